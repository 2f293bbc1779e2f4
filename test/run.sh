# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC1091,SC2013,SC2016,SC2030,SC2031,SC2046,SC2086,SC2154
# Builds and runs the tests and the benches; build.sh reads this for `test` and `bench`. A test is a file test_NAME.c or an
# executable script, anywhere below this folder, and prints TAP. One of its first lines says when it runs and what it needs:
#     level: first|full|release|first release|full release|none; packages: those of Debian; makes: words of make_for below
# A C test without this line belongs to the first level and needs no package; each test.py needs python3.
longest='hard test_reference test_mesa random_scenes verdict verify contexts scenes cost' # these begin first, so that no processor waits at the end
# Mutants are the program with a fault in one file: bounds on colours that are a thousand times too wide; infinite bounds
# of the first object; open meshes taken for solids, so that their backs are not drawn; no mesh taken for a solid; shadow
# volumes of lights that are moved by $MOVED; another rule for the level of detail, by $CORNER, $NORM or $EXACT.
pixel=raster/candidates/pixel.c
mutation='s/(float)(common + alone)/(float)(1000 * (common + alone))/; s/(float)alone/(float)(1000 * alone)/'
endless='s/= (float)(common + alone)/= pixel->surface == pixel->fragments->tile->lit->surfaces ? HUGE_VALF : (float)(common + alone)/'
instances=raster/plan/instances.c
hollow='s/added[.]solid = .*;/added.solid = true;/'
whole='s/added[.]solid = .*;/added.solid = false;/'
moved='s/factor \* vector_dot(row_of(of, 0), v)/& + atof(getenv("MOVED"))/'
detail='s/#include <math.h>/&\n#include <stdlib.h>/; s/rule->lower/(rule->lower != (getenv("CORNER") != NULL))/g
    s/rule->largest/(rule->largest != (getenv("NORM") != NULL))/; s/rule->logarithm == LOGARITHM_LINEAR/& \&\& !getenv("EXACT")/'
. raster/gl/static.sh

needs_gl() {
    [ "$GL" = osmesa ] || refuse "build.sh: this compares with OpenGL, which GL=$GL leaves out"
}

# test_name FILE sets $name to the name that users type.
test_name() {
    name=${1##*/}
    name=${name%.*}
}

# of_head WORD FILE... prints what stands behind "WORD:" in the lines of these files that begin with "level:".
of_head() {
    word=$1
    shift
    for file; do
        sed -nE "1,8s/^(#|\/\*) (level: .*)/\2/p" "$file" | sed -nE "s/.*$word: *([^;*]*).*/\1/p"
    done
}

# level_of FILE prints first, full or release, or the first of them and release.
level_of() {
    level=$(of_head level "$1")
    echo ${level:-first}
}

# named NAME... prints the files of these tests.
named() {
    for wanted; do
        test_name "$wanted"
        wanted=$name
        found=
        for file in $all; do
            test_name "$file"
            [ "$name" != "$wanted" ] || { found=$file; echo "$file"; }
        done
        [ -n "$found" ] || refuse "build.sh: there is no test '$wanted'; the tests are:
$(for file in $all; do test_name "$file"; echo "  $name"; done)"
    done
}

# choose LEVEL [NAME...] sets $chosen to the tests of these names; without names, to those of the level: `full` has those of
# `first`, too; `release` has its own, and soaks of those that have amounts for it: they take hours. The longest come first.
choose() {
    all=$(find test/*/ -name 'test_*.c' -o -type f -perm -u+x | sort)
    wanted_level=$1
    shift
    if [ $# != 0 ]; then
        chosen=$(named "$@")
        return
    fi
    chosen=$(for file in $all; do
        case $wanted_level-$(level_of "$file") in first-first* | full-f* | release-*release*) echo "$file" ;; esac
    done)
    chosen=$(for name in $longest; do echo "$chosen" | grep "/${name}[.]" || :; done
        echo "$chosen" | grep -Ev "/($(echo $longest | tr ' ' '|'))[.]")
}

# packages_of FILE... prints the packages that these tests need.
packages_of() {
    { of_head packages "$@"; case $* in *.py*) echo python3 ;; esac; } | tr -s ' ' '\n' | sort -u
}

# Leaves those tests out of $chosen that need a package which this system does not have, and says so.
leave_out() {
    unknown=$(for package in $(packages_of $chosen); do exists "$package" || echo "$package"; done)
    [ -n "$unknown" ] || return 0
    kept=
    for file in $chosen; do
        lacks=$(packages_of "$file" | grep -Fx "$unknown" | tr '\n' ' ')
        if [ -z "$lacks" ]; then kept="$kept $file"; else test_name "$file"; echo "  left out  $name: this system has no package $lacks"; fi
    done
    chosen=$kept
}

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

# build_units FILE...: the C tests, each linked with that library. Warnings are errors.
build_units() {
    compile test/units '-O1 -Werror -fPIE -Itest/shared' "$@"
    for object in $objects; do
        test_name "$object"
        case $(packages_of "$(find test -name "$name.c")") in *osmesa*) osmesa=-lOSMesa ;; *) osmesa= ;; esac
        (libraries="$osmesa $libraries"; link "test/$name" "$object" "$LIBRARY")
    done
}

# Makes all that the chosen tests need, in a shell of its own.
make_for_tests() (
    units=$(printf '%s\n' $chosen | grep '[.]c$' || :)
    needed=" $(of_head makes $chosen | tr -s ' \n' ' ')"
    mkdir -p "$BUILD/test"
    case $needed in *' static '*) static_program ;; esac
    [ -z "$units$needed" ] || make_library
    for word in $needed; do
        case $word in
        static | library) ;;
        test_*) units="$units $(find test/*/ -name "$word.c")" ;;
        *) make_$word ;;
        esac
    done
    [ -z "$units" ] || build_units $(printf '%s\n' $units | sort -u)
)

