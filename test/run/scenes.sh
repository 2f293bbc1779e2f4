#!/bin/sh
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile
# OpenGL's picture of every built-in scene agrees with the reference, under other lights, too.
. test/run/tap.sh

agrees() { # NAME OPTION...
    name=$1
    shift
    exits 0 "$name: the pictures agree" "$SPECTRAL" render "$@" --size 300x200 -o "$tmp/out.tif"
    prints '^unexplained +0$' "$name: no pixel is unexplained"
}

for scene in data/builtin/scenes/*.scene; do
    agrees "$(basename "$scene" .scene)" "$(basename "$scene" .scene)"
done

# On processors without fused multiply-add, with vertices that Mesa lights without LLVM (its powers
# are then the C library's), and on its other driver.
for variant in GALLIUM_OVERRIDE_CPU_CAPS=sse2 DRAW_USE_LLVM=0 GALLIUM_DRIVER=softpipe \
    'GALLIUM_DRIVER=softpipe DRAW_USE_LLVM=0'; do
    for scene in colorchecker room pasture; do
        # the shell splits this into words on purpose
        # shellcheck disable=SC2086
        exits 0 "$scene, $variant: the pictures agree" env $variant "$SPECTRAL" render "$scene" \
            --size 300x200 --wavelengths 400:700:60 -o /dev/null
    done
done

# At the scene's own size, the check would find an error above 2 counts at nearly every smooth pixel.
for scene in data/builtin/scenes/*.scene; do
    name=$(basename "$scene" .scene)
    exits 0 "$name: the pictures agree at its own size" "$SPECTRAL" render "$name" -o /dev/null \
        --json - --quiet
    awk -v RS=, -F: '/"smooth_pixels"/ { n = $2 } /"smooth_floor_999_counts"/ { floor = $2 }
        END { exit !(n > 10000 && floor > 0 && floor <= 2) }' "$tmp/out"
    ok $? "$name: 99.9 % of the smooth pixels have a floor of 2 counts or less"
done
# The path of a compiled-in scene works like its name; the paths in the scene lead to compiled-in files.
agrees "a compiled-in scene by its path" builtin:scenes/patches.scene --wavelengths 550
for light in a uv fluorescent; do
    agrees "fluorescence under $light" fluorescence --light "1=$light"
    agrees "metamers under $light" metamers --light "1=$light"
done

# Fluorescent pairs seen from the front: both halves are equal in every band under incandescent light, and the
# right half glows under ultraviolet.
cat >"$tmp/pairs.scene" <<'SCENE'
size 300 200
camera ortho 12
light a 1 direction 0 0 1
checker fluorescence plane 5 5
SCENE
halves() { # TRUTH NAME OPTION...
    truth=$1
    name=$2
    shift 2
    for renderer in gl raster; do
        run "$SPECTRAL" render "$tmp/pairs.scene" -o "$tmp/pairs.tif" --renderer $renderer "$@"
        [ "$status" = 0 ] && /usr/bin/python3 - "$tmp/pairs.tif" "$truth" >"$tmp/out" 2>&1 <<'PYTHON'
import sys
import numpy as np
import tifffile
pages = np.array([page.asarray() for page in tifffile.TiffFile(sys.argv[1]).pages], int)
for row in (50, 150):  # three pairs in each row of the grid, cut at 50, 150 and 250
    for column in (50, 150, 250):
        left, right = (pages[:, row - 20:row + 20, x:x + 20] for x in (column - 21, column + 1))
        assert eval(sys.argv[2]), (row, column, left.max(), right.max())
PYTHON
        ok $? "$renderer: $name"
    done
}
halves 'abs(left - right).max() <= 1 and left.max() > 1000' 'fluorescent pairs are equal in every band under A'
halves 'right[40:].sum() > 4 * left[40:].sum()' 'above 500 nm only the right half glows under ultraviolet' \
    --light 1=uv

"$SPECTRAL" render pasture --size 150x100 --depth 8 --wavelengths 380:730:25 --renderer raster \
    -o "$tmp/picture.tif" --quiet && cmp "$tmp/picture.tif" data/builtin/textures/picture.tif
ok $? "the picture in the room equals the program's stack of the pasture"
done_testing
