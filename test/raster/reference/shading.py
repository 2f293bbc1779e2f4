#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile libosmesa6-dev; makes: faults
"""Compares shading by triangle, vertex and pixel with closed forms and with each other; checks tessellation, and the
rounding of OpenGL's colour buffers and of pages. Prints TAP."""
import os

import numpy as np
import tifffile

import rendered
from rendered import FAULTS, SCENES, check, done, parts, output_of, path_of, refuses, write

NINE_LIGHTS = "".join(f"light 1 0.1 position {x} 3 8\n" for x in range(-4, 5))
ONE = "wavelengths 500 500 1\nmaterial matt { diffuse 1 }\n"


def run(scene, *options, **environment):
    return rendered.run("render", scene, "--quiet", *options, env={**os.environ, **environment})


class Picture:
    """Samples [page, y, x] as stored, and the report; a scene is a built-in name or lines of text."""

    def __init__(self, scene, *options):
        self.report = rendered.render(scene, *options)
        self.full_scale = self.report["full_scale"]
        with tifffile.TiffFile(path_of("stack.tif")) as tiff:
            n_pages = len(self.report["wavelengths_nm"])
            self.samples = np.array([page.asarray() for page in tiff.pages[:n_pages]])

    def agreed(self):
        return self.report["check"]["unexplained_pixels"] == 0 and self.report["check"]["samples"] > 0


def reference(scene, shading, *options):
    """Radiances of the reference, of one page."""
    return Picture(scene, "--renderer", "raster", "--depth", "32f", "--shading", shading, *options)


def rms(values):
    return np.sqrt(np.mean(np.square(values)))


def pixels(size, extent):
    x = ((np.arange(size) + 0.5) / size - 0.5) * extent
    return np.meshgrid(x, -x)


def falls(errors, order):
    """Returns whether errors at factors 1, 2 and 4 fall with this order."""
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    return bool(np.all((ratios > 0.8 * 2 ** order) & (ratios < 1.25 * 2 ** order)))


# ---- against closed forms ----

def sphere():
    """A sphere's normal at a pixel is its position there; the light is in front of every pixel's point."""
    scene = "size 120 120\ncamera ortho 2\nlight 1 1 direction 0.3 0.2 1\n" + ONE + "object sphere 1 24 12 material matt\n"
    x, y = pixels(120, 2)
    inside = np.hypot(x, y) < 0.7
    light = np.array([0.3, 0.2, 1]) / np.sqrt(1.13)
    truth = (light[0] * x + light[1] * y)[inside] + light[2] * np.sqrt(1 - (x * x + y * y)[inside])
    errors = [rms(reference(scene, "phong", "--tessellation", factor).samples[0][inside] - truth)
              for factor in ("1", "2", "4")]
    check(falls(errors, 2), "phong: a sphere comes near N.L with the second order of its tessellation", errors)
    fine = reference(scene, "phong", "--tessellation", "20").samples[0]
    error = np.abs(fine[inside] - truth).max()
    check(error < 1e-4, "phong: a finely tessellated sphere is N.L at each pixel", error)


def approaches(name, shape, where):
    """Compares interior pixels only, where both surfaces show a point of the same side."""
    scene = ("size 120 120\ncamera ortho 2.4\nlight 1 1 direction 0.2 -0.3 1\nambient 1 0.1\n" + ONE +
             f"object {shape} material matt\n")
    x, y = pixels(120, 2.4)
    inside = where(np.hypot(x, y))
    off = {"smooth": [], "flat": []}
    for factor in ("1", "2", "4"):
        phong = reference(scene, "phong", "--tessellation", factor).samples[0]
        for shading, errors in off.items():
            errors.append(rms((reference(scene, shading, "--tessellation", factor).samples[0] - phong)[inside]))
    check(falls(off["smooth"], 2), f"smooth shading of a {name} approaches phong with the second order", off)
    check(falls(off["flat"], 1), f"flat shading of a {name} approaches phong with the first order", off)


