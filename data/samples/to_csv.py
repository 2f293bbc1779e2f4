#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Turns spectra of other formats into a table that spectral reads: a wavelength in nm and the values of each sample a row.

    python3 to_csv.py FILE [NUMBER] > TABLE.csv

It reads JCAMP-DX 4.24 and 5 (XYDATA of numbers with blanks, commas or signs between them, and XYPOINTS), CxF3, and tables of
pairs of columns: a wavelength and a value, side by side for each sample (Cary, spreadsheets), or pair after pair in a line
(pbrt). Units of wavelengths, wavenumbers, frequencies and energies become nm; percent, and absorbance as 10 to the power of
-A, become a fraction of 1. Samples with different
wavelengths are written one at a time, by their numbers. A file that it does not understand in full is refused. It needs Python alone."""
import csv
import re
import sys
import xml.etree.ElementTree

# nm of a value in this unit
UNITS = {"nanometers": lambda x: x, "nm": lambda x: x, "micrometers": lambda x: 1e3 * x, "microns": lambda x: 1e3 * x, "um": lambda x: 1e3 * x,
         "angstroms": lambda x: x / 10, "1/cm": lambda x: 1e7 / x, "cm-1": lambda x: 1e7 / x, "thz": lambda x: 299792.458 / x,
         "ev": lambda x: 1239.841984 / x}
QUANTITIES = {"reflectance": lambda y: y, "transmittance": lambda y: y, "percent reflectance": lambda y: y / 100, "% reflectance": lambda y: y / 100,
              "%r": lambda y: y / 100, "percent transmittance": lambda y: y / 100, "% transmittance": lambda y: y / 100, "%t": lambda y: y / 100,
              "absorbance": lambda y: 10 ** -y, "log(1/r)": lambda y: 10 ** -y}
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def refuse(why):
    sys.exit(f"to_csv.py: {sys.argv[1]}: {why}")


def known(table, word, what):
    return table.get(" ".join(word.lower().split())) or refuse(f"{what} {word!r}; known are {', '.join(table)}")


def numbers(line):
    """The numbers of a line, which hold all that it says."""
    if re.sub(r"[\s,;]", "", NUMBER.sub("", line)):
        refuse(f"numbers with letters, as in {line.strip()[:40]!r}, are a compressed form that is not read")
    return [float(number) for number in NUMBER.findall(line)]


def jcamp(text):
    """[(name, [(nm, value), ...])]"""
    blocks, samples = re.split(r"(?mi)^##TITLE=", text)[1:], []
    for block in blocks:
        fields = [re.split("=", field, maxsplit=1) for field in re.split(r"(?m)^##", re.sub(r"\$\$.*", "", "TITLE=" + block))]
        value = {re.sub(r"[\s\-_/]", "", field[0]).upper(): field[1].strip() for field in fields if len(field) == 2}
        data = value.get("XYDATA") or value.get("XYPOINTS")
        if data is None:
            continue
        to_nm, to_fraction = known(UNITS, value.get("XUNITS", ""), "XUNITS"), known(QUANTITIES, value.get("YUNITS", ""), "YUNITS")
        x_factor, y_factor = float(value.get("XFACTOR", 1)), float(value.get("YFACTOR", 1))
        form, *lines = data.splitlines()
        points = []
        if "XYDATA" in value:
            ys = [y for line in lines for y in numbers(line)[1:]]
            first, last = float(value["FIRSTX"]), float(value["LASTX"])
            points = [(first + (last - first) * i / max(len(ys) - 1, 1), y) for i, y in enumerate(ys)]
        else:
            flat = numbers(" ".join(lines))
            points = [(x * x_factor, y) for x, y in zip(flat[::2], flat[1::2])]
        if int(float(value.get("NPOINTS", len(points)))) != len(points):
            refuse(f"NPOINTS is {value['NPOINTS']}, but {form.strip()} has {len(points)}")
        samples.append((value["TITLE"], [(to_nm(x), to_fraction(y * y_factor)) for x, y in points]))
    return samples


def cxf(text):
    samples = []
    for element in xml.etree.ElementTree.fromstring(text).iter():
        if element.tag.endswith("}ReflectanceSpectrum"):
            values = numbers(element.text)
            start, step = float(element.get("StartWL")), float(element.get("Increment", 10))
            samples.append((element.get("Name") or f"{len(samples) + 1}", [(start + i * step, y) for i, y in enumerate(values)]))
    return samples


def pairs(text):
    """A heading names the columns of pairs; without one, lines hold pair after pair of one sample."""
    rows = [row for row in csv.reader(text.splitlines(), delimiter=";" if ";" in text else "," if "," in text else "\t" if "\t" in text else " ",
                                      skipinitialspace=True) if any(row) and not row[0].startswith("#")]
    heads = [row for row in rows if not NUMBER.fullmatch(row[0].strip().replace(",", "."))]
    rows = [[cell.strip().replace(",", ".") for cell in row] for row in rows if row not in heads]
    if not rows or len(rows[0]) % 2:
        refuse("neither JCAMP-DX, nor CxF, nor pairs of columns")
    if not heads:
        return [("1", [(float(x), float(y)) for row in rows for x, y in zip(row[::2], row[1::2])])]
    names = heads[0] + [""] * len(rows[0])
    return [(names[i] if len(heads) > 1 and names[i] else names[i + 1], [(float(row[i]), float(row[i + 1])) for row in rows if row[i + 1:] and row[i]])
            for i in range(0, len(rows[0]), 2)]


def main():
    text = open(sys.argv[1], encoding="utf-8-sig", errors="replace").read()
    samples = jcamp(text) if text.lstrip().startswith("##") else cxf(text) if text.lstrip().startswith("<") else pairs(text)
    if not samples:
        refuse("no spectra")
    grids = [sorted(x for x, _ in points) for _, points in samples]
    if any(grid != grids[0] for grid in grids):
        if len(sys.argv) < 3:
            refuse(f"its samples have different wavelengths; give the number of one: {', '.join(f'{i + 1} {name}' for i, (name, _) in enumerate(samples))}")
        if not (sys.argv[2].isdigit() and 0 < int(sys.argv[2]) <= len(samples)):
            refuse(f"no sample {sys.argv[2]}; expected a number from 1 to {len(samples)}")
        samples = [samples[int(sys.argv[2]) - 1]]
    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(["wavelength (nm)"] + [name for name, _ in samples])
    for row in zip(*(sorted(points) for _, points in samples)):
        out.writerow([f"{row[0][0]:.10g}"] + [f"{value:.10g}" for _, value in row])


main()
