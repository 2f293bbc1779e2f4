#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile libosmesa6-dev; makes: faults
"""Bounds from above. A bound that is too wide lets faults pass, and no picture shows it. So the scenes of planted faults and some hard
cases, which need different bounds, have the floors (the largest errors that can pass) of test/cases/floors.txt, as many pixels in
doubt, and errors that come as near to their bounds. In those of several passes a sample that is a third above its floor is found, so that
floors are true. Prints TAP.

    test/raster/bounds/floors.py          the test
    test/raster/bounds/floors.py renew    writes test/cases/floors.txt; a change needs a reason"""
import concurrent.futures
import glob
import json
import os
import sys

import numpy as np
import tifffile

from rendered import FAULTS, cases, check, done, path_of, run

TABLE = "test/cases/floors.txt"
HARD = ("far-slanted near-cuts-sliver slivers-sides texture-slivers gloss-two-sided flat-slivers mirrored tiles-wide "
        "shadow-candle shadow-mirrored shadow-open thin-at-border rigid-0.5e-6 normals-unit light-in-surface edge-on-almost "
        "border-diagonal shadow-far-cut shift-perspective-1e6 scale-anisotropic").split()
OPTIONS = {"patches 8": ("--buffer", "8"), "textures 32f": ("--depth", "32f"), "lights samples": ("--samples", "2"),
           "floor softpipe": ("--renderer", "softpipe"), "lights softpipe": ("--renderer", "softpipe"),
           "mipmaps softpipe": ("--renderer", "softpipe"), "shadows softpipe": ("--renderer", "softpipe"), "textures flat": ("--shading", "flat")}
NUMBERS = ("mean floor, mean floor in one band, pixels not checked, ambiguous pixels, largest mean residual, open pixels at edges, "
           "floors within 256 counts, error / bound, error / bound of bands, error / bound of depths").split(", ")
SAME = 7  # so many of these follow from the scene alone; errors are Mesa's, whose versions differ
# The fault changes what OpenGL draws second: there another tile, or a light that is dark at the pixel.
SECOND_IS_OTHER = "tiles-wide", "shadow-candle"
CHANGE, LESS = 0.002, 0.5


def scenes():
    """The name of a row, its scene and options."""
    paths = sorted(glob.glob("test/cases/faults/*.scene")) + [f"data/builtin/hard/{name}.scene" for name in HARD] + \
        ["test/cases/hard/light-grazing-two.scene", "test/cases/verdict/coarse-depth.scene"]
    rows = [(os.path.basename(path)[:-6], path, ()) for path in paths]
    return rows + [(name, f"test/cases/faults/{name.split()[0]}.scene", options) for name, options in OPTIONS.items()]


def measure(row):
    """Returns the numbers of a scene, and a pixel inside a surface with its floor in one band."""
    name, path, options = row
    full = ("--full-scale", "0.5") if name == "bright" else ()
    out = path_of(name.replace(" ", "-"))
    result = run("render", path, "-q", "-o", "/dev/null", "--check-map", out + ".tif", "--json", "-", "--unchecked", "1", *full, *options)
    if result.returncode:
        return None, result.stderr
    floor, alone, _, kind = tifffile.imread(out + ".tif").astype(float)
    report = json.loads(result.stdout)
    found = report["check"]
    known = (floor >= 0) & np.isfinite(floor) & (floor < 65535)
    numbers = [floor[known].mean(), alone[known].mean(), found["unchecked_pixels"], found["ambiguous_pixels"],
               found["mean_residual_limit_counts"], found["open_edge_pixels"], found["floor_within_256"], found["worst_error_over_bound"], found["worst_band_error_over_bound"],
               found["worst_depth_error_over_bound"]]
    inside = known & (kind == 0) & (alone > 0)
    inside[[0, -1]] = inside[:, [0, -1]] = False
    if "--samples" in options or report["work"]["gl_passes"] < 2 or name in SECOND_IS_OTHER:
        return numbers, None
    y, x = np.nonzero(inside)
    middle = np.argsort(alone[inside])[len(y) // 2] if len(y) else 0
    return numbers, (int(x[middle]), int(y[middle]), alone[y[middle], x[middle]]) if len(y) else None


def plant(row, spot):
    """Plants a sample that is off by a third more than its floor. Returns whether it is found, and the message."""
    name, path, options = row
    x, y, floor = spot
    full = ("--full-scale", "0.5") if name == "bright" else ()
    found = run("render", path, "-q", "-o", "/dev/null", *full, *options, FAULT="73", FAULT_PIXEL=f"{x},{y}",
                FAULT_COUNTS=f"{4 / 3 * floor + 1e-3:.9g}", LD_PRELOAD=FAULTS)
    return found.returncode == 1 and f"first at {x},{y}" in found.stderr, found.stderr


def main():
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        rows = list(cases(scenes(), lambda row: row[0]))
        measured = dict(zip((row[0] for row in rows), pool.map(measure, rows)))
        if sys.argv[1:] == ["renew"]:
            with open(TABLE, "w", encoding="utf-8") as file:
                file.write(f"# {', '.join(NUMBERS)}, by scenes: test/raster/bounds/floors.py renew\n")
                for name, (numbers, _) in measured.items():
                    file.write(f"{name}: {' '.join(f'{number or 0:.6g}' for number in numbers)}\n")
            return
        with open(TABLE, encoding="utf-8") as file:
            table = {name: [float(word) for word in numbers.split()] for name, numbers in
                     (line.split(":") for line in file if not line.startswith("#"))}
        spots = [(row, measured[row[0]][1]) for row in rows if isinstance(measured[row[0]][1], tuple)]
        planted = dict(zip((row[0] for row, _ in spots), pool.map(lambda job: plant(*job), spots)))
    for row in cases(rows, lambda row: row[0]):
        name = row[0]
        numbers, spot = measured[name]
        if not check(numbers is not None, f"{name}: bounds hold", spot):
            continue
        wide = [f"{what}: {number:.6g}, was {limit:.6g}" for what, number, limit in zip(NUMBERS[:SAME], numbers, table[name])
                if not abs(number - limit) <= CHANGE * limit + 1e-9]
        check(not wide, f"{name}: floors and pixels in doubt are those of {TABLE}", *wide)
        far = [f"{what}: {number:.6g}, was {least:.6g}" for what, number, least in zip(NUMBERS[SAME:], numbers[SAME:], table[name][SAME:])
               if (number or 0) < LESS * least]
        check(not far, f"{name}: errors come as near to their bounds", *far)
        if name in planted:
            check(planted[name][0], f"{name}: a sample that is a third above its floor is found", spot, planted[name][1])
    done()


main()
