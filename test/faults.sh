#!/bin/sh
# SPDX-License-Identifier: MIT
# A fault planted in the GL path must end with exit 1 and name a pixel, a wavelength and an object;
# the same scene without it must pass. $FAULTS is the library made of test/fault.c.
. test/tap.sh
FAULTS=${FAULTS:-build/test/fault.so}
textures=../../../data/textures

scene() { # NAME: standard input, drawn small
    { echo 'size 64 48' && cat; } >"$tmp/$1.scene"
}

scene patches <<'SCENE'
wavelengths 400 700 50
camera ortho 12
light d65 1 position 2 1 8
light a 0.5 direction -1 1 1
checker ../../../data/materials/colorchecker.list sphere 2.8 20 20
object plane 14 10 material board translate 0 0 -3
material board { diffuse gaussian:600,80*0.5 gloss 10 }
SCENE

scene lights <<'SCENE'
wavelengths 400 700 60
camera perspective 25 near 1 far 40 eye 0 3 9 look 0 0 0
viewer local
ambient d65 0.1
light d65 1 position 3 3 4 attenuation 1 0.1 0.02
light a 2 position 0 5 0 spot 0 -1 0 30 8
light 1 1 position -3 1 5 spot 0.5 0 -1 25 40
material paper { diffuse 0.5 fluorescence gaussian:370,40 gaussian:440,60*0.4 gloss 20 specular 0.5 }
material lamp { diffuse gaussian:550,80 gloss 5 emission d65*0.02 }
object sphere 0.8 20 20 material paper translate -2 0 0
object torus 0.3 0.6 16 16 material lamp
object plane 1.5 1.5 material paper two-sided scale -1 1 1 rotate 150 0 1 0 translate 2 0 0
object plane 0.8 0.8 material lamp rotate 150 0 1 0 translate 0 -1.4 0
SCENE

{ cat "$tmp/lights.scene" && echo 'shading flat'; } >"$tmp/flat.scene"

scene groups <<'SCENE'
wavelengths 400 600 50
camera ortho 4
light d65 0.1 position -8 3 4
light d65 0.1 position -6 3 4
light d65 0.1 position -4 3 4
light d65 0.1 position -2 3 4
light d65 0.1 position 0 3 4
light d65 0.1 position 2 3 4
light d65 0.1 position 4 3 4
light d65 0.1 position 6 3 4
light d65 0.1 position 8 3 4
material clay { diffuse 0.5 gloss 20 }
object sphere 1.4 30 30 material clay
SCENE

scene textures <<SCENE
wavelengths 400 700 60
camera perspective 30 near 1 far 40 eye 0 3 9 look 0 0 0
light d65 1 position 3 3 8
material ground { diffuse 0.7 texture $textures/grass.tif linear }
material board { diffuse 0.7 texture $textures/checks.tif nearest }
material photo { diffuse 0.7 spectral-texture $textures/picture.tif linear gloss 30 }
object plane 9 9 material ground rotate -90 1 0 0 translate 0 -1 0 repeat 0.4 1.3
object plane 2 2 material board translate -1.5 0.5 0 repeat 2.2 1.7
object sphere 1 20 20 material photo translate 1.5 0.5 0 repeat 1.2 0.8
SCENE

# Whatever is seen of this one under ultraviolet is fluorescence.
scene glow <<'SCENE'
wavelengths 440 540 20
camera ortho 4
light uv 1 position 1 2 8
material dye { diffuse 0.5 fluorescence gaussian:370,40 gaussian:480,60*0.4 }
object sphere 1.4 20 20 material dye
SCENE

# The plane reaches beyond the picture and has its shape, so that the seam of its two triangles runs
# through two corners of the picture.
scene diagonal <<'SCENE'
wavelengths 400 600 100
camera ortho 4
light 1 1 position 1 2 8
material wall { diffuse 0.8 }
object plane 8 6 material wall
SCENE

render() { # FAULT SCENE [OPTION...]
    fault=$1
    scene=$2
    shift 2
    env FAULT="$fault" LD_PRELOAD="$FAULTS" "$SPECTRAL" render "$tmp/$scene.scene" \
        -o "$tmp/out.tif" "$@"
}

for scene in patches lights flat groups textures glow diagonal; do
    exits 0 "without a fault the pictures agree: $scene" render none "$scene"
    prints '^unexplained +0$' "and no pixel is unexplained"
    rm -f "$tmp/out.tif"
done

# Fault, scene, and the material on which it shows first.
while read -r fault scene material; do
    exits 1 "a planted fault is found: $fault in $scene" render "$fault" "$scene"
    says "first at [0-9]+,[0-9]+ at [0-9]+ nm on $material \(.*$scene\.scene:[0-9]+\)" \
        "$fault: pixel, wavelength and object are named"
    one_line "$fault"
    absent "$tmp/out.tif" "$fault"
done <<'FAULTS'
wavelength patches board
triangle patches board
shift patches board
gain patches board
pixel patches board
pixel-nan patches board
diffuse lights paper
specular lights lamp
constant lights lamp
position lights lamp
axis lights lamp
exponent lights lamp
cutoff lights lamp
attenuation lights lamp
gloss lights lamp
viewer lights lamp
front lights paper
one-sided lights paper
two-sided lights lamp
shading lights lamp
shading flat lamp
provoking flat lamp
group groups clay
texel-shift textures photo
texel-bands textures photo
texel textures photo
filter textures photo
clamp textures board
mirror textures board
no-diffuse glow dye
half diagonal wall
black diagonal wall
nan diagonal wall
FAULTS

exits 1 "one wrong pixel fails the whole picture" render pixel patches
prints '^unexplained +1$' "and it is the only one that is unexplained"
exits 1 "--keep stores a stack that failed" render pixel patches --keep
grep -aq 'cross-check: DIFFERENT' "$tmp/out.tif"
ok $? "with the verdict in it"
rm -f "$tmp/out.tif"
for depth in 16 32f; do
    for fault in pixel-nan nan; do
        exits 3 "unchecked, what is no number is refused all the same at depth $depth: $fault" \
            render "$fault" patches --no-check --depth "$depth"
        absent "$tmp/out.tif" "depth $depth"
    done
done
done_testing
