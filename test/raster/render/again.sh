#!/bin/sh
# SPDX-License-Identifier: MIT
# level: full; packages: python3
# A stack records how it was made. The program can make it again from this record, to the last byte, or says
# why not.
. test/shared/tap.sh
SPECTRAL=$(realpath "$SPECTRAL")
version=$("$SPECTRAL" --version | sed -n 's/^spectral //p')

# changed CODE FROM TO: a copy with other bytes; negative places count from the end
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
mkfifo "$tmp/pipe.csv"
printf 'light d65 1 direction 0 0 1\nmaterial m { diffuse 0.5 }\nobject sphere 1 9 9 material m\n' >"$tmp/pipe.scene"
cat "$tmp/a folder/paint.csv" >"$tmp/pipe.csv" & # once: a second read would wait for ever
exits 0 "a table comes through a pipe" timeout 60 "$SPECTRAL" render "$tmp/pipe.scene" --light "1=$tmp/pipe.csv" --size 9x9 --renderer raster --no-check -o "$tmp/pipe.tif"
run "$SPECTRAL" info "$tmp/pipe.tif"
prints "^file +$(sha256sum <"$tmp/a folder/paint.csv" | cut -c 1-64) $tmp/pipe.csv$" "its digest is that of the bytes that were read"
exits 0 "info prints how it was made" "$SPECTRAL" info "$made"
prints '^program +spectral [0-9]' "info prints the program"
prints "^scene +$tmp/own.scene$" "info prints the scene"
prints "^scene sha256 +$(cat "$tmp/own.scene" "$tmp/a folder/more.scene" | sha256sum | cut -c 1-64)$" \
    "info prints the SHA-256 of the scene's text, with the text of included files after it"
prints '^option +--depth=32f$' "info prints the options"
prints "^option +--light=1=$tmp/a folder/lamp.csv\*3$" "info keeps blanks in options"
prints '^renderer +raster$' "info prints the renderer"
prints "^light +$tmp/a folder/lamp.csv\*3$" "info prints the light"
prints '^ambient light +d65\*0.1$' "info prints the ambient light"
prints '^objects +1$' "info prints the number of objects"
! grep -q white "$tmp/out"
ok $? "info does not print the numbers of the white"
prints '^pages +7$' "info prints the number of pages"
prints '^full scale +9$' "info prints the full scale"
prints '^scale +radiance = sample W' "info prints the meaning of a sample"
prints '^verdict +pixels of the reference$' "info prints the verdict of the check"
! grep -q no-check "$tmp/out"
ok $? "info does not mention that the reference was not checked"
exits 0 "a stack of a scene in one file is made" "$SPECTRAL" render spheres --size 8x8 -o "$tmp/gl.tif"
"$SPECTRAL" info "$tmp/gl.tif" | grep -q "$(sha256sum <data/builtin/scenes/spheres.scene | cut -c 1-64)"
ok $? "the SHA-256 of a built-in scene in one file is the file's"

exits 0 "a stack is made again" "$SPECTRAL" render --again "$made" -o "$tmp/again.tif"
prints "^again +the same bytes as $made$" "the program says that the bytes are the same"
cmp -s "$made" "$tmp/again.tif"
ok $? "the bytes are the same"
for ending in tif png; do
    exits 0 "a stack is made again with a map of its check" \
        "$SPECTRAL" render --again "$made" -o /dev/null --check-map "$tmp/map.$ending" --quiet
    [ -s "$tmp/map.$ending" ]
    ok $? "the map is written: $ending"
done
(cd "$tmp" && "$SPECTRAL" render --again gl.tif --quiet --threads 1) && [ -f "$tmp/gl-again.tif" ]
ok $? "OpenGL's pixels are made again, under a name of their own"
exits 0 "an unchecked stack is made" "$SPECTRAL" render patches --size 8x8 --no-check -o "$tmp/unchecked.tif"
exits 0 "an unchecked stack is made again" "$SPECTRAL" render --again "$tmp/unchecked.tif" -o /dev/null
"$SPECTRAL" info "$tmp/unchecked.tif" >"$tmp/out"
! grep -q '^objects' "$tmp/out"
ok $? "an unchecked stack has no objects, since nobody knows OpenGL's"

