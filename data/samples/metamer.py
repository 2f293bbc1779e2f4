#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""metamer.py REFLECTANCE.csv OBSERVER.csv LAMP.csv [AMOUNT] > PAIR.csv: makes a metamer, which looks like the reflectance to
the observer under the lamp, and differs from it under other lamps.

The three are tables as spectral show NAME --csv writes them; a camera is an observer, too. In a scene the pair is
`diffuse PAIR.csv:original` and `diffuse PAIR.csv:metamer`. Over the wavelengths of REFLECTANCE.csv both have the same sums of
reflectance x lamp x curve x width: draw the scene at these. Their difference is the metameric black that bends least: of all
blacks with one sum of squares it has the least sum of squared second differences, where it is 0 beyond the table. It is as
large as values from 0 to 1 allow, times AMOUNT: above 0, at most 1 (default)."""
import sys

import numpy as np


def table(path):
    """The wavelengths of a table, and its curves."""
    with open(path, encoding="utf-8-sig") as file:
        heading = file.readline()
        try:
            nm, *curves = np.loadtxt(file, delimiter=",", ndmin=2).T
        except ValueError as why:
            raise ValueError(f"{path}: {why}") from why
    if not curves or len(nm) < 2 or heading[0].isdigit() or not np.isfinite(curves).all() or not (np.diff(nm) > 0).all():
        raise ValueError(f"{path}: expected a heading, and wavelengths that rise, with values behind each")
    return nm, np.array(curves)


if len(sys.argv) not in (4, 5):
    sys.exit(__doc__)
try:
    (nm, originals), (own, curves), (lamp_nm, lamps) = map(table, sys.argv[1:4])
    amount = float((sys.argv + ["1"])[4])
except (OSError, ValueError) as why:
    sys.exit(f"metamer.py: {why}")
original, light = originals[0], np.interp(nm, lamp_nm, lamps[0], 0, 0) * np.gradient(nm)
seen = np.array([np.interp(nm, own, curve, 0, 0) for curve in curves]) * light
if len(originals) != 1 or len(lamps) != 1 or len(nm) <= len(curves) or not seen.any(axis=1).all() or not 0 < amount <= 1:
    sys.exit("metamer.py: expected one reflectance, of more wavelengths than the observer has curves, one lamp, which each curve "
             "sees at these wavelengths, and an amount above 0, at most 1")
blacks = np.linalg.svd(seen)[2][len(seen):].T  # a column each, of length 1 and at right angles; their sums are 0
black = blacks @ np.linalg.svd(np.diff(np.pad(blacks, ((2, 2), (0, 0))), 2, axis=0))[2][-1]
rooms = [(np.where(way > 0, 1 - original, original)[way != 0] / abs(way[way != 0])).min() for way in (black, -black)]
if not (original.min() >= 0 and original.max() <= 1 and max(rooms) > 0):
    sys.exit(f"metamer.py: {sys.argv[1]}: expected values from 0 to 1 that leave room on both sides of the original")
metamer = np.clip(original + amount * max(rooms) * (black if rooms[0] > rooms[1] else -black), 0, 1)
print("nm,original,metamer", *(f"{row[0]:.17g},{row[1]:.17g},{row[2]:.17g}" for row in zip(nm, original, metamer)), sep="\n")
