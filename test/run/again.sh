#!/bin/sh
# SPDX-License-Identifier: MIT
# A stack records how it was made. From that it can be made again, to the last byte, or a message says
# why not.
. test/run/tap.sh
SPECTRAL=$(realpath "$SPECTRAL")
version=$("$SPECTRAL" --version | sed -n 's/^spectral //p')

# changed BYTES FROM TO: a copy with other bytes; negative places count from the end
changed() {
    /usr/bin/python3 -c '
import sys
stack = bytearray(open(sys.argv[1], "rb").read())
exec(sys.argv[3])
open(sys.argv[2], "wb").write(stack)' "$2" "$3" "$1"
}

mkdir -p "$tmp/a folder"
cat >"$tmp/own.scene" <<'SCENE'
include "a folder/more.scene"
wavelengths 400 700 50
size 40 30
camera ortho 4
object sphere 1 20 20 material paint
SCENE
printf 'light d65 1 direction 0 0 1\nmaterial paint { diffuse paint.csv gloss 20 }\n' \
    >"$tmp/a folder/more.scene"
printf '400,0.5\n700,0.7\n' >"$tmp/a folder/paint.csv"
printf '300,1\n760,2\n' >"$tmp/a folder/lamp.csv"
made="$tmp/made.tif"

exits 0 "a stack is made" "$SPECTRAL" render "$tmp/own.scene" --renderer raster --no-check --depth=32f \
    --light "1=$tmp/a folder/lamp.csv*3" --ambient 'd65*0.1' --full-scale 9 -o "$made"
exits 0 "info tells how" "$SPECTRAL" info "$made"
prints '^program +spectral [0-9]' "by which program"
prints "^scene +$tmp/own.scene$" "of which scene"
prints "^scene SHA-256 +$(cat "$tmp/own.scene" "$tmp/a folder/more.scene" | sha256sum | cut -c 1-64)$" \
    "whose text had which SHA-256: the file's, then what it includes"
prints '^option +--depth=32f$' "with which options"
prints "^option +--light=1=$tmp/a folder/lamp.csv\*3$" "blanks in them are kept"
prints '^renderer +raster$' "whose pixels they are"
prints "^light +$tmp/a folder/lamp.csv\*3$" "what it is lit by"
prints '^ambient light +d65\*0.1$' "and around"
prints '^objects +1$' "how many objects it knows"
! grep -q white "$tmp/out"
ok $? "but not all numbers of the white"
prints '^pages +7 of 40 x 30 pixels$' "how many pages"
prints '^full scale +9$' "of what scale"
prints '^scale +radiance = sample W' "and what a sample means"
prints '^verdict +pixels of the reference$' "and what the check said"
! grep -q no-check "$tmp/out"
ok $? "that the reference was not checked does not show"
exits 0 "of one file the SHA-256 is the file's" "$SPECTRAL" render spheres --size 8x8 -o "$tmp/gl.tif"
"$SPECTRAL" info "$tmp/gl.tif" | grep -q "$(sha256sum <data/builtin/scenes/spheres.scene | cut -c 1-64)"
ok $? "built-in ones too"

exits 0 "a stack is made again" "$SPECTRAL" render --again "$made" -o "$tmp/again.tif"
prints "^again +the same bytes as $made$" "and said to be the same"
cmp -s "$made" "$tmp/again.tif"
ok $? "which it is"
(cd "$tmp" && "$SPECTRAL" render --again gl.tif --quiet --threads 1) && [ -f "$tmp/gl-again.tif" ]
ok $? "OpenGL's pixels too, under a name of its own"
exits 0 "unchecked ones too" "$SPECTRAL" render patches --size 8x8 --no-check -o "$tmp/unchecked.tif"
exits 0 "are still unchecked" "$SPECTRAL" render --again "$tmp/unchecked.tif" -o /dev/null
"$SPECTRAL" info "$tmp/unchecked.tif" >"$tmp/out"
! grep -q '^objects' "$tmp/out"
ok $? "and tell no objects: nobody knows what OpenGL shows"