exits 1 "another OpenGL differs" env GALLIUM_DRIVER=softpipe "$SPECTRAL" render --again "$tmp/gl.tif" -o "$tmp/no.tif"
says 'drawn by llvmpipe.*, this one by softpipe' "the message names both drivers"
absent "$tmp/no.tif" "another OpenGL"
sed "s/$version/0.0.9/" "$made" >"$tmp/older.tif"
exits 1 "a stack of another version differs" "$SPECTRAL" render --again "$tmp/older.tif" -o "$tmp/no.tif"
says 'made by spectral 0.0.9, but this is spectral' "the message names both versions"
absent "$tmp/no.tif" "another version"
exits 1 "with --keep the stack is drawn in spite of that" \
    "$SPECTRAL" render --again "$tmp/older.tif" -o "$tmp/newer.tif" --keep
cmp -s "$tmp/newer.tif" "$made"
ok $? "the kept stack is of this version"
changed 'stack[-5 * 40 * 30 + 4 * (40 * 12 + 20)] ^= 1' "$made" "$tmp/flipped.tif"
exits 1 "one bit of one sample differs" "$SPECTRAL" render --again "$tmp/flipped.tif" -o "$tmp/no.tif"
says 'first at 20,12 of page 7 \(700 nm\)' "the message names the place of the bit"
changed 'stack[-1] ^= 1' "$made" "$tmp/mapped.tif"
exits 1 "one bit of the object map differs" "$SPECTRAL" render --again "$tmp/mapped.tif" -o /dev/null
says 'first at 39,29 of the object map' "the message names the place in the object map"
exits 1 "with --keep the new stack is stored" \
    "$SPECTRAL" render --again "$tmp/flipped.tif" -o "$tmp/kept.tif" --keep
cmp -s "$made" "$tmp/kept.tif"
ok $? "the stored stack is the right one"
# A stack of 16 bits and many blocks; a bit in its last page, a byte too many and one too few.
exits 0 "a larger stack is made" "$SPECTRAL" render spheres --size 400x300 --wavelengths 400,500,700 --renderer raster \
    --no-check -o "$tmp/large.tif"
prints '^stack +.*/large.tif$' "the table names the larger stack"
changed 'stack[-3 * 400 * 300 + 2 * (400 * 299 + 398)] ^= 1' "$tmp/large.tif" "$tmp/flipped.tif"
changed 'stack.append(0)' "$tmp/large.tif" "$tmp/longer.tif"
changed 'del stack[-1]' "$tmp/large.tif" "$tmp/shorter.tif"
exits 1 "one bit of one count differs" "$SPECTRAL" render --again "$tmp/flipped.tif" --no-check -o /dev/null \
    --json "$tmp/again.json"
says 'first at 398,299 of page 3 \(700 nm\)' "the message names the place of the bit"
grep -q '"again": {"same": false, "page": 3, "x": 398, "y": 299}' "$tmp/again.json"
ok $? "the JSON has the place of the bit"
exits 1 "a stack with an extra byte differs" "$SPECTRAL" render --again "$tmp/longer.tif" --no-check -o /dev/null
exits 1 "a stack without its last byte differs" "$SPECTRAL" render --again "$tmp/shorter.tif" --no-check -o /dev/null
exits 0 "the larger stack is made again" "$SPECTRAL" render --again "$tmp/large.tif" --no-check --json - --quiet -o /dev/null
prints '"again": {"same": true}.*"output": null' "the JSON says that it is the same, and that no output is written"
! find . -maxdepth 1 -name '*large*' | grep -q .
ok $? "no output is left in this folder"

