#!/usr/bin/env -S PYTHONPATH=test/shared:test/make /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Checks the sample materials: metals, metamers and fluorescent pairs. Their files equal the output of their
makers, and their claims are recomputed from the digits in the files and from data/builtin/tables. Colours
are compared by CIEDE2000, which compare.py finds equal to the program's, and test_colour.c that to published pairs. Prints TAP."""
import os
import subprocess

import numpy as np

from colours import cielab, ciede2000
from rendered import SPECTRAL, TMP, built_in, check, done

from material_files import thesis_observer

FOLDER = "data/builtin/materials"
NM = np.arange(300.0, 765.0, 5.0)
VISIBLE_DIFFERENCE = 5 # CIEDE2000


def table(name):
    nm, *columns = built_in(name)
    return np.array([np.interp(NM, nm, column, left=0, right=0) for column in columns])


LIGHT = {name: table(name)[0] for name in ("d65", "a", "fluorescent", "uv")}
OBSERVER = {name: table(name) for name in ("cie1931", "dcs200-camera", "transparency-film")}
THESIS_OBSERVER = np.array([thesis_observer()[nm] for nm in NM], float).T
# IEC 61966-2-1, linear sRGB to XYZ
FROM_SRGB = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def material(path):
    """{kind: columns} of a material file; kind '' is the diffuse reflectance"""
    rows = {}
    for line in open(path, encoding="ascii"):
        words = line.split("#")[0].split()
        if words:
            kind = "" if words[0][0].isdigit() else words.pop(0)
            rows.setdefault(kind, []).append([float(word) for word in words])
    columns = {kind: np.array(values).T for kind, values in rows.items()}
    for kind, values in columns.items():
        assert kind == "g" or np.array_equal(values[0], NM), (path, kind)
    return {kind: values if kind == "g" else values[1:] for kind, values in columns.items()}


def listed(name):
    path = f"{FOLDER}/{name}.list"
    names = [line.strip() for line in open(path, encoding="ascii") if line[0] != "#"]
    return [f"{FOLDER}/{name}.txt" for name in names]


# ---- colour differences ----

def colour(stimulus, light, observer):
    """CIELAB; a camera's channels are shown as linear sRGB"""
    seen, white = OBSERVER[observer] @ stimulus, OBSERVER[observer] @ LIGHT[light]
    if observer != "cie1931":
        seen, white = FROM_SRGB @ np.maximum(seen / white, 0), FROM_SRGB.sum(1)
    return cielab(seen, white)


def difference(one, two, light, observer):
    return ciede2000(colour(one, light, observer), colour(two, light, observer))


# ---- the materials ----

def check_made():
    for name in ("metals", "metamers", "fluorescence"):
        subprocess.run(["/usr/bin/python3", "-B", f"test/make/{name}.py", TMP], check=True)
    made = {os.path.relpath(os.path.join(folder, file), TMP)
            for folder, _, files in os.walk(TMP) for file in files}
    kept = {os.path.relpath(os.path.join(FOLDER, folder, file), FOLDER)
            for folder in ("metals", "metamers", "fluorescence")
            for file in os.listdir(f"{FOLDER}/{folder}")} | {"metals.list", "fluorescence.list"}
    check(made == kept, f"the makers write the {len(kept)} files that are kept and no others")
    differing = [name for name in sorted(made & kept)
                 if open(f"{TMP}/{name}").read() != open(f"{FOLDER}/{name}").read()]
    check(not differing, f"each file equals its maker's digit by digit {differing or ''}")
    named = {os.path.relpath(path, FOLDER) for name in
             ("metals", "fluorescence", "metamers/illuminant", "metamers/observer")
             for path in listed(name)}
    check(named == {name for name in kept if name.endswith(".txt")}, "the lists name all files")


# Wavelength, n and k of other films than those of the sample metals: S. Babar and J. H. Weaver,
# Optical constants of Cu, Ag, and Au revisited, Appl. Opt. 54, 477-481 (2015); F. Cheng et al., ACS
# Nano 10, 9852-9860 (2016), supporting information (aluminium); both from refractiveindex.info, CC0.
# Two such measurements differ by up to 0.05 in reflectance, more at the steep edges (gold 500 nm,
# copper 570 nm), which are left out.
OTHER_FILMS = {
    "gold": ((442.8, 1.486, 1.797), (652.5, 0.1091, 3.529), (729.3, 0.07661, 4.242)),
    "copper": ((442.8, 1.168, 2.299), (652.5, 0.08780, 3.759), (729.3, 0.06434, 4.507)),
    "silver": ((442.8, 0.052, 2.604), (652.5, 0.04964, 4.432), (729.3, 0.05151, 5.048)),
    "aluminium": ((450.85, 0.39158, 4.30538), (548.60, 0.58716, 5.26268), (700.48, 1.17210, 6.64536)),
}


