#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Checks wavelength sampling from render to develop. The result of each method for a chart, whose radiances are
light x reflectance, is computed once more with numpy, at every nm, from the tables. Theory says how errors
fall. test_sampling.c has the spectra for which a method must be exact, tolerances, refusals and hard cases. Prints TAP."""
import glob
import json
import re

import numpy as np

from colours import cielab, ciede2000
from rendered import bail_out, built_in, check, developed, done, output_of, pages_of, path_of, run, table, weights, write

FIRST, LAST = 380, 730  # of the scene patches
NM = np.arange(FIRST, LAST + 1.0)
CHART = [np.interp(NM, *table(path)) for path in sorted(glob.glob("data/builtin/materials/colorchecker/*.txt"))]
METHODS = ["box:8", "riemann:10", "gauss:8", "gauss:8,open", "gauss:9,xyz", "gauss:9,lms", "gauss:8,acc",
           "adaptive:0.001", "basis:6", "rgb", "xyz"]
SMALL = "wavelengths 380 730 5\nsize 8 8\ncamera ortho 2\n"


# ---- sums with numpy ----

def light_of(name):
    return np.interp(NM, *built_in(name), 0, 0)


EYE, EYE_10, D65 = weights("cie1931", NM), weights("cie1964", NM), light_of("d65")


def lagrange(nodes, nm=NM):
    """[node, nm]: the polynomials that are 1 at one node and 0 at all others."""
    return np.array([np.prod([(nm - other) / (node - other) for other in nodes if other != node], 0)
                     * np.ones(len(nm)) for node in nodes])


# ---- the program ----

class Sampled:
    """A scene rendered by the reference under one sampling, into pages of floats."""

    def __init__(self, scene, sampling, *options):
        self.path = path_of("sampled.tif")
        self.result = run("render", scene, "--sampling", sampling, "--renderer", "raster", "--no-check",
                          "--quiet", "--threads", "1", "--depth", "32f", "--json", "-", "-o", self.path, *options)
        self.report = json.loads(self.result.stdout) if self.result.returncode == 0 else None

    def pages(self):
        return len(pages_of(self.path))

    def nodes(self):
        return np.array(self.report["wavelengths_nm"])

    def xyz(self, *options):
        """XYZ of the developed stack [y, x, channel]"""
        return developed(self.path, "--xyz", "--threads", "1", *options)[0]


def chart(sampling, *options, detector="cie1931"):
    """XYZ of the 24 patches, [patch, channel], and the number of pages."""
    stack = Sampled("patches", sampling, "--size", "60x40", *options)
    if stack.report is None:
        bail_out(stack.result.stderr)
    return stack.xyz("--detector", detector)[5::10, 5::10].reshape(-1, 3), stack.pages()


def is_near(seen, expected, name, magnitude=None):
    """Pages and pictures have single precision: each value, and each factor, has an error of 2^-24 of itself;
    `magnitude` is the sum of the magnitudes of a channel's terms."""
    magnitude = np.abs(expected).max() if magnitude is None else magnitude
    error = np.abs(seen - expected).max()
    check(error <= 3 * 2**-24 * magnitude, name, f"error {error} of {magnitude}")


def error(seen, expected):
    """The largest error of all channels and patches, relative to the white's Y."""
    return np.abs(seen - expected).max() / (EYE[1] @ D65)


# ---- the definition of each method ----

def exact(light):
    return np.array([EYE @ (light * r) for r in CHART])


def check_ambient():
    """Ambient light counts as a light does."""
    surface = "material m { diffuse 0.5 }\nobject plane 9 9 material m\n"
    said = [re.findall("adaptive.*", output_of("plan", write("lit.scene", f"{SMALL}{light}\n{surface}"), "--sampling", "adaptive:0.01"))
            for light in ("ambient f11 1", "light f11 1 direction 0 0 1")]
    check(said[0] == said[1] and "emission peaks" in said[0][0], "adaptive finds the peaks of ambient light", said)


