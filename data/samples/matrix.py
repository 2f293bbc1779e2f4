#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""matrix.py OBJECTS.csv [CHANNEL...] > MATRIX.csv: fits the matrix that takes a camera's raw values to XYZ, by least squares
over the objects of a stack.

OBJECTS.csv is what spectral probe STACK --objects --detector CAMERA.csv --csv writes. Channels are taken by their names, or, without
any, all of the camera. MATRIX.csv has a row for each channel: its name, and what a raw value of 1 adds to X, Y and Z. Each object
counts the same; those without pixels are left out. The matrix fits objects like these: other spectra can be further off."""
import csv
import sys

import numpy as np

if len(sys.argv) < 2:
    sys.exit(__doc__)
try:
    with open(sys.argv[1], encoding="utf-8", newline="") as file:
        heading, *rows = list(csv.reader(file)) or [[]]
    behind = ["" for _ in heading[:8]] + heading[8:]  # object, pixels, X, Y, Z, L, a, b: a channel may be named b, too
    own = [name for name in behind if name and name + " standard deviation" in heading and not name.endswith(" nm")]
    channels = sys.argv[2:] or own
    wanted = [(name, heading[:8]) for name in "XYZ"] + [(name, behind) for name in channels]
    for name, names in wanted:
        if names.count(name) != 1:
            raise ValueError(f"expected one column {name}, found {names.count(name)}; its channels: {', '.join(own) or 'none'}")
    columns = [names.index(name) for name, names in wanted]
    table = np.array([[row[i] for i in columns] for row in rows if row[columns[0]]], float).reshape(-1, len(columns))
    if not channels or not np.isfinite(table).all():
        raise ValueError("expected channels of a camera, and numbers that are finite")
except (OSError, ValueError, IndexError) as why:
    sys.exit(f"matrix.py: {sys.argv[1]}: {why}")
matrix, _, rank, _ = np.linalg.lstsq(table[:, 3:], table[:, :3], rcond=None)
if rank < len(channels):
    sys.exit(f"matrix.py: {sys.argv[1]}: its {len(channels)} channels need as many objects with independent raw values, found {rank}")
out = csv.writer(sys.stdout, lineterminator="\n", quoting=csv.QUOTE_NONNUMERIC)  # names may have blanks
out.writerow(["channel", "X", "Y", "Z"])
out.writerows([name, *map(float, row)] for name, row in zip(channels, matrix))
