#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Measured sets, as instruments and spreadsheets write them: 24 patches in each of five kinds of files give the same stack, one of
them is taken by its name or number, and a set that leaves a choice open is refused. `show` plots spectra. Prints TAP."""
import csv
import io
from pathlib import Path

import numpy as np
import tifffile

from rendered import TMP, check, done, run, write

NM = list(range(400, 701, 20))
RNG = np.random.default_rng(24)
PATCHES = [(f"{'ABCD'[i // 6]}{i % 6 + 1}", f"patch {i + 1}", np.round(RNG.uniform(0, 1, len(NM)), 4)) for i in range(24)]


def cgats(separator, quote, field, names=True):
    fields = ["SAMPLE_ID", "SAMPLE_NAME", "XYZ_Y"] + [field % nm for nm in NM]
    rows = [[quote + ident + quote, quote + name + quote, "50.0"] + [f"{100 * value:.2f}" for value in values]
            for ident, name, values in PATCHES]
    return "\n".join(["CTI3   ", "", 'DESCRIPTOR "a set"', 'KEYWORD "SPECTRAL_BANDS"', f'SPECTRAL_BANDS "{len(NM)}"',
                      'SPECTRAL_START_NM "400.0"', 'SPECTRAL_END_NM "700.0"', 'SPECTRAL_NORM "100.0"', f"NUMBER_OF_FIELDS {len(fields)}",
                      "BEGIN_DATA_FORMAT", separator.join(fields), "END_DATA_FORMAT", f"NUMBER_OF_SETS {len(rows)}", "BEGIN_DATA",
                      *(separator.join(row) for row in rows), "END_DATA", "", "CAL", "BEGIN_DATA", "1 2", "END_DATA", ""])


def rows(separator, mark):
    lines = [separator.join(["ID", "Name", *(f"{nm}nm" for nm in NM)])]
    lines += [separator.join([ident, name, *(f"{value:.4f}".replace(".", mark) for value in values)]) for ident, name, values in PATCHES]
    return "\r".join(lines) + "\r"  # as Excel for Mac ends lines


def columns():
    lines = ["wavelength (nm)," + ",".join(name for _, name, _ in PATCHES)]
    lines += [f"{nm}," + ",".join(f"{values[i]:.4f}" for *_, values in PATCHES) for i, nm in enumerate(NM)]
    return "\n".join(lines[:1] + lines[:0:-1]) + "\n"  # the longest wavelength first


SETS = {"argyll.ti3": cgats(" ", '"', "SPEC_%d"), "xrite.txt": cgats("\t", "", "R_%d"), "konica.cgats": cgats(" ", '"', "SPECTRAL_NM%d"),
        "rows.csv": rows(",", "."), "german.csv": rows(";", ","), "columns.csv": columns()}
SCENE = """size 90 60
wavelengths 400 700 10
camera ortho 12 eye 0 0 5 look 0 0 0
light d65 1 direction 0 0 1
"""


def stack(name, lines):
    path = write(name + ".scene", SCENE + lines)
    result = run("render", path, "-o", f"{TMP}/{name}.tif", "--depth", "32f", "--quiet")
    return tifffile.imread(f"{TMP}/{name}.tif") if result.returncode == 0 else result.stderr


def expected(values):
    """the spectrum between the samples"""
    return np.interp(range(400, 701, 10), NM, values)


reference = None
d65 = stack("white", "material m { diffuse 1 }\nobject plane 12 8 material m\n")
for name, text in SETS.items():
    write(name, text)
    whole = stack("whole", f"checker {name} plane 4 4\n")
    reference = whole if reference is None else reference
    check(np.array_equal(whole, reference) and np.ptp(whole) > 0.5, f"the 24 patches of {name} give the same stack", whole)
    names = run("list", f"{TMP}/{name}").stdout.split("\n")[1:-1]
    check([line.strip() for line in names] == [name for _, name, _ in PATCHES], f"list prints the names of {name}", names)
    for word in ["patch 17", "17"] + ["C5"] * (name != "columns.csv"):
        got = stack("one", f'material m {{ diffuse "{name}:{word}" }}\nobject plane 12 8 material m\n')
        check(np.allclose(got[:, 30, 45], expected(PATCHES[16][2]) * d65[:, 30, 45], rtol=1e-5), f"{name}:{word} is that patch", got)
    for word, why in ("", "24"), (":nix", "no sample 'nix'"), (":patch 1x", "did you mean patch 1"), (":25", "25"):
        got = stack("none", f'material m {{ diffuse "{name}{word}" }}\nobject plane 12 8 material m\n')
        check(isinstance(got, str) and why in got, f"{name}{word} is refused: {why}", got)

write("twice.csv", "Name,400,500\na,0.1,0.2\na,0.3,0.4\n")
got = stack("twice", "material m { diffuse twice.csv:a }\nobject plane 12 8 material m\n")
check("2 samples are named 'a'" in got, "a name that two samples have is refused", got)
write("other.csv", "Name,Gloss,400,500\na,2,0.1,0.1\nb,1,0.3,0.3\n")
got = stack("other", "material m { diffuse other.csv:1 }\nobject plane 12 8 material m\n")
check(np.allclose(got[:, 30, 45], 0.1 * d65[:, 30, 45], rtol=1e-5), "a number is no value of another field", got)
write("dark.csv", "Name,400,500\na,0.1,-0.02\n")
got = stack("dark", "material m { diffuse dark.csv }\nobject plane 12 8 material m\n")
check("dark.csv:2:7" in got and "below 0" in got and "write 0" in got, "a value below 0 is refused with the way out", got)
write("tm27.spdx", """<?xml version="1.0" encoding="utf-8"?>
<IESTM2714 xmlns="iestm2714" version="1.0"><SpectralDistribution>
<SpectralData wavelength="400">0.2</SpectralData><SpectralData wavelength="500">3.0E-01</SpectralData>
  <SpectralData wavelength="700">0.5</SpectralData>
