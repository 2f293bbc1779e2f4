# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC1091,SC2034,SC2046,SC2086,SC2154
# The unit tests and all commands on all built-in scenes under the sanitizers of clang, and the code of
# the static program under valgrind; build.sh reads this for `sanitize`. The first finding ends it: a wrong access, a
# leak, undefined behaviour, a number that a cast changes, a value that depends on memory never written.
sanitize_packages='clang libclang-rt-dev valgrind'
sanitizers='-g -O2 -fno-omit-frame-pointer -fsanitize=address,undefined,float-cast-overflow,implicit-conversion
  -fno-sanitize-recover=all'
sanitize_size='--size 48x32 --wavelengths 400:700:50'

# clean COMMAND... runs the program, which must succeed without a finding.
clean() {
    "$@" >"$out/printed" 2>&1 </dev/null && ! grep -q 'runtime error\|ERROR: ' "$out/printed" && return
    echo "fails: $*" >&2
    tail -n 60 "$out/printed" >&2
    exit 1
}

# Every command on a scene, each with most of its options.
sanitize_scene() {
    echo "sanitizing the commands on $1"
    checked="--unchecked 1 --keep --check-map $out/map.tif"
    for changes in "$checked" "$checked --shading flat --renderer softpipe --depth 32f --buffer 16" \
        '--shading phong --renderer raster --depth 8 --tessellation 0.5 --sampling gauss:3'; do
        clean $program render $1 $sanitize_size $changes -v --json "$out/report.json" -o "$out/stack.tif"
        clean $program info "$out/stack.tif" --json "$out/info.json"
        clean $program info "$out/stack.tif"
        clean $program envi "$out/stack.tif" -o "$out/header.hdr"
        clean $program render --again "$out/stack.tif" -q -o "$out/again.tif"
        clean $program develop "$out/stack.tif" --exposure auto --adaptation cat16 --white a -o "$out/picture.png"
        clean $program compare "$out/stack.tif" "$out/again.tif" --map "$out/map.png" --json "$out/compare.json"
    done
    clean $program plan $1 --sampling gauss:3
    clean $program plan $1 --json "$out/plan.json"
    for sampling in box:3 riemann:50 adaptive:0.01 basis:3 rgb xyz; do
        case $1-$sampling in room-basis:3 | room-rgb | room-xyz) continue ;; esac # room has a spectral texture
        clean $program render $1 --size 24x16 --renderer raster --sampling $sampling -q -o "$out/sampled.tif"
        clean $program develop "$out/sampled.tif" --lab -o "$out/lab.tif"
    done
    clean $program render $1 $sanitize_size -q --light 1=a*2 --ambient d65*0.1 -o "$out/other.tif"
    clean $program render $1 $sanitize_size -q --renderer raster -o "$out/reference.tif"
    clean $program compare "$out/reference.tif" "$out/other.tif" --tolerance 100000%
    clean $program develop "$out/other.tif" --sampling gauss:5 --bits 16 --display monitor -o "$out/picture.tif"
    for form in '' --csv --svg "--json $out/probe.json"; do
        clean $program probe "$out/other.tif" 20 10 5 4 $form
        clean $program probe $1 $sanitize_size 20 10 $form
    done
    clean $program view $1 $sanitize_size -q -o "$out/page.html"
    clean $program view $1 $sanitize_size -q -o "$out/page.png"
}

sanitize_commands() {
    for scene in $(find data/builtin/scenes -name '*.scene' | sort); do
        scene=${scene##*/}
        sanitize_scene "${scene%.scene}"
    done
    echo "sanitizing the other commands"
    clean $program --help
    clean $program --version
    for kind in '' scenes materials illuminants detectors shapes models lists textures samplings; do
        clean $program list $kind
    done
    clean $program show room -o "$out/room.scene"
    large='patches --size 3000x1300 --wavelengths 500,600'
    for part in 1 2; do
        clean $program render $large --part $part/2 -o "$out/part$part.tif"
    done
    clean $program join -o "$out/joined.tif" "$out/part1.tif" "$out/part2.tif"
    # cost draws by EGL, too, whose drivers leak 112 bytes. They are closed then: sanitize.leaks cannot name them.
    ASAN_OPTIONS=$ASAN_OPTIONS:detect_leaks=0 clean $program cost patches --size 24x16 --csv "$out/cost.csv" --svg "$out/cost.svg" -q
}

# Makes the static program with one change: the C library is shared, since valgrind can only watch the
# allocations of a shared one. All else is the same objects and the same libraries, OSMesa and libtiff too.
build_for_valgrind() {
    . raster/gl/static.sh
    prepare
    find_static_libraries
    parts=$(versions $static_packages)
    compile obj-static "$CFLAGS" $sources "$BUILD/builtin.c"
    libraries="-Wl,-Bstatic $(echo "$libraries" | sed 's/-static-pie\|-static -no-pie//; s/-lm$/-Wl,-Bdynamic -lm/')"
    link sanitize/valgrind $objects
}

# Valgrind sees values that were never written, which the sanitizers do not.
sanitize_static() (
    build_for_valgrind
    for scene in patches room fluorescence; do
        echo "running render and develop of $scene under valgrind"
        for words in "render $scene --size 16x12 --wavelengths 400:700:150 -q -o $out/static.tif" \
            "develop $out/static.tif -q -o $out/static.png"; do
            clean valgrind -q --error-exitcode=99 --leak-check=full --show-leak-kinds=definite \
                --errors-for-leak-kinds=definite --suppressions=test/sanitize.supp "$BUILD/sanitize/valgrind" $words
        done
    done
)

sanitize() {
    need $sanitize_packages
    out=$BUILD/sanitize/out
    program=$BUILD/sanitize/spectral
    mkdir -p "$out"
    # Tests ask for more memory than there is, and let the program crash: its own handler then ends it. The
    # search for leaks would crash: it reads variables of threads in a library that is closed.
    export ASAN_OPTIONS=detect_stack_use_after_return=1:allocator_may_return_null=1:handle_segv=0:use_sigaltstack=0:intercept_tls_get_addr=0 \
        LSAN_OPTIONS=suppressions=$PWD/test/sanitize.leaks:print_suppressions=0 UBSAN_OPTIONS=print_stacktrace=1
    BUILD=$BUILD/sanitize CC=clang CFLAGS=$sanitizers CPPFLAGS=$sanitizers ./build.sh test \
        $(find test -name 'test_*.c' | sed 's:.*/::; s:[.]c$::' | sort)
    sanitize_commands
    sanitize_static
}
