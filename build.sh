#!/bin/sh
# SPDX-License-Identifier: MIT
# usage: ./build.sh [COMMAND]
#   build                  makes the program, build/spectral; the same without a COMMAND
#   run                    makes it, and with it colorchecker.tif, colorchecker.png and colorchecker.html
#   check                  looks at layout, scripts, rules and English of the sources, without a build: some seconds
#   test [NAME...]         runs the first level of the tests, some minutes, or those named, such as test_text or cli
#   test full [NAME...]    runs all tests of the code in C, the longer ones too: an hour
#   test release [NAME...]  runs tests with browsers, containers, other systems and other programs, and soaks: hours
#   fuzz [SECONDS] [TARGET...]  changes inputs of readers at random, so long for each target (60 seconds)
#   sanitize               unit tests and all commands under the sanitizers of clang, and under valgrind
#   coverage               prints the lines that no test runs
#   bench [quick] [--csv FILE]  measures all ratios that the program has goals for; quick: of small pictures
#   bench effects          measures the seconds of each effect
#   live                   makes build/spectral-live, whose pages hold the program, so that they draw a changed scene
#   live install PREFIX    installs that one
#   minimal                makes build/spectral-minimal, for small systems: render with its check, plan, info, list, show,
#                          join and envi, by OSMesa, with -Os and packed built-in files
#   static                 makes build/spectral-static, which needs nothing but a Linux kernel
#   dist                   makes a release archive around the static program
#   install PREFIX         copies program, manual, samples, ... below PREFIX (below DESTDIR, where that is set)
#   uninstall PREFIX       removes what install wrote there, and nothing else
#   clean                  deletes the folder build
# From the environment: CC (gcc), CFLAGS (-O3), CPPFLAGS, LDFLAGS, GL (osmesa, or none: without OpenGL), TIER (full,
# or minimal, also for static), BUILD (build; the folder for all that is made). On Debian, root installs the packages that are missing.

# Other scripts have the libraries (data/libraries.sh), the files that are compiled in (data/builtin.sh),
# install and uninstall (data/install.sh), the program in live pages (data/wasi/wasm.sh), the static program and
# the release (raster/gl/static.sh), the tests (test/run.sh, test/fuzz/fuzz.sh, test/sanitize.sh, test/coverage.sh). Lists are split on purpose.
# shellcheck disable=SC1091,SC2015,SC2016,SC2030,SC2031,SC2034,SC2046,SC2086,SC2154
set -eu
export LC_ALL=C
called_from=$PWD
cd "$(dirname "$0")"
: "${CC:=gcc}" "${CPPFLAGS=}" "${LDFLAGS=}" "${GL:=osmesa}" "${TIER:=full}" "${BUILD:=build}"
[ "$*" != minimal ] || TIER=minimal
[ "$TIER" = full ] || small='-Os -ffunction-sections -fdata-sections -fno-asynchronous-unwind-tables'
: "${CFLAGS:=${small:--O3}}"
# These come after $CFLAGS, which may ask for arithmetic that changes pictures. No floating-point traps
# are taken and no errno is read after sqrt: both let loops be done several samples at once and change
# no result.
language='-std=c99 -D_XOPEN_SOURCE=700 -D_FILE_OFFSET_BITS=64 -I. -fno-associative-math
  -fno-reciprocal-math -fsigned-zeros -fno-finite-math-only -ffp-contract=off -fno-trapping-math
  -fno-math-errno'
# A number that an enumeration names is an int, which a double holds exactly; clang 21 warns of it, and clang 9 of the option.
warnings='-pedantic -Wall -Wextra -Wshadow -Wconversion -Wdouble-promotion -Wstrict-prototypes
  -Wmissing-prototypes -Wundef -Wvla -Wcast-qual -Wwrite-strings -Wno-unknown-warning-option
  -Wno-enum-float-conversion'
hardening='-fstack-protector-strong -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2'
hardened_link='-Wl,-z,relro,-z,now,-z,noexecstack'
threads=-pthread
mark='made-by-build.sh' # a file in each folder that `clean` may delete
parts=                # packages that become part of the program, with their versions
kind=                 # -live: the program with live pages; -minimal: the minimal one

