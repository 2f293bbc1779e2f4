# SPDX-License-Identifier: MIT
"""Helps scripts that compare pictures with closed forms: renders scenes by the program ($SPECTRAL), reads them back
with tifffile, and reads spectra from the tables. Expected values come from the tables and geometry, never from
the program."""
import json
import os
import re
import subprocess
import sys

import numpy as np
import tifffile

from colours import ciede2000, cielab
from tap import bail_out, check, done  # noqa: F401  the scripts import them from here

SPECTRAL = os.environ.get("SPECTRAL", "build/spectral")
TMP = os.path.join(os.environ.get("TEST_TMP", "build/tmp"),
                   os.path.splitext(os.path.basename(sys.argv[0]))[0])
MATERIAL = "data/builtin/materials/colorchecker/15-red.txt"
WAVELENGTHS = np.arange(300.0, 765.0, 5.0)
SCENES = sorted(name[:-6] for name in os.listdir("data/builtin/scenes") if name.endswith(".scene"))
os.makedirs(TMP, exist_ok=True)


def table(path, separator=None):
    rows = [line.split(separator) for line in open(path) if line[0].isdigit()]
    return np.array(rows, float).T


D65 = np.interp(WAVELENGTHS, *table("data/builtin/tables/d65.csv", ","))
LAMP_A = np.interp(WAVELENGTHS, *table("data/builtin/tables/a.csv", ","))
RED = np.interp(WAVELENGTHS, *table(MATERIAL))  # np.interp holds the end values, as reflectances do


def per_band(spectrum):
    return np.asarray(spectrum)[:, None, None]


def write(name, text):
    path = os.path.join(TMP, name)
    with open(path, "w") as out:
        out.write(text)
    return path


def run(*words, program=os.path.abspath(SPECTRAL), text=True, **options):
    """Runs the program; its output and its errors are texts, or else bytes. Options in capitals are variables of its environment."""
    variables = {name: options.pop(name) for name in list(options) if name.isupper()}
    words = [word if isinstance(word, bytes) else str(word) for word in words]
    return subprocess.run([program, *words], capture_output=True, text=text, check=False,
                          env={**options.pop("env", os.environ), **variables}, **options)


def render(scene, *words, stack="stack.tif", worst=0, **options):
    """Renders a scene, its name or its text, into a stack in TMP. Returns the report; the test ends if the status is above `worst`."""
    path = write("rendered.scene", scene) if "\n" in scene else scene
    result = run("render", path, "-o", os.path.join(TMP, stack), "--json", "-", "--quiet", *words, **options)
    if result.returncode > worst:
        bail_out(scene, words, result.stderr)
    return json.loads(result.stdout)


def refuses(what, pattern, *words, status=2, absent=None, **options):
    """Checks that the program refuses the words: its exit status, and one line with the pattern; no output, if it is bad usage."""
    result = run(*words, **options)
    check(result.returncode == status and result.stderr.count("\n") == 1 and re.search(pattern, result.stderr) and
          not (status == 2 and result.stdout) and not (absent and os.path.exists(absent)), f"refused: {what}", result.returncode,
          result.stderr, result.stdout)


def pages_of(stack):
    """The values of a picture's pages [page, y, x]; three channels of one page become three pages."""
    with tifffile.TiffFile(stack) as tiff:
        pages = np.array([page.asarray() for page in tiff.pages], float)
    return np.moveaxis(pages[0], -1, 0) if pages.ndim == 4 else pages


def objects_of(stack):
    """The number of the object that each pixel shows, from the map after the last page; 0 is background."""
    with tifffile.TiffFile(stack) as tiff:
        offset, size = re.search(r"object_map: (\d+) (\d)\n", tiff.pages[0].description).groups()
        shape = tiff.pages[0].shape
    return np.fromfile(stack, f"<u{size}", np.prod(shape), offset=int(offset)).reshape(shape)


def tristimulus(stack, *options):
    """XYZ of each pixel [channel, y, x], as develop makes them, and the white [channel, 1]."""
    picture = os.path.join(TMP, "xyz.tif")
    result = run("develop", stack, "--xyz", "-o", picture, *options)
    white = re.search(r"^white +XYZ ([0-9. ]+),", result.stdout, re.MULTILINE)
    if result.returncode != 0 or not white:
        bail_out("cannot develop", stack)
    return tifffile.imread(picture).astype(float), np.array(white.group(1).split(), float)[:, None]


def colour_error_95(truth, seen):
    """The CIEDE2000 that 95 % of the pixels have at most, of those where one of the two shows an object. Each: what
    tristimulus returns, and what objects_of does. The white is that of the truth."""
    ((one, white), objects), ((two, _), other_objects) = truth, seen
    shown = (objects > 0) | (other_objects > 0)
    difference = np.sort(ciede2000(cielab(one[:, shown], white), cielab(two[:, shown], white)))
    return difference[len(difference) - len(difference) // 20 - 1]


class Picture:
    """A rendered scene: radiances [band, y, x], the program's JSON report, and the tolerance of a
    stored sample in radiance: half a count, plus in GL the largest bound that the program derives
    and prints. In the scene RED is the path of MATERIAL."""

    def __init__(self, name, renderer, scene, *options):
        path = write(name + ".scene", scene.replace("RED", os.path.relpath(MATERIAL, TMP)))
        self.stack = os.path.join(TMP, f"{name}-{renderer}.tif")
        self.report = render(path, "--renderer", renderer, *options, stack=f"{name}-{renderer}.tif")
        self.count = self.report["full_scale"] / 65535
        self.radiance = pages_of(self.stack) * self.count
        bound = self.report["check"]["floor_worst_counts"] if renderer == "gl" else 1e-6
        self.tolerance = (0.5 + bound) * self.count

    def agrees(self, expected, name, where=np.s_[:, :, :], slack=0):
        """`slack` bounds the relative rounding of what the program reads. A tolerance above 8 counts is too wide, and
        fails."""
        seen = self.radiance[where]
        error = np.abs(seen - expected).max()
        tolerance = self.tolerance + slack * np.max(expected)
        check(seen.size > 0 and error <= tolerance <= 8 * self.count, name,
              f"largest error {error}, tolerance {tolerance}, a count {self.count}")
