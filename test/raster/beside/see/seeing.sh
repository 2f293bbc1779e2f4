#!/bin/sh
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
# Tests the commands that read stacks: develop, probe, compare and view. bad.sh has command lines that are refused; images.py
# and test_cube.c have pictures that are no stacks, develop.py and probe.py stacks of other programs.
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
exits 3 "a full device is a failure of the system" "$SPECTRAL" develop "$stack" -o /dev/full
one_line "a full device"
cp "$tmp/seen.tif" "$tmp/kept.tif"
exits 2 "bad input leaves an old picture alone" "$SPECTRAL" develop "$tmp/cut.tif" -o "$tmp/seen.tif"
cmp -s "$tmp/seen.tif" "$tmp/kept.tif"
ok $? "the old picture keeps its bytes"
"$SPECTRAL" develop "$stack" -o /dev/stdout 2>"$tmp/err" | cat >"$tmp/piped.tif"
cmp -s "$tmp/seen.tif" "$tmp/piped.tif"
ok $? "a picture goes through a pipe"
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
exits 0 "probe writes a plot" "$SPECTRAL" probe "$stack" 2 2 4 4 --svg -o "$tmp/plot.svg"
"$SPECTRAL" probe "$stack" 2 2 4 4 --svg -o - | cmp -s - "$tmp/plot.svg"
ok $? "-o - writes the plot to standard output"
"$SPECTRAL" probe "$stack" 5 5 >/dev/full 2>"$tmp/err"
[ $? = 3 ]
ok $? "a full standard output is noticed"

# ---- compare ----

exits 0 "a stack is equal to itself" "$SPECTRAL" compare "$stack" "$stack"
exits 1 "two lights give different stacks" "$SPECTRAL" compare "$stack" "$tmp/a.tif"
one_line "a difference"
exits 0 "they are equal within a tolerance" "$SPECTRAL" compare "$stack" "$tmp/a.tif" --tolerance 200%
exits 1 "they differ beyond a smaller tolerance" "$SPECTRAL" compare "$stack" "$tmp/a.tif" --tolerance 0.1dE00
exits 1 "the map is written although they differ" \
    "$SPECTRAL" compare "$stack" "$tmp/a.tif" --map "$tmp/map.tif" --quiet
"$SPECTRAL" compare "$stack" "$tmp/a.tif" --map /dev/stdout 2>"$tmp/err" | cat >"$tmp/piped.tif"
cmp -s "$tmp/map.tif" "$tmp/piped.tif"
ok $? "the map goes through a pipe"
says '^CIEDE2000 ' "the table then goes to standard error"
exits 1 "stacks are compared under a nearly black white" "$SPECTRAL" compare "$stack" "$tmp/a.tif" --white 1e-290
prints '^CIEDE2000 +[0-9]' "a nearly black white gives finite differences"

# ---- view ----

exits 0 "view writes a page" "$SPECTRAL" view patches --size 60x40 -o "$tmp/page.html"
prints '^page +.*page.html' "view prints the name of the page"
"$SPECTRAL" view patches --size 60x40 -o - 2>"$tmp/err" | cmp -s - "$tmp/page.html"
ok $? "-o - writes the page to standard output"
says '^page +-' "the table then goes to standard error"
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
"$SPECTRAL" view patches --size 60x40 --threads 3 -o "$tmp/pipe" --quiet &
viewer=$!
timeout 300 cat "$tmp/pipe" >"$tmp/piped.html" # a program that fails opens no pipe
wait "$viewer"
ok $? "the page goes through a pipe"
exits 0 "a page may end in .HTM" "$SPECTRAL" view patches --size 60x40 -o "$tmp/page.HTM" --quiet
cmp -s "$tmp/page.HTM" "$tmp/page.html"
ok $? "it is the same page"
exits 0 "view writes a picture" "$SPECTRAL" view patches --size 60x40 -o "$tmp/still.png"
prints '^picture +.*still.png' "view prints the name of the picture"
exits 0 "a picture is not limited to 16 megapixels" "$SPECTRAL" view patches --size 5000x4000 --wavelengths 500,600 \
    -o "$tmp/still.png" --quiet
ln -s /dev/full "$tmp/full.png"
exits 3 "a picture for a full device is a failure of the system" "$SPECTRAL" view patches --size 60x40 -o "$tmp/full.png"
one_line "a picture for a full device"
exits 3 "a page for a full device is a failure of the system" "$SPECTRAL" view patches --size 60x40 -o /dev/full
done_testing