usage() { sed -n '3,/^$/s/^# \{0,1\}//p' build.sh; }
refuse() { echo "${1:-$(usage)}" >&2; exit 2; }
. data/libraries.sh
. data/builtin.sh
. data/wasi/wasm.sh
if [ "$TIER" != full ]; then
    kind=-minimal LDFLAGS="$LDFLAGS -Wl,--gc-sections"
    minimal_builtin
fi

# Makes and marks $BUILD. A folder that held other files before is not marked.
make_folder() {
    case $BUILD in *[[:space:]]*) refuse "build.sh: BUILD='$BUILD' has blanks; name another folder" ;; esac
    case $CFLAGS in *-Ofast* | *-ffast-math* | *-funsafe-math*) refuse "build.sh: $CFLAGS changes pictures; -O3 does not" ;; esac
    mkdir -p "$BUILD"
    [ "$BUILD" != build ] && [ -n "$(ls -A "$BUILD")" ] || : >"$BUILD/$mark"
}

prepare() {
    make_folder
    need $(compiler_packages)
    round_sums
    [ "$kind" != -live ] || add_module
    make_builtin
}

# Sets $sources for $GL and $TIER; spectral.c, which has main, is the first. The tables in raster/beside
# list what a program contains of the rooms in that folder, which the core does not know.
find_sources() {
    rooms='data raster/reference raster/visibility raster/renderers raster/plan raster/bounds raster/volumes raster/candidates raster/counts raster/check raster/render'
    all='raster/beside/colour raster/beside/accuracy raster/beside/measure raster/beside/verify raster/beside/see raster/beside/cost raster/beside/view'
    commands=commands ways=ways
    without='/no_[a-z]*[.]c$'
    case $GL in
    osmesa) rooms="$rooms raster/gl" all="$all raster/beside/shader" ;;
    none) commands=commands_no_gl ways=ways_none without="$without|^raster/beside/(measure|verify)/(command|tables|expect)[.]c" ;;
    *) refuse "build.sh: GL is osmesa or none, not '$GL'" ;;
    esac
    case $TIER in
    full) rooms="$rooms $all" ;;
    minimal) commands=commands_minimal && [ "$GL" = none ] || ways=ways_minimal ;;
    *) refuse "build.sh: TIER is full or minimal, not '$TIER'" ;;
    esac
    sources="spectral.c $(find $rooms -name '*.c' ! -path 'data/samples/*' | grep -Ev "$without" | sort)
        raster/beside/$commands.c raster/beside/$ways.c"
}

# stamp FILE TEXT writes the file, unless it holds the text already.
stamp() { [ "$(cat "$1" 2>/dev/null)" = "$2" ] || printf '%s\n' "$2" >"$1"; }

# is_fresh OBJECT: the command, the source and its headers are older than the start of its making.
is_fresh() {
    [ -f "$1" ] && read -r _ needs <"$1.needs" &&
        [ -z "$(find $needs "$tree/made-with" -newer "$1.start" 2>&1)" ]
}