def check_riemann():
    for step in 1, 5, 20:
        nm = np.arange(FIRST, LAST + 1e-9, step)
        at = np.isin(NM, nm)
        is_near(chart(f"riemann:{step}")[0],
                np.array([weights("cie1931", nm) @ (D65 * r)[at] for r in CHART]),
                f"riemann:{step} is a sum over every {step} nm")
    check(chart("riemann:5")[1] == 71, "each wavelength has a page: 71 for 350 nm by 5")


def boxes(n):
    """[box, nm]: the cells of 1 nm in each box. Boxes have equal areas under the observer's functions; a box ends
    with the cell at which the total area reaches the box's share."""
    area = np.cumsum(np.abs(EYE).sum(0))
    ends = np.append(0, np.searchsorted(area, area[-1] * np.arange(1, n + 1) / n * (1 - 1e-12)) + 1)
    number = np.arange(len(NM))
    return ((number >= ends[:-1, None]) & (number < ends[1:, None])).astype(float)


def check_box():
    for n in 1, 4, 10:
        shares = boxes(n)
        mean = shares / shares.sum(1)[:, None]
        expected = np.array([(EYE @ shares.T) @ ((mean @ D65) * (mean @ r)) for r in CHART])
        seen, pages = chart(f"box:{n}")
        is_near(seen, expected, f"box:{n}: means of light and reflectance over boxes of equal area")
        check(pages == n, f"box:{n} has {n} pages", pages)


def primaries():
    """The matrix of sRGB from its chromaticities: linear red, green and blue to XYZ."""
    white = np.array([0.3127, 0.3290, 0.3583]) * 100 / 0.3290
    columns = np.array([[0.64, 0.33, 0.03], [0.30, 0.60, 0.10], [0.15, 0.06, 0.79]]).T
    return columns * np.linalg.solve(columns, white)


def three_numbers(light, matrix, clips):
    """Products of light and reflectance as three numbers each; the reflectance's numbers are those under D65."""
    values = np.linalg.inv(matrix) @ EYE
    clip = (lambda v: v.clip(0)) if clips else (lambda v: v)
    return np.array([matrix @ (clip(values @ light) * clip(values @ (D65 * r) / (values @ D65)))
                     for r in CHART])


def check_three_numbers():
    for name in "d65", "a", "fluorescent":
        light = light_of(name)
        for method, matrix in ("rgb", primaries()), ("xyz", np.eye(3)):
            seen, pages = chart(method, "--light", f"1={name}")
            magnitude = 3 * (EYE @ light).max()  # sRGB's matrix has negative parts
            is_near(seen, three_numbers(light, matrix, method == "rgb"),
                    f"{method} under {name}: a radiance is three numbers of a light times three of a reflectance",
                    magnitude)
            check(pages == 3, "the stack has three pages")
    check(error(chart("xyz")[0], exact(D65)) < 1e-6, "under D65 itself xyz is right")
    wrong = error(chart("xyz", "--light", "1=a")[0], exact(light_of("a")))
    check(wrong > 0.01, "under illuminant A xyz is not right", wrong)


def check_basis():
    for name in "d65", "fluorescent":
        products = np.array([light_of(name) * r for r in CHART])
        components = np.linalg.svd(products, full_matrices=False)[2]
        for k in 1, 2, 4, 8, 24:
            seen = chart(f"basis:{k}", "--light", f"1={name}")[0]
            part = components[:k]
            expected = (products @ part.T) @ (EYE @ part.T).T
            magnitude = 4 * np.abs(EYE).sum(0) @ products.max(0)  # coordinates are sheared
            is_near(seen, expected, f"basis:{k} under {name}: the error is that of {k} singular vectors", magnitude)


