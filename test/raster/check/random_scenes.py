#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full release; packages: python3-numpy python3-tifffile libosmesa6-dev; makes: faults
"""Renders random scenes, with everything that the scene language has, by the program ($SPECTRAL) and cross-
checks every pixel at 31 wavelengths. A scene follows from its seed alone. A scene that fails is kept in
test/cases/random/, and later runs begin with it; data/samples/reduce.py makes it small. Prints TAP.

    test/raster/check/random_scenes.py                                  200 scenes on llvmpipe, 30 on softpipe; with FULL=1 1000 and 120,
                                                                        with SOAK=1 (`test release`) 5000 and 500
    test/raster/check/random_scenes.py 1000 5000                        5000 scenes on each, from scene 1000"""
import concurrent.futures
import glob
import json
import os
import random
import re
import shutil
import subprocess
import sys
import time

import numpy as np
import tifffile

from rendered import FAULTS, SPECTRAL, TMP, amount, check, done, path_of

KEPT = "test/cases/random"
COUNT = {"llvmpipe": amount(200, 1000, 5000), "softpipe": amount(30, 120, 500)}
SHADOWS = {"llvmpipe": amount(60, 200, 1000), "softpipe": amount(20, 60, 200)}
RELIEFS = {"llvmpipe": amount(60, 240, 1000), "softpipe": amount(20, 60, 200)}  # with shadows, too
WAVELENGTHS = "wavelengths 400 700 10"
PATIENCE_S = 300  # seconds after which a scene counts as hung
MOST_KEPT = 3  # scenes a run

# Reasons to refuse a scene: its numbers leave the range of single precision, or a light grazes a surface so
# exactly that rounding alone decides whether the surface shines.
REFUSALS = [
    "the texture must repeat less often",
    "is not finite in the window; coordinates and scales are too large",
    "single precision does not know depths there better than",
    "reflects no finite radiance; a light that weakens with distance may be too near",
    "the object's transform is singular or not finite",
    "rounding alone decides whether the brightest point of the picture reflects",
]

# ---- chance ----


class Dice:
    """Uses random() alone: Python promises the same numbers in every version for no other function."""

    def __init__(self, seed):
        self.random = random.Random(seed).random

    def chance(self, share):
        return self.random() < share

    def whole(self, low, high):
        return low + int(self.random() * (high - low + 1))

    def pick(self, *items):
        return items[int(self.random() * len(items))]

    def real(self, low, high):
        """Often draws a round number, where formulas have their special cases."""
        value = low + self.random() * (high - low)
        return float(f"{value:.4g}") if self.chance(0.85) else float(round(value))

    def share(self):
        return float(f"{self.random():.3g}")

    def log(self, low, high):
        """Draws every order of magnitude with the same probability."""
        return float(f"{low * (high / low) ** self.random():.3g}")


def line(*words):
    return " ".join(f"{word:.9g}" if isinstance(word, float) else str(word) for word in words)


# ---- meshes ----


def height_field(dice, step):
    """Vertices that all neighbours share; quadrilaterals, which are bent, or triangles."""
    n, m, rough = dice.whole(1, 7), dice.whole(1, 7), dice.pick(0.0, 0.2, 1.0)
    points = [(round((2 * i / n - 1) / step) * step, round((2 * j / m - 1) / step) * step,
               round(dice.real(-rough, rough) / step) * step)
              for j in range(m + 1) for i in range(n + 1)]
    corner = [(j * (n + 1) + i + 1, j * (n + 1) + i + 2, (j + 1) * (n + 1) + i + 2,
               (j + 1) * (n + 1) + i + 1) for j in range(m) for i in range(n)]
    if dice.chance(0.5):
        return points, [half for a, b, c, d in corner for half in ((a, b, c), (a, c, d))]
    return points, corner


def needles(dice, step):
    """A fan of thin triangles that share the vertex in the middle."""
    n = dice.whole(3, 60)
    points = [(0.0, 0.0, dice.real(0, 1))] + [(1.0, 2 * i / n - 1, 0.0) for i in range(n + 1)]
    return points, [(1, i + 2, i + 3) for i in range(n)]


