#!/bin/sh
# SPDX-License-Identifier: MIT
# level: full; packages: python3-scipy psychtoolbox-3-common
# The converter makes the 24 ColorChecker materials again from their source; the files must be equal.
. test/run/tap.sh

exits 0 "the converter runs" /usr/bin/python3 test/make/colorchecker.py "$tmp/made"
for material in data/builtin/materials/colorchecker/*.txt; do
    cmp -s "$material" "$tmp/made/colorchecker/$(basename "$material")"
    ok $? "$(basename "$material" .txt) equals its source"
done
[ "$(grep -c '^colorchecker/' data/builtin/materials/colorchecker.list)" = 24 ]
ok $? "the list has 24 patches"
done_testing
