#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Lights with a unit: the stack and all that is made of it carry the unit, and Y is a luminance in cd/m2, 683 lm/W; relative light is as
before. Prints TAP."""
import json

import numpy as np
import tifffile

from rendered import TMP, built_in, check, done, output_of, run, widths, write

NM = np.arange(380.0, 781.0, 5)
UNIT = "W sr-1 m-2 nm-1"
SCENE = """wavelengths 380 780 5
size 60 40
camera ortho 3 eye 0 0 5 look 0 0 0
light {0} 0.02 direction 0 0 1 {1}
ambient {0} 0.01 {1}
material half {{ diffuse 0.5 }}
object plane 9 9 material half
"""
STACK = f"{TMP}/a.tif"


def render(name, spectrum, unit, *options):
    output_of("render", write("a.scene", SCENE.format(spectrum, unit)), "-o", f"{TMP}/{name}.tif", "--depth", "32f", "-q", *options)
    return f"{TMP}/{name}.tif"


def probed(path):
    return json.loads(output_of("probe", path, "5", "5", "--json", "-"))


own, x, y, z = built_in("cie1931")
sums = 683 * (np.array([np.interp(NM, own, curve) for curve in (x, y, z)]) * widths(NM)).sum(1)
absolute, relative = render("absolute", "e", "unit W"), render("relative", "e", "unit relative")
seen = probed(absolute)
check(np.allclose(seen["XYZ"], 0.5 * 0.03 * sums, rtol=1e-6) and seen["unit"] == UNIT,
      "a white paper of reflectance 0.5 under 0.03 W sr-1 m-2 nm-1 has the luminance of the sum", seen["XYZ"], 0.5 * 0.03 * sums)
check(abs(seen["XYZ"][1] - 0.5 * 0.03 * 683 * y.sum() * (own[1] - own[0])) < 0.02, "which is 683 lm/W times the integral of y", seen["XYZ"])
plain = probed(relative)
check(np.allclose(np.array(seen["XYZ"]) / plain["XYZ"], 683 * y.sum() * (own[1] - own[0]) / 100, rtol=1e-12) and "relative" in plain["unit"],
      "relative light has Y = 100 of radiance 1")
check(np.allclose(seen["Lab"], plain["Lab"], atol=1e-9), "CIELAB does not depend on the unit")

output_of("develop", absolute, "--xyz", "-o", f"{TMP}/x.tif")
pages = tifffile.imread(f"{TMP}/x.tif")
check(np.allclose(pages[:, 5, 5], seen["XYZ"], rtol=1e-6), "develop --xyz writes cd/m2")
check("Y in cd/m2" in tifffile.TiffFile(f"{TMP}/x.tif").pages[0].description, "and its pages say so")
output_of("develop", absolute, "--detector", "cie1931", "--raw", "-o", f"{TMP}/r.tif")
with tifffile.TiffFile(f"{TMP}/r.tif") as file:
    check(np.allclose([page.asarray()[5, 5] for page in file.pages], seen["XYZ"], rtol=1e-6) and "cd m-2" in file.pages[1].tags[42112].value,
          "so do the raw values of an observer")
for path, unit in ((absolute, UNIT), (relative, UNIT + " (relative)")):
    with tifffile.TiffFile(path) as file:
        check(f'role="unittype">{unit}</Item>' in file.pages[3].tags[42112].value and f"sample {unit}\n" in file.pages[0].description,
              f"the tags of the stack: {unit}")
    check(json.loads(output_of("info", path, "--json", "-"))["unit"] == unit, f"info: {unit}")
    check(unit.replace(" (", ", ").replace(")", "") in output_of("probe", path, "5", "5"), f"probe: {unit}")
objects = json.loads(output_of("probe", absolute, "--objects", "--edges", "--json", "-"))
check(objects["unit"] == UNIT and np.allclose(objects["objects"][0]["XYZ"], seen["XYZ"], rtol=1e-6), "values of objects have the unit")
check(np.allclose(probed(f"{TMP}/a.scene")["XYZ"], plain["XYZ"], rtol=1e-6), "a scene is probed in its unit")

day = render("day", "d65", "unit W")
output_of("develop", day, "--exposure", repr(100 / probed(day)["XYZ"][1]), "--bits", "16", "-o", f"{TMP}/p.tif")
shown = tifffile.imread(f"{TMP}/p.tif")[5, 5]
check(shown.min() >= 65400, "100 cd/m2 at exposure 1 are the display's white", shown)  # but for the light beyond 780 nm

parts = [render(f"part{i}", "e", "unit W", "--part", f"{i}/2", "--size", "1600x1300", "--wavelengths", "500:600:50") for i in (1, 2)]
output_of("join", *parts, "-o", f"{TMP}/joined.tif")
check(probed(f"{TMP}/joined.tif")["unit"] == UNIT, "parts keep the unit")
output_of("render", f"{TMP}/a.scene", "--ambient", "a*0.1", "--light", "1=d65", "-o", f"{TMP}/other.tif", "-q")
render("again", "e", "unit W", "--light", "1=a*0.3", "--ambient", "d65*0.1")
check(probed(f"{TMP}/again.tif")["unit"] == UNIT, "options that replace spectra keep the unit")
for sampling in "gauss:4", "gauss:4,xyz", "box:6", "xyz":
    output_of("develop", render("sampled", "e", "unit W", "--sampling", sampling), "--xyz", "-o", f"{TMP}/x.tif")
    xyz = tifffile.imread(f"{TMP}/x.tif")[:, 5, 5]
    check(np.allclose(xyz, seen["XYZ"], rtol=1e-3), f"--sampling {sampling} keeps the luminance", xyz)

AMBIENT_FIRST = "ambient e 0.1\n" + SCENE
for scene, words in ((AMBIENT_FIRST, "a.scene:5:1: error: the unit of this light is W, of those before it relative"),
                     (SCENE.replace("direction 0 0 1 {1}", "direction 0 0 1"), "a.scene:5:1: error: the unit of this light is W"),
                     (SCENE.replace("{1}", "{1} unit W", 1), "a.scene:4:37: error: unit is given twice"), (SCENE.replace("{1}", "unit nm"), "a.scene:4:35: error: unknown unit")):
    refused = run("render", write("a.scene", scene.format("e", "unit W")), "-o", f"{TMP}/no.tif")
    check(refused.returncode == 2 and words in refused.stderr, f"refused: {words}", refused.stderr)
refused = run("compare", absolute, relative)
check(refused.returncode == 2 and "relative" in refused.stderr, "stacks of different units are not compared", refused.stderr)
done()
