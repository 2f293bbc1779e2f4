#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile
"""Computes probe's output for a stack once more with numpy from its samples. Probe's output for a scene must equal
the stack that render stores, and its other curves must equal the tables. Plots are read back as XML. Prints TAP."""
import csv
import io
import os
import re
import xml.etree.ElementTree as ElementTree

import numpy as np

from colours import cielab
from rendered import (D65, LAMP_A, MATERIAL, RED, TMP, WAVELENGTHS, check, done, output_of, pages_of, path_of,
                      reference, refuses, run, weights, write, write_stack)

SVG = "{http://www.w3.org/2000/svg}"
SIZE = "--size", "120x80"


def probe(*arguments):
    """Columns of the CSV by name, without units."""
    result = run("probe", *arguments, "--csv")
    if result.returncode != 0:
        return {"error": result.stderr}
    head, *rows = csv.reader(io.StringIO(result.stdout))
    return dict(zip([re.sub(r" \([^()]*\)$", "", name) for name in head], np.array(rows, float).T))


def values_of(*arguments):
    """Lines of the text by their first words."""
    lines = run("probe", *arguments).stdout.splitlines()
    return {line[:18].strip(): line[18:] for line in lines}


def render(scene, *options):
    path = reference(scene + ".tif", scene, *SIZE, "--depth", "32f", *options)
    return path, pages_of(path)


# ---- a stack ----

def test_stack():
    path, pixels = render("colorchecker")
    for x, y, w, h in (60, 40, 1, 1), (0, 0, 120, 80), (13, 7, 31, 22), (119, 79, 1, 1):
        seen = probe(path, x, y, w, h)
        region = pixels[:, y:y + h, x:x + w].reshape(len(pixels), -1)
        check(np.allclose(seen["radiance"], region.mean(1), rtol=1e-14, atol=0)
              and np.allclose(seen["standard deviation of radiance"], region.std(1), rtol=1e-9, atol=1e-15),
              f"mean and standard deviation of {w} x {h} pixels from {x},{y}")
    check((probe(path, 60, 40)["radiance"] == pixels[:, 40, 60]).all(), "probe prints a pixel's samples exactly")
    check(probe(path, 60, 40)["radiance"].tolist() == probe(path, 60, 40, 1, 1)["radiance"].tolist(),
          "a pixel is a region of 1 x 1")
    eye = weights("cie1931", WAVELENGTHS)
    lines, mean = values_of(path, 13, 7, 31, 22), pixels[:, 7:29, 13:44].mean((1, 2))
    xyz, white = eye @ mean, eye @ D65
    for name, expected in (("XYZ", xyz), ("xy", xyz[:2] / xyz.sum()), ("Lab", cielab(xyz, white)), ("white XYZ", white)):
        seen = np.array(lines[name].split(), float)
        check(abs(seen - expected).max() <= 0.51e-4, f"{name} is that of the mean", lines[name], expected)
    text = values_of(path, 60, 40)
    check(text["source"] == path and text["region"] == "pixel 60,40", "the text names stack and pixel", text)
    wavelength = [line for line in run("probe", path, 60, 40).stdout.splitlines() if line.startswith("550 ")]
    radiance = pixels[WAVELENGTHS == 550, 40, 60][0]
    check(len(wavelength) == 1 and abs(float(wavelength[0].split()[1]) - radiance) <= 6e-6 * radiance,
          "a line has its wavelength and then its radiance", wavelength)
    return path


def test_foreign():
    path = write_stack("foreign.tif", [np.full((4, 5), page + 0.5, np.float32) for page in range(3)], (450, 550, 650))
    seen, lines = probe(path, 0, 0, 5, 4), values_of(path, 0, 0, 5, 4)
    check(seen["wavelength"].tolist() == [450, 550, 650] and seen["radiance"].tolist() == [0.5, 1.5, 2.5]
          and not seen["standard deviation of radiance"].any(),
          "a stack of another program is probed, and equal pixels have no deviation")
    check(lines["Lab"].startswith("none") and lines["object"].startswith("unknown"),
          "its white and objects are unknown", lines)
    check(re.fullmatch(r"[-.\d]+ [-.\d]+ [-.\d]+", values_of(path, 0, 0, "--white", "d65")["Lab"]),
          "--white sets its white")


def test_steady():
    """The distance between floats near 1000 is 2^-14."""
    steps = np.arange(20).reshape(4, 5) % 3
    path = write_stack("steady.tif", [(1000 + steps * 2.0**-14).astype(np.float32)], [450])
    spread = probe(path, 0, 0, 5, 4)["standard deviation of radiance"][0]
    check(abs(spread / (steps.std() * 2.0**-14) - 1) < 1e-9, "a small deviation is exact beside a large mean", spread)


