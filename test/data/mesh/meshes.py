#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile glmark2-data
"""Renders a real mesh with the program ($SPECTRAL) and cross-checks every pixel at 93 wavelengths: the Stanford
bunny of Debian's glmark2-data, 69 thousand triangles under two lights. Prints TAP."""
import json

from rendered import check, done, run, write

SCENE = """size 800 800
wavelengths 300 760 5
{camera}
light d65 1 position 3 3 8
light a 0.5 direction -1 0.5 1
material clay {{ diffuse gaussian:600,150*0.8 {gloss} }}
object mesh /usr/share/glmark2/models/bunny.obj unitize material clay
"""
VIEWS = {
    "matt": {"camera": "camera ortho 2.4", "gloss": ""},
    "glossy, in perspective": {
        "camera": "camera perspective 40 near 1 far 10 eye 0 0.3 3 look 0 0 0",
        "gloss": "gloss 20 specular 0.3"},
}


def bunny(view, words):
    path = write("bunny.scene", SCENE.format(**words))
    result = run("render", path, "-o", "/dev/null", "--json", "-", "--quiet")
    report = json.loads(result.stdout)["check"]
    check(result.returncode == 0 and report["unexplained_pixels"] == 0,
          f"bunny, {view}: every pixel is explained at all 93 wavelengths", report)
    check(report["unbounded_pixels"] == 0, f"bunny, {view}: every pixel has a bound", report)
    check(report["samples"] == 800 * 800 * 93, f"bunny, {view}: no sample is left out", report)
    check(report["exact"] >= 0.98 * report["samples"],
          f"bunny, {view}: at least 98 % of the counts are exact", report)
    check(report["smooth_pixels"] > 0 and report["smooth_floor_999_counts"] <= 2,
          f"bunny, {view}: an error of 4 counts inside smooth surfaces would be found", report)
    check(0.01 < report["worst_error_over_bound"] < 1,
          f"bunny, {view}: the bounds are neither exceeded nor far too wide", report)


for view, words in VIEWS.items():
    bunny(view, words)
done()