# compile TREE OPTIONS SOURCE... sets $objects. They lie below $BUILD/TREE as the sources lie below this
# folder, and those that are not fresh are made anew. An object has its name only when it is whole. After
# an error no other file is begun.
compile() {
    tree=$BUILD/$1
    command="$CC $warnings $CPPFLAGS $2 $language $threads"
    shift 2
    mkdir -p "$tree"
    stamp "$tree/made-with" "$command $($CC --version | head -n 1) $parts"
    objects='' stale=''
    for source; do
        object=${source#"$BUILD/"}
        object=$tree/${object%.c}.o
        objects="$objects $object"
        is_fresh "$object" || stale="$stale $source $object"
    done
    [ -n "$stale" ] || return 0
    echo "compiling $(($(echo $stale | wc -w) / 2)) of $# files with $CC"
    rm -f "$tree/failed" "$tree/compiled"
    export tree command
    printf '%s\n' $stale | xargs -P "$(nproc || echo 1)" -n 2 sh -c '
        [ ! -f "$tree/failed" ] && mkdir -p "${2%/*}" && rm -f "$2" && : >"$2.start" &&
            $command -MMD -MF "$2.d" -MT object -c "$1" -o "$2.new" &&
            { tr -d "\\\\\n" <"$2.d" && echo; } >"$2.needs" && mv "$2.new" "$2" ||
            { : >"$tree/failed"; exit 1; }
        [ ! -t 1 ] || { echo >>"$tree/compiled"; printf "%d\\r" $(wc -l <"$tree/compiled"); }' compile || exit 1
}

# link PROGRAM OBJECT... below $BUILD, unless it is newer than all of them
link() {
    program=$BUILD/$1
    shift
    stamp "$program.made-with" "$CC $CFLAGS $threads $LDFLAGS $* $libraries $parts"
    if [ ! -x "$program" ] || [ -n "$(find "$@" "$program.made-with" -newer "$program")" ]; then
        echo "building $program"
        $CC $CFLAGS $threads $LDFLAGS "$@" -o "$program.new" $libraries
        mv "$program.new" "$program"
    fi
}

# For editors: the last command for each source, as JSON.
list_commands() {
    export command PWD
    printf '%s\n' $sources | awk '
        function json(text) { gsub(/[\\"]/, "\\\\&", text); return "\"" text "\"" }
        BEGIN { n = split(ENVIRON["command"], word); for (i = 1; i <= n; i++) words = words json(word[i]) ", " }
        { printf "%s\n{\"directory\": %s, \"file\": %s, \"arguments\": [%s\"-c\", %s]}", (NR == 1 ? "[" : ","),
            json(ENVIRON["PWD"]), json($0), words, json($0) }
        END { print "\n]" }' >"$BUILD/compile_commands.json"
}

# Code without optimization has no fortified calls.
harden() {
    case $CFLAGS in *-O[123s]*) CFLAGS="$CFLAGS $hardening" ;; esac
    case $libraries in *-static*) ;; *) CFLAGS="$CFLAGS -fPIE" libraries="-pie $hardened_link $libraries" ;; esac
}

build() {
    make_folder
    need $(compiler_packages) $(library_packages)
    prepare
    find_sources
    find_libraries
    check_versions
    harden
    compile "obj${small:+-minimal}" "$CFLAGS" $sources "$BUILD/$builtin"
    [ -n "${small:-}" ] || list_commands
    link "spectral$kind" $objects
}

# The first picture of a new user: a stack, what a person sees, and a page for the browser.
first_minute() {
    for command in 'render colorchecker --size 600x400' 'develop colorchecker.tif -q' 'view colorchecker --size 600x400 -q'; do
        echo "\$ $BUILD/spectral $command"
        "$BUILD/spectral" $command
    done
    cat <<END

Look at them:  $PWD/colorchecker.png
               $PWD/colorchecker.html
               $PWD/colorchecker.tif  (a page a wavelength)
Try next:      $BUILD/spectral probe colorchecker.tif 100 100
               $BUILD/spectral show spheres -o my.scene && $BUILD/spectral view my.scene -o my.png
END
}

clean() {
    [ ! -e "$BUILD" ] || [ -f "$BUILD/$mark" ] || refuse "build.sh: $BUILD held other files before; delete it yourself"
    rm -rf "$BUILD"
}

case "$*" in live | 'live install '?*) kind=-live && shift ;; minimal) shift ;; esac
case "${*:-build}" in
build) build ;;
run) build; first_minute ;;
test | 'test '* | bench | 'bench '*) . test/run.sh ;;
fuzz | 'fuzz '*) . test/fuzz/fuzz.sh; shift; fuzz "$@" ;;
check) . test/check.sh; check ;;
sanitize) . test/sanitize.sh; sanitize ;;
coverage) . test/coverage.sh; coverage ;;
static) . raster/gl/static.sh; static_program ;;
dist) . raster/gl/static.sh; dist ;;
'install '?*) [ $# = 2 ] || refuse; build; . data/install.sh; install_program "$2" ;;
'uninstall '?*) [ $# = 2 ] || refuse; . data/install.sh; uninstall_program "$2" ;;
clean) clean ;;
-h | --help) usage ;;
*) refuse ;;
esac
