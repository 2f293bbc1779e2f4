#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Makes a PNG for people of a stack: CIE 1931 observer, sRGB (IEC 61966-2-1), a built-in light as white.
usage: test/picture.py STACK.tif PICTURE.png [LIGHT]"""
import struct
import sys
import zlib

import numpy as np
import tifffile

TO_SRGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
D65_WHITE = np.array([0.9505, 1.0, 1.0890])


def table(name):
    return np.array([line.split(",") for line in open(f"data/tables/{name}.csv") if line[0].isdigit()],
                    float).T


def png(path, pixels):
    height, width, _ = pixels.shape
    up = np.diff(pixels, axis=0, prepend=np.zeros((1, width, 3), np.uint8))  # PNG's filter 2
    rows = b"".join(b"\2" + row.tobytes() for row in up)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0))
                  + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


stack, picture = sys.argv[1:3]
light = sys.argv[3] if len(sys.argv) > 3 else "d65"
with tifffile.TiffFile(stack) as tiff:
    radiance = np.array([page.asarray() for page in tiff.pages], float)
    wavelengths = np.array(tiff.pages[0].tags[65000].value, float)
observer = table("cie1931")
curves = np.array([np.interp(wavelengths, observer[0], curve) for curve in observer[1:]])
white = curves @ np.interp(wavelengths, *table(light))
xyz = np.tensordot(curves, radiance, 1)
xyz *= (D65_WHITE / white)[:, None, None] / (xyz[1] / white[1]).max()
rgb = np.tensordot(TO_SRGB, xyz, 1).clip(0, 1)
encoded = np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * rgb ** (1 / 2.4) - 0.055)
png(picture, (encoded.transpose(1, 2, 0) * 255 + 0.5).astype(np.uint8))
