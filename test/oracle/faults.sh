#!/bin/sh
# SPDX-License-Identifier: MIT
# level: first; packages: libosmesa6-dev; makes: faults mutant
# Each fault planted in OpenGL must end with exit 1 and one line that names a pixel, an object and
# what differs; the scene drawn without it must pass. $FAULTS is the library made of test/oracle/fault.c,
# $MUTANT the program with all bounds a thousand times too wide. Scenes lie in test/cases/faults/. FULL=1 plants all
# faults; without it some of each kind, on llvmpipe.
. test/run/tap.sh
FAULTS=${FAULTS:-build/test/fault.so}
MUTANT=${MUTANT:-${BUILD:-build}/test/spectral-mutant}
FAULT_PASSES=$tmp/passes
export FAULT_PASSES
few=' 1 3 6 10 13 14 21 25 34 43 45 46 49 59 65 69 71 '

# Number, fault and scene, as in test/README.md. Any implementation may have faults 1 to 46.
cat >"$tmp/table" <<'TABLE'
| 1 | one triangle of each mesh is missing | patches |
| 2 | a triangle of one pixel is missing | crumb |
| 3 | two bands of each pass are swapped | patches |
| 4 | two passes are swapped | patches |
| 5 | the picture is shifted by 1/2 pixel | patches |
| 6 | the picture is shifted by 1/64 pixel | patches |
| 7 | the picture is mirrored from top to bottom | patches |
| 8 | the picture is mirrored from left to right | patches |
| 9 | the fill rule takes right and top edges for left and bottom ones | grid |
| 9 | the same in a picture whose size is no power of two | grid-thirds |
| 10 | pixels on a shared edge are drawn by neither triangle | mirrored-seam |
| 10 | pixels on a shared edge are drawn by both triangles | seam |
| 11 | flat shading for smooth | patches |
| 12 | the first vertex colours a flat triangle, not the last | flat |
| 13 | affine interpolation for perspective | floor |
| 14 | depth test LEQUAL for LESS | twins |
| 15 | depth test GREATER for LESS | patches |
| 16 | no depth test | before |
| 17 | depth is not written | before |
| 18 | front faces are culled | patches |
| 19 | clockwise faces are taken for front faces | leaves |
| 20 | back faces are lit by the normals of the front | leaves |
| 21 | normals are not normalised under a scale of 2 | enlarged |
| 22 | normals are rescaled, not normalised, under an anisotropic scale | stretched |
| 23 | normals are transformed as points are, under a shear | sheared |
| 24 | the specular colour is dropped | glossy |
| 25 | shininess times 1.01 | glossy |
| 26 | shininess 0 is treated as 1 | matt |
| 27 | the reflected ray in place of the half vector | grazing |
| 28 | the viewer is taken to be infinitely far | glossy |
| 29 | highlights on faces that are turned away from the light | grazing |
| 30 | linear and quadratic attenuation are exchanged | lights |
| 31 | a light at infinity is treated as one at a point | glossy |
| 32 | lights are placed under the modelview of an object | lights |
| 33 | the ambient colour of a material is lost in one band | lights |
| 34 | every sample is 1/65535 too large | patches |
| 35 | samples are cut off, not rounded, to 16 bits | patches |
| 36 | colours of vertices are clamped | bright |
| 37 | samples went through 8 bits | patches |
| 38 | one pass is never finished: the buffer keeps the pass before | patches |
| 39 | nothing is clipped at the near plane | near |
| 40 | a clip plane cuts the wrong half of a halved mesh | halves |
| 41 | new vertices at the near plane have the colour of an old one | near |
| 42 | the viewport is off by 1 pixel | patches |
| 43 | one sample of one pixel is wrong by 1/1000 | patches |
| 44 | a pixel at an edge is midway between both sides | edge |
| 45 | a pixel at an edge has the other side's value in one band | edge |
| 46 | every bound is 1000 times too wide (in the program itself) | soft |
| 47 | every sample is 1/1000 too large | patches |
| 48 | one sample is no number | patches |
| 49 | diffuse light is 1/1000 too weak in one band | lights |
| 50 | specular light is 1/100 too weak in one band | lights |
| 51 | ambient light is 1/100 too weak in one band | lights |
| 52 | lights are 1/100 too far to the right | lights |
| 53 | the axes of spots are turned by up to 1/100 | lights |
| 54 | the exponents of spots times 1.01 | lights |
| 55 | spots have no cutoff | lights |
| 56 | one-sided faces are lit from behind | lights |
| 57 | smooth shading for flat | flat |
| 58 | the second group of lights is missing | groups |
| 59 | textures are moved by one texel | textures |
| 60 | two bands of a spectral texture are swapped | textures |
| 61 | one texel is wrong by 1/100 | textures |
| 62 | the nearest texel for a linear filter | textures |
| 63 | textures do not repeat from left to right | textures |
| 64 | every other repetition of a texture is mirrored | textures |
| 65 | no fluorescence in one band of each pass | glow |
| 66 | every sample is half as large | seam |
| 67 | the picture is black | seam |
| 68 | no sample is a number | seam |
| 69 | the depth of one pixel is wrong by 1/10000 | patches |
| 69 | the depth of one pixel at an edge is wrong by 1/10000 | edge |
| 69 | the depth of one pixel is wrong by 1/10000 where the border cuts a triangle in perspective | floor |
| 70 | a pixel at an edge shows another triangle that looks the same | edge |
| 71 | five fragments too many at an edge | edge |
| 71 | five fragments too many on a triangle too thin for a bound | sliver |
| 72 | a pixel at an edge shows the background, not what lies behind the edge | edge |
TABLE

