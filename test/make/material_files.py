# SPDX-License-Identifier: MIT
# Shared by the makers of built-in files. Those of materials compute in decimal, so that they write the same digits
# on every machine.
import decimal
import os

decimal.getcontext().prec = 40
WAVELENGTHS = range(300, 765, 5)


def table(path, separator=","):
    """{nm: (value, ...)} of a text of numbers"""
    with open(path, encoding="ascii") as source:
        rows = [line.split(separator) for line in source if line[0].isdigit()]
    return {int(row[0]): tuple(decimal.Decimal(value) for value in row[1:]) for row in rows}


def thesis_observer():
    """{nm: (x, y, z)}: the CIE 1931 observer as the 1998 thesis prints it: in 4 decimals, 0 below 380 nm,
    and the figures of 750 nm up to 760 nm"""
    cie, digits = table("data/builtin/tables/cie1931.csv"), decimal.Decimal("0.0001")
    return {nm: tuple(value.quantize(digits) * (nm >= 380) for value in cie[min(max(nm, 380), 750)])
            for nm in WAVELENGTHS}


def gaussian(nm, centre, deviation):
    return (-((nm - decimal.Decimal(centre)) / deviation) ** 2 / 2).exp()


def write(path, *texts):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="ascii") as out:
        out.writelines(texts)
