#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile python3-pil
"""Displays by their numbers, --display FILE: pixels are computed once more with numpy. The thesis's monitor as a file is
--display monitor, by its equations 13 and 14. Prints TAP."""
import os
import re

import numpy as np
import tifffile
from PIL import Image

from colours import MONITOR, MONITOR_GAIN, MONITOR_GAMMA, OWN_DISPLAYS
from rendered import check, developed, done, output_of, path_of, reference, refuses, remove, weights, write, write_stack

MONITOR_FILE = "data/builtin/displays/monitor.csv"
NM = np.arange(400, 701, 20)


def strong_colours():
    """A stack of few bright bands in each pixel, many of them beyond each display, and its XYZ."""
    radiance = (np.random.default_rng(78).random((len(NM), 40, 60)) ** 4 * 2).astype(np.float32)
    return write_stack("strong.tif", radiance, NM), np.moveaxis(np.tensordot(weights("cie1931", NM), radiance.astype(float), (1, 0)), 0, -1)


def check_pixels(name, seen, expected, bits):
    """The last bit may differ if the exact value is half-way between two steps, within a thousandth."""
    error = np.abs(seen - expected * (2**bits - 1)).max()
    check(seen.shape == expected.shape and error <= 0.501 and np.ptp(expected) == 1, f"{name}, {bits} bits: the pixels are numpy's", error)


def check_display(stack, name, display, linear, largest, encode):
    beyond = int(((linear < -1e-6) | (linear > largest + 1e-6)).any(-1).sum())
    for bits in 8, 16:
        seen, said = developed(stack, "--display", display, "--bits", bits)
        check_pixels(name, seen, encode(linear), bits)
        counted = int(re.search(r"out of gamut +(\d+) ", said)[1])
        check(counted == beyond and 0 < beyond < seen[..., 0].size, f"{name}, {bits} bits: {beyond} pixels are out of gamut", counted)
    seen, _ = developed(stack, "--display", display, "--bits", 16, "--exposure", "auto")
    check_pixels(f"{name}, its brightest channel at the largest value", seen, encode(linear / (linear / largest).max()), 16)


def file_of(name):
    return write(f"{name}.csv", OWN_DISPLAYS[name].text())


def monitor(stack, xyz):
    """Its file: the same pixels and profile as its name, by the thesis's equations."""
    linear = xyz @ MONITOR.T
    for display in MONITOR_FILE, "monitor":
        check_display(stack, display, display, linear, MONITOR_GAIN ** MONITOR_GAMMA,
                      lambda linear: np.minimum(linear.clip(0) ** (1 / MONITOR_GAMMA) / MONITOR_GAIN, 1))
    for bits in 8, 16:
        made = []
        for display in MONITOR_FILE, "monitor":
            developed(stack, "--display", display, "--bits", bits)
            with tifffile.TiffFile(path_of("developed.tif")) as tiff:
                made.append((tiff.asarray().tobytes(), tiff.pages[0].tags[34675].value))
        check(made[0] == made[1], f"the file of the thesis's monitor gives the pixels and the profile of its name, {bits} bits")


def forms(stack):
    """Blanks and semicolons part numbers, too; names and headings may be left out."""
    expected, _ = developed(stack, "--display", file_of("crt"))
    text = OWN_DISPLAYS["crt"].text()
    for name, other in (("blanks", text.replace(",", " ")), ("semicolons", text.replace(",", ";\t")),
                        ("numbers alone", re.sub("(?m)^[a-z]+,", "", text)),
                        ("headings", "# measured\nprimary,X,Y,Z\n\n" + text.replace("gain", "channel,red,green,blue\ngain"))):
        seen, _ = developed(stack, "--display", write("form.csv", other))
        check((seen == expected).all(), f"a file with {name} is the same display")


def without_display(stack):
    """--xyz and --lab do not depend on the display; --raw takes none."""
    for options in ("--xyz",), ("--lab", "--white", "d65"):
        (plain, _), (seen, _) = developed(stack, *options), developed(stack, *options, "--display", file_of("crt"))
        check((plain == seen).all(), f"{options[0]} is the same with any display")
    refuses("--raw with a display", "--raw takes no --display", "develop", stack, "--raw", "--display", file_of("crt"), "-o", path_of("raw.tif"))


