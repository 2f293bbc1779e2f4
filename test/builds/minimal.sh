#!/bin/sh
# SPDX-License-Identifier: MIT
# level: full; packages: binutils
# The minimal program (./build.sh minimal) is the core alone: none of the rooms in raster/beside/ is in it, it is small, and its
# stacks are those of the full program, byte by byte. The same holds for a minimal program without OpenGL. Each of the four
# programs proposes only what it can do.
. test/shared/tap.sh
made=$tmp/build
minimal=$made/spectral-minimal

CC=gcc BUILD=$made exits 0 "./build.sh minimal builds it" ./build.sh minimal

# ---- what is in it ----

# functions FILE...: the names of functions that the objects or the program define for others
functions() { nm "$@" | sed -n 's/^[0-9a-f]* T //p' | sort -u; }

CC=gcc BUILD=$made/full exits 0 "./build.sh builds the full one" ./build.sh
functions "$made"/full/obj/raster/beside/*/*.o >"$tmp/beside"
functions "$minimal" >"$tmp/minimal"
functions "$made/full/spectral" >"$tmp/full"
[ "$(comm -12 "$tmp/beside" "$tmp/full" | wc -l)" -gt 100 ]
ok $? "the full program has functions of the rooms beside the core"
comm -12 "$tmp/beside" "$tmp/minimal" >"$tmp/out"
[ ! -s "$tmp/out" ]
ok $? "the minimal program has none of them"
strip -o "$tmp/stripped" "$minimal"
[ "$(wc -c <"$tmp/stripped")" -le 600000 ]
ok $? "stripped it has at most 600,000 bytes"

# ---- what it does ----

run "$minimal" list scenes
[ "$(sed -n 's/^  //p' "$tmp/out" | tr '\n' ' ')" = 'colorchecker fluorescence metamers patches ' ]
ok $? "it has the scenes that need no texture and no mesh"
for scene in colorchecker fluorescence metamers patches; do
    for options in '' '--depth 32f --samples 2' '--renderer raster'; do
        "$minimal" render "$scene" --size 120x80 $options -q -o "$tmp/small.tif" &&
            "$made/full/spectral" render "$scene" --size 120x80 $options -q -o "$tmp/whole.tif" &&
            cmp "$tmp/small.tif" "$tmp/whole.tif"
        ok $? "$scene $options: the same bytes"
    done
done
run "$minimal" show tables/d65
"$made/full/spectral" show tables/d65 | cmp -s - "$tmp/out"
ok $? "a packed file is what was packed"
refuses 'unknown command .view.; known are render, plan, info' "a command that it lacks" "$minimal" view
refuses 'draws without shaders' "shaders" "$minimal" render patches --renderer gl-shader -o "$tmp/x.tif"
refuses "no option '--accuracy'" "an option of a room beside" "$minimal" plan patches --accuracy 1

# ---- without OpenGL ----

CC=gcc GL=none BUILD=$made/none exits 0 "it builds without OpenGL" ./build.sh minimal
exits 0 "it then draws by the reference" "$made/none/spectral-minimal" render patches --size 120x80 -o "$tmp/small.tif"
prints '^verdict +not checked: this program was built without OpenGL' "and says that nothing was checked"
"$made/full/spectral" render patches --size 120x80 --renderer raster -q -o "$tmp/whole.tif"
cmp "$tmp/small.tif" "$tmp/whole.tif"
ok $? "the same bytes as of --renderer raster"
strip -o "$tmp/stripped" "$made/none/spectral-minimal"
[ "$(wc -c <"$tmp/stripped")" -le 560000 ]
ok $? "stripped it has at most 560,000 bytes"
run "$made/none/spectral-minimal" render colorchecker --size 120x80 --threads 2 --json - -o "$tmp/small.tif"
[ "$(sed -n 's/.*"peak_bytes": *\([0-9]*\).*/\1/p' "$tmp/out")" -le $((11 << 20)) ]
ok $? "it takes at most 11 MiB of memory for 120 x 80 pixels"
refuses 'add --renderer raster' "OpenGL" "$made/none/spectral-minimal" render patches --renderer gl -o "$tmp/x.tif"

# ---- what each program proposes ----

# proposed PROGRAM prints the lines that the program proposes: by its name alone, and as examples of its commands.
proposed() {
    "$1" | sed -nE 's/^  spectral (([^ ]+ )*[^ ]+)  .*/\1/p'
    "$1" --help | sed -nE 's/^  ([a-z]+)  .*/\1/p' | while read -r command; do
        "$1" "$command" --help | sed -n '/^example:/,$s/^  spectral //p'
    done
}

# types PROGRAM KIND: each of these lines works where it is typed, in their order. The examples of compare and join need
# files; that of judge needs what another program has drawn, and says so.
types() {
    rm -rf "$tmp/typed"
    mkdir "$tmp/typed"
    program=$(realpath "$1")
    proposed "$1" | awk '!seen[$0]++' >"$tmp/proposed"
    [ "$(wc -l <"$tmp/proposed")" -ge "$("$1" --help | grep -c '^  [a-z]')" ]
    ok $? "$2: each command has an example"
    while read -r line; do
        (
            cd "$tmp/typed" || exit
            case $line in
            compare*) cp colorchecker.tif a.tif && cp a.tif b.tif ;;
            join*) for part in 1 2; do "$program" render colorchecker --part $part/2 -q; done ;;
            esac
        )
        run sh -c "cd $tmp/typed && exec $program $line"
        case $line in judge*) [ "$status" = 2 ] && grep -q 'drawn.txt' "$tmp/err" ;; *) [ "$status" = 0 ] ;; esac
        ok $? "$2: spectral $line"
    done <"$tmp/proposed"
}
CC=gcc GL=none BUILD=$made/none exits 0 "the full one builds without OpenGL" ./build.sh
types "$made/full/spectral" full
types "$minimal" minimal
types "$made/none/spectral" "without OpenGL"
types "$made/none/spectral-minimal" "minimal, without OpenGL"
for program in spectral spectral-minimal; do
    run "$made/none/$program"
    ! grep -q "checks" "$tmp/out"
    ok $? "without OpenGL $program promises no check"
done
done_testing
