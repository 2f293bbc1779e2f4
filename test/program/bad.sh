#!/bin/sh
# SPDX-License-Identifier: MIT
# level: first
# Inputs that must be refused. The first line of each file in test/cases/bad gives the place, relative to
# test/cases/bad, and the words of the message:
#   # expect: FILE:LINE:COLUMN: error: WORDS
. test/shared/tap.sh

for scene in test/cases/bad/*.scene; do
    expected=$(sed -n '1s/^# expect: //p' "$scene")
    run "$SPECTRAL" plan "$scene"
    [ "$status" = 2 ] && [ "$(wc -l <"$tmp/err")" = 1 ] && [ ! -s "$tmp/out" ] &&
        [ -n "$expected" ] && grep -Fq -- "test/cases/bad/${expected%%error: *}error: " "$tmp/err" &&
        grep -Fq -- "${expected#*error: }" "$tmp/err"
    ok $? "$(basename "$scene" .scene): ${expected#*error: }"
done

printf '%s\n' 'material unused no/such/file.txt' 'material m { diffuse 0.5 }' \
    'object sphere 1 9 9 material m' >"$tmp/unused.scene"
exits 0 "a material that no object uses is not read" "$SPECTRAL" plan "$tmp/unused.scene"

exits 2 "a file that is no texture is refused by render, too" \
    "$SPECTRAL" render test/cases/bad/texture-not-tiff.scene -o "$tmp/none.tif"
one_line "a file that is no texture"
absent "$tmp/none.tif" "a file that is no texture"

# a corner of the square is where the light is
printf '%s\n' 'material m { diffuse 0.5 }' 'object plane 2 2 material m' \
    'light d65 1 position 1 1 0 attenuation 0 0 1' >"$tmp/near.scene"
refuses 'near\.scene:2:1: error: vertex [1-4] of this object reflects no finite radiance' \
    "a light that weakens with distance, at a vertex" "$SPECTRAL" render "$tmp/near.scene" -o "$tmp/near.tif"
absent "$tmp/near.tif" "a light at a vertex"

"$SPECTRAL" render patches --size 4x4 --renderer raster --no-check --quiet -o "$tmp/stack.tif"
printf '%s\n' 'material m { diffuse 0.5 spectral-texture stack.tif }' 'object plane 9 9 material m' \
    'light d65 1 direction 0 0 1' 'size 4 4' >"$tmp/spectral.scene"
for sampling in basis:3 rgb xyz; do
    refuses "spectral\.scene:1:26: error: $sampling " "$sampling takes no spectral texture" \
        "$SPECTRAL" plan "$tmp/spectral.scene" --sampling "$sampling"
done
for sampling in box:3 riemann:50 gauss:3 adaptive:0.01; do
    exits 0 "$sampling takes a spectral texture, by OpenGL and by the reference" \
        "$SPECTRAL" render "$tmp/spectral.scene" --sampling "$sampling" -o /dev/null
done
run "$SPECTRAL" plan "$tmp/spectral.scene" --sampling gauss:3
prints '^texture .*, at the wavelength of each page$' "plan says which wavelengths of the texture are used"
refuses '^--wavelengths:1:1: error: wavelengths from 1000 to 100000 nm' "a range that is too wide to be sampled" \
    "$SPECTRAL" plan "$tmp/spectral.scene" --wavelengths 1000:100000:1000 --sampling gauss:3
printf '%s\n' 'material m { diffuse 0.5 }' 'object plane 9 9 material m' \
    'light 1e200 1e100 direction 0 0 1' >"$tmp/bright.scene"
refuses 'bright\.scene:3:7: error: radiance 1e\+300 cannot be sampled; expected 1e\+290 at most' \
    "a light whose sum overflows, for sampling" "$SPECTRAL" plan "$tmp/bright.scene" --sampling adaptive:0.01
done_testing
