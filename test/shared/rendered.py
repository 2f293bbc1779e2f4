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
from tap import amount, bail_out, cases, check, done, parts  # noqa: F401  the scripts import them from here

SPECTRAL = os.environ.get("SPECTRAL", "build/spectral")
LIVE = os.path.abspath(os.environ.get("LIVE", "build/spectral-live"))
FAULTS, SPOIL, FAIL = (os.path.abspath(os.environ.get(variable, f"build/test/{name}.so")) for variable, name in (
    ("FAULTS", "fault"), ("SPOIL_LIBRARY", "spoil"), ("FAIL_LIBRARY", "fail")))
TMP = os.path.join(os.environ.get("TEST_TMP", "build/tmp"),
                   os.path.splitext(os.path.basename(sys.argv[0]))[0])
MATERIAL = "data/builtin/materials/colorchecker/15-red.txt"
WAVELENGTHS = np.arange(300.0, 765.0, 5.0)
CAMERAS = "dcs200-camera", "transparency-film"
SCENES = sorted(name[:-6] for name in os.listdir("data/builtin/scenes") if name.endswith(".scene"))
# Two groups of lights; a mirrored, a two-sided and a textured object; a spot; an attenuation.
EFFECTS = """wavelengths 400 700 10
size 90 60
camera perspective 40 eye 0 0 6
light d65 0.5 position 2 2 5 spot 0 0 -1 60 2
light a 0.2 position -1 2 3 attenuation 1 0.1 0.05
""" + "".join(f"light gaussian:{440 + 20 * i},40 0.1 direction {i - 4} 1 2\n" for i in range(9)) + """
ambient gaussian:550,80 0.1
material m { diffuse 0.6 specular 0.3 gloss 20 texture checks }
material n { diffuse 0.3 specular 0.5 gloss 0 }
object sphere 0.8 12 8 material m two-sided rotate 30 0 1 0 scale 1 -1.2 1 translate -1 0 0
object torus 0.3 0.6 8 12 material n translate 1 0 0
"""
os.makedirs(TMP, exist_ok=True)


def table(path, separator=None):
    rows = [line.split(separator) for line in open(path) if line[0].isdigit()]
    return np.array(rows, float).T


def built_in(name):
    """A built-in table of a light or a detector: wavelengths, and a row for each curve."""
    return table(f"data/builtin/tables/{name}.csv", ",")


def widths(nm):
    """Width of each wavelength: half-way to both neighbours; a whole step for the first and the last."""
    steps = np.diff(nm)
    return (np.append(steps[:1], steps) + np.append(steps, steps[-1:])) / 2


def weights(detector, nm):
    """Equation 11 of the thesis: the weights [channel, wavelength] that make tristimulus values, or a camera's channels, of
    radiances. An observer's Y of a radiance of 1 is 100."""
    own, *curves = built_in(detector)
    k = 1 if detector in CAMERAS else 100 / (curves[1] * widths(own)).sum()
    return np.array([np.interp(nm, own, curve, 0, 0) for curve in curves]) * widths(nm) * k


D65 = np.interp(WAVELENGTHS, *built_in("d65"))
LAMP_A = np.interp(WAVELENGTHS, *built_in("a"))
RED = np.interp(WAVELENGTHS, *table(MATERIAL))  # np.interp holds the end values, as reflectances do


def per_band(spectrum):
    return np.asarray(spectrum)[:, None, None]


def path_of(name):
    return os.path.join(TMP, name)


def write(name, text):
    with open(path_of(name), "w") as out:
        out.write(text)
    return path_of(name)


def write_camera():
    """A detector of three channels that is not built in."""
    return write("camera.csv", "nm,r,g,b\n400,0,0.1,0.9\n500,0.1,0.8,0.3\n600,0.9,0.2,0\n700,0.2,0,0\n")


def bytes_of(path):
    with open(path, "rb") as file:
        return file.read()


def remove(*paths):
    """Removes the files that exist."""
    for path in filter(os.path.exists, paths):
        os.remove(path)


def run(*words, program=os.path.abspath(SPECTRAL), text=True, **options):
    """Runs the program; its output and its errors are texts, or else bytes. Options in capitals are variables of its environment."""
    variables = {name: options.pop(name) for name in list(options) if name.isupper()}
    words = [word if isinstance(word, bytes) else str(word) for word in words]
    result = subprocess.run([program, *words], capture_output=True, text=text, check=False,
                            env={**options.pop("env", os.environ), **variables}, **options)
    number = text and result.stdout and re.search(r"^.*(?<![\w.-])-?(nan|inf)(?![\w.-]).*$", result.stdout, re.M)
    if number:  # a figure that does not exist is "none", or null in JSON
        bail_out(*words, "prints a number that does not exist: " + number[0])
    return result


