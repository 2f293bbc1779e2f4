#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""A matrix behind a detector, two eyes on one stack, and the raw values of a camera: develop, probe and compare print what this integration
finds, for 1 to 40 channels, under whites of lights, of lit surfaces and of objects; objects have the differences of the published pairs. Wrong
files are refused in words. Prints TAP."""
import csv
import io
import json
import os
import re

import numpy as np
import tifffile

from colours import srgb
from rendered import (built_in, bytes_of, check, ciede2000, cielab, developed, done, objects_of, output_of, pages_of, parts, path_of, reference,
                      refuses, remove, run, table, weights, widths, write)

RNG = np.random.default_rng(781)
NM, COARSE, OWN = np.arange(400.0, 701, 10), np.arange(400.0, 701, 20), np.arange(380.0, 721, 20)
SCENE = """wavelengths 400 700 10
size 48 32
camera ortho 4 eye 0 0 5 look 0 0 0
light d65 1 position 3 3 5
ambient a 0.2
material red { diffuse colorchecker/15-red specular 0.3 gloss 20 }
material green { diffuse colorchecker/14-green }
material grey { diffuse colorchecker/22-neutral-5 }
object sphere 0.9 material red translate -0.6 0 0
object plane 1.5 1 material green translate 0.9 0.2 -1
object plane 1.5 0.8 material grey translate 0.6 -1 -1
object plane 0.3 0.3 material grey translate -0.6 0 -20
"""
A = reference("a.tif", write("a.scene", SCENE), "--depth", "32f")
B = reference("b.tif", write("b.scene", SCENE.replace("d65 1", "f11 1.1")), "--depth", "32f")  # under another lamp
C = reference("c.tif", path_of("b.scene"), "--depth", "32f", "--wavelengths", "400:700:20")
SEEN = {A: (pages_of(A), NM), B: (pages_of(B), NM), C: (pages_of(C), COARSE)}
FLOAT = 2e-7  # relative, of a float


class Camera:
    """A detector's file, its curves, and the file of a matrix that takes the white of A near equal X, Y and Z of 100."""

    def __init__(self, n):
        self.curves, self.names = np.round(RNG.uniform(0, 1, (n, len(OWN))), 4), [f"c{i}" for i in range(n)]
        rows = [",".join(["nm", *self.names])] + [",".join(map(str, row)) for row in zip(OWN, *self.curves)]
        self.path, self.matrix_path = write(f"{n}.csv", "\n".join(rows) + "\n"), path_of(f"m{n}.csv")
        mixed = RNG.uniform(0.2, 1, (n, 3))
        self.matrix = mixed * 100 / (self.weights(NM) @ WHITE @ mixed) * (0.9, 1, 1.1)
        self.write(f"m{n}.csv", "channel,X,Y,Z", ",", True)
        self.options = "--detector", self.path, "--matrix", self.matrix_path

    def write(self, name, heading, separator, named):
        rows = [separator.join(([channel] if named else []) + [repr(float(value)) for value in row]) for channel, row in zip(self.names, self.matrix)]
        return write(name, "\n".join(([heading] if heading else []) + rows) + "\n")

    def weights(self, nm):
        return np.array([np.interp(nm, OWN, curve, 0, 0) for curve in self.curves]) * widths(nm)

    def xyz(self, nm):
        """The weights of XYZ, by the matrix."""
        return self.matrix.T @ self.weights(nm)


def light(name, nm=NM):
    return np.interp(nm, *built_in(name), 0, 0)


WHITE = (light("d65") + 0.2 * light("a")) / 1.2  # of A: the mean of its lights
WHITE_B = (1.1 * light("f11") + 0.2 * light("a")) / 1.3
CAMERAS = {n: Camera(n) for n in (1, 3, 6, 40)}
EYE = weights("cie1931", NM)
REFUSED = path_of("refused.tif")


def near(seen, expected, relative=1e-9):
    """Within this part of the largest value."""
    return np.shape(seen) == np.shape(expected) and np.abs(np.array(seen, float) - expected).max() <= relative * np.abs(expected).max()


def said(command, *words):
    """Returns the JSON that a command prints."""
    return json.loads(run(command, *words, "--json", "-").stdout)


def lab(xyz, white):
    """[channel, ...] -> CIELAB"""
    return cielab(xyz, white.reshape(3, *[1] * (xyz.ndim - 1)))


