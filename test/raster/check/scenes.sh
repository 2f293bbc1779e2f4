#!/bin/sh
# SPDX-License-Identifier: MIT
# level: full
# OpenGL's picture of every built-in scene agrees with the reference, under other lights, too.
. test/shared/tap.sh

agrees() { # NAME OPTION...
    name=$1
    shift
    exits 0 "$name: the pictures agree" "$SPECTRAL" render "$@" --size 300x200 -o "$tmp/out.tif"
    prints '^verdict +agreed: every pixel is' "$name: no pixel is unexplained"
}

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

"$SPECTRAL" render pasture --size 150x100 --depth 8 --wavelengths 380:730:25 --renderer raster \
    -o "$tmp/picture.tif" --quiet && cmp "$tmp/picture.tif" data/builtin/textures/picture.tif
ok $? "the picture in the room equals the program's stack of the pasture"
done_testing