def slivers(dice, step):
    """Triangles whose vertices nearly lie on a line."""
    points, faces = [], []
    for i in range(dice.whole(1, 6)):
        a, b = ([dice.real(-2, 2) for _ in range(3)] for _ in range(2))
        share, off = dice.random(), dice.pick(1e-1, 1e-2, 1e-2, 1e-3, 1e-5)
        c = [p + share * (q - p) + off * dice.real(-1, 1) for p, q in zip(a, b)]
        points += [a, b, c]
        faces.append((3 * i + 1, 3 * i + 2, 3 * i + 3))
    return points, faces


def soup(dice, step):
    """Triangles that share vertices at random, cross each other, or have no area."""
    points = [[round(dice.real(-2, 2) / step) * step for _ in range(3)]
              for _ in range(dice.whole(4, 12))]
    n = len(points)
    return points, [[dice.whole(1, n) for _ in range(3)] for _ in range(dice.whole(2, 12))]


def prism(dice, step):
    """A prism with polygons as its ends; edges may be creases."""
    n = dice.whole(1, 5)
    half = [((1 - t * t) / (1 + t * t), 2 * t / (1 + t * t))
            for t in ((2 * i / n - 1) for i in range(n + 1))]
    ring = [(round(x / step) * step, round(y / step) * step) for x, y in half + [(-1, 1), (-1, -1)]]
    k = len(ring)
    points = [(x, y, z) for z in (-0.5, 0.5) for x, y in ring]
    sides = [(i + 1, (i + 1) % k + 1, (i + 1) % k + 1 + k, i + 1 + k) for i in range(k)]
    return points, sides + [tuple(range(k, 0, -1)), tuple(range(k + 1, 2 * k + 1))]


def normal(dice):
    """Normals: most are no unit vectors, and the squares of some vanish or overflow in single precision."""
    length = dice.pick(0.0, 1e-19, 1e20) if dice.chance(0.03) else dice.pick(1.0, 1.0, 0.01, 30.0)
    return [length * dice.real(-1, 1) for _ in range(2)] + [length]


def mesh_text(dice, step, parts):
    points, faces = dice.pick(height_field, height_field, needles, slivers, soup, prism)(dice, step)
    coordinates = dice.chance(0.5)
    # A mesh or part needs a face of some area: each begins with this one.
    n = len(points)
    points = [*points, (1, 1, 1), (1.5, 1, 1), (1, 1.5, 1)]
    uses = [(part, [n + 1, n + 2, n + 3]) for part in parts or [""]]
    uses += [(dice.pick(*parts) if parts else "", face) for face in faces]
    lines = [line("v", *(float(x) for x in point)) for point in points]
    normals = dice.chance(0.2)
    if coordinates:
        lines += [line("vt", float(x), float(y)) for x, y, _ in points]
    if normals:
        lines += [line("vn", *normal(dice)) for _ in points]
    corner = {(False, False): "{0}", (True, False): "{0}/{0}", (False, True): "{0}//{0}",
              (True, True): "{0}/{0}/{0}"}[coordinates, normals]
    for i, (part, face) in enumerate(uses):
        if part and (i == 0 or part != uses[i - 1][0]):
            lines.append("usemtl " + part)
        lines.append(line("f", *(corner.format(k) for k in face)))
    return "\n".join(lines) + "\n"


# ---- scenes ----

GREY = [f"grey-{i}.tif" for i in range(6)]
STACKS = [f"stack-{i}.tif" for i in range(3)]


def write_textures(folder):
    numbers = np.random.default_rng(1)
    sides = [(8, 8), (13, 7), (64, 32), (1, 1), (100, 61)]
    for name, shape in zip(GREY, sides):
        kind = np.uint16 if shape[0] % 2 else np.uint8
        image = numbers.integers(0, np.iinfo(kind).max + 1, shape).astype(kind)
        tifffile.imwrite(os.path.join(folder, name), image)
    y, x = np.mgrid[0:48, 0:48]
    smooth = np.round(30000 + 20000 * np.sin(x * np.pi / 24) * np.cos(y * np.pi / 24))
    tifffile.imwrite(os.path.join(folder, GREY[5]), smooth.astype(np.uint16))
    bands = [(550,), (400, 700), range(380, 740, 40)]
    for name, shape, nm in zip(STACKS, [(4, 4), (9, 5), (32, 32)], bands):
        with tifffile.TiffWriter(os.path.join(folder, name)) as stack:
            for band in nm:
                page = numbers.integers(0, 65536, shape).astype(np.uint16)
                stack.write(page, contiguous=False, extratags=[(285, 2, 0, f"{band} nm", True)])


