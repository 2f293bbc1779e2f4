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

# What the scene language has but this version does not simulate is refused, never left out.
refused() { # NAME LINE:COLUMN STATEMENT...
    name=$1
    place=$2
    printf '%s\n' 'material m { diffuse 0.5 }' 'light d65 1 position 0 0 8' "$3" "${4:-}" \
        >"$tmp/refused.scene"
    exits 2 "$name is refused" "$SPECTRAL" render "$tmp/refused.scene" -o "$tmp/refused.tif"
    says "refused\.scene:$place: error: .*cannot be simulated" "$name: at its place"
    one_line "$name"
    absent "$tmp/refused.tif" "$name"
}

refused fluorescence 3:39 'material f { diffuse 0.5 fluorescence uv 0.1 }' 'object sphere 1 9 9 material f'
refused texture 3:26 'material f { diffuse 0.5 texture a.tif }' 'object sphere 1 9 9 material f'
refused 'a spectral texture' 3:26 'material f { diffuse 0.5 spectral-texture a.tif }' \
    'object sphere 1 9 9 material f'
refused emission 3:35 'material f { diffuse 0.5 emission 0.2 }' 'object sphere 1 9 9 material f'
refused 'a metameric partner' 3:26 'material f { diffuse 0.5 metamer m }' \
    'object sphere 1 9 9 material f'
refused 'a Donaldson matrix' 3:26 'material f { diffuse 0.5 donaldson d.csv }' \
    'object sphere 1 9 9 material f'
refused 'a spot light' 3:28 'light d65 1 position 0 0 8 spot 0 0 -1 30 2' 'object sphere 1 9 9 material m'
refused attenuation 3:28 'light d65 1 position 0 0 8 attenuation 1 0.1 0' \
    'object sphere 1 9 9 material m'
refused 'flat shading' 3:1 'shading flat' 'object sphere 1 9 9 material m'
refused 'a material map' 3:13 'object mesh a.obj materials a.mtl-map'

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
done_testing
