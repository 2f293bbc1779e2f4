#!/usr/bin/env -S PYTHONPATH=test/shared:test/raster/check /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile libosmesa6-dev; makes: faults liar
"""Checks the measurements of a driver (raster/beside/measure): of Mesa's two drivers they find what data/doc/mesa.md says;
the bounds made of them hold, of an OpenGL of another name (liar.c), too; and an OpenGL that does something else gets wider
bounds, or is refused with the reason. test_mesa.c measures what the program does not. Prints TAP."""
import json
import os
import re

import numpy as np
import tifffile

import random_scenes
from rendered import FAULTS, LIAR, SCENES, TMP, check, done, run, write

FULL = "FULL" in os.environ
PLANTED = {"fill": "9", "first": "12", "clamp": "36", "diffuse": "49", "gloss": "85", "dull": "86", "shift": "87"}  # lies that fault.c has, by their numbers there
STEP = 2.0**-9  # half a step of a grid of 8 bits below a pixel


def lying(lie, *words, driver="llvmpipe", **environment):
    if lie in PLANTED:
        environment = {"FAULT": PLANTED[lie], "LD_PRELOAD": f"{LIAR}:{FAULTS}", **environment}
    return run(*words, **{"LIE": lie, "LD_PRELOAD": LIAR, "GALLIUM_DRIVER": driver, **environment})


def measured(**environment):
    report = json.loads(run("drivers", "--measure", "--json", "-", **environment).stdout)
    return [one for one in report["drivers"] if one["usable"]]


def known_drivers():
    for one in measured():
        traits, bounds = one["traits"], one["measured_bounds"]
        name = f"{one['gl']} {one['gl_renderer'].split()[0]}"
        if "llvmpipe" in name:
            check(0.9 * STEP < traits["edge_px"] <= STEP and traits["subpixel_bits"] == 8, f"{name}: edges lie on a grid of 1/256 pixel", traits)
            check(traits["fill_rule"] == ["left", "bottom"] and traits["centres_on_edges"] > 900 and traits["centres_against_rule"] == 0,
                  f"{name}: it draws left and bottom edges", traits)
            check(traits["edge_holes"] == traits["edge_doubles"] == 0, f"{name}: it draws shared edges once", traits)
            check(-0.501 < traits["depth_steps_low"] < -0.4 and 0.4 < traits["depth_steps_high"] < 0.501, f"{name}: it rounds depths", traits)
            check(traits["sliver_pixels"] == traits["sliver_pixels_not_finite"] > 50 and traits["sliver_pixels_shown"] == 0,
                  f"{name}: triangles without area have no finite colour, and are not shown", traits)
            check(1e-6 < traits["highlight_error"] < 2e-5, f"{name}: highlights have five digits", traits)
            expected = {"edge_px": STEP, "depth_steps": 1, "watertight": True, "exact_fill_rule": True}
        else:
            check(traits["edge_px"] < 1e-5 and traits["subpixel_bits"] == 4, f"{name}: edges lie on no grid", traits)
            check(traits["fill_rule"] == ["right", "top"] and 0 < traits["centres_against_rule"] < 20,
                  f"{name}: it draws right and top edges, but for a few centres", traits)
            check(traits["edge_holes"] > 0 and traits["edge_doubles"] > 0, f"{name}: it leaves holes and doubles", traits)
            check(-1.001 < traits["depth_steps_low"] < -0.9 and traits["depth_steps_high"] == 0, f"{name}: it cuts depths off", traits)
            check(traits["sliver_pixels"] == 0, f"{name}: it draws no triangles without area", traits)
            check(traits["highlight_error"] < 1e-6, f"{name}: highlights have six digits", traits)
            expected = {"edge_px": 0, "depth_steps": 1.5, "watertight": False, "exact_fill_rule": False}
        check(traits["provoking_corner"] == 3 and not traits["clamps_colours"] and traits["filter_texels"] < 1e-6 and
              traits["value_px"] < 1e-4 and traits["normal_roundings"] < 26 and traits["pixels_that_vary_between_passes"] == 0,
              f"{name}: the last corner, no clamp, no steps of filters or corners, equal passes", traits)
        detail = bounds.pop("detail")
        check(1e-4 <= detail < (2e-4 if expected["watertight"] else 0.006) and traits["pixels_that_vary_in_detail"] == 0,
              f"{name}: its level of detail is known to twice what its rule leaves", detail)
        check(bounds == {**expected, "value_px": 0, "filter_texels": 0, "lighting": 1}, f"{name}: the bounds are those that the program has for it", bounds)


