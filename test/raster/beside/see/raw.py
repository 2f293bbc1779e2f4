#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Raw values of detectors of 1 to 31 channels are the sums over pages of radiance x sensitivity x width, to the rounding of a float or of
a count; their pages have the channels' names and unit. Prints TAP."""
import re

import numpy as np
import tifffile

from rendered import TMP, check, done, output_of, run, widths, write

NM = np.arange(400.0, 701.0, 10)
OWN = np.arange(380.0, 721.0, 20)
RNG = np.random.default_rng(6)
run("render", write("a.scene", """wavelengths 400 700 10
size 70 50
camera ortho 3 eye 0 0 5 look 0 0 0
light d65 1 position 3 3 5
ambient a 0.1
material m { diffuse colorchecker/15-red specular 0.3 gloss 20 }
object sphere 1 material m
"""), "-o", f"{TMP}/a.tif", "--depth", "32f", "--quiet")
radiance = tifffile.imread(f"{TMP}/a.tif").astype(float)


def table(name, sensitivity, separator=","):
    names = [f"c {i + 1}" if separator == "," else f"c{i + 1}" for i in range(len(sensitivity))]
    lines = [separator.join(["nm", *names])] + [separator.join(f"{value:.6g}" for value in row) for row in zip(OWN, *sensitivity)]
    return write(name, "\n".join(lines) + "\n"), names


def raw(detector, *options):
    result = run("develop", f"{TMP}/a.tif", "--detector", detector, "--raw", "-o", f"{TMP}/raw.tif", *options)
    return result, tifffile.TiffFile(f"{TMP}/raw.tif") if result.returncode == 0 else None


def pages(file):
    return np.array([page.asarray() for page in file.pages], float)


for n in 1, 2, 3, 6, 31:
    sensitivity = np.round(RNG.uniform(0, 1, (n, len(OWN))), 4)
    detector, names = table(f"{n}.csv", sensitivity)
    expected = np.array([np.tensordot(np.interp(NM, OWN, curve) * 10, radiance, 1) for curve in sensitivity])
    result, file = raw(detector)
    check(np.allclose(pages(file), expected, rtol=2e-7), f"{n} channels are the sums over the pages", result.stderr)
    check([page.tags["PageName"].value for page in file.pages] == names and all(
        "W sr-1 m-2 (relative)" in page.tags[42112].value for page in file.pages), f"{n} pages have names and a unit")
    check(f"{n} channel" in result.stdout, f"the {n} channels are named", result.stdout)
    _, counts = raw(detector, "--bits", "16")
    scale = float(re.search("full_scale: (\\S+)", counts.pages[0].description).group(1))
    check(np.abs(pages(counts) * scale / 65535 - expected).max() <= 0.501 * scale / 65535 and pages(counts).max() == 65535,
          f"counts of {n} channels are within half a count", scale)
    _, one = raw(detector, "-j", "1")
    check(np.array_equal(pages(one), pages(file)), f"{n} channels: threads change no bit")
_, twice = raw(detector, "--exposure", "2")
check(np.allclose(pages(twice), 2 * pages(file), rtol=2e-7), "an exposure is a factor")
_, auto = raw(detector, "--exposure", "auto")
check(abs(pages(auto).max() - 1) < 1e-6, "an automatic exposure makes the largest value 1")

# an observer's raw values are its tristimulus values; a CGATS set of three samples is one, too
rows = "\n".join(f"{name} " + " ".join(f"{v:.6f}" for v in curve) for name, curve in zip("XYZ", RNG.uniform(0, 1, (3, len(OWN)))))
write("set.cmf", "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_ID " + " ".join(f"SPEC_{nm:.0f}" for nm in OWN)
      + f"\nEND_DATA_FORMAT\nBEGIN_DATA\n{rows}\nEND_DATA\n")
for detector in "cie1931", f"{TMP}/set.cmf":
    _, file = raw(detector)
    run("develop", f"{TMP}/a.tif", "--detector", detector, "--xyz", "-o", f"{TMP}/xyz.tif")
    check(np.allclose(pages(file), tifffile.imread(f"{TMP}/xyz.tif"), rtol=3e-7), f"raw values of {detector} are its XYZ")

for options, why in ((["--xyz"], "--raw takes no --xyz"), (["--bits", "8"], "counts of --bits 16"), (["--white", "d65"], "no --white"),
                     (["-o", f"{TMP}/raw.png"], "PNG")):
    result, _ = raw("cie1931", *options)
    check(result.returncode == 2 and why in result.stderr, f"refused: --raw {options[0]}: {why}", result.stderr)