def planes():
    """All shadings are equal if nothing changes between vertices, with textures, too."""
    tifffile.imwrite(path_of("grey.tif"), np.arange(64, dtype=np.uint8).reshape(8, 8) * 4)
    head = ("size 60 60\ncamera perspective 40 near 1 far 20 eye 1 2 5 look 0 0 0\nambient 1 0.1\n"
            "light 1 1 direction 0.4 0.2 1\nlight 1 0.5 direction 0.4 0.2 -1\n" + ONE +
            "material drawn { diffuse 0.8 texture grey.tif linear }\n")
    phong, smooth = (reference(head + "object box 1 2 1.5 material drawn rotate 30 1 0 0\n", shading) for shading in ("phong", "smooth"))
    off = np.abs(phong.samples - smooth.samples).max()
    check(off <= 1e-6 and smooth.samples.max() > 0.3, "phong of a textured box under a light at infinity equals smooth shading", off)
    seen = int(np.count_nonzero(smooth.samples))
    check(phong.report["work"]["points_lit"] >= seen > 500 and phong.report["work"]["vertices_lit"] == 0,
          "phong lights one point a pixel, and no vertices", phong.report["work"], seen)
    check(smooth.report["work"]["points_lit"] == 0, "smooth shading lights no points")


# ---- the largest radiance of phong ----

def full_scale():
    scene = "size 61 61\ncamera ortho 4\n" + ONE + "object plane 8 8 material matt\n"
    pixel = 4 / 61
    near = scene + f"light 1 1 position {8 * pixel} {3 * pixel} 0.5 attenuation 0 0 1\n"
    lit = reference(near, "phong")
    check(0.999 * lit.full_scale < lit.samples.max() <= lit.full_scale * (1 + 1e-6) and abs(lit.full_scale - 4) < 1e-9,
          "full scale is the largest radiance of a square, at the foot of a light that weakens with distance",
          lit.full_scale, lit.samples.max())
    for where, squared in (("5 4.5 1", 2.25), ("5 0.3 1", 2)):
        beside = reference(scene + f"light 1 1 position {where} attenuation 0 0 1\n", "phong")
        check(abs(beside.full_scale * squared - 1) < 1e-9,
              f"for a light beside the square, at {where}, the largest radiance is at the edge", beside.full_scale)
    both = reference(scene + "light 1 1 direction 0 0 1\nlight 1 3 direction 0 0 1\n", "phong")
    check(abs(both.full_scale - 4) < 1e-9 and abs(both.samples.max() - 4) < 1e-6,
          "the lights add up in the full scale", both.full_scale)
    away = scene.replace("material matt\n", "material matt translate 0 0 -1\n")
    for light, radiance in (("attenuation 0 0 1", 2.0 ** 60), ("spot 0 0 -1 40 2", 1)):
        above = reference(away + f"light 1 1 position 0 0 {2.0 ** -30 - 1!r} {light}\n", "phong", "--full-scale", "1e20").samples.max()
        check(abs(above / radiance - 1) < 1e-5, f"a light too near for OpenGL lights the surface: {light}", above)
    touching = write("touching.scene", scene + "light 1 1 position 0.1 0.1 0 attenuation 0 0 1\n")
    phong = ("--shading", "phong", "--renderer", "raster", "-o", "/dev/null")
    refuses("a light without limit on a surface", "touching.scene:6.*--full-scale", "render", touching, *phong)
    check(run(touching, *phong, "--full-scale", "100").returncode == 0,
          "a light without limit on a surface is accepted with --full-scale")
    for name in SCENES:
        picture = Picture(name, "--size", "150x100", "--shading", "phong", "--renderer", "raster")
        check(picture.report["clipped_samples"] == 0 and picture.report["check"] is picture.report["buffer_bits"] is None and
              picture.samples.max() > 0,
              f"phong of {name}: no sample is above full scale, and none is checked", picture.report["clipped_samples"])
    stack = path_of("stack.tif")
    table, info = output_of("render", "patches", *phong[:4], "-o", stack), output_of("info", stack)
    check("not checked: OpenGL has no phong shading" in table and "not checked: OpenGL has no phong" in info,
          "the table and the stack say that nothing was checked, and why", table, info)