def drivers_without_a_name():
    """The bounds that were measured hold as those that are known."""
    random_scenes.write_textures(TMP)
    random = [random_scenes.put(random_scenes.scene(seed, (64, 64)), TMP, str(seed)) for seed in range(1, 101 if FULL else 7)]
    for driver, scenes in (("llvmpipe", SCENES + random), ("softpipe", (SCENES + random)[::1 if FULL else 3])):
        for scene in scenes:
            size = () if scene in random else ("--size", "120x80", "--wavelengths", "400:700:60")
            result = lying("", "render", scene, *size, "-o", "/dev/null", driver=driver)
            check(result.returncode == 0 and re.search(r"^bounds +measured: edges to ", result.stdout, re.MULTILINE) and
                  "verdict           agreed: every pixel is" in result.stdout, f"an unknown {driver} agrees: {scene}", result.stdout, result.stderr)
    result = lying("", "render", "patches", "--size", "60x40", "-o", "/dev/null", "--no-check", "--json", "-")
    check(result.returncode == 0 and json.loads(result.stdout)["driver_profile"] is None, "nothing is measured without a check", result.stderr)
    result = lying("diffuse", "render", "test/cases/faults/lights.scene", "-o", "/dev/null")
    check(result.returncode == 1 and "not explained" in result.stdout, "diffuse light of an unknown driver that is 1/1000 too weak in a band is found", result.stdout, result.stderr)


def textured():
    """A small texture: liar.c makes it 256 times as large a side."""
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
    for lie, words in (("fill", "edges to 0.00195 pixel, values to 0, depth to 1 step,"), ("low", "depth to 2 step"),
                       ("filter", "filters to 0.00391"), ("gloss", "light to 8 x Mesa's")):
        result = lying(lie, "render", scene, "-o", "/dev/null", "--unchecked", "1")
        check(result.returncode == 0 and re.search(f"^bounds +measured: .*{re.escape(words)}", result.stdout, re.MULTILINE),
              f"{lie}: the bounds follow", result.stdout, result.stderr)
        if lie == "filter":  # the bounds of Mesa would not do
            result = lying(lie, "render", scene, "-o", "/dev/null", "-v", "--unchecked", "1", LIAR_NAME="llvmpipe")
            check(result.returncode == 1 and "bounds            of llvmpipe\n" in result.stdout,
                  f"{lie}: under the name of llvmpipe it differs", result.stdout, result.stderr)
    for lie, words in (("coarse", r"depth: -255.50 to \+0.50 steps \(GL_DEPTH_BITS 24\); allowed: -1.5 to 1.5 of 24 bits"),
                       ("clamp", "colours above 1: clamped; allowed: kept"),
                       ("first", "flat colour: of the first corner; allowed: last"),
                       ("passes", r"flat and lit passes: \d+ of \d+ pixels differ; allowed: 0"),
                       ("dull", "highlights: off by 0.0[0-9]+, "),
                       ("shift", r"edges: off by 0.09[0-9]+ pixel \(GL_SUBPIXEL_BITS 8\); allowed: 1/16")):
        output = os.path.join(TMP, "refused.tif")
        result = lying(lie, "render", scene, "-o", output)
        check(result.returncode == 3 and re.fullmatch(f"error: Liar cannot be checked: {words}.*; spectral drivers --measure prints more\n", result.stderr)
              and not os.path.exists(output), f"{lie}: it is refused, with the reason", result.stdout, result.stderr)
        if lie != "coarse" and not FULL:
            continue
        result = lying(lie, "drivers", "--measure")
        check(re.search(f"^  bounds          none: {words}", result.stdout, re.MULTILINE), f"{lie}: the table says why", result.stdout)


def table():
    """One line a trait, with what OpenGL allows."""
    text = run("drivers", "--measure").stdout
    rows = re.findall(r"^    (\S.*?)  +\S.*?  +(\S.*)$", text, re.MULTILINE)
    check(len(rows) % 13 == 0 and rows[:13] == [("edges", "1/16"), ("centres on edges", "any rule"), ("shared edges", "0, 0"),
                                                ("without area", "no rule"), ("depth", "-1.5 to 1.5 of 24 bits"), ("flat colour", "last"),
                                                ("colours above 1", "kept"), ("values in triangles", "1/16"),
                                                ("linear filtering", "no rule; bounded to 1/16"),
                                                ("level of detail", "any rule, twice the same"), ("highlights", "1e-05 an operation"),
                                                ("normals", "1e-05 an operation"), ("flat and lit passes", "0")], "the table has thirteen traits", text)


known_drivers()
drivers_without_a_name()
liars()
table()
done()
