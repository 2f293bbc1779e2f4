# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2034,SC2086,SC2153,SC2154
# The libraries of the program: those of Debian's packages, and those that are built from Debian's sources
# (data/tiff/libtiff.sh, raster/gl/osmesa.sh); build.sh reads this. On another system nothing is installed:
# the compiler will say what it lacks. Libraries that were built are kept in $XDG_CACHE_HOME/spectral
# (~/.cache/spectral).
case ${XDG_CACHE_HOME:-} in # as the XDG base directory specification has it
/*) cache=$XDG_CACHE_HOME/spectral ;;
*) cache=${HOME:-$PWD/build}/.cache/spectral ;;
esac

. data/tiff/libtiff.sh

# links HEADER FUNCTION OPTION... succeeds if $CC makes a program that calls the function.
links() {
    header=$1
    function=$2
    shift 2
    printf '#include <%s>\nint main(void) { return !%s(); }\n' "$header" "$function" |
        $CC $CPPFLAGS $CFLAGS $LDFLAGS -x c - -o "$BUILD/probe" "$@" 2>/dev/null
}

# Sets $libraries for $GL. A compiler that sees no libtiff, such as musl-gcc or one for another
# processor, gets its own, and makes a static program.
find_libraries() {
    libraries='-ltiff -lz -lm'
    case $GL-$CC in
    osmesa-*)
        need libgl-dev libegl-dev libosmesa6 libtiff-dev zlib1g-dev
        libraries="$libraries -ldl" # OpenGL's libraries are opened at run time
        ;;
    none-gcc | none-clang) need libtiff-dev zlib1g-dev ;;
    esac
    if [ "$GL" = none ] && ! links tiffio.h TIFFGetVersion $libraries; then
        find_tiff
        CPPFLAGS="$CPPFLAGS -I$tiff/include -I$zlib/include"
        libraries="-static -Wl,--gc-sections -L$tiff -L$zlib $libraries"
    fi
}

# ---- packages ----

# need PACKAGE... installs the packages that are missing, or says what to type.
need() {
    command -v dpkg-query >/dev/null || return 0
    installed=$(dpkg-query -W -f='${Package} ${db:Status-Status}, ' "$@" 2>/dev/null) || : # some are unknown
    lacking=
    for package; do
        case ", $installed" in *", $package installed, "*) ;; *) lacking="$lacking $package" ;; esac
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

# need_compiler installs $CC, if it is one of these.
need_compiler() {
    case $CC in
    gcc) need gcc libc6-dev ;;
    clang) need clang libc6-dev ;;
    musl-gcc) need musl-tools ;;
    aarch64-linux-gnu-gcc) need gcc-aarch64-linux-gnu libc6-dev-arm64-cross ;;
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
