#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Makes data/builtin/displays/ again, the ICC profiles of displays (ICC.1:2010, version 4.3) that pictures embed, and the numbers of the
thesis's monitor: `test/make/profiles.py FOLDER` writes them into FOLDER. A profile has three colorants and three curves. Those of sRGB are
those of raster/beside/colour/display.c, which puts the numbers of any other display into own.icc; profiles.py tests them. No copyright."""
import os
import struct
import sys

import numpy as np

D50 = np.array([0.9642, 1, 0.8249])
D65 = np.array([0.3127, 0.3290, 0.3583]) / 0.3290
BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
PRIMARIES = np.array([[0.64, 0.30, 0.15], [0.33, 0.60, 0.06], [0.03, 0.10, 0.79]])  # IEC 61966-2-1
SRGB = PRIMARIES * np.linalg.solve(PRIMARIES, D65)  # from linear RGB to XYZ
# The thesis's monitor: from XYZ of Y = 100; linear = (gain x value)^exponent
MONITOR = np.array([[0.03426, -0.01633, -0.005365], [-0.01026, 0.01911, 0.0002522], [0.000529, -0.001811, 0.00867]])
GAIN, EXPONENT = np.array([1.035, 1.053, 1.047]), np.array([1.534, 1.393, 1.435])


def fixed(numbers):
    return np.floor(np.ravel(numbers) * 65536 + 0.5).astype(">i4").tobytes()


def text(words):
    """A multiLocalizedUnicodeType (10.13) with one text."""
    return struct.pack(">4s3I4s2I", b"mluc", 0, 1, 12, b"enUS", 2 * len(words), 28) + words.encode("utf-16-be")


def curve(numbers):
    """A parametricCurveType (10.15): function 3, or function 1 of three numbers."""
    return struct.pack(">4sI2H", b"para", 0, 1 if len(numbers) == 3 else 3, 0) + fixed(numbers)


def profile(name, to_xyz, curves):
    """to_xyz: from the largest linear values to XYZ. White is adapted to D50 by Bradford's transform."""
    to_xyz = to_xyz / to_xyz[1].sum()
    white = to_xyz.sum(axis=1)
    adaptation = np.linalg.inv(BRADFORD) * (BRADFORD @ D50 / (BRADFORD @ white)) @ BRADFORD
    tags = [("desc", text(name)), ("cprt", text("No copyright, use freely")), ("wtpt", b"XYZ \0\0\0\0" + fixed(D50)),
            ("chad", b"sf32\0\0\0\0" + fixed(adaptation))]
    tags += [(f"{c}XYZ", b"XYZ \0\0\0\0" + fixed(column)) for c, column in zip("rgb", (adaptation @ to_xyz).T)]
    tags += [(f"{c}TRC", curve(numbers)) for c, numbers in zip("rgb", curves)]
    table, data = struct.pack(">I", len(tags)), b""
    for tag, content in tags:
        table += struct.pack(">4s2I", tag.encode(), 132 + 12 * len(tags) + len(data), len(content))
        data += content + bytes(-len(content) % 4)
    # The date is fixed, so that each run writes the same bytes.
    head = struct.pack(">3I12s3H6x4s28x", 132 + 12 * len(tags) + len(data), 0, 0x04300000, b"mntrRGB XYZ ", 2000, 1, 1, b"acsp")
    return (head + fixed(D50)).ljust(128, b"\0") + table + data


LARGEST = np.linalg.inv(MONITOR) * GAIN ** EXPONENT
for file, made in (
        ("srgb", profile("sRGB", SRGB, 3 * [(2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)])),
        ("own", profile("Display, by its numbers", LARGEST, [(e, 1, 0) for e in EXPONENT]))):
    with open(os.path.join(sys.argv[1], f"{file}.icc"), "wb") as out:
        out.write(made)
with open(os.path.join(sys.argv[1], "monitor.csv"), "w", encoding="ascii") as out:
    out.write("""# The monitor of G. M. Johnson's thesis of 1998, with the figures of its program: the matrix from XYZ to linear values, which it
# prints, became the primaries at full drive. The Y of a picture's white is 100. A channel's linear value is (gain x value + offset)^gamma.
primary,X,Y,Z
""")
    for name, column in zip(("red", "green", "blue"), LARGEST.T):
        out.write(f"{name},{','.join(f'{number:.17g}' for number in column)}\n")
    out.write("channel,red,green,blue\n")
    for name, row in (("gain", GAIN), ("offset", (0, 0, 0)), ("gamma", EXPONENT)):
        out.write(f"{name},{','.join(f'{number:g}' for number in row)}\n")
