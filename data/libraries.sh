# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2034,SC2046,SC2086,SC2153,SC2154
# The libraries of the program: those of Debian's packages, and those that are built from Debian's sources
# (data/images/libtiff.sh, raster/gl/osmesa.sh); build.sh reads this. On another system nothing is installed:
# the compiler will say what it lacks. Libraries that were built are kept in $XDG_CACHE_HOME/spectral
# (~/.cache/spectral).
case ${XDG_CACHE_HOME:-} in # as the XDG base directory specification has it
/*) cache=$XDG_CACHE_HOME/spectral ;;
*) cache=${HOME:-$PWD/build}/.cache/spectral ;;
esac

. data/images/libtiff.sh

# links HEADER FUNCTION OPTION... succeeds if $CC makes a program that calls the function.
links() {
    header=$1
    function=$2
    shift 2
    printf '#include <%s>\nint main(void) { return !%s(); }\n' "$header" "$function" |
        $CC $CPPFLAGS $CFLAGS $LDFLAGS -x c - -o "$BUILD/probe" "$@" 2>/dev/null
}

# macro NAME HEADER prints the value that $CC gives a macro; nothing where it finds no header.
macro() { printf '#include <%s>\n%s\n' "$2" "$1" | $CC $CPPFLAGS $CFLAGS $language -x c -E -P - 2>/dev/null | tail -n 1; }

# Refuses a compiler that lacks some of C99, and a libtiff that cannot place pages, before either prints many lines.
check_versions() {
    case $(macro __clang_major__ limits.h)-$(macro __GNUC__ limits.h) in
    [0-5]-*) refuse "build.sh: $CC is clang $(macro __clang_major__ limits.h); expected clang 6 or later" ;;
    __clang_major__-[0-4]) refuse "build.sh: $CC is gcc $(macro __GNUC__ limits.h); expected gcc 5 or later" ;;
    esac
    version=$(macro TIFFLIB_VERSION tiffio.h)
    case $version in
    20[01]?????) [ "$version" -ge 20191103 ] || refuse "build.sh: libtiff is \
$(macro TIFFLIB_VERSION_STR tiffio.h | sed 's/.*Version \([0-9.]*\).*/\1/'); expected 4.1 or later" ;;
    esac
}

# Adds the options by which $CC rounds sums to float and double. With the wider ones of some processors pictures would
# differ, and the sources refuse to be compiled: x86 of 32 bits needs the first, s390x the second, for its floats.
round_sums() {
    for option in '' '-msse2 -mfpmath=sse' -fexcess-precision=fast; do
        if [ "$(CFLAGS="$CFLAGS $option" macro FLT_EVAL_METHOD float.h)" = 0 ]; then
            language="$language $option"
            return
        fi
    done
}

# library_packages prints the packages of the libraries for $GL.
library_packages() {
    case $GL-$CC in
    osmesa-*) echo libgl-dev libegl-dev $(opengl_packages) libtiff-dev zlib1g-dev ;;
    none-gcc | none-clang) echo libtiff-dev zlib1g-dev ;;
    esac
}

# opengl_packages prints the package of OSMesa, or those of EGL where they are installed, or where the system has no OSMesa,
# as Debian after version 13.
opengl_packages() {
    egl='libegl1 libegl-mesa0 libgl1-mesa-dri'
    if installed libosmesa6 || { ! installed $egl && exists libosmesa6; }; then echo libosmesa6; else echo $egl; fi
}

# Sets $libraries for $GL. A compiler that sees no libtiff, such as musl-gcc or one for another
# processor, gets its own, and makes a static program.
find_libraries() {
    need $(library_packages)
    libraries='-ltiff -lz -lm'
    [ "$GL" != osmesa ] || libraries="$libraries -ldl" # OpenGL's libraries are opened at run time
    if [ "$GL" = none ] && ! links tiffio.h TIFFGetVersion $libraries; then
        find_tiff
        CPPFLAGS="$CPPFLAGS -I$tiff/include -I$zlib/include"
        libraries="-static -Wl,--gc-sections -L$tiff -L$zlib $libraries"
    fi
}

