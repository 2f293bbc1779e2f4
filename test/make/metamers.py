#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# Makes data/builtin/materials/metamers/* again, from data/builtin/tables and the ColorChecker:
# `python3 -B test/make/metamers.py FOLDER` writes them into FOLDER/metamers.
import sys
from decimal import Decimal

from material_files import WAVELENGTHS, gaussian, table, thesis_observer, write

SETS = {"illuminant": "they differ under illuminant A and under the fluorescent tube",
        "observer": "the DCS200 camera and the transparency film see them differ"}
HEAD = """\
# Metamers {number} of the set '{set}', {name}: reflectance (0 to 1) by wavelength in nm. Plain
# lines are one surface, mr lines its partner. To the CIE 1931 observer both are alike under D65
# (data/builtin/tables): exactly as the thesis prints it in 4 decimals, within 0.01 CIEDE2000 in all digits;
# {difference}.
# The plain one is {base}.
# Its partner is the same plus a metameric black, which D65 and the observer see as 0 (J. B. Cohen
# and W. E. Kappauf, Metameric color stimuli, fundamental metamers, and Wyszecki's metameric blacks,
# Am. J. Psychol. 95, 537-564 (1982)): Gaussians of standard deviation {deviation} nm about
# {centres} nm; the first is {height} high, the heights of the others follow from
# the three sums of D65 x black x observer over 300 to 760 nm every 5 nm, all 0. 13 decimals keep
# the sums 0. Computed, not measured.
# Licence: {licence}. Made by test/make/metamers.py.
"""
GREY = Decimal("0.3")
# name, ColorChecker patch (None: grey), deviation and centres of the Gaussians, height of the first:
# chosen by a search for differences of about 10 CIEDE2000 with Gaussians as wide as possible.
PAIRS = {
    "illuminant": (
        ("grey", None, 40, (405, 500, 565, 610), "0.40"),
        ("light-skin", 2, 22, (440, 495, 550, 590), "-0.22"),
        ("blue-sky", 3, 40, (425, 495, 555, 625), "-0.36"),
        ("foliage", 4, 22, (480, 510, 530, 620), "-0.12"),
        ("blue-flower", 5, 35, (410, 495, 565, 615), "0.46"),
        ("purplish-blue", 8, 25, (430, 480, 530, 675), "-0.40"),
    ),
    "observer": (
        ("grey", None, 40, (425, 500, 570, 635), "-0.34"),
        ("light-skin", 2, 40, (435, 500, 570, 640), "0.30"),
        ("blue-sky", 3, 45, (420, 500, 560, 640), "-0.31"),
        ("foliage", 4, 40, (485, 515, 560, 625), "-0.20"),
        ("bluish-green", 6, 40, (435, 505, 570, 635), "-0.25"),
        ("green", 14, 35, (480, 515, 565, 625), "-0.19"),
    ),
}


def determinant(a, b, c):
    return (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0]))


def black(deviation, centres, height):
    """{nm: value} of the metameric black: Gaussians that D65 and the observer see as 0"""
    light, observer = table("data/builtin/tables/d65.csv"), thesis_observer()
    bumps = [{nm: gaussian(nm, centre, deviation) for nm in WAVELENGTHS} for centre in centres]
    first, *others = [[sum(light[nm][0] * bump[nm] * observer[nm][i] for nm in WAVELENGTHS)
                       for i in range(3)] for bump in bumps]
    wanted = [-Decimal(height) * value for value in first]
    heights = [Decimal(height)]
    for column in range(3): # Cramer's rule
        replaced = others[:column] + [wanted] + others[column + 1:]
        heights.append(determinant(*replaced) / determinant(*others))
    return {nm: sum(h * bump[nm] for h, bump in zip(heights, bumps)) for nm in WAVELENGTHS}


def surface(name, patch):
    """The plain surface: {nm: reflectance}, description, licence"""
    if patch is None:
        return ({nm: GREY for nm in WAVELENGTHS}, "a grey of 30 %, as in the 1998 thesis",
                "MIT")
    file = "colorchecker/%02d-%s.txt" % (patch, name)
    values = table("data/builtin/materials/" + file, None)
    held = {nm: values[max(nm, min(values))][0] for nm in WAVELENGTHS}
    return (held, "data/builtin/materials/%s, its source there" % file,
            "Expat (MIT), see ../colorchecker/LICENSE")


def material(kind, number):
    name, patch, deviation, centres, height = PAIRS[kind][number - 1]
    plain, base, licence = surface(name, patch)
    added = black(deviation, centres, height)
    head = HEAD.format(number=number, set=kind, name=name.replace("-", " "), base=base,
                       difference=SETS[kind], deviation=deviation, height=height, licence=licence,
                       centres="%d, %d, %d and %d" % centres)
    return (head + "".join("%d %.5f\n" % (nm, plain[nm]) for nm in WAVELENGTHS) +
            "".join("mr %d %.13f\n" % (nm, plain[nm] + added[nm]) for nm in WAVELENGTHS))


def main(folder):
    for kind, pairs in PAIRS.items():
        names = ["metamers/%s-%d-%s" % (kind, number, pair[0]) for number, pair in enumerate(pairs, 1)]
        write("%s/metamers/%s.list" % (folder, kind),
              "# Pairs alike to the CIE 1931 observer under D65;\n# %s.\n" % SETS[kind],
              "# Source and licence: in each file.\n", *(name + "\n" for name in names))
        for number, name in enumerate(names, 1):
            write("%s/%s.txt" % (folder, name), material(kind, number))


main(sys.argv[1])