def check_metals():
    total = {}
    for path in listed("metals"):
        name = os.path.basename(path)[:-4]
        values = material(path)
        diffuse, specular = values[""][0], values["s"][0]
        total[name] = diffuse + specular
        check(diffuse.min() > 0 and total[name].max() < 1 and
              abs(diffuse / total[name] - 0.06).max() < 1e-4 and values["g"] == 36,
              f"{name}: 6 % of its reflection is diffuse, and it never reflects more than it receives "
              f"(at most {total[name].max():.5f})")
        for nm, n, k in OTHER_FILMS[name]:
            other = abs((n - 1 + 1j * k) / (n + 1 + 1j * k)) ** 2
            here = np.interp(nm, NM, total[name])
            check(abs(here - other) < 0.05,
                  f"{name} at {nm:g} nm: {here:.3f}, another film {other:.3f}")
    at = {name: dict(zip(NM, values)) for name, values in total.items()}
    check(at["gold"][700] > 0.95 and at["gold"][450] < 0.45, "gold reflects red, not blue")
    check(at["copper"][550] < at["gold"][550] - 0.1 and at["copper"][700] > 0.95,
          "copper's edge lies at longer wavelengths than gold's")
    check(at["silver"][320] < 0.2 and min(at["silver"][nm] for nm in NM if nm >= 400) > 0.95,
          "silver reflects little of the ultraviolet of 320 nm, but more than 95 % of visible light")
    # bare aluminium in the standard specifications of Rocky Mountain Instrument's mirror coatings
    check(all(abs(at["aluminium"][nm] - r) < 0.005 for nm, r in ((500, 0.918), (550, 0.915), (600, 0.911))),
          "aluminium at 500, 550 and 600 nm agrees with specifications of mirror coatings")
    plan = subprocess.run([SPECTRAL, "plan", f"{FOLDER}/metals.list"], capture_output=True, text=True)
    check(plan.returncode == 0 and "specular          yes (4 of " in plan.stdout,
          "the program reads the four metals and draws their highlights")


def check_metamers(name, broken):
    response = (LIGHT["d65"] * THESIS_OBSERVER).T
    matrix_r = response @ np.linalg.inv(response.T @ response) @ response.T # Cohen and Kappauf's
    for path in listed(f"metamers/{name}"):
        values = material(path)
        pair = values[""][0], values["mr"][0]
        label = f"{name} {os.path.basename(path)[len(name) + 1:-4]}"
        check(min(map(np.min, pair)) >= 0.01 and max(map(np.max, pair)) <= 0.95,
              f"{label}: reflectances within 0.01 and 0.95 ({min(map(np.min, pair)):.3f} to "
              f"{max(map(np.max, pair)):.3f})")
        plain, partner = (response.T @ reflectance for reflectance in pair)
        check(abs(partner / plain - 1).max() < 1e-9,
              f"{label}: XYZ equal under D65 (to {abs(partner / plain - 1).max():.1e})")
        delta = difference(*(LIGHT["d65"] * reflectance for reflectance in pair), "d65", "cie1931")
        check(delta < 0.01, f"{label}: equal also for the observer in all its digits: CIEDE2000 {delta:.4f}")
        black = pair[1] - pair[0]
        check(abs(matrix_r @ black).max() < 1e-9 * abs(black).max(),
              f"{label}: the difference has no fundamental (black up to {abs(black).max():.3f})")
        for light, observer in broken:
            delta = difference(*(LIGHT[light] * reflectance for reflectance in pair), light, observer)
            check(delta > VISIBLE_DIFFERENCE, f"{label}: {light}, {observer}: CIEDE2000 {delta:.1f}")


def check_fluorescence():
    for path in listed("fluorescence"):
        values = material(path)
        plain, partner = values[""][0], values["mr"][0]
        excitation, emission = values["mf"]
        label = f"fluorescence {os.path.basename(path)[:-4]}"

        def stimulus(light):
            mean = (LIGHT[light] * excitation).sum() / excitation.sum()
            return LIGHT[light] * plain, LIGHT[light] * partner + mean * emission
        check(min(plain.min(), partner.min()) > 0 and max(plain.max(), partner.max()) < 1,
              f"{label}: reflectances within 0 and 1 (up to {plain.max():.3f})")
        one, two = stimulus("a")
        check(abs(two / one - 1).max() < 1e-12,
              f"{label}: alike in every band under A (to {abs(two / one - 1).max():.1e})")
        check(NM[excitation > 0].max() < NM[emission > 0].min(),
              f"{label}: light is absorbed up to {NM[excitation > 0].max():g} nm and emitted from "
              f"{NM[emission > 0].min():g} nm")
        # The material emits no more than the light that it absorbs at each wavelength, in
        # energy and in photons (whose energy falls with wavelength).
        energy = excitation / excitation.sum() * emission.sum()
        photons = excitation / excitation.sum() * (emission * NM).sum() / NM
        check((energy <= 1 - partner).all() and (photons <= 1 - partner).all(),
              f"{label}: it emits no more than it absorbs (energy {(energy / (1 - partner)).max():.2f}, "
              f"photons {(photons / (1 - partner)).max():.2f} of it at most)")
        delta = difference(*stimulus("d65"), "d65", "cie1931")
        check(delta > VISIBLE_DIFFERENCE, f"{label}: D65: CIEDE2000 {delta:.1f}")
        dark, glowing = OBSERVER["cie1931"][1] @ np.transpose(stimulus("uv"))
        check(glowing > 5 * dark, f"{label}: {glowing / dark:.0f} times as bright under the black light")


check_made()
check_metals()
check_metamers("illuminant", (("a", "cie1931"), ("fluorescent", "cie1931")))
check_metamers("observer", (("d65", "dcs200-camera"), ("d65", "transparency-film")))
check_fluorescence()
done()
