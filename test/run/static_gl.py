#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile; makes: static
"""Compares OpenGL's pixels from the static program ($STATIC), which contains softpipe, with those of $SPECTRAL on
llvmpipe. Each program reports the distance of its OpenGL from the same reference; this bounds the distance of both
pictures in all samples, except samples that either program finds apart, and ambiguous pixels, where each may show
another surface. Floors leave half a count of rounding to each."""
import json
import os
import subprocess
import sys

import numpy as np

sys.dont_write_bytecode = True
from rendered import SPECTRAL, TMP, check, done, pages_of
from tap import skip_all

# Softpipe takes most of the time, band by band.
SIZE = (["--size", "600x400"] if os.environ.get("FULL") else
        ["--size", "300x200", "--wavelengths", "300:760:46"])
STATIC = os.environ.get("STATIC", "build/spectral-static")
SMOOTH = 256  # counts between neighbouring pixels; SMOOTH_COUNTS in spectral.h


def render(program, scene, renderer, *options):
    """The stack as [band, y, x], and the report, or None if the program failed."""
    path = os.path.join(TMP, "stack.tif")
    environment = dict(os.environ, GALLIUM_DRIVER="llvmpipe") if program == SPECTRAL else None
    result = subprocess.run([program, "render", scene, "-o", path, "--renderer", renderer, *SIZE,
                             "--json", "-", "--quiet", *options],
                            stdout=subprocess.PIPE, env=environment, check=False)
    if result.returncode != 0:
        return None, None
    return pages_of(path).astype(int), json.loads(result.stdout)


def steepness(stack):
    """The largest change to a neighbour, in any band."""
    padded = np.pad(stack, ((0, 0), (1, 1), (1, 1)), mode="edge")
    height, width = stack.shape[1:]
    steps = [np.abs(padded[:, y:y + height, x:x + width] - stack).max(axis=0)
             for y, x in np.ndindex(3, 3)]
    return np.max(steps, axis=0)


def compare(scene):
    ours, our_report = render(STATIC, scene, "gl")
    theirs, their_report = render(SPECTRAL, scene, "gl")
    reference, _ = render(SPECTRAL, scene, "raster", "--no-check")
    check(ours is not None and theirs is not None, f"{scene}: both agree with the reference")
    if ours is None or theirs is None:
        return
    drivers = [report["gl_renderer"].split()[0] for report in (our_report, their_report)]
    check(drivers == ["softpipe", "llvmpipe"], f"{scene}: softpipe draws one picture and llvmpipe the other")
    check(our_report["full_scale"] == their_report["full_scale"], f"{scene}: both have the same full scale")
    checks = [report["check"] for report in (our_report, their_report)]
    ambiguous = sum(each["ambiguous_pixels"] for each in checks)
    samples = np.abs(ours - theirs)
    pixels = samples.max(axis=0)
    inside = steepness(reference) <= SMOOTH
    print(f"# {scene}: softpipe loses {checks[0]['edge_holes']} and doubles {checks[0]['edge_doubles']} "
          "fragments where triangles meet")
    for where, name in ((inside, "inside surfaces"), (~inside, "on edges")):
        print(f"# {scene}: of {where.sum()} pixels {name} {np.count_nonzero(pixels[where])} differ, "
              f"{np.count_nonzero(pixels[where] > 1)} by more than 1 count, by at most {pixels[where].max()}")
    # Samples that both programs report as equal to the reference's count, or within one count.
    for key, counts in (("exact", 0), ("within_1", 2)):
        apart = np.count_nonzero(samples > counts)
        most = sum(each["samples"] - each[key] for each in checks) + ambiguous * len(samples)
        print(f"# {scene}: {apart} of {samples.size} samples differ by more than {counts} counts; "
              f"{most} may")
        check(apart <= most, f"{scene}: samples are as near as both are to the reference ({key})")
    floors = 1 + sum(each["floor_worst_counts"] for each in checks)
    apart = np.count_nonzero(pixels > floors)
    print(f"# {scene}: {apart} pixels differ by more than {floors:.1f} counts; {ambiguous} may")
    check(apart <= ambiguous, f"{scene}: both are within the sum of their floors, except at ambiguous pixels")


def main():
    if not os.access(STATIC, os.X_OK):
        skip_all(f"no {STATIC}: ./build.sh static")
    for scene in ("colorchecker", "room", "metals"):
        compare(scene)
    done()


main()