def check_words():
    """plan describes a sampling in a line."""
    for method, words in (("riemann:50", "9 wavelengths; radiances at these wavelengths only"),
                          ("gauss:8", "8 wavelengths, 3 of 24 weights negative (-1.1 %); radiances at these wavelengths only"),
                          ("adaptive:0.1", "5 wavelengths, 1 emission peak (546 nm); radiances at these wavelengths only"),
                          ("rgb", "3 components; no spectra, and no fluorescence; for no detector but cie1931")):
        said = output_of("plan", "patches", "--light", "1=gaussian:546,4", "--wavelengths", "380:780:1", "--sampling", method)
        check(f"{method} for cie1931: {words}\n" in said, f"plan describes {method}", said)


# ---- theory of quadrature ----

def check_gauss():
    for name in "a", "d65":
        truth, light = exact(light_of(name)), f"1={name}"
        gauss = error(chart("gauss:8", "--light", light)[0], truth)
        riemann, pages = chart("riemann:50", "--light", light)
        check(pages == 8 and gauss < error(riemann, truth), f"gauss:8 beats 8 equal steps under {name}",
              gauss, error(riemann, truth))
    truth, lamp = exact(light_of("a")), ("--light", "1=a")
    errors = np.array([error(chart(f"gauss:{n}", *lamp)[0], truth) for n in (2, 4, 8, 16, 32)])
    ratios = errors[1:] / errors[:-1]
    check(ratios[0] < 0.6 and (np.diff(ratios) < 0).all(),
          "under the smooth illuminant A each doubling of N leaves a smaller part of the error than the last:"
          f" {', '.join(f'{r:.3f}' for r in ratios)}", errors)
    errors = [error(chart(f"riemann:{step}", *lamp)[0], truth) for step in (100, 50, 25)]
    check(errors[1] < errors[0] / 4 and errors[2] < errors[1] / 4,
          "half the step leaves less than a quarter of the error: riemann is of second order or better", errors)


# ---- another detector afterwards ----

def check_other_detector():
    truth = np.array([EYE_10 @ (D65 * r) for r in CHART])
    for n, method in (8, "gauss:8,open"), (12, "gauss:12"):
        stack = Sampled("patches", method, "--size", "60x40")
        nodes = stack.nodes()
        at = np.array([np.interp(nodes, *built_in("d65"))
                       * np.interp(nodes, *table(path))
                       for path in sorted(glob.glob("data/builtin/materials/colorchecker/*.txt"))])
        of = EYE_10 @ lagrange(nodes).T
        seen = stack.xyz("--detector", "cie1964")[5::10, 5::10].reshape(-1, 3)
        is_near(seen, at @ of.T, f"{method} works for another observer, by the polynomial through its {n} pages",
                np.abs(of).sum(1).max() * at.max())
    legendre = (np.polynomial.legendre.leggauss(8)[0] * (LAST + 1 - FIRST) + LAST + FIRST) / 2
    nodes = Sampled("patches", "gauss:8,open", "--size", "60x40").nodes()
    check(np.abs(nodes - legendre).max() < 1e-9,
          "gauss:8,open has the wavelengths of Gauss-Legendre quadrature", nodes)
    shares = boxes(10)
    mean = shares / shares.sum(1)[:, None]
    is_near(chart("box:10", detector="cie1964")[0],
            np.array([(EYE_10 @ shares.T) @ ((mean @ D65) * (mean @ r)) for r in CHART]),
            "box:10 works for another observer, by its boxes")
    for method, limit in ("adaptive:0.0001", 0.001), ("riemann:1", 1e-6):
        wrong = error(chart(method, detector="cie1964")[0], truth)
        check(wrong < limit, f"{method} is right for another observer, too", wrong)


# ---- limits of three numbers ----

