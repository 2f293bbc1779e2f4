# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2038,SC2046,SC2086,SC2154
# The rules of the sources that need no build; build.sh reads this for `check`. It takes some seconds, so it comes first after an edit.
# Version 14 of clang-format made the layout; other versions lay out a few lines otherwise.

# runs WHAT COMMAND... prints what the command says if it fails, and notes that.
runs() {
    what=$1
    shift
    if "$@" >"$said" 2>&1; then
        echo "passed  $what"
    else
        echo "FAILED  $what"
        grep -Ev '^ok |^1\.\.' "$said" | sed 's/^/    /'
        failed=1
    fi
}

# lacking COMMAND PACKAGE prints the package if there is no such command.
lacking() { command -v "$1" >/dev/null || echo "$2"; }

check_layout() { find spectral.[ch] data raster test -name '*.[ch]' | xargs -n 40 -P 4 "$format" --dry-run -Werror; }

check_scripts() { shellcheck -S warning $(grep -rlE '^#!/bin/(ba)?sh|^# shellcheck shell' .ci build.sh data raster test); }

# Sets $format.
find_format() {
    format=clang-format-14
    [ -z "$(lacking $format clang-format)" ] || format=clang-format
}

check() {
    failed=0
    said=$(mktemp)
    find_format
    packages=$(lacking $format clang-format; lacking shellcheck shellcheck; lacking python3 python3)
    [ -z "$packages" ] || refuse "build.sh: packages are missing; type: sudo apt-get install $(echo $packages)"
    case $($format --version) in
    *'version 14.'*) ;;
    *) refuse "build.sh: the layout is that of clang-format 14; type: sudo apt-get install clang-format-14" ;;
    esac
    runs "layout (to mend: $format -i FILE)" check_layout
    runs 'scripts (shellcheck)' check_scripts
    runs 'rules of the sources (test/program/house.py)' /usr/bin/python3 -B test/program/house.py
    runs 'plain English (test/documents/english.py)' env PYTHONPATH=test/shared /usr/bin/python3 -B test/documents/english.py
    rm "$said"
    return $failed
}
