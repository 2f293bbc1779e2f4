#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile liblcms2-utils
"""The ICC profiles of pictures are as the specification says (ICC.1:2010), and Little CMS reads them as intended:
media-relative XYZ for D50. Prints TAP."""
import struct
import subprocess

import numpy as np
import tifffile

from colours import MONITOR, MONITOR_GAIN, MONITOR_GAMMA, OWN_DISPLAYS, ciede2000, cielab
from rendered import TMP, bytes_of, check, done, output_of, path_of, reference, write

D50 = np.array([0.9642, 1, 0.8249])
BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
# IEC 61966-2-1: linear RGB to XYZ, from the chromaticities of the primaries and of D65
PRIMARIES = np.array([[0.64, 0.30, 0.15], [0.33, 0.60, 0.06], [0.03, 0.10, 0.79]])
CHANNELS = [*np.eye(3, dtype=int), np.ones(3, int)]
VALUES = np.array([*(value * channel for channel in CHANNELS for value in range(256)),
                   [200, 100, 50], [1, 2, 3], [30, 60, 240], [250, 255, 245]])
TAGS = {"desc": "mluc", "cprt": "mluc", "wtpt": "XYZ ", "chad": "sf32", **{f"{channel}XYZ": "XYZ " for channel in "rgb"},
        **{f"{channel}TRC": "para" for channel in "rgb"}}


def srgb(values):
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    white = np.array([0.3127, 0.3290, 0.3583]) / 0.3290
    return linear @ (PRIMARIES * np.linalg.solve(PRIMARIES, white)).T


def monitor(values):
    return (MONITOR_GAIN * values) ** MONITOR_GAMMA @ np.linalg.inv(MONITOR).T


def to_d50(white):
    """Bradford's linear transform from white"""
    return np.linalg.inv(BRADFORD) * (BRADFORD @ D50 / (BRADFORD @ white)) @ BRADFORD


def check_form(name, profile, adaptation):
    """All data follow the table of tags, at multiples of 4, without gaps. Returns the place of each tag."""
    words = np.frombuffer(profile, ">u4")
    check(words[0] == len(profile), f"{name}: the profile records its size")
    check(profile[8:10] == b"\4\x30" and profile[12:24] == b"mntrRGB XYZ " and profile[36:40] == b"acsp",
          f"{name}: it is a display's profile, from RGB to XYZ, of version 4.3")
    check(words[17:20].tolist() == [0xF6D6, 0x10000, 0xD32D], f"{name}: its D50 is the specification's")
    end, n = 132 + 12 * len(TAGS), int(words[32])
    table = {tag.decode(): place for tag, *place in struct.iter_unpack(">4s2I", profile[132:132 + 12 * n])}
    check(n == len(table) and set(table) == set(TAGS), f"{name}: it has {len(TAGS)} tags", table)
    for tag, kind in TAGS.items():
        at, size = table[tag]
        check(at == end and profile[at:at + 8] == kind.encode() + bytes(4) and size >= 12 and at + size <= len(profile),
              f"{name}: {tag} follows, of type '{kind}'", at, size)
        end = (at + size + 3) // 4 * 4
    check(end == len(profile), f"{name}: no data follow the last tag")
    for tag, expected in ("wtpt", D50), ("chad", adaptation.ravel()):
        numbers = np.frombuffer(profile, ">i4", len(expected), table[tag][0] + 8) / 65536
        check(np.abs(numbers - expected).max() <= 0.5 / 65536 + 1e-9, f"{name}: {tag} has the numbers of D50", numbers, expected)
    return {tag: at + 8 for tag, (at, _) in table.items()}


def check_numbers(name, display, profile, place, adaptation, luminance):
    """The colorants are those of the display, and the curves (a x + b)^g of function type 1 have 1 as their largest value."""
    for i, channel in enumerate("rgb"):
        colorant, (kind, *curve) = np.frombuffer(profile, ">i4", 3, place[f"{channel}XYZ"]), struct.unpack_from(">H2x3i", profile, place[f"{channel}TRC"])
        gain, offset, gamma = display.gain[i], display.offset[i], display.gamma[i]
        expected = [*(adaptation @ display.primaries[i] / luminance), gamma, gain / (gain + offset), offset / (gain + offset)]
        seen = np.array([*colorant, *curve]) / 65536
        check(kind == 1 and np.abs(seen - expected).max() <= 0.5 / 65536 + 1e-9, f"{name}: colorant and curve of channel {channel}", kind, seen, expected)


def read_by_lcms(path):
    lines = "".join("%d %d %d\n" % tuple(value) for value in VALUES) + "q\n"
    seen = subprocess.run(["transicc", "-v0", "-n", "-t1", "-i", path, "-o", "*XYZ"], input=lines,
                          capture_output=True, text=True, check=True).stdout
    return np.array([line.split() for line in seen.split("\n") if line.strip()], float) / 100


subprocess.run(["/usr/bin/python3", "-B", "test/make/profiles.py", TMP], check=True)
for made in "srgb.icc", "own.icc", "monitor.csv":
    check(bytes_of(path_of(made)) == bytes_of(f"data/builtin/displays/{made}"), f"test/make/profiles.py makes {made} again")
stack = reference("stack.tif", "patches", "--size", "4x4")
for name, to_xyz in (("srgb", srgb), ("monitor", monitor), *((name, display.shown) for name, display in OWN_DISPLAYS.items())):
    own = OWN_DISPLAYS.get(name)
    output_of("develop", stack, "-o", path_of("picture.tif"), "--display", write(f"{name}.csv", own.text()) if own else name)
    with tifffile.TiffFile(path_of("picture.tif")) as tiff:
        profile = tiff.pages[0].tags[34675].value
    with open(path_of(f"{name}.icc"), "wb") as out:
        out.write(profile)
    white = to_xyz(np.ones(3))
    adaptation = to_d50(white / white[1])
    places = check_form(name, profile, adaptation)
    if own:
        check_numbers(name, own, profile, places, adaptation, white[1])
    expected = to_xyz(VALUES / 255) @ adaptation.T / white[1]
    seen = read_by_lcms(out.name)
    difference, of_colour = abs(seen - expected), ciede2000(*(cielab(xyz.T, D50[:, None]) for xyz in (seen, expected)))
    # Numbers of the profile are rounded to 1/65536; those of the curves can count up to three times.
    check(difference.max() < 4 / 65536, f"{name}: {len(VALUES)} colours through Little CMS "
          f"(largest difference {difference.max():.6f})")
    check(of_colour.max() < 0.1, f"{name}: Little CMS sees the colours that the display shows (largest CIEDE2000 {of_colour.max():.4f})")
done()
