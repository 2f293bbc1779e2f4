#!/bin/sh
# SPDX-License-Identifier: MIT
# A stack tells how it was made, and can be made again from that, to the last byte, or it is said why
# not.
. test/tap.sh

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
prints '^pages +7 of 40 x 30 pixels$' "how many"
prints '^full scale +9$' "of what scale"
prints '^scale +radiance = sample W' "and what a sample means"
prints '^verdict +pixels of the reference$' "and what the check said"
! grep -q no-check "$tmp/out"
ok $? "that the reference was not checked does not show"
exits 0 "of one file the SHA-256 is the file's" "$SPECTRAL" render spheres --size 8x8 -o "$tmp/gl.tif"
"$SPECTRAL" info "$tmp/gl.tif" | grep -q "$(sha256sum <data/scenes/spheres.scene | cut -c 1-64)"
ok $? "built-in ones too"

exits 0 "a stack is made again" "$SPECTRAL" render --again "$made" -o "$tmp/again.tif"
prints "^again +the same bytes as $made$" "and said to be the same"
cmp -s "$made" "$tmp/again.tif"
ok $? "which it is"
(cd "$tmp" && "$OLDPWD/$SPECTRAL" render --again gl.tif --quiet --threads 1) && [ -f "$tmp/gl-again.tif" ]
ok $? "OpenGL's pixels too, under a name of its own"
exits 0 "unchecked ones too" "$SPECTRAL" render patches --size 8x8 --no-check -o "$tmp/unchecked.tif"
exits 0 "are still unchecked" "$SPECTRAL" render --again "$tmp/unchecked.tif" -o /dev/null

exits 1 "another OpenGL" env GALLIUM_DRIVER=softpipe "$SPECTRAL" render --again "$tmp/gl.tif" -o "$tmp/no.tif"
says 'drawn by llvmpipe.*, this one by softpipe' "is told"
absent "$tmp/no.tif" "another OpenGL"
sed 's/0[.]1[.]0/0.0.9/' "$made" >"$tmp/older.tif"
exits 1 "another version" "$SPECTRAL" render --again "$tmp/older.tif" -o "$tmp/no.tif"
says 'made by spectral 0.0.9, this is spectral' "is told"
/usr/bin/python3 -c '
import sys
stack = bytearray(open(sys.argv[1], "rb").read())
stack[-4 * 40 * 30 + 4 * (40 * 12 + 20)] ^= 1
open(sys.argv[2], "wb").write(stack)' "$made" "$tmp/flipped.tif"
exits 1 "one bit of one sample" "$SPECTRAL" render --again "$tmp/flipped.tif" -o "$tmp/no.tif"
says 'first at 20,12 of page 7 \(700 nm\)' "is found at its place"
exits 1 "with --keep the new stack is stored" \
    "$SPECTRAL" render --again "$tmp/flipped.tif" -o "$tmp/kept.tif" --keep
cmp -s "$made" "$tmp/kept.tif"
ok $? "and is the good one"
printf '400,0.5\n700,0.71\n' >"$tmp/a folder/paint.csv"
exits 1 "a material that has changed" "$SPECTRAL" render --again "$made" -o "$tmp/no.tif"
absent "$tmp/no.tif" "a material that has changed"
echo '# more' >>"$tmp/a folder/more.scene"
exits 2 "a scene that has changed" "$SPECTRAL" render --again "$made" -o "$tmp/no.tif"
says "text is not that of $made: its SHA-256 is" "is told before anything is drawn"
rm "$tmp/own.scene"
exits 2 "a scene that is gone" "$SPECTRAL" render --again "$made" -o "$tmp/no.tif"

exits 2 "a scene beside --again" "$SPECTRAL" render patches --again "$tmp/gl.tif"
exits 2 "another size" "$SPECTRAL" render --again "$tmp/gl.tif" --size 4x4
says 'takes no --size=4x4' "is refused by name"
exits 2 "a TIFF file of others" "$SPECTRAL" info data/textures/bark.tif
says 'does not tell how it was made' "is told to be one"
exits 2 "what is no TIFF file" "$SPECTRAL" render --again README.md
exits 2 "info without a stack" "$SPECTRAL" info
# A record may say nothing but what makes the picture: never where to write.
sed 's/--size=8x8/--json=8x8/' "$tmp/gl.tif" >"$tmp/forged.tif"
exits 2 "a forged record" "$SPECTRAL" render --again "$tmp/forged.tif" -o "$tmp/no.tif"
says "no option '--json'" "cannot set other options"
absent 8x8 "a forged record"
done_testing