# A stack that failed its check and was kept.
exits 1 "a stack fails its check" env GALLIUM_DRIVER=softpipe "$SPECTRAL" render textures --size 150x100 \
    --wavelengths 500,600 --strict --keep -o "$tmp/failed.tif"
exits 1 "the stack fails its check again" env GALLIUM_DRIVER=softpipe "$SPECTRAL" render --again "$tmp/failed.tif" -o "$tmp/no.tif"
says 'the pictures differ at' "the check fails for the same reason"
prints '^again +the same bytes' "the failed stack has the same bytes"
absent "$tmp/no.tif" "a check that failed"

printf '400,0.5\n700,0.71\n' >"$tmp/a folder/paint.csv"
refuses "paint.csv has changed since the stack was made: expected SHA-256" "a stack with a changed material is refused" "$SPECTRAL" render --again "$made" -o "$tmp/no.tif"
absent "$tmp/no.tif" "a material that has changed"
echo '# more' >>"$tmp/a folder/more.scene"
refuses "the scene has changed since $made was made: expected SHA-256" "a changed scene is refused" "$SPECTRAL" render --again "$made" -o "$tmp/no.tif"
changed 'at = stack.index(b"scene_sha256: ") + 77; stack[at] ^= 1' "$tmp/gl.tif" "$tmp/digit.tif"
refuses "the scene has changed since" "a changed digit of the SHA-256 is refused" "$SPECTRAL" render --again "$tmp/digit.tif" -o "$tmp/no.tif"
rm "$tmp/own.scene"
refuses "its scene '$tmp/own.scene' does not exist; a relative name starts from" "a missing scene is refused" "$SPECTRAL" render --again "$made" -o "$tmp/no.tif"

