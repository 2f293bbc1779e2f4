#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first release; packages: python3-numpy python3-tifffile libosmesa6-dev; makes: faults full_mutants
"""Tests shadows: planted faults are found, shadows cost nothing where none falls into view, and parts, threads and samples do not
change them. Faults 88 to 95 and 110 to 112 are those of faults.md. MOVED_MUTANT is the program whose shadow volumes are those of lights that
are moved. Prints TAP.

    test/raster/check/shadows.py          6 random scenes for the drivers that lie; with FULL=1 60 (SOAK=1, `test release`: 300), larger pictures, and lights that move"""
import concurrent.futures
import json
import os
import random
import re

import numpy as np
import tifffile

from rendered import FAULTS, SPECTRAL, amount, bytes_of, check, done, judged, parts, path_of, run, stack_of, write

SCENE = "test/cases/faults/shadows.scene"
MUTANT = os.path.join(os.path.dirname(SPECTRAL), "test/spectral-moved")
DRIVERS = "llvmpipe", "softpipe"
TEXT = open(SCENE).read()
FULL = "FULL" in os.environ


# ---- planted faults ----

def faults():
    for driver in DRIVERS:
        for number in 0, 88, 89, 90, 92, 93, 94, 95:
            status, found, message = judged(SCENE, GALLIUM_DRIVER=driver, LD_PRELOAD=FAULTS, FAULT=str(number))
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
        status, _, _ = judged(big, program=MUTANT, MOVED=str(2.0 ** -exponent))
        if status == 1:
            least = 2.0 ** -exponent
    status, _, _ = judged(big, program=MUTANT, MOVED="0")
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
    status, first, _ = judged(plain)
    for path, what in (none, "no object casts a shadow"), (away, "shadows fall out of view"):
        _, found, _ = judged(path)
        check(status == 0 and found["work"]["gl_passes"] == first["work"]["gl_passes"] and not found["effects"]["shadows"],
              f"where {what}, OpenGL draws as many passes as without shadows", found["work"], first["work"])
    stacks = [stack_of(path, "--renderer", "raster", "--no-check") for path in (plain, none)]
    check(np.array_equal(*stacks), "and the pixels are those without shadows")
    said = run("plan", away).stdout
    check("no object throws a shadow into view" in said, "plan says so", said)


def none_of(text):
    """All objects but the sphere cast no shadow."""
    return re.sub(r"(object plane .*) material", r"\1 casts no material", text)


def mirrored():
    """The back of a mirrored sheet under a light with shadows, in several tiles: shadows leave OpenGL's state as they found it."""
    path = write("mirrored.scene", """wavelengths list 500
size 1400 900
camera ortho 12 eye 0 0 6 look 0 0 0
light 1 0.6 position 1 2 -5 shadows
light 1 0.5 direction 0 1 1
material m { diffuse 0.8 }
object plane 10 6 material m two-sided rotate 150 0 1 0 scale -1 1 1
object plane 1 1 material m two-sided scale -1 1 1 translate 0 1 -3
""")
    status, found, message = judged(path)
    check(status == 0 and found["work"]["gl_passes"] > 2, "mirrored sheets agree in several tiles", message, found and found["work"])


# ---- invariances ----

