#!/bin/sh
# SPDX-License-Identifier: MIT
# What it makes lies under build/; the program is build/spectral. CC and CFLAGS come from the
# environment. On Debian, what is missing is installed when run as root.
# Lists are split into words on purpose.
# shellcheck disable=SC2086,SC2046
set -eu
cd "$(dirname "$0")"

usage='usage: ./build.sh [build | run | test [full] | bench [effects] | install PREFIX | clean]'
CC=${CC:-gcc}
CFLAGS=${CFLAGS:--O3}
# No floating-point traps are taken and no errno is read after sqrt: both let loops be done several
# samples at once and change no result (no -ffast-math, no -march=native, no contraction).
language="-std=c99 -D_XOPEN_SOURCE=700 -D_FILE_OFFSET_BITS=64 -ffp-contract=off -fno-trapping-math
  -fno-math-errno -fopenmp -I."
warnings='-pedantic -Wall -Wextra -Wshadow -Wconversion -Wdouble-promotion -Wstrict-prototypes
  -Wmissing-prototypes -Wundef -Wvla -Wcast-qual -Wwrite-strings'
# libtiff and what it brings are linked statically, so that only OSMesa must be there at run time.
# Lerc is C++, whose library OSMesa's LLVM brings anyway.
libraries='-Wl,--exclude-libs,ALL -Wl,-Bstatic -ltiff -lwebp -lzstd -llzma -lLerc -ljbig -ljpeg
  -ldeflate -lz -Wl,-Bdynamic -lOSMesa -l:libstdc++.so.6 -lm -lpthread'

build_packages='libc6-dev libosmesa6-dev libtiff-dev zlib1g-dev libzstd-dev libdeflate-dev
  liblzma-dev libjpeg-dev libjbig-dev libwebp-dev liblerc-dev'
test_packages='gcc clang libomp-dev perl python3-tifffile python3-numpy python3-scipy python3-gdal
  imagej default-jdk-headless glmark2-data psychtoolbox-3-common'
mutation='s/whole = bound\[i\]/whole = 1000 * bound[i]/'

# need PACKAGE... installs what is missing, or says what to type.
need() {
    command -v dpkg-query >/dev/null || return 0 # not Debian: the compiler will say what it lacks
    lacking=
    for package; do
        dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' ||
            lacking="$lacking $package"
    done
    [ -n "$lacking" ] || return 0
    if [ "$(id -u)" != 0 ]; then
        echo "build.sh: packages are missing; type: sudo apt-get install$lacking" >&2
        exit 2
    fi
    echo "installing$lacking"
    mkdir -p build
    if ! { apt-get update && DEBIAN_FRONTEND=noninteractive \
        apt-get install -y --no-install-recommends $lacking; } >build/install.log 2>&1 </dev/null; then
        tail -n 20 build/install.log >&2
        exit 3
    fi
}

# The text files under data/ as C, so that the program runs alone.
builtin_files() {
    find data/tables data/materials data/models data/scenes data/textures -type f | LC_ALL=C sort >build/builtin.list
    echo '#include "spectral.h"'
    number=0
    while read -r file; do
        number=$((number + 1))
        echo "static const unsigned char file_${number}[] = {"
        od -An -v -tu1 "$file" | sed 's/  */,/g; s/^,//; s/$/,/'
        echo '0};'
    done <build/builtin.list
    echo 'const struct builtin_file builtin_files[] = {'
    number=0
    while read -r file; do
        number=$((number + 1))
        echo "{\"${file#data/}\", file_$number, sizeof file_$number - 1},"
    done <build/builtin.list
    echo '};'
    echo "const size_t builtin_file_count = $number;"
}

# program OUTPUT SOURCE... with $CC, $CFLAGS and the warnings
program() {
    output=$1
    shift
    $CC $language $warnings $CFLAGS "$@" -o "$output.new" $libraries
    mv "$output.new" "$output"
}

prepare() {
    mkdir -p build
    case $CC in
    gcc) need gcc $build_packages ;;
    clang) need clang libomp-dev $build_packages ;;
    *) need $build_packages ;;
    esac
    builtin_files >build/builtin.new
    cmp -s build/builtin.new build/builtin.c || cp build/builtin.new build/builtin.c
}

build() {
    prepare
    made_with="$CC $CFLAGS"
    if [ -x build/spectral ] && [ "$(cat build/made-with 2>/dev/null)" = "$made_with" ] &&
        [ -z "$(find spectral.[ch] data raster build.sh build/builtin.c -newer build/spectral)" ]; then
        return
    fi
    echo "building build/spectral ($made_with)"
    program build/spectral spectral.c data/*.c raster/*.c build/builtin.c
    echo "$made_with" >build/made-with
}

# Warnings are errors here, with gcc and with clang; each test program is linked with everything but
# the command line.
build_tests() {
    need $test_packages
    mkdir -p build/test build/tmp
    warnings="$warnings -Werror"
    echo "building the tests"
    for source in spectral.c data/*.c raster/*.c build/builtin.c; do
        object=build/test/$(echo "$source" | tr / -).o
        $CC $language $warnings -O2 -c "$source" -o "$object"
    done
    rm -f build/test/spectral.c.o build/test/library.a
    ar rcs build/test/library.a build/test/*.o
    for source in test/test_*.c test/bench.c; do
        CFLAGS='-O1 -Itest' program "build/test/$(basename "$source" .c)" "$source" build/test/library.a
    done
    CC=clang CFLAGS=-O2 program build/test/spectral-clang spectral.c data/*.c raster/*.c build/builtin.c
    $CC $language $warnings -O1 -shared -fPIC test/fault.c -o build/test/fault.so -ldl
    # a program with a fault of its own: all bounds on colours are a thousand times too wide
    sed "$mutation" raster/counts.c >build/test/mutant.c
    CFLAGS='-O1 -Iraster' program build/test/spectral-mutant spectral.c build/test/mutant.c build/test/library.a
}

run_tests() {
    export SPECTRAL=build/spectral TEST_TMP=build/tmp FAULTS=build/test/fault.so
    scripts=$(find test -maxdepth 1 -perm -u+x -type f | LC_ALL=C sort)
    prove --timer --exec '' $(find build/test -name 'test_*' -perm -u+x | LC_ALL=C sort) $scripts
}

# 5,000 random scenes on llvmpipe and 500 on softpipe.
run_full_tests() {
    for random in 'llvmpipe --count 5000' 'softpipe --count 500'; do
        prove --timer --exec '' test/random_scenes.py :: --first 1000 --driver $random
    done
}

case ${1:-build} in
build) build ;;
run)
    build
    build/spectral render colorchecker -o colorchecker.tif
    ;;
test)
    build
    build_tests
    run_tests
    case ${2:-} in
    full) run_full_tests ;;
    '') ;;
    *)
        echo "$usage" >&2
        exit 2
        ;;
    esac
    ;;
bench)
    build
    case ${2:-} in
    effects)
        need python3-tifffile python3-numpy
        /usr/bin/python3 test/bench_effects.py build/spectral build/tmp/bench
        ;;
    '')
        program build/bench -Itest test/bench.c $(find data raster -name '*.c') build/builtin.c
        build/bench
        ;;
    *)
        echo "$usage" >&2
        exit 2
        ;;
    esac
    ;;
install)
    [ $# = 2 ] || { echo "$usage" >&2; exit 2; }
    build
    install -D -m 755 build/spectral "${DESTDIR:-}$2/bin/spectral"
    ;;
clean) rm -rf build ;;
*)
    echo "$usage" >&2
    exit 2
    ;;
esac
