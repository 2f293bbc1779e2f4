#!/bin/sh
# SPDX-License-Identifier: MIT
# A fault planted in the GL path must end with exit 1 and name a pixel, a wavelength and an object;
# the same scene without it must pass. $FAULTS is the library made of test/fault.c.
. test/tap.sh
FAULTS=${FAULTS:-build/test/fault.so}

cat >"$tmp/fault.scene" <<'SCENE'
size 120 80
wavelengths 400 700 20
camera ortho 12
light d65 1 position 2 1 8
light a 0.5 direction -1 1 1
checker ../../../data/materials/colorchecker.list sphere 2.8 20 20
object plane 14 10 material board translate 0 0 -3
material board { diffuse gaussian:600,80*0.5 gloss 10 }
SCENE

render() {
    env FAULT="$1" LD_PRELOAD="$FAULTS" "$SPECTRAL" render "$tmp/fault.scene" -o "$tmp/out.tif"
}

exits 0 "without a fault the pictures agree" render none
prints '^unexplained +0$' "and no pixel is unexplained"
rm -f "$tmp/out.tif"
for fault in wavelength triangle shift pixel nan; do
    exits 1 "a planted fault is found: $fault" render "$fault"
    says 'first at [0-9]+,[0-9]+ at [0-9]+ nm on [a-z0-9-]+ \(.*fault\.scene:[67]\)' \
        "$fault: pixel, wavelength and object are named"
    one_line "$fault"
    absent "$tmp/out.tif" "$fault"
done
exits 1 "one wrong pixel fails the whole picture" render pixel
prints '^unexplained +1$' "and it is the only one that is unexplained"
exits 1 "--keep stores a stack that failed" \
    env FAULT=pixel LD_PRELOAD="$FAULTS" "$SPECTRAL" render "$tmp/fault.scene" \
    -o "$tmp/kept.tif" --keep
grep -aq 'cross-check: DIFFERENT' "$tmp/kept.tif"
ok $? "with the verdict in it"
for depth in 16 32f; do
    exits 3 "unchecked, what is no number is refused all the same at depth $depth" \
        env FAULT=nan LD_PRELOAD="$FAULTS" "$SPECTRAL" render "$tmp/fault.scene" \
        -o "$tmp/unchecked.tif" --no-check --depth "$depth"
    absent "$tmp/unchecked.tif" "depth $depth"
done
done_testing
