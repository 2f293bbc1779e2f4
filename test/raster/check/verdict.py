#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile python3-pil libosmesa6-dev; makes: faults mutants
"""Checks what the program ($SPECTRAL) says of its own check: that a picture in which little could be checked is never
called agreed, that small faults in single samples are found where the floor says so, and that the map shows both.
Prints TAP. Faults 73 to 84 are those of faults.md; $FAULTS plants them. ENDLESS is the program with infinite
bounds for the first object of a scene; HOLLOW takes open meshes for solids; WHOLE draws the backs of solids, too."""
import json
import math
import os
import random
import subprocess

import numpy as np
import tifffile
from PIL import Image

from rendered import FAULTS, SPECTRAL, check, done, parts, output_of, path_of, remove, run, write

ENDLESS, HOLLOW, WHOLE = (os.path.join(os.path.dirname(FAULTS), f"spectral-{name}")
                          for name in ("endless", "hollow", "whole"))
DRIVERS = "llvmpipe", "softpipe"
CASES = "test/cases/verdict/"
SMALL = "--size", "300x200", "--wavelengths", "400:700:20"
BACKGROUND = -1000
CHECKED, AMBIGUOUS, NOT_CHECKED, DIFFERS = range(4)


class Render:
    """A run: its exit status, messages, table and JSON report, and if it was asked for, the map by page names."""

    def __init__(self, scene, *options, driver="llvmpipe", fault=0, program=SPECTRAL, mapped=False, **environment):
        self.map_path, self.json_path = path_of("map.tif"), path_of("report.json")
        remove(self.map_path, self.json_path)
        options = [*options, "--json", self.json_path, *(["--check-map", self.map_path] if mapped else [])]
        if "-o" not in options:
            options += ["-o", "/dev/null"]
        environment = {**os.environ, "GALLIUM_DRIVER": driver, **environment}
        if fault:
            environment |= {"FAULT": str(fault), "LD_PRELOAD": FAULTS}
        done_run = run("render", scene, *options, program=program, env=environment)
        self.status, self.table, self.says = done_run.returncode, done_run.stdout, done_run.stderr
        self.report = json.load(open(self.json_path)) if os.path.exists(self.json_path) else None
        self.map = read_map(self.map_path) if mapped and os.path.exists(self.map_path) else None

    @property
    def verdict(self):
        return self.report["verdict"] if self.report else None

    def __str__(self):
        return f"exit {self.status}: {self.table}{self.says}"


def read_map(path):
    with tifffile.TiffFile(path) as tiff:
        return {page.tags["PageName"].value: page.asarray() for page in tiff.pages}


# ---- little can be checked ----

def check_hollow():
    for driver in DRIVERS:
        for name, words in (("from-above", r"on ground ("), ("edge-on", "edge-on"), ("nearly-grazing", "light")):
            scene = f"{CASES}{name}.scene"
            plain = Render(scene, driver=driver)
            check(plain.status == 1 and plain.verdict == "not verified" and f"{scene}:" in plain.says and
                  words in plain.says and plain.says.count("\n") == 1,
                  f"{driver}: {name} is not verified; the message names the object and the cause", plain)
            loose = Render(scene, "--unchecked", "1", driver=driver)
            check(loose.status == 0 and loose.verdict == "agreed",
                  f"{driver}: {name} agrees if all of it may stay unchecked", loose)
            black = Render(scene, driver=driver, fault=77)
            expected = "not verified" if name == "edge-on" else "differs"
            check(black.status == 1 and black.verdict == expected,
                  f"{driver}: with fault 77, a black band, {name} is {expected}", black)
    for name, what in (("noise", "diffuse reflection"), ("noise-highlight", "a highlight")):
        noise = Render(f"{CASES}{name}.scene")
        check(noise.status == 2 and f"{name}.scene:5 grazes this object" in noise.says and
              f"{name}.scene:7:" in noise.says,
              f"a full scale of {what} that is rounding noise is refused, with the light and the object", noise)
    chosen = Render(f"{CASES}noise.scene", "--full-scale", "1")
    check(chosen.status == 0 and chosen.verdict == "agreed", "with a full scale of its own the scene is black", chosen)
    endless = Render("patches", program=ENDLESS)
    check(endless.status == 1 and endless.verdict == "not verified",
          "fault 79: with infinite bounds for one object the picture is not verified", endless)


