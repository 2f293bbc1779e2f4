#!/bin/sh
# SPDX-License-Identifier: MIT
# level: first; packages: python3
# Tests the command line: exit status, messages, and outputs that are complete or absent. bad.sh has command lines that
# are refused, outputs.py each output in a file, a pipe and standard output.
. test/shared/tap.sh
small="--size 40x30 --wavelengths 400:700:50"

# shellcheck disable=SC2086  # $small is a list of words
{
    exits 0 "--version prints versions" "$SPECTRAL" --version
    prints '^spectral [0-9]' "--version prints the program's version"
    prints 'Mesa' "--version prints OSMesa's version"
    prints 'LIBTIFF' "--version prints libtiff's version"
    exits 2 "no command is bad usage" "$SPECTRAL"
    exits 0 "plan works without a picture" "$SPECTRAL" plan patches $small
    prints '^bands +7$' "plan prints the number of bands"
    prints '^  passes +3$' "plan prints the number of passes"
    prints '^specular +no \(no lit material has gloss\)' "plan prints why an effect is not simulated"

    # Outputs.
    exits 0 "render writes a stack" "$SPECTRAL" render patches $small -o "$tmp/a.tif" --quiet
    [ ! -s "$tmp/out" ] && [ ! -s "$tmp/err" ]
    ok $? "--quiet prints nothing"
    exits 0 "a stack is made again" "$SPECTRAL" render patches $small --output="$tmp/b.tif"
    cmp -s "$tmp/a.tif" "$tmp/b.tif"
    ok $? "both stacks have the same bytes"
    exits 0 "the reference's stack is made" \
        "$SPECTRAL" render patches $small --renderer raster --threads 1 -o "$tmp/c.tif"
    cp "$tmp/c.tif" "$tmp/old.tif"
    exits 3 "a full device is a failure of the system" \
        "$SPECTRAL" render patches $small -o /dev/full
    one_line "a full device"
    [ -c /dev/full ]
    ok $? "the device is still a device"
    # A process that is over its limit of a file's size gets SIGXFSZ, and would end without a word.
    mkdir "$tmp/limited"
    for command in "render patches --size 200x200 --renderer raster --no-check -o $tmp/limited/a.tif" \
        "develop $tmp/c.tif -o $tmp/limited/a.tif" "view room --size 200x200 -o $tmp/limited/a.html"; do
        # shellcheck disable=SC2086,SC3045
        (ulimit -S -f 4 && "$SPECTRAL" $command) >"$tmp/out" 2>"$tmp/err"
        [ $? = 3 ] && [ "$(wc -l <"$tmp/err")" = 1 ] && [ -z "$(ls -A "$tmp/limited")" ]
        ok $? "${command%% *}: a limit on the size of files is a failure of the system, and leaves no file"
    done
    # shellcheck disable=SC3045
    (ulimit -S -f 4 && TMPDIR=$tmp/limited "$SPECTRAL" develop "$tmp/c.tif" -o -) >"$tmp/out" 2>"$tmp/err"
    says "error: $tmp/limited: cannot hold [0-9]+ bytes: File too large" "a folder that cannot hold a pipe's copy is named"
    exits 0 "a device's copy needs no folder that takes files" env TMPDIR="$tmp/none" "$SPECTRAL" show d65 -o /dev/null
    exits 0 "a long name gets a temporary file" "$SPECTRAL" show d65 -o "$tmp/$(printf %0250d 0)"
    exits 3 "JSON to a full device is a failure of the system" \
        "$SPECTRAL" render patches $small -o /dev/null --quiet --json /dev/full
    exits 2 "bad input leaves an old output alone" \
        "$SPECTRAL" render patches --size 0x0 -o "$tmp/old.tif"
    cmp -s "$tmp/c.tif" "$tmp/old.tif"
    ok $? "the old output keeps its bytes"
    "$SPECTRAL" plan >/dev/full 2>"$tmp/err"
    [ $? = 3 ]
    ok $? "a full standard output is noticed"
    # A reader that closes the pipe has read what it wanted. `unread` runs the program when nobody reads any more.
    unread() { # STATUS NAME COMMAND...
        expected=$1
        name=$2
        shift 2
        bash -c '{ sleep 0.2; "$@"; } 2>"$0" | :; exit ${PIPESTATUS[0]}' "$tmp/err" "$@"
        status=$?
        [ $status = "$expected" ] && [ ! -s "$tmp/err" ]
        ok $? "$name (exit $expected, no message)"
    }
    unread 0 "a list that nobody reads" "$SPECTRAL" list
    unread 0 "a plan that nobody reads" "$SPECTRAL" plan room
    unread 0 "a built-in file that nobody reads" "$SPECTRAL" show sheep
    unread 0 "a help that nobody reads" "$SPECTRAL" --help
    unread 0 "JSON that nobody reads" "$SPECTRAL" render patches $small -o /dev/null --quiet --json -
    unread 0 "a table that nobody reads" "$SPECTRAL" render patches $small -o "$tmp/unread.tif"
    cmp -s "$tmp/a.tif" "$tmp/unread.tif"
    ok $? "its stack is complete"
    unread 3 "a stack that nobody reads is a failure" "$SPECTRAL" render patches $small -o /dev/stdout --quiet
    unread 3 "a stack to - that nobody reads is a failure" "$SPECTRAL" render patches $small -o - --quiet
    unread 3 "a picture that nobody reads is a failure" "$SPECTRAL" develop "$tmp/a.tif" -o - --quiet
    unread 0 "a page, which is text, that nobody reads" "$SPECTRAL" view patches $small -o - --quiet
    unread 0 "a probe that nobody reads" "$SPECTRAL" probe "$tmp/a.tif" 1 1
    unread 2 "no command, and nobody reads" "$SPECTRAL"
    status=0
    bash -c '"$@" 2>"$0" | head -n 1; exit ${PIPESTATUS[0]}' "$tmp/err" "$SPECTRAL" plan room >"$tmp/out" || status=$?
    [ $status = 0 ] && [ ! -s "$tmp/err" ] && [ "$(wc -l <"$tmp/out")" = 1 ]
    ok $? "plan room | head -n 1 prints a line, and no message"

    "$SPECTRAL" render patches $small -o - 2>"$tmp/err" >"$tmp/piped.tif"
    cmp -s "$tmp/a.tif" "$tmp/piped.tif" && grep -q '^stack  *-$' "$tmp/err" && [ ! -e ./- ]
    ok $? "-o - writes the same bytes to standard output, and no file of that name"

    # JSON.
    exits 0 "render writes its results as JSON" "$SPECTRAL" render patches $small -o "$tmp/j.tif" --json "$tmp/j.json"
    /usr/bin/python3 - "$tmp" >"$tmp/out" 2>"$tmp/err" <<'PYTHON'
import hashlib, json, sys
tmp = sys.argv[1]
report = json.load(open(tmp + "/j.json"))
keys = """program version scene width height wavelengths_nm full_scale renderer gl_renderer gl_version
effects work check seconds peak_bytes output sha256""".split()
assert set(keys) <= set(report), set(keys) - set(report)
check = """samples exact within_1 max_counts rms_counts pixels ambiguous_pixels unexplained_pixels
unbounded_pixels worst_error_over_bound first_unexplained""".split()
assert set(check) <= set(report["check"])
assert report["sha256"] == hashlib.sha256(open(tmp + "/j.tif", "rb").read()).hexdigest()
assert report["check"]["samples"] == 40 * 30 * 7 and report["check"]["pixels"] == 40 * 30
PYTHON
    ok $? "the JSON has every field (work.py has those of effects and work), and the SHA-256 of the stack"
}

