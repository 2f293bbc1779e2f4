#!/bin/sh
# SPDX-License-Identifier: MIT
# The reference's stack is the same to the last byte whichever compiler built the program, however
# many threads it has and whether the picture is checked.
# $CLANG is the program built by clang, for another level of optimisation.
. test/tap.sh
CLANG=${CLANG:-build/test/spectral-clang}

for scene in colorchecker spheres patches metamers fluorescence metals textures room pasture; do
    for program in "$SPECTRAL" "$CLANG"; do
        exits 0 "$scene by $program" "$program" render "$scene" --size 300x200 --renderer raster \
            --no-check -o "$tmp/$(basename "$program").tif"
    done
    cmp -s "$tmp/$(basename "$SPECTRAL").tif" "$tmp/$(basename "$CLANG").tif"
    ok $? "$scene: both wrote the same bytes"
    exits 0 "$scene by one thread, checked" "$SPECTRAL" render "$scene" --size 300x200 \
        --renderer raster --threads 1 -o "$tmp/checked.tif"
    cmp -s "$tmp/checked.tif" "$tmp/$(basename "$CLANG").tif"
    ok $? "$scene: one thread and the check change no byte"
done
done_testing
