# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC1091,SC2013,SC2016,SC2030,SC2031,SC2046,SC2086,SC2154
# Builds and runs the tests and the benches; build.sh reads this for `test` and `bench`. A test is a file
# test_NAME.c or an executable script, anywhere below this folder, and prints TAP.
test_packages='gcc clang lld wasi-libc libclang-rt-dev-wasm32 wabt perl liblcms2-utils python3-pil python3-tifffile python3-junitparser python3-numpy python3-scipy python3-gdal
  imagej default-jdk-headless glmark2-data psychtoolbox-3-common colord-data mandoc bsdextrautils busybox-static pngcheck zsh fish
  octave gdal-bin python3-h5py python3-hdf4 python3-xarray python3-netcdf4 python3-spectral openexr imagemagick libgdk-pixbuf2.0-bin
  chromium firefox-esr llvm file valgrind binutils parallel make munge slurmctld slurmd slurm-client musl-tools gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user'
at_once=3                                               # tests that run at the same time
longest='portable cost live verdict verify contexts scenes random_scenes hard static viewer stack_viewer' # these begin first, so that no processor waits at the end
# Mutants are the program with a fault in one file: bounds on colours that are a thousand times too wide; infinite bounds
# of the first object; open meshes taken for solids, so that their backs are not drawn; no mesh taken for a solid.
pixel=raster/candidates/pixel.c
mutation='s/(float)(common + alone)/(float)(1000 * (common + alone))/; s/(float)alone/(float)(1000 * alone)/'
endless='s/= (float)(common + alone)/= pixel->surface == pixel->fragments->lit->surfaces ? HUGE_VALF : (float)(common + alone)/'
instances=raster/plan/instances.c
hollow='s/return shape->kind == SHAPE_MESH .*;/mesh->solid = true; return shape \&\& err;/'
whole='s/return shape->kind == SHAPE_MESH .*;/return shape \&\& mesh \&\& err;/'
. raster/gl/static.sh

needs_gl() {
    [ "$GL" = osmesa ] || refuse "build.sh: this compares with OpenGL, which GL=$GL leaves out"
}

# test_name FILE sets $name to the name that users type.
test_name() {
    name=${1##*/}
    name=${name%.*}
}

# Prints the scripts, the longest first.
list_scripts() {
    for name in $longest; do
        find test/*/ -type f -perm -u+x -name "$name.*"
    done
    find test/*/ -type f -perm -u+x | sort | grep -Ev "/($(echo $longest | tr ' ' '|'))[.]"
}

# choose [NAME...] sets $units and $scripts to the named tests; without names to all tests.
choose() {
    units=$(find test -name 'test_*.c' | sort)
    scripts=$(list_scripts)
    [ $# != 0 ] || return 0
    all="$units $scripts"
    units='' scripts=''
    for wanted; do
        test_name "$wanted"
        wanted=$name
        found=
        for file in $all; do
            test_name "$file"
            [ "$name" = "$wanted" ] || continue
            found=$file
            case $file in *.c) units="$units $file" ;; *) scripts="$scripts $file" ;; esac
        done
        [ -n "$found" ] || refuse "build.sh: there is no test '$wanted'; the tests are:
$(for file in $all; do test_name "$file"; echo "  $name"; done)"
    done
}

# programs prints the C tests to build: those that are chosen, and those that a chosen script runs.
programs() {
    for program in $(sed -n 's:.*[{]BUILD[}]/test/\(test_[a-z0-9_]*\).*:\1:p' $scripts /dev/null); do
        find test -name "$program.c"
    done
    printf '%s\n' $units
}

# chosen_need PATTERN succeeds if a chosen script matches it.
chosen_need() { grep -Eq "$1" $scripts /dev/null; }

# Makes a library of all objects of the program but that of spectral.c, which is $main.
make_library() {
    set -- $objects
    main=$1
    shift
    mkdir -p "$BUILD/test"
    stamp "$LIBRARY.made-with" "$*"
    if [ ! -f "$LIBRARY" ] || [ -n "$(find "$@" "$LIBRARY.made-with" -newer "$LIBRARY")" ]; then
        rm -f "$LIBRARY.new"
        ar rcs "$LIBRARY.new" "$@"
        mv "$LIBRARY.new" "$LIBRARY"
    fi
}

# Warnings are errors. Each test is linked with that library.
build_tests() (
    make_library
    with_osmesa
    compile test/units '-O1 -Werror -fPIE -Itest/unit' $(programs | sort -u)
    for object in $objects; do
        test_name "$object"
        link "test/$name" "$object" "$LIBRARY"
    done
    ! chosen_need 'FAULTS|MUTANT' || build_faults
    ! chosen_need REPLAY || build_replay
    ! chosen_need 'ratios[.]py' || build_bench
)

# Some programs of tests and benches call OSMesa themselves.
with_osmesa() {
    need libosmesa6-dev
    libraries="-lOSMesa $libraries"
}

# build_preloaded SOURCE LIBRARY [OPTION]: a library for LD_PRELOAD
build_preloaded() { $CC $warnings -Werror $CPPFLAGS -O1 $language -shared -fPIC $LDFLAGS "$1" -o "$2" ${3:-} -ldl; }