def refusals(stack):
    out = path_of("refused.tif")
    remove(out)
    rows = OWN_DISPLAYS["crt"].text().splitlines()

    def changed(row, text):
        return "\n".join([*rows[:row], *([text] if text else []), *rows[row + 1:]]) + "\n"

    limits, number = "gain, gamma and gain [+] offset lie from 0.01 to 100; found ", "must be a number such as"
    white, name = "its primaries add up to no white", "expected the row of '%s', found '%s'"
    for what, says, text in (
            ("a gamma of 0", limits + "1.02, 0 and 0.99", changed(5, "gamma,2,0,2")),
            ("a negative gamma", limits, changed(5, "gamma,2,2,-1")),
            ("a huge gamma", limits, changed(5, "gamma,2,101,2")),
            ("a gain of 0", limits + "0, 2.35 and 0.04", changed(3, "gain,0,1,1")),
            ("a huge gain", limits, changed(3, "gain,1,1,1e20")),
            ("an offset that leaves no range", limits + "1.1, 1.8 and 0$", changed(4, "offset,0,0,-1.1")),
            ("an offset that leaves nearly no range", limits, changed(4, "offset,0,0,-1.0999")),
            ("primaries in a plane", "its primaries lie in a plane", changed(1, "green,80.2,41.8,3.8")),
            ("a primary of 0", "its primaries lie in a plane", changed(2, "blue,0,0,0")),
            ("primaries whose white is dark", white, changed(1, "green,35.2,-28.3,11.6")),
            ("primaries whose white has no cone response", white, changed(2, "blue,18.3,7.4,-95.6")),
            ("a huge primary beside a dark white", white, changed(1, "green,1e9,-28.299,11.6")),
            ("a missing row", ":5:1: error: " + name % ("offset", "gamma"), changed(4, "")),
            ("a missing last row", "expected 6 rows of three numbers, found 5", changed(5, "")),
            ("a wrong name", ":5:1: error: " + name % ("offset", "ofset"), changed(4, "ofset,0,0,0")),
            ("another order", ":4:1: error: " + name % ("gain", "gamma"), changed(3, rows[5])),
            ("NaN", ":4:8: error: .*" + number, changed(3, "gain,1,nan,1")),
            ("infinity", ":6:7: error: .*" + number, changed(5, "gamma,inf,2,2")),
            ("seven rows", ":7:1: error: expected 6 rows, no more", changed(5, rows[5] + "\n" + rows[5])),
            ("four numbers", ":4:12: error: '1' is too much", changed(3, "gain,1,1,1,1")),
            ("two numbers", ":4:9: error: expected a number", changed(3, "gain,1,1")),
            ("no numbers", "expected 6 rows of three numbers, found 0", "red\n"),
            ("an empty file", "expected 6 rows of three numbers, found 0", "")):
        refuses(what, says, "develop", stack, "--display", write("bad.csv", text), "-o", out, absent=out)
    for word in path_of("none.csv"), "crt", "":
        refuses(f"the display '{os.path.basename(word)}'", f"no display '{word}' and no such file; expected srgb, monitor, or a file",
                "develop", stack, "--display", word, "-o", out, absent=out)
    refuses("a folder", "is a folder", "develop", stack, "--display", "data", "-o", out, absent=out)
    for page in "x.html", "x.png":
        refuses(f"a bad display for {page}", limits, "view", "patches", "--size", "8x6", "--display", write("bad.csv", changed(3, "gain,0,1,1")),
                "-o", path_of(page), absent=path_of(page))


def stills():
    """The PNG of view has the pixels of develop, but for what it rounds."""
    expected, _ = developed(reference("checker.tif", "colorchecker", "--size", "60x40"), "--exposure", "auto", "--display", file_of("crt"))
    output_of("view", "colorchecker", "--size", "60x40", "--display", file_of("crt"), "-o", path_of("still.png"), "--quiet")
    with Image.open(path_of("still.png")) as image:
        error = np.abs(np.asarray(image).astype(float) - expected)
    check(error.max() <= 1 and np.mean(error > 0) < 0.01 and np.ptp(expected) > 100, "the PNG of view is develop's picture on this display",
          error.max(), np.mean(error > 0))


STACK, XYZ = strong_colours()
monitor(STACK, XYZ)
for known, numbers in OWN_DISPLAYS.items():
    check_display(STACK, known, file_of(known), numbers.linear(XYZ), numbers.largest, numbers.values)
forms(STACK)
without_display(STACK)
refusals(STACK)
stills()
done()
