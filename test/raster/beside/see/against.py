#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""`probe --against`: a metameric pair on the two halves of a plane agrees under the recorded light and differs under others by the
CIEDE2000 and the metamerism index of ISO 18314-4 that are computed here from the reflectances. Prints TAP."""
import json
import re

import numpy as np
import tifffile

from rendered import TMP, built_in, check, cielab, ciede2000, done, output_of, run, weights, write

NM = np.arange(400.0, 701.0, 10)
RNG = np.random.default_rng(3)
FIRST = 0.4 + 0.2 * np.sin(NM / 40)
W = weights("cie1931", NM)
LIGHTS = {name: np.interp(NM, *built_in(name), 0, 0) for name in ("d65", "a", "f11")}
# the second reflectance: a metameric black under d65, and then a small step away, so that the pair does not match exactly
seen = (W * LIGHTS["d65"]).T
black = RNG.uniform(-1, 1, len(NM))
black -= seen @ np.linalg.solve(seen.T @ seen, seen.T @ black)
SECOND = FIRST + 0.15 * black / np.abs(black).max() + 0.002
for name, values in ("first", FIRST), ("second", SECOND):
    write(f"{name}.csv", "nm,R\n" + "".join(f"{nm:g},{value:.9f}\n" for nm, value in zip(NM, values)))
run("render", write("a.scene", """wavelengths 400 700 10
size 40 20
camera ortho 4 eye 0 0 5 look 0 0 0
light d65 1 direction 0 0 1
material a { diffuse first.csv metamer b }
material b { diffuse second.csv }
object plane 4 2 material a
"""), "-o", f"{TMP}/a.tif", "--depth", "32f", "--quiet")
radiance = tifffile.imread(f"{TMP}/a.tif").astype(float)
pixels = radiance[:, 10, 5], radiance[:, 10, 35]
if abs(pixels[0] - FIRST * LIGHTS["d65"]).max() > 1e-5:
    pixels = pixels[::-1]
    places = "35", "10", "--against", "5", "10"
else:
    places = "5", "10", "--against", "35", "10"
check(np.allclose(pixels, [FIRST * LIGHTS["d65"], SECOND * LIGHTS["d65"]], rtol=1e-5), "the halves show the pair")
result = run("probe", f"{TMP}/a.tif", *places, "--light", "a", "--light", "1=f11")

rows = run("probe", f"{TMP}/a.tif", *places[:2], "4", "5", *places[2:], "--csv").stdout.split("\n")[1:-1]
means = [radiance[:, 10:15, int(x):int(x) + 4].mean((1, 2)) for x in (places[0], places[3])]
check(np.allclose([[float(value) for value in row.split(",")[1:3]] for row in rows], np.transpose(means), rtol=1e-9), "two regions of W x H pixels", rows[:2])


def xyz(values, light):
    return W @ (values * light)


def delta(one, other, light):
    white = W @ light
    return ciede2000(cielab(one, white), cielab(other, white))


printed = {where.split(",")[0]: (float(value), where) for value, where in re.findall(r"CIEDE2000 +([\d.]+) under (.*)", result.stdout)}
at = {name: [xyz(values, light) for values in (FIRST, SECOND)] for name, light in LIGHTS.items()}
check(abs(printed["the recorded light"][0] - delta(*at["d65"], LIGHTS["d65"])) < 2e-3, "CIEDE2000 under the recorded light", result.stdout[:500])
for name in "a", "f11":
    value, where = printed[name]
    check(abs(value - delta(*at[name], LIGHTS[name])) < 2e-3, f"CIEDE2000 under {name}", value, delta(*at[name], LIGHTS[name]))
    corrected = at[name][1] * at["d65"][0] / at["d65"][1]
    index = float(where.split()[-1])
    check(abs(index - delta(at[name][0], corrected, LIGHTS[name])) < 2e-3 and abs(index - value) > 0.01,
          f"the metamerism index under {name} corrects the mismatch", index, value)
difference = pixels[1] - pixels[0]
check(f"rms {np.sqrt(np.mean(difference ** 2)):.6g}" in result.stdout, "the rms of the spectra's difference", result.stdout[:300])
cosine = pixels[0] @ pixels[1] / np.linalg.norm(pixels[0]) / np.linalg.norm(pixels[1])
check(abs(float(re.search("spectral angle +([\\d.e-]+)", result.stdout).group(1)) - np.degrees(np.arccos(cosine))) < 1e-4, "spectral angle")
rows = run("probe", f"{TMP}/a.tif", *places, "--csv").stdout.split("\n")[1:-1]
check(np.allclose([[float(v) for v in row.split(",")] for row in rows], np.transpose([NM, *pixels, difference]), rtol=1e-9, atol=1e-12),
      "CSV has both spectra and their difference")
for words, why in ((["5", "10", "--against", "35"], "--against takes X and Y"), (["5", "10", "--against", "35", "10", "--svg"], "no --svg"), (
        ["5", "10", "--against", "35", "10", "--csv", "--light", "a"], "needs a scene"), (["5", "10", "--against", "35", "10", "--size", "9x9"], "no other change"),
                   (["5", "10", "--against", "99", "10"], "reaches")):
    result = run("probe", f"{TMP}/a.tif", *words)
    check(result.returncode == 2 and why in result.stderr, f"refused: {' '.join(words)}", result.stderr)

# objects: without their edges, as probe --objects has them
output_of("render", "patches", "--size", "120x80", "-o", f"{TMP}/p.tif", "--quiet")
values = {entry["name"]: np.array(entry["radiance"]) for entry in json.loads(output_of("probe", f"{TMP}/p.tif", "--objects", "--json", "-"))["objects"]}
rows = run("probe", f"{TMP}/p.tif", "15-red", "--against", "14-green", "--csv").stdout.split("\n")[1:-1]
seen = np.array([[float(v) for v in row.split(",")] for row in rows])
check(np.array_equal(seen[:, 1:3], np.transpose([values["15-red"], values["14-green"]])), "two objects are compared by their means")
number = list(values).index("14-green") + 1
check(run("probe", f"{TMP}/p.tif", "15-red", "--against", number, "--csv").stdout.split("\n")[1:-1] == rows, "an object has its number in --objects, too")
check("object 15-red and object 14-green" in run("probe", f"{TMP}/p.tif", "15-red", "--against", "14-green").stdout, "the table names both objects")
output_of("render", write("twins.scene", "size 60 40\nlight d65 1 direction 0 0 1\nmaterial m { diffuse 0.5 }\nobject sphere 1 material m translate -2 0 0\n"
                          "object sphere 1 material m translate 2 0 0\ncamera ortho 8\n"), "-o", f"{TMP}/t.tif", "--quiet")
for words, why in ((["m", "--against", "2"], "there is no object 'm', or not one alone"), (["m#3", "--against", "2"], "there is no object 'm#3'"),
                   (["no", "--against", "2"], "there is no object 'no'"), (["0", "--against", "1"], "no object '0'")):
    result = run("probe", f"{TMP}/t.tif", *words)
    check(result.returncode == 2 and why in result.stderr, f"refused: {' '.join(words)}", result.stderr)
alike = [run("probe", f"{TMP}/t.tif", name, "--against", "m#1", "--csv").stdout for name in ("2", "m#2", "m#1")]
check(alike[0] == alike[1] != alike[2], "of two objects that are named m, the second is m#2, and 2", *alike)
# an index that does not exist
output_of("render", write("black.scene", "size 60 40\nlight d65 1 direction 0 0 1\nmaterial k { diffuse 0 }\nmaterial w { diffuse 0.5 }\n"
                          "object plane 3 3 material k translate -2 0 0\nobject plane 3 3 material w translate 2 0 0\ncamera ortho 8\n"),
          "-o", f"{TMP}/k.tif", "--quiet")
for one, other in ("k", "k"), ("k", "w"), ("w", "k"):
    result = run("probe", f"{TMP}/k.tif", one, "--against", other, "--light", "1=a")
    check("metamerism index none" in result.stdout, f"{one} against {other}: where a region is black, there is no metamerism index", result.stdout)
done()
