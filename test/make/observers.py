#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# Makes the CIE's observers in data/builtin/tables again, from the Debian package psychtoolbox-3-common:
# `test/make/observers.py FOLDER` writes them into FOLDER.
import sys
from decimal import Decimal

import scipy.io

from material_files import write

SOURCE = "/usr/share/psychtoolbox-3/PsychColorimetricData/PsychColorimetricMatFiles/"
HEAD = """\
# {title}.
# Columns x, y, z: {columns}.
# Unit: none; y peaks at {peak:f} (at {peak_nm} nm).
# Wavelengths: {first} to {last} nm every nm.
# Source: {source}.mat of Psychtoolbox-3 (PsychColorimetricMatFiles), in all its digits.
# Original: {original}.
# Licence: Expat (MIT), see ../materials/colorchecker/LICENSE.
wavelength_nm,x,y,z
"""
STANDARD = "CIE standard colorimetric observers (ISO/CIE 11664-1)"
FUNDAMENTAL = "CIE 170-2:2015; the source has it from www.cvrl.org, 2016"
OBSERVERS = {
    "cie1931": ("xyz1931", "CIE 1931 standard colorimetric observer (2 degrees)",
                "x, y and z colour matching functions", STANDARD),
    "cie1964": ("xyz1964", "CIE 1964 standard colorimetric observer (10 degrees)",
                "x10, y10 and z10 colour matching functions", STANDARD),
    "cie2006-2": ("xyzCIEPhys2", "CIE 2006 cone-fundamental-based observer (2 degrees)",
                  "xF, yF and zF colour matching functions", FUNDAMENTAL),
    "cie2006-10": ("xyzCIEPhys10", "CIE 2006 cone-fundamental-based observer (10 degrees)",
                   "xF,10, yF,10 and zF,10 colour matching functions", FUNDAMENTAL),
}


def table(name):
    source, title, columns, original = OBSERVERS[name]
    content = scipy.io.loadmat(SOURCE + "T_%s.mat" % source)
    first, step, count = (int(number) for number in content["S_" + source][0])
    assert step == 1
    values = [[Decimal(repr(float(value))) for value in row] for row in content["T_" + source].T]
    peak, peak_nm = max((row[1], nm) for nm, row in enumerate(values, first))
    head = HEAD.format(title=title, columns=columns, peak=peak.normalize(), peak_nm=peak_nm,
                       first=first, last=first + count - 1, source="T_" + source, original=original)
    return head + "".join("%d,%s\n" % (nm, ",".join(format(value.normalize(), "f") for value in row))
                          for nm, row in enumerate(values, first))


def main(folder):
    for name in OBSERVERS:
        write("%s/%s.csv" % (folder, name), table(name))


main(sys.argv[1])
