#!/bin/sh
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
# Tests the commands that read stacks: develop, probe, compare and view. bad.sh has command lines that are refused; images.py
# and forged.py have pictures that are no stacks, develop.py and probe.py stacks of other programs; outputs.py
# writes to pipes and full devices, compare.py has tolerances.
. test/shared/tap.sh
small="--size 60x40 --wavelengths 400:700:20"
stack=$tmp/stack.tif

# shellcheck disable=SC2086  # $small is a list of words
"$SPECTRAL" render patches $small -o "$stack" --quiet
# shellcheck disable=SC2086
"$SPECTRAL" render patches $small --light 1=a -o "$tmp/a.tif" --quiet
head -c 30000 "$stack" >"$tmp/cut.tif"
python=/usr/bin/python3

# ---- develop ----

refuses 'wavelength' "develop of pages without wavelengths" "$SPECTRAL" develop data/builtin/textures/dots.tif -o "$tmp/none"
exits 0 "develop accepts --quiet" "$SPECTRAL" develop "$stack" -o "$tmp/seen.tif" --quiet
[ ! -s "$tmp/out" ] && [ ! -s "$tmp/err" ]
ok $? "--quiet prints nothing"
cp "$tmp/seen.tif" "$tmp/kept.tif"
exits 2 "bad input leaves an old picture alone" "$SPECTRAL" develop "$tmp/cut.tif" -o "$tmp/seen.tif"
cmp -s "$tmp/seen.tif" "$tmp/kept.tif"
ok $? "the old picture keeps its bytes"
sed "s,[.][.]/,$PWD/data/builtin/,g" data/builtin/scenes/patches.scene >"$tmp/mine.html" # any file may hold a scene
cp "$tmp/mine.html" "$tmp/kept.html"
refuses 'would replace an input' "a page in the place of its scene" "$SPECTRAL" view "$tmp/mine.html" --size 9x9 -o "$tmp/mine.html"
cmp -s "$tmp/mine.html" "$tmp/kept.html"
ok $? "the scene stays as it was"
exits 0 "a table of three sensitivities is a detector" \
    "$SPECTRAL" develop "$stack" --detector data/builtin/tables/dcs200-camera.csv -o "$tmp/camera.tif"
"$SPECTRAL" develop "$stack" --detector dcs200-camera -o "$tmp/built-in.tif" --quiet
"$python" -c 'import sys, tifffile; a, b = map(tifffile.imread, sys.argv[1:]); sys.exit(int((a != b).any()))' \
    "$tmp/camera.tif" "$tmp/built-in.tif"
ok $? "its picture equals that of the built-in detector"

# ---- probe ----

exits 0 "probe prints a spectrum" "$SPECTRAL" probe "$stack" 5 5
prints 'W sr-1 m-2 nm-1' "probe prints the unit of radiance"
exits 0 "probe prints the spectrum of a region" "$SPECTRAL" probe "$stack" 2 2 4 4 --csv
prints '^"wavelength \(nm\)","radiance' "probe prints a table"

# ---- compare ----

exits 1 "the map is written although they differ" \
    "$SPECTRAL" compare "$stack" "$tmp/a.tif" --map "$tmp/map.tif" --quiet
[ -s "$tmp/map.tif" ]
ok $? "it is there"
exits 1 "stacks are compared under a nearly black white" "$SPECTRAL" compare "$stack" "$tmp/a.tif" --white 1e-290
prints '^CIEDE2000 +[0-9]' "a nearly black white gives finite differences"

# ---- view ----

exits 0 "view writes a page" "$SPECTRAL" view patches --size 60x40 -o "$tmp/page.html"
prints '^page +.*page.html' "view prints the name of the page"
grep -q '<script' "$tmp/page.html" && ! grep -Eq '(src|href)="?(https?:)?//' "$tmp/page.html"
ok $? "the page names no other address"
# The page waits until its pipe is read.
mkfifo "$tmp/pipe"
mkdir "$tmp/waiting"
TMPDIR="$tmp/waiting" "$SPECTRAL" view patches --size 60x40 --threads 3 -o "$tmp/pipe" --quiet &
viewer=$!
sleep 1
kill -TERM "$viewer"
wait "$viewer"
[ $? = 143 ] && [ -z "$(ls -A "$tmp/waiting")" ]
ok $? "a SIGTERM ends a program that waits for the reader of a pipe, and no file is left"
exits 0 "a page may end in .HTM" "$SPECTRAL" view patches --size 60x40 -o "$tmp/page.HTM" --quiet
cmp -s "$tmp/page.HTM" "$tmp/page.html"
ok $? "it is the same page"
exits 0 "view writes a picture" "$SPECTRAL" view patches --size 60x40 -o "$tmp/still.png"
prints '^picture +.*still.png' "view prints the name of the picture"
for words in "" "--exposure auto" "--exposure 0.5"; do
    # shellcheck disable=SC2086  # $words is a list of words
    exits 0 "view writes a picture under a bright lamp, with '$words'" "$SPECTRAL" view patches --light 1=f11 --size 60x40 -o "$tmp/still.png" $words
    prints "^exposure +0[.]$(case $words in *0.5) echo '5$' ;; *) echo '15[0-9]+ [(]auto[)]$' ;; esac)" "its exposure is the automatic one, or that which is asked for"
done
exits 0 "a picture is not limited to 16 megapixels" "$SPECTRAL" view patches --size 5000x4000 --wavelengths 500,600 \
    -o "$tmp/still.png" --quiet
done_testing