# A list of materials, the scene that shows it, and a name with many kinds of characters.
cp data/builtin/materials/colorchecker/*.txt "$tmp"
(cd "$tmp" && ls ./*.txt | head -n 3) >"$tmp/a <b> & \"c\" 100%.list"
exits 0 "a list of materials is rendered" "$SPECTRAL" render "$tmp/a <b> & \"c\" 100%.list" --wavelengths 500,600.5 \
    --size 8x8 -o "$tmp/list.tif"
exits 0 "info prints the stack of a list" "$SPECTRAL" info "$tmp/list.tif"
prints '/a <b> & "c" 100%[.]list$' "info prints the name of the list"
prints '^option +--wavelengths=500,600.5$' "info prints the option of wavelengths"
prints '^wavelengths nm +500 to 600.5$' "info prints the wavelengths of the pages"
prints "^scene sha256 +$(cat "$tmp"/*.list data/builtin/scenes/colorchecker.scene | sha256sum | cut -c 1-64)$" \
    "the SHA-256 is that of the list and of the scene that shows it"
exits 0 "the stack of a list is made again" "$SPECTRAL" render --again "$tmp/list.tif" -o "$tmp/again.tif"

# A record may contain only options that make the picture, never a place to write to.
sed 's/--size=8x8/--json=8x8/' "$tmp/gl.tif" >"$tmp/forged.tif"
refuses "no option '--json'" "a forged record is refused" "$SPECTRAL" render --again "$tmp/forged.tif" -o "$tmp/no.tif"
absent 8x8 "a forged record"
changed 'at = stack.index(b"--size=8x8"); stack[at] = 43' "$tmp/gl.tif" "$tmp/forged.tif"
refuses "records '[+]-size=8x8', which is not an option" "a word that is no option is refused" "$SPECTRAL" render --again "$tmp/forged.tif" -o "$tmp/no.tif"
changed 'at = stack.index(b"--size=8x8"); stack[at + 2] = 27' "$tmp/gl.tif" "$tmp/forged.tif"
run "$SPECTRAL" info "$tmp/forged.tif"
prints '^option +--[?]ize=8x8$' "a control character does not reach the terminal"

# The link from the first page to the second one is damaged: for libtiff the file ends there.
changed 'at = int.from_bytes(stack[4:8], "little"); at += 2 + 12 * int.from_bytes(stack[at:at + 2], "little"); stack[at:at + 4] = bytes(4)' \
    "$tmp/gl.tif" "$tmp/lost.tif"
for command in "develop $tmp/lost.tif -o $tmp/lost.png" "probe $tmp/lost.tif 1 1" "info $tmp/lost.tif" \
    "compare $tmp/lost.tif $tmp/lost.tif"; do
    # shellcheck disable=SC2086
    exits 2 "${command%% *}: a stack that has lost pages is refused" "$SPECTRAL" $command
    says 'it has 1 pages, but records [0-9]+; it was cut or damaged' "the message has both numbers of pages"
done
absent "$tmp/lost.png" "a stack that has lost pages"

# The stack of a stranger may name any file.
mkdir "$tmp/here"
printf '%s\n' 'include "a folder/more.scene"' 'wavelengths 500 600 50' 'size 8 8' 'object sphere 1 9 9 material paint' >"$tmp/own.scene"
cp "$tmp/own.scene" "$tmp/here/own.scene"
cp -r "$tmp/a folder" "$tmp/here"
here() { # COMMAND... in that folder
    (cd "$tmp/here" && timeout 10 "$SPECTRAL" "$@" >out 2>err)
}
here render own.scene --renderer raster --no-check -o made.tif
ok $? "a stack of a relative name is made"
here render --again made.tif -o again.tif
ok $? "it is made again in that folder"
here render "$(realpath "$tmp/own.scene")" --renderer raster --no-check -o outside.tif &&
    here render own.scene --light '1=../a folder/lamp.csv' --renderer raster --no-check -o lamp.tif &&
    { echo nm,x,y,z && seq -f '%g,1,2,1' 400 10 700; } >"$tmp/a folder/eye.csv" &&
    here render own.scene --sampling gauss:2 --observer '../a folder/eye.csv' --renderer raster --no-check -o observer.tif
ok $? "stacks of files outside of the folder are made"
# Older programs recorded this option by the name that was typed.
changed 'at = stack.index(b"--detector="); stack[at:at + 11] = b"--observer="' "$tmp/here/observer.tif" "$tmp/here/older.tif"
spared() { # STACK PATTERN NAME: this stack is not made again, with these words
    here render --again "$1" -o refused.tif
    [ $? = 2 ] && grep -q "$2" "$tmp/here/err" && [ ! -e "$tmp/here/refused.tif" ]
    ok $? "$3"
}
spared older.tif 'eye.csv, which is no file below this folder' "a file that --observer names is refused, too"
for stack in outside lamp observer; do
    spared $stack.tif 'names .*, which is no file below this folder; --trust reads it' \
        "$stack: a stack that names a file outside of the folder is refused"
    here render --again $stack.tif -o trusted.tif --trust
    ok $? "$stack: --trust makes it again"
done
here render builtin:scenes/patches.scene --size 8x8 --light 1=builtin:tables/a.csv --renderer raster --no-check -o builtin.tif
ok $? "a stack of built-in files, by their paths, is made"
here render --again builtin.tif -o builtin-again.tif
ok $? "it is made again: built-in files need no --trust"
ln -sf "$(realpath "$tmp/own.scene")" "$tmp/here/own.scene"
spared made.tif 'no file below this folder' "a link out of the folder is refused"
rm "$tmp/here/own.scene"
mkfifo "$tmp/here/own.scene"
spared made.tif 'no file below this folder' "a pipe is refused, and not waited for"
rm "$tmp/here/own.scene"
echo 'root:secret:0' >"$tmp/here/own.scene"
spared made.tif '^own.scene:1:1: error: this input is not what it was' "another text is refused"
! grep -q 'secret' "$tmp/here/err"
ok $? "the message does not quote the file that a stack names"
done_testing