render() { # FAULT SCENE [OPTION...]
    fault=$1
    scene=$2
    shift 2
    [ "$scene" != bright ] || set -- --full-scale 0.5 "$@"
    env FAULT="$fault" LD_PRELOAD="$FAULTS" "$SPECTRAL" render "test/cases/faults/$scene.scene" \
        -o "$tmp/out.tif" "$@"
}

# Prints the smallest error, in counts, that the check surely finds everywhere inside surfaces.
smooth_floor() { # PROGRAM SCENE
    "$1" render "test/cases/faults/$2.scene" -o /dev/null --quiet --json - |
        sed -n 's/.*"smooth_floor_worst_counts": *\([^,}]*\).*/\1/p'
}

is_above() { # LIMIT VALUE
    awk -v limit="$1" -v value="$2" 'BEGIN { exit !(value != "" && value + 0 > limit) }'
}

# The program finds errors of 2 counts; the mutant must report that it does not.
finds_mutant() { # SCENE
    floor=$(smooth_floor "$SPECTRAL" "$1")
    is_above 0.01 "$floor" && ! is_above 2 "$floor" && is_above 2 "$(smooth_floor "$MUTANT" "$1")"
}

finds() { # FAULT SCENE
    run render "$1" "$2"
    [ "$status" = 1 ] && [ "$(wc -l <"$tmp/err")" = 1 ] && [ ! -e "$tmp/out.tif" ] &&
        grep -Eq \
            'first at [0-9]+,[0-9]+ on [0-9a-z-]+ \(test/cases/faults/[a-z-]+\.scene:[0-9]+\): (at [0-9]+ nm )?OpenGL' \
            "$tmp/err"
}

# is_chosen NUMBER
is_chosen() {
    [ "${FULL:-}" = 1 ] || case $few in *" $1 "*) ;; *) return 1 ;; esac
}