# ---- backs that solids hide ----

def check_backs():
    scene = f"{CASES}open.scene"
    for driver in DRIVERS:
        plain, hollow = Render(scene, driver=driver), Render(scene, driver=driver, program=HOLLOW)
        check(plain.status == 0 and hollow.status == 1 and hollow.verdict == "differs",
              f"{driver}: fault 84: backs that OpenGL should have drawn are missed", plain, hollow)
    stack = path_of("backs.tif")
    for scene in "colorchecker", "metals", "pasture", "room", "spheres", "textures", f"{CASES}coarse-depth.scene":
        small = SMALL if os.sep not in scene else ()
        runs = [(Render(scene, *small, "--unchecked", "1", "-o", stack, program=program), tifffile.imread(stack))
                for program in (SPECTRAL, WHOLE)]
        check(all(run.status == 0 for run, _ in runs) and np.array_equal(runs[0][1], runs[1][1]),
              f"{scene}: without the backs that solids hide, every sample is the same", *(run for run, _ in runs))


# ---- words and limits ----

def check_words():
    agreed = Render("patches", "--size", "60x40")
    check(agreed.status == 0 and agreed.verdict == "agreed" and "\nverdict           agreed: " in agreed.table,
          "table and JSON say agreed", agreed)
    strict = Render("patches", "--size", "60x40", "--strict")
    check(strict.status == 0 and strict.verdict == "agreed", "a strict check agrees where all is checked", strict)
    scene = "test/cases/hard/scale-needle.scene"
    for options, verdict in ((), "not verified"), (("--unchecked", "0.2"), "agreed"), (("--strict",), "not verified"):
        seen = Render(scene, *options)
        check(seen.verdict == verdict and seen.status == (verdict != "agreed"),
              f"12 % unchecked are {verdict} with {' '.join(options) or 'no option'}", seen)
    stack = path_of("words.tif")
    unchecked = Render("patches", "--size", "60x40", "--no-check", "-o", stack)
    info = output_of("info", stack)
    check(unchecked.verdict == "not checked" and "\nverdict           not checked\n" in unchecked.table and
          "not checked" in info and unchecked.report["check"] is None,
          "without a check, table, JSON and stack say not checked", unchecked, info)
    empty = Render(path_of("empty.scene"))
    check(empty.status == 0 and empty.verdict == "agreed" and
          empty.report["check"]["floor_median_counts"] is None,
          "figures that do not exist are null in JSON", empty)
    dark = Render("patches", "--size", "60x40", fault=68)
    check(dark.report["check"]["rms_counts"] is None, "so are those of samples that are no numbers", dark)
    for driver in DRIVERS:
        off = Render("colorchecker", "--size", "120x80", driver=driver)
        report = off.report["check"]
        check(abs(report["mean_residual_counts"]) < report["mean_residual_limit_counts"] < 0.1,
              f"{driver}: roundings leave less than a tenth of a count on average", off)


# ---- faults in samples ----

def write_ramp(n=60):
    """A slope of n x n squares of two triangles, each 4 x 4 pixels. The normals make the light grow evenly from left to right,
    so that roundings of positions may change each sample by the same small number of counts, up or down."""
    cosines = [0.2 + 0.7 * x / n for x in range(n + 1)]
    lines = [f"vn {math.sqrt(1 - c * c)!r} 0 {c!r}" for c in cosines]
    lines += [f"v {x} {y} 0" for y in range(n + 1) for x in range(n + 1)]
    for y in range(n):
        for x in range(n):
            corners = ((x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1))
            lines.append("f " + " ".join(f"{b * (n + 1) + a + 1}//{a + 1}" for a, b in corners))
    write("ramp.obj", "\n".join(lines) + "\n")
    write("ramp.scene", f"material m {{ diffuse 1 }}\nobject mesh ramp.obj material m translate {-n / 2} {-n / 2} 0\n"
          f"light e 1 direction 0 0 1\ncamera ortho {n}\nsize {4 * n} {4 * n}\nwavelengths 400 700 100\n")


