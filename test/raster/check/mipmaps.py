#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first release; packages: python3-numpy python3-tifffile libosmesa6-dev; makes: faults full_mutants
"""Tests mipmaps: levels against averages, the reference against a second implementation, planted faults, drivers with other rules for
the level of detail, invariances, and random scenes. Faults 96 to 100 are those of faults.md; spectral-detail is the program with
another rule. Prints TAP.

    test/raster/check/mipmaps.py                      3 random scenes by each way of OSMesa; with FULL=1 60 (SOAK=1, `test release`: 1000) by all ways, other rules and
                                                      families of drivers"""
import os
import random
import re
import shutil

import numpy as np
import tifffile

from rendered import FAULTS, SPECTRAL, amount, check, done, judged, parts, output_of, pages_of, path_of, run, stack_of, write, write_stack

SCENE = "test/cases/faults/mipmaps.scene"
MUTANT = os.path.join(os.path.dirname(SPECTRAL), "test/spectral-detail")
WAYS = "llvmpipe", "softpipe", "gl-shader", "es-shader", "gl-shader:softpipe", "es-shader:softpipe"
FULL = "FULL" in os.environ
COUNT = amount(3, 60, 1000)


def write_texture(name, texels):
    tifffile.imwrite(path_of(name), np.asarray(texels, "f4"))
    return name


# ---- levels, and the reference ----

def exported(scene, folder):
    """The texels of a scene's first texture, level by level, as export writes them."""
    shutil.rmtree(path_of(folder), ignore_errors=True)
    output_of("export", scene, "-o", path_of(folder))
    return np.fromfile(os.path.join(path_of(folder), "texture-0.bin"), "f4")


