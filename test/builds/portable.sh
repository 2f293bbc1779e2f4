#!/bin/sh
# SPDX-License-Identifier: MIT
# level: release; packages: musl-tools gcc-aarch64-linux-gnu libc6-dev-arm64-cross gcc-arm-linux-gnueabihf libc6-dev-armhf-cross gcc-riscv64-linux-gnu libc6-dev-riscv64-cross gcc-s390x-linux-gnu libc6-dev-s390x-cross qemu-user python3-numpy python3-tifffile; makes: static
# The static program, and those for another C library and other processors, draw the same bytes (golden_stacks.sh), and write
# and read files as this machine's program does. On s390x numbers have their highest byte first.
. test/shared/tap.sh
. test/builds/golden_stacks.sh
machines='aarch64-linux-gnu arm-linux-gnueabihf riscv64-linux-gnu s390x-linux-gnu'

# Textures whose numbers have their lowest or their highest byte first, as TIFF, PNG and SGI, and a scene for each.
textures() {
    /usr/bin/python3 - "$1" <<'END'
import struct, sys, zlib
import numpy as np
import tifffile
folder = sys.argv[1]
grey = np.add.outer(np.arange(12) * 4001, np.arange(16) * 777 + 300).astype(np.uint16)
names = []
for order, word in (("<", "low"), (">", "high")):
    for samples, kind in ((grey, "counts"), ((grey / 65535).astype(np.float32), "floats")):
        names.append(f"{kind}-{word}.tif")
        tifffile.imwrite(f"{folder}/{names[-1]}", samples, byteorder=order)
        names.append(f"packed-{names[-1]}")
        tifffile.imwrite(f"{folder}/{names[-1]}", samples, byteorder=order, compression="zlib")
rows = grey.astype(">u2")
def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
with open(folder + "/grey.png", "wb") as out:
    out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 16, 12, 16, 0, 0, 0, 0)) +
              chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row.tobytes() for row in rows))) + chunk(b"IEND", b""))
with open(folder + "/grey.sgi", "wb") as out:
    out.write(struct.pack(">HBBHHHHII", 474, 0, 2, 2, 16, 12, 1, 0, 65535).ljust(512, b"\0") + rows[::-1].tobytes())
for name in names + ["grey.png", "grey.sgi"]:
    with open(f"{folder}/{name}.scene", "w") as out:
        print("wavelengths 400 700 100\nsize 40 30\ncamera ortho 2\nlight d65 1 direction 0 0 1\n"
              f"material m {{ diffuse 0.9 texture {name} linear }}\nobject plane 2 2 material m", file=out)
END
}

# files FOLDER PROGRAM...: writes files, and reads them again, in the folder
files() (
    cd "$1" && shift
    for scene in *.scene; do
        "$@" render "$scene" --renderer raster --no-check -q -o "${scene%.scene}-stack.tif" || return
    done
    for depth in 8 16 32f; do
        "$@" render spheres --size 90x60 --depth $depth --renderer raster --no-check --part 1/1 -q -o part.tif &&
            "$@" join part.tif -q -o "whole-$depth.tif" &&
            "$@" envi "whole-$depth.tif" &&
            "$@" info "whole-$depth.tif" --json "info-$depth.json" &&
            "$@" probe "whole-$depth.tif" 45 30 --csv -o "pixel-$depth.csv" &&
            "$@" probe "whole-$depth.tif" --objects --csv -o "objects-$depth.csv" &&
            "$@" develop "whole-$depth.tif" --bits 16 -q -o "picture-$depth.png" &&
            "$@" develop "whole-$depth.tif" --bits 16 -q -o "picture-$depth.tif" &&
            "$@" develop "whole-$depth.tif" --raw -q -o "raw-$depth.tif" || return
    done
    "$@" render room --size 60x40 --wavelengths 400:700:100 --renderer raster --no-check -q -o room.tif &&
        "$@" view whole-16.tif -o counts.html && "$@" view whole-32f.tif -o floats.html && "$@" render --again whole-16.tif -q -o again.tif
)

# as_here NAME PROGRAM...: the program's files are those of this machine's program
as_here() {
    title=$1
    shift
    rm -rf "$tmp/there"
    cp -r "$tmp/inputs" "$tmp/there"
    files "$tmp/there" "$@" >"$tmp/out" 2>"$tmp/err" && diff -r "$tmp/here" "$tmp/there" >"$tmp/out"
    ok $? "$title: the files that this machine's program writes"
}

mkdir "$tmp/inputs"
textures "$tmp/inputs" && cp -r "$tmp/inputs" "$tmp/here" && files "$tmp/here" "$PWD/$SPECTRAL" >"$tmp/out" 2>"$tmp/err"
ok $? "this machine's program writes and reads $(find "$tmp/here" -type f | wc -l) files"

as_golden_by 'static, OSMesa' "${STATIC:-build/spectral-static}"
# shellcheck disable=SC2046 # a list of words
built_programs musl-gcc -O2 none $(printf '%s-gcc -O2 none ' $machines)
for machine in $machines; do
    as_here "$machine" "qemu-${machine%%-*}" "$PWD/$builds/$machine-gcc-O2/spectral"
done
done_testing
