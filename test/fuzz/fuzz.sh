# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC1091,SC2012,SC2034,SC2046,SC2048,SC2086,SC2154,SC2164
# Fuzzing: libFuzzer of clang changes inputs at random, keeps those that reach new code, and stops at the
# first that breaks a rule of the sanitizers or of the target; build.sh reads this for `fuzz`. The code and
# libtiff, from Debian's source, are built with AddressSanitizer and UndefinedBehaviorSanitizer. A target is
# a row in the table of fuzz.c.
fuzz_packages='clang libclang-rt-dev dpkg-dev make autoconf automake libtool libdeflate-dev libjbig-dev libjpeg-dev
  liblerc-dev liblzma-dev libwebp-dev libzstd-dev zlib1g-dev'
# libtiff goes on after undefined behaviour, which is its own matter; it stops at a wrong access. Our
# code stops at both, and at numbers that a cast changes without a word.
fuzz_sanitizers='-g -O1 -fno-omit-frame-pointer -fsanitize=fuzzer-no-link,address,undefined'
own_sanitizers="$fuzz_sanitizers -fsanitize=float-cast-overflow,implicit-conversion -fno-sanitize-recover=all"
# An allocation above 256 MB fails, as on a machine that has no more: large pictures are legitimate, but
# would take the time of thousands of inputs. No input may take 25 s; the slowest good one takes less than 1 s,
# but the machine may be busy.
fuzz_limits='-timeout=25 -rss_limit_mb=2560 -detect_leaks=1'
export ASAN_OPTIONS=allocator_may_return_null=1:max_allocation_size_mb=256:detect_stack_use_after_return=0
fuzz_kept=test/fuzz/corpus # kept inputs: TARGET/kept.tar.gz, and beside it those that once failed

make_tiff_fuzz() { configure_tiff CC=clang CFLAGS="$fuzz_sanitizers"; }

# Makes $BUILD/fuzz/fuzz.
build_fuzzer() {
    need $fuzz_packages
    CC=clang GL=none
    prepare
    version=$(debian_version libtiff-dev)
    key="$(cat data/images/libtiff.sh) $fuzz_sanitizers $($CC -v 2>&1)"
    cached tiff_fuzz tiff "$version" "$key"
    libraries="-fsanitize=fuzzer -L$library -ltiff -ldeflate -ljbig -ljpeg -lLerc -llzma -lwebp -lzstd -lz -lm"
    CFLAGS=$own_sanitizers
    find_sources
    set -- $sources
    shift # spectral.c, which test/fuzz/line.c includes
    compile fuzz/objects "-Werror -isystem $library/include $own_sanitizers" "$@" "$BUILD/builtin.c" \
        $(find test/fuzz -name '*.c' ! -name replay.c | sort)
    link fuzz/fuzz $objects
}

# Prints the names of the targets.
fuzz_targets() { grep -oE '[{]"[a-z]+", .*fuzz_' test/fuzz/fuzz.c | cut -d '"' -f 2; }

# fuzz_seeds TARGET prints the files that a target begins with, beside those that are kept.
fuzz_seeds() {
    case $1 in
    scene) find data/builtin/scenes data/samples test/cases "$made" -name '*.scene' ;;
    list) find data/builtin/materials test/cases/bad -name '*.list' ;;
    material) find data/builtin/materials test/cases/bad/materials -name '*.txt' ;;
    table) find data/builtin/tables data/builtin/daylight data/samples test/cases/bad/tables -name '*.csv' -o -name '*.txt' ;;
    mesh) find data/builtin/models data/samples test/cases/bad/meshes -name '*.obj' ;;
    mtl) find test/cases/bad/maps "$made" -name '*.mtl' ;;
    map) find data/builtin/models test/cases/bad/maps "$made" -name '*.map' ;;
    matrix) find test/cases/bad/matrices "$made" -name '*.csv' ;;
    display) find data/builtin/displays -name '*.csv' ;;
    texture) find data/builtin/textures test/cases/bad/textures "$made" -name '*.tif' -o -name '*.sgi' ;;
    png) find "$made" -name 'png-*' ;;
    set) find "$made" -name '*.ti3' ;;
    stack) find "$made" -name 'stack-*' ;;
    record) find "$made" -name 'record-*' ;;
    line) find "$made" -name 'line-*' ;;
    esac
}

# fuzz_words TARGET prints the words of its sources as a dictionary: each string of ASCII without blanks, '%' and '\'.
fuzz_words() {
    case $1 in
    scene) words='data/scene data/mesh/shape.c data/spectra' ;;
    list | map) words='data/scene/material*.c' ;;
    material | mtl) words='data/scene/material.c data/scene/mtl.c data/spectra/spectrum.c' ;;
    table | set | matrix) words='data/spectra' ;;
    display) words=raster/beside/colour ;;
    mesh) words=data/mesh/obj.c ;;
    texture | png) words=data/images ;;
    record) words='data/stack/record.c data/stack/tags.c data/sampling/method.c' ;;
    stack) words='data/images data/stack data/sampling/method.c' ;;
    line) words='spectral.c data/sampling data/spectra data/scene raster/render raster/beside' ;;
    esac
    find $words -name '*.c' -exec grep -hv '^#' {} + | grep -oE '"[!#$&-Z^-~]{1,32}"' | sort -u
}