# ---- packages ----

# installed PACKAGE... succeeds if all are installed.
installed() {
    [ "$(dpkg-query -W -f='${db:Status-Status}\n' "$@" 2>/dev/null | grep -cx installed)" = $# ]
}

# exists PACKAGE succeeds if the system has the package, or has no packages of Debian.
exists() {
    command -v apt-cache >/dev/null || return 0
    installed "$1" || { update_lists && apt-cache show "$1" >/dev/null 2>&1; }
}

# Reads the lists of packages anew, once an hour.
update_lists() {
    [ "$(id -u)" = 0 ] && [ -z "$(find "$BUILD/updated" -mmin -60 2>/dev/null)" ] || return 0
    logged update apt-get update
    : >"$BUILD/updated"
}

# need PACKAGE... installs the packages that are missing, or says what to type.
need() {
    command -v dpkg-query >/dev/null || return 0
    lacking=
    for package; do
        installed "$package" || lacking="$lacking $package"
    done
    [ -n "$lacking" ] || return 0
    if [ "$(id -u)" != 0 ]; then
        refuse "build.sh: packages are missing; type: sudo apt-get install$lacking"
    fi
    update_lists
    announce $lacking
    logged install env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends $lacking
}

# announce PACKAGE... says how many packages will be installed, with those that they need, and how large they are.
announce() {
    apt-cache show --no-all-versions $(apt-get install -s --no-install-recommends "$@" | sed -n 's/^Inst \([^ ]*\).*/\1/p') |
        awk -v names="$*" '/^Size:/ { fetch += $2; n++ } /^Installed-Size:/ { disk += $2 } END {
            printf "installing %d packages, %.0f MB to fetch, %.0f MB on disk: %s\n", n, fetch / 1e6, disk / 1e3, names }'
}

# compiler_packages prints the packages of $CC, if it is one of these.
compiler_packages() {
    case $CC in
    gcc | clang) echo $CC libc6-dev ;;
    musl-gcc) echo musl-tools ;;
    aarch64-linux-gnu-gcc) echo gcc-aarch64-linux-gnu libc6-dev-arm64-cross ;;
    arm-linux-gnueabihf-gcc) echo gcc-arm-linux-gnueabihf libc6-dev-armhf-cross ;;
    riscv64-linux-gnu-gcc) echo gcc-riscv64-linux-gnu libc6-dev-riscv64-cross ;;
    s390x-linux-gnu-gcc) echo gcc-s390x-linux-gnu libc6-dev-s390x-cross ;;
    esac
}

# versions PACKAGE... prints the versions of installed packages.
versions() {
    [ $# = 0 ] || ! command -v dpkg-query >/dev/null || dpkg-query -W "$@"
}

# logged NAME COMMAND... runs a command and writes its output to $BUILD/NAME.log. If the command fails,
# the end of the log is shown.
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

# ---- libraries from their sources ----

# debian_version PACKAGE prints the version of the package's source, by this machine's package lists.
debian_version() {
    apt-cache show --no-all-versions "$1" 2>/dev/null | awk '
        /^Version:/ { version = $2 }
        /^Source: .*\(/ { version = substr($3, 2, length($3) - 2) }
        END { print version; exit version == "" }' ||
        refuse "build.sh: Debian's package lists do not name $1; type: sudo apt-get update"
}

# debian_source PACKAGE VERSION FOLDER unpacks Debian's source, patched, into FOLDER/source. It reads the
# archives that this machine reads, but into lists of its own: the machine's configuration stays as it was.
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

# cached NAME PACKAGE VERSION KEY sets $library to a folder of the cache. If the folder is missing, the
# function make_NAME is called beside Debian's `source`, and fills the folder `library`, which becomes
# the cache's when all succeeds. Another KEY gives another folder.
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