def spots(render, wanted, seed, n=10):
    """Random pixels of a map that are settled and of the wanted kind, not at the border."""
    inside = np.zeros_like(wanted)
    inside[1:-1, 1:-1] = True
    y, x = np.nonzero(wanted & inside & (render.map["class"] == CHECKED))
    chosen = random.Random(seed).sample(range(len(x)), n)
    return [(int(x[i]), int(y[i])) for i in chosen]


def found_at(scene, options, driver, fault, counts, pixels):
    found = 0
    for x, y in pixels:
        seen = Render(scene, *options, driver=driver, fault=fault, FAULT_PIXEL=f"{x},{y}",
                     FAULT_COUNTS=str(counts), mapped=True)
        differs = np.argwhere(seen.map["class"] == DIFFERS).tolist()
        found += seen.status == 1 and seen.verdict == "differs" and differs == [[y, x]]
    return found


def check_samples():
    """Each fault at ten random pixels; nine must be found, and the map must show that pixel and no other. Faults of all
    samples must be found, too."""
    write_ramp()
    for driver in DRIVERS:
        for fault, scene, options, counts, what in (
                (73, "pasture", SMALL, 1, "of textured ground in perspective"),
                (74, f"{CASES}wide-floor.scene", (), 1, "of a floor that the border cuts"),
                (75, "colorchecker", SMALL, 4, "of a facet seen nearly edge-on")):
            plain = Render(scene, *options, driver=driver, mapped=True)
            floor = plain.map["floor"]
            wanted = {73: floor > 4, 74: floor >= 0, 75: floor > 4}[fault]
            pixels = spots(plain, wanted, fault)
            found = found_at(scene, options, driver, fault, counts, pixels)
            check(found >= 9, f"{driver}: fault {fault}, one sample {what} off by {counts} counts, is found",
                  f"at {found} of 10 pixels", [float(plain.map["floor in one band"][y, x]) for x, y in pixels])
        blocks = Render("textures", *SMALL, driver=driver, mapped=True)
        pixels = spots(blocks, blocks.map["floor"] > 1, 78)
        found = sum(Render("textures", *SMALL, driver=driver, fault=78, FAULT_PIXEL=f"{x},{y}").status
                    for x, y in pixels)
        check(found >= 9, f"{driver}: fault 78, two bands exchanged in 3 x 3 textured pixels, is found", f"{found} of 10")
        bright = Render(f"{CASES}wide-floor.scene", driver=driver, fault=76)
        check(bright.status == 1 and bright.verdict == "differs",
              f"{driver}: fault 76, all light times 1.0005 on a floor that the border cuts, is found", bright)
        plain, biased = (Render(path_of("ramp.scene"), driver=driver, fault=fault) for fault in (0, 80))
        check(plain.status == 0 and biased.status == 1 and biased.verdict == "differs" and
              biased.report["check"]["unexplained_pixels"] == 0 and "OpenGL is off by +0.16" in biased.table + biased.says,
              f"{driver}: fault 80, all samples too large by less than the bound of each, shows in their mean", plain, biased)


# ---- the map ----

