#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Tries each limit that spectral.h names: what lies at it is taken, and what lies one beyond is refused by a line that names it. Each
limit of spectral.h has its trial here. A trial writes what it needs for a number, and returns the words of a command."""
import os
import re

import numpy as np
import tifffile

from rendered import check, done, output_of, path_of, run, write

PLANE = "object plane 1 1 material m\n"
SCENE = "size 2 2\nlight d65 1 direction 0 0 1\nmaterial m { diffuse 0.5 }\n"
HEADER = open("spectral.h").read()
LIMITS = {name: eval(value) for name, value in re.findall(  # a number, or 1 << a number
    r"^    ([A-Z_]+) = ([\d< ]+),? +/\*", HEADER[HEADER.index("/* Limits:"):HEADER.index("enum exit_status")], re.M)}


def plan(text):
    return "plan", write("limit.scene", text)


def side(n):
    picture = path_of("wide.tif")
    tifffile.imwrite(picture, np.zeros((1, n), np.uint8))
    return "info", picture


def include(n):
    """A chain of scenes; the first one includes no other."""
    write("0.scene", SCENE + PLANE)
    for i in range(n):
        write(f"{i + 1}.scene", f"include {i}.scene\n")
    return "plan", path_of(f"{n}.scene")


def texture(n):
    tifffile.imwrite(path_of("texture.tif"), np.zeros((1, n), np.uint8))
    return plan(SCENE + "material t { diffuse 0.5 texture texture.tif }\n" + PLANE.replace("material m", "material t"))


def face(n):
    """A polygon of n corners on a circle."""
    at = 2 * np.pi * np.arange(n) / n
    write("face.obj", "".join(f"v {x:.9f} {y:.9f} 0\n" for x, y in zip(np.cos(at), np.sin(at))) +
          "f " + " ".join(str(i + 1) for i in range(n)) + "\n")
    return plan(SCENE + "object mesh face.obj material m\n")


def line(n):
    return plan(SCENE + PLANE + "#" * n + "\n")


def text(n):
    start = SCENE + PLANE
    return plan(start + "\n" * (n - len(start)))


def includes(n):
    write("empty.scene", "# nothing\n")
    return plan(SCENE + PLANE + n * "include empty.scene\n")


def channels(n):
    write("detector.csv", "nm" + "".join(f",c{i}" for i in range(n)) + "\n400" + n * ",1" + "\n700" + n * ",0.5" + "\n")
    return "develop", STACK, "--raw", "--detector", path_of("detector.csv"), "-o", path_of("raw.tif")


def bands(n):
    return "list", write("bands.txt", "CGATS.17\nSPECTRAL_BANDS " + f'"{n}"\nSPECTRAL_START_NM "400"\nSPECTRAL_END_NM "700"\n'
                         "NUMBER_OF_SETS 1\nBEGIN_DATA\n" + n * "0.5 " + "\nEND_DATA\n")


def matrix(n):
    nm = np.linspace(300, 780, n)
    write("dye.csv", "nm,700\n" + "".join(f"{at:.6f},0.0001\n" for at in nm))
    return plan(SCENE.replace("0.5 }", "0.5 donaldson dye.csv }") + PLANE)


def operands(n):
    return "join", "-o", path_of("joined.tif"), *["none.tif"] * n


TRIALS = {
    "LONGEST_SIDE": side,
    "LARGEST_PAGE": lambda n: ("view", "patches", "--size", f"4096x{-(-n // 4096)}", "-o", path_of("page.html")),
    "MOST_PAGE_OBJECTS": lambda n: ("view", write("limit.scene", SCENE + n * PLANE), "-o", path_of("page.html")),
    "MOST_POSITIONS": lambda n: ("plan", "patches", "--samples", n),
    "MOST_WAVELENGTHS": lambda n: (*plan(SCENE + PLANE), "--wavelengths", f"1000:{999 + n}:1"),
    "LARGEST_QUADRATURE": lambda n: ("plan", "patches", "--sampling", f"gauss:{n}"),
    "MOST_SHADOWED": lambda n: plan(SCENE + n * "light d65 0.1 direction 0 1 1 shadows\n" + PLANE + PLANE.replace("\n", " translate 0 0 1\n")),
    "MOST_DIVISIONS": lambda n: plan(SCENE + f"object sphere 1 {n} 2 material m\n"),
    "MOST_TEAPOT_DIVISIONS": lambda n: plan(SCENE + f"object teapot 1 {n} material m\n"),
    "LONGEST_TEXTURE": texture,
    "LONGEST_FACE": face,
    "LONGEST_TEXT": text,
    "LONGEST_LINE": line,
    "MOST_CHANNELS": channels,
    "MOST_BANDS": bands,
    "LARGEST_MATRIX": matrix,
    "DEEPEST_INCLUDE": lambda n: include(n - 1),
    "MOST_INCLUDES": includes,
    "MOST_CURVES": lambda n: ("show", *["d65"] * n, "--csv"),
    "MOST_OPERANDS": operands,
    "MOST_RECORDED": lambda n: ("plan", "patches", *["--light", "1=a"] * n),
}
MEGABYTES = {"LONGEST_TEXT", "LONGEST_LINE"}  # of these, a message says MB
# The trial of a limit is refused for another reason, or would draw for minutes, or read for seconds.
OTHERWISE = {"MOST_OPERANDS": "none.tif"}
ONE_BEYOND = {"LARGEST_PAGE", "LONGEST_TEXT"}

STACK = path_of("stack.tif")
output_of("render", "patches", "--size", "4x4", "--wavelengths", "500:600:50", "-o", STACK, "-q", "--renderer", "raster")
check(set(TRIALS) == set(LIMITS), "each limit of spectral.h has a trial", set(TRIALS) ^ set(LIMITS))
for name, trial in TRIALS.items():
    limit = LIMITS[name]
    if name not in ONE_BEYOND:
        at = run(*trial(limit))
        check(at.returncode == 0 if name not in OTHERWISE else OTHERWISE[name] in at.stderr, f"{name}: {limit} is taken", at.returncode, at.stderr)
    beyond = run(*trial(limit + 1))
    check(beyond.returncode == 2 and beyond.stderr.count("\n") == 1 and (str(limit >> 20 if name in MEGABYTES else limit) in beyond.stderr or "unexpected operand" in beyond.stderr),
          f"{name}: {limit + 1} is refused", beyond.returncode, beyond.stderr)
done()
