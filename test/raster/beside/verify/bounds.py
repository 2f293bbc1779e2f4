#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile libosmesa6-dev; makes: faults
"""Checks the legal counts of render --bounds and of export: what each driver draws lies within its own interval and within that of any
driver; an interval is as wide as the floors of the check; and what a planted fault changes lies outside. Prints TAP."""
import json
import os
import re
import subprocess
import sys

import numpy as np
import tifffile

from rendered import FAULTS, SCENES, check, done, output_of, pages_of, parts, path_of, refuses, remove, run

FULL = "FULL" in os.environ
SMALL = "--size", "90x60", "--wavelengths", "400:700:50"
LIBRARIES = {"osmesa": ("llvmpipe", "softpipe"), "egl": (
    "llvmpipe", "softpipe", "gl-shader:llvmpipe", "gl-shader:softpipe", "es-shader:llvmpipe", "es-shader:softpipe")}
WAYS = [("--gl", library, "--renderer", driver) for library, drivers in LIBRARIES.items() for driver in drivers]


def within(stack, bounds):
    """Runs the sample."""
    return subprocess.run([sys.executable, "data/samples/within.py", stack, bounds], capture_output=True, text=True, check=False)


def ends_of(name):
    pages = pages_of(path_of(name)).astype(int)
    return pages[::2], pages[1::2]


def drawn(scene, *words, **environment):
    """The samples of a scene, as they are stored, and their bounds."""
    remove(path_of("own.tif"), path_of("stack.tif"))
    result = run("render", scene, *words, "-o", path_of("stack.tif"), "--bounds", path_of("own.tif"), "--keep", **environment)
    if result.returncode > 1:
        return None
    return pages_of(path_of("stack.tif")).astype(int), *ends_of("own.tif")


def honest():
    """Every way of drawing here, each scene."""
    hard = re.findall(r"^  (hard/\S+)$", output_of("list", "hard"), re.MULTILINE)
    scenes = [(scene, SMALL, WAYS if FULL else WAYS[:2]) for scene in SCENES]
    scenes += [(scene, (), [WAYS[i % len(WAYS)], WAYS[(i + 1) % len(WAYS)]]) for i, scene in enumerate(hard)]
    widths = {"its own": [], "any": []}
    for scene, words, ways in scenes if FULL else scenes[3:7] + scenes[10::20]:
        reference = run("render", scene, *words, "--renderer", "raster", "--no-check", "-o", "/dev/null", "--bounds", path_of("any.tif"),
                        "--json", "-")
        any_low, any_high = ends_of("any.tif")
        n_open = int(((any_low == 0) & (any_high == 65535)).any(axis=0).sum())
        check(f"for any driver: nothing bounds {n_open} pixels\n" in reference.stderr and json.loads(reference.stdout)["unbounded_pixels"] == n_open, f"{scene}: the report counts what nothing bounds",
              reference.stdout, reference.stderr, n_open)
        for way in ways:
            samples, low, high = drawn(scene, *words, *way)
            check(((low <= samples) & (samples <= high)).all() and ((any_low <= low) & (high <= any_high)).all(),
                  f"{scene} {' '.join(way)}: within its interval, and that within any driver's", np.argwhere((samples < low) | (samples > high))[:5])
            if scene in SCENES:
                widths["its own"].append((high - low).ravel())
                widths["any"].append((any_high - any_low).ravel())
    for of, found in widths.items():
        print(f"# width of {of}, in counts: median %g, 99 %% %g" % tuple(np.percentile(np.concatenate(found), (50, 99))))


def as_the_check():
    """A pixel's interval is its floor to both sides, rounded outwards; a pixel of several positions has the mean of theirs."""
    for scene in ("spheres", "textures"):
        output_of("render", scene, *SMALL, "-o", path_of("stack.tif"), "--bounds", path_of("own.tif"), "--check-map", path_of("map.tif"))
        low, high = ends_of("own.tif")
        floor, _, _, classes = tifffile.imread(path_of("map.tif"))
        width, object_pixels = (high - low).max(axis=0), (classes == 0) & (floor > 0)
        inner = object_pixels & (low > 0).all(axis=0) & (high < 65535).all(axis=0)
        check(inner.sum() > 1000 and not (high - low == 65535).any() and (width <= 2 * floor + 2)[inner].all() and (width >= 2 * floor)[inner].all(), f"{scene}: as wide as the floors of the check",
              inner.sum(), (width - 2 * floor)[inner].max(), (width - 2 * floor)[inner].min())
    samples, low, high = drawn("spheres", *SMALL, "--samples", "4")
    check(((low <= samples) & (samples <= high)).all() and np.median(high - low) <= 2, "pixels of several positions, too", np.median(high - low))


def faults():
    """A fault outside of its interval is found without the program; judge and render find more: which triangle a pixel shows, how many
    fragments it has, and whether one geometry explains all bands."""
    with open("test/raster/check/faults.md") as file:
        rows = re.findall(r"^\| (\d+) \|.*\| ([a-z-]+) \|$", file.read().split("| number | fault | scene |")[1].split("\n\n")[0], re.MULTILINE)
    missed = []
    rows = [(number, scene) for number, scene in rows if number not in ("4", "46")]  # of two renders; of the program
    for number, scene in rows if FULL else rows[:24:4]:
        path = f"test/cases/faults/{scene}.scene"
        options = ("--full-scale", "0.5") if scene == "bright" else ()
        found = drawn(path, *options, FAULT=number, LD_PRELOAD=FAULTS)
        if found and ((found[1] <= found[0]) & (found[0] <= found[2])).all():  # None: OpenGL draws no numbers
            missed.append(number)
    print(f"# {len(rows) - len(missed)} of {len(rows)} faults lie outside; within:", *missed)
    check(len(missed) <= (10 if FULL else 1), "most planted faults lie outside of the interval", missed)
    drawn("test/cases/faults/patches.scene", FAULT="43", LD_PRELOAD=FAULTS)
    result = within(path_of("stack.tif"), path_of("own.tif"))
    check(result.returncode == 1 and re.match(r"\d+,\d+ at \d+ nm: \d+, legal \d+ to \d+\n1 of \d+ pixels are outside; nothing bounds 0\n$", result.stdout),
          "within.py names the pixel", result.stdout, result.stderr)
    drawn("test/cases/faults/patches.scene")
    check(within(path_of("stack.tif"), path_of("own.tif")).returncode == 0, "within.py passes honest pixels")


def limits():
    refuses("shading that OpenGL has not", "--bounds are those of OpenGL, which phong shading has not", "render", "patches", *SMALL, "--shading", "phong", "--renderer", "raster",
            "-o", path_of("no.tif"), "--bounds", path_of("no.b.tif"), absent=path_of("no.b.tif"))
    refuses("a part of a picture", "--part takes no --bounds", "render", "patches", "--part", "1/2", "--bounds", path_of("no.b.tif"))
    refuses("a driver without bounds", "beside --bounds only", "render", "patches", "--bounds-for", "any")
    for scene, least in (("half-zero", 900), ("spot-90", 64)):
        samples, low, high = drawn(f"test/cases/hard/{scene}.scene", "--wavelengths", "550", "--bounds-for", "any")
        n_open = (high - low == 65535).sum()
        check(samples.shape == low.shape and len(samples) == 1 and n_open >= least and ((low <= samples) & (samples <= high)).all(),
              f"{scene}: pixels without a bound are open, also in one band", n_open)


parts(honest, as_the_check, faults, limits)
done()
