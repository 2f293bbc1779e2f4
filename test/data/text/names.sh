#!/bin/sh
# SPDX-License-Identifier: MIT
# level: first
# Names of built-in files can be used as `spectral list` prints them, in scenes and in options; `show` prints each file.
# A mistyped word is refused with the word that was meant.
. test/shared/tap.sh
names() { "$SPECTRAL" list "$1" | sed -n 's/^  //p'; }
light='light d65 1 direction 0 0 1'
ball='object sphere 1 9 9 material m'

# usable WHAT NAMES LINE...: a scene of these lines can be planned with each of the names in the place of NAME
usable() {
    what=$1
    names=$2
    shift 2
    bad=
    for name in $names; do
        printf '%s\n' "$@" | sed "s:NAME:$name:g" >"$tmp/my.scene"
        "$SPECTRAL" plan "$tmp/my.scene" >"$tmp/out" 2>"$tmp/err" || bad="$bad $name"
    done
    [ -n "$names" ] && [ -z "$bad" ]
    ok $? "$what$bad"
}

usable 'each scene can be included' "$(names scenes)" 'include NAME'
usable 'each material can be used' "$(names materials)" "$light" 'material m NAME' "$ball"
usable 'a material file of one spectrum can be a reflectance' "$(names materials | grep colorchecker)" \
    "$light" 'material m { diffuse NAME }' "$ball"
usable 'each illuminant can be a light' "$(names illuminants)" 'light NAME 1 direction 0 0 1' \
    'material m { diffuse 0.5 }' "$ball"
usable 'each model can be a mesh' "$(names models)" "$light" 'material m { diffuse 0.5 }' 'object mesh NAME material m'
usable 'each texture can be used' "$(names textures | grep -vx picture)" "$light" \
    'material m { diffuse 0.5 texture NAME linear }' 'object plane 1 1 material m'
usable 'the texture that is a stack can be a spectral one' "$(names textures | grep -x picture)" "$light" \
    'material m { diffuse 0.5 spectral-texture NAME linear }' 'object plane 1 1 material m'
usable 'each list can be a checker' "$(names lists)" "$light" 'checker NAME sphere 1 9 9'
"$SPECTRAL" render patches --size 6x4 --renderer raster --no-check --quiet -o "$tmp/a.tif"
for name in $(names detectors); do
    exits 0 "the detector $name can see a stack" "$SPECTRAL" develop "$tmp/a.tif" --detector "$name" -o "$tmp/seen.tif"
done
run "$SPECTRAL" list lights
mv "$tmp/out" "$tmp/lights"
run "$SPECTRAL" list Illuminants
cmp -s "$tmp/out" "$tmp/lights"
ok $? "lights is another word for illuminants, and case is ignored"

"$SPECTRAL" list illuminants | tr -d '\n' >"$tmp/out"
prints ' f1  f2 .* f9  f10  f11  f12 ' "numbers in names are in their order"

# show
for kind in scenes/.scene materials/.txt tables/.csv models/.obj materials/.list textures/.tif; do
    bad=
    # shellcheck disable=SC2044 # our own names have no blanks
    for file in $(find "data/builtin/${kind%/*}" -name "*${kind#*/}"); do
        "$SPECTRAL" show "builtin:${file#data/builtin/}" | cmp -s - "$file" || bad="$bad $file"
    done
    [ -z "$bad" ]
    ok $? "show prints each file of ${kind%/*}: ${kind#*/}$bad"
done
"$SPECTRAL" show metals/gold | cmp -s - data/builtin/materials/metals/gold.txt
ok $? "show takes the name that list prints"
for scene in $(names scenes); do
    "$SPECTRAL" show "$scene" -o "$tmp/$scene.scene"
    "$SPECTRAL" render "$scene" --size 60x40 --renderer raster --no-check --quiet -o "$tmp/a.tif"
    "$SPECTRAL" render "$tmp/$scene.scene" --size 60x40 --renderer raster --no-check --quiet -o "$tmp/b.tif"
    exits 0 "a copy of the scene $scene renders the same picture in another folder" "$SPECTRAL" compare "$tmp/a.tif" "$tmp/b.tif"
done

# words that were meant; bad.sh has those of command lines
scene() { # MEANT LINE...
    meant=$1
    shift
    printf '%s\n' "$@" >"$tmp/my.scene"
    refuses "did you mean ${meant}[?]" "$meant is meant" "$SPECTRAL" plan "$tmp/my.scene"
}
scene object 'objct sphere 1 9 9 material m'
scene sphere 'object shpere 1 9 9 material m'
scene translate 'material m { diffuse 0.5 }' 'object sphere 1 9 9 material m trnslate 1 0 0'
scene mirror 'material mirror { specular 1 gloss 9 }' 'object sphere 1 9 9 material miror'
scene metals/gold 'material m metals/glod' 'object sphere 1 9 9 material m'
scene metals/gold 'material m gold' 'object sphere 1 9 9 material m'
scene checks 'material m { diffuse 1 texture checks.tif }' 'object plane 1 1 material m' "$light"
scene sheep 'material m { diffuse 1 }' 'object mesh sheep.obj material m'
scene colorchecker 'checker colorcheker sphere 1 9 9'
for word in li xy; do # two letters begin too many words; a half of the letters differ
    echo "$word 1" >"$tmp/my.scene"
    run "$SPECTRAL" plan "$tmp/my.scene"
    [ "$status" = 2 ] && ! grep -q 'did you mean' "$tmp/err"
    ok $? "no word is meant by $word"
done
printf '%s\n' 'LIGHT D65 1 Direction 0 0 1' 'Material m Metals/Gold' 'object Sphere 1 9 9 material m' >"$tmp/my.scene"
exits 0 "case is ignored in words and in names of built-in files" "$SPECTRAL" Plan "$tmp/my.scene" --Size 9x9
cp data/builtin/tables/a.csv "$tmp/D65"
sed 's/D65/d65/' "$tmp/my.scene" >"$tmp/built-in.scene"
run "$SPECTRAL" probe "$tmp/my.scene" 600 400
mv "$tmp/out" "$tmp/own"
run "$SPECTRAL" probe "$tmp/built-in.scene" 600 400
! cmp -s "$tmp/own" "$tmp/out"
ok $? "a file comes before a built-in name that differs in case"

run "$SPECTRAL"
[ "$status" = 2 ] && [ ! -s "$tmp/err" ] && [ "$(wc -l <"$tmp/out")" = 11 ]
ok $? "the program's name alone prints eleven lines"
for command in $(sed -n 's/^  spectral \([a-z]*\) .*/\1/p' "$tmp/out"); do
    exits 0 "spectral $command --help prints the help of the command" "$SPECTRAL" "$command" --help
    prints "^usage: spectral $command " "it begins with the usage"
    prints "^  spectral $command " "it has an example"
done
exits 0 "a letter and its value may touch: -j2" "$SPECTRAL" render patches --size 4x4 -j2 -q -o /dev/null
done_testing