def output_of(*words, **options):
    """Runs the program, which must succeed. Returns its output."""
    result = run(*words, **options)
    if result.returncode != 0:
        bail_out(*words, result.stderr)
    return result.stdout


def unshadowed(name):
    """The path of a built-in scene whose lights throw no shadows."""
    return write(f"{name}.scene", output_of("show", name).replace(" shadows\n", "\n"))


def reference(name, scene, *options):
    """Renders a scene by the reference alone. Returns the path of the stack."""
    output_of("render", scene, "--renderer", "raster", "--no-check", "--quiet", "-o", path_of(name), *options)
    return path_of(name)


def developed(stack, *options):
    """The samples of the picture that develop makes [y, x, channel], and what it prints."""
    said = output_of("develop", stack, "-o", path_of("developed.tif"), *options)
    return np.moveaxis(pages_of(path_of("developed.tif")), 0, 2), said


def render(scene, *words, stack="stack.tif", worst=0, **options):
    """Renders a scene, its name or its text, into a stack in TMP. Returns the report; the test ends if the status is above `worst`."""
    path = write("rendered.scene", scene) if "\n" in scene else scene
    result = run("render", path, "-o", path_of(stack), "--json", "-", "--quiet", *words, **options)
    if result.returncode > worst:
        bail_out(scene, words, result.stderr)
    return json.loads(result.stdout)


def judged(path, *options, program=SPECTRAL, **environment):
    """The exit status, the report and the message of a render that keeps no stack."""
    result = run("render", path, "-o", "/dev/null", "--quiet", "--json", "-", *options, program=os.path.abspath(program), **environment)
    return result.returncode, json.loads(result.stdout) if result.returncode < 2 else None, result.stderr


def stack_of(path, *options):
    """The samples of a scene as they are stored."""
    result = run("render", path, "-o", path_of("stack.tif"), "--quiet", "--keep", *options)
    check(result.returncode == 0, f"{os.path.basename(path)} {' '.join(options)} is drawn", result.stderr)
    return tifffile.imread(path_of("stack.tif"))


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


def values_of(stack):
    """The radiances of a stack of 16 bits [page, y, x]; those of another program are as they stand."""
    with tifffile.TiffFile(stack) as tiff:
        full_scale = re.search(r"full_scale: (\S+)", tiff.pages[0].description)
    return pages_of(stack) * (float(full_scale.group(1)) / 65535 if full_scale else 1)


def response_of(stack):
    """The matrix that makes tristimulus values of components, and the white's, as a stack of components records them."""
    with tifffile.TiffFile(stack) as tiff:
        recorded = dict(re.findall("^(response|white_response): (.*)$", tiff.pages[0].description, re.MULTILINE))
    return np.array(recorded["response"].split(), float).reshape(3, 3), np.array(recorded["white_response"].split(), float)


def write_stack(name, pages, nm, photometric="minisblack", compression=None):
    """Writes a stack without the program: pages that are named by their wavelengths."""
    with tifffile.TiffWriter(path_of(name)) as out:
        for page, wavelength in zip(pages, nm):
            out.write(page, metadata=None, contiguous=False, photometric=photometric, compression=compression,
                      extratags=[(285, "s", 0, f"{wavelength} nm", True)])
    return path_of(name)


def objects_of(stack):
    """The number of the object that each pixel shows, from the map after the last page; 0 is background."""
    with tifffile.TiffFile(stack) as tiff:
        offset, size = re.search(r"object_map: (\d+) (\d)\n", tiff.pages[0].description).groups()
        shape = tiff.pages[0].shape
    return np.fromfile(stack, f"<u{size}", np.prod(shape), offset=int(offset)).reshape(shape)


def tristimulus(stack, *options):
    """XYZ of each pixel [channel, y, x], as develop makes them, and the white [channel, 1]."""
    xyz, said = developed(stack, "--xyz", *options)
    white = re.search(r"^white +XYZ ([0-9. ]+),", said, re.MULTILINE)
    return np.moveaxis(xyz, 2, 0), np.array(white.group(1).split(), float)[:, None]


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
        self.stack = path_of(f"{name}-{renderer}.tif")
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
