#!/bin/sh
# SPDX-License-Identifier: MIT
# level: full; packages: libosmesa6-dev
# The bench measures every ratio that has a goal. Its figures are not judged here: the pictures are small.
. test/shared/tap.sh

exits 0 'the bench of small pictures ends well' ./build.sh bench quick --csv "$tmp/ratios.csv"
[ "$(cut -d , -f 1 "$tmp/ratios.csv" | grep -x '[a-k]' | sort -u | tr -d '\n')" = abcdefghik ]
ok $? 'each row of the table has a ratio'
for part in gl raster check write; do
    grep -q "render, checked: $part\",s," "$tmp/ratios.csv"
    ok $? "the seconds of a render's part are measured: $part"
done
done_testing
