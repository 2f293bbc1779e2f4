#!/bin/sh
# SPDX-License-Identifier: MIT
# level: first; packages: python3 mandoc bsdextrautils
# usage: test/documents/manual.sh [renew]
# The manual pages are well-formed; spectral(1) describes each option, command and list of the program, spectral(5) its
# files. The list of options equals that of --help; renew writes this list into the page and keeps the page's own explanations.
. test/shared/tap.sh
renewed_page() { /usr/bin/python3 test/documents/manual_options.py "$SPECTRAL" spectral.1; }
if [ "${1:-}" = renew ]; then
    renewed_page >"$tmp/page" && cat "$tmp/page" >spectral.1
    exit
fi

exits 0 "the manual pages have no fault" mandoc -Tlint spectral.1 spectral.5
renewed_page | diff spectral.1 - >"$tmp/err"
ok $? "the page lists the options of --help; test/documents/manual.sh renew renews the list"
mandoc -Tascii spectral.1 | col -bx >"$tmp/page"
exits 0 "--help prints the usage" "$SPECTRAL" --help
prints '^usage: ' "the usage is on standard output"
options() { grep -Eo -- '(^|[ ,=])--?[a-z][a-z-]*' "$1" | tr -d ' ,=' | LC_ALL=C sort -u; }
[ "$(wc -l <"$tmp/out")" -le 40 ]
ok $? "it fits a screen of 40 lines"
commands=$(sed -n 's/^  \([a-z]*\) .*/\1/p' "$tmp/out")
for command in $commands; do "$SPECTRAL" "$command" --help; done >>"$tmp/out"
options "$tmp/out" >"$tmp/printed"
options "$tmp/page" >"$tmp/documented"
[ "$(wc -l <"$tmp/printed")" -gt 15 ]
ok $? "--help lists many options"
diff "$tmp/printed" "$tmp/documented" >"$tmp/err"
ok $? "the manual has these options and no others"
for command in $commands; do
    grep -Eq "^ {5}spectral $command" "$tmp/page"
    ok $? "the manual has the command $command"
done
for kind in $("$SPECTRAL" list | grep '^[a-z]'); do
    grep -Eqw "$kind" "$tmp/page"
    ok $? "the manual has the list of $kind"
done
# Each option in the help of a command is one that it has; join and its like may name one of render, with its command.
foreign=
for command in $commands; do
    "$SPECTRAL" "$command" --help | sed 's/render --[a-z]*//g' >"$tmp/help"
    options "$tmp/help" | grep '^--' | grep -vx -- --version >"$tmp/named" # spectral -V
    sed -n 's/^  \(-.*\)/\1/p' "$tmp/help" | sed 's/   *.*//' | grep -Eo -- '--[a-z][a-z-]*' | LC_ALL=C sort -u >"$tmp/own"
    foreign="$foreign$(comm -23 "$tmp/named" "$tmp/own" | sed "s/^/ $command /" | tr '\n' ' ')"
done
[ -z "$foreign" ]
ok $? "no help names an option that its command does not have$foreign"
# A terminal of 80 columns shows each help without broken lines.
too_long=
for command in '' $commands; do
    # shellcheck disable=SC2086  # $command may be no word
    "$SPECTRAL" $command --help | grep -E '.{81}' && too_long="$too_long spectral $command --help"
done >"$tmp/out"
"$SPECTRAL" | grep -E '.{81}' >>"$tmp/out" && too_long="$too_long spectral"
[ -z "$too_long" ]
ok $? "no line of a help is longer than 80 columns$too_long"