class Writer:
    """Writes one scene. In its texts @ stands for the beginning of its files' names."""

    def __init__(self, seed, size):
        self.dice = dice = Dice(seed)
        self.files, self.lines = {}, []
        self.style = dice.pick("free", "free", "free", "free", "inside", "round", "dyadic", "exact")
        self.width, self.height = size
        self.step = 1 / 64
        if self.style == "exact":
            self.width = self.height = 1 << (min(size).bit_length() - 1)
        self.lines += [WAVELENGTHS, line("size", self.width, self.height)]
        self.camera()
        self.statements()
        self.n_materials = dice.whole(1, 4)
        for _ in range(self.lights_wanted()):
            self.light()
        if dice.chance(0.05):
            self.lines.append("include @-more.scene")
            self.files["-more.scene"] = "material plain { diffuse 0.4 gloss 10 }\n"
        else:
            self.lines.append("material plain { diffuse 0.4 gloss 10 }")
        for i in range(self.n_materials):
            self.material(i)
        for _ in range(dice.whole(1, dice.pick(2, 6))):
            self.objects()
        if dice.chance(0.08):
            self.checker()
        self.files[".scene"] = "\n".join(self.lines) + "\n"

    def length(self, low, high):
        if self.style == "exact" or self.style == "dyadic":
            return round(self.dice.real(low, high) / self.step) * self.step
        return self.dice.real(low, high)

    def vector(self, reach):
        return [self.length(-reach, reach) for _ in range(3)]

    def direction(self, forward=False):
        vector = self.vector(1)
        if forward:
            vector[2] = abs(vector[2])
        return vector if any(vector) else [0.0, 0.0, 1.0]

    # -- statements on the whole scene --

    def camera(self):
        dice = self.dice
        if self.style == "exact":
            # A unit is a power of two of pixels; steps of a pixel, half a pixel, and 1/256.
            across = dice.pick(4, 8, 16)
            self.step = across / self.width / dice.pick(1, 2, 2, 256)
            depth = dice.pick(16, 16, 2, 1)  # objects may end at the near or far plane
            self.lines.append(line("camera ortho", across, "near", -depth, "far", depth))
        elif self.style == "dyadic":
            # Edges pass through pixel centres, but their numbers are rounded in single precision.
            across = dice.pick(self.width / 32, self.width / 16, 5.0, 10.0)
            self.step = across / self.width * dice.pick(0.5, 1, 4)
            depth = dice.pick(16, 16, 2, 1)
            self.lines.append(line("camera ortho", across, "near", -depth, "far", depth))
        elif self.style == "inside":
            angle = dice.pick(dice.real(40, 120), 90, 150, 175)
            self.lines.append(line("camera perspective", angle, "near", dice.log(0.001, 1),
                                   "far", dice.pick(5, 60, 1000), "eye", *self.vector(0.7),
                                   "look", *self.vector(0.7)[:2], 3.0))
        elif self.style == "free" and dice.chance(0.35):
            words = ["camera ortho", dice.pick(dice.real(4, 12), dice.log(0.3, 60))]
            if dice.chance(0.5):
                words += ["near", dice.real(-6, 0), "far", dice.real(1, 8)]
            if dice.chance(0.6):
                words += ["eye", *self.vector(2)[:2], 3.0, "look", *self.vector(1)]
            self.lines.append(line(*words))
        else:
            angle = dice.pick(dice.real(20, 90), 90, 60, dice.log(0.5, 20), 130)
            away = min(max(300 / angle, 2), 300) if angle < 60 else dice.real(2, 9)
            near = dice.pick(0.001, 0.1, 1, 3, dice.log(0.001, 3), 0.8 * away)
            far = dice.pick(1.1, 2.0, 20.0) * away + 4
            free = self.style == "free"
            eye = [*self.vector(3)[:2], away] if free else [0.0, 0.0, float(round(away))]
            look = [*self.vector(1)[:2], -1.0] if free and dice.chance(0.8) else [0.0, 0.0, 0.0]
            words = ["camera perspective", angle, "near", float(near), "far", far]
            words += ["eye", *eye, "look", *look]
            if dice.chance(0.2):
                words += ["up", self.dice.real(-1, 1), 1.0, 0.5]
            self.lines.append(line(*words))

    def statements(self):
        dice = self.dice
        if dice.chance(0.4):
            self.lines.append("viewer local")
        if dice.chance(0.25):
            self.lines.append("shading flat")
        for _ in range(dice.pick(0, 0, 0, 1, 1, 2)):
            self.lines.append(line("ambient", self.radiation(), dice.real(0, 0.3)))

    # -- lights --

    def radiation(self):
        dice = self.dice
        if dice.chance(0.05):
            self.files["-lamp.csv"] = "350 1\n400 0.5\n545 1\n546 9\n547 1\n800 0\n"
            return "@-lamp.csv"
        return dice.pick("d65", "d65", "a", "fluorescent", "uv", "1",
                         f"blackbody:{dice.whole(1000, 20000)}",
                         f"gaussian:{dice.whole(350, 720)},{dice.whole(5, 100)}")

    def lights_wanted(self):
        many = self.dice.chance(0.08)
        return self.dice.whole(9, 20) if many else self.dice.pick(0, 1, 1, 2, 2, 3, 4)

    def light(self):
        dice = self.dice
        words = ["light", self.radiation(), dice.pick(dice.real(0.1, 1), dice.log(0.001, 100))]
        if dice.chance(0.35):
            self.lines.append(line(*words, "direction", *self.direction(dice.chance(0.7))))
            return
        at = [dice.real(-6, 6), dice.real(-6, 6), dice.real(-2, 9)]
        if dice.chance(0.1):
            at = self.vector(1)  # among the objects, perhaps in a vertex
        words += ["position", *at]
        if dice.chance(0.4):
            factors = [dice.pick(factor, dice.log(1e-3, 10)) for factor in (1, 0, 0)]
            words += ["attenuation", *factors]
        if dice.chance(0.4):
            axis = [dice.real(-2, 2) - at[0], dice.real(-2, 2) - at[1], -at[2]]
            words += ["spot", *(axis if any(axis) else [0.0, 0.0, -1.0]),
                      dice.pick(0, 90, 180, 1, 89.9, dice.real(5, 60)),
                      dice.pick(0, 1, 128, 0.5, dice.log(0.1, 128))]
        self.lines.append(line(*words))

    # -- materials --

    def reflectance(self, most=1.0):
        dice = self.dice
        value = most * dice.share()
        return dice.pick(f"{value:g}",
                         f"gaussian:{dice.whole(380, 720)},{dice.whole(10, 120)}*{value:g}",
                         f"{most:g}", f"builtin:materials/colorchecker/15-red.txt*{value:g}")

    def material(self, i):
        dice = self.dice
        if dice.chance(0.1):
            self.lines.append(f"material m{i} builtin:materials/" + dice.pick(
                "metals/gold.txt", "metals/silver.txt", "fluorescence/green.txt",
                "metamers/observer-1-grey.txt", "colorchecker/16-yellow.txt"))
            return
        if dice.chance(0.07):
            self.lines.append(f"material m{i} @-m{i}.txt")
            self.files[f"-m{i}.txt"] = self.material_file()
            return
        words = [f"material m{i} {{"]
        bispectral = dice.chance(0.12)
        if bispectral or dice.chance(0.9):
            words += ["diffuse", self.reflectance(0.3 if bispectral else 1.0)]
        else:
            words += ["emission", self.radiation() + "*0.2"]
        if dice.chance(0.45):
            words += ["gloss", dice.pick(0, 0.1, 0.3, 1, 2, 20, 128, dice.log(0.1, 128))]
        if dice.chance(0.35):
            words += ["specular", self.reflectance()]
        if bispectral:
            words += [f"donaldson @-dye{i}.csv"]
            self.files[f"-dye{i}.csv"] = self.matrix()
        elif dice.chance(0.2):
            words += [f"fluorescence gaussian:{dice.whole(300, 450)},{dice.whole(5, 60)}",
                      f"gaussian:{dice.whole(430, 650)},{dice.whole(10, 80)}*0.5"]
        if dice.chance(0.2) and "emission" not in words:
            words += ["emission", self.radiation() + "*0.3"]
        look_up = dice.pick("nearest", "linear", "bilinear", "")
        if dice.chance(0.4):
            words += ["texture", dice.pick(*GREY, "builtin:textures/checks.tif"), look_up]
        elif dice.chance(0.4):
            picture = dice.pick(*STACKS, "builtin:textures/picture.tif")
            words += ["spectral-texture", picture, look_up]
        if dice.chance(0.25):
            words += ["metamer plain"]
        self.lines.append(line(*words, "}"))

    def material_file(self):
        dice = self.dice
        text = [line(nm, dice.share()) for nm in range(400, 701, 50)]
        if dice.chance(0.5):
            text += [line("g", dice.log(0.1, 128))]
        if dice.chance(0.5):
            text += [line("s", nm, dice.share()) for nm in (400, 700)]
        if dice.chance(0.5):
            text += [line("f", nm, dice.share(), dice.share()) for nm in (350, 450)]
            text += ["f 500 0.5 0.5"]
        if dice.chance(0.5):
            text += [line("mr", nm, dice.share()) for nm in (400, 550, 700)]
        if dice.chance(0.5):
            text += [f"t {dice.pick(*GREY)}"]
        return "\n".join(text) + "\n"

    def matrix(self):
        dice = self.dice
        first = dice.whole(300, 400)
        columns = [first + 20 * i for i in range(dice.whole(1, 6))]
        rows = [line(to, *((nm != to) * (0.05 + 0.08 * dice.share()) for nm in columns))  # the diagonal would be a reflectance
                for to in range(430, 551, 30)]
        return "\n".join([line("nm", *columns), *rows]) + "\n"

    # -- objects --

    def some_material(self):
        return f"material m{self.dice.whole(0, self.n_materials - 1)}"

    def divisions(self, least):
        dice = self.dice
        return dice.pick(least, dice.whole(least, 12), dice.whole(least, 30), dice.whole(least, 30),
                         dice.whole(40, 80) if dice.chance(0.3) else 8)

    def size(self):
        if self.style in ("exact", "dyadic"):
            return max(self.length(0.25, 4), self.step)
        if self.dice.chance(0.02):
            return self.dice.log(0.01, 1000)  # much longer than wide
        return self.factor * self.dice.log(0.3, 3)

    def shape(self):
        dice = self.dice
        kind = dice.pick("sphere", "torus", "box", "plane", "plane", "cylinder", "cone", "disk",
                         "teapot", "mesh", "mesh")
        if self.style == "exact":
            kind = dice.pick("box", "plane", "mesh", "mesh")
        self.factor = dice.log(0.01, 1000) if dice.chance(0.15) else 1.0
        size = self.size()
        if kind == "sphere":
            return line(kind, size, self.divisions(3), self.divisions(2))
        if kind == "torus":
            tube = size * dice.pick(0.1, 0.4, 1.2)
            return line(kind, tube, size, self.divisions(3), self.divisions(3))
        if kind == "box":
            return line(kind, size, self.size(), self.size())
        if kind == "plane":
            return line(kind, size, self.size())
        if kind in ("cylinder", "cone"):
            return line(kind, size, self.size(), self.divisions(3), self.divisions(1))
        if kind == "disk":
            return line(kind, size, self.divisions(3))
        if kind == "teapot":
            return line(kind, size, dice.whole(1, 6))
        return self.mesh()

    def mesh(self):
        dice = self.dice
        i = sum(name.endswith(".obj") for name in self.files)
        parts = ["red", "green", "blue"][:dice.whole(0, 3)]
        self.files[f"-mesh{i}.obj"] = mesh_text(dice, self.step, parts)
        words = f"mesh @-mesh{i}.obj" + dice.pick("", "", " unitize")
        words += dice.pick("", " crease 0", " crease 180", " crease 40")
        if not parts:
            return words
        uses, entries = ["* material plain"], ""
        for part in parts:
            if dice.chance(0.3):
                uses.append(f"{part} mtl @-mesh{i}.mtl")
                entry = [f"newmtl {part}", line("Kd", *(dice.share() for _ in range(3))),
                         "Ks 0.5 0.5 0.5", line("Ns", dice.pick(0, 10, 1000))]
                entries += "\n".join(entry) + "\n"
                self.files[f"-mesh{i}.mtl"] = entries
            else:
                uses.append(part + " " + self.some_material())
        self.files[f"-mesh{i}.map"] = "\n".join(uses) + "\n"
        return words + f" materials @-mesh{i}.map"

    def scaling(self):
        dice = self.dice
        if self.style == "exact":
            return line("scale", *(dice.pick(-1, 0.5, 1, 2) for _ in range(3)))
        if dice.chance(0.2):
            return line("scale", dice.pick(-1, 0.5, 2, 1.000001, dice.log(0.01, 100)))
        factors = [dice.pick(1, dice.log(0.3, 3), dice.log(0.01, 10)) for _ in range(3)]
        return line("scale", *(dice.pick(-1, 1) * factor for factor in factors))

    def rotation(self):
        dice = self.dice
        if self.style == "exact":
            return dice.pick("", "rotate 180 0 0 1", "rotate 90 0 0 1")
        if self.style in ("dyadic", "round") or dice.chance(0.15):
            axis = dice.pick((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1))
            return line("rotate", dice.pick(0, 45, 90, 180, -90, 30), *axis)
        return line("rotate", dice.real(0, 360), *self.direction())

    def transform(self):
        dice = self.dice
        words = []
        if dice.chance(0.3):
            words.append(self.scaling())
        words.append(self.rotation())
        if dice.chance(0.15):  # sheared
            words += [self.scaling(), self.rotation()]
        reach = 1 if self.style == "inside" else 2
        return " ".join(words + [line("translate", *self.vector(reach))])

    def options(self):
        dice = self.dice
        words = ["two-sided"] if dice.chance(0.4) else []
        if dice.chance(0.4):
            words.append(line("repeat", dice.log(0.1, 20), dice.pick(1, dice.log(0.1, 20))))
        if dice.chance(0.2):
            words.append("planar")
        return words

    def objects(self):
        """One object; or two equal ones, where the order decides; or two in one plane."""
        dice = self.dice
        shape, options, transform = self.shape(), self.options(), self.transform()
        flat = shape.startswith(("plane", "disk", "box"))
        again = [shape] if dice.chance(0.12) else []
        if flat and dice.chance(0.25):
            again.append(line("plane", self.size(), self.size()))
        for what in [shape, *again]:
            words = ["object", what, *options, transform]
            if " materials " not in what:
                words.insert(2, self.some_material())
            self.lines.append(" ".join(word for word in words if word))

    def checker(self):
        dice = self.dice
        names = [f"builtin:materials/{name}.txt" for name in (
            "metals/copper", "fluorescence/red", "metamers/illuminant-4-foliage",
            "colorchecker/01-dark-skin", "colorchecker/19-white")][:dice.whole(1, 5)]
        self.files["-checks.list"] = "\n".join(names) + "\n"
        shape = dice.pick("torus 0.6 1.2 6 9", "sphere 2 12 8", "cone 1 2 9 2")
        self.lines.append(line("checker @-checks.list", shape, *self.options(), self.transform()))


