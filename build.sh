#!/bin/sh
# SPDX-License-Identifier: MIT
# What it makes lies under $BUILD (build; relative to this folder); the program is $BUILD/spectral. From
# the environment come also CC, CFLAGS, and GL: osmesa, or none for a program without OpenGL. On Debian,
# what is missing is installed when run as root. Libraries that are built here are kept in
# $XDG_CACHE_HOME/spectral (~/.cache/spectral).
# Lists are split into words on purpose.
# shellcheck disable=SC2046,SC2086,SC2089,SC2090
set -eu
export LC_ALL=C
called_from=$PWD
cd "$(dirname "$0")"

usage='usage: ./build.sh [build | static | run | test [full] | bench [effects] | dist | install PREFIX | clean]'
CC=${CC:-gcc}
CFLAGS=${CFLAGS:--O3}
GL=${GL:-osmesa}
BUILD=${BUILD:-build}
case ${XDG_CACHE_HOME:-} in # as the XDG base directory specification has it
/*) cache=$XDG_CACHE_HOME/spectral ;;
*) cache=${HOME:-$PWD/build}/.cache/spectral ;;
esac
# These come after $CFLAGS, which may ask for arithmetic that changes pictures. No floating-point traps
# are taken and no errno is read after sqrt: both let loops be done several samples at once and change
# no result.
language='-std=c99 -D_XOPEN_SOURCE=700 -D_FILE_OFFSET_BITS=64 -I. -fno-associative-math
  -fno-reciprocal-math -fsigned-zeros -fno-finite-math-only -ffp-contract=off -fno-trapping-math
  -fno-math-errno'
warnings='-pedantic -Wall -Wextra -Wshadow -Wconversion -Wdouble-promotion -Wstrict-prototypes
  -Wmissing-prototypes -Wundef -Wvla -Wcast-qual -Wwrite-strings'
hardening='-fstack-protector-strong -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2'
static_packages='g++ libc6-dev libtiff-dev zlib1g-dev libzstd-dev libdeflate-dev liblzma-dev libjpeg-dev libwebp-dev
  liblerc-dev'
test_packages='gcc clang libomp-dev perl liblcms2-utils python3-pil python3-tifffile python3-numpy python3-scipy python3-gdal
  imagej default-jdk-headless glmark2-data psychtoolbox-3-common mandoc bsdextrautils busybox-static
  chromium file binutils musl-tools gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user'
mutation='s/whole = bound\[i\]/whole = 1000 * bound[i]/'

refuse() {
    echo "${1:-$usage}" >&2
    exit 2
}

# ---- packages, and libraries from their sources ----

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
        refuse "build.sh: packages are missing; type: sudo apt-get install$lacking"
    fi
    echo "installing$lacking"
    logged install install_packages $lacking
}

install_packages() {
    apt-get update
    DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@"
}

# versions PACKAGE... tells those that are installed.
versions() {
    [ $# = 0 ] || ! command -v dpkg-query >/dev/null || dpkg-query -W "$@"
}

# logged NAME COMMAND... writes to $BUILD/NAME.log, whose end is shown if the command fails.
logged() {
    mkdir -p "$BUILD"
    log=$BUILD/$1.log
    shift
    set +e # in a condition, the command would go on after an error
    (set -e; "$@") >"$log" 2>&1 </dev/null
    status=$?
    set -e
    [ "$status" = 0 ] || { tail -n 20 "$log" >&2; exit 3; }
}

# debian_version BINARY_PACKAGE: the version of its source package, by this machine's package lists
debian_version() {
    apt-cache show --no-all-versions "$1" 2>/dev/null | awk '
        /^Version:/ { version = $2 }
        /^Source: .*\(/ { version = substr($3, 2, length($3) - 2) }
        END { print version; exit version == "" }' ||
        refuse "build.sh: Debian's package lists do not name $1; type: sudo apt-get update"
}

# debian_source PACKAGE VERSION FOLDER unpacks Debian's source, patched, into FOLDER/source. The
# archives are those of this machine, but in lists of their own: its configuration stays as it was.
debian_source() {
    mkdir -p "$3/sources" "$3/lists/partial"
    archive='debian([.]org/[^ ]*|-security|[.]list)?/?[[:space:]]'
    cat /etc/apt/sources.list /etc/apt/sources.list.d/*.list 2>/dev/null |
        sed -nE "s,^deb([[:space:]].*${archive}.* main),deb-src\1,p" >"$3/sources/debian.list"
    cat /etc/apt/sources.list.d/*.sources 2>/dev/null |
        awk -v RS= -v uri="(^|\n)URIs:[^\n]*$archive" '$0 "\n" ~ uri {
            sub(/(^|\n)Types:[^\n]*/, "\nTypes: deb-src"); print $0 "\n" }' >"$3/sources/debian.sources"
    (
        apt="-o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts=$3/sources
            -o Dir::State::Lists=$3/lists -o Dir::Cache=$3 -o APT::Sandbox::User=root"
        cd "$3" && apt-get $apt update &&
            apt-get $apt source --only-source --download-only "$1=$2" &&
            dpkg-source --no-check -x ./*.dsc source
    )
}

# cached NAME PACKAGE VERSION KEY sets $library to a folder of the cache: what make_NAME puts into the
# folder `library` of its own, beside Debian's `source`, when all of it succeeds.
cached() {
    library=$cache/$1-$3-$(echo "$4" | sha256sum | cut -c 1-16)
    case $library in *[[:space:]]*) refuse "build.sh: blanks in $cache; set XDG_CACHE_HOME to another folder" ;; esac
    [ ! -d "$library" ] || return 0
    echo "building $1 $3 (minutes, but only once)"
    logged "$1" make_cached "$@"
}

make_cached() {
    mkdir -p "$cache"
    work=$(mktemp -d "$cache/new.XXXXXX")
    trap 'rm -rf "$work"' EXIT
    trap 'exit 3' HUP INT TERM
    debian_source "$2" "$3" "$work"
    cd "$work"
    "make_$1"
    mv -T "$work/library" "$library" || [ -d "$library" ] # another build was faster
}

. raster/osmesa.sh
. data/tiff.sh

# ---- the program ----

# The text files under data/ as C, so that the program runs alone.
builtin_files() {
    find data/tables data/materials data/models data/scenes data/textures data/viewer.html -type f |
        sort >"$BUILD/builtin.list"
    echo '#include "spectral.h"'
    number=0
    while read -r file; do
        number=$((number + 1))
        echo "static const unsigned char file_${number}[] = {"
        od -An -v -tu1 "$file" | sed 's/  */,/g; s/^,//; s/$/,/'
        echo '0};'
    done <"$BUILD/builtin.list"
    echo 'const struct builtin_file builtin_files[] = {'
    number=0
    while read -r file; do
        number=$((number + 1))
        echo "{\"${file#data/}\", file_$number, sizeof file_$number - 1},"
    done <"$BUILD/builtin.list"
    echo '};'
    echo "const size_t builtin_file_count = $number;"
}