def inner(stack):
    """Returns for each object the pixels that show it and have no neighbour that shows another one."""
    shown = objects_of(stack)
    padded, (h, w) = np.pad(shown, 1, "edge"), shown.shape
    whole = np.all([padded[dy:dy + h, dx:dx + w] == shown for dy in range(3) for dx in range(3)], axis=0)
    return [whole & (shown == number) for number in range(1, shown.max() + 1)]


def means(stack, of=None):
    """The mean spectrum of each object that is seen, by weights if they are given."""
    pages = SEEN[stack][0]
    spectra = np.array([pages[:, at].mean(1) for at in inner(stack) if at.any()]).T
    return spectra if of is None else of @ spectra


# ---- a matrix ----

def pictures():
    for n, camera in CAMERAS.items():
        of = camera.xyz(NM)
        white = of @ WHITE
        xyz, text = developed(A, "--xyz", *camera.options)
        xyz, expected = np.moveaxis(xyz, 2, 0), np.tensordot(of, SEEN[A][0], 1)
        check(near(xyz, expected, FLOAT), f"{n} channels: develop writes XYZ by the matrix", np.abs(xyz - expected).max())
        found = np.array(re.search("^white +XYZ (\\S+) (\\S+) (\\S+), .*recorded", text, re.M).groups(), float)
        check(near(found, white, 1e-5) and f"{n} channels, to XYZ by {camera.matrix_path}" in text and text.split("unseen")[1].split("\n")[0].count("%") == n,
              f"{n} channels: the white is the camera's, by the matrix, and the files are named", text)
        result = said("develop", A, "--lab", "-o", path_of("lab.tif"), *camera.options)
        check(near(pages_of(path_of("lab.tif")), lab(expected, white), FLOAT) and near(result["white"], white) and result["matrix"] == camera.matrix_path,
              f"{n} channels: CIELAB, and the white as JSON", result)
        rgb, _ = developed(A, "--bits", "16", *camera.options)
        display = np.array([[0.64, 0.33, 0.03], [0.30, 0.60, 0.10], [0.15, 0.06, 0.79]]).T
        d65 = np.array([0.3127, 0.3290, 0.3583]) / 0.3290 * 100
        display = np.linalg.inv(display * np.linalg.solve(display, d65))
        exact = 65535 * srgb(np.tensordot(display, expected, 1))
        check(np.abs(np.moveaxis(rgb, 2, 0) - exact).max() <= 0.5 + 1e-6 and np.ptp(exact) > 20000, f"{n} channels: a display shows XYZ")
        cones = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])  # Bradford
        adapted, _ = developed(A, "--xyz", "--adaptation", "bradford", *camera.options)
        to = np.linalg.inv(cones) @ np.diag(cones @ d65 / (cones @ white)) @ cones
        check(near(np.moveaxis(adapted, 2, 0), np.tensordot(to, expected, 1), FLOAT), f"{n} channels: the eye adapts to that white")


def probes():
    for n, camera in CAMERAS.items():
        of, name = camera.xyz(NM), f"{n} channels"
        white = of @ WHITE
        for where, at in (["15", "15"], np.s_[:, 15:16, 15:16]), (["20", "6", "25", "20"], np.s_[:, 6:26, 20:45]):
            found, mean = said("probe", A, *where, *camera.options), SEEN[A][0][at].mean((1, 2))
            check(near(found["XYZ"], of @ mean) and near(found["white_XYZ"], white) and near(found["Lab"], lab(of @ mean, white)) and
                  near(found["raw"], camera.weights(NM) @ mean) and found["channels"] == camera.names, f"{name}: probe of {' '.join(where)}", found)
        rows = list(csv.DictReader(io.StringIO(output_of("probe", A, "--objects", "--csv", *camera.options))))
        seen = [[float(row[key]) for key in "XYZLab"] for row in rows if row["X"]]
        xyz = means(A, of)
        check(near(seen, np.concatenate([xyz, lab(xyz, white)]).T) and len(rows) == 4 and len(seen) == 3, f"{name}: probe of objects", rows)
        raw = [[float(row[key]) for key in camera.names] for row in rows if row["X"]]
        check(near(raw, means(A, camera.weights(NM)).T), f"{name}: raw values of objects")
        found = said("probe", path_of("a.scene"), "15", "15", *camera.options)
        check(near(found["XYZ"], of @ SEEN[A][0][:, 15, 15], FLOAT) and near(found["white_XYZ"], white), f"{name}: probe of a scene", found)
        text = output_of("probe", A, "15", "15", *camera.options)
        check(f"({n} channels, to XYZ by {camera.matrix_path})" in text and "observer" not in text, f"{name}: probe names the matrix", text)
        pair = [of @ SEEN[A][0][:, 15, x] for x in (15, 36)]
        text = output_of("probe", A, "15", "15", "--against", "36", "15", *camera.options)
        check(near(float(re.search("^CIEDE2000 +(\\S+) under the recorded", text, re.M).group(1)), ciede2000(*(lab(xyz, white) for xyz in pair)), 1e-5),
              f"{name}: two regions differ as by the matrix", text)