# build_preloaded SOURCE LIBRARY [OPTION]: a library for LD_PRELOAD
build_preloaded() { $CC $warnings -Werror $CPPFLAGS -O1 $language -shared -fPIC $LDFLAGS "$1" -o "$2" ${3:-} -ldl; }

# The program whose pages hold the program.
make_live() { (kind=-live && build); }

# The fuzz targets (test/fuzz), which read files given to them.
make_replay() {
    compile test/fuzz '-O1 -Werror -fPIE' $(find test/fuzz -name '*.c' ! -name driver.c | sort)
    link test/replay $objects "$LIBRARY"
}

make_fail() { build_preloaded test/program/fail.c "$FAIL_LIBRARY"; }
make_spoil() { build_preloaded test/raster/beside/shader/spoil.c "$SPOIL_LIBRARY"; }
make_calls() { build_preloaded test/raster/gl/calls.c "$CALLS_LIBRARY" -lOSMesa; }
make_faults() { build_preloaded test/raster/check/fault.c "$FAULTS" -lOSMesa; }

# Prints the tables of commands and options.
make_command_table() {
    compile test/table '-O1 -Werror -fPIE' test/program/command_table.c
    link test/command_table $objects "$LIBRARY"
}

# The program under sanitizers: a wrong access and undefined behaviour end it with status 99. With gcc's shared
# libraries the second sanitizer would not write into log_path.
make_sanitized() (
    CFLAGS="-g -O1 -fPIE -fno-omit-frame-pointer -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all"
    case $CC in *gcc*) LDFLAGS="$LDFLAGS -static-libasan -static-libubsan" ;; esac
    find_sources
    compile test/sanitized "$CFLAGS" $sources "$BUILD/$builtin"
    link test/spectral-sanitized $objects
)