def invariances():
    raster = stack_of(SCENE, "--renderer", "raster")
    for options in ("--threads", "1"), ("--threads", "7"):
        check(np.array_equal(raster, stack_of(SCENE, "--renderer", "raster", *options)), f"the same pixels by {options}")
    gl = stack_of(SCENE).astype(int)
    check(np.mean(np.abs(gl - raster) > 1) < 0.01, "OpenGL has the reference's shadows but at few pixels")
    parts = [path_of(f"{i}.tif") for i in (1, 2)]
    tall = "--size", "2400x1600" if FULL else "1200x800"
    for i, part in enumerate(parts):
        run("render", SCENE, *tall, "--part", f"{i + 1}/2", "-o", part, "--quiet")
    whole, joined = path_of("whole.tif"), path_of("joined.tif")
    run("render", SCENE, *tall, "-o", whole, "--quiet")
    result = run("join", "-o", joined, *parts)
    check(result.returncode == 0 and bytes_of(whole) == bytes_of(joined), "parts make the bytes of the whole", result.stderr)
    for options in ("--samples", "4"), ("--shading", "flat"), ("--depth", "16"), ("--accuracy", "1"):
        status, found, message = judged(SCENE, *options)
        check(status == 0, f"shadows agree with {' '.join(options)}", message, found and found["check"])
    dark = []
    for shading in "smooth", "phong":
        words = "--shading", shading, "--renderer", "raster", "--full-scale", "2"
        plain = write("plain.scene", TEXT.replace(" shadows", ""))
        dark.append(stack_of(SCENE, *words)[0] < stack_of(plain, *words)[0])
    check(np.mean(dark[0]) > 0.05 and np.mean(dark[0] != dark[1]) < 0.005, "Phong shading has the same shadows",
          np.mean(dark[0]), np.mean(dark[0] != dark[1]))


# ---- drivers without shadows, in scenes where OpenGL could count them otherwise ----

LIES = {0: "an honest driver", 110: "one without shadows", 111: "one with shadows everywhere", 112: "one with shadows inverted"}
DOUBTFUL = 256  # counts that a checked pixel may be off


def near_surface(seed):
    """A lamp at a distance of any order of magnitude from a plate, a box or a ball; or a surface that lies in another one."""
    dice = random.Random(seed)
    away = 10 ** -dice.uniform(0, 8)
    turn = f"rotate {dice.choice((0, 90, 180, dice.uniform(0, 360))):.9g} {dice.choice(('1 0 0', '0 1 0', '1 2 3'))}"
    at = [round(dice.uniform(-1.5, 1.5), dice.choice((0, 1, 6))) for _ in range(3)]
    at[1] = abs(at[1]) + 1
    place = "{} {} {}".format(*at)
    size = dice.choice((0.2, 1, 3))
    camera = dice.choice((f"perspective 45 near {dice.choice((0.1, 1))} far {dice.choice((40, 64, 1e5))}", "ortho 9 near -20 far 40"))
    shape = dice.choice((f"plane {size} {size} {dice.choice((1, 4))} material m two-sided translate 0 0 {-away:.9g} {turn} translate {place}",
                         f"box {size} {size} {size} material m translate {size / 2 + away:.9g} 0 0 {turn} translate {place}",
                         f"sphere {size} 16 8 material m translate 0 {-size - away:.9g} 0 {turn} translate {place}"))
    lines = ["wavelengths list 450 600", "size 72 48", f"camera {camera} eye 0 4 8 look 0 0.5 0", "ambient d65 0.1",
             f"light d65 1 position {place} shadows", "material ground { diffuse 0.5 }", "material m { diffuse 0.7 }",
             f"object plane {dice.choice((12, 200))} {dice.choice((12, 200))} {dice.choice((1, 6))} material ground rotate -90 1 0 0",
             "object " + shape]
    for _ in range(dice.randint(0, 3)):
        lines.append(f"object {dice.choice(('sphere 0.6 16 8', 'box 1 0.7 0.8'))} material m translate "
                     f"{dice.uniform(-3, 3):.4g} {dice.uniform(0.3, 2):.4g} {dice.uniform(-2, 2):.4g}")
    if dice.random() < 0.3:  # a second floor in the first one
        lines.append(f"object plane 11 13 {dice.choice((1, 5))} material m rotate -90 1 0 0")
    return write(f"near-{seed}.scene", "\n".join(lines) + "\n")