def forms():
    """A matrix may be written in other ways."""
    camera = CAMERAS[6]
    first, _ = developed(A, "--xyz", *camera.options)
    for heading, separator, named in (("channel;X;Y;Z", ";", True), ("X Y Z", " ", False), ("", "\t", True), ("", ",", False), ("# a comment\n\n", " , ", True)):
        path = camera.write("form.csv", heading, separator, named)
        xyz, _ = developed(A, "--xyz", "--detector", camera.path, "--matrix", path)
        check(np.array_equal(xyz, first), f"a matrix below {heading!r}, parted by {separator!r}, {'with' if named else 'without'} names")
    write("blank.csv", open(camera.path).read().replace("c0", "c 0", 1))
    path = camera.write("form.csv", "channel,X,Y,Z", ",", True)
    write("form.csv", open(path).read().replace("c0,", '"c 0",'))
    xyz, _ = developed(A, "--xyz", "--detector", path_of("blank.csv"), "--matrix", path)
    check(np.array_equal(xyz, first), "a name with a blank is quoted")
    xyz, _ = developed(A, "--xyz", "--matrix", write("eye.csv", "0 1 0\n1 0 0\n0 0 2\n"))
    expected = np.tensordot(EYE, SEEN[A][0], 1)[[1, 0, 2]] * np.reshape([1, 1, 2], (3, 1, 1))
    check(near(np.moveaxis(xyz, 2, 0), expected, FLOAT), "an observer's values are taken by a matrix, too")


def refused_matrices():
    camera = CAMERAS[3]
    rows = [f"c{i},1,2,3" for i in range(3)]
    for what, text, why in (
            ("too few rows", rows[:2], "expected 3 rows of three numbers, found 2"), ("too many rows", rows + ["1,2,3"], ":4:1: error: expected 3 rows, no more"),
            ("NaN", rows[:2] + ["c2,nan,1,1"], ":3:4: .*not 'nan'"), ("a row of NaN", rows[:2] + ["nan,nan,nan"], "found 2"), ("infinity", rows[:2] + ["1,2,inf"], ":3:5: .*not 'inf'"),
            ("another channel's name", ["c0,1,2,3", "c2,1,2,3", "c1,1,2,3"], ":2:1: error: expected the row of 'c1', found 'c2'"),
            ("names in other letters", ["C0,1,2,3", *rows[1:]], "expected the row of 'c0', found 'C0'"), ("a word", rows[:2] + ["c2,1,two,3"], "not 'two'"),
            ("four numbers in a row", rows[:2] + ["c2,1,2,3,4"], ":3:10: error: '4' is too much: a row of three"), ("two numbers in a row", rows[:2] + ["c2,1,2"], ":3:7: error: expected a number"),
            ("an empty file", [], "found 0"), ("comments alone", ["# 1 2 3"], "found 0"), ("numbers beyond use", rows[:2] + ["1e31,1,1"], "above 1e\\+30")):
        path = write("wrong.csv", "".join(line + "\n" for line in text))
        for command, *words in ("develop", A, "-o", REFUSED), ("probe", A, "1", "1"), ("probe", A, "--objects"), ("compare", A, B), ("compare", A, A, "--objects", "--other", camera.path):
            detector = [] if "--other" in words else ["--detector", camera.path]
            refuses(f"{what}, by {command} {words[-1]}", why, command, *words, *detector, "--matrix", path, absent=REFUSED)
    for command, *words in ("develop", A, "-o", REFUSED), ("probe", A, "1", "1"), ("compare", A, A):
        refuses(f"no file, by {command}", "none.csv: No such file", command, *words, "--detector", camera.path, "--matrix", path_of("none.csv"), absent=REFUSED)
    refuses("--raw with a matrix", "--raw takes no --matrix", "develop", A, "--raw", "-o", REFUSED, *camera.options, absent=REFUSED)
    refuses("a camera without a matrix", "expected an observer", "compare", A, A, "--other", camera.path)
    refuses("six channels without a matrix", "6 channels", "compare", A, A, "--objects", "--other", CAMERAS[6].path)
    for sampling in "rgb", "xyz", "gauss:6,xyz":
        stack = reference("fixed.tif", path_of("a.scene"), "--sampling", sampling)
        for command, *words in ("develop", stack, "-o", REFUSED), ("compare", stack, A), ("compare", stack, stack):
            refuses(f"{sampling} with a matrix, by {command}", "was sampled for cie1931; --matrix needs all", command, *words, *camera.options, absent=REFUSED)
        refuses(f"{sampling} seen by another camera", "was sampled for cie1931; --matrix needs all", "compare", A, stack, "--other", camera.path, "--matrix", camera.matrix_path)