# ---- tessellation ----

def tessellation():
    head = "size 60 40\ncamera ortho 3\nlight 1 1 direction 1 1 1\n" + ONE

    def of(shape, *options):
        return Picture(head + f"object {shape} material matt\n", *options)

    for shape in ("sphere 1 20 10", "torus 0.3 0.8 12 24", "teapot 1 4"):
        plain, one = of(shape), of(shape, "--tessellation", "1")
        check(np.array_equal(plain.samples, one.samples) and plain.samples.max() > 0, f"tessellation 1 changes no bit of a {shape.split()[0]}")
    for factor, shape, becomes in (("2", "sphere 1 20 10", "sphere 1 40 20"), ("0.5", "cone 0.8 1 15 4", "cone 0.8 1 8 2"),
                                   ("3", "teapot 1 4", "teapot 1 12"), ("1e-9", "sphere 1 20 10", "sphere 1 3 2"),
                                   ("1.26", "torus 0.3 0.8 10 30", "torus 0.3 0.8 13 38"), ("7", "box 1 2 1 2", "box 1 2 1 14"),
                                   ("0.1", "plane 1 2 3", "plane 1 2 1"), ("0.1", "cylinder 0.8 1 10 3", "cylinder 0.8 1 3 1"),
                                   ("1.04", "disk 1 12 1", "disk 1 12 1"), ("7", "mesh chair", "mesh chair")):
        scaled, written = of(shape, "--tessellation", factor), of(becomes)
        check(np.array_equal(scaled.samples, written.samples) and scaled.report["work"] == written.report["work"],
              f"tessellation {factor} of {shape} is {becomes}")
    check(of("teapot 1 9", "--tessellation", "1e9").report["work"]["vertices_lit"] == 32 * 65 ** 2 - 8,
          "counts stay within the limits of the scene language")


# ---- buffers and pages ----

def buffers():
    steps = {"8": 255, "16": 65535}
    groups = "size 60 40\ncamera ortho 3\n" + NINE_LIGHTS + ONE + "object sphere 1 30 30 material matt\n"
    even = "size 60 40\ncamera ortho 3\nlight 1 0.7 direction 0 0 1\n" + ONE + "object plane 8 8 material matt\n"
    for driver in ("llvmpipe", "softpipe"):
        for bits in steps:
            check(not Picture(even, "--renderer", driver, "--buffer", bits, "--full-scale", "1").report["check"]["biased"],
                  f"{driver}: {bits} bits are not called biased although they round a plain surface in one direction")
        # a pass of its own for each light with shadows
        for name, scene, passes in (("nine lights", groups, 2), ("spheres", "spheres", 3), ("room", "room", 5), ("textures", "textures", 1)):
            options = ("--renderer", driver) + (() if "\n" in scene else ("--size", "60x40", "--wavelengths", "400:700:25"))
            floats = Picture(scene, *options, "--depth", "32f")
            check(floats.agreed() and floats.report["buffer_bits"] == 32, f"{driver}, {name}: a buffer of floats agrees")
            for bits, most in steps.items():
                picture = Picture(scene, *options, "--depth", "32f", "--buffer", bits)
                off = np.abs(picture.samples - floats.samples).max() / picture.full_scale
                bound = passes * (0.5 / most + 2 ** -22)  # four roundings in single precision
                check(picture.agreed() and picture.report["clipped_samples"] == 0 and 0.9 * 0.5 / most < off <= bound,
                      f"{driver}, {name}: a buffer of {bits} bits agrees; its error is at most half a step a pass",
                      f"off by {off * most} steps")