exits 1 "another OpenGL" env GALLIUM_DRIVER=softpipe "$SPECTRAL" render --again "$tmp/gl.tif" -o "$tmp/no.tif"
says 'drawn by llvmpipe.*, this one by softpipe' "is told"
absent "$tmp/no.tif" "another OpenGL"
sed "s/$version/0.0.9/" "$made" >"$tmp/older.tif"
exits 1 "another version" "$SPECTRAL" render --again "$tmp/older.tif" -o "$tmp/no.tif"
says 'made by spectral 0.0.9, but this is spectral' "is told"
absent "$tmp/no.tif" "another version"
exits 1 "with --keep it is drawn all the same" \
    "$SPECTRAL" render --again "$tmp/older.tif" -o "$tmp/newer.tif" --keep
cmp -s "$tmp/newer.tif" "$made"
ok $? "by this version"
changed 'stack[-5 * 40 * 30 + 4 * (40 * 12 + 20)] ^= 1' "$made" "$tmp/flipped.tif"
exits 1 "one bit of one sample" "$SPECTRAL" render --again "$tmp/flipped.tif" -o "$tmp/no.tif"
says 'first at 20,12 of page 7 \(700 nm\)' "is found at its place"
changed 'stack[-1] ^= 1' "$made" "$tmp/mapped.tif"
exits 1 "one bit of the object map" "$SPECTRAL" render --again "$tmp/mapped.tif" -o /dev/null
says 'first at 39,29 of the object map' "is found at its place"
exits 1 "with --keep the new stack is stored" \
    "$SPECTRAL" render --again "$tmp/flipped.tif" -o "$tmp/kept.tif" --keep
cmp -s "$made" "$tmp/kept.tif"
ok $? "and is the good one"
# A stack of 16 bits and many blocks; a bit in its last page, a byte too many and one too few.
exits 0 "a larger stack" "$SPECTRAL" render spheres --size 400x300 --wavelengths 400,500,700 --renderer raster \
    --no-check -o "$tmp/large.tif"
prints '^stack +.*/large.tif$' "is made"
changed 'stack[-3 * 400 * 300 + 2 * (400 * 299 + 398)] ^= 1' "$tmp/large.tif" "$tmp/flipped.tif"
changed 'stack.append(0)' "$tmp/large.tif" "$tmp/longer.tif"
changed 'del stack[-1]' "$tmp/large.tif" "$tmp/shorter.tif"
exits 1 "one bit of one count" "$SPECTRAL" render --again "$tmp/flipped.tif" --no-check -o /dev/null \
    --json "$tmp/again.json"
says 'first at 398,299 of page 3 \(700 nm\)' "is found at its place"
grep -q '"again": {"same": false, "page": 3, "x": 398, "y": 299}' "$tmp/again.json"
ok $? "also in the JSON"
exits 1 "a byte too many" "$SPECTRAL" render --again "$tmp/longer.tif" --no-check -o /dev/null
exits 1 "a byte too few" "$SPECTRAL" render --again "$tmp/shorter.tif" --no-check -o /dev/null
exits 0 "the stack itself" "$SPECTRAL" render --again "$tmp/large.tif" --no-check --json - --quiet -o /dev/null
prints '"again": {"same": true}.*"output": null' "is the same, and nothing is written"
! find . -maxdepth 1 -name '*large*' | grep -q .
ok $? "nor left in this folder"

# A check that failed, and was kept.
exits 1 "a stack that failed its check" env GALLIUM_DRIVER=softpipe "$SPECTRAL" render textures --size 150x100 \
    --wavelengths 500,600 --strict --keep -o "$tmp/failed.tif"
exits 1 "fails again" env GALLIUM_DRIVER=softpipe "$SPECTRAL" render --again "$tmp/failed.tif" -o "$tmp/no.tif"
says 'the pictures differ at' "for the same reason"
prints '^again +the same bytes' "and is the same"
absent "$tmp/no.tif" "a check that failed"