# ---- two eyes ----

def is_summary(found, values, name):
    """Checks the mean, the 95 % and the largest of what compare says."""
    values = np.sort(np.ravel(values))
    quantile = values[len(values) - len(values) // 20 - 1]
    check(near(found["mean"], values.mean(), 1e-6) and near(found["largest"], values[-1], 1e-6) and quantile * (1 - 1e-6) <= found["quantile_95"] <= quantile * (1 + 1 / 1024),
          f"{name}: mean, 95 % and largest", found, values.mean(), quantile, values[-1])
    return values[-1]


def expected_of(a, b, of_a, of_b, white):
    """CIEDE2000 of each pixel that is not black in both."""
    pages = SEEN[a][0], SEEN[b][0]
    shown = pages[0].any(0) | pages[1].any(0)
    return ciede2000(lab(of_a @ pages[0][:, shown], white), lab(of_b @ pages[1][:, shown], white))


def pixels():
    for n, camera in CAMERAS.items():
        matrix = "--matrix", camera.matrix_path
        for b in A, B, C:
            of_b, name = camera.xyz(SEEN[b][1]), f"{n} channels, {os.path.basename(b)}"
            found = said("compare", A, b, "--other", camera.path, *matrix)
            worst = is_summary(found["dE00"], expected_of(A, b, EYE, of_b, EYE @ WHITE), f"{name}, seen by another")
            check((found["observer"], found["other"], found["matrix"], found["colours_alone"], found["largest"], found["bands"]) ==
                  ("cie1931", camera.path, camera.matrix_path, True, None, []), f"{name}: JSON says who sees", found)
            for tolerance, status in ((worst * 1.00001, 0), (worst * 0.99999, 1)):
                result = run("compare", A, b, "--other", camera.path, *matrix, "--tolerance", f"{tolerance:.9g}dE00", "--quiet")
                check(result.returncode == status and not result.stdout, f"{name}: a tolerance of {tolerance:.6g} has status {status}", result.stderr)
            found = said("compare", A, b, *camera.options)
            if b != A:
                is_summary(found["dE00"], expected_of(A, b, camera.xyz(NM), of_b, camera.xyz(NM) @ WHITE), f"{name}, both by the matrix")
            check(found["other"] is None and found["colours_alone"] == (b == C), f"{name}: both by the matrix have their pages", found)
    found = said("compare", A, B, "--other", "cie1964")
    is_summary(found["dE00"], expected_of(A, B, EYE, weights("cie1964", NM), EYE @ WHITE), "two observers")
    found = said("compare", A, A, "--detector", "cie1964", "--other", "cie1931", "--white", "a")
    is_summary(found["dE00"], expected_of(A, A, weights("cie1964", NM), EYE, weights("cie1964", NM) @ light("a")), "two observers, and a white")
    words = "compare", A, A, "--other", CAMERAS[6].path, "--matrix", CAMERAS[6].matrix_path
    map_png, map_tiff = path_of("map.png"), path_of("map.tif")
    remove(map_png)
    text = run(*words, "--map", map_png).stdout
    check(bytes_of(map_png)[1:4] == b"PNG" and f"map               {map_png}" in text and "CIEDE2000: 0 black" in text, "a map is drawn", text)
    check("observer          cie1931\ndetector " in text and f"(6 channels, to XYZ by {CAMERAS[6].matrix_path})\nwhite " in text and "recorded by the first" in text,
          "words say who sees, and the white", text)
    refuses("a TIFF map of colours", "expected --map with .png", *words, "--map", map_tiff, absent=map_tiff)
    refuses("a tolerance of radiance", "expected --tolerance as 0.5dE00", *words, "--tolerance", "1%")


def objects():
    for n, camera in CAMERAS.items():
        for a, b in (A, A), (A, B), (B, C):
            white = EYE @ (WHITE if a == A else WHITE_B)
            of_b = camera.xyz(SEEN[b][1])
            expected = ciede2000(lab(means(a, EYE), white), lab(means(b, of_b), white))
            name = f"{n} channels, objects of {os.path.basename(a)} and {os.path.basename(b)}"
            words = "compare", a, b, "--objects", "--other", camera.path, "--matrix", camera.matrix_path
            found = said(*words)
            check([each["name"] for each in found["objects"]] == ["red", "green", "grey#1"] and near([each["dE00"] for each in found["objects"]], expected, 1e-6),
                  f"{name}: those that are seen have the difference of their means", found, expected)
            worst = is_summary(found["dE00"], expected, name)
            for tolerance, status in ((worst * 1.00001, 0), (worst * 0.99999, 1)):
                check(run(*words, "--tolerance", f"{tolerance:.9g}dE00").returncode == status, f"{name}: a tolerance of {tolerance:.6g} has status {status}")
    table_a, table_b = (list(csv.DictReader(io.StringIO(output_of("probe", stack, "--objects", "--csv", *options)))) for stack, options in ((A, ()), (B, CAMERAS[6].options)))
    xyz = [np.array([[float(row[key]) for key in "XYZ"] for row in rows if row["X"]]).T for rows in (table_a, table_b)]
    result = run("compare", A, B, "--objects", "--other", CAMERAS[6].path, "--matrix", CAMERAS[6].matrix_path)
    seen = [float(line.split()[0]) for line in result.stdout.split("\n")[:3]]
    check(near(seen, ciede2000(*(lab(each, EYE @ WHITE) for each in xyz)), 1e-5) and "white             XYZ" in result.stdout and "of 3 objects" in result.stdout and
          result.returncode == 1, "they are those of what probe says, as words", result.stdout)
    found = said("compare", A, B, "--objects", *CAMERAS[6].options)
    check(found["within_tolerance"] is False and found["other"] is None and found["matrix"] == CAMERAS[6].matrix_path, "the JSON says how they were seen", found)
    of = CAMERAS[6].xyz(NM)
    check(near([each["dE00"] for each in found["objects"]], ciede2000(*(lab(means(stack, of), of @ WHITE) for stack in (A, B))), 1e-6), "both by the matrix", found)
    check(not run("compare", A, B, "--objects", "--quiet").stdout and "of 3 objects" in run("compare", A, B, "--objects", "--json", path_of("o.json")).stdout and
          len(json.load(open(path_of("o.json")))["objects"]) == 3, "--quiet and --json are as without --objects")
    words = SCENE.replace("material grey", "material other").replace("grey {", "other {")
    other = reference("other.tif", write("other.scene", words), "--size", "24x16")
    refuses("other objects", "other objects: 'grey#1' and 'other#1'", "compare", A, other, "--objects")
    fewer = reference("fewer.tif", write("fewer.scene", "\n".join(SCENE.split("\n")[:-2]) + "\n"))
    refuses("more objects", "has 4 objects, .* 3", "compare", A, fewer, "--objects")
    lit = reference("lit.tif", write("lit.scene", SCENE.replace("3 3 5", "3 3 5 unit W").replace("a 0.2", "a 0.2 unit W")))
    refuses("another unit", "radiances of .* are in", "compare", A, lit, "--objects")
    refuses("a map of objects", "--objects takes no --map", "compare", A, B, "--objects", "--map", path_of("no.png"), absent=path_of("no.png"))
    for tolerance in "1%", "0.5", "1dE76":
        refuses(f"objects to {tolerance}", "expected --tolerance as 0.5dE00", "compare", A, B, "--objects", "--tolerance", tolerance)
    refuses("a stack without objects", "no map of objects", "compare", A, write_foreign(), "--objects")


def write_foreign():
    pages = SEEN[A][0].astype(np.float32)
    with tifffile.TiffWriter(path_of("foreign.tif")) as out:
        for page, nm in zip(pages, NM):
            out.write(page, metadata=None, contiguous=False, photometric="minisblack", extratags=[(285, "s", 0, f"{nm} nm", True)])
    return path_of("foreign.tif")


def published():
    """A patch for each published pair: three bands, each seen by one channel, so that a radiance is an X, a Y or a Z. The white is lit."""
    pairs = np.array([line.split() for line in open("test/cases/ciede2000.cases") if line[0].isdigit()], float)
    white = np.array([0.95047, 1, 1.08883])
    eye = write("bands.csv", "nm,x,y,z\n400,1,0,0\n500,0,1,0\n600,0,0,1\n")
    write("white.csv", "nm,light\n" + "".join(f"{nm},{value}\n" for nm, value in zip((400, 500, 600), white)))
    stacks = []
    for which, colours in (("one", pairs[:, :3].T), ("two", pairs[:, 3:6].T)):
        y = (colours[0] + 16) / 116
        roots = np.array([y + colours[1] / 500, y, y - colours[2] / 200])
        ratios = np.where(roots > 6 / 29, roots ** 3, 3 * (6 / 29) ** 2 * (roots - 4 / 29))
        check(ratios.min() > 0 and ratios.max() < 1, f"all colours {which} are reflectances", ratios.min(), ratios.max())
        write(f"{which}.csv", "nm," + ",".join(f"p{i}" for i in range(34)) + "\n" +
              "".join(",".join([str(nm), *(f"{value:.12g}" for value in row)]) + "\n" for nm, row in zip((400, 500, 600), ratios)))
        text = "wavelengths 400 600 100\nsize 70 50\ncamera ortho 7 eye 0 0 5 look 0 0 0\nlight white.csv 1 direction 0 0 1\n"
        text += "".join(f"material p{i} {{ diffuse {which}.csv:p{i} }}\nobject plane 0.8 0.8 material p{i} translate {i % 7 - 3} {i // 7 - 2} 0\n" for i in range(34))
        stacks.append(reference(f"{which}.tif", write(f"{which}.scene", text), "--depth", "32f"))
    found = said("compare", *stacks, "--objects", "--detector", eye)
    seen = np.array([each["dE00"] for each in found["objects"]])
    check([each["name"] for each in found["objects"]] == [f"p{i}" for i in range(34)], "there are 34 pairs")
    off = np.abs(seen - pairs[:, 6])
    check(off.max() <= 1e-4, "objects have the published differences", off)
    print(f"# largest error of a published difference: {off.max():.2g}")
    is_summary(found["dE00"], seen, "published pairs")
    text = run("compare", *stacks, "--objects", "--detector", eye).stdout
    check("white             XYZ 95.047 100 108.883" in text, "below their white", text[-200:])


# ---- raw values, and their bound ----

def bounds():
    camera = CAMERAS[6]
    exact = path_of("a.tif")
    of = camera.weights(NM)
    for bits in 16, 8:
        stack = reference(f"{bits}.tif", path_of("a.scene"), "--depth", bits)
        with tifffile.TiffFile(stack) as file:
            step = float(re.search("full_scale: (\\S+)", file.pages[0].description).group(1)) / (2 ** bits - 1)
        near_bound = 0
        for x, y, w, h in (15, 15, 1, 1), (36, 15, 1, 1), (30, 26, 1, 1), (8, 8, 20, 15), (0, 0, 48, 32), (0, 0, 1, 1):
            found, true = (said("probe", each, x, y, w, h, "--detector", camera.path) for each in (stack, exact))
            mean, mean_exact = (pages[:, y:y + h, x:x + w].mean((1, 2)) for pages in (pages_of(stack) * step, SEEN[A][0]))
            name = f"{bits} bits, {w} x {h} pixels from {x},{y}"
            check(found["channels"] == camera.names and near(found["raw"], of @ mean, FLOAT) if mean.any() else not any(found["raw"]), f"{name}: six raw values are numpy's", found, of @ mean)
            check(near(found["raw_bound"], step / 2 * np.abs(of).sum(1)), f"{name}: they are stored to half a count of each page", found, step)
            check(near(true["raw"], of @ mean_exact) and near(true["raw_bound"], 2.0 ** -24 * np.abs(of) @ mean_exact) if mean_exact.any() else not any(true["raw_bound"]),
                  f"{name}: floats are stored to 2^-24 of their values", true)
            share = np.abs(np.subtract(found["raw"], true["raw"])) / np.add(found["raw_bound"], true["raw_bound"])
            check((share <= 1).all(), f"{name}: the exact raw value lies within that", share)
            near_bound = max(near_bound, share.max())
        check(near_bound > 0.05, f"{bits} bits: the bound is not idle", near_bound)
    text = output_of("probe", path_of("8.tif"), "15", "15", "--detector", camera.path)
    found = said("probe", path_of("8.tif"), "15", "15", "--detector", camera.path)
    check(all(f"{name:<17} {value:.6g}, stored to {bound:.2g}\n" in text for name, value, bound in zip(camera.names, found["raw"], found["raw_bound"])), "words say so", text)


def whites():
    refl = np.interp(NM, *table("data/builtin/materials/colorchecker/19-white.txt"))
    own_light = write("lamp.csv", "nm,lamp,other\n380,1,2\n500,2,1\n720,3,3\n")
    own = np.interp(NM, (380, 500, 720), (1, 2, 3)), np.interp(NM, (450, 650), (0.9, 0.3))
    write("paint.csv", "nm,R\n450,0.9\n650,0.3\n")  # beyond its ends a reflectance continues
    object_means = means(A)
    for white, radiance in (("a*colorchecker/19-white", light("a") * refl), ("d65*2*colorchecker/19-white", 2 * light("d65") * refl), ("d65", light("d65")), ("d65*0.5", light("d65") / 2),
                            (f"{own_light}:lamp*{path_of('paint.csv')}", own[0] * own[1]), (f"a*{path_of('paint.csv')}", light("a") * own[1]), ("object:green", object_means[:, 1]),
                            ("object:2", object_means[:, 1]), ("object:3", object_means[:, 2])):
        short = white.replace(path_of(""), "")
        found = said("develop", A, "--white", white, "--lab", "-o", path_of("lab.tif"))
        check(near(found["white"], EYE @ radiance) and near(pages_of(path_of("lab.tif")), lab(np.tensordot(EYE, SEEN[A][0], 1), EYE @ radiance), FLOAT), f"{short}: develop", found)
        found = said("probe", A, "15", "15", "--white", white)
        check(near(found["white_XYZ"], EYE @ radiance) and near(found["Lab"], lab(EYE @ SEEN[A][0][:, 15, 15], EYE @ radiance)), f"{short}: probe", found)
        found = said("compare", A, B, "--white", white)
        is_summary(found["dE00"], expected_of(A, B, EYE, EYE, EYE @ radiance), f"{short}: compare")
        of = CAMERAS[6].xyz(NM)
        found = said("compare", A, A, "--objects", "--white", white, "--other", CAMERAS[6].path, "--matrix", CAMERAS[6].matrix_path)
        check(near([each["dE00"] for each in found["objects"]], ciede2000(*(lab(each, EYE @ radiance) for each in (means(A, EYE), means(A, of)))), 1e-6), f"{short}: objects")
        check(near(said("probe", A, "1", "1", "--white", white, *CAMERAS[6].options)["white_XYZ"], of @ radiance), f"{short}: by a matrix")
        said_so = run("compare", A, B, "--white", white).stdout
        check(f"({white})" in said_so, f"{short}: compare names it", said_so)
    for command, *words in ("develop", A, "-o", REFUSED), ("probe", A, "1", "1"), ("compare", A, A, "--tolerance", "1dE00"):
        for white, why in (("colorchecker/19-white", "19-white is a reflectance; name its light, too: d65\\*colorchecker/19-white"), ("colorchecker/19-white*d65", "is a reflectance"),
                           ("d65*a", "above 1"), ("d65*none.csv", "none.csv"), ("object:none", "there is no object 'none'"), ("object:5", "there is no object '5'"), ("object:0", "no object"),
                           ("object:grey", "there is no object 'grey', or not one alone"), ("object:4", "no pixel shows '4' but at its edges")):
            refuses(f"the white {white}, by {command}", why, command, *words, "--white", white, absent=REFUSED)
    fine = np.arange(400.0, 701)
    for sampling in "xyz", "rgb", "gauss:6,xyz":
        stack = reference("fixed.tif", path_of("a.scene"), "--sampling", sampling)
        radiance = 2 * light("d65", fine) * np.interp(fine, *table("data/builtin/materials/colorchecker/19-white.txt"))
        found = said("develop", stack, "--white", "d65*2*colorchecker/19-white", "--xyz", "-o", path_of("x.tif"))
        check(near(found["white"], weights("cie1931", fine) @ radiance, 1e-6), f"{sampling}: a lit surface is white", found, weights("cie1931", fine) @ radiance)
        for command, *words in ("develop", stack, "-o", REFUSED), ("compare", stack, stack, "--tolerance", "1dE00"):
            refuses(f"{sampling}: an object as white, by {command}", "was sampled for cie1931; --white object: needs all wavelengths", command, *words, "--white", "object:2", absent=REFUSED)
    refuses("an object of a scene as white", "expected TIFF", "probe", path_of("a.scene"), "1", "1", "--white", "object:2")


# ---- raw files ----

def raw_files():
    camera = CAMERAS[6]
    floats, counts, others, few = (path_of(f"{name}.tif") for name in ("floats", "counts", "others", "few"))
    words = "--raw", "--detector", camera.path, "-q", "-o"
    output_of("develop", A, *words, floats)
    output_of("develop", A, "--bits", "16", *words, counts)
    output_of("develop", B, *words, others)
    output_of("develop", A, "--raw", "--detector", CAMERAS[3].path, "-q", "-o", few)
    with tifffile.TiffFile(counts) as file:
        step = float(re.search("full_scale: (\\S+)", file.pages[0].description).group(1)) / 65535
    pages = {floats: pages_of(floats), counts: pages_of(counts) * step, others: pages_of(others)}
    check(near(pages[floats], np.tensordot(camera.weights(NM), SEEN[A][0], 1), FLOAT), "raw values are sums")
    for path in floats, counts:
        name = os.path.basename(path)
        for x, y, w, h in (15, 15, 1, 1), (8, 8, 20, 15):
            at = pages[path][:, y:y + h, x:x + w]
            found = said("probe", path, x, y, w, h)
            check(near(found["radiance"], at.mean((1, 2)), FLOAT) and np.allclose(found["standard_deviation"], at.std((1, 2)), rtol=1e-5, atol=1e-12),
                  f"{name}: probe of {w} x {h} pixels is numpy's", found, at.mean((1, 2)))
            check(found["XYZ"] is None and found["unit"] == "raw" and found["wavelengths_nm"] is None and not found["channels"], f"{name}: there are no colours", found)
        rows = list(csv.reader(io.StringIO(output_of("probe", path, "15", "15", "--csv"))))
        check(rows[0] == ["channel (number)", "raw value (raw)", "standard deviation (raw)"] and near([float(row[1]) for row in rows[1:]], pages[path][:, 15, 15], FLOAT) and
              [row[0] for row in rows[1:]] == list("123456"), f"{name}: a row a channel", rows)
        check("XYZ" not in output_of("probe", path, "15", "15"), f"{name}: words have no colours")
        text = output_of("info", path)
        check(f"raw values of: {A}" in text and f"detector: {camera.path}" in text, f"{name}: info says what it is", text)
        for command, *more in ("develop", "-o", REFUSED), ("view", "-o", path_of("refused.html")), ("envi", "-o", path_of("refused.img")):
            refuses(f"{name}, by {command}", "has raw values of a detector's channels; expected the stack", command, path, *more, absent=more[1])
        refuses(f"{name}: objects", "no map of objects", "probe", path, "--objects")
        for words in ("--detector", camera.path), ("--matrix", camera.matrix_path), ("--white", "d65"):
            refuses(f"{name}: {words[0]}", "has raw values, which no eye sees", "probe", path, "15", "15", *words)
    check(run("compare", floats, floats).returncode == 0, "a raw file equals itself")
    for b in counts, others:
        result = run("compare", "-v", floats, b)
        off, slack = np.abs(pages[b] - pages[floats]), FLOAT * pages[b].max()  # counts are read as floats
        rows = re.findall("^(\\d) +(\\S+) +(\\d+),(\\d+) +(\\S+)$", result.stdout, re.M)
        check("\nchannel           largest" in result.stdout and len(rows) == 6 and all(
            np.allclose([float(row[1]), float(row[4])], [page.max(), np.sqrt((page ** 2).mean())], rtol=1e-5, atol=slack) for row, page in zip(rows, off)),
            f"{os.path.basename(b)}: compare -v has a line a channel", result.stdout)
        found = said("compare", floats, b)
        check(abs(found["largest"] - off.max()) <= slack and abs(found["rms"] - np.sqrt((off ** 2).mean())) <= slack and found["wavelengths_nm"] is None and "dE00" not in found and
              "colour            none: raw values have none" in result.stdout, f"{os.path.basename(b)}: compare is numpy's", found, off.max())
        for tolerance, status in ((found["largest"] * 1.00001, 0), (found["largest"] * 0.99999, 1)):
            check(run("compare", floats, b, "--tolerance", f"{tolerance:.9g}").returncode == status, f"a tolerance of {tolerance:.6g} has status {status}")
    for a, b, more in ((floats, A, []), (A, floats, []), (floats, few, []), (floats, counts, ["--tolerance", "1dE00"]), (floats, counts, ["--white", "d65"]), (floats, A, ["--white", "d65"]),
                       (floats, counts, ["--other", "cie1931"]), (floats, counts, camera.options)):
        refuses(f"{os.path.basename(a)} and {os.path.basename(b)} {' '.join(more[:1])}", "raw values have no colours; expected two files of as many channels", "compare", a, b, *more)


parts(pictures, probes, forms, refused_matrices, pixels, objects, published, bounds, whites, raw_files)
done()
