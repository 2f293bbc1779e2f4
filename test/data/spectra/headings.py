#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Each word of a heading is used or refused: tables as instruments, spreadsheets and programs write them give the spectrum that
they hold, or a message that names the word: test/cases/headings.cases has them. Prints TAP."""
import csv
import io
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

from rendered import TMP, bytes_of, check, done, output_of, pages_of, run, write, write_stack

SCENE = "size 2 2\nwavelengths 400 700 100\nambient e 1\nmaterial m {{ diffuse {} }}\nobject plane 20 20 material m\n"
LIGHT = "size 2 2\nwavelengths 400 700 100\nambient {} 1\nmaterial m {{ diffuse 0.5 }}\nobject plane 1 1 material m\n"
CASE = r"^# (read|noisy|refused): (.*?) \| (.*?) ?\| (.*)\n((?:(?!# (?:read|noisy|refused): ).*\n)*)"
TABLES = [(*words, content.encode("latin-1", "backslashreplace").decode("unicode_escape"))
          for *words, content in re.findall(CASE, Path("test/cases/headings.cases").read_text(encoding="utf-8"), re.MULTILINE)]


def table(name, content):
    path = f"{os.path.abspath(TMP)}/{name.replace(' ', '-').replace('/', '-')}.txt"
    Path(path).write_bytes(content.encode())
    return path


def spectrum(path, sample):
    name, star, factor = sample.partition("*")
    return f'"{path}{":" + name if name else ""}{star}{factor}"'


def values_of(text):
    return {float(row[0]): float(row[1]) for row in list(csv.reader(io.StringIO(text)))[1:]}


for kind, case, sample, expected, content in TABLES:
    word = spectrum(table(case, content), "" if sample == "LIGHT" else sample)
    plan = run("plan", write("case.scene", (LIGHT if sample == "LIGHT" else SCENE).format(word)))
    if kind == "refused":
        listed = run("list", word.strip('"').partition("*")[0]) if case in ("no rows", "JCAMP-DX", "prefixes") else None
        check(plan.returncode == 2 and plan.stderr.count("\n") == 1 and expected in plan.stderr and (not listed or listed.returncode == 2),
              f"refused: {case}: {expected}", plan.stdout[:300], plan.stderr, listed)
        continue
    shown = run("show", word.strip('"'), "--csv")
    found, numbers = values_of(shown.stdout), [float(number) for number in expected.split()]
    right = dict(zip(numbers[::2], numbers[1::2]))
    check(plan.returncode == 0 and all(abs(found.get(at, 9) - value) < 1e-9 for at, value in right.items()) and
          (kind == "noisy" or len(found) == len(right)), f"read: {case}", plan.stderr, shown.stderr, found)
    if kind == "noisy":
        result = run("render", f"{TMP}/case.scene", "-o", f"{TMP}/case.tif", "--renderer", "raster")
        check(result.returncode == 0 and "beyond 0 or 1" in result.stdout, f"a note counts it: {case}", result.stdout, result.stderr)

# ---- numbers that are no spectra, and wavelengths in another unit ----
for number in ("6500", "2856", "1000", "100000", "6504.5"):
    result = run("plan", write("case.scene", LIGHT.format(number)))
    check(result.returncode == 2 and f"daylight:{number} or blackbody:{number}" in result.stderr, f"{number} as a light is no temperature", result.stderr)
    check(run("plan", write("case.scene", LIGHT.format(number + "*1"))).returncode == 0, f"{number}*1 is the number")
for text in ("0.4 0.7 0.01", "list 0.4 0.5", "0.38 0.78 0.005", "1 5 1", "list 0.55"):
    result = run("plan", write("case.scene", "wavelengths " + text + "\nobject plane 1 1 material m\nmaterial m { diffuse 0.5 }\n"))
    check(result.returncode == 2 and "multiply micrometres by 1000" in result.stderr, f"wavelengths {text} are refused", result.stderr)
result = run("plan", "patches", "--wavelengths", "0.4:0.7:0.01")
check(result.returncode == 2 and "multiply micrometres" in result.stderr, "so they are on the command line", result.stderr)

# ---- channels by their names ----
COLOURS = {"r": (0.01, 0.1), "g": (0.2, 0.5), "b": (0.5, 0.02)}
output_of("render", "patches", "--size", "30x20", "--wavelengths", "400:700:10", "-o", f"{TMP}/patches.tif", "--renderer", "raster", "--no-check", "-q")


def developed(names, values):
    write("detector.csv", "nm," + ",".join(names) + "".join(f"\n{nm}," + ",".join(str(value[i]) for value in values) for i, nm in enumerate((400, 700))) + "\n")
    return run("develop", f"{TMP}/patches.tif", "--detector", f"{TMP}/detector.csv", "-o", f"{TMP}/seen.png").stdout, open(f"{TMP}/seen.png", "rb").read()


first = developed("RGB", [COLOURS[c] for c in "rgb"])[1]
for order in ("BGR", ("blue", "green", "red"), ("Green", "R", "b"), "GBR", "RBG"):
    _, picture = developed(order, [COLOURS[c[0].lower()] for c in order])
    check(picture == first, f"channels {', '.join(order)} stand in the order of red, green and blue")
xyz = developed("xyz", [COLOURS[c] for c in "rgb"])
for order in ("zyx", "YXZ", "yzx", ("z_bar", "x_bar", "y_bar"), "ZXY"):
    said = developed(order, [COLOURS["rgb"["xyz".index(c[0].lower())]] for c in order])
    check("observer" in said[0] and said == xyz, f"channels {', '.join(order)} are an observer's", said)
for head, separator in (('# mine\n\n"Wavelength (nm)";"x";"y";"z"\r', ";"), ("lambda xbar ybar zbar", " "), ("nm\tx_10(2deg)\ty_10(2deg)\tz_10(2deg)", "\t"),
                        ("nm;CIE x\u0304;CIE \u0233;CIE z\u0304", ";")):
    lines = [head, *(separator.join(map(str, (nm, *(COLOURS[c][i] for c in "rgb")))) for i, nm in enumerate((400, 700)))]
    write("detector.csv", "\n".join(lines) + "\n")
    said = run("develop", f"{TMP}/patches.tif", "--detector", f"{TMP}/detector.csv", "-o", f"{TMP}/seen.png").stdout, bytes_of(f"{TMP}/seen.png")
    check(said == xyz, f"so are those of {head!r}", said[0])
check("observer" not in developed(("xenon", "y", "z"), [COLOURS[c] for c in "rgb"])[0], "xenon is no x")
for name in "a:1", "a*2", "a b.csv", "0.5":
    write(name, "nm r g b\n400 1 2 3\n")
    result = run("develop", os.path.abspath(f"{TMP}/patches.tif"), "--detector", f"./{name}", "-o", "seen.png", cwd=TMP)
    check(result.returncode == 0, f"a detector in a file named {name} is read", result.stderr)
# the bands of 300 and 600 nm are 300 nm wide, those of the picture 10, 20 and 30; the sum of y is 600, which becomes 100
write("lobed.csv", "nm,x,y,z\n300,1,3,4\n600,1,-1,4\n")
said = output_of("develop", write_stack("uneven.tif", np.ones((3, 1, 1), np.float32), (400, 410, 440)), "--xyz", "--detector", f"{TMP}/lobed.csv",
                 "-o", f"{TMP}/uneven-xyz.tif")
check(np.allclose(pages_of(f"{TMP}/uneven-xyz.tif").ravel(), [10, (10 * (3 - 4 / 3) * 1 + 20 * (3 - 4 * 110 / 300) + 30 * (3 - 4 * 140 / 300)) / 6, 40]),
      "a negative y reduces the sum", pages_of(f"{TMP}/uneven-xyz.tif").ravel())
lost = [float(word) for word in re.findall(r"[\d.e-]+(?= %)", re.search("^unseen.*$", said, re.MULTILINE)[0])]
check(np.allclose(lost, [90, 100 - 100 * (3 * 55 + 5) / 1200, 90], rtol=1e-4), "and counts by its size where it is not seen", lost, said)

# ---- the sample that makes tables of other formats ----
JCAMP = "##TITLE= paint\n##JCAMP-DX= 4.24\n##XUNITS= {}\n##YUNITS= {}\n##XFACTOR= {}\n##YFACTOR= {}\n##NPOINTS= {}\n{}\n##END=\n"
for case, content, expected in (
        ("wavenumbers", JCAMP.format("1/CM", "REFLECTANCE", 1, 1, 2, "##XYPOINTS= (XY..XY)\n25000, 0.1\n20000, 0.2"), {400: 0.1, 500: 0.2}),
        ("factors", JCAMP.format("NANOMETERS", "% REFLECTANCE", 2, 0.5, 2, "##XYPOINTS= (XY..XY)\n200 20\n250 40"), {400: 0.1, 500: 0.2}),
        ("steps", JCAMP.format("NANOMETERS", "REFLECTANCE", 1, 1, 4, "##FIRSTX= 400\n##LASTX= 700\n##XYDATA= (X++(Y..Y))\n400 0.1 0.2\n600 0.3 0.4"),
         {400: 0.1, 500: 0.2, 700: 0.4}),
        ("absorbance", JCAMP.format("NANOMETERS", "ABSORBANCE", 1, 1, 2, "##XYPOINTS= (XY..XY)\n400 1\n500 2"), {400: 0.1, 500: 0.01}),
        ("CxF", '<?xml version="1.0"?><c:CxF xmlns:c="x"><c:ReflectanceSpectrum Name="p" StartWL="400" Increment="50">0.1 0.15 0.2</c:ReflectanceSpectrum></c:CxF>',
         {400: 0.1, 500: 0.2}),
        ("pairs in a line", "400 0.1 500 0.2\n600 0.3 700 0.4\n", {400: 0.1, 500: 0.2, 600: 0.3, 700: 0.4}), ("pairs of columns", "Wavelength (nm),%R,Wavelength (nm),%R\n400,0.1,400,0.9\n500,0.2,500,0.8\n", {400: 0.1, 500: 0.2})):
    path = table(case, content)
    made = subprocess.run([sys.executable, "data/samples/to_csv.py", path], capture_output=True, text=True, check=False)
    write("made.csv", made.stdout)
    found = values_of(made.stdout)
    check(made.returncode == 0 and all(abs(found.get(at, 9) - value) < 1e-9 for at, value in expected.items()) and run("list", f"{TMP}/made.csv").returncode == 0,
          f"to_csv.py: {case}", made.stdout, made.stderr)
for case, content, why in (("compressed numbers", JCAMP.format("1/CM", "REFLECTANCE", 1, 1, 2, "##FIRSTX= 1\n##LASTX= 2\n##XYDATA= (X++(Y..Y))\n400A12b3"), "compressed"),
                           ("an unknown unit", JCAMP.format("FURLONGS", "REFLECTANCE", 1, 1, 1, "##XYPOINTS= (XY..XY)\n1 1"), "FURLONGS")):
    made = subprocess.run([sys.executable, "data/samples/to_csv.py", table(case, content)], capture_output=True, text=True, check=False)
    check(made.returncode == 1 and why in made.stderr and not made.stdout, f"to_csv.py refuses {case}", made.stderr)
done()
