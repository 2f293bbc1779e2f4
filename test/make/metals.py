#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# Makes data/builtin/materials/metals/*.txt and metals.list again, from the optical constants below:
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

# name: symbol, source, page of the database, rows of micrometres, n and k, digit by digit
METALS = {
    "aluminium": ("Al", RAKIC, "Rakic", """
        2.4797E-01 1.8137E-01 2.9029E+00
        3.0996E-01 2.8003E-01 3.7081E+00
        3.2628E-01 3.1474E-01 3.9165E+00
        3.6466E-01 3.9877E-01 4.3957E+00
        4.1328E-01 5.2135E-01 5.0008E+00
        4.4280E-01 6.0790E-01 5.3676E+00
        4.7687E-01 7.2780E-01 5.7781E+00
        5.1660E-01 8.7340E-01 6.2418E+00
        5.6357E-01 1.0728E+00 6.7839E+00
        6.1993E-01 1.3660E+00 7.4052E+00
        6.5225E-01 1.5724E+00 7.7354E+00
        6.8881E-01 1.8301E+00 8.0601E+00
        7.2932E-01 2.1606E+00 8.3565E+00
        7.7491E-01 2.6154E+00 8.4914E+00"""),
    "copper": ("Cu", JOHNSON, "Johnson", """
        0.2924 1.42 1.633
        0.3009 1.40 1.679
        0.3107 1.38 1.729
        0.3204 1.38 1.783
        0.3315 1.34 1.821
        0.3425 1.36 1.864
        0.3542 1.37 1.916
        0.3679 1.36 1.975
        0.3815 1.33 2.045
        0.3974 1.32 2.116
        0.4133 1.28 2.207
        0.4305 1.25 2.305
        0.4509 1.24 2.397
        0.4714 1.25 2.483
        0.4959 1.22 2.564
        0.5209 1.18 2.608
        0.5486 1.02 2.577
        0.5821 0.70 2.704
        0.6168 0.30 3.205
        0.6595 0.22 3.747
        0.7045 0.21 4.205
        0.7560 0.24 4.665
        0.8211 0.26 5.180"""),
    "gold": ("Au", JOHNSON, "Johnson", """
        0.2924 1.49 1.878
        0.3009 1.53 1.889
        0.3107 1.53 1.893
        0.3204 1.54 1.898
        0.3315 1.48 1.883
        0.3425 1.48 1.871
        0.3542 1.50 1.866
        0.3679 1.48 1.895
        0.3815 1.46 1.933
        0.3974 1.47 1.952
        0.4133 1.46 1.958
        0.4305 1.45 1.948
        0.4509 1.38 1.914
        0.4714 1.31 1.849
        0.4959 1.04 1.833
        0.5209 0.62 2.081
        0.5486 0.43 2.455
        0.5821 0.29 2.863
        0.6168 0.21 3.272
        0.6595 0.14 3.697
        0.7045 0.13 4.103
        0.7560 0.14 4.542
        0.8211 0.16 5.083"""),
    "silver": ("Ag", JOHNSON, "Johnson", """
        0.2924 1.39 1.161
        0.3009 1.34 0.964
        0.3107 1.13 0.616
        0.3204 0.81 0.392
        0.3315 0.17 0.829
        0.3425 0.14 1.142
        0.3542 0.10 1.419
        0.3679 0.07 1.657
        0.3815 0.05 1.864
        0.3974 0.05 2.070
        0.4133 0.05 2.275
        0.4305 0.04 2.462
        0.4509 0.04 2.657
        0.4714 0.05 2.869
        0.4959 0.05 3.093
        0.5209 0.05 3.324
        0.5486 0.06 3.586
        0.5821 0.05 3.858
        0.6168 0.06 4.152
        0.6595 0.05 4.483
        0.7045 0.04 4.838
        0.7560 0.03 5.242
        0.8211 0.04 5.727"""),
}


def reflectance(nm, rows):
    above = next(index for index, row in enumerate(rows) if row[0] * 1000 > nm)
    (lower, n0, k0), (upper, n1, k1) = rows[above - 1:above + 1]
    t = (Decimal(nm) / 1000 - lower) / (upper - lower)
    n, k = n0 + t * (n1 - n0), k0 + t * (k1 - k0)
    return ((n - 1) ** 2 + k ** 2) / ((n + 1) ** 2 + k ** 2)


def material(name):
    symbol, source, page, text = METALS[name]
    rows = [[Decimal(word) for word in line.split()] for line in text.split("\n")[1:]]
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
