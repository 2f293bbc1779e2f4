#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""The tables of observers and illuminants agree with their sources. Prints TAP."""
import math
import os
import subprocess
import sys

sys.dont_write_bytecode = True
from rendered import TMP, check, done

FOLDER = "data/builtin/tables"


def table(name):
    """{nm: [value, ...]}, as written"""
    rows = [line.strip().split(",") for line in open(f"{FOLDER}/{name}.csv") if line[0].isdigit()]
    return {int(row[0]): row[1:] for row in rows}


subprocess.run(["/usr/bin/python3", "-B", "test/make/observers.py", TMP], check=True)
for name in sorted(os.listdir(TMP)):
    check(open(f"{TMP}/{name}").read() == open(f"{FOLDER}/{name}").read(),
          f"{name} equals its maker's output, digit by digit")

# CIE 15:2004, with c2 = 1.435e7 nm K and 2848 K
differing = [nm for nm, (value,) in table("a").items() if value != "%.6f" % float(
    "%.6g" % ((560 / nm) ** 5 * math.expm1(1.435e7 / (2848 * 560)) / math.expm1(1.435e7 / (2848 * nm))))]
check(not differing, f"illuminant A follows the CIE's formula {differing or ''}")

# D65 is a daylight of 6504 K: linear between every 10 nm, as the CIE defines it
d65 = {nm: float(value) for nm, (value,) in table("d65").items()}
bend = max(abs(d65[nm] - (d65[nm - 5] + d65[nm + 5]) / 2) for nm in range(305, 830, 10))
check(bend < 1.1e-5, f"D65 is linear between every 10 nm (to {bend:.6f})")
done()
