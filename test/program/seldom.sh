#!/bin/sh
# SPDX-License-Identifier: MIT
# level: full
# Messages and lines that are seldom seen: `./build.sh coverage` named those that no other test runs. Each is
# compared with its words. limits.py has those of limits.
. test/shared/tap.sh

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
prints '^bands +2$' "plan prints components"

run "$SPECTRAL" render patches --size 24x16 --wavelengths 400:700:150 -o /dev/null --check-map "$tmp/map.png"
prints '^map colours ' "render says what the colours of a map mean"

run "$SPECTRAL" view patches --size 8x6 -o "$tmp/still.png" --json - -q
prints '"out_of_gamut_pixels": [0-9]' "view counts the pixels of a picture that are out of gamut"
"$SPECTRAL" render patches --size 4x4 --wavelengths 400:700:150 -q -o "$tmp/checked.tif"

# a light so close above the only pixel that the square of its distance is 0
printf '%s\n' 'material m { diffuse 0.5 }' 'object plane 2 2 material m' 'light d65 1 position 0 0 1e-320 attenuation 0 0 1' \
    'camera ortho 2' 'size 1 1' >"$tmp/near.scene"
refuses 'a radiance is not finite' "view of an infinite radiance" \
    "$SPECTRAL" view "$tmp/near.scene" --shading phong -o "$tmp/near.png"
refuses 'a radiance is not finite' "probe of an infinite radiance" \
    "$SPECTRAL" probe "$tmp/near.scene" 0 0 --shading phong
printf '%s\n' 'material m { diffuse 0.5 }' 'object plane 2 2 material m' 'ambient d65 1' 'camera ortho 2' >"$tmp/it's small.scene"
run "$SPECTRAL" cost "$tmp/it's small.scene" --size 4x4 --wavelengths 400:700:100 -j 1
line=$(sed -n 's/^  spectral render \(.*\) -o every-nm.tif$/\1/p' "$tmp/out")
eval "\"\$SPECTRAL\" render $line --json - -q -o /dev/null" >"$tmp/typed.json" && grep -q "it's small" "$tmp/typed.json" &&
    grep -q '"width": 4,' "$tmp/typed.json"
ok $? "a shell reads the command that cost names, with the scene's path and the options: $line"

name=$(printf '%s/a\001\177.scene' "$tmp")
"$SPECTRAL" show patches >"$name"
"$SPECTRAL" render "$name" --size 4x4 --wavelengths 500 -q -o "$tmp/named.tif" --json "$tmp/named.json" &&
    grep -aq 'a??[.]scene' "$tmp/named.tif" && grep -q 'a\\u0001\\u007f[.]scene' "$tmp/named.json"
ok $? "control characters of a name are '?' in the stack, which is XML, and numbers in JSON"

name=$tmp/élan.tif
cp "$tmp/checked.tif" "$name"
run "$SPECTRAL" develop "$name" -o "$tmp/named.tif" -q
grep -aq '/[?][?]lan[.]tif' "$tmp/named.tif"
ok $? "bytes beyond ASCII are '?' in the description of a picture"
{
    printf '%s\n' 'material m { diffuse 0.5 }' 'object plane 2 2 material m' 'camera ortho 2' 'size 8192 1'
    for i in $(seq 70); do echo "light blackbody:$((2000 + i)) 1 position 0 0 $i"; done
} >"$tmp/wide.scene"
run "$SPECTRAL" plan "$tmp/wide.scene"
prints '^  tiles +2$' "a pixel with many terms has narrower tiles"
refuses 'the file has 257 MB; a text file has at most 256 MB' "a pipe that gives too long a text" \
    sh -c 'yes "# a comment" | head -c 268435457 | "$SPECTRAL" plan -'
printf '%s\n' 'material m { diffuse 0.5 }' 'material black { diffuse 0 }' 'object plane 2 2 material m' \
    'object plane 1 1 material black translate 0 0 0.5' 'light e 1 position 0 0 2' 'camera ortho 2' 'size 9 9' >"$tmp/black.scene"
run "$SPECTRAL" render "$tmp/black.scene" --renderer raster --shading phong --wavelengths 500 -o "$tmp/black.tif"
run "$SPECTRAL" info "$tmp/black.tif"
prints '^full scale +0.5$' "an object that reflects no light does not change the full scale"
done_testing