result = run("develop", f"{TMP}/a.tif", "--detector", f"{TMP}/6.csv", "-o", f"{TMP}/none.png")
check(result.returncode == 2 and "6 channels" in result.stderr and "--raw" in result.stderr, "a picture of six channels names --raw")
result = run("develop", f"{TMP}/a.tif", "--detector", "dcs200-camera", "--xyz", "-o", f"{TMP}/none.tif")
check(result.returncode == 2 and "--raw" in result.stderr, "--xyz of a camera names --raw", result.stderr)
result = run("info", f"{TMP}/raw.tif")
check("raw values of" in result.stdout, "info prints how raw values were made", result.stdout)

# ---- samplings ----

six, names = table("6.csv", np.clip(1 - np.abs(OWN - np.linspace(430, 680, 6)[:, None]) / 60, 0, 1))
output_of("render", f"{TMP}/a.scene", "--wavelengths", "400:700:1", "-o", f"{TMP}/a.tif", "--depth", "32f", "--quiet")
fine = pages(raw(six)[1])
for sampling, tolerance in (("gauss:16", 0.015), ("gauss:16,open", 0.015), ("riemann:10", 0.01)):
    output_of("render", f"{TMP}/a.scene", "--wavelengths", "400:700:1", "--sampling", sampling, "--detector", six, "-o", f"{TMP}/a.tif", "-q")
    result, file = raw(six)
    off = np.abs(pages(file) - fine).max((1, 2)) / fine.max((1, 2))
    off = off[1:5]  # the ends of the range cut the outer two
    check(off.max() < tolerance, f"{sampling} for six channels keeps their values", result.stderr, off)
output_of("render", f"{TMP}/a.scene", "--sampling", "xyz", "-o", f"{TMP}/a.tif", "--quiet")
check("radiances" in raw(six)[0].stderr, "components have no raw values", raw(six)[0].stderr)
output_of("render", f"{TMP}/a.scene", "--sampling", "gauss:6,xyz", "-o", f"{TMP}/a.tif", "--quiet")
check("for cie1931 only" in raw(six)[0].stderr, "a sampling for one observer has them for no other detector", raw(six)[0].stderr)
refused = run("render", f"{TMP}/a.scene", "--sampling", "box:6", "--detector", six, "-o", f"{TMP}/no.tif")
check(refused.returncode == 2 and "needs three channels" in refused.stderr, "boxes need three channels", refused.stderr)

# ---- the error of a raw value ----

# the reference alone has levels of detail of its own: no mipmaps here
pasture = write("pasture.scene", output_of("show", "pasture").replace(" linear ", " bilinear "))
output_of("render", pasture, "--size", "90x60", "--depth", "32f", "-o", f"{TMP}/a.tif", "--check-map", f"{TMP}/map.tif", "--quiet")
seen = pages(raw(six)[1])
with tifffile.TiffFile(f"{TMP}/a.tif") as file:
    nm = np.array([float(page.tags["PageName"].value.split()[0]) for page in file.pages])
    full_scale = float(re.search("full_scale: (\\S+)", file.pages[0].description).group(1))
output_of("render", pasture, "--size", "90x60", "--depth", "32f", "-o", f"{TMP}/a.tif", "--renderer", "raster", "--quiet")
reference = pages(raw(six)[1])
floor, _, _, kind = tifffile.imread(f"{TMP}/map.tif").astype(float)
sensitivity = np.clip(1 - np.abs(OWN - np.linspace(430, 680, 6)[:, None]) / 60, 0, 1)
weight = np.array([(np.interp(nm, OWN, np.round(curve, 6), 0, 0) * widths(nm)).sum() for curve in sensitivity])[:, None, None]
bound = np.maximum(floor, 0) * full_scale / 65535 * weight + 2e-7 * reference
checked = kind == 0
check(checked.mean() > 0.9 and (np.abs(seen - reference) <= bound)[:, checked].all(),
      "at pixels that the map calls checked, raw values of OpenGL are as near to the reference's as its floor says",
      (np.abs(seen - reference) / bound)[:, checked].max())
check((np.abs(seen - reference) > bound / 300)[:, checked].any(), "and the bound is not idle", (np.abs(seen - reference) / bound)[:, checked].max())
done()