# The program that keeps a list of the functions that it passes.
make_walk() (
    find_sources
    compile test/walk '-g -O1 -fno-inline -fno-pie -finstrument-functions' $sources "$BUILD/$builtin"
    walked=$objects
    compile test/walk-list '-O1 -fno-pie' test/program/walk.c
    CFLAGS='' libraries=${libraries#-pie} LDFLAGS="$LDFLAGS -no-pie"
    link test/spectral-walk $walked $objects
)

make_mutant() { build_mutant mutant $pixel "$mutation"; }

make_mutants() {
    build_mutant endless $pixel "$endless"
    build_mutant hollow $instances "$hollow"
    build_mutant whole $instances "$whole"
    build_mutant moved raster/volumes/volumes.c "$moved"
    build_mutant detail raster/renderers/detail.c "$detail"
}

# Mutants that only the longer amounts need.
make_full_mutants() { [ -z "${FULL:-}" ] || make_mutants; }

# build_mutant NAME FILE MUTATION
build_mutant() {
    sed "$3" "$2" >"$BUILD/test/$1.new"
    ! cmp -s "$2" "$BUILD/test/$1.new" || refuse "test/run.sh: the mutation finds nothing in $2"
    cmp -s "$BUILD/test/$1.new" "$BUILD/test/$1.c" || mv "$BUILD/test/$1.new" "$BUILD/test/$1.c"
    compile "test/$1" "-O1 -Werror -fPIE -I$(dirname "$2")" "$BUILD/test/$1.c"
    link "test/spectral-$1" "$main" $objects "$LIBRARY"
}

# run_tests [full|release] [NAME...]; the longer amounts of `full` are asked for by FULL=1, the soaks of `release` by SOAK=1, too.
run_tests() {
    needs_gl
    level=first
    case ${1:-} in
    full) level=full; export FULL=1; shift ;;
    release) level=release; export FULL=1 SOAK=1; shift ;;
    esac
    choose $level "$@"
    make_folder
    leave_out
    need $(compiler_packages) $(library_packages) $(packages_of $chosen)
    build
    export SPECTRAL="$BUILD/spectral" LIVE="$BUILD/spectral-live" STATIC="$BUILD/spectral-static" TEST_TMP="$BUILD/tmp" BUILD \
        FAULTS="$BUILD/test/fault.so" FAIL_LIBRARY="$BUILD/test/fail.so" LIBRARY="$BUILD/test/library.a" REPLAY="$BUILD/test/replay" \
        CALLS_LIBRARY="$BUILD/test/calls.so" SPOIL_LIBRARY="$BUILD/test/spoil.so"
    make_for_tests
    mkdir -p "$TEST_TMP"
    RESULTS=$(mktemp "$TEST_TMP/results.XXXXXX")
    export RESULTS
    begun=$(date +%s)
    for file in $chosen; do
        test_name "$file"
        case $file in *.c) echo "$BUILD/test/$name" ;; *) echo "$file" ;; esac
    done | xargs -P "${JOBS:-$(($(nproc || echo 1) + 1))}" -n 1 sh test/one.sh || :
    count() { grep -c "^$1 " "$RESULTS" || :; }
    echo "$(count passed) passed, $(count failed) failed, $(count skipped) skipped, $(($(date +%s) - begun)) s"
    [ "$(wc -l <"$RESULTS")" = $(echo $chosen | wc -w) ] && [ "$(count failed)" = 0 ] || exit 1
    rm "$RESULTS"
}

# Builds the programs that test/bench/ratios.py measures beside the program.
make_bench() {
    compile obj-bench "$CFLAGS -Werror" test/bench/*.c
    for object in $objects; do
        test_name "$object"
        (libraries="-lOSMesa $libraries"; link "test/$name" "$object" "$LIBRARY")
    done
}

# run_bench [effects | [quick] [--csv FILE]]
run_bench() {
    needs_gl
    case "$*" in
    effects | '' | quick | '--csv '?* | 'quick --csv '?*) ;;
    *) refuse ;;
    esac
    build
    if [ "${1:-}" = effects ]; then
        need python3-tifffile python3-numpy
        /usr/bin/python3 test/bench/bench_effects.py "$BUILD/spectral" "$BUILD/tmp/bench"
        return
    fi
    LIBRARY=$BUILD/test/library.a
    need libosmesa6-dev
    (make_library && make_bench)
    need python3
    /usr/bin/python3 test/bench/ratios.py --from "$called_from" "$BUILD" "$@"
}

case $1 in
test) shift; run_tests "$@" ;;
bench) shift; run_bench "$@" ;;
esac
