#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Each word of a heading is used or refused: tables as instruments, spreadsheets and programs write them give the spectrum that
they hold, or a message that names the word. A case is a table, the sample that is taken of it, and the values at some
wavelengths (`show` prints them), or words of a refusal, where it is a reflectance, or, marked so, a light. Prints TAP."""
import csv
import io
import os
import re
import subprocess
import sys

import numpy as np

from rendered import TMP, bytes_of, check, done, output_of, pages_of, run, write, write_stack

RISING = {400: 0.1, 500: 0.2, 700: 0.4}
SCENE = "size 2 2\nwavelengths 400 700 100\nambient e 1\nmaterial m {{ diffuse {} }}\nobject plane 20 20 material m\n"
LIGHT = "size 2 2\nwavelengths 400 700 100\nambient {} 1\nmaterial m {{ diffuse 0.5 }}\nobject plane 1 1 material m\n"


def rows(separator=",", mark=".", values=RISING, scale=1, nm=str):
    return "".join(f"{nm(at)}{separator}{value * scale:.6g}".replace(".", mark) + "\n" for at, value in values.items())


READ = {
    # wavelengths: where a heading or a rise of numbers says so
    "names with numbers beside a word for wavelengths": ("Longueur d'onde;Probe 300;Probe 400\n" + rows(";", ",").replace("\n", ";0,9\n"), "Probe 300", RISING),
    "names as R writes them": (',"X1","X2"\n' + rows().replace("\n", ",0.9\n"), "X1", RISING),
    "numbers as names beside lambda": ("lambda,100,200\n" + rows().replace("\n", ",0.9\n"), "100", RISING),
    "the index of pandas": (",reflectance\n" + rows(), "", RISING),
    "numbered columns": ("nm,1,2\n" + rows().replace("\n", ",0.9\n"), "1", RISING),
    "falling rows": ("nm,R\n" + rows(values=dict(reversed(RISING.items()))), "", RISING),
    "a falling heading": ("name,700,500,400\npaint,0.4,0.2,0.1\n", "", RISING),
    "other columns behind the wavelengths": ("patch;400;500;700;L*;a*;b*\nA1;0,1;0,2;0,4;50;1;2\n", "A1", RISING),
    "units in the heading": ("Name\t400 nm\t500 nm\t700 nm\npaint 7\t0.1\t0.2\t0.4\n", "paint 7", RISING),
    "brackets as SpectraMagic writes them": ("Data Name,360[nm],400[nm],500[nm],700[nm]\npaper,0.05,0.1,0.2,0.4\n", "paper", RISING),
    "nm before the number": ("SampleID,nm400,nm500,nm700\n7,0.1,0.2,0.4\n", "7", RISING),
    "numbers as samples": ("ID,400,500,700\n1,0.1,0.2,0.4\n2,0.5,0.5,0.5\n", "1", RISING),
    "a heading that says wavelength above samples": ("Wavelength (nm),400,500,700\npaint A,0.1,0.2,0.4\n", "paint A", RISING),
    # units of x
    "micrometres": ("Wavelength (µm),R\n" + rows(nm=lambda at: f"{at / 1000}"), "", RISING),
    "microns": ("wave_um;R\n" + rows(";", ",", nm=lambda at: f"{at / 1000}"), "", RISING),
    "angstroms": ("lambda_Angstrom R\n" + rows(" ", nm=lambda at: f"{at * 10}"), "", RISING),
    "a sign for angstroms": ("wavelength [Å] R\n" + rows(" ", nm=lambda at: f"{at * 10}"), "", RISING),
    "a unit in each row": (rows(",", nm=lambda at: f"{at} nm"), "", RISING),
    # a line of units below the names
    "units below names": ("Wave;Paint A;Paint B\n[nm];[];[]\n" + rows(";", ",").replace("\n", ";0,9\n"), "Paint A", RISING),
    "units below some names": ("Wavelength,Paint A,Paint B\nnm,,\n" + rows().replace("\n", ",0.9\n"), "Paint A", RISING),
    "percent with a factor": ("Wave;R\n[nm];[%]\n" + rows(";", ",", scale=100), "*0.01", RISING),
    # instruments' files
    "Ocean Optics": ("SpectraSuite Data File\n++++++++++\nDate: Mon Jan 01 10:00:00 2024\nUser: lab\nIntegration Time (usec): 100000 (USB2)\n"
                     "Spectra Averaged: 5\nNumber of Pixels in Processed Spectrum: 3\n>>>>>Begin Processed Spectral Data<<<<<\n" + rows("\t", ",") +
                     ">>>>>End Processed Spectral Data<<<<<\n", "", RISING),
    "OceanView": ("Data from FLMS_0__0.txt Node\n\nDate: Tue Mar 03 11:00:00 CET 2024\nUser: lab\nSpectrometer: FLMS\nTrigger mode: 0\n"
                  "XAxis mode: Wavelengths\n>>>>>Begin Spectral Data<<<<<\n" + rows("\t"), "", RISING),
    "Jaz": ("Jaz Absolute Irradiance File\n++++++++++\nDate: Mon\n>>>>>Begin Processed Spectral Data<<<<<\nW\tD\tS\tP\n" +
            "".join(f"{at}\t0\t1\t{value}\n" for at, value in RISING.items()) + ">>>>>End Processed Spectral Data<<<<<\n", "P", RISING),
    "Avantes": ("0804016U1\nIntegration time: 100.00 ms\nspectrometer name: X1" + 20 * "\0" + "\nWave   ;Sample   ;Dark     ;Reference;Reflectance\n"
                "[nm]   ;[counts] ;[counts] ;[counts] ;[%]\n\n" + "".join(f" {at},00; 9,0; 1,0; 8,0;{100 * value}\n".replace(".", ",") for at, value in RISING.items()),
                "Reflectance*0.01", RISING),
    "CGATS": ("CGATS.17\nSPECTRAL_NORM 100\nBEGIN_DATA_FORMAT\nSAMPLE_ID SAMPLE_NAME SPECTRAL_NM400 SPECTRAL_NM500 SPECTRAL_NM700\nEND_DATA_FORMAT\n"
              "BEGIN_DATA\n1 \"paint A\" 10 20 40\n2 white 90 90 90\nEND_DATA\n", "paint A", RISING),
    "X-Rite": ("CGATS.17\nORIGINATOR \"i1Profiler\"\nNUMBER_OF_FIELDS 4\nBEGIN_DATA_FORMAT\nSampleID\tR_400\tR_500\tR_700\nEND_DATA_FORMAT\n"
               "BEGIN_DATA\nA1\t0.1\t0.2\t0.4\nEND_DATA\n", "A1", RISING),
    "Konica Minolta": ("Data Name,L*(D65),a*(D65),b*(D65),400[nm],500[nm],700[nm]\npaper,95,0,1,0.1,0.2,0.4\n", "paper", RISING),
    "pandas": (",sample_1,sample_2\n400.0,0.1,0.9\n500.0,0.2,0.9\n700.0,0.4,0.9\n", "sample_1", RISING),
    "R": ('"wl","paint","paper"\n400,0.1,0.9\n500,0.2,0.9\n700,0.4,0.9\n', "paint", RISING),
    "MATLAB": ("   4.0000000e+02   1.0000000e-01\n   5.0000000e+02   2.0000000e-01\n   7.0000000e+02   4.0000000e-01\n", "", RISING),
    "a sentence with units of other things": ("Energy saving on, lamp at 5 cm, slit of 2 mm\n" + rows("\t"), "", RISING),
    "a note with a length below the date": ("Date: Mon\nDistance of the probe: 5 mm\n" + rows(" "), "", RISING),
    "Ctrl-Z at the end": (rows() + "\x1a", "", RISING),
    "no-break spaces": ("nm;R\n" + rows("\u00a0;"), "", RISING),
    "a date as the first line": ("12/03/2024 10:11:12\nnm;R\n" + rows(";", ","), "", RISING),
    "a number of samples as the first line": ("3\nnm;R\n" + rows(";", ","), "", RISING),
    # IES TM-27, as XML says
    "TM-27 with comments, prefixes and single quotes": (
        "<?xml version='1.0'?>\n<ies:IESTM2714 xmlns:ies='x'><!-- <SpectralData wavelength=\"450\">0.9</SpectralData> -->\n"
        "<ies:SpectralData\n  unit='nm'\n  wavelength = '400'>0.1</ies:SpectralData><SpectralData wavelength=\"500\"> 0.2\n</SpectralData>"
        "<SpectralData wavelength=\"700\">4e-1</SpectralData></ies:IESTM2714>\n", "", RISING),
    # noise beyond 0 and 1
    "noise below 0 beyond the visible": ("nm,R\n200,-0.3\n" + rows() + "900,-2\n", "", RISING),
    "noise above 1 beyond the visible": ("nm,R\n190,10\n200,140\n" + rows(scale=100), "*0.01", RISING),
    "a little below 0": ("nm,R\n400,0.1\n450,-0.0004\n500,0.2\n700,0.4\n", "", RISING),
    "a hair above 1": ("nm,R\n400,0.1\n450,1.005\n500,0.2\n700,0.4\n", "", RISING),
    "a hair below 0": ("nm,R\n400,0.1\n450,-0.009\n500,0.2\n700,0.4\n", "", RISING),
}
NOISE = {name for name in READ if name.startswith(("noise", "a little", "a hair"))}

REFUSED = {
    "two readings": (",400,500\n400,0.1,0.2\n500,0.1,0.2\n", "", "wavelengths, if each row is a sample, or names of columns"),
    "pairs of columns": ("Wavelength,R,Wavelength,R\n400,0.1,300,0.7\n500,0.2,350,0.6\n", "1", "another pair of columns"),
    "pairs in a line": ("400 0.1 500 0.2\n600 0.3 700 0.4\n", "1", "pairs of a wavelength and a value"),
    "prefixes": ("name,R_400,R_500\npaint,0.1,0.2\n", "", "wavelengths such as 400 or 400 nm"),
    "wavenumbers": ("Wavenumber,R\n25000,0.1\n20000,0.2\n", "", "10000000 divided by"),
    "1/cm": ("1/cm,R\n25000,0.1\n20000,0.2\n", "", "10000000 divided by"),
    "energies": ("photon energy,R\n3.1,0.1\n2.5,0.2\n", "", "1239.84198 divided by"),
    "frequencies": ("frequency (THz),R\n749,0.1\n600,0.2\n", "", "299792.458 divided by"),
    "millimetres": ("wavelength/mm,R\n0.0004,0.1\n0.0005,0.2\n", "", "1000000 times"),
    "micrometres without a word": ("0.4 0.1\n0.5 0.2\n", "", "micrometres"),
    "no wavelengths at all": ("0.01 0.1\n0.5 0.2\n", "", "expected wavelengths in nm"),
    "wavelengths beyond the picture": ("4000 0.1\n7000 0.2\n", "", "none in the picture's range"),
    "percent": ("nm,R %\n" + rows(), "", "says percent"),
    "Prozent": ("Remission in Prozent\nnm;R\n" + rows(";", ","), "", "says percent"),
    "pct": ("nm,R (pct)\n" + rows(), "", "says percent"),
    "pourcent": ("nm,réflectance en pourcent\n" + rows(), "", "says percent"),
    "per cent": ("nm;R, per cent\n" + rows(";"), "", "says percent"),
    "percent in the line of units": ("Wave;A\n[nm];[%]\n" + rows(";", ","), "", "says percent"),
    "absorbance": ("Wavelength,Absorbance\n" + rows(), "", "'Absorbance' is no reflectance"),
    "log(1/R)": ("nm,log(1/R)\n" + rows(), "", "is no reflectance"),
    "optical density": ("nm;optical density\n" + rows(";"), "", "is no reflectance"),
    "K/S": ("nm,K/S\n" + rows(), "", "is no reflectance"),
    "counts": ("nm,S [counts]\n" + rows(), "", "is no reflectance"),
    "a radiance": ("nm,spectral radiance\n" + rows(), "", "is no reflectance"),
    "TM-27 of radiance": ('<?xml version="1.0"?><a><SpectralQuantity>radiance</SpectralQuantity><SpectralData wavelength="400">0.1</SpectralData></a>\n', "", "is no reflectance"),
    "a reflectance as a light": ("nm,reflectance\n" + rows(), "LIGHT", "is no light"),
    "a transmittance as a light": ("nm,Transmittance\n" + rows(), "LIGHT", "is no light"),
    "noise that counts": ("nm,R\n400,0.1\n500,-0.2\n700,0.4\n", "", "below 0"),
    "too bright": ("nm,R\n400,90\n500,105\n700,95\n", "*0.01", "is above 1"),
    "a typing error": ("nm,R\n4oo,0.1\n500,0.2\n", "", "'4oo'"),
    "a row with a word": ("nm,R,comment\n400,0.1,good\n", "", "'good'"),
    "no rows": ("nm,R\n", "", "no line begins with a wavelength"),
    "JCAMP-DX": ("##TITLE= x\n##JCAMP-DX= 4.24\n##XUNITS= 1/CM\n##XYDATA= (X++(Y..Y))\n400 0.1\n##END=\n", "", "JCAMP-DX"),
    "CxF": ('<?xml version="1.0"?><CxF><ReflectanceSpectrum StartWL="400">0.1 0.2</ReflectanceSpectrum></CxF>\n', "", "CxF"),
    "UTF-16 without a mark": ("nm,R\n400,0.1\n".encode("utf-16-le"), "", "UTF-16"),
    "a pointer of Git LFS": ("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n", "", "Git LFS"),
    "IES": ("IESNA:LM-63-2002\nTILT=NONE\n", "", "IES"),
}


def table(name, content):
    path = f"{os.path.abspath(TMP)}/{name.replace(' ', '-').replace('/', '-')}.txt"
    with open(path, "wb") as file:
        file.write(content if isinstance(content, bytes) else content.encode())
    return path


def spectrum(path, sample):
    name, star, factor = sample.partition("*")
    return f'"{path}{":" + name if name else ""}{star}{factor}"'


for case, (content, sample, expected) in READ.items():
    word = spectrum(table(case, content), sample)
    plan = run("plan", write("case.scene", SCENE.format(word)))
    shown = run("show", word.strip('"'), "--csv")
    found = {float(row[0]): float(row[1]) for row in list(csv.reader(io.StringIO(shown.stdout)))[1:]}
    check(plan.returncode == 0 and all(abs(found.get(at, 9) - value) < 1e-9 for at, value in expected.items()), f"read: {case}",
          plan.stderr, shown.stderr, found)
for case in sorted(NOISE):
    content, sample, _ = READ[case]
    result = run("render", write("case.scene", SCENE.format(spectrum(table(case, content), sample))), "-o", f"{TMP}/case.tif", "--renderer", "raster")
    check(result.returncode == 0 and "beyond 0 or 1" in result.stdout, f"a note counts it: {case}", result.stdout, result.stderr)
for case, (content, sample, why) in REFUSED.items():
    scene = LIGHT if sample == "LIGHT" else SCENE
    word = spectrum(table(case, content), "" if sample == "LIGHT" else sample)
    result = run("plan", write("case.scene", scene.format(word)))
    listed = run("list", word.strip('"').partition("*")[0]) if case in ("no rows", "JCAMP-DX", "prefixes") else None
    check(result.returncode == 2 and result.stderr.count("\n") == 1 and why in result.stderr and (not listed or listed.returncode == 2),
          f"refused: {case}: {why}", result.stdout[:300], result.stderr, listed)

# ---- numbers that are no spectra, and wavelengths in another unit ----
for number in ("6500", "2856", "1000", "100000", "6504.5"):
    result = run("plan", write("case.scene", LIGHT.format(number)))
    check(result.returncode == 2 and f"daylight:{number} or blackbody:{number}" in result.stderr, f"{number} as a light is no temperature", result.stderr)
    check(run("plan", write("case.scene", LIGHT.format(number + "*1"))).returncode == 0, f"{number}*1 is the number")
for text in ("0.4 0.7 0.01", "list 0.4 0.5", "0.38 0.78 0.005", "1 5 1", "list 0.55"):
    result = run("plan", write("case.scene", "wavelengths " + text + "\nobject plane 1 1 material m\nmaterial m { diffuse 0.5 }\n"))
    check(result.returncode == 2 and "multiply micrometres by 1000" in result.stderr, f"wavelengths {text} are refused", result.stderr)
result = run("plan", "patches", "--wavelengths", "0.4:0.7:0.01")
check(result.returncode == 2 and "multiply micrometres" in result.stderr, "so they are on the command line", result.stderr)

# ---- channels by their names ----
COLOURS = {"r": (0.01, 0.1), "g": (0.2, 0.5), "b": (0.5, 0.02)}
output_of("render", "patches", "--size", "30x20", "--wavelengths", "400:700:10", "-o", f"{TMP}/patches.tif", "--renderer", "raster", "--no-check", "-q")


def developed(names, values):
    write("detector.csv", "nm," + ",".join(names) + "".join(f"\n{nm}," + ",".join(str(value[i]) for value in values) for i, nm in enumerate((400, 700))) + "\n")
    return run("develop", f"{TMP}/patches.tif", "--detector", f"{TMP}/detector.csv", "-o", f"{TMP}/seen.png").stdout, open(f"{TMP}/seen.png", "rb").read()


first = developed("RGB", [COLOURS[c] for c in "rgb"])[1]
for order in ("BGR", ("blue", "green", "red"), ("Green", "R", "b"), "GBR", "RBG"):
    _, picture = developed(order, [COLOURS[c[0].lower()] for c in order])
    check(picture == first, f"channels {', '.join(order)} stand in the order of red, green and blue")
xyz = developed("xyz", [COLOURS[c] for c in "rgb"])
for order in ("zyx", "YXZ", "yzx", ("z_bar", "x_bar", "y_bar"), "ZXY"):
    said = developed(order, [COLOURS["rgb"["xyz".index(c[0].lower())]] for c in order])
    check("observer" in said[0] and said == xyz, f"channels {', '.join(order)} are an observer's", said)
for head, separator in (('# mine\n\n"Wavelength (nm)";"x";"y";"z"\r', ";"), ("lambda xbar ybar zbar", " "), ("nm\tx_10(2deg)\ty_10(2deg)\tz_10(2deg)", "\t"),
                        ("nm;CIE x\u0304;CIE \u0233;CIE z\u0304", ";")):
    lines = [head, *(separator.join(map(str, (nm, *(COLOURS[c][i] for c in "rgb")))) for i, nm in enumerate((400, 700)))]
    write("detector.csv", "\n".join(lines) + "\n")
    said = run("develop", f"{TMP}/patches.tif", "--detector", f"{TMP}/detector.csv", "-o", f"{TMP}/seen.png").stdout, bytes_of(f"{TMP}/seen.png")
    check(said == xyz, f"so are those of {head!r}", said[0])
check("observer" not in developed(("xenon", "y", "z"), [COLOURS[c] for c in "rgb"])[0], "xenon is no x")
for name in "a:1", "a*2", "a b.csv", "0.5":
    write(name, "nm r g b\n400 1 2 3\n")
    result = run("develop", os.path.abspath(f"{TMP}/patches.tif"), "--detector", f"./{name}", "-o", "seen.png", cwd=TMP)
    check(result.returncode == 0, f"a detector in a file named {name} is read", result.stderr)
# the bands of 300 and 600 nm are 300 nm wide, those of the picture 10, 20 and 30; the sum of y is 600, which becomes 100
write("lobed.csv", "nm,x,y,z\n300,1,3,4\n600,1,-1,4\n")
said = output_of("develop", write_stack("uneven.tif", np.ones((3, 1, 1), np.float32), (400, 410, 440)), "--xyz", "--detector", f"{TMP}/lobed.csv",
                 "-o", f"{TMP}/uneven-xyz.tif")
check(np.allclose(pages_of(f"{TMP}/uneven-xyz.tif").ravel(), [10, (10 * (3 - 4 / 3) * 1 + 20 * (3 - 4 * 110 / 300) + 30 * (3 - 4 * 140 / 300)) / 6, 40]),
      "a negative y reduces the sum", pages_of(f"{TMP}/uneven-xyz.tif").ravel())
lost = [float(word) for word in re.findall(r"[\d.e-]+(?= %)", re.search("^unseen.*$", said, re.MULTILINE)[0])]
check(np.allclose(lost, [90, 100 - 100 * (3 * 55 + 5) / 1200, 90], rtol=1e-4), "and counts by its size where it is not seen", lost, said)

# ---- the sample that makes tables of other formats ----
JCAMP = "##TITLE= paint\n##JCAMP-DX= 4.24\n##XUNITS= {}\n##YUNITS= {}\n##XFACTOR= {}\n##YFACTOR= {}\n##NPOINTS= {}\n{}\n##END=\n"
for case, content, expected in (
        ("wavenumbers", JCAMP.format("1/CM", "REFLECTANCE", 1, 1, 2, "##XYPOINTS= (XY..XY)\n25000, 0.1\n20000, 0.2"), {400: 0.1, 500: 0.2}),
        ("factors", JCAMP.format("NANOMETERS", "% REFLECTANCE", 2, 0.5, 2, "##XYPOINTS= (XY..XY)\n200 20\n250 40"), {400: 0.1, 500: 0.2}),
        ("steps", JCAMP.format("NANOMETERS", "REFLECTANCE", 1, 1, 4, "##FIRSTX= 400\n##LASTX= 700\n##XYDATA= (X++(Y..Y))\n400 0.1 0.2\n600 0.3 0.4"),
         {400: 0.1, 500: 0.2, 700: 0.4}),
        ("absorbance", JCAMP.format("NANOMETERS", "ABSORBANCE", 1, 1, 2, "##XYPOINTS= (XY..XY)\n400 1\n500 2"), {400: 0.1, 500: 0.01}),
        ("CxF", '<?xml version="1.0"?><c:CxF xmlns:c="x"><c:ReflectanceSpectrum Name="p" StartWL="400" Increment="50">0.1 0.15 0.2</c:ReflectanceSpectrum></c:CxF>',
         {400: 0.1, 500: 0.2}),
        ("pairs in a line", "400 0.1 500 0.2\n600 0.3 700 0.4\n", RISING), ("pairs of columns", "Wavelength (nm),%R,Wavelength (nm),%R\n400,0.1,400,0.9\n500,0.2,500,0.8\n", {400: 0.1, 500: 0.2})):
    path = table(case, content)
    made = subprocess.run([sys.executable, "data/samples/to_csv.py", path], capture_output=True, text=True, check=False)
    write("made.csv", made.stdout)
    found = {float(row[0]): float(row[1]) for row in list(csv.reader(io.StringIO(made.stdout)))[1:]}
    check(made.returncode == 0 and all(abs(found.get(at, 9) - value) < 1e-9 for at, value in expected.items()) and run("list", f"{TMP}/made.csv").returncode == 0,
          f"to_csv.py: {case}", made.stdout, made.stderr)
for case, content, why in (("compressed numbers", JCAMP.format("1/CM", "REFLECTANCE", 1, 1, 2, "##FIRSTX= 1\n##LASTX= 2\n##XYDATA= (X++(Y..Y))\n400A12b3"), "compressed"),
                           ("an unknown unit", JCAMP.format("FURLONGS", "REFLECTANCE", 1, 1, 1, "##XYPOINTS= (XY..XY)\n1 1"), "FURLONGS")):
    made = subprocess.run([sys.executable, "data/samples/to_csv.py", table(case, content)], capture_output=True, text=True, check=False)
    check(made.returncode == 1 and why in made.stderr and not made.stdout, f"to_csv.py refuses {case}", made.stderr)
done()