def with_reliefs(text, seed):
    """Displaces two of three objects. Planes and boxes get divisions; meshes without vt need planar coordinates."""
    dice, out = Dice(seed + 0.5), []
    for words in text.split("\n"):
        if words.startswith(("object", "checker")) and dice.chance(0.67):
            words = re.sub(r"(plane \S+ \S+|box \S+ \S+ \S+)", rf"\1 {dice.whole(1, 20)}", words)
            words += line(" displace", dice.pick(*GREY, "ripples", "weave"), dice.pick(-1, 1, 1) * dice.log(0.001, 1))
            words += " planar" if " mesh " in words and " planar" not in words else ""
        out.append(words)
    return "\n".join(out)


def scene(seed, size=(200, 200)):
    """The scene's texts by the ends of their names; ".scene" is the first to read."""
    files = Writer(seed, size).files
    return {**files, ".scene": with_reliefs(files[".scene"], seed)} if DISPLACED else files


def put(files, folder, name):
    """Writes a scene's files; returns the path of the scene."""
    for end, text in files.items():
        with open(os.path.join(folder, name + end), "w") as out:
            out.write(text.replace("@", name))
    return os.path.join(folder, name + ".scene")


# ---- rendering ----


MORE = []  # options of render
DISPLACED = []  # not empty: scenes have reliefs