# ---- a scene ----

def test_scene(scene, regions):
    path, pixels = render(scene)
    same = agree = objects = 0
    for x, y, w, h in regions:
        of_scene, of_stack = probe(scene, x, y, w, h, *SIZE), probe(path, x, y, w, h)
        columns = "radiance", "standard deviation of radiance"
        same += all(np.array_equal(of_scene[c], of_stack[c]) for c in columns)
        agree += np.array_equal(of_scene["radiance"], pixels[:, y, x]) if w == h == 1 else 1
        lines = [values_of(scene, x, y, w, h, *SIZE), values_of(path, x, y, w, h)]
        objects += all(lines[0][key] == lines[1][key] for key in ("object", "XYZ", "Lab", "white XYZ"))
    check(same == len(regions),
          f"{scene}: radiances of {len(regions)} pixels and regions are what render stores, to the last bit")
    check(agree == len(regions), f"{scene}: another program reads the same radiances")
    check(objects == len(regions), f"{scene}: the object and colours equal those of the stack")


def test_curves():
    scene = write("curves.scene", f"""wavelengths 300 760 5
size 40 40
camera ortho 4
light d65 0.75 direction 0 0 1
light a*0.5 0.25 direction 0 0 1
ambient gaussian:500,80 0.1
material red {os.path.relpath(MATERIAL, TMP)}
material dye {{ diffuse 0.3 specular 0.25 gloss 9 fluorescence gaussian:370,40 gaussian:440,60*0.4 emission d65*0.05 }}
object plane 1 2 material red translate -1 0 0
object plane 1 2 material dye translate 1 0 0
""")
    ambient = np.exp(-4 * np.log(2) * ((WAVELENGTHS - 500) / 80) ** 2)
    lights = {"light 1 (d65)": 0.75 * D65, "light 2 (a*0.5)": 0.125 * LAMP_A,
              "ambient light 1 (gaussian:500,80)": 0.1 * ambient}
    red, dye = probe(scene, 10, 20), probe(scene, 30, 20)
    check(all(name in red and np.allclose(red[name], values, rtol=1e-12, atol=1e-300) for name, values in lights.items()),
          "each light and ambient light is intensity x spectrum", list(red))
    check(np.allclose(red["reflectance"], RED, rtol=1e-12) and "specular reflectance" not in red
          and "excitation" not in red, "a matt object has its reflectance and no other curve")
    check(np.allclose(red["radiance"], sum(lights.values()) * RED, rtol=1e-6),
          "its radiance is its reflectance times all light, which faces it")
    expected = {"reflectance": 0.3, "specular reflectance": 0.25, "own light": 0.05 * D65,
                "excitation": np.exp(-4 * np.log(2) * ((WAVELENGTHS - 370) / 40) ** 2),
                "emission": 0.4 * np.exp(-4 * np.log(2) * ((WAVELENGTHS - 440) / 60) ** 2)}
    check(all(name in dye and np.allclose(dye[name], values, rtol=1e-12, atol=1e-300) for name, values in expected.items()),
          "a fluorescent object has reflectances, excitation, emission and its own light", list(dye))
    write("matrix.csv", "nm 300 400 500\n500 0.02 0.04 0.3\n600 0.01 0.03 0.1\n")
    scaled = write("matrix.scene", "wavelengths list 500 550 600\nsize 4 4\nlight 1 2 direction 0 0 1\nambient 1 0.5\n"
                   "material m { donaldson matrix.csv }\nobject plane 20 20 material m\n")
    matrix = probe(scaled, 1, 1)
    check(np.allclose(matrix["emission under light 1 (1)"], [0.12, 0.2, 0.28]) and
          np.allclose(matrix["emission under ambient light 1 (1)"], [0.03, 0.05, 0.07]) and np.allclose(matrix["reflectance"], 0.3),
          "a matrix has its diagonal as reflectance, and the emission under each light", list(matrix))
    check(values_of(scene, 10, 20)["object"] == "red" and values_of(scene, 30, 20)["object"] == "dye",
          "objects have their names")
    background, both = probe(scene, 20, 1), probe(scene, 10, 20, 21, 1)
    check(not background["radiance"].any() and set(background) == set(red) - {"reflectance"},
          "the background is black, and has only lights as curves", list(background))
    check(set(both) == set(background), "a region of two objects has only lights as curves", list(both))
    check(values_of(scene, 20, 1)["object"] == "background" and
          values_of(scene, 10, 20, 21, 1)["object"].startswith("unknown"),
          "the text names the background and an unknown object")
    return scene


# ---- plots ----

def lines_of(root):
    """The lines of a plot by their names."""
    return {g.find(SVG + "title").text: g.find(SVG + "path") for g in root.iter(SVG + "g") if g.find(SVG + "title") is not None}