# The defaults of the page: a scene with them shows the same as a scene without.
sed -n '/^[.]Ss Defaults/,/^[.]Ed/p' spectral.5 | sed '/^[.A]/d' >"$tmp/defaults"
# words STATEMENT prints the words of the page's table that the statement may leave out.
words() { sed -n 's/^[.]It '"$1"' Ta //p' spectral.5 | sed 's/[(,;].*//; s/\\-/-/g'; }
[ "$(wc -l <"$tmp/defaults")" = 5 ] && words material | grep -q '^gloss 0'
ok $? "the page lists defaults"
# same NAME: the files a.scene and b.scene show the same
same() {
    for scene in a b; do
        "$SPECTRAL" render "$tmp/$scene.scene" --renderer raster --no-check --quiet -o "$tmp/$scene.tif" 2>"$tmp/err"
    done
    exits 0 "$1" "$SPECTRAL" compare "$tmp/a.tif" "$tmp/b.tif"
}
objects() { # CAMERA LIGHT MATERIAL OBJECT MESH
    printf '%s\n' "$1" "light d65 40 position 1 2 6 $2" "material m { diffuse 0.5 specular 0.4 texture checks $3 }" \
        "object torus 1 2 20 20 material m rotate 30 1 1 0 translate 0 1 -4 $4" \
        "object mesh chair material m unitize translate 1 0 -5 $5"
}
objects '' '' '' '' '' >"$tmp/a.scene"
{ cat "$tmp/defaults"; objects '' '' '' '' ''; } >"$tmp/b.scene"
same "a scene without these statements has the defaults of the page"
small='size 90 60'
objects "$small" '' '' '' '' >"$tmp/a.scene"
objects "$small" "$(words 'light position')" "nearest $(words material)" "$(words 'object, checker')" \
    "$(words 'object mesh')" >"$tmp/b.scene"
same "words that are left out have the defaults of the page"
{ echo 'camera perspective 40'; objects "$small" '' '' '' ''; } >"$tmp/a.scene"
{ echo "camera perspective 40 $(words 'camera perspective')"; objects "$small" '' '' '' ''; } >"$tmp/b.scene"
same "a perspective camera has the defaults of the page"
{ echo 'camera perspective 40'; objects "$small" '' '' 'repeat 2 1' ''; } >"$tmp/b.scene"
run "$SPECTRAL" render "$tmp/b.scene" --renderer raster --no-check --quiet -o "$tmp/b.tif"
exits 1 "other words show something else" "$SPECTRAL" compare "$tmp/a.tif" "$tmp/b.tif"

# The defaults of options, as --help prints them: with such an option all is as without it.
names_default() { # COMMAND OPTION VALUE
    "$SPECTRAL" "$1" --help | awk '/^  -/ { printf "\n" } { sub(/^  +/, " "); printf "%s", $0 }' |
        grep -Eq -- "^ .*$2[ ,].*( $3 \(default\)|[(]default: $3[);])"
    ok $? "the help of $1 $2 prints its default, $3"
}
rendered() { "$SPECTRAL" render patches --size 30x20 --sampling box:3 "$@" --quiet 2>"$tmp/err"; }
rendered -o "$tmp/a.tif"
for default in 'renderer gl' 'buffer float' 'depth 16' 'unchecked 0.01' 'detector cie1931'; do
    names_default render "--${default% *}" "${default#* }"
    rendered "--${default% *}" "${default#* }" -o "$tmp/b.tif"
    exits 0 "render --$default changes nothing" "$SPECTRAL" compare "$tmp/a.tif" "$tmp/b.tif" --tolerance 0
done
"$SPECTRAL" develop "$tmp/a.tif" --quiet -o "$tmp/c.tif"
for default in 'detector cie1931' 'adaptation none' 'exposure 1' 'bits 8'; do
    names_default develop "--${default% *}" "${default#* }"
    "$SPECTRAL" develop "$tmp/a.tif" "--${default% *}" "${default#* }" --quiet -o "$tmp/d.tif"
    cmp -s "$tmp/c.tif" "$tmp/d.tif"
    ok $? "develop --$default changes nothing"
done

# Each example of the page runs, in the order of the page. cost needs a small picture.
mkdir "$tmp/examples"
cp data/samples/* "$tmp/examples"
sed -i 's/^size .*/size 30 20/; s/^wavelengths .*/wavelengths 400 700 100/' "$tmp/examples/my.scene"
sed -n '/^[.]Sh EXAMPLES/,/^[.]Sh SEE/s/^[.]Dl //p' spectral.1 >"$tmp/commands"
[ "$(wc -l <"$tmp/commands")" -gt 10 ]
ok $? "the page has examples"
program=$(realpath "$SPECTRAL")
while read -r command; do
    run sh -c "cd $tmp/examples && spectral() { $program \"\$@\"; } && $command"
    [ "$status" = 0 ]
    ok $? "$command"
done <"$tmp/commands"
for file in own.scene under-a.tif my.tif tube.tif person.png camera.png fluorescence.html cost.svg patch.svg; do
    [ -s "$tmp/examples/$file" ]
    ok $? "the examples write $file"
done

done_testing