def check_map():
    for driver in DRIVERS:
        seen = Render("textures", "--size", "240x160", driver=driver, mapped=True)
        report, pages = seen.report["check"], seen.map
        check(list(pages) == ["floor", "floor in one band", "error / bound", "class"] and
              all(page.shape == (160, 240) and page.dtype == np.float32 for page in pages.values()),
              f"{driver}: the map has four float pages with names", list(pages))
        floor, alone = pages["floor"], pages["floor in one band"]
        shown = floor >= 0
        check(shown.sum() == report["object_pixels"] and np.isclose(floor.max(), report["floor_worst_counts"]) and
              np.isclose(alone.max(), report["band_floor_worst_counts"]) and
              (floor <= 1).sum() - (~shown).sum() == report["floor_within_1"],
              f"{driver}: the floors of the map are those of the report")
        check((alone <= floor).all(), f"{driver}: no error of one band hides where one of all bands is found")
        ratio = pages["error / bound"]
        worst = max(report["worst_error_over_bound"], report["worst_band_error_over_bound"])
        check(0 <= ratio.min() and np.isclose(ratio.max(), worst, rtol=1e-5),
              f"{driver}: so is the worst error / bound", ratio.max(), worst)
        kinds = pages["class"]
        check((kinds == AMBIGUOUS).sum() == report["ambiguous_pixels"] - (~shown & (kinds == NOT_CHECKED)).sum() and
              set(np.unique(kinds)) <= {CHECKED, AMBIGUOUS, NOT_CHECKED},
              f"{driver}: its classes are those of the report")
    wide = Render("patches", "--size", "40x9000", mapped=True)
    check(wide.map["floor"].shape == (9000, 40), "a picture of several tiles has one map", wide)
    failed = Render("patches", fault=43, mapped=True)
    check(failed.status == 1 and (failed.map["class"] == DIFFERS).sum() == 1 == failed.report["check"]["unexplained_pixels"],
          "the map of a picture that differs is written, and shows where")
    coloured_map()


def read_colours(*command, **options):
    """The two halves of a map as PNG: a number for each pixel's colour."""
    path = path_of("map.png")
    subprocess.run([SPECTRAL, "render", *command, "-o", "/dev/null", "--quiet", "--check-map", path], check=False,
                   stderr=subprocess.DEVNULL, **options)
    image = np.asarray(Image.open(path)).astype(int)
    return np.split(image[..., 0] << 16 | image[..., 1] << 8 | image[..., 2], 2, axis=1)


def coloured_map():
    """A PNG shows both floors. Each power of two has a colour; background and pixels that differ have others."""
    scenes = (("textures", "--size", "240x160"), ("pasture", "--size", "300x200"), ("patches", "--size", "40x9000"))
    for words in scenes:
        pages, colours = Render(*words, mapped=True).map, read_colours(*words)
        pairs = set()
        for floor, seen in zip((pages["floor"], pages["floor in one band"]), colours):
            step = np.where(floor < 0, BACKGROUND, np.clip(np.ceil(np.log2(np.maximum(floor, 1 / 16))), -4, 9))
            pairs |= set(zip(step.ravel(), seen.ravel()))
        check(len(pairs) == len({step for step, _ in pairs}) == len({colour for _, colour in pairs}) >= 3 and
              all((step == BACKGROUND) == (colour == 0) for step, colour in pairs),
              f"{words[0]}: each power of two has a colour of its own in both halves of the PNG", sorted(pairs))
    wrong = Render("patches", fault=43, mapped=True).map["class"] == DIFFERS
    environment = {**os.environ, "GALLIUM_DRIVER": "llvmpipe", "FAULT": "43", "LD_PRELOAD": FAULTS}
    for seen in read_colours("patches", env=environment):
        check(((seen[:len(wrong)] == 0xff00ff) == wrong).all() and wrong.sum() == 1, "the pixel that differs is magenta in the PNG")


def main():
    write("empty.scene", "wavelengths 400 700 100\nsize 8 8\ncamera ortho 4\nlight d65 1 direction 0 0 1\n"
          "material m { diffuse 0.5 }\nobject plane 1 1 material m translate 100 0 0\n")
    parts(check_hollow, check_backs, check_words, check_samples, check_map)
    done()


main()
