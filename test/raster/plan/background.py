#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""A background is its spectrum times its intensity wherever no object is, in every way of drawing, size and camera, and changes nothing
on the objects. Prints TAP."""
import json

import numpy as np
import tifffile

from rendered import D65, TMP, check, done, run, write

SCENE = """wavelengths 300 760 5
size 60 40
{camera}
light d65 1 position 3 3 5
ambient d65 0.1
material m {{ diffuse 0.5 }}
object sphere 0.8 material m
{background}
"""
CAMERAS = {"perspective": "camera perspective 30 near 1 far 60 eye 0 0 5 look 0 0 0",
           "ortho": "camera ortho 4 near -3 far 900 eye 1 2 5 look 0 0 0 up 1 0 0",
           "deep": "camera perspective 120 near 0.01 far 40 eye 0 0.5 2 look 0 0 0"}


def stack(camera, background, *options):
    path = write("b.scene", SCENE.format(camera=CAMERAS[camera], background=background))
    result = run("render", path, *options, "-o", f"{TMP}/b.tif", "--depth", "32f", "--json", "-", "--quiet")
    return (tifffile.imread(f"{TMP}/b.tif"), json.loads(result.stdout)) if result.returncode == 0 else (result.stderr, {})


for camera in CAMERAS:
    for options in (), ("--renderer", "raster"), ("--size", "30x90"), ("--shading", "flat"), ("--renderer", "softpipe"), (
            "--renderer", "gl-shader:llvmpipe"):
        name = f"{camera} {' '.join(options)}"
        plain, _ = stack(camera, "", *options)
        got, report = stack(camera, "background d65*2 0.25", *options)
        behind = np.all(plain == 0, axis=0)
        check(behind.any() and np.allclose(got[:, behind], (0.5 * D65)[:, None], rtol=1e-5),
              f"{name}: the background is d65 x 0.5 everywhere behind the sphere")
        check(np.array_equal(got[:, ~behind], plain[:, ~behind]), f"{name}: the sphere keeps its values")
        if "raster" not in options:
            check(report["check"]["unexplained_pixels"] == 0 and report["check"]["unbounded_pixels"] == 0,
                  f"{name}: every pixel is checked", report.get("check"))
result = run("plan", write("twice.scene", "background d65 1\nbackground a 1\n"))
check(result.returncode == 2 and "twice.scene:2:1: error: background is given twice" in result.stderr, "one background", result.stderr)
result = run("plan", write("none.scene", "background d65\n"))
check(result.returncode == 2 and "expected a number: intensity" in result.stderr, "a background has an intensity", result.stderr)
done()