def points(path):
    return np.array(re.findall(r"([-\d.]+),([-\d.]+)", path.get("d")), float)


def test_svg(scene):
    result = run("probe", scene, 30, 20, "--svg")
    root = ElementTree.fromstring(result.stdout)
    seen = probe(scene, 30, 20)
    groups = lines_of(root)
    names = [name for name in seen if name not in ("wavelength", "standard deviation of radiance")]
    check(sorted(groups) == sorted(names), "the plot has a line for each curve", list(groups), names)
    right = {"reflectance", "specular reflectance", "excitation", "emission"}
    check(all(len(points(groups[name])) == len(WAVELENGTHS) for name in names), "each line has all wavelengths")
    for side, members in (("left", set(names) - right), ("right", right)):
        x = np.concatenate([points(groups[name])[:, 0] for name in members])
        y = np.concatenate([points(groups[name])[:, 1] for name in members])
        values = np.concatenate([seen[name] for name in members])
        fit_x = np.polyfit(np.tile(WAVELENGTHS, len(members)), x, 1)
        fit_y = np.polyfit(values, y, 1)
        check(abs(np.polyval(fit_y, values) - y).max() < 0.01 and fit_y[0] < 0
              and abs(np.polyval(fit_x, np.tile(WAVELENGTHS, len(members))) - x).max() < 0.01,
              f"lines of the {side} axis share one scale, to a hundredth of a pixel")
    texts = [text.text for text in root.iter(SVG + "text")]
    check("wavelength (nm)" in texts and "radiance (W sr⁻¹ m⁻² nm⁻¹, relative)" in texts and "400" in texts,
          "axes name quantity and unit", texts)
    check(not re.search(r"<script|href|\bon\w+=", result.stdout), "the plot has no script and no reference")
    check(result.stdout == run("probe", scene, 30, 20, "--svg").stdout, "the plot has the same bytes each time")


def test_bars(path):
    """Bars of a region reach from mean - deviation, or from 0, to mean + deviation."""
    def lines(*region):
        return lines_of(ElementTree.fromstring(run("probe", path, *region, "--svg").stdout))
    drawn, seen = lines(0, 0, 120, 80), probe(path, 0, 0, 120, 80)
    mean, spread = seen["radiance"], seen["standard deviation of radiance"]
    scale = np.polyfit(points(drawn["radiance"])[:, 1], mean, 1)
    ends = np.polyval(scale, points(drawn["standard deviation of radiance"])[:, 1].reshape(-1, 2).T)
    check(np.abs(ends - [np.maximum(mean - spread, 0), mean + spread]).max() < 1e-4 * mean.max(), "each wavelength of a region has a bar of its deviation",
          ends[:, :2])
    check(list(lines(60, 40)) == ["radiance"], "a pixel has no bars")


# ---- refusals ----

def refused(pattern, *words):
    refuses(" ".join(map(str, words)), pattern, "probe", *words)


def test_refusals(path, scene):
    for source, size in (path, "120 x 80"), (scene, "40 x 40"):
        width, height = map(int, size.split(" x "))
        for region in ((width, 0), (0, height), (width - 1, 0, 2, 1), (0, height - 1, 1, 2), (2147483647, 0),
                       (1, 1, 2147483647, 1)):
            refused(f"the picture has {size} pixels", source, *region)
    rgb, gauss = path_of("rgb.tif"), path_of("gauss.tif")
    for out, sampling in (rgb, "rgb"), (gauss, "gauss:6"):
        output_of("render", "metamers", "--size", "60x40", "--sampling", sampling, "--quiet", "-o", out)
    refused("a probe needs radiances at wavelengths; .*rgb.tif holds the components of rgb", rgb, 0, 0)
    check(run("probe", gauss, 20, 20).returncode == 0, "a sampled stack with radiances is probed")


STACK = test_stack()
test_foreign()
test_steady()
test_scene("colorchecker", [(60, 40, 1, 1), (20, 20, 1, 1), (33, 18, 40, 40), (0, 0, 120, 80)])
test_scene("fluorescence", [(20, 20, 1, 1), (24, 20, 1, 1), (0, 79, 1, 1), (15, 15, 3, 2)])
test_scene("textures", [(21, 16, 1, 1), (60, 40, 1, 1), (10, 10, 50, 20)])
test_scene("room", [(60, 30, 1, 1), (10, 70, 1, 1), (100, 20, 1, 1), (50, 30, 20, 20), (0, 0, 120, 80)])
test_scene("metamers", [(20, 20, 1, 1), (24, 20, 1, 1), (22, 18, 4, 1)])
SCENE = test_curves()
test_svg(SCENE)
test_bars(STACK)
test_refusals(STACK, SCENE)
done()
