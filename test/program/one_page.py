#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile libosmesa6-dev
"""Compiles and runs data/samples/one-page.c: it agrees with itself, and its samples are those that the program makes of the scene
in its head, within 1 count, by OpenGL and by the reference. It notices a fault planted in its rasterizer. Prints TAP."""
import os
import re
import subprocess

import numpy as np

from rendered import bytes_of, check, done, output_of, pages_of, path_of, run, write

SOURCE = "data/samples/one-page.c"
BANDS = 31


def compile_as(name, text):
    return subprocess.run([os.environ.get("CC", "cc"), "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", write(name + ".c", text),
                           "-o", path_of(name), "-lOSMesa", "-ltiff", "-lm"], check=False, capture_output=True, text=True)


def draw(name):
    return run(path_of(name + ".tif"), program=path_of(name))


source = bytes_of(SOURCE).decode("ascii")
code = re.sub(r"/\*.*?\*/", "", source, flags=re.DOTALL)
lines = [line for line in code.splitlines() if line.strip()]
check(len(lines) <= 120 and '#include "' not in code, "the sample has at most 120 lines of code, and no header of ours", len(lines))
compiled = compile_as("one-page", source)
check(compiled.returncode == 0 and not compiled.stderr, "it compiles as C99 without a warning", compiled.stderr)
drawn = draw("one-page")
check(drawn.returncode == 0 and drawn.stdout.startswith("0 of "), "OpenGL and its rasterizer agree", drawn.stdout, drawn.stderr)
check(run(program=path_of("one-page")).returncode == 2, "without the name of a stack it ends with status 2")

scene = write("one-page.scene", "".join(re.findall(r"^ \*     ((?:size|wavelengths|camera|light|material|object) .*\n)", source, re.MULTILINE)))
for renderer in ("gl", "raster"):
    stack = path_of(renderer + ".tif")
    output_of("render", scene, "--renderer", renderer, "-o", stack)
    ours, theirs = pages_of(path_of("one-page.tif")), pages_of(stack)[:BANDS]
    worst = np.abs(ours - theirs).max() if ours.shape == theirs.shape else None
    check(worst is not None and worst <= 1 and ours.max() > 65000, f"its samples are those of render --renderer {renderer}, within 1 count",
          ours.shape, theirs.shape, worst)

planted = source.replace("b * v[1].cosine", "c * v[1].cosine")
check(planted != source and compile_as("planted", planted).returncode == 0 and draw("planted").returncode == 1,
      "a planted fault of its rasterizer is found")
done()
