#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Measures the cost of each effect: renders and cross-checks 24 spheres with it and without it, by turns,
in one run. Prints the ratio of the shortest times, the parts that it falls upon, and the program's
counters.
usage: test/bench/bench_effects.py PROGRAM FOLDER [ROUNDS]"""
import json
import os
import subprocess
import sys

import numpy as np
import tifffile

PROGRAM, FOLDER = sys.argv[1:3]
ROUNDS = int(sys.argv[3]) if len(sys.argv) > 3 else 15
HEAD = "wavelengths 400 700 10\nsize 900 600\ncamera ortho 12\n"
LIGHT = "light d65 1 position 0 0 8"
MATERIAL = "diffuse gaussian:550,120*0.8"
COUNTERS = ("terms", "gl_passes", "vertices_lit", "power_functions", "excitation_integrals",
            "textures_loaded")
# Differences from the plain scene: the light, words added to the material and to the objects, further
# statements.
EFFECTS = (
    ("ambient light", LIGHT, "", "", "ambient a 0.1"),
    ("a second light", LIGHT, "", "", "light a 0.5 position 4 4 8"),
    ("specular", LIGHT, "gloss 30", "", ""),
    ("specular, local viewer", LIGHT, "gloss 30", "", "viewer local"),
    ("attenuation", LIGHT + " attenuation 0 0.1 0.01", "", "", ""),
    ("spot", LIGHT + " spot 0 0 -1 40 8", "", "", ""),
    ("twelve lights", "\n".join("light d65 0.1 direction %d %d 9" % (i % 4, i // 4) for i in range(12)),
     "", "", ""),
    ("fluorescence", LIGHT, "fluorescence gaussian:380,40 gaussian:520,60*0.5", "", ""),
    ("bispectral", LIGHT, "donaldson matrix.csv", "", ""),
    ("emission", LIGHT, "emission 0.1", "", ""),
    ("texture, nearest", LIGHT, "texture texture.tif nearest", "", ""),
    ("texture, bilinear", LIGHT, "texture texture.tif bilinear", "", ""),
    ("texture, mipmaps", LIGHT, "texture texture.tif linear", "", ""),
    ("spectral texture, nearest", LIGHT, "spectral-texture stack.tif nearest", "", ""),
    ("spectral texture, bilinear", LIGHT, "spectral-texture stack.tif bilinear", "", ""),
    ("spectral texture, mipmaps", LIGHT, "spectral-texture stack.tif linear", "", ""),
    ("metameric halves", LIGHT, "metamer other", "", ""),
    ("two-sided", LIGHT, "", "two-sided", ""),
    ("flat shading", LIGHT, "", "", "shading flat"),
)


def scene(light=LIGHT, material="", objects="", statements=""):
    lines = [HEAD, light, statements, "material other { diffuse gaussian:560,110*0.8 }",
             "material used { %s %s }" % (MATERIAL, material)]
    for row in range(4):
        for column in range(6):
            lines.append("object sphere 0.9 40 40 material used %s translate %g %g 0"
                         % (objects, 2 * column - 5, 3 - 2 * row))
    return "\n".join(lines) + "\n"


def write(name, text):
    path = os.path.join(FOLDER, name)
    with open(path, "w") as out:
        out.write(text)
    return path


def render(path, *options):
    output = subprocess.run([PROGRAM, "render", path, "--quiet", "--json", "-", *options],
                            stdout=subprocess.PIPE, check=True).stdout
    return json.loads(output)


def prepare():
    os.makedirs(FOLDER, exist_ok=True)
    ramp = np.add.outer(np.arange(64), np.arange(64)) * 2
    tifffile.imwrite(os.path.join(FOLDER, "texture.tif"), ramp.astype(np.uint8))
    excitation = range(300, 460, 10)
    rows = ["emission/excitation," + ",".join(map(str, excitation))]
    rows += ["%d,%s" % (nm, ",".join(["0.02"] * len(excitation))) for nm in range(480, 600, 10)]
    write("matrix.csv", "\n".join(rows) + "\n")
    plain = write("plain.scene", scene())
    render(plain, "-o", os.path.join(FOLDER, "stack.tif"), "--size", "90x60")
    return plain


def seconds(reports, part):
    return min(report["seconds"][part] for report in reports)


def compare(name, plain, path):
    without, with_it = [], []
    for _ in range(ROUNDS):
        without.append(render(plain, "-o", "/dev/null"))
        with_it.append(render(path, "-o", "/dev/null"))
    total = seconds(with_it, "total") / seconds(without, "total")
    more = [1000 * (seconds(with_it, part) - seconds(without, part))
            for part in ("gl", "raster", "check")]
    counters = [with_it[0]["work"][counter] for counter in COUNTERS]
    print(("%-26s %6.2f" + " %+7.0f" * 3 + " %9d" * len(COUNTERS)) % (name, total, *more, *counters),
          flush=True)


print("24 spheres, 900 x 600 pixels, 31 wavelengths, checked, no file; shortest of %d" % ROUNDS)
print("%-26s %6s %7s %7s %7s" % ("", "ratio", "gl", "raster", "check"), end="")
print(" %9s %9s %9s %9s %9s %9s" % ("terms", "passes", "vertices", "powers", "integrals", "textures"))
print("%-26s %6s %23s" % ("", "", "milliseconds more"))
base = prepare()
compare("the same again", base, base)
for number, (effect, *parts) in enumerate(EFFECTS):
    compare(effect, base, write("effect-%d.scene" % number, scene(*parts)))