compiler_packages() {
    case $CC in
    gcc) echo gcc libc6-dev ;;
    clang) echo clang libomp-dev libc6-dev ;;
    musl-gcc) echo musl-tools ;;
    aarch64-linux-gnu-gcc) echo gcc-aarch64-linux-gnu libc6-dev-arm64-cross ;;
    esac
}

# links HEADER FUNCTION OPTION... tells whether $CC makes a program that calls it.
links() {
    header=$1
    function=$2
    shift 2
    printf '#include <%s>\nint main(void) { return !%s(); }\n' "$header" "$function" |
        $CC $CFLAGS -x c - -o "$BUILD/probe" "$@" 2>/dev/null
}

# Sets $sources: all but those that match.
leave_out() {
    sources=$({ echo spectral.c; find data raster -name '*.c' | sort; } | grep -vE "$1")
}

# Sets $sources and $libraries for $GL. A compiler that sees no libtiff, such as musl-gcc or one for
# another processor, gets its own, and makes a static program.
find_libraries() {
    case $GL in
    osmesa)
        leave_out raster/no_gl.c
        libraries='-lOSMesa -ltiff -lz -lm'
        need libosmesa6-dev libtiff-dev zlib1g-dev
        ;;
    none)
        leave_out 'raster/(mesa|identify).c'
        libraries='-ltiff -lz -lm'
        case $CC in gcc | clang) need libtiff-dev zlib1g-dev ;; esac
        if ! links tiffio.h TIFFGetVersion $libraries; then
            find_tiff
            libraries="-static -Wl,--gc-sections -I$tiff/include -I$zlib/include -L$tiff -L$zlib -ltiff -lz -lm"
        fi
        ;;
    *) refuse "build.sh: GL is osmesa or none, not '$GL'" ;;
    esac
}