class Result:
    def __init__(self, path, driver, **environment):
        command = [SPECTRAL, "render", path, *"-o /dev/null --json - --quiet --threads 1 --unchecked 1".split(), *MORE]
        environment = {**os.environ, "GALLIUM_DRIVER": driver, **environment}
        started = time.monotonic()
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S,
                                  check=False, env=environment)
            self.status, self.message = done.returncode, done.stderr.strip()
        except subprocess.TimeoutExpired:
            self.status, self.message = "hangs", ""
        self.seconds = time.monotonic() - started
        self.refused = self.status == 2 and any(why in self.message for why in REFUSALS)
        self.report = json.loads(done.stdout) if self.status in (0, 1) else None

    def failed(self):
        return self.status != 0 and not self.refused


def keep(files, folder, name):
    os.makedirs(folder, exist_ok=True)
    path = put(files, folder, name)
    for texture in GREY + STACKS:
        if any(texture in text for text in files.values()):
            shutil.copy(path_of(texture), folder)
    return path


# ---- truths ----

# Some scene must match each of these patterns; in the order of the README.
COVERAGE = [
    r"^include", r"lamp\.csv", r"camera ortho", r"camera perspective", r" near 0\.00", r" up ",
    r"viewer local", r"shading flat", r"^ambient", r"^light .* direction", r"^light .* position",
    r"attenuation", r"spot", r"spot .* 180 ", r"(?s)(^light .*){9}", r"object sphere",
    r"object torus", r"object box", r"object plane", r"object cylinder", r"object cone",
    r"object disk", r"object teapot", r"object mesh", r"^checker", r"unitize", r"crease",
    r"materials @", r" mtl ", r"^usemtl", r"^vn ", r"two-sided", r"planar", r"repeat", r"scale -",
    r"rotate .* scale .* rotate", r"gloss 128", r"gloss 0\.1 ", r"specular", r"fluorescence",
    r"donaldson", r"emission", r" texture .*nearest", r" texture .* linear", r" texture .* bilinear",
    r"spectral-texture .*nearest", r"spectral-texture .* linear", r"spectral-texture .* bilinear", r"metamer", r"material m\d @",
    r"^(object .*)\n\1$",
]


