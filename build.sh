#!/bin/sh
# SPDX-License-Identifier: MIT
# build.sh [build | run | test [full] | install PREFIX | clean]
# Everything it makes lies under build/. CC, CFLAGS and WERROR=1 are taken from the environment.
set -eu
cd "$(dirname "$0")"

CC=${CC:-gcc}
CFLAGS=${CFLAGS:--O3}
language='-std=c99 -D_XOPEN_SOURCE=700 -D_FILE_OFFSET_BITS=64 -ffp-contract=off -I.'
warnings='-pedantic -Wall -Wextra -Wshadow -Wconversion -Wdouble-promotion -Wstrict-prototypes
  -Wmissing-prototypes -Wundef -Wvla -Wcast-qual -Wwrite-strings'

# Packages by what they are for; the first file of each tells whether it is there.
build_packages='gcc libosmesa6-dev libtiff-dev zlib1g-dev libzstd-dev libdeflate-dev liblzma-dev
  libjpeg-dev libjbig-dev libwebp-dev liblerc-dev'
test_packages='clang libomp-dev perl python3-tifffile python3-numpy python3-gdal python3-scipy imagej
  default-jdk-headless glmark2-data psychtoolbox-3-common'

missing() {
    for package; do
        dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' ||
            printf '%s ' "$package"
    done
}

# Installs what is missing as root; otherwise says what to type.
need() {
    command -v dpkg-query >/dev/null || return 0 # no Debian: the compiler will say what it lacks
    lacking=$(missing "$@")
    [ -n "$lacking" ] || return 0
    if [ "$(id -u)" != 0 ]; then
        echo "build.sh: packages are missing; type: sudo apt-get install $lacking" >&2
        exit 2
    fi
    echo "installing $lacking"
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq
    # shellcheck disable=SC2086  # a list of words
    apt-get install -y -qq --no-install-recommends $lacking >build/apt.log 2>&1 ||
        { cat build/apt.log >&2; exit 3; }
}

# The text files under data/, as C: the program runs alone.
builtin_files() {
    number=0
    echo '#include "spectral.h"'
    find data/tables data/materials data/models data/scenes -type f | LC_ALL=C sort >build/data.list
    while read -r file; do
        echo "static const unsigned char file_$number[] = {"
        od -An -v -tu1 "$file" | sed 's/  */,/g; s/^,//; s/$/,/'
        echo '0};'
        number=$((number + 1))
    done <build/data.list
    number=0
    echo 'const struct builtin_file builtin_files[] = {'
    while read -r file; do
        echo "{\"${file#data/}\", file_$number, sizeof file_$number - 1},"
        number=$((number + 1))
    done <build/data.list
    echo '};'
    echo "const size_t builtin_file_count = $number;"
}

# libtiff and what it brings are linked statically, so that only OSMesa must be there at run time.
# Lerc is C++; OSMesa's LLVM brings that library anyway.
libraries() {
    echo '-Wl,--exclude-libs,ALL -Wl,-Bstatic -ltiff -lwebp -lzstd -llzma -lLerc -ljbig -ljpeg'
    echo '-ldeflate -lz -Wl,-Bdynamic -lOSMesa -lstdc++ -lm -lpthread'
}

compile() { # OUTPUT FLAGS...
    output=$1
    shift
    # shellcheck disable=SC2046,SC2086
    $CC $language $warnings $CFLAGS -fopenmp "$@" -o "$output" $(libraries)
}

build() {
    mkdir -p build
    # shellcheck disable=SC2086
    need $build_packages
    builtin_files >build/builtin.c.new
    cmp -s build/builtin.c.new build/builtin.c || mv build/builtin.c.new build/builtin.c
    newest=$(find spectral.[ch] data raster build.sh build/builtin.c -newer build/spectral 2>/dev/null || echo all)
    [ -n "$newest" ] || return 0
    echo "building build/spectral with $CC $CFLAGS"
    compile build/spectral.new spectral.c data/*.c raster/*.c build/builtin.c
    mv build/spectral.new build/spectral
}

case ${1:-build} in
build) build ;;
run)
    build
    build/spectral render colorchecker -o colorchecker.tif
    ;;
*)
    echo "usage: build.sh [build | run | test [full] | install PREFIX | clean]" >&2
    exit 2
    ;;
esac