def judge(path, driver, lie, reference, honest, *options):
    """Renders by a driver that lies. Returns its status, where it is wrong, what is said against it, and the report."""
    name = path_of(f"{os.path.basename(path)}-{driver}-{lie}")
    result = run("render", path, "-o", name + ".tif", "--keep", "--quiet", "--check-map", name + "-map.tif", "--json", name + ".json",
                 *options, GALLIUM_DRIVER=driver, LD_PRELOAD=FAULTS, FAULT=str(lie))
    if result.returncode > 1:
        return result.returncode, None, result.stderr
    wrong = (abs(tifffile.imread(name + ".tif").astype(int) - reference) > DOUBTFUL).any(axis=0)
    classes = tifffile.imread(name + "-map.tif", key=3)
    check_of = json.load(open(name + ".json"))["check"]
    for end in ".tif", "-map.tif", ".json":
        os.remove(name + end)
    known = wrong if honest is None else honest
    hidden = int((wrong & ~known & (classes < 2)).sum())
    fault = "differs: " + result.stderr if lie == 0 and "differ" in result.stderr else \
        f"{hidden} wrong pixels count as checked" if hidden else \
        f"{int(wrong.sum())} pixels are wrong, and agreed" if result.returncode == 0 and \
        (wrong & ~known).sum() > 0.01 * check_of["object_pixels"] + check_of["open_edge_pixels"] else None
    return result.returncode, wrong, fault


def lies_about(path, *options):
    """Returns the statuses of all drivers that lie about a scene, and what is said against them."""
    stack = path_of(os.path.basename(path) + ".tif")
    result = run("render", path, "-o", stack, "--quiet", "--renderer", "raster", "--no-check", *options)
    if result.returncode:
        return {}, [f"{path}: {result.stderr}"]
    reference = tifffile.imread(stack).astype(int)
    os.remove(stack)
    statuses, faults_found = {}, []
    for driver in DRIVERS:
        honest = None
        for lie, who in LIES.items():
            status, wrong, fault = judge(path, driver, lie, reference, honest, *options)
            statuses[driver, lie] = status
            honest = wrong if lie == 0 else honest
            if fault:
                faults_found.append(f"{os.path.basename(path)}, {driver}, {who}: {fault}")
    return statuses, faults_found


def liars():
    hard = [f"data/builtin/hard/{name}.scene" for name in ("shadow-candle", "shadow-touch", "shadow-ground", "shadow-deep", "shadow-box-open")]
    hard += [f"test/cases/hard/{name}.scene" for name in ("shadow-touch-turned", "shadow-touch-ortho", "shadow-touched", "shadow-coplanar")]
    hard.append(SCENE)
    built = ["colorchecker", "fluorescence", "metals", "metamers", "pasture", "patches", "relief", "room", "spheres", "textures"]
    small = "--size", "90x60", "--wavelengths", "450,600"
    near = [near_surface(seed) for seed in range(amount(6, 60, 300))]
    if not FULL:
        hard, built = hard[:2] + hard[-1:], built[-2:]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for what, paths, options in (("hard cases", hard, ()), ("built-in scenes", built, small),
                                     ("random scenes with a lamp at a surface", near, ())):
            found = list(pool.map(lambda path: lies_about(path, *options), paths))
            check(not any(faults_found for _, faults_found in found),
                  f"{what}: honest drivers never differ, and no pixel that a lie changes counts as checked in a picture that is agreed",
                  *[fault for _, faults_found in found for fault in faults_found][:20])
            caught = [sum(statuses.get((driver, lie)) == 1 for statuses, _ in found for driver in DRIVERS) for lie in LIES]
            print(f"# {what}: of {2 * len(paths)} pictures not agreed:", ", ".join(f"{who} {n}" for who, n in zip(LIES.values(), caught)))
    statuses = [lies_about(path)[0] for path in hard[:2]]
    check(all(status[driver, lie] == (lie > 0) for status in statuses for driver in DRIVERS for lie in LIES),
          "a lamp above a table, or at a plate: honest drivers agree, and each lie is found", statuses)


parts(faults, mirrored, liars, *([moved_lights] if FULL else []), economy, invariances)
done()
