#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# Makes data/builtin/materials/metals/*.txt and metals.list again, from the optical constants in metals.csv:
# `python3 -B test/make/metals.py FOLDER` writes both into FOLDER.
import sys
from decimal import Decimal

from material_files import WAVELENGTHS, write

DIFFUSE_SHARE = Decimal("0.06")
GLOSS = 36
JOHNSON = ("P. B. Johnson and R. W. Christy, Optical constants of the noble metals,\n"
           "# Phys. Rev. B 6, 4370-4379 (1972), room temperature")
RAKIC = ("A. D. Rakic, Algorithm for the determination of intrinsic optical constants of metal\n"
         "# films: application to aluminum, Appl. Opt. 34, 4755-4767 (1995)")
HEAD = """\
# {title}, polished but slightly rough: reflectance (0 to 1) by wavelength in nm.
# A plane surface reflects R = ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2) at normal incidence. {diffuse} % of
# R is diffuse here and {specular} % specular (lines s), with the gloss {gloss}: all three are chosen, not
# measured. n and k are interpolated linearly; R is rounded to 5 decimals.
# Source: {source};
# its n and k as in the refractiveindex.info database (main/{symbol}/nk/{page}.yml).
# Licence: CC0 1.0, as the database. Made by test/make/metals.py.
"""

# name: symbol, source, page of the database
METALS = {
    "aluminium": ("Al", RAKIC, "Rakic"),
    "copper": ("Cu", JOHNSON, "Johnson"),
    "gold": ("Au", JOHNSON, "Johnson"),
    "silver": ("Ag", JOHNSON, "Johnson"),
}


def constants(name):
    """[micrometres, n, k] of each row of metals.csv for a metal"""
    with open("test/make/metals.csv", encoding="ascii") as source:
        rows = [line.split(",") for line in source]
    return [[Decimal(figure) for figure in row[1:]] for row in rows if row[0] == name]


def reflectance(nm, rows):
    above = next(index for index, row in enumerate(rows) if row[0] * 1000 > nm)
    (lower, n0, k0), (upper, n1, k1) = rows[above - 1:above + 1]
    t = (Decimal(nm) / 1000 - lower) / (upper - lower)
    n, k = n0 + t * (n1 - n0), k0 + t * (k1 - k0)
    return ((n - 1) ** 2 + k ** 2) / ((n + 1) ** 2 + k ** 2)


def material(name):
    symbol, source, page = METALS[name]
    rows = constants(name)
    spectrum = {nm: reflectance(nm, rows) for nm in WAVELENGTHS}
    head = HEAD.format(title=name.capitalize(), diffuse=round(100 * DIFFUSE_SHARE),
                       specular=round(100 * (1 - DIFFUSE_SHARE)), gloss=GLOSS, source=source,
                       symbol=symbol, page=page)
    return (head + "g %d\n" % GLOSS +
            "".join("%d %.5f\n" % (nm, DIFFUSE_SHARE * r) for nm, r in spectrum.items()) +
            "".join("s %d %.5f\n" % (nm, (1 - DIFFUSE_SHARE) * r) for nm, r in spectrum.items()))


def main(folder):
    write(folder + "/metals.list", "# Four polished metals. Source and licence: in each file.\n",
          *("metals/%s\n" % name for name in METALS))
    for name in METALS:
        write("%s/metals/%s.txt" % (folder, name), material(name))


main(sys.argv[1])