for scene in test/cases/faults/*.scene; do
    scene=$(basename "$scene" .scene)
    [ "${FULL:-}" = 1 ] || case $scene in patches | lights | floor | seam) ;; *) continue ;; esac
    for GALLIUM_DRIVER in softpipe llvmpipe; do
        export GALLIUM_DRIVER
        exits 0 "without a fault the pictures agree: $scene on $GALLIUM_DRIVER" render 0 "$scene"
        prints '^unexplained +0$' "without a fault no pixel is unexplained: $scene on $GALLIUM_DRIVER"
        rm -f "$tmp/out.tif"
    done
done
for scene in sheared grazing near; do
    exits 0 "the shader for planted faults passes without a fault: $scene" render -1 "$scene"
    rm -f "$tmp/out.tif"
done

while IFS='|' read -r _ number name scene _; do
    number=$((number))
    is_chosen $number || continue
    scene=${scene# }
    scene=${scene% }
    [ $number != 4 ] || run render 0 "$scene" # keeps the passes that fault 4 swaps
    rm -f "$tmp/out.tif"
    if [ $number = 46 ]; then finds_mutant "$scene"; else finds "$number" "$scene"; fi
    missed=$?
    ok $missed "planted fault $number is found:$name"
    echo "$number $missed" >>"$tmp/verdicts"
    echo "| $number |$name| $scene | $([ $missed = 0 ] && echo found || echo MISSED) |" >&2
done <"$tmp/table"
sed -n '/^| number | fault | scene |$/,/^$/p' test/README.md | grep '^| [0-9]' | cmp -s - "$tmp/table"
ok $? "test/README.md has the same table"

[ "${FULL:-}" = 1 ] || { done_testing; exit; }
count=$(awk '{ missed[$1] += $2 }
    END { for (i = 1; i <= 46; i++) n += i in missed && !missed[i]; print n + 0 }' "$tmp/verdicts")
echo "$count of 46 planted faults found" >&2
[ "$count" = 46 ]
ok $? "46 of 46 planted faults are found, each by its number"

GALLIUM_DRIVER=softpipe
for number in 1 6 14 23 37 41 44 45; do
    finds "$number" "$(sed -n "s/^| $number |.*| \(.*\) |$/\1/p" "$tmp/table")"
    ok $? "planted fault $number is found on softpipe, too"
done
GALLIUM_DRIVER=llvmpipe

exits 1 "one wrong sample fails the whole picture" render 43 patches
prints '^unexplained +1$' "only the pixel of the wrong sample is unexplained"
exits 1 "a picture of components is checked, too" render 34 patches --sampling basis:3
grep -q 'at component [1-3] OpenGL' "$tmp/err"
ok $? "the message names the component: $(cat "$tmp/err")"
exits 1 "--keep stores a stack that failed" render 43 patches --keep
grep -aq 'differs; ' "$tmp/out.tif"
ok $? "the kept stack records the verdict"
rm -f "$tmp/out.tif"

lacks() { # FAULT MESSAGE [OPTION...]
    fault=$1
    message=$2
    shift 2
    exits 3 "an OpenGL that cannot draw the scene is no difference: $message" render "$fault" patches "$@"
    grep -q "$message" "$tmp/err"
    ok $? "the message says what it lacks: $(cat "$tmp/err")"
    absent "$tmp/out.tif" "fault $fault"
}
lacks 81 'OSMesa gives 32 bits of colour, 16 of depth and 8 of stencil; 32, 24 and 8 are needed'
lacks 82 'OSMesa draws at most 16 x [0-9]* pixels at once'
lacks 83 'this OSMesa draws with another driver, not with softpipe' --renderer softpipe
exits 0 "cost goes on where OSMesa lacks a driver" \
    env FAULT=83 LD_PRELOAD="$FAULTS" "$SPECTRAL" cost test/cases/faults/grid.scene --size 8x6 --runs 5 -j 1
prints 'without .*softpipe.*: this OSMesa draws with another driver, not with softpipe' "cost notes what it leaves out"

for depth in 16 32f; do
    for fault in 48 68; do
        exits 3 "NaN is refused even unchecked, at depth $depth: $fault" \
            render "$fault" patches --no-check --depth "$depth"
        absent "$tmp/out.tif" "depth $depth"
    done
done
done_testing