# Writes stacks of this program, and command lines, below the folder $made.
make_seeds() {
    made=$BUILD/fuzz/made
    [ ! -d "$made" ] || return 0
    mkdir -p "$made.new"
    (
        build
        for options in '--depth 8' '--depth 32f' '--light 1=a' '--sampling gauss:3' '--sampling box:3' '--sampling basis:2' \
            '--sampling rgb' '--sampling adaptive:0.1' '--ambient d65*0.2'; do
            "$BUILD/spectral" render patches --size 5x4 --wavelengths 400:700:100 --renderer raster --no-check -q $options \
                -o "$made.new/stack-$(echo "$options" | tr -c 'a-z0-9\n' -).tif"
        done
        "$BUILD/spectral" render patches --size 5x4 --wavelengths 500 --renderer raster --no-check -q --part 1/1 -o "$made.new/stack-part"
    )
    need python3-tifffile
    /usr/bin/python3 test/fuzz/fuzz_seeds.py "$made.new"
    # the examples of the program's commands, and of the pages
    grep -rhE '[.]example = ' data raster | cut -d '"' -f 2 >"$made.new/lines"
    grep -hoE '^spectral [^|>]*' README.md data/doc/*.md | cut -d ' ' -f 2- | sort -u >>"$made.new/lines"
    number=0
    while read -r line; do
        number=$((number + 1))
        printf '%s' "$line" | tr -s ' ' '\n' >"$made.new/line-$number"
    done <"$made.new/lines"
    mv "$made.new" "$made"
}

# A folder in memory for the files that targets write, with those that inputs name.
open_folder() {
    FUZZ_FOLDER=$(mktemp -d /dev/shm/spectral-fuzz.XXXXXX 2>/dev/null || mktemp -d)
    trap 'rm -rf "$FUZZ_FOLDER"' EXIT
    trap 'exit 3' HUP INT TERM
    cp -R test/cases/bad/*/ data/samples/*.* data/builtin/textures/dots.tif "$FUZZ_FOLDER"
    export FUZZ_FOLDER
}

# run_fuzzer TARGET OPTION... FOLDER...
run_fuzzer() {
    FUZZ_TARGET=$1
    export FUZZ_TARGET
    shift
    case $FUZZ_TARGET in texture | stack) most=16384 ;; *) most=4096 ;; esac
    "$BUILD/fuzz/fuzz" $fuzz_limits -max_len=$most -print_final_stats=1 -artifact_prefix="$BUILD/fuzz/found/$FUZZ_TARGET-" \
        "$@" </dev/null
}

# Ends the fuzzing of a target that failed: makes its input smaller, where it can, and names it.
end_failed() {
    found=$(ls -t "$BUILD/fuzz/found/$1"-* | head -n 1)
    echo "making $found smaller"
    run_fuzzer $1 -minimize_crash=1 -max_total_time=60 -exact_artifact_path="$found.small" "$found" >"$BUILD/fuzz/small.log" 2>&1 || :
    [ -f "$found.small" ] || cp "$found" "$found.small"
    echo "the input that fails is $found.small; to see it fail again:
FUZZ_FOLDER=$BUILD FUZZ_TARGET=$1 $BUILD/fuzz/fuzz $found.small"
    exit 1
}

# unpack TARGET puts its kept inputs into the empty folder $BUILD/fuzz/kept.
unpack() {
    rm -rf "$BUILD/fuzz/kept"
    mkdir -p "$BUILD/fuzz/found" "$BUILD/fuzz/kept"
    find $fuzz_kept/$1 -type f ! -name kept.tar.gz -exec cp {} "$BUILD/fuzz/kept" \; 2>/dev/null || : # none yet
    [ ! -f $fuzz_kept/$1/kept.tar.gz ] || tar -C "$BUILD/fuzz/kept" -xzf $fuzz_kept/$1/kept.tar.gz
}

# prepare_target TARGET fills $BUILD/fuzz/TARGET, which keeps what earlier runs found, and writes its words.
prepare_target() {
    mkdir -p "$BUILD/fuzz/$1"
    fuzz_seeds $1 | while read -r file; do
        cp "$file" "$BUILD/fuzz/$1/$(echo "$file" | tr / _)"
    done
    cp -R "$BUILD/fuzz/kept/." "$BUILD/fuzz/$1"
    fuzz_words $1 >"$BUILD/fuzz/$1.dict"
}

# Replaces the kept inputs of a target by a small set that reaches the same code.
keep() {
    rm -rf "$BUILD/fuzz/small"
    mkdir -p "$BUILD/fuzz/small" "$fuzz_kept/$1"
    run_fuzzer $1 -set_cover_merge=1 "$BUILD/fuzz/small" "$BUILD/fuzz/$1"
    tar -C "$BUILD/fuzz/small" -c --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner --mode=u=rw,go=r . |
        gzip -9n >$fuzz_kept/$1/kept.tar.gz
}

# fuzz [SECONDS|keep] [TARGET...]: 0 seconds only read the kept inputs again; keep: replaces them
fuzz() {
    seconds=60
    case ${1:-} in
    keep) seconds=keep; shift ;;
    [0-9]*) seconds=$1; shift ;;
    esac
    known=$(fuzz_targets)
    for target; do
        echo "$known" | grep -qx -- "$target" || refuse "build.sh: there is no target '$target'; the targets are:
$known"
    done
    [ "$seconds" = 0 ] || make_seeds
    build_fuzzer
    open_folder
    for target in ${*:-$(fuzz_targets)}; do
        unpack $target
        case $seconds in
        0) run_fuzzer $target -runs=0 "$BUILD/fuzz/kept" ;;
        keep) prepare_target $target; keep $target ;;
        *)
            prepare_target $target
            echo "fuzzing $target for $seconds seconds"
            run_fuzzer $target -max_total_time=$seconds -dict="$BUILD/fuzz/$target.dict" "$BUILD/fuzz/$target" ||
                end_failed $target
            ;;
        esac
    done
}