printf '400,0.5\n700,0.71\n' >"$tmp/a folder/paint.csv"
exits 1 "a material that has changed" "$SPECTRAL" render --again "$made" -o "$tmp/no.tif"
absent "$tmp/no.tif" "a material that has changed"
echo '# more' >>"$tmp/a folder/more.scene"
exits 2 "a scene that has changed" "$SPECTRAL" render --again "$made" -o "$tmp/no.tif"
says "the scene has changed since $made was made: expected SHA-256" "is reported before anything is drawn"
changed 'at = stack.index(b"scene_sha256: ") + 77; stack[at] ^= 1' "$tmp/gl.tif" "$tmp/digit.tif"
exits 2 "one digit of the SHA-256" "$SPECTRAL" render --again "$tmp/digit.tif" -o "$tmp/no.tif"
says "the scene has changed since" "counts"
rm "$tmp/own.scene"
exits 2 "a scene that is gone" "$SPECTRAL" render --again "$made" -o "$tmp/no.tif"
says "its scene '$tmp/own.scene' does not exist; a relative name starts from" "is reported, with the folder that names start from"

# A list, the scene that shows it, and names of many kinds.
cp data/builtin/materials/colorchecker/*.txt "$tmp"
(cd "$tmp" && ls ./*.txt | head -n 3) >"$tmp/a <b> & \"c\" 100%.list"
exits 0 "a list of materials" "$SPECTRAL" render "$tmp/a <b> & \"c\" 100%.list" --wavelengths 500,600.5 \
    --size 8x8 -o "$tmp/list.tif"
exits 0 "is told" "$SPECTRAL" info "$tmp/list.tif"
prints '/a <b> & "c" 100%[.]list$' "by its name"
prints '^option +--wavelengths=500,600.5$' "with its wavelengths"
prints '^wavelengths +500 to 600.5 nm$' "which the pages have"
prints "^scene SHA-256 +$(cat "$tmp"/*.list data/builtin/scenes/colorchecker.scene | sha256sum | cut -c 1-64)$" \
    "its text is the list and the scene that shows it"
exits 0 "and made again" "$SPECTRAL" render --again "$tmp/list.tif" -o "$tmp/again.tif"

exits 2 "a scene beside --again" "$SPECTRAL" render patches --again "$tmp/gl.tif"
exits 2 "another size" "$SPECTRAL" render --again "$tmp/gl.tif" --size 4x4
says 'takes no --size=4x4' "is refused by name"
exits 2 "a TIFF file of others" "$SPECTRAL" info data/builtin/textures/bark.tif
says 'has no record of how it was made' "is told to be one"
exits 2 "what is no TIFF file" "$SPECTRAL" render --again README.md
exits 2 "info without a stack" "$SPECTRAL" info
# A record may say nothing but what makes the picture: never where to write.
sed 's/--size=8x8/--json=8x8/' "$tmp/gl.tif" >"$tmp/forged.tif"
exits 2 "a forged record" "$SPECTRAL" render --again "$tmp/forged.tif" -o "$tmp/no.tif"
says "no option '--json'" "cannot set other options"
absent 8x8 "a forged record"
changed 'at = stack.index(b"--size=8x8"); stack[at] = 43' "$tmp/gl.tif" "$tmp/forged.tif"
exits 2 "a word that is no option" "$SPECTRAL" render --again "$tmp/forged.tif" -o "$tmp/no.tif"
says "records '[+]-size=8x8', which is not an option" "is none"
changed 'at = stack.index(b"--size=8x8"); stack[at + 2] = 27' "$tmp/gl.tif" "$tmp/forged.tif"
run "$SPECTRAL" info "$tmp/forged.tif"
prints '^option +--[?]ize=8x8$' "a control character does not reach the terminal"
exits 2 "another check of OpenGL's pixels" "$SPECTRAL" render --again "$tmp/gl.tif" --no-check
exits 2 "what is compiled in" "$SPECTRAL" render --again builtin:textures/picture.tif -o /dev/null
says 'compiled in' "is not compared"
done_testing