def check_fluorescence():
    scene = write("glow.scene", SMALL + "light d65 1 direction 0 0 1\nmaterial dull { diffuse 0.3 }\n"
                  "material glow { diffuse 0.3 fluorescence gaussian:450,40 gaussian:540,60 }\n"
                  "object plane 1 2 material dull translate -0.5 0 0\n"
                  "object plane 1 2 material glow translate 0.5 0 0\n")
    for method in "rgb", "xyz", "riemann:1", "basis:2":
        dull, glow = Sampled(scene, method).xyz()[4, [2, 6]]
        white = np.array([95.047, 100, 108.883])
        difference = ciede2000(cielab(dull, white), cielab(glow, white))
        cannot = method in ("rgb", "xyz")
        check(difference == 0 if cannot else difference > 10, f"{method} {'cannot show' if cannot else 'shows'}"
              f" fluorescence in daylight: {difference:.2f} CIEDE2000 between a pair")
    check_glow()


def check_glow():
    """Renders the built-in scene under a black light."""
    glow = ["--size", "60x40", "--light", "1=uv"]
    truth = Sampled("fluorescence", "riemann:1", *glow).xyz()

    def off(method):
        return np.abs(Sampled("fluorescence", method, *glow).xyz() - truth).max() / truth.max()

    for method, limit in ("basis:30", 3e-6), ("adaptive:0.01", 0.01), ("adaptive:0.0001", 0.0001):
        wrong = off(method)
        check(wrong < limit, f"{method} shows the glow under a black light, within {limit}", wrong)
    for few, many in ("box:10", "box:60"), ("gauss:10,open", "gauss:40,open"):
        wrong = off(few), off(many)
        check(wrong[0] > 5 * wrong[1], f"{many} shows the glow better than {few}", wrong)


# ---- OpenGL ----

def check_gl():
    for scene in "spheres", "patches":
        for method in METHODS:
            result = run("render", scene, "--size", "60x40", "--sampling", method, "--quiet", "-o", "/dev/null")
            check(result.returncode == 0, f"OpenGL and the reference agree on {scene} by {method}", result.stderr)


def check_again():
    for method in METHODS:
        stack = Sampled("spheres", method, "--size", "30x20")
        again = path_of("again.tif")
        result = run("render", "--again", stack.path, "--quiet", "-o", again)
        check(result.returncode == 0 and open(again, "rb").read() == open(stack.path, "rb").read(),
              f"a stack by {method} is made again to the last byte", result.stderr)


# ---- components ----

def check_components():
    check(chart("basis:99")[1] == 24, "a basis of 99 has 24 components for 24 patches")
    scene = write("equal.scene", SMALL + "light d65 1 direction 0 0 1\nmaterial m { diffuse gaussian:600,80*0.8 }\n"
                  "object plane 1 2 material m translate -0.5 0 0\nobject plane 1 2 material m translate 0.5 0 0\n")
    check(Sampled(scene, "basis:9").pages() == 1, "a basis of equal spectra has 1 component")
    write("parts.obj", "v -1 -1 0\nv 0 -1 0\nv 0 1 0\nusemtl a\nf 1 2 3\nv 1 -1 0\nv 1 1 0\nusemtl b\nf 2 4 5\n")
    write("parts.map", "a material glossy\nb material half\n")
    scene = write("parts.scene", SMALL + "light d65 1 direction 0 1 2\nlight gaussian:450,40 1 direction 0 0 1\nlight d65 1 direction 1 0 1\nambient a 0.5\n"
                  "material plain { diffuse gaussian:600,90 }\nmaterial glossy { diffuse gaussian:500,50 specular 0.3 gloss 9 emission gaussian:650,20 }\n"
                  "material half { diffuse 0.125 metamer plain }\nmaterial unused { diffuse gaussian:400,30 }\n"
                  "object mesh parts.obj materials parts.map\nobject sphere 0.4 12 8 material plain translate 0 0 1\n")
    basis, every_nm = (Sampled(scene, method).xyz() for method in ("basis:99", "riemann:1"))
    is_near(basis, every_nm, "a basis of all components has each light's product with each part of a mesh, highlight and emission",
            4 * np.abs(every_nm).max())


check_ambient()
check_riemann()
check_box()
check_three_numbers()
check_basis()
check_words()
check_gauss()
check_other_detector()
check_fluorescence()
check_gl()
check_again()
check_components()
done()