# The same for a program that is static with an OSMesa of its own, and hardened. Mesa calls the
# pthread functions only if something else brings them, and crashes without. What would load drivers of
# accelerators by dlopen is OpenMP's, and never called. Neither is libjbig, which would put the program
# under the GPL: data/image.c refuses its pictures.
find_static_libraries() {
    [ "$GL" = osmesa ] || refuse "build.sh: the static program has an OSMesa of its own; GL=$GL is for the plain build"
    need $static_packages
    find_osmesa
    CFLAGS="$CFLAGS $hardening -ffunction-sections -fdata-sections -isystem $osmesa/include
        -DOSMESA_VERSION=\"${osmesa_version%%-*}\""
    libraries="-static-pie -Wl,--gc-sections,-z,relro,-z,now,-z,noexecstack
        -Wl,-u,pthread_mutexattr_init,-u,pthread_mutexattr_settype,-u,pthread_mutexattr_destroy
        -Wl,--wrap=dlopen,--defsym=__wrap_dlopen=abort
        $(printf ' -Wl,--defsym=jbg_%s=abort' dec_free dec_getimage dec_getsize dec_in dec_init enc_free \
            enc_init enc_out newlen strerror)
        -L$osmesa -lOSMesa -ltiff -lwebp -lzstd -llzma -lLerc -ljpeg -ldeflate -lz -lstdc++ -lm"
    leave_out raster/no_gl.c
}

# Sets $openmp. Without OpenMP for the C library in use, --threads changes nothing.
find_openmp() {
    openmp=-fopenmp
    links omp.h omp_get_max_threads -fopenmp $libraries || openmp=-Wno-unknown-pragmas
}

prepare() {
    case $CFLAGS in
    *-Ofast* | *-ffast-math* | *-funsafe-math*) refuse "build.sh: $CFLAGS changes pictures; -O3 does not" ;;
    esac
    mkdir -p "$BUILD"
    need $(compiler_packages)
    builtin_files >"$BUILD/builtin.new"
    cmp -s "$BUILD/builtin.new" "$BUILD/builtin.c" || cp "$BUILD/builtin.new" "$BUILD/builtin.c"
}

# program OUTPUT SOURCE... with $CC, $CFLAGS and the warnings
program() {
    output=$1
    shift
    $CC $warnings $CFLAGS $language $openmp "$@" -o "$output.new" $libraries
    mv "$output.new" "$output"
}

# fresh_program OUTPUT PACKAGE... makes it of all sources, unless it is there already; the packages are
# those that become part of it.
fresh_program() {
    output=$1
    shift
    made_with="$CC $CFLAGS $libraries $(versions "$@")"
    if [ ! -x "$output" ] || [ "$(cat "$output.made-with" 2>/dev/null)" != "$made_with" ] ||
        [ -n "$(find spectral.[ch] data raster build.sh "$BUILD/builtin.c" -newer "$output")" ]; then
        echo "building ${output%.symbols} with $CC"
        program "$output" $sources "$BUILD/builtin.c"
        echo "$made_with" >"$output.made-with"
    fi
}

build() {
    prepare
    find_libraries
    find_openmp
    fresh_program "$BUILD/spectral"
}

# In a shell of its own, which keeps $CFLAGS and $libraries. The file .symbols is for debuggers.
static_program() (
    prepare
    find_static_libraries
    find_openmp
    fresh_program "$BUILD/spectral-static.symbols" $static_packages
    strip -o "$BUILD/spectral-static.new" "$BUILD/spectral-static.symbols"
    mv "$BUILD/spectral-static.new" "$BUILD/spectral-static"
)

# ---- a release ----

# What the static program holds, beside this project's own: which versions, and their copyrights.
licences() {
    folder=$1
    mkdir "$folder"
    cp "$osmesa/copyright" "$folder/mesa"
    gcc=$(gcc -dumpversion)
    set -- libtiff-dev libwebp-dev libzstd-dev liblzma-dev liblerc-dev libjpeg62-turbo-dev libdeflate-dev \
        zlib1g-dev libc6-dev "libgcc-$gcc-dev" "libstdc++-$gcc-dev"
    { echo "mesa $osmesa_version"; versions "$@"; } >"$folder/VERSIONS"
    for package; do
        cp -L "/usr/share/doc/$package/copyright" "$folder/$package"
    done
}

