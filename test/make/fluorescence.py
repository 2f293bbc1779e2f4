#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# Makes data/builtin/materials/fluorescence/*.txt and fluorescence.list again, from data/builtin/tables/a.csv:
# `python3 -B test/make/fluorescence.py FOLDER` writes them into FOLDER.
import sys
from decimal import Decimal

from material_files import WAVELENGTHS, gaussian, table, write

HEAD = """\
# Fluorescence, {name}: two surfaces that are alike in every wavelength under illuminant A. Plain
# lines: reflectance (0 to 1) by wavelength in nm, without fluorescence. Lines mr and mf: the
# partner, which fluoresces; mf has excitation and emission, both relative, used as
# light x reflectance + emission x N, N = sum(light x excitation) / sum(excitation).
# MODELLED, NOT MEASURED, after {after}: the excitation is a Gaussian
# about {excited} nm, the emission one about {emitted} nm, of {peak} at its peak, with standard
# deviations of {widths} nm (excitation, emission below and above its peak).
# Both are cut at {cut} nm, so that nothing is given out at a shorter wavelength than it is taken in.
# The partner's reflectance rises from {low} to {high} about {edge} nm. Plain reflectance = the partner's
# + emission x N / light under A (data/builtin/tables/a.csv, 300 to 760 nm every 5 nm), to 15 decimals.
# Licence: MIT. Made by test/make/fluorescence.py.
"""
# name: its model; nm of the peaks of excitation and emission; standard deviations of
# the excitation and of the emission below and above its peak; nm of the cut; highest emission;
# reflectance far below and far above an edge at a wavelength, and the steepness of that edge in nm.
PAIRS = {
    "white": ("paper with an optical brightener", 355, 440, (28, 14, 28), 415, "0.92",
              ("0.06", "0.72", 400, 9)),
    "blue": ("quinine on a grey ground", 350, 455, (28, 22, 36), 410, "0.58",
             ("0.10", "0.20", 430, 12)),
    "green": ("a zinc sulphide pigment", 375, 525, (32, 24, 32), 450, "0.68",
              ("0.08", "0.25", 430, 12)),
    "yellow": ("a daylight yellow pigment", 410, 525, (32, 14, 34), 490, "0.8",
               ("0.08", "0.60", 490, 12)),
    "orange": ("a daylight orange pigment", 430, 595, (45, 14, 32), 550, "0.9",
               ("0.06", "0.60", 570, 12)),
    "red": ("a europium complex", 355, 614, (24, 5, 6), 560, "1.7",
            ("0.15", "0.30", 420, 12)),
}


def flank(nm, peak, below, above):
    return gaussian(nm, peak, below if nm < peak else above)


def edge(nm, low, high, centre, steepness):
    rise = 1 + (Decimal(centre - nm) / steepness).exp()
    return Decimal(low) + (Decimal(high) - Decimal(low)) / rise


def material(name):
    after, excited, emitted, widths, cut, peak, step = PAIRS[name]
    light = {nm: row[0] for nm, row in table("data/builtin/tables/a.csv").items()}
    digits = Decimal("0.0001")
    excitation, emission, partner = {}, {}, {}
    for nm in WAVELENGTHS:
        below, above = gaussian(nm, excited, widths[0]), flank(nm, emitted, *widths[1:])
        excitation[nm] = (below if nm < cut else Decimal(0)).quantize(digits)
        emission[nm] = (Decimal(peak) * above if nm >= cut else Decimal(0)).quantize(digits)
        partner[nm] = edge(nm, *step).quantize(digits)
    excited_mean = (sum(light[nm] * excitation[nm] for nm in WAVELENGTHS)
                    / sum(excitation.values()))
    plain = {nm: partner[nm] + emission[nm] * excited_mean / light[nm] for nm in WAVELENGTHS}
    head = HEAD.format(name=name, after=after, excited=excited, emitted=emitted, cut=cut, peak=peak,
                       widths="%d, %d and %d" % widths, low=step[0], high=step[1], edge=step[2])
    return (head + "".join("%d %.15f\n" % (nm, plain[nm]) for nm in WAVELENGTHS) +
            "".join("mr %d %s\n" % (nm, partner[nm]) for nm in WAVELENGTHS) +
            "".join("mf %d %s %s\n" % (nm, excitation[nm], emission[nm]) for nm in WAVELENGTHS))


def main(folder):
    write(folder + "/fluorescence.list",
          "# Pairs with the same radiance in every band under illuminant A. One of each pair fluoresces.\n"
          "# How they are modelled, and the licence: in each file.\n",
          *("fluorescence/%s\n" % name for name in PAIRS))
    for name in PAIRS:
        write("%s/fluorescence/%s.txt" % (folder, name), material(name))


main(sys.argv[1])