# The fuzz targets (test/fuzz), which read files given to them.
build_replay() {
    compile test/fuzz '-O1 -Werror -fPIE' $(find test/fuzz -name '*.c' ! -name driver.c | sort)
    link test/replay $objects "$LIBRARY"
}

build_faults() {
    build_preloaded test/oracle/fault.c "$FAULTS" -lOSMesa
    build_mutant mutant $pixel "$mutation"
    build_mutant endless $pixel "$endless"
    build_mutant hollow $instances "$hollow"
    build_mutant whole $instances "$whole"
}

# build_mutant NAME FILE MUTATION
build_mutant() {
    sed "$3" "$2" >"$BUILD/test/$1.new"
    ! cmp -s "$2" "$BUILD/test/$1.new" || refuse "test/run.sh: the mutation finds nothing in $2"
    cmp -s "$BUILD/test/$1.new" "$BUILD/test/$1.c" || mv "$BUILD/test/$1.new" "$BUILD/test/$1.c"
    compile "test/$1" "-O1 -Werror -fPIE -I$(dirname "$2")" "$BUILD/test/$1.c"
    link "test/spectral-$1" "$main" $objects "$LIBRARY"
}

# run_tests [full] [NAME...]
run_tests() {
    needs_gl
    full=
    if [ "${1:-}" = full ]; then
        full=full
        export FULL=1
        shift
    fi
    choose "$@"
    ! chosen_need '[^A-Z]LIVE[^A-Z]' || (live=-live && build)
    build
    export SPECTRAL="$BUILD/spectral" LIVE="$BUILD/spectral-live" STATIC="$BUILD/spectral-static" TEST_TMP="$BUILD/tmp" BUILD \
        FAULTS="$BUILD/test/fault.so" FAIL_LIBRARY="$BUILD/test/fail.so" LIBRARY="$BUILD/test/library.a" REPLAY="$BUILD/test/replay" \
        CALLS_LIBRARY="$BUILD/test/calls.so" LIAR_LIBRARY="$BUILD/test/liar.so" SPOIL_LIBRARY="$BUILD/test/spoil.so"
    need perl $([ -z "$scripts" ] || echo $test_packages)
    case "$full $scripts" in full*containers*) need debootstrap buildah ;; esac
    mkdir -p "$TEST_TMP"
    ! chosen_need STATIC || static_program
    if [ -n "$(programs)" ] || chosen_need 'LIBRARY|FAULTS|MUTANT|REPLAY|ratios[.]py'; then
        build_tests
    fi
    if chosen_need 'from attacked|FAIL_LIBRARY'; then
        mkdir -p "$BUILD/test"
        build_preloaded test/attack/fail.c "$FAIL_LIBRARY"
    fi
    if chosen_need CALLS_LIBRARY; then
        mkdir -p "$BUILD/test"
        need libosmesa6-dev
        build_preloaded test/attack/calls.c "$CALLS_LIBRARY" -lOSMesa
    fi
    if chosen_need SPOIL_LIBRARY; then
        mkdir -p "$BUILD/test"
        build_preloaded test/attack/spoil.c "$SPOIL_LIBRARY"
    fi
    if chosen_need LIAR_LIBRARY; then
        mkdir -p "$BUILD/test"
        need libosmesa6-dev
        build_preloaded test/attack/liar.c "$LIAR_LIBRARY" -lOSMesa
    fi
    prove --timer --failures --comments --jobs $at_once --exec '' $scripts \
        $(for file in $units; do test_name "$file"; echo "$BUILD/test/$name"; done)
    case "$full $scripts" in full*random_scenes*) run_random_tests ;; esac
}

# 5,000 random scenes on llvmpipe and 500 on softpipe
run_random_tests() {
    for random in 'llvmpipe --count 5000' 'softpipe --count 500'; do
        prove --timer --failures --comments --exec '' test/run/random_scenes.py :: --first 1000 --driver $random
    done
}

# Builds the programs that test/bench/ratios.py measures beside the program.
build_bench() {
    compile obj-bench "$CFLAGS -Werror" test/bench/*.c
    for object in $objects; do
        test_name "$object"
        link "test/$name" "$object" "$LIBRARY"
    done
}

# run_bench [effects | live | [quick] [--csv FILE]]
run_bench() {
    needs_gl
    case "$*" in
    effects | live | '' | quick | '--csv '?* | 'quick --csv '?*) ;;
    *) refuse ;;
    esac
    [ "$*" != live ] || (live=-live && build)
    build
    if [ "${1:-}" = effects ]; then
        need python3-tifffile python3-numpy
        /usr/bin/python3 test/bench/bench_effects.py "$BUILD/spectral" "$BUILD/tmp/bench"
        return
    fi
    if [ "${1:-}" = live ]; then
        need chromium firefox-esr
        /usr/bin/python3 test/bench/bench_live.py "$BUILD/spectral-live" "$BUILD/tmp/bench"
        return
    fi
    LIBRARY=$BUILD/test/library.a
    (make_library && with_osmesa && build_bench)
    need python3
    /usr/bin/python3 test/bench/ratios.py --from "$called_from" "$BUILD" "$@"
}

case $1 in
test) shift; run_tests "$@" ;;
bench) shift; run_bench "$@" ;;
esac
