#!/bin/sh
# SPDX-License-Identifier: MIT
# level: release; packages: busybox
# The shell and the tools of BusyBox, with a compiler, build the program, which draws the bytes of all others (golden_stacks.sh).
. test/shared/tap.sh
. test/builds/golden_stacks.sh
tools=$PWD/$tmp/tools
made=$builds/busybox

mkdir "$tools"
for tool in $(busybox --list); do
    ln -s "$(command -v busybox)" "$tools/$tool"
done
rm -f "$tools"/dpkg* # packages are the system's
for tool in gcc as ld; do
    ln -sf "$(command -v $tool)" "$tools/$tool"
done
exits 0 "BusyBox builds the program" env -i PATH="$tools" HOME="$tmp" BUILD="$made" "$tools/sh" ./build.sh
as_golden 'by BusyBox' $small 2 "$made/spectral"
done_testing
