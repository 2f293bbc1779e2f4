#!/bin/sh
# SPDX-License-Identifier: MIT
# Inputs that must be refused. The first line of each file in test/bad says where, relative to
# test/bad, and with which words:
#   # expect: FILE:LINE:COLUMN: error: WORDS
. test/tap.sh

for scene in test/bad/*.scene; do
    expected=$(sed -n '1s/^# expect: //p' "$scene")
    run "$SPECTRAL" plan "$scene"
    [ "$status" = 2 ] && [ "$(wc -l <"$tmp/err")" = 1 ] && [ ! -s "$tmp/out" ] &&
        [ -n "$expected" ] && grep -Fq -- "test/bad/${expected%%error: *}error: " "$tmp/err" &&
        grep -Fq -- "${expected#*error: }" "$tmp/err"
    ok $? "$(basename "$scene" .scene): ${expected#*error: }"
done

printf '%s\n' 'material unused no/such/file.txt' 'material m { diffuse 0.5 }' \
    'object sphere 1 9 9 material m' >"$tmp/unused.scene"
exits 0 "a material that no object uses is not even read" "$SPECTRAL" plan "$tmp/unused.scene"

printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n' >"$tmp/range.obj"
printf 'material m { diffuse 0.5 }\nobject mesh range.obj material m\n' >"$tmp/mesh.scene"
exits 2 "a face index out of range is refused" "$SPECTRAL" plan "$tmp/mesh.scene"
says 'range\.obj:4:7: error: ' "at its place in the OBJ file"
printf 'material m { diffuse 0.5 }\nobject mesh none.obj material m\n' >"$tmp/mesh.scene"
exits 2 "a missing mesh is refused" "$SPECTRAL" plan "$tmp/mesh.scene"
says 'mesh\.scene:2:13: error: .*none\.obj' "where the scene names it"

exits 2 "a texture that is none is refused by render, too" \
    "$SPECTRAL" render test/bad/texture-not-tiff.scene -o "$tmp/none.tif"
one_line "a texture that is none"
absent "$tmp/none.tif" "a texture that is none"

# a corner of the square is where the light is
printf '%s\n' 'material m { diffuse 0.5 }' 'object plane 2 2 material m' \
    'light d65 1 position 1 1 0 attenuation 0 0 1' >"$tmp/near.scene"
exits 2 "a light that weakens with distance must not be at a vertex" \
    "$SPECTRAL" render "$tmp/near.scene" -o "$tmp/near.tif"
says 'near\.scene:2:1: error: vertex [1-4] of this object reflects no finite radiance' \
    "the object and the vertex are named"
one_line "a light at a vertex"
absent "$tmp/near.tif" "a light at a vertex"
done_testing
