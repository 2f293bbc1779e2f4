#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# Makes the CIE illuminants in data/builtin/tables again, but for a and d65, which are the thesis's:
# `test/make/illuminants.py FOLDER` writes them into FOLDER. Daylights come from
# data/builtin/daylight/components.csv, the others from illuminants.csv beside this script.
import os
import sys
from decimal import Context, Decimal

from material_files import write

HERE = os.path.dirname(os.path.abspath(__file__))
COMPONENTS = HERE + "/../../data/builtin/daylight/components.csv"
HEAD = """\
# CIE {title}.
# Unit: relative spectral power, 1.0 at 560 nm.{reaches}
# Wavelengths: {first} to {last} nm every 5 nm.
# Source: {source}.
# Original: {original}.
# Licence: {licence}.
wavelength_nm,power
"""
FACTS = "figures published as facts; no claim is made on them"
DAYLIGHTS = {"d50": 5000, "d55": 5500, "d75": 7500}
COLOUR = ("sds.py of Colour (colour-science), whose figures test/make/illuminants.csv keeps,\n"
          "# divided by that at 560 nm, {figure}, in 6 digits", "BSD 3-Clause, see ../daylight/LICENSE")
LAMPS = {
    "c": ("illuminant C: average daylight, as an incandescent lamp behind a filter", "CIE 15:2004"),
    **{f"f{i}": (f"illuminant FL{i}: a fluorescent lamp {kind} of {kelvin} K", "CIE 15:2004")
       for i, (kind, kelvin) in enumerate(
           [("of the standard kind,", kelvin) for kelvin in (6430, 4230, 3450, 2940, 6350, 4150)] +
           [("with a broad spectrum,", kelvin) for kelvin in (6500, 5000, 4150)] +
           [("with three narrow bands,", kelvin) for kelvin in (5000, 4000, 3000)], 1)},
    **{f"led-b{i}": (f"illuminant LED-B{i}: a blue LED with a phosphor, of {kelvin} K", "CIE 015:2018")
       for i, kelvin in enumerate((2733, 2998, 4103, 5109, 6598), 1)},
}


def columns(path):
    """{name: {nm: figure as written}}, without empty fields"""
    lines = [line.strip().split(",") for line in open(path, encoding="ascii") if line[0] != "#"]
    return {name: {int(row[0]): row[i] for row in lines[1:] if row[i]}
            for i, name in enumerate(lines[0]) if i > 0}


def daylight(kelvin, components):
    """The CIE's recipe in exact decimals: M1 and M2 have three. The nominal temperatures are older
    than today's second radiation constant, 1.4388 for 1.4380 cm K."""
    t = float(kelvin) * 1.4388 / 1.4380
    x = (-4.6070e9 / t**3 + 2.9678e6 / t**2 + 0.09911e3 / t + 0.244063 if t <= 7000 else
         -2.0064e9 / t**3 + 1.9018e6 / t**2 + 0.24748e3 / t + 0.237040)
    y = -3.000 * x * x + 2.870 * x - 0.275
    m = 0.0241 + 0.2562 * x - 0.7341 * y
    m1 = Decimal("%.3f" % ((-1.3515 - 1.7703 * x + 5.9114 * y) / m))
    m2 = Decimal("%.3f" % ((0.0300 - 31.4424 * x + 30.0717 * y) / m))
    s0, s1, s2 = ({nm: Decimal(figure) for nm, figure in components[name].items()}
                  for name in ("s0", "s1", "s2"))
    return m1, m2, {nm: (s0[nm] + m1 * s1[nm] + m2 * s2[nm]) / 100 for nm in s0}


def text(values, **head):
    largest = max(values, key=lambda nm: values[nm])
    reaches = ("" if values[largest] < 5 else f" The line at {largest} nm\n"
               f"# reaches {values[largest]:.2f}, so the table exceeds 1: that is no mistake.")
    return HEAD.format(first=min(values), last=max(values), reaches=reaches, **head) + "".join(
        "%d,%s\n" % (nm, format(value.normalize(), "f")) for nm, value in values.items())


def main(folder):
    tables = {"e": text({nm: Decimal(1) for nm in range(300, 835, 5)},
                        title="illuminant E: equal energy", source="its definition",
                        original="CIE 15", licence=FACTS)}
    for name, kelvin in DAYLIGHTS.items():
        m1, m2, values = daylight(kelvin, columns(COMPONENTS))
        tables[name] = text(
            values, title=f"illuminant {name.upper()}: daylight of about {kelvin} K",
            source=f"../daylight/components.csv, as the CIE prescribes, with M1 {m1} and M2 {m2}",
            original="CIE 15, Colorimetry", licence=FACTS)
    for name, figures in columns(HERE + "/illuminants.csv").items():
        title, original = LAMPS[name]
        six = Context(prec=6)
        values = {nm: six.divide(Decimal(figure), Decimal(figures[560]))
                  for nm, figure in figures.items()}
        tables[name] = text(values, title=title, source=COLOUR[0].format(figure=figures[560]),
                            original=original + ", Colorimetry", licence=COLOUR[1])
    for name, content in tables.items():
        write(f"{folder}/{name}.csv", content)


main(sys.argv[1])
