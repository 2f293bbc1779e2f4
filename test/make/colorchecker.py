#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# Makes data/builtin/materials/colorchecker/*.txt and colorchecker.list again, from the measurements in the
# Debian package psychtoolbox-3-common: `test/make/colorchecker.py FOLDER` writes both into FOLDER.
# The repository keeps them; this script shows the source of each figure.
import sys

import scipy.io

from material_files import write

SOURCE = ("/usr/share/psychtoolbox-3/PsychColorimetricData/PsychColorimetricMatFiles/"
          "sur_macbeth.mat")
# The order is that of the chart and of the source's columns.
NAMES = ("dark skin, light skin, blue sky, foliage, blue flower, bluish green, orange, "
         "purplish blue, moderate red, purple, yellow green, orange yellow, blue, green, red, "
         "yellow, magenta, cyan, white, neutral 8, neutral 6.5, neutral 5, neutral 3.5, black"
         ).split(", ")
FIRST_GOOD_NM, LAST_GOOD_NM = 395, 730
HEAD = """\
# ColorChecker patch {number}, {name}: diffuse reflectance (0 to 1) by wavelength in nm.
# Source: sur_macbeth.mat (1998), column {number}, of Psychtoolbox-3 (PsychColorimetricMatFiles);
# its notes: "Reflectance of Macbeth color checker (not accurate, needs updating)". The instrument
# is not named. Rounded to 5 decimals.
# Held: the source falls to 0 below {first} nm and is 0 above {last} nm, where it has no
# measurement; the values at {first} and {last} nm stand there instead.
# Licence: Expat (MIT), see LICENSE in this folder.
"""


def file_name(number):
    return "%02d-%s" % (number, NAMES[number - 1].replace(" ", "-"))


def material(number, reflectances, wavelengths):
    lines = [HEAD.format(number=number, name=NAMES[number - 1], first=FIRST_GOOD_NM,
                         last=LAST_GOOD_NM)]
    by_wavelength = dict(zip(wavelengths, reflectances))
    for wavelength in wavelengths:
        good = min(max(wavelength, FIRST_GOOD_NM), LAST_GOOD_NM)
        lines.append("%d %.5f\n" % (wavelength, by_wavelength[good]))
    return "".join(lines)


def list_of_materials():
    return "".join(["# The 24 patches of the ColorChecker chart, row by row from the top left.\n"
                    "# Source and licence: in each file.\n",
                    *("colorchecker/%s\n" % file_name(number) for number in range(1, len(NAMES) + 1))])


def main(folder):
    source = scipy.io.loadmat(SOURCE)
    start, step, count = (int(number) for number in source["S_macbeth"][0])
    wavelengths = [start + step * index for index in range(count)]
    write(folder + "/colorchecker.list", list_of_materials())
    for number in range(1, len(NAMES) + 1):
        write("%s/colorchecker/%s.txt" % (folder, file_name(number)),
              material(number, source["sur_macbeth"][:, number - 1], wavelengths))


main(sys.argv[1])
