#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile libosmesa6-dev; makes: faults mutants
"""Tests shadows: planted faults are found, shadows cost nothing where none falls into view, and parts, threads and samples do not
change them. Faults 88 to 95 are those of test/README.md. MOVED_MUTANT is the program whose shadow volumes are those of lights that
are moved. Prints TAP."""
import json
import os
import re

import numpy as np
import tifffile

from rendered import FAULTS, SPECTRAL, bytes_of, check, done, path_of, run, write

SCENE = "test/cases/faults/shadows.scene"
MUTANT = os.path.join(os.path.dirname(SPECTRAL), "test/spectral-moved")
DRIVERS = "llvmpipe", "softpipe"
TEXT = open(SCENE).read()


def report(path, *options, program=SPECTRAL, **environment):
    """The exit status, the report and the message of a render."""
    result = run("render", path, "-o", "/dev/null", "--quiet", "--json", "-", *options, program=program, **environment)
    return result.returncode, json.loads(result.stdout) if result.returncode < 2 else None, result.stderr


# ---- planted faults ----

def faults():
    for driver in DRIVERS:
        for number in 0, 88, 89, 90, 92, 93, 94, 95:
            status, found, message = report(SCENE, GALLIUM_DRIVER=driver, LD_PRELOAD=FAULTS, FAULT=str(number))
            if number == 0:
                check(status == 0 and found["check"]["open_pixels"] < found["check"]["pixels"] / 20,
                      f"{driver}: shadows agree, and few pixels are in doubt", found["check"])
            else:
                check(status == 1 and re.search(r"first at \d+,\d+ on \w+ \(\S+:\d+\): at \d+ nm OpenGL", message),
                      f"{driver}: planted fault {number} is found, with its pixel", message)


def moved_lights():
    """Moves the lights of the volumes, but not of the reference, along the x of each mesh."""
    big = write("moved.scene", re.sub(r"size 96 64", "size 384 256", TEXT))
    least = None
    for exponent in range(0, 24):
        status, _, _ = report(big, program=MUTANT, MOVED=str(2.0 ** -exponent))
        if status == 1:
            least = 2.0 ** -exponent
    status, _, _ = report(big, program=MUTANT, MOVED="0")
    check(status == 0, "lights that are moved by 0 agree")
    # the ball is 1.1 above the floor, and its light 6.8 above it; a unit of the floor is about 30 pixels wide
    pixels = least and least * 1.1 / 6.8 * 30
    check(pixels and pixels < 0.2, "a light is moved by less than moves a shadow by 1/5 pixel, and that is found", least, pixels)
    print(f"# the least move that is found: {least:.3g}, which moves the ball's shadow by about {pixels:.2g} pixels")


# ---- what shadows cost ----

def economy():
    plain = write("plain.scene", TEXT.replace(" shadows", ""))
    none = write("none.scene", TEXT.replace(" material", " casts no material"))
    away = write("away.scene", re.sub(r"object sphere .*", "object sphere 0.9 20 12 material ball translate 0 0 -60", none_of(TEXT)))
    status, first, _ = report(plain)
    for path, what in (none, "no object casts a shadow"), (away, "shadows fall out of view"):
        _, found, _ = report(path)
        check(status == 0 and found["work"]["gl_passes"] == first["work"]["gl_passes"] and not found["effects"]["shadows"],
              f"where {what}, OpenGL draws as many passes as without shadows", found["work"], first["work"])
    stacks = [stack_of(path, "--renderer", "raster", "--no-check") for path in (plain, none)]
    check(np.array_equal(*stacks), "and the pixels are those without shadows")
    said = run("plan", away).stdout
    check("no object throws a shadow into view" in said, "plan says so", said)


def none_of(text):
    """All objects but the sphere cast no shadow."""
    return re.sub(r"(object plane .*) material", r"\1 casts no material", text)


def stack_of(path, *options):
    out = path_of("stack.tif")
    result = run("render", path, "-o", out, "--quiet", *options)
    check(result.returncode == 0, f"{os.path.basename(path)} {' '.join(options)} is drawn", result.stderr)
    return tifffile.imread(out)


# ---- invariances ----

def invariances():
    raster = stack_of(SCENE, "--renderer", "raster")
    for options in ("--threads", "1"), ("--threads", "7"):
        check(np.array_equal(raster, stack_of(SCENE, "--renderer", "raster", *options)), f"the same pixels by {options}")
    gl = stack_of(SCENE).astype(int)
    check(np.mean(np.abs(gl - raster) > 1) < 0.01, "OpenGL has the reference's shadows but at few pixels")
    parts = [path_of(f"{i}.tif") for i in (1, 2)]
    tall = "--size", "2400x1600"
    for i, part in enumerate(parts):
        run("render", SCENE, *tall, "--part", f"{i + 1}/2", "-o", part, "--quiet")
    whole, joined = path_of("whole.tif"), path_of("joined.tif")
    run("render", SCENE, *tall, "-o", whole, "--quiet")
    result = run("join", "-o", joined, *parts)
    check(result.returncode == 0 and bytes_of(whole) == bytes_of(joined), "parts make the bytes of the whole", result.stderr)
    for options in ("--samples", "4"), ("--shading", "flat"), ("--depth", "16"), ("--accuracy", "1"):
        status, found, message = report(SCENE, *options)
        check(status == 0, f"shadows agree with {' '.join(options)}", message, found and found["check"])
    dark = []
    for shading in "smooth", "phong":
        words = "--shading", shading, "--renderer", "raster", "--full-scale", "2"
        plain = write("plain.scene", TEXT.replace(" shadows", ""))
        dark.append(stack_of(SCENE, *words)[0] < stack_of(plain, *words)[0])
    check(np.mean(dark[0]) > 0.05 and np.mean(dark[0] != dark[1]) < 0.005, "Phong shading has the same shadows",
          np.mean(dark[0]), np.mean(dark[0] != dark[1]))


faults()
moved_lights()
economy()
invariances()
done()
