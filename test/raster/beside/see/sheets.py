#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile python3-gdal python3-pil pngcheck
"""The sample sheet.py: each picture of a sheet has the pixels that develop writes, at the exposure that holds for all, above its name,
in every order, number and format. Prints TAP."""
import base64
import itertools
import os
import re
import subprocess
import sys

import numpy as np
import tifffile
from osgeo import gdal

from documents import put_in_path
from rendered import TMP, bytes_of, check, developed, done, path_of, reference, write

gdal.UseExceptions()
LIGHTS = "d65", "a", "f11*0.2"
WIDTH, HEIGHT = 90, 60
STACKS = {light: reference(f"under-{light.split('*')[0]}.tif", "patches", "--size", f"{WIDTH}x{HEIGHT}", "--wavelengths", "400:700:20",
                           f"--light=1={light}") for light in LIGHTS}
SMALL = reference("small.tif", "patches", "--size", "30x20", "--wavelengths", "400:700:20")


def sheet(*words, code="", **variables):
    command = [sys.executable, "-B", "-c", f"import sys; sys.path.insert(0, 'data/samples'); import sheet\n{code}\nsheet.main()"] if code else [
        sys.executable, "-B", "data/samples/sheet.py"]
    return subprocess.run([*command, *map(str, words)], capture_output=True, text=True, check=False, env={**os.environ, **variables})


def made(*words, ending=".png", **options):
    """The pixels of a sheet that must be made, and what is said of it."""
    path = path_of("sheet" + ending)
    result = sheet(*words[:-1] if isinstance(words[-1], tuple) else words, "-o", path, *(words[-1] if isinstance(words[-1], tuple) else ()), **options)
    check(result.returncode == 0 and not result.stderr, f"sheet.py {' '.join(map(str, words))}: it is made", result.stderr)
    return np.moveaxis(gdal.Open(path).ReadAsArray(), 0, 2), result.stdout


