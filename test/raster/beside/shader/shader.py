#!/usr/bin/env -S PYTHONPATH=test/shared:test/raster/check /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full release; packages: python3-numpy python3-tifffile; makes: spoil
"""Checks --renderer gl-shader and es-shader: pictures agree with the reference on both of Mesa's drivers, OpenGL 3.3 core
and OpenGL ES 3 draw the same bits, four passes are drawn at once, a planted fault is found, and an OpenGL ES
that cannot read depths is not said to be checked there. FULL: all scenes at 300x200, and 40 random ones; SOAK (`test release`): 200. Prints TAP."""
import json
import os
import re

import numpy as np

import random_scenes
from rendered import EFFECTS, SCENES, SPOIL, TMP, amount, check, done, parts, pages_of, refuses, run, write
from tap import bail_out

FULL = "FULL" in os.environ
SMALL = () if FULL else ("--wavelengths", "400:700:20")


def drawn(scene, renderer, *options):
    """The report of a render, and all samples."""
    stack = os.path.join(TMP, "stack.tif")
    result = run("render", scene, "-o", stack, "--keep", "--json", "-", "--depth", "32f", "--renderer", renderer, *options)
    if result.returncode > 1:
        bail_out(scene, renderer, options, result.stderr)
    return json.loads(result.stdout), pages_of(stack), result


def is_explained(name, result):
    """Surfaces at one depth, as random scenes have them, leave pixels that nobody can check."""
    return result.returncode == 0 or ("random" in name and "error: not verified: " in result.stderr)


def agree(name, scene, *options, drivers=("llvmpipe", "softpipe")):
    for driver in drivers:
        core, pixels, result = drawn(scene, f"gl-shader:{driver}", *options)
        check(is_explained(name, result) and core["gl_renderer"].startswith(driver) and "Core Profile" in core["gl_version"] and
              core["driver_profile"] == driver, f"{name}: OpenGL 3.3 core agrees with {driver}", result.stderr)
        check(0 < (core["check"]["worst_error_over_bound"] or 0) < 1 or "random" in name,
              f"{name}: its errors are within bounds", core["check"])
        es, others, result = drawn(scene, f"es-shader:{driver}", *options)
        check(is_explained(name, result) and es["gl_version"].startswith("OpenGL ES 3") and np.array_equal(pixels, others) and
              core["check"] == es["check"], f"{name}: OpenGL ES 3 draws the same with {driver}", result.stderr)


def scenes():
    size = "300x200" if FULL else "120x80"
    for scene in SCENES:
        agree(scene, scene, *SMALL, "--size", size, drivers=("llvmpipe", "softpipe") if FULL else ("llvmpipe",))
    agree("two groups of lights", write("own.scene", EFFECTS))
    for scene, *options in (("room", "--shading", "flat"), ("colorchecker", "--size", "8300x20"), ("room", "--size", "70x50", "--samples", "2"),
                            ("room", "--accuracy", "0.5"), ("metals", "--sampling", "xyz"), ("patches", "--strict")):
        size = () if "--size" in options else ("--size", "60x40")
        agree(f"{scene} {' '.join(options)}", scene, *size, *options, drivers=("llvmpipe",))
    random_scenes.write_textures(TMP)
    for seed in range(1, 1 + amount(5, 40, 200)):
        agree(f"random scene {seed}", random_scenes.put(random_scenes.scene(seed, (64, 64)), TMP, str(seed)), drivers=("llvmpipe",))


def work():
    """31 wavelengths are 11 passes: three batches of at most four; and a pass for each with lighting of OpenGL's own."""
    words = ("--size", "60x40", "--wavelengths", "400:700:10", "--no-check")
    fixed, _, _ = drawn("colorchecker", "gl", "--gl", "egl", *words)
    shader, _, _ = drawn("colorchecker", "gl-shader", *words)
    check(fixed["work"]["gl_passes"] == 11 and shader["work"]["gl_passes"] == 3, "four passes are drawn at once", fixed["work"], shader["work"])
    check(fixed["work"]["draw_calls"] * 3 == shader["work"]["draw_calls"] * 11, "with so many fewer draw calls", fixed["work"], shader["work"])
    for name in ("gl-shader", "es-shader"):
        again = run("verify", "patches", "--renderer", name)
        check(again.returncode == 0 and f"--gl auto --renderer {name}: " in again.stdout, f"verify takes {name}", again.stdout, again.stderr)


def faults():
    fault = {"SPOIL": "diffuse", "LD_PRELOAD": SPOIL}
    for name in ("gl-shader", "es-shader") if FULL else ("es-shader",):
        result = run("verify", "room", "--gl", "egl", "--renderer", name, **fault)
        check(result.returncode == 1 and "differs" in result.stdout, f"{name}: weak light is found", result.stdout, result.stderr)


def limits():
    words = ("render", "patches", "--size", "60x40", "-o", "/dev/null")
    result = run(*words, "--renderer", "es-shader", SPOIL="depths", LD_PRELOAD=SPOIL)
    check(result.returncode == 0 and "\nnot checked       depths and fragments: there are none\n" in result.stdout and
          "every colour is what" in result.stdout, "OpenGL ES without depths is not checked there, and the report says so", result.stdout)
    for name in ("gl-shader", "es-shader"):
        result = run("render", "room", "--size", "90x60", "-o", "/dev/null", "--renderer", name, SPOIL="unknown", LD_PRELOAD=SPOIL)
        check(result.returncode == 0 and re.search("^bounds +measured: edges to 0.00195 pixel", result.stdout, re.MULTILINE) and
              "drawn by          Foo 9000, " in result.stdout, f"{name}: an unknown driver is measured by shaders", result.stdout, result.stderr)
    result = run(*words, "--renderer", "es-shader", SPOIL="unknown depths", LD_PRELOAD=SPOIL)
    check(result.returncode == 0 and "\nbounds            measured: " in result.stdout and "every colour is what" in result.stdout,
          "an unknown OpenGL ES without depths is measured without them", result.stdout, result.stderr)
    result = run(*words, "--renderer", "es-shader", SPOIL="unknown filters", LD_PRELOAD=SPOIL)
    check(result.returncode == 0 and "\nbounds            measured: " in result.stdout and "agreed: every pixel is" in result.stdout,
          "one that does not filter floats is measured without textures", result.stdout, result.stderr)
    refuses("a linear texture there", "this OpenGL ES does not filter floats; add `nearest`", "render", "room", "-o", "/dev/null", "--renderer", "es-shader",
            status=3, SPOIL="unknown filters", LD_PRELOAD=SPOIL)
    result = run(*words, "--renderer", "gl-shader", "--no-check", SPOIL="unknown", LD_PRELOAD=SPOIL)
    check(result.returncode == 0 and "drawn by          Foo 9000, " in result.stdout, "without a check it draws", result.stderr)
    for renderer, gl, pattern in (("gl-shader", "osmesa", "OSMesa draws without shaders here; add --gl egl"), ("es-shader", "egl:60", "there is no egl:60")):
        refuses(f"{renderer} by {gl}", pattern, *words, "--renderer", renderer, "--gl", gl, status=3)


parts(scenes, work, faults, limits)
done()