</SpectralDistribution></IESTM2714>
""")
result = run("show", f"{TMP}/tm27.spdx", "--csv")
check([[float(v) for v in row] for row in list(csv.reader(io.StringIO(result.stdout)))[1:]] == [[400, 0.2], [500, 0.3], [700, 0.5]],
      "a spectrum of IES TM-27 is read", result.stdout, result.stderr)

# ---- files of other formats are named ----
TABLE = "nm,R\n400,0.1\n700,0.5\n"
for name, content, why in (
        ("le.csv", b"\xff\xfe" + TABLE.encode("utf-16-le"), "the text is UTF-16; save it as UTF-8"),
        ("be.csv", b"\xfe\xff" + TABLE.encode("utf-16-be"), "the text is UTF-16; save it as UTF-8"),
        ("a.json", b'{"main": {"400": [0.1]}}', "the file is JSON"), ("a.csv", b"\xef\xbb\xbf<?xml version='1.0'?><a/>", "is XML, but has no SpectralData"),
        ("a.xlsx", b"PK\x03\x04\x14\0\0\0", "it looks like ZIP"), ("a.mat", b"MATLAB 5.0 MAT-file\0", "it looks like MATLAB"),
        ("sekonic.csv", b"Title,x\nTLMF,---\n\nSpectral Data 400[nm],0.1\n", "no line begins with a wavelength")):
    Path(TMP, name).write_bytes(content)
    got = stack("format", f"material m {{ diffuse {name} }}\nobject plane 12 8 material m\n")
    check(isinstance(got, str) and name in got and why in got and got.count("\n") == 1, f"{name} is refused: {why}", got)
write("cube.hdr", "ENVI\nsamples = 2\n")
for name, content, why in (("cube.bin", b"\0\1" * 8, "gdal_translate"), ("b.mat", b"MATLAB 5.0\0", "has the format MATLAB"),
                           ("b.npy", b"\x93NUMPY\1\0", "has the format NumPy"), ("b.h5", b"\x89HDF\r\n", "has the format HDF5")):
    Path(TMP, name).write_bytes(content)
    result = run("develop", f"{TMP}/{name}", "-o", f"{TMP}/none.png")
    check(result.returncode == 2 and why in result.stderr, f"develop refuses {name}: {why}", result.stderr)

# ---- show ----
result = run("show", "d65", "cie1931", "metals/gold", f"{TMP}/rows.csv", "daylight:6504", "--csv")
head, *body = csv.reader(io.StringIO(result.stdout))
check(head[:6] == ["wavelength (nm)", "d65", "cie1931 X", "cie1931 Y", "cie1931 Z", "metals/gold reflectance"] and len(head) == 32,
      "show names the curves of lights, detectors, materials and sets", head)
at = {float(row[0]): row for row in body}
check(float(at[560][1]) == 1 and float(at[420][head.index("patch 9")]) == PATCHES[8][2][1], "their values are those of the tables", at[420])
check(at[830][head.index("patch 9")] == "", "a table has no values beyond its ends", at[830])
result = run("show", "d65", "a", "f11", "--svg")
check(result.stdout.startswith("<?xml") and result.stdout.count("<title>") == 4, "show plots three curves", result.stdout[:200])
result = run("show", "d65", "nix", "--svg")
check(result.returncode == 2 and "nix" in result.stderr, "show refuses a name that is none", result.stderr)
result = run("show", "d65", "a")
check(result.returncode == 2 and "--csv or --svg" in result.stderr, "show prints one file", result.stderr)
done()
