#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile python3-scipy psychtoolbox-3-common colord-data
"""The tables of observers and illuminants, the ColorChecker's materials and the models agree with their sources. Prints TAP."""
import itertools
import math
import os
import subprocess

import scipy.io

from rendered import TMP, check, done

FOLDER = "data/builtin/tables"


def table(name):
    """{nm: [value, ...]}, as written"""
    rows = [line.strip().split(",") for line in open(f"{FOLDER}/{name}.csv") if line[0].isdigit()]
    return {int(row[0]): row[1:] for row in rows}


for maker, kept in (("observers", "tables"), ("illuminants", "tables"), ("colorchecker", "materials"), ("models", "models")):
    made = f"{TMP}/{maker}"
    os.makedirs(made, exist_ok=True)
    subprocess.run(["/usr/bin/python3", "-B", f"test/make/{maker}.py", made], check=True)
    names = [os.path.relpath(os.path.join(top, name), made) for top, _, files in os.walk(made) for name in files]
    differing = [name for name in names if open(f"{made}/{name}").read() != open(f"data/builtin/{kept}/{name}").read()]
    check(names and not differing, f"the {len(names)} files of {maker}.py equal its output, digit by digit", differing)
patches = set(os.listdir("data/builtin/materials/colorchecker")) - {"LICENSE"}
check(patches == set(os.listdir(f"{TMP}/colorchecker/colorchecker")) and len(patches) == 24, "the ColorChecker has 24 patches", patches)

# CIE 15:2004, with c2 = 1.435e7 nm K and 2848 K
differing = [nm for nm, (value,) in table("a").items() if value != "%.6f" % float(
    "%.6g" % ((560 / nm) ** 5 * math.expm1(1.435e7 / (2848 * 560)) / math.expm1(1.435e7 / (2848 * nm))))]
check(not differing, f"illuminant A follows the CIE's formula {differing or ''}")

# D65 is a daylight of 6504 K: linear between every 10 nm, as the CIE defines it
d65 = {nm: float(value) for nm, (value,) in table("d65").items()}
bend = max(abs(d65[nm] - (d65[nm - 5] + d65[nm + 5]) / 2) for nm in range(305, 830, 10))
check(bend < 1.1e-5, f"D65 is linear between every 10 nm (to {bend:.6f})")

# Figures that were copied by hand are those of other publishers.
PSYCHTOOLBOX = "/usr/share/psychtoolbox-3/PsychColorimetricData/PsychColorimetricMatFiles"
VISIBLE = range(380, 785, 5)
copied = table("../../../test/make/illuminants")
components = table("../daylight/components")


def same(figures, others):
    """the wavelengths at which they differ"""
    assert len(others) == len(VISIBLE)
    return [nm for nm, other in zip(VISIBLE, others) if abs(float(figures[nm]) - other) > 1e-9]


mean = scipy.io.loadmat(f"{PSYCHTOOLBOX}/B_cieday.mat")["B_cieday"]
for i in range(3):
    differing = same({nm: row[i] for nm, row in components.items()}, mean[:, i])
    check(not differing, f"the daylight component s{i} equals Psychtoolbox's {differing or ''}")
bent = [nm for nm in range(305, 830, 10) for i in range(3) if abs(float(components[nm][i]) - (
    float(components[nm - 5][i]) + float(components[nm + 5][i])) / 2) > 1e-9]
check(not bent, f"the components are linear between every 10 nm {bent or ''}")
differing = same({nm: row[0] for nm, row in copied.items()},
                 scipy.io.loadmat(f"{PSYCHTOOLBOX}/spd_CIEC.mat")["spd_CIEC"][:, 0])
check(not differing, f"illuminant C equals Psychtoolbox's {differing or ''}")

# colord 1.4.6 has six other figures. Its F10 has x 0.3461; the CIE published 0.3458.
COLORD_DIFFERS = {"F5": [690], "F6": [625], "F9": [530], "F10": [385, 605], "F12": [390]}
for i in range(1, 13):
    sheet = open(f"/usr/share/colord/illuminant/CIE-F{i}.sp", encoding="ascii").read().split()
    begin = sheet.index("BEGIN_DATA") + 1
    differing = same({nm: row[i] for nm, row in copied.items()},
                     [100 * float(value) for value in sheet[begin:sheet.index("END_DATA")]])
    check(differing == COLORD_DIFFERS.get(f"F{i}", []), f"F{i} equals colord's, but for known figures", differing)

# Chromaticities as published: CIE 15:2004, tables T.3 and T.7; CIE 015:2018. They are sums every 5 nm.
PUBLISHED = """
    a 0.44758 0.40745  c 0.31006 0.31616  d50 0.34567 0.35851  d55 0.33243 0.34744  d65 0.31272 0.32903
    d75 0.29903 0.31488  e 0.3333 0.3333
    f1 0.3131 0.3371  f2 0.3721 0.3751  f3 0.4091 0.3941  f4 0.4402 0.4031  f5 0.3138 0.3452  f6 0.3779 0.3882
    f7 0.3129 0.3292  f8 0.3458 0.3586  f9 0.3741 0.3727  f10 0.3458 0.3588  f11 0.3805 0.3769
    f12 0.4370 0.4042
    led-b1 0.4560 0.4078  led-b2 0.4357 0.4012  led-b3 0.3756 0.3723  led-b4 0.3422 0.3502
    led-b5 0.3118 0.3236""".split()
OF_10_DEGREES = "d75 0.29968 0.31740  d65 0.31381 0.33098  a 0.45117 0.40594".split()
for eye, name, *published in (*zip(itertools.repeat("cie1931"), PUBLISHED[::3], PUBLISHED[1::3], PUBLISHED[2::3]),
                              *zip(itertools.repeat("cie1964"), OF_10_DEGREES[::3], OF_10_DEGREES[1::3], OF_10_DEGREES[2::3])):
    observer = table(eye)
    light = {nm: float(value) for nm, (value,) in table(name).items()}
    xyz = [sum(light[nm] * float(observer[nm][i]) for nm in VISIBLE) for i in range(3)]
    xy = [value / sum(xyz) for value in xyz[:2]]
    # half a unit of the last digit, and the rounding of the figures themselves
    off = max(abs(own - float(digits)) * 10 ** (len(digits) - 2) for own, digits in zip(xy, published))
    check(off < 0.6, f"{name} has the published chromaticity to {eye}", xy, published)
    check(light[560] == 1, f"{name} is 1 at 560 nm")
done()