def faults():
    """Faults planted between the program and OpenGL, by their numbers in test/raster/check/faults.md."""
    large = ("1 patches", "3 patches", "5 patches", "11 patches", "15 patches", "24 glossy", "38 patches", "42 patches",
             "48 patches", "58 groups", "62 textures", "69 patches", "70 patches")
    small = ("34 patches", "37 patches", "43 patches", "47 patches", "58 groups", "62 textures")
    for bits, planted in (("8", large), ("16", small)):
        for fault in planted:
            number, scene = fault.split()
            found = run(f"test/cases/faults/{scene}.scene", "--buffer", bits, "-o", "/dev/null", FAULT=number, LD_PRELOAD=FAULTS)
            check(found.returncode == 1 and "the pictures differ" in found.stderr,
                  f"a buffer of {bits} bits: fault {number} is found in {scene}", found.stderr)
        for scene in ("patches", "glossy", "groups", "textures"):
            none = run(f"test/cases/faults/{scene}.scene", "--buffer", bits, "-o", "/dev/null", FAULT="0", LD_PRELOAD=FAULTS)
            check(none.returncode == 0, f"without a fault the same buffer agrees: {scene}", none.stderr)


def clipping():
    scene = "size 60 40\ncamera ortho 3\nlight 1 1 direction 0 0 1\n" + ONE + "object sphere 1 30 30 material matt\n"
    for name, text in (("one pass", scene), ("two passes", scene.replace("light 1 1 direction 0 0 1\n", NINE_LIGHTS))):
        for bits in ("8", "16"):
            dark = Picture(text, "--buffer", bits, "--full-scale", "0.3", "--unchecked", "1")
            expected = reference(text, "smooth").samples > 0.3
            check(dark.agreed() and abs(dark.report["clipped_samples"] - expected.sum()) < 0.05 * expected.sum(),
                  f"{bits} bits, {name}: samples clipped at full scale agree, and are counted",
                  dark.report["clipped_samples"], expected.sum())
            bright = Picture(text, "--buffer", bits, "--full-scale", "1")
            check(bright.agreed() and bright.report["clipped_samples"] == 0,
                  f"{bits} bits, {name}: no sample is clipped below full scale")


def pages():
    for name in ("spheres", "colorchecker"):
        for renderer in ("gl", "raster"):
            options = ("--size", "120x80", "--wavelengths", "400:700:20", "--renderer", renderer)
            floats, bytes_ = Picture(name, *options, "--depth", "32f"), Picture(name, *options, "--depth", "8")
            off = np.abs(bytes_.samples / 255 - floats.samples / floats.full_scale).max() * 255
            check(bytes_.samples.dtype == np.uint8 and bytes_.samples.max() > 200 and off <= 0.5 + 1e-4,
                  f"{renderer}, {name}: pages of 8 bits are within half a count of floats", off)
    floats = Picture("spheres", "--size", "120x80", "--depth", "32f")
    half = Picture("spheres", "--size", "120x80", "--depth", "8", "--full-scale", str(floats.full_scale / 2))
    expected = np.count_nonzero(floats.samples / floats.full_scale * 2 >= 255.5 / 255)
    check(half.report["clipped_samples"] == expected > 0 and half.samples.max() == 255,
          "samples above a page's 8 bits are counted, and stored as 255", half.report["clipped_samples"], expected)
    many = "size 120 120\ncamera ortho 20\nlight 1 1 direction 0 0 1\n" + ONE + "".join(
        f"object plane 1 1 material matt translate {x - 9} {y - 8} 0\n" for x in range(19) for y in range(17))
    check(Picture(many, "--depth", "8").agreed(), "an object map of more than 255 objects lies beside pages of 8 bits")


sphere()
approaches("sphere", "sphere 1 24 12", lambda r: r < 0.7)
approaches("torus", "torus 0.3 0.8 24 48", lambda r: np.abs(r - 0.8) < 0.2)
parts(planes, full_scale, tessellation, buffers, faults, clipping, pages)
done()
