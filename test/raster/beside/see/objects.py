#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""`probe --objects` prints the mean and deviation of the pixels that the object map gives each object, edges left out by default, its XYZ
and CIELAB, and the raw values of a detector's channels. Prints TAP."""
import csv
import io
import json
import re

import numpy as np
import tifffile

from rendered import TMP, bytes_of, check, done, run, weights, write

STACK = f"{TMP}/a.tif"
run("render", write("a.scene", """wavelengths 400 700 10
size 90 60
camera ortho 4 eye 0 0 5 look 0 0 0
light d65 1 position 3 3 5
ambient a 0.2
material m { diffuse colorchecker/15-red specular 0.3 gloss 20 }
material n { diffuse colorchecker/14-green }
object sphere 0.9 material m translate -0.6 0 0
object plane 1.5 1 material n translate 0.9 0.2 -1
object plane 0.01 0.01 material n translate 1.9 1.2 -1
"""), "-o", STACK, "--depth", "32f", "--quiet")
radiance = tifffile.imread(STACK).astype(float)
text = tifffile.TiffFile(STACK).pages[0].description
offset, size = map(int, re.search("object_map: (\\d+) (\\d)", text).groups())
shown = np.frombuffer(bytes_of(STACK), f"<u{size}", 90 * 60, offset).reshape(60, 90)
padded = np.pad(shown, 1, "edge")
inner = np.all([padded[dy:dy + 60, dx:dx + 90] == shown for dy in range(3) for dx in range(3)], axis=0)
write("cam.csv", "nm,blue,red\n380,1,0\n500,0.5,0.1\n720,0,1\n")
run("develop", STACK, "--detector", f"{TMP}/cam.csv", "--raw", "-o", f"{TMP}/raw.tif")
raw = tifffile.imread(f"{TMP}/raw.tif").astype(float)
xyz = weights("cie1931", np.arange(400.0, 701.0, 10))
for options, kept in ([], inner), (["--edges"], np.ones_like(inner)):
    result = run("probe", STACK, "--objects", "--detector", f"{TMP}/cam.csv", "--json", "-", *options)
    report = json.loads(result.stdout)
    check([entry["name"] for entry in report["objects"]] == ["m", "n#1", "n#2"] and report["channel_names"] == ["blue", "red"],
          f"{options}: objects and channels have names", result.stdout[:300])
    for number, entry in enumerate(report["objects"], 1):
        at = (shown == number) & kept
        name = f"{options}: object {number}"
        check(entry["pixels"] == at.sum(), f"{name} has {at.sum()} pixels", entry["pixels"])
        if not at.any():
            check(entry["XYZ"] is None and entry["radiance"] is None, f"{name} without pixels has no values", entry)
            continue
        mean = radiance[:, at].mean(axis=1)
        check(np.allclose(entry["radiance"], mean, rtol=1e-12) and np.allclose(entry["standard_deviation"], radiance[:, at].std(axis=1),
                                                                               rtol=1e-9, atol=1e-12), f"{name}: mean and deviation of each band")
        check(np.allclose(entry["channels"], raw[:, at].mean(axis=1), rtol=1e-6) and
              np.allclose(entry["channels_standard_deviation"], raw[:, at].std(axis=1), rtol=1e-4, atol=1e-6), f"{name}: raw values")
        check(np.allclose(entry["XYZ"], xyz @ mean, rtol=1e-9), f"{name}: XYZ of the mean", entry["XYZ"])
rows = list(csv.reader(io.StringIO(run("probe", STACK, "--objects", "--csv").stdout)))
check(len(rows) == 4 and len(rows[0]) == 8 + 2 * 31 and rows[0][8] == "400 nm", "CSV has a row an object", rows[0])
lines = run("probe", STACK, "--objects").stdout
check("m\n  pixels" in lines and "Lab" in lines, "words name objects, pixels and colours", lines)
for words, why in ((["1", "1"], "takes a STACK alone"), (["--svg"], "no --svg"), (["--size", "9x9"], "needs a scene")):
    result = run("probe", STACK, *words, "--objects")
    check(result.returncode == 2 and why in result.stderr, f"--objects {words} is refused", result.stderr)
result = run("probe", f"{TMP}/raw.tif", "--objects")
check(result.returncode == 2, "a stack without a map is refused", result.stderr)
done()
