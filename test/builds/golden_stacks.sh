# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2034,SC2086,SC2154
# For golden.sh, compilers.sh and portable.sh, after tap.sh: the reference's stacks have the same bytes for every compiler, C
# library and processor, with and without OpenGL, with any number of threads, checked or not. test/cases/golden.sha256 has
# the digests of all built-in scenes: small ones in counts and in radiances, and scenes at their own size. With FULL=1 each
# program of another compiler draws them with one thread, too, and at their own size.
builds=${BUILD:-build}/portable
golden=test/cases/golden.sha256
small=120x80
scenes=$("$SPECTRAL" list scenes | sed -n 's/^  //p')
check=--no-check
left_out='^$' # the stacks that are not drawn, as a pattern

# stacks SIZE: prints name, scene and options of each stack; small ones in counts and in radiances, and some
# with other samplings, depths and shadings
stacks() {
    all_stacks "$1" | grep -v -e "$left_out"
}

all_stacks() {
    for scene in $scenes; do
        echo "$scene${1:+-$1}.tif $scene ${1:+--size=$1}"
        [ -z "$1" ] || echo "$scene-$1-32f.tif $scene --size=$1 --depth=32f"
    done
    [ -n "$1" ] || return 0
    for sampling in box:7 gauss:9 gauss:64,open gauss:8,lms adaptive:0.003 basis:5 rgb xyz; do
        echo "fluorescence-$sampling.tif fluorescence --size=$1 --depth=32f --light=1=fluorescent --sampling=$sampling"
    done
    for scene in room spheres textures; do # bounds of any driver, without OpenGL
        echo "$scene-bounds.tif $scene --size=$1 --bounds-for=any"
    done
    echo "metals-phong.tif metals --size=$1 --depth=8 --shading=phong --tessellation=1.5"
}

# hashes SIZE THREADS PROGRAM... prints the lines of sha256sum.
hashes() {
    size=$1
    threads=$2
    shift 2
    stacks "$size" | while read -r stack scene options; do
        case $stack in *-bounds.tif) options="$options --bounds $tmp/$stack -o /dev/null" ;; *) options="$options -o $tmp/$stack" ;; esac
        "$@" render "$scene" $options --renderer raster $check --threads "$threads" --quiet &&
            (cd "$tmp" && sha256sum "$stack")
        rm -f "$tmp/$stack"
    done
}

golden_hashes() { # SIZE
    stacks "$1" | while read -r stack _; do
        grep -F "  $stack" "$golden"
    done
}

# as_golden NAME SIZE THREADS PROGRAM...
as_golden() {
    name="$1, ${2:-own size}, $3 thread$([ "$3" = 1 ] || echo s)"
    size=$2
    threads=$3
    shift 3
    for program; do :; done # the last word
    begun=$(date +%s)
    hashes "$size" "$threads" "$@" >"$tmp/hashes" 2>"$tmp/err"
    printf '# %-58s %s %8s bytes %4s s\n' "$name" "$(sha256sum <"$tmp/hashes" | cut -c 1-16)" \
        "$(wc -c <"$program")" $(($(date +%s) - begun))
    [ -s "$tmp/hashes" ] && golden_hashes "$size" | diff - "$tmp/hashes" >"$tmp/out"
    ok $? "$name: the bytes of $golden"
}

# as_golden_by NAME PROGRAM...: with two threads, and with FULL=1 with one, and at the scenes' own sizes
as_golden_by() {
    title=$1
    shift
    as_golden "$title" $small 2 "$@"
    [ "${FULL:-0}" != 0 ] || return 0
    as_golden "$title" $small 1 "$@"
    as_golden "$title" '' 2 "$@"
}

# built_programs COMPILER OPTION OPENGL...: builds each, with warnings as errors, and compares its stacks
# shellcheck disable=SC2016
built_programs() {
    echo "$@" | tmp=$tmp builds=$builds xargs -P 2 -n 3 sh -c '
        compiler=$0 option=$1
        CC=$compiler CFLAGS="$option -Werror" GL=$2 BUILD=$builds/$compiler$option ./build.sh \
            >"$tmp/$compiler$option.log" 2>&1 || {
            rm -f "$builds/$compiler$option/spectral"
            sed "s/^/# $compiler $option: /" "$tmp/$compiler$option.log"
        }'
    while [ $# -gt 0 ]; do
        case $1 in
        *-linux-gnu*) # an emulator takes most of the time for the many triangles of these, and for the same picture twice
            [ "${FULL:-0}" != 0 ] || left_out="^metals-\|^room-\|-$small.tif"
            as_golden_by "$1 $2, OpenGL $3" "qemu-${1%%-*}" "$builds/$1$2/spectral"
            left_out='^$'
            ;;
        *) as_golden_by "$1 $2, OpenGL $3" "$builds/$1$2/spectral" ;;
        esac
        shift 3
    done
}