# The same bytes wherever it is made of the same versions: its date is that of the manual page.
dist() {
    static_program
    find_osmesa
    version=$(sed -n 's/^#define SPECTRAL_VERSION "\(.*\)"/\1/p' spectral.h)
    name=spectral-$version-linux-$(uname -m)
    rm -rf "${BUILD:?}/$name"
    mkdir "$BUILD/$name" "$BUILD/$name/data"
    cp "$BUILD/spectral-static" "$BUILD/$name/spectral"
    cp README.md LICENSE spectral.1 "$BUILD/$name"
    for folder in data/*/; do
        cp -R "${folder%/}" "$BUILD/$name/data"
    done
    licences "$BUILD/$name/licences"
    (cd "$BUILD/$name" && find . -type f | sort | xargs sha256sum >../SHA256SUMS && mv ../SHA256SUMS .)
    tar -C "$BUILD" -c --sort=name --mtime="$(sed -n 's/^[.]Dd //p' spectral.1) UTC" --owner=0 --group=0 \
        --numeric-owner --mode=u=rwX,go=rX "$name" | gzip -9n >"$BUILD/$name.tar.gz.new"
    mv "$BUILD/$name.tar.gz.new" "$BUILD/$name.tar.gz"
    rm -rf "${BUILD:?}/$name"
    (cd "$BUILD" && sha256sum "$name.tar.gz")
}

# A relative PREFIX is one of the folder that this was called from.
install_program() {
    target=${DESTDIR:+$DESTDIR/}$1
    case $target in /*) ;; *) target=$called_from/$target ;; esac
    install -D -m 755 "$BUILD/spectral" "$target/bin/spectral"
    install -D -m 644 spectral.1 "$target/share/man/man1/spectral.1"
}

# ---- tests and benches ----

# Warnings are errors here, with gcc and with clang; each test program is linked with everything but
# the command line.
build_tests() {
    need $test_packages
    mkdir -p "$BUILD/test" "$BUILD/tmp"
    warnings="$warnings -Werror"
    echo "building the tests"
    for source in $sources "$BUILD/builtin.c"; do
        $CC $warnings -O2 $language $openmp -c "$source" -o "$BUILD/test/$(echo "$source" | tr / _).o"
    done
    rm -f "$BUILD/test/spectral.c.o" "$BUILD/test/library.a"
    ar rcs "$BUILD/test/library.a" "$BUILD"/test/*.o
    for source in test/test_*.c test/bench.c; do
        CFLAGS='-O1 -Itest' program "$BUILD/test/$(basename "$source" .c)" "$source" "$BUILD/test/library.a"
    done
    $CC $warnings -O1 $language -shared -fPIC test/fault.c -o "$BUILD/test/fault.so" -ldl
    # a program with a fault of its own: all bounds on colours are a thousand times too wide
    sed "$mutation" raster/counts.c >"$BUILD/test/mutant.c"
    CFLAGS='-O1 -Iraster' program "$BUILD/test/spectral-mutant" spectral.c "$BUILD/test/mutant.c" \
        "$BUILD/test/library.a"
}

run_tests() {
    export SPECTRAL="$BUILD/spectral" STATIC="$BUILD/spectral-static" TEST_TMP="$BUILD/tmp" BUILD \
        FAULTS="$BUILD/test/fault.so" LIBRARY="$BUILD/test/library.a"
    scripts=$(find test -maxdepth 1 -perm -u+x -type f | sort)
    prove --timer --exec '' $(find "$BUILD/test" -name 'test_*' -perm -u+x | sort) $scripts
}

# 5,000 random scenes on llvmpipe and 500 on softpipe.
run_random_tests() {
    for random in 'llvmpipe --count 5000' 'softpipe --count 500'; do
        prove --timer --exec '' test/random_scenes.py :: --first 1000 --driver $random
    done
}

needs_gl() {
    [ "$GL" = osmesa ] || refuse "build.sh: this compares with OpenGL, which GL=$GL leaves out"
}

case "${1:-build} ${2:-}" in
'build ') build ;;
'static ') static_program ;;
'run ')
    build
    "$BUILD/spectral" render colorchecker $([ "$GL" = osmesa ] || echo --renderer raster) -o colorchecker.tif
    ;;
'test ' | 'test full')
    needs_gl
    build
    static_program
    build_tests
    [ "${2:-}" != full ] || export FULL=1
    run_tests
    [ "${2:-}" != full ] || run_random_tests
    ;;
'bench ')
    needs_gl
    build
    program "$BUILD/bench" -Itest test/bench.c $(echo $sources | sed 's/^spectral.c//') "$BUILD/builtin.c"
    "$BUILD/bench"
    ;;
'bench effects')
    needs_gl
    build
    need python3-tifffile python3-numpy
    /usr/bin/python3 test/bench_effects.py "$BUILD/spectral" "$BUILD/tmp/bench"
    ;;
'dist ') dist ;;
'install '?*)
    [ $# = 2 ] || refuse
    build
    install_program "$2"
    ;;
'clean ') rm -rf "$BUILD" ;;
*) refuse ;;
esac
