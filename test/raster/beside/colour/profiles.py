#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile liblcms2-utils; makes: test_profile
"""Little CMS reads the ICC profiles as intended: media-relative XYZ for D50. Prints TAP."""
import os
import subprocess

import numpy as np

from rendered import TMP, check, done

BUILD = os.environ.get("BUILD", "build")
D50 = np.array([0.9642, 1, 0.8249])
BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
# IEC 61966-2-1: linear RGB to XYZ, from the chromaticities of the primaries and of D65
PRIMARIES = np.array([[0.64, 0.30, 0.15], [0.33, 0.60, 0.06], [0.03, 0.10, 0.79]])
# the thesis's monitor: from XYZ of Y = 100; linear = (gain x value)^exponent
MONITOR = np.array([[0.03426, -0.01633, -0.005365], [-0.01026, 0.01911, 0.0002522],
                    [0.000529, -0.001811, 0.00867]])
GAIN, EXPONENT = np.array([1.035, 1.053, 1.047]), np.array([1.534, 1.393, 1.435])
VALUES = np.array([[255, 255, 255], [255, 0, 0], [0, 255, 0], [0, 0, 255], [128, 128, 128], [8, 8, 8],
                   [200, 100, 50], [1, 2, 3], [30, 60, 240], [250, 255, 245]])


def srgb(values):
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    white = np.array([0.3127, 0.3290, 0.3583]) / 0.3290
    return linear @ (PRIMARIES * np.linalg.solve(PRIMARIES, white)).T


def monitor(values):
    return (GAIN * values) ** EXPONENT @ np.linalg.inv(MONITOR).T


def beside_d50(xyz, white):
    """Adapted by Bradford's linear transform from white to D50"""
    gain = BRADFORD @ D50 / (BRADFORD @ white)
    return xyz @ (np.linalg.inv(BRADFORD) * gain @ BRADFORD).T


def read_by_lcms(path):
    lines = "".join("%d %d %d\n" % tuple(value) for value in VALUES) + "q\n"
    seen = subprocess.run(["transicc", "-v0", "-n", "-t1", "-i", path, "-o", "*XYZ"], input=lines,
                          capture_output=True, text=True, check=True).stdout
    return np.array([line.split() for line in seen.split("\n") if line.strip()], float) / 100


for name, to_xyz in (("srgb", srgb), ("monitor", monitor)):
    path = os.path.join(TMP, f"{name}.icc")
    with open(path, "wb") as out:
        subprocess.run([f"{BUILD}/test/test_profile", name], stdout=out, check=True)
    expected = beside_d50(to_xyz(VALUES / 255), to_xyz(np.ones(3)))
    difference = abs(read_by_lcms(path) - expected)
    # Numbers of the profile are rounded to 1/65536; those of the curves can count up to three times.
    check(difference.max() < 4 / 65536, f"{name}: {len(VALUES)} colours through Little CMS "
          f"(largest difference {difference.max():.6f})")
done()