def averaged(texels):
    """All levels of a texture [y upwards, x], each texel the average of the part of level 0 that it covers."""
    def shares(n, m):
        """[coarse, fine]: the part of each fine texel that lies in a coarse one."""
        edges = np.arange(m + 1) * n / m
        fine = np.arange(n)
        parts = np.minimum(fine + 1, edges[1:, None]) - np.maximum(fine, edges[:-1, None])
        return np.maximum(0, parts) * m / n
    levels, (height, width) = [texels], texels.shape
    while height > 1 or width > 1:
        height, width = max(1, height // 2), max(1, width // 2)
        levels.append(shares(texels.shape[0], height) @ texels @ shares(texels.shape[1], width).T)
    return levels


def levels():
    dice = np.random.default_rng(1)
    for height, width in (64, 64), (50, 37), (3, 7), (5, 1), (1, 6), (16, 128):
        texels = dice.random((height, width)).astype("f4")
        write_texture("levels.tif", texels)
        scene = write("levels.scene", "material m { diffuse 1 texture levels.tif linear }\nlight 1 1 direction 0 0 1\n"
                                      "object plane 1 1 material m repeat 5 5\n")
        found = exported(scene, "levels")
        expected = np.concatenate([level.ravel() for level in averaged(texels[::-1].astype(float))])
        check(found.size == expected.size and np.allclose(found, expected, rtol=6e-8, atol=0),
              f"{width} x {height} texels: each level holds averages of the first", found.size, expected.size)


def filtered(levels_of, s, t, detail):
    """Trilinear filtering (sections 3.8.8 and 3.8.9 of the specification)."""
    def bilinear(level):
        height, width = level.shape
        x, y = s * width - 0.5, t * height - 0.5
        left, low = np.floor(x).astype(int), np.floor(y).astype(int)
        u, v = x - left, y - low
        corner = [[level[(low + j) % height, (left + i) % width] for i in (0, 1)] for j in (0, 1)]
        return (corner[0][0] * (1 - u) + corner[0][1] * u) * (1 - v) + (corner[1][0] * (1 - u) + corner[1][1] * u) * v
    values = np.array([bilinear(level) for level in levels_of])
    whole = np.minimum(np.floor(detail).astype(int), len(levels_of) - 1)
    pick = np.indices(detail.shape)
    fine, coarse = values[(whole, *pick)], values[(np.minimum(whole + 1, len(levels_of) - 1), *pick)]
    return fine + (coarse - fine) * (detail - whole)


def reference():
    """A wall seen at an angle, in closed form: rays, their derivatives from pixel to pixel, and textures of several sizes."""
    dice = np.random.default_rng(2)
    width, height, far, turn = 90, 60, 9, np.radians(70)
    for shape in (64, 64), (30, 100):
        texels = dice.random(shape).astype("f4")
        write_texture("wall.tif", texels)
        scene = write("wall.scene", f"""wavelengths list 500
size {width} {height}
camera perspective 60 near 0.5 far 90 eye 0 0 {far} look 0 0 0
ambient 1 1
material wall {{ diffuse 1 texture wall.tif linear }}
object plane 40 40 material wall repeat 12 7 rotate 70 0 1 0
""")
        stack = path_of("wall.tif-stack")
        output_of("render", scene, "--renderer", "raster", "--no-check", "--quiet", "--full-scale", "1", "--depth", "32f", "-o", stack)
        y, x = np.mgrid[0:height, 0:width] + 0.5
        scale = np.tan(np.radians(30)) / (height / 2)
        rays = (x - width / 2) * scale, (height / 2 - y) * scale

        def place(p, q):
            """The wall is (a cos, b, -a sin), the ray (0, 0, far) + (p, q, -1) d: a cos = p d, -a sin = far - d."""
            d = far / (1 - p * np.tan(turn))
            return p * d / np.cos(turn) / 40 * 12 + 6, q * d / 40 * 7 + 3.5
        s, t = place(*rays)
        step = 1e-6
        slopes = [[(after - before) / (2 * step) * scale for after, before in
                   zip(place(rays[0] + step * (i == 0), rays[1] + step * (i == 1)), place(rays[0] - step * (i == 0), rays[1] - step * (i == 1)))]
                  for i in (0, 1)]
        rho = np.maximum(*[np.hypot(ds * shape[1], dt * shape[0]) for ds, dt in slopes])
        detail = np.clip(np.log2(rho), 0, np.log2(max(shape)) // 1)
        seen = pages_of(stack)[0]
        inside = (np.abs(s - 6) < 5.9) & (np.abs(t - 3.5) < 3.4) & (rays[0] * np.tan(turn) < 0.9)
        expected = filtered(averaged(texels[::-1].astype(float)), s, t, detail)
        off = np.abs(seen - expected)[inside]
        check(inside.mean() > 0.2 and detail[inside].max() > 2 and off.max() < 3e-6,
              f"{shape[1]} x {shape[0]} texels: the reference is a wall in closed form", off.max(), inside.mean())


def filters():
    """One file under three filters in one scene: each object has what it has alone, and they differ."""
    write_texture("filtered.tif", np.random.default_rng(4).random((16, 16)).astype("f4"))
    names = "nearest", "bilinear", "linear"

    def drawn(*wanted):
        scene = write("filters.scene", "size 60 20\nwavelengths list 500\ncamera ortho 6\nambient 1 1\n" + "".join(
            f"material {name} {{ diffuse 1 texture filtered.tif {name} }}\nobject plane 2 2 material {name} repeat 3.3 3.3 "
            f"translate {2 * names.index(name) - 2} 0 0\n" for name in wanted))
        output_of("render", scene, "--quiet", "--full-scale", "1", "--unchecked", "1", "-o", path_of("filters.tif"))
        return pages_of(path_of("filters.tif"))[0]
    together, alone = drawn(*names), [drawn(name) for name in names]
    check(np.array_equal(together, sum(alone)) and min(picture.max() for picture in alone) > 0,
          "three materials with one file have their own filters")
    columns = [together[:, 20 * i:20 * i + 20] for i in range(3)]
    check(all(np.abs(columns[i] - columns[k]).max() > 1000 for i, k in ((0, 1), (1, 2), (0, 2))), "which show other numbers")


def aliasing():
    """The root mean square of the error beside many samples a pixel without mipmaps, in parts of the largest value."""
    plain = write("bilinear.scene", open(SCENE).read().replace(" linear ", " bilinear "))

    def drawn(scene, samples):
        output_of("render", scene, "--renderer", "raster", "--no-check", "--quiet", "--full-scale", "2", "--samples", samples,
                  "--wavelengths", "500,600", "-o", path_of("aliased.tif"))
        return pages_of(path_of("aliased.tif"))
    truth = drawn(plain, "16")
    rms = {(scene, samples): np.sqrt(np.mean((drawn(scene, samples) - truth)[truth > 0] ** 2)) / truth.max()
           for scene in (plain, SCENE) for samples in ("1", "4")}
    check(rms[SCENE, "1"] < 0.5 * rms[plain, "1"] and rms[SCENE, "4"] < 0.5 * rms[SCENE, "1"],
          "mipmaps alias less than half as much, and samples add to that", rms)
    print("# bilinear, with 4 x 4 samples, linear, with 4 x 4 samples:", *(f"{value:.2g}" for value in rms.values()))


# ---- planted faults ----

def faults():
    for driver in WAYS[:2]:
        for number in 0, 96, 97, 98, 99:
            status, found, message = judged(SCENE, GALLIUM_DRIVER=driver, LD_PRELOAD=FAULTS, FAULT=str(number))
            if number == 0:
                check(status == 0 and found["effects"]["mipmaps"] and found["check"]["unchecked_pixels"] < 100,
                      f"{driver}: mipmaps agree, nearly all pixels checked", message, found and found["check"])
            else:
                check(status == 1 and re.search(r"first at \d+,\d+ on \w+ ", message),
                      f"{driver}: planted fault {number} is found, with its pixel", message)
        for rule in ("CORNER", "NORM", *(["EXACT"] if driver == "llvmpipe" else [])) if FULL else ():
            status, _, message = judged(SCENE, program=MUTANT, GALLIUM_DRIVER=driver, **{rule: "1"})
            check(status == 1 and re.search(r"first at \d+,\d+ on \w+ ", message), f"{driver}: another rule ({rule}) is found", message)
        if FULL:
            status, _, message = judged(SCENE, program=MUTANT, GALLIUM_DRIVER=driver)
            check(status == 0, f"{driver}: the mutant with the driver's own rule agrees", message)


def families():
    """Drivers that are not known are measured: one that follows a rule of Mesa's is recognised; another one may show whatever the
    specification allows; one that changes is refused."""
    unknown = {"LD_PRELOAD": FAULTS, "FAULT": "83"}
    for name in WAYS[:2]:
        said = run("drivers", "-v", GALLIUM_DRIVER=name, **unknown).stdout
        check(re.search(rf"level of detail +as {name} ", said), f"{name}: its rule is known without its name", said)
        status, found, message = judged(SCENE, GALLIUM_DRIVER=name, **unknown)
        check(status == 0 and found["driver_profile"] == "measured" and found["check"]["unchecked_pixels"] < (20 if name == "llvmpipe" else 100),
              f"{name}: agrees where it is not known", message, found and found["check"])
    for option in "rho_approx", "brilinear":
        said = run("drivers", "-v", GALLIVM_PERF=option, **unknown).stdout
        check("levels of detail as specified" in said and "neither as llvmpipe nor softpipe" in said,
              f"{option}: a rule that is none of these is said to be as wide as specified", said)
        status, found, _ = judged(SCENE, GALLIVM_PERF=option, **unknown)
        check(status == 1 and found["check"]["unchecked_pixels"] > 100, f"{option}: there most pixels cannot be checked", found and found["check"])
    status, _, message = judged(SCENE, LD_PRELOAD=FAULTS, FAULT="100")
    check(status == 3 and "it draws its targets twice, and the pictures differ" in message, "a driver that changes from drawing to drawing is refused", message)


# ---- invariances ----

def invariances():
    defined = stack_of(SCENE, "--renderer", "raster", "--no-check")
    for options in ("--gl", "osmesa"), ("--gl", "egl"), ("--threads", "1"), ("--threads", "5"):
        check(np.array_equal(defined, stack_of(SCENE, "--renderer", "raster", *options)),
              f"the stored reference does not depend on the driver that checks it ({' '.join(options)})")
    stored = {way: stack_of(SCENE, "--renderer", way) for way in ("llvmpipe", "softpipe", "raster")}
    check(not np.array_equal(stored["llvmpipe"], stored["softpipe"]), "drivers choose levels of detail by rules of their own")
    for way, name in ("llvmpipe", "llvmpipe"), ("softpipe", "softpipe"), ("raster", "specification"):
        run("render", SCENE, "-o", path_of("stack.tif"), "--quiet", "--renderer", way)
        said = output_of("info", path_of("stack.tif"))
        check(re.search(rf"^mipmaps +{name}$", said, re.MULTILINE), f"the record of {way} says whose levels these are", said)
    for size in "160x100", "161x99":
        for gl in "osmesa", "egl":
            check(judged(SCENE, "--size", size, "--gl", gl)[0] == 0, f"{size} pixels agree by {gl}")
    # several tiles in each direction
    tall = "--size", "1601x1203", "--wavelengths", "500,600"
    parts = [path_of(f"{i}.tif") for i in (1, 2, 3)]
    for way in "llvmpipe", "softpipe":
        for i, part in enumerate(parts):
            run("render", SCENE, *tall, "--renderer", way, "--part", f"{i + 1}/3", "-o", part, "--quiet", "--keep")
        whole, joined = path_of("whole.tif"), path_of("joined.tif")
        run("render", SCENE, *tall, "--renderer", way, "-o", whole, "--quiet", "--keep")
        result = run("join", "--keep", "-o", joined, *parts)
        check(result.returncode < 2 and open(whole, "rb").read() == open(joined, "rb").read(), f"{way}: parts make the bytes of the whole",
              result.stderr)
    text = open(SCENE).read()
    plain = write("bilinear.scene", text.replace(" linear ", " bilinear "))
    status, found, _ = judged(plain)
    check(status < 2 and not found["effects"]["mipmaps"], "bilinear has no mipmaps", found and found["effects"])
    check("no texture is linear" in output_of("plan", plain), "plan says so")


# ---- random scenes ----

def random_mesh(dice, name):
    """Triangles of any size and slope, with coordinates that repeat 0.01 to 400 times."""
    lines, n = [], dice.choice((1, 2, 6, 40))
    for i in range(n):
        size, repeats = 10 ** dice.uniform(-0.7, 1.2), 10 ** dice.uniform(-2, 2.6)
        middle = [dice.uniform(-6, 6), dice.uniform(-4, 4), dice.uniform(-30, 6)]
        for _ in range(3):
            lines.append("v " + " ".join(f"{m + dice.uniform(-size, size):.5g}" for m in middle))
            lines.append(f"vt {dice.uniform(-repeats, repeats):.5g} {dice.uniform(-repeats, repeats):.5g}")
        lines.append("f " + " ".join(f"{k}/{k}" for k in range(3 * i + 1, 3 * i + 4)))
    return write(name, "\n".join(lines) + "\n")


def random_scene(seed):
    dice = random.Random(seed)
    lines = [f"size {dice.randint(20, 90)} {dice.randint(20, 90)}", "wavelengths list 450 500 550 600 650 700",
             f"camera {dice.choice(('perspective 50', 'perspective 90', 'ortho 12'))} near {dice.choice((0.5, 2))} far 60 eye 0 0 10 look 0 0 0",
             "ambient 1 0.5", "light d65 1 direction 1 1 2"]
    for i in range(dice.randint(1, 4)):
        texture = dice.choice([f"texture {name}" for name in GREY] + [f"spectral-texture {name}" for name in STACKS])
        lines.append(f"material m{i} {{ diffuse {dice.uniform(0.2, 1):.2g} {texture} linear }}")
        name = f"random-{seed}-{i}.obj"
        random_mesh(dice, name)
        shape = dice.choice((f"mesh {name}", f"mesh {name}", "sphere 2 20 16", "plane 40 40", "teapot 2"))
        repeat = "" if "mesh" in shape else f"repeat {10 ** dice.uniform(-0.3, 2):.3g} {10 ** dice.uniform(-0.3, 2):.3g} "
        lines.append(f"object {shape} material m{i} {dice.choice(('', 'two-sided '))}{repeat}scale {dice.choice((1, 1, -1, 0.3))} 1 1 rotate {dice.uniform(-180, 180):.4g} "
                     f"{dice.uniform(-1, 1):.2g} 1 0.2 translate {dice.uniform(-3, 3):.3g} {dice.uniform(-3, 3):.3g} {dice.uniform(-20, 3):.3g}")
    return write(f"random-{seed}.scene", "\n".join(lines) + "\n")


GREY, STACKS = [], []


def write_textures():
    dice = np.random.default_rng(3)
    for i, shape in enumerate(((64, 64), (1, 7), (50, 37), (16, 128), (2, 2), (100, 75))):
        GREY.append(write_texture(f"grey-{i}.tif", dice.random(shape)))
    for i, shape in enumerate(((32, 32), (20, 31))):
        write_stack(f"stack-{i}.tif", dice.random((4, *shape)).astype("f4"), [400, 500, 600, 700])
        STACKS.append(f"stack-{i}.tif")
    yy, xx = np.mgrid[0:64, 0:64] // 8
    GREY.append(write_texture("squares.tif", np.where((xx + yy) % 2, 0.9, 0.1)))


def random_scenes():
    for way in WAYS if FULL else WAYS[:2]:
        differ, unverified, objects, unchecked, worst = [], 0, 0, 0, 0.0
        for seed in range(1, COUNT + 1):
            status, found, message = judged(random_scene(seed), "--renderer", way)
            if status > 1 or (status == 1 and not re.search("^error: not verified", message)):
                differ.append((seed, message))
                continue
            unverified += status
            objects += found["check"]["object_pixels"]
            unchecked += found["check"]["unchecked_pixels"]
            worst = max(worst, found["check"]["worst_error_over_bound"] or 0)
        check(not differ, f"{way}: no pixel of {COUNT} random scenes differs", *differ[:3])
        print(f"# {way}: {objects} object pixels, {unchecked} not checked, {unverified} scenes not verified, error / bound at most {worst:.3g}")


write_textures()
parts(levels, reference, filters, *([aliasing] if FULL else []), faults, *([families, invariances] if FULL else []), random_scenes)
done()
