#!/bin/sh
# SPDX-License-Identifier: MIT
# level: first
# Inputs that must be refused. The first line of each file in test/cases/bad gives the place, relative to
# test/cases/bad, and the words of the message:
#   # expect: FILE:LINE:COLUMN: error: WORDS
# A file KIND.cases holds many files that a scene or an option names, each behind such a line with the word FILE.
# commands.cases has command lines, each with its message. What they would write, $none, must not be there.
. test/shared/tap.sh

# is_refused FOLDER EXPECTED WORD...: plan with these words gives one line: the place in that folder, and the expected words
is_refused() {
    folder=$1
    expected=$2
    shift 2
    run "$SPECTRAL" plan "$@"
    [ "$status" = 2 ] && [ "$(wc -l <"$tmp/err")" = 1 ] && [ ! -s "$tmp/out" ] && [ -n "$expected" ] &&
        grep -Fq -- "$folder${expected%%error: *}error: " "$tmp/err" && grep -Fq -- "${expected#*error: }" "$tmp/err"
    ok $? "refused: $expected"
}

for scene in test/cases/bad/*.scene; do
    is_refused test/cases/bad/ "$(sed -n '1s/^# expect: //p' "$scene")" "$scene"
done

# refuses_each KIND WORD...: each file of KIND.cases is refused, as FILE in the scene $scene, or where these words name it
refuses_each() {
    file=$(realpath "$tmp")/$1
    cases=test/cases/bad/$1.cases
    shift
    for i in $(seq "$(grep -c '^# expect: ' "$cases")"); do
        awk -v i="$i" '/^# expect: / { n++; next } n == i' "$cases" >"$file"
        printf '%s\n' "$scene" | sed "s:FILE:$file:" >"$tmp/refused.scene"
        is_refused "$file" "$(sed -n 's/^# expect: FILE//p' "$cases" | sed -n "${i}p")" "$tmp/refused.scene" "$@"
    done
}
scene='material m { diffuse 0.5 }
object mesh FILE material m'
refuses_each meshes
scene='material m { diffuse FILE }
object plane 1 1 material m'
refuses_each tables
scene='material m FILE
object plane 1 1 material m'
refuses_each materials
scene='material m { diffuse 0.6 donaldson FILE }
object plane 1 1 material m
light d65 1 direction 0 0 1'
refuses_each matrices
scene='include patches'
refuses_each detectors --sampling box:2 --detector "$(realpath "$tmp")/detectors"

none=$tmp/none stack=$tmp/stack.tif cut=$tmp/cut.tif dark=$tmp/dark.tif two=$tmp/two.scene empty=$tmp/empty.scene link=$tmp/link even=$tmp/even.scene
ln -s missing "$link"
printf '%s\n' 'light d65 1 direction 0 0 1' 'material m { diffuse 0.5 }' 'object plane 1 1 material m' >"$even"
"$SPECTRAL" render patches --size 60x40 --wavelengths 400:700:100 -q -o "$stack"
"$SPECTRAL" render patches --size 9x9 --wavelengths 600:700:20 --light 1=uv -q -o "$dark"
head -c 9000 "$stack" >"$cut"
printf '%s\n' 'light 1 1 position 0 0 8' 'light 1 1 position 0 0 9' >"$two"
echo 'size 10 10' >"$empty"
while IFS='	' read -r command message; do
    eval "run \"\$SPECTRAL\" $command"
    [ "$status" = 2 ] && [ "$(wc -l <"$tmp/err")" = 1 ] && grep -Fq -- "$message" "$tmp/err" && ! ls "$none"* >/dev/null 2>&1
    ok $? "refused: spectral $command: $message"
done <test/cases/bad/commands.cases
! [ -e ./- ]
ok $? "no command has written a file -"

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
printf '%s\n' 'material m { diffuse 0.5 spectral-texture stack.tif bilinear }' 'object plane 9 9 material m' \
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
printf '%s\n' 'material m { diffuse 0.5 }' 'object plane 9 9 material m' \
    'light 1e200 1e100 direction 0 0 1' >"$tmp/bright.scene"
refuses 'bright\.scene:3:7: error: radiance 1e\+300 cannot be sampled; expected 1e\+290 at most' \
    "a light whose sum overflows, for sampling" "$SPECTRAL" plan "$tmp/bright.scene" --sampling adaptive:0.01
done_testing
