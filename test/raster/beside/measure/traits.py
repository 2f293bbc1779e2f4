#!/usr/bin/env -S PYTHONPATH=test/shared:test/raster/check /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile libosmesa6-dev; makes: faults
"""Checks the measurement of a driver by its targets (raster/beside/measure): of Mesa's two drivers it finds what the program has
for them; an OpenGL of another name agrees by what was measured; and one that does something else gets wider bounds, is
refused with the reason, or differs where it shows. Prints TAP."""
import json
import os
import re

import numpy as np
import tifffile

import random_scenes
from rendered import FAULTS, SCENES, TMP, check, done, parts, run, write

FULL = "FULL" in os.environ
LIES = {"": "0", "fill": "9", "first": "12", "clamp": "36", "diffuse": "49", "gloss": "85", "dull": "86", "shift": "87",
        "low": "101", "coarse": "102", "filter": "103", "passes": "104"}  # their numbers in faults.md
REFUSED = "the driver cannot be checked: its targets differ by more than OpenGL leaves free: the pictures differ at "
HONEST = {"edge_px": 2.0**-9, "value_px": 0, "value_roundings": 5, "depth_steps": 2, "filter_texels": 0, "lighting": 1, "detail": 0, "watertight": True}


def lying(lie, *words, driver="llvmpipe", **environment):
    return run(*words, **{"FAULT": LIES[lie], "FAULT_RENDERER": "Liar", "LD_PRELOAD": FAULTS, "GALLIUM_DRIVER": driver, **environment})


def known_drivers():
    report = json.loads(run("drivers", "--json", "-").stdout)
    for one in report["drivers"]:
        if one["usable"]:
            check(one["cannot_be_checked"] is None and one["measured_bounds"] == HONEST,
                  f"{one['gl']} {one['renderer']}: by its targets {one['gl_renderer'].split()[0]} is as good as Mesa's drivers are known to be", one)


def drivers_without_a_name():
    """The bounds that were measured hold as those that are known."""
    random_scenes.write_textures(TMP)
    random = [random_scenes.put(random_scenes.scene(seed, (64, 64)), TMP, str(seed)) for seed in range(1, 101 if FULL else 7)]
    for driver, scenes in (("llvmpipe", SCENES + random), ("softpipe", (SCENES + random)[::1 if FULL else 3])):
        for scene in scenes:
            size = () if scene in random else ("--size", "120x80", "--wavelengths", "400:700:60")
            words = "render", scene, *size, "-o", "/dev/null"
            result = lying("", *words, driver=driver)
            by_name = run(*words, "--renderer", driver).stdout if scene in random and result.returncode else ""
            check(re.search(r"^bounds +measured: edges to ", result.stdout, re.MULTILINE) and
                  ("verdict           agreed: every pixel is" in result.stdout or ("not verified" in result.stdout and "not verified" in by_name)),
                  f"an unknown {driver} agrees: {scene}", result.stdout, result.stderr)
    result = lying("", "render", "patches", "--size", "60x40", "-o", "/dev/null", "--no-check", "--json", "-")
    check(result.returncode == 0 and json.loads(result.stdout)["driver_profile"] is None, "nothing is measured without a check", result.stderr)


def textured():
    """A small texture: a lie makes it 32 times as large a side."""
    generator = np.random.default_rng(1)
    tifffile.imwrite(os.path.join(TMP, "small.tif"), (generator.random((8, 8)) * 65535).astype(np.uint16), photometric="minisblack")
    return write("small.scene", """wavelengths 400 700 60
size 150 100
camera perspective 50 eye 0 0 4
ambient e 0.2
light d65 1 position 1 1 3
material m { diffuse 0.7 specular 0.3 gloss 40 texture small.tif bilinear }
object plane 4 3 material m rotate 40 1 0 0
object sphere 0.6 40 20 material m translate 0 0 0.8
""")


def liars():
    scene = textured()
    for lie, words in (("fill", "edges to 0.00195 pixel, values to 0,"), ("low", "depth to 2 step"),
                       ("filter", "filters to 0.0156"), ("gloss", "light to 1 x Mesa's")):
        result = lying(lie, "render", scene, "-o", "/dev/null", "--unchecked", "1")
        check(result.returncode == 0 and re.search(f"^bounds +measured: .*{re.escape(words)}", result.stdout, re.MULTILINE),
              f"{lie}: the bounds hold", result.stdout, result.stderr)
        if lie == "filter":  # the bounds of Mesa would not do
            result = lying(lie, "render", scene, "-o", "/dev/null", "-v", "--unchecked", "1", FAULT_RENDERER="llvmpipe")
            check(result.returncode == 1 and "bounds            of llvmpipe\n" in result.stdout,
                  f"{lie}: under the name of llvmpipe it differs", result.stdout, result.stderr)
    for lie, words in (("coarse", r"\d+ of 77120 pixels, .*: OpenGL's depth "), ("clamp", ""), ("passes", ".*: at 450 nm OpenGL "),
                       ("dull", ".* on plate .*: at 450 nm OpenGL "), ("diffuse", ".*OpenGL is off at 550 nm by .*; all other bands fit together"),
                       ("shift", ".*: OpenGL draws ")):
        output = os.path.join(TMP, "refused.tif")
        result = lying(lie, "render", scene, "-o", output)
        check(result.returncode == 3 and re.fullmatch(f"error: {REFUSED}{words}.*\n", result.stderr) and not os.path.exists(output),
              f"{lie}: it is refused, with the reason", result.stdout, result.stderr)
        if lie == "coarse" or FULL:
            result = lying(lie, "drivers")
            check(re.search(f"cannot be checked: {REFUSED}{words}", result.stdout, re.MULTILINE), f"{lie}: drivers says why", result.stdout)
    # the targets are smooth, so that only a flat picture shows this
    result = lying("first", "render", "test/cases/faults/flat.scene", "-o", "/dev/null")
    check(result.returncode == 1 and "the pictures differ at " in result.stderr, "first: a flat picture differs", result.stdout, result.stderr)


def table():
    """A line a driver; with -v one a trait, with what OpenGL allows."""
    brief, text = (run("drivers", *words).stdout for words in ((), ("-v",)))
    rows = re.findall(r"^    (\S.*?)  +\S.*?  +(\S.*)$", text, re.MULTILINE)
    check(rows[:8] == [("edges", "1/16"), ("corners of values", "1/16"), ("values in triangles", "1e-05 an operation"),
                       ("depth", "1.5 and a rounding"), ("linear filtering", "no rule; bounded to 1/16"), ("lighting", "1e-05 an operation"),
                       ("where triangles meet", "each pixel once"), ("level of detail", "any corner, norm and logarithm")] and len(rows) % 8 == 0,
          "the table has eight traits", text)
    check(len(brief.splitlines()) == len(re.findall("^--gl ", text, re.MULTILINE)) and brief.count(" subpixel and 24 depth bits, can be checked\n") == text.count("\n    edges "),
          "without -v there is a line a driver", brief)


parts(known_drivers, drivers_without_a_name, liars, table)
done()