# A scene from standard input. Its files are relative to the working folder.
input=$(realpath "$tmp")/input
program=$(realpath "$SPECTRAL")
mkdir "$input"
cp data/builtin/materials/metals/gold.txt "$input"
printf '%s\n' 'size 30 20' 'wavelengths 400 700 50' 'light d65 1 direction 0 0 1' 'material m gold.txt' \
    'object sphere 1 9 9 material m' >"$input/a.scene"
# from FILE STATUS NAME COMMAND...: in the folder, with the file as standard input
from() {
    file=$1
    expected=$2
    name=$3
    shift 3
    status=0
    (cd "$input" && "$@" <"$file") >"$tmp/out" 2>"$tmp/err" || status=$?
    [ $status = "$expected" ]
    ok $? "$name (exit $expected)"
}
from a.scene 0 "render reads a scene from standard input" "$program" render - --renderer raster --no-check --quiet
from a.scene 0 "its default output is scene.tif" test -s "$input/scene.tif"
from a.scene 0 "the scene's file makes a stack" "$program" render a.scene --renderer raster --no-check --quiet -o a.tif
from a.scene 0 "both show the same" "$program" compare a.tif scene.tif
from a.scene 0 "plan reads standard input" "$program" plan -
prints '^scene +<stdin>$' "plan prints that it did"
from a.scene 0 "probe reads standard input" "$program" probe - 15 10
from a.scene 0 "view reads standard input" "$program" view - --quiet
[ -s "$input/scene.html" ]
ok $? "its default output is scene.html"
from a.scene 0 "info prints where the scene came from" "$program" info scene.tif
prints '^scene +<stdin>$' "it was standard input"
from a.scene 2 "such a stack cannot be made again" "$program" render --again scene.tif
says 'its scene was read from standard input' "the message has the reason"
cp "$input/a.scene" "$input/spared.scene"
from spared.scene 2 "the output would replace the file that is standard input" "$program" render - -o spared.scene
cmp -s "$input/a.scene" "$input/spared.scene"
ok $? "the file keeps its bytes"
sed 's/sphere 1/shpere 1/' "$input/a.scene" >"$input/bad.scene"
from bad.scene 2 "a bad scene from standard input is refused" "$program" plan -
says '^<stdin>:5:8: error: ' "the message names the place"
mkfifo "$input/pipe"
echo 'include pipe' >"$input/names.scene"
from a.scene 2 "a pipe that a scene names is refused, and not waited for" timeout 20 "$program" plan names.scene
says '^names.scene:1:9: error: cannot read pipe: it is no regular file' "the message says so"
from a.scene 0 "a pipe that the shell opened is read" sh -c "sed 's/gold.txt/metals\/gold/' | timeout 20 '$program' plan /dev/stdin"
refuses '^<stdin>: error: the file is empty' "an empty standard input is refused" "$SPECTRAL" plan -
"$SPECTRAL" plan - 2>"$tmp/err" <&-
[ $? = 2 ]
ok $? "a closed standard input is refused"
"$SPECTRAL" render "$input/a.scene" --renderer raster --no-check -o "$input/closed.tif" 2>"$tmp/err" >&-
[ $? = 3 ] && [ ! -e "$input/closed.tif" ]
ok $? "a closed standard output, for the table, is a failure of the system, and leaves no stack"

printf '%s\n' "$PWD/data/builtin/materials/colorchecker/01-dark-skin.txt" \
    "$PWD/data/builtin/materials/colorchecker/15-red.txt" >"$tmp/two.list"
exits 0 "a thesis list file is a scene" "$SPECTRAL" plan "$tmp/two.list"
prints '^  materials +3$' "plan counts its materials and the background"
done_testing