def check_coverage(texts, effects):
    lacking = [pattern for pattern in COVERAGE if not re.search(pattern, texts, re.M)]
    check(not lacking, "the scenes contain all words and cases of the list", *lacking)
    idle = [name for name in effects[0] if not any(effect[name] for effect in effects)]
    used = ["shadows"] * ("--shadows" in MORE) + ["displace"] * len(DISPLACED)
    check(idle == [name for name in ("shadows", "phong", "displace", "tessellation") if name not in used],
          "the scenes use every effect of OpenGL that a scene can ask for", *idle)


def replay(driver):
    """Replays the scenes that failed once."""
    for path in sorted(glob.glob(os.path.join(KEPT, f"*-{driver}.scene"))):
        result = Result(path, driver)
        name = os.path.basename(path)
        check(result.status == 0, f"{driver}: a scene that failed once passes: {name}", result.message)


def draw(seed, driver):
    files, name = scene(seed), f"{seed}-{driver}"
    result = Result(put(files, TMP, name), driver)
    for end in files:
        os.remove(os.path.join(TMP, name + end))
    return seed, files, result


def describe(found):
    return ", ".join(f"{round(found[name], 4)} {name.replace('_', ' ')}" for name in SUMS + LARGEST)


MANY = 1000  # scenes, after which each class has shown its largest errors


