#!/bin/sh
# SPDX-License-Identifier: MIT
# level: full; packages: clang
# The reference's stacks have the same bytes for every compiler, C library and processor, with and without OpenGL,
# with any number of threads, checked or not. test/cases/golden.sha256 has the digests of all built-in scenes: small
# ones in counts and in radiances, and scenes at their own size. FULL=1 also renders them with gcc's other
# optimisations, with one thread each, and at their own size by all programs; it checks those in radiances, too, and
# renders metals, room and those in counts on aarch64.
# $STATIC is the static program with OpenGL.
#     test/run/portable.sh renew      writes test/cases/golden.sha256 anew, by $SPECTRAL
# Lists are split into words on purpose.
# shellcheck disable=SC2086
. test/run/tap.sh
STATIC=${STATIC:-build/spectral-static}
builds=${BUILD:-build}/portable
golden=test/cases/golden.sha256
small=120x80
# compiler, option, OpenGL; -freciprocal-math would change pictures, so the program turns it off
matrix='clang -O2 osmesa  musl-gcc -O2 none  aarch64-linux-gnu-gcc -O2 none'
[ "${FULL:-0}" = 0 ] || matrix="$matrix  gcc -O0 none  gcc -O2 none  gcc -O3 none  gcc -freciprocal-math none"
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
    echo "metals-phong.tif metals --size=$1 --depth=8 --shading=phong --tessellation=1.5"
}

# hashes SIZE THREADS PROGRAM... prints the lines of sha256sum.
hashes() {
    size=$1
    threads=$2
    shift 2
    stacks "$size" | while read -r stack scene options; do
        "$@" render "$scene" $options --renderer raster $check --threads "$threads" --quiet -o "$tmp/$stack" &&
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

if [ "${1:-}" = renew ]; then
    { hashes $small 1 "$SPECTRAL" && hashes '' 1 "$SPECTRAL"; } >"$tmp/golden"
    exec mv "$tmp/golden" "$golden"
fi

for size in $small ''; do
    grep -q " $(golden_hashes "$size" | sha256sum | cut -c 1-16) " data/doc/reproducibility.md
    ok $? "reproducibility.md prints the digest of all stacks, ${size:-own size}"
done
[ -n "$scenes" ] && [ "$(wc -l <"$golden")" = "$({ stacks $small; stacks ''; } | wc -l)" ]
ok $? "$golden has each built-in scene small and at its own size"

# Warnings are errors, with all compilers.
# shellcheck disable=SC2016
echo "$matrix" | tmp=$tmp builds=$builds xargs -P 2 -n 3 sh -c '
    compiler=$0 option=$1
    CC=$compiler CFLAGS="$option -Werror" GL=$2 BUILD=$builds/$compiler$option ./build.sh \
        >"$tmp/$compiler$option.log" 2>&1 || {
        rm -f "$builds/$compiler$option/spectral"
        sed "s/^/# $compiler $option: /" "$tmp/$compiler$option.log"
    }'

as_golden 'dynamic, OSMesa' $small 1 "$SPECTRAL"
as_golden 'dynamic, OSMesa' $small 2 "$SPECTRAL"
as_golden 'dynamic, OSMesa' '' 2 "$SPECTRAL"
check=
[ "${FULL:-0}" != 0 ] || left_out='-32f\|^metals-phong\|^fluorescence-[^0-9]'
as_golden 'dynamic, OSMesa, checked' $small 2 "$SPECTRAL"
check=--no-check
left_out='^$'
if [ -x "$STATIC" ]; then
    as_golden_by 'static, OSMesa' "$STATIC"
else
    skip "there is no $STATIC; ./build.sh static makes it"
fi
set -- $matrix
while [ $# -gt 0 ]; do
    case $1 in
    aarch64-*) # an emulator takes most of the time for the many triangles of these, and for the same picture twice
        [ "${FULL:-0}" != 0 ] || left_out="^metals-\|^room-\|-$small.tif"
        as_golden_by "$1 $2, OpenGL $3" qemu-aarch64 "$builds/$1$2/spectral"
        left_out='^$'
        ;;
    *) as_golden_by "$1 $2, OpenGL $3" "$builds/$1$2/spectral" ;;
    esac
    shift 3
done

plain=$builds/musl-gcc-O2/spectral
small="--size 30x20 --wavelengths 400:700:50"
{
    exits 0 "a program without OpenGL prints its version" "$plain" --version
    prints '^without OpenGL$' "its version says so"
    exits 2 "a program without OpenGL refuses OpenGL's pixels" "$plain" render patches $small -o "$tmp/none.tif"
    says 'built without OpenGL; add --renderer raster' "the message asks for --renderer raster"
    absent "$tmp/none.tif" "OpenGL's pixels"
    exits 2 "a program without OpenGL refuses a strict check" "$plain" render patches $small --renderer raster --strict
    exits 0 "a program without OpenGL makes the reference's pixels" "$plain" render patches $small --renderer raster -o "$tmp/plain.tif"
    prints '^verdict +not checked: .* without OpenGL' "the table says that they are unchecked"
    exits 0 "a program with OpenGL makes the same stack again" \
        "$SPECTRAL" render --again "$tmp/plain.tif" -o "$tmp/again.tif"
    exits 0 "a program with OpenGL makes a checked stack" \
        "$SPECTRAL" render patches $small --renderer raster -o "$tmp/checked.tif"
    exits 0 "the program without OpenGL makes the checked stack again" "$plain" render --again "$tmp/checked.tif" -o "$tmp/again.tif"
    exits 2 "arithmetic that changes pictures is refused" env CFLAGS=-Ofast BUILD="$tmp/fast" ./build.sh
    says '-Ofast changes pictures' "the message names the option"
    exits 2 "an unknown OpenGL is refused" env GL=vulkan BUILD="$tmp/vulkan" ./build.sh
    says 'GL is osmesa or none' "the message lists the choices of GL"
}
done_testing