def cells(pixels, n, columns):
    """The pictures of a sheet and the areas of their names, row by row; all else must be white."""
    rows = -(-n // columns)
    check(pixels.shape[0] % rows == 0 and pixels.shape[1] % columns == 0, f"{n} pictures in {columns} columns: the sheet has equal cells", pixels.shape)
    down, across, rest = pixels.shape[0] // rows, pixels.shape[1] // columns, pixels.copy()
    margin, found = (across - WIDTH) // 2, []
    for i in range(n):
        y, x = i // columns * down, i % columns * across
        places = np.s_[y + margin:y + margin + HEIGHT, x + margin:x + margin + WIDTH], np.s_[y + margin + HEIGHT:y + down, x:x + across]
        found.append([pixels[place] for place in places])
        for place in places:
            rest[place] = np.iinfo(pixels.dtype).max
    check((rest == np.iinfo(pixels.dtype).max).all(), f"{n} pictures in {columns} columns: all around them is white")
    return found


def inked(name):
    return (name < np.iinfo(name.dtype).max / 2).sum()


def orders():
    """The names move with their pictures. The exposure is that of the brightest stack."""
    least = min(float(re.search(r"exposure +(\S+)", developed(path, "--exposure=auto")[1])[1]) for path in STACKS.values())
    names = {}
    for order in itertools.permutations(LIGHTS):
        pixels, said = made(*(STACKS[light] for light in order), ("--exposure", "auto"))
        exposure = float(re.search(r"exposure (\S+)", said)[1])
        check(abs(exposure / least - 1) < 1e-9, f"{order}: the exposure is the least of all", exposure, least)
        for light, (picture, name) in zip(order, cells(pixels, 3, 3)):
            alone, _ = developed(STACKS[light], f"--exposure={said.split()[-1]}")
            check((picture == alone).mean() > 0.999 and np.abs(picture.astype(int) - alone).max() <= 1 and np.ptp(alone) > 30,
                  f"{order}: the picture under {light} is that of develop", np.abs(picture.astype(int) - alone).max())
            check(inked(name) > 20 and (names.setdefault(light, name) == name).all(), f"{order}: the name of {light} stands below it, as in every order")
    check(len({name.tobytes() for name in names.values()}) == 3, "names differ")


def formats():
    for ending, bits in itertools.product((".png", ".tif", ".tiff"), (8, 16)):
        for options in [], ["--display", "monitor", "--adaptation", "cat16"], ["--detector", "dcs200-camera", "--white", "d65"]:
            words = ["--bits", bits, "--exposure", 0.9, *options]
            pixels, _ = made(*STACKS.values(), tuple(words), ending=ending)
            for path, (picture, _) in zip(STACKS.values(), cells(pixels, 3, 3)):
                alone, _ = developed(path, *words)
                check((picture == alone).all() and np.iinfo(picture.dtype).bits == bits and np.ptp(alone) > 1 << bits - 2,
                      f"{ending} of {bits} bits, {options}: the pixels are those of develop {os.path.basename(path)}")
            profile = tifffile.TiffFile(path_of("developed.tif")).pages[0].tags[34675].value
            found = gdal.Open(path_of("sheet" + ending)).GetMetadataItem("SOURCE_ICC_PROFILE", "COLOR_PROFILE")
            check(len(profile) > 100 and base64.b64decode(found or "") == profile, f"{ending} of {bits} bits, {options}: its profile is the display's")
            if ending == ".png":
                check(subprocess.run(["pngcheck", "-q", path_of("sheet.png")], check=False).returncode == 0, f"pngcheck finds no fault, {bits} bits")
    check(all(f"stack             {path}".encode() in bytes_of(path_of("sheet.tiff")) for path in STACKS.values()), "the sheet records its stacks")


def numbers():
    """All cells are there, in the order of the words."""
    paths = list(STACKS.values())
    alone = {path: developed(path)[0] for path in paths}
    for n in range(1, 8):
        order = [paths[i % 3] for i in range(n)]
        for columns in 0, 1, 2, n, 99:
            pixels, _ = made(*order, ("--columns", columns) if columns else ())
            shown = cells(pixels, n, min(columns, n) or {1: 1, 2: 2, 3: 3, 4: 2, 5: 3, 6: 3, 7: 4}[n])
            check(all((picture == alone[path]).all() and inked(name) for path, (picture, name) in zip(order, shown)),
                  f"{n} stacks, --columns {columns}: each is at its place, above its name")


def own_names():
    d65, lamp, _ = STACKS.values()
    usual = [name for _, name in cells(made(d65, lamp)[0], 2, 2)]
    named = [name for _, name in cells(made(f"under-a={d65}", f"={lamp}")[0], 2, 2)]
    check((named[0] == usual[1]).all() and (named[1] == usual[1]).all(), "NAME=STACK is shown as a file of that name; without a name it is the file's")
    equals = write("a=b.tif", "")
    with open(equals, "wb") as copy:
        copy.write(bytes_of(d65))
    check(inked(cells(made(equals)[0], 1, 1)[0][1]) > 0, "the name of a file may have an equals sign")
    for code in "", "sheet.FONT = 'no such font'":
        for name in "x", "i" * 120, "Grüße 光 \"quoted\"", "  ":
            picture, below = cells(made(f"{name}={d65}", code=code)[0], 1, 1)[0]
            check((picture == developed(d65)[0]).all() and (below < 255).any() == bool(name.strip()),
                  f"a name of {len(name)} letters stands below its picture, {'with another font' if code else 'with the usual font'}")


def refusals():
    d65 = STACKS["d65"]
    path = path_of("kept.png")
    old = write("kept.png", "an older file")
    for what, words, pattern, status in (
            ("stacks of other size", (d65, SMALL, "-o", path), f"small.tif: 30 x 20 pixels, but .*under-d65.tif has {WIDTH} x {HEIGHT}$", 2),
            ("a missing stack", (d65, "none.tif", "-o", path), "none.tif", 2),
            ("a scene", ("patches", d65, "-o", path), "patches is a scene, not a stack", 2),
            ("an option that develop has not", (d65, "-o", path, "--columms", 2), "develop has no option '--columms'", 2),
            ("XYZ", (d65, d65, "-o", path, "--xyz"), "a sheet is RGB", 2),
            ("raw values", (d65, "-o", path, "--raw"), "--raw takes no --json", 2),
            ("a sheet in the place of a stack", (d65, "-o", d65), "would replace an input", 2),
            ("a folder that does not exist", (d65, "-o", path_of("none/sheet.png")), "No such file", 3),
            ("a program that does not exist", (d65, "-o", path), "No such file", 3),
            ("no stack", ("-o", path), "^sheet.py STACK", 1), ("no sheet", (d65,), "^sheet.py STACK", 1), ("no words", (), "^sheet.py STACK", 1),
            ("another ending", (d65, "-o", path_of("sheet.jpg")), "^sheet.py STACK", 1),
            ("columns that are no number", (d65, "-o", path, "--columns", "two"), "^sheet.py STACK", 1)):
        stack = bytes_of(d65)
        result = sheet(*words, **({"PATH": "/none"} if "program" in what else {}))
        check(result.returncode == status and re.search(pattern, result.stderr) and not result.stdout and "Traceback" not in result.stderr,
              f"{what}: refused in words", result.returncode, result.stderr)
        check(open(old).read() == "an older file" and bytes_of(d65) == stack and not [name for name in os.listdir(TMP) if name.startswith(".sheet")],
              f"{what}: the old files stay, and nothing else is left")


put_in_path()
for part in orders, formats, numbers, own_names, refusals:
    part()
done()