def kinds(files, effects):
    """The classes of a scene: its effects, its camera, and shading."""
    text = files[".scene"]
    return ["perspective" if "camera perspective" in text else "parallel",
            *(["flat"] if "shading flat" in text else []),
            *(name for name, used in effects.items() if used and name != "lights")]


SUMS = ["pixels", "object_pixels", "ambiguous_pixels", "unexplained_pixels", "unchecked_pixels", "open_pixels", "open_edge_pixels",
        "edge_pixels", "unbounded_pixels"]
LARGEST = ["worst_error_over_bound", "worst_band_error_over_bound", "worst_depth_error_over_bound"]


def run(driver, seeds):
    started = time.monotonic()
    total = dict.fromkeys(SUMS + LARGEST, 0)
    failed, refused, texts, effects, seconds, classes = [], 0, "", [], 0, {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for seed, files, result in pool.map(lambda seed: draw(seed, driver), seeds):
            texts += "".join(files.values())
            seconds += result.seconds
            refused += result.refused
            if result.failed():
                failed.append(seed)
                print(f"# {driver}: scene {seed}, exit {result.status}:", result.message)
                if len(failed) <= MOST_KEPT:
                    print("# kept as", keep(files, KEPT, f"{seed}-{driver}"), flush=True)
            if result.report is None:
                continue
            effects.append(result.report["effects"])
            found = {name: result.report["check"].get(name) or 0 for name in total}
            for kind in kinds(files, result.report["effects"]):
                classes[kind] = max(classes.get(kind, 0), *(found[name] for name in LARGEST[:2]))
            for name in total:
                add = sum if name in SUMS else max
                total[name] = add((total[name], found[name]))
    judge(driver, len(seeds), total, failed, refused)
    print(f"# {driver}, largest error / bound by class:",
          ", ".join(f"{kind} {ratio:.2f}" for kind, ratio in sorted(classes.items())), flush=True)
    if len(seeds) >= MANY:
        check(all(ratio > 0.2 for ratio in classes.values()),
              f"{driver}: in no class of scenes are the bounds five times too wide", classes)
    if len(seeds) >= 200:
        check_coverage(texts, effects)
    print(f"# {driver}: {len(seeds)} scenes from {seeds[0]}, {refused} refused: {describe(total)};"
          f" {time.monotonic() - started:.0f} s, {seconds:.0f} s in the program", flush=True)


def judge(driver, n, total, failed, refused):
    least = 0.2 if n >= 30 else 0.02  # few scenes show smaller errors
    least *= 0.5 if MORE else 1  # and so do smaller triangles
    check(not failed, f"{driver}: all of {n} scenes are drawn", f"not {failed}")
    check(refused <= 0.05 * n, f"{driver}: few scenes are refused", f"{refused} of {n}")
    check(total["unexplained_pixels"] == 0 < total["pixels"],
          f"{driver}: every pixel is explained at all wavelengths", total)
    # many scenes have surfaces in one plane, and a light that just reaches a vertex, or a shadow that may end anywhere
    check(total["unchecked_pixels"] - total["open_pixels"] < 0.01 * total["object_pixels"],
          f"{driver}: fewer than one object pixel in 100 cannot be checked, besides those that OpenGL leaves open", total)
    check(total["open_pixels"] < 0.25 * total["object_pixels"], f"{driver}: it leaves less than a quarter open", total)
    for name, what in zip(LARGEST, ("bounds", "bounds of one band", "bounds on depth")):
        check(least < total[name] <= 1, f"{driver}: the {what} are neither exceeded nor far too wide", total[name])


def check_fault(size):
    """Plants a fault in the GL path. The first scene of one file that shows it is kept, and shows it again."""
    fault = {"LD_PRELOAD": FAULTS, "FAULT": "24"}
    for seed in range(1, 100):
        files = scene(seed, size)
        if len(files) == 1 and Result(put(files, TMP, "planted"), "llvmpipe", **fault).status == 1:
            break
    path = keep(files, path_of("kept"), f"{seed}-llvmpipe")
    check(Result(path, "llvmpipe", **fault).status == 1, "a kept scene shows the planted fault", path)
    check(Result(path, "llvmpipe").status == 0, "the kept scene passes without the fault", path)


def main():
    first, *count = map(int, sys.argv[1:] or ["1"])
    write_textures(TMP)
    for driver, n in COUNT.items():
        replay(driver)
        run(driver, range(first, first + (count or [n])[0]))
    check_fault((64, 64))
    for more, n_of in (["--samples", "2", "--size", "100x100"], {"llvmpipe": 30}), (["--shadows"], SHADOWS), (["--shadows"], RELIEFS):
        MORE[:] = more
        DISPLACED[:] = [True] * (n_of is RELIEFS)
        for driver, n in n_of.items():
            run(driver, range(8060, 8060 + n))
    done()


if __name__ == "__main__":
    main()
