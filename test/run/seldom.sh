#!/bin/sh
# SPDX-License-Identifier: MIT
# Messages and lines that are seldom seen: `./build.sh coverage` named those that no other test runs. Each is
# compared with its words.
. test/run/tap.sh

small='--size 8x6 --wavelengths 400:700:50 --renderer raster --no-check -q'
for sampling in gauss:3 rgb basis:2; do
    # shellcheck disable=SC2086
    "$SPECTRAL" render patches $small --sampling "$sampling" -o "$tmp/$sampling.tif"
    run "$SPECTRAL" info "$tmp/$sampling.tif"
    prints "^sampling +$sampling\$" "info prints the sampling $sampling"
done
prints '^sampled only for +cie1931$' "info prints the only detector of a basis"
prints '^components +of 400 to 700 nm$' "info prints the range of components"
run "$SPECTRAL" info "$tmp/gauss:3.tif"
prints '^sampled for +cie1931$' "info prints the detector of other samplings"
run "$SPECTRAL" plan patches --sampling basis:2
prints '^bands +2 \(components\)$' "plan prints components"

refuses() { # WORDS NAME COMMAND...
    words=$1
    shift
    exits 2 "$@"
    says "$words" "the message: $words"
    one_line "the message: $words"
}
refuses 'envi takes a STACK' "envi without a stack" "$SPECTRAL" envi
refuses 'exclude each other' "probe in two forms" "$SPECTRAL" probe patches 1 1 --csv --svg
refuses '--detector needs --sampling' "a detector without sampling" "$SPECTRAL" plan patches --detector cie1964
refuses 'is a PNG file, not a scene' "a picture as a scene" "$SPECTRAL" plan data/gallery/patches.png
refuses 'cannot draw phong shading' "phong shading by OpenGL" "$SPECTRAL" render patches --shading phong
refuses 'which has no phong shading' "a check of phong shading" \
    "$SPECTRAL" render patches --shading phong --renderer raster --strict

for i in 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33; do
    echo "include $((i + 1)).scene" >"$tmp/$i.scene"
done
echo 'light d65 1 direction 0 0 1' >"$tmp/34.scene"
refuses 'more than 32 deep' "a chain of 34 includes" "$SPECTRAL" plan "$tmp/0.scene"

run "$SPECTRAL" render patches --size 24x16 --wavelengths 400:700:150 -o /dev/null --check-map "$tmp/map.png"
prints '^map colours ' "render says what the colours of a map mean"
done_testing
