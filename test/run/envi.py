#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile python3-gdal python3-spectral
"""ENVI cubes in and out.

In: cubes of every type, order of bytes and interleave, written here by numpy, and by SPy and GDAL, equal the same
radiances in a TIFF file, to the last bit. Broken headers are refused with their place.
Out: SPy, GDAL and numpy map a stack by its header, and find the samples, wavelengths and scales that tifffile finds."""
import importlib
import json
import os
import resource
import shutil
import subprocess
import sys

import numpy as np
import tifffile

sys.dont_write_bytecode = True
from rendered import SPECTRAL, TMP, check, done, write

TYPES = {1: "u1", 2: "i2", 3: "i4", 4: "f4", 5: "f8", 12: "u2", 13: "u4", 14: "i8", 15: "u8"}
ORDER = {"bsq": (0, 1, 2), "bil": (1, 0, 2), "bip": (1, 2, 0)}  # from band, row, column
NM = [400, 450.5, 500, 620, 700]
HEIGHT, WIDTH = 7, 6
COUNTS = np.random.default_rng(1).integers(0, 128, (len(NM), HEIGHT, WIDTH))  # each type holds them


def module(name):
    """A module that a system may lack; None: it is missing."""
    try:
        return importlib.import_module(name)
    except ImportError:
        print(f"# no Python module {name}")
        return None


def path(name):
    return os.path.join(TMP, name)


def run(*words, **more):
    return subprocess.run([SPECTRAL, *words], capture_output=True, text=True, check=False, **more)


def tiff(name, pixels, nm=NM, **more):
    """Radiances as float pages, with wavelengths as page names."""
    with tifffile.TiffWriter(path(name)) as out:
        for page, wavelength in zip(np.asarray(pixels), nm):
            out.write(page, metadata=None, contiguous=False, photometric="minisblack",
                      extratags=[(285, "s", 0, f"{wavelength} nm", True)], **more)
    return path(name)


def lines(**changes):
    """The lines of a header. A key's '_' is a blank; None leaves the line out."""
    values = {"samples": WIDTH, "lines": HEIGHT, "bands": len(NM), "header offset": 0, "file type": "ENVI Standard",
              "data type": 4, "interleave": "bsq", "byte order": 0, "wavelength units": "Nanometers",
              "wavelength": "{" + ", ".join(map(str, NM)) + "}"}
    values.update((key.replace("_", " "), value) for key, value in changes.items())
    return ["ENVI"] + [f"{key} = {value}" for key, value in values.items() if value is not None]


def cube(name, pixels, kind=4, interleave="bsq", big=False, offset=0, header=None, **changes):
    """Writes the data file NAME and its header; returns the header's path."""
    samples = np.asarray(pixels).astype((">" if big else "<") + TYPES[kind])
    with open(path(name), "wb") as out:
        out.write(b"\xff" * offset + samples.transpose(ORDER[interleave]).tobytes())
    text = "\n".join(lines(**{"data_type": kind, "interleave": interleave, "byte_order": int(big),
                              "header_offset": offset, **changes}))
    return write(header or name + ".hdr", text + "\n")


def equal(a, b, *options):
    result = run("compare", a, b, *options)
    return result.returncode == 0, result.stdout + result.stderr


# ---- in ----

def test_kinds():
    expected = tiff("expected.tif", COUNTS.astype(np.float32))
    for kind, name in TYPES.items():
        differ = [(interleave, big) for interleave in ORDER for big in (False, True)
                  if not equal(expected, cube("kind", COUNTS, kind, interleave, big, 37 * big))[0]]
        check(not differ, f"type {kind} ({name}): three interleaves and two byte orders are the same", differ)
    changed = COUNTS.copy()
    changed[3, 2, 1] += 1
    for interleave in ORDER:
        result = run("compare", expected, cube("kind", changed, 12, interleave))
        check(result.returncode == 1 and "1 W" in result.stdout and "at 620 nm, at pixel 1,2" in result.stdout,
              f"{interleave}: one sample that differs is found in its place", result.stdout)


def test_extremes():
    """Numbers that only their own type holds, and the sign."""
    for kind, numbers in ((12, [65535, 256, 255]), (13, [4294967295, 65536, 1]), (15, [2**64 - 1, 2**63, 1]),
                          (14, [2**62 + 1, 2**32, 1]), (3, [2**31 - 1, 65536, 1]), (5, [1e-30, 0.1, 3e38]),
                          (4, [1e-45, 0.1, 3.4028235e38])):
        pixels = np.array(numbers, TYPES[kind]).reshape(1, 1, 3)
        for big in (False, True):
            here = cube("extreme", pixels, kind, "bip", big, samples=3, lines=1, bands=1, wavelength="{500}")
            same = equal(tiff("extreme.tif", pixels.astype(np.float32), [500]), here)
            check(same[0], f"type {kind}, {'big' if big else 'little'}-endian: {numbers}", same[1])
    for kind in (2, 3, 4, 5, 14):
        negative = COUNTS.copy()
        negative[1, 4, 3] = -1
        result = run("develop", cube("negative.dat", negative, kind), "-o", path("none"))
        check(result.returncode == 2 and "negative.dat: band 2 (450.5 nm): the radiance at column 3, row 4 is -1; "
              in result.stderr, f"type {kind}: a negative radiance is refused in its place", result.stderr)
    for value in (np.nan, np.inf):
        broken = COUNTS.astype(float)
        broken[0, 0, 5] = value
        result = run("develop", cube("broken.dat", broken, 5), "-o", path("none"))
        check(result.returncode == 2 and "column 5, row 0 is" in result.stderr, f"{value} is refused", result.stderr)


def test_header():
    """Other ways to write a header change nothing."""
    expected = path("expected.tif")
    plain = cube("kind", COUNTS, 12)
    text = open(plain).read()
    for name, changed in (
            ("CRLF", text.replace("\n", "\r\n")),
            ("upper case", text.upper()),
            ("blanks and tabs", text.replace(" = ", "\t =   ").replace("data type", "data \t type")),
            ("no blanks", text.replace(" = ", "=").replace(", ", ",")),
            ("a byte order mark", "\ufeff" + text),
            ("comments and empty lines", text.replace("\n", "\n; samples = 1\n \n")),
            ("no line end", text.rstrip("\n")),
            ("unknown keys", text + "map info = {UTM, 1, # {,\n samples = 3\n}\nsensor type = = }\nwavelengths = 7\n"),
            ("one number a line", text.replace(", ", ",\r\n\t").replace("= {", "= {\n").replace("}", "\n }  ")),
            ("numbers otherwise", text.replace("450.5,", "4505e-1,").replace("400,", "+400.,")),
            ("micrometres", text.replace("Nanometers", "Micrometers").replace(
                ", ".join(map(str, NM)), ", ".join(str(nm / 1000) for nm in NM)))):
        same = equal(expected, write("kind.hdr", changed))
        check(same[0], f"{name} in a header change nothing", same[1])
    result = run("info", plain)
    check(result.returncode == 0 and "pages             5 of 6 x 7 pixels\nwavelengths       400 to 700 nm\n"
          in result.stdout and "unsigned 16-bit, bsq, little-endian, from byte 0" in result.stdout,
          "info prints what the header states", result.stdout, result.stderr)
    result = run("info", plain, "--json", "-")
    check(result.returncode == 0 and json.loads(result.stdout)["wavelengths_nm"] == NM, "and as JSON", result.stderr)


def test_names():
    """Either file names the cube."""
    expected = path("expected.tif")
    for ending in ("", ".img", ".dat", ".raw", ".bsq", ".bil", ".bip", ".IMG"):
        data = "names" + ending
        for header in {"names.hdr", data + ".hdr"}:
            for old in ("names.hdr", data + ".hdr"):
                if os.path.exists(path(old)):
                    os.remove(path(old))
            cube(data, COUNTS, 12, header=header)
            same = equal(expected, path(data))
            check(same[0], f"{data} has its header in {header}", same[1])
            if ending != ".IMG" or header != "names.hdr":
                same = equal(expected, path(header))
                check(same[0], f"{header} has its samples in {data}", same[1])
            os.remove(path(data))
            os.remove(path(header))
    cube("odd.xyz", COUNTS, 12)
    same = equal(expected, path("odd.xyz"))
    check(same[0], "any name may have a header NAME.hdr", same[1])
    cube("data.xyz", COUNTS, 12, header="data.hdr")
    result = run("develop", path("data.xyz"), "-o", path("none"))
    check(result.returncode == 2, "but NAME.hdr belongs to known endings only", result.stderr)
    result = run("develop", path("data.hdr"), "-o", path("none"))
    check(result.returncode == 2 and "data file is missing" in result.stderr,
          "a header without a data file is refused", result.stderr)
    for output in ("kind", "kind.hdr"):
        cube("kind", COUNTS, 12)
        for operand in ("kind", "kind.hdr"):
            result = run("probe", path(operand), "0", "0", "-o", path(output))
            check(result.returncode == 2 and "would replace the input" in result.stderr,
                  f"probe {operand} does not replace {output}", result.stderr)


def test_scales():
    ramp = np.linspace(0.5, 2, len(NM))[:, None, None]
    listed = "{" + ", ".join(repr(float(x)) for x in ramp.ravel()) + "}"
    minus = "{" + ", ".join(["-0.25"] * len(NM)) + "}"
    for name, expected, changes in (
            ("gain and offset of each band", (COUNTS + 1) * ramp - 0.25,
             {"data_gain_values": listed, "data_offset_values": minus}),
            ("offset", (COUNTS + 1) - 0.25, {"data_offset_values": minus}),
            ("reflectance scale factor", (COUNTS + 1) / 128, {"reflectance_scale_factor": 128}),
            ("a factor and gains that agree", (COUNTS + 1) / 128,
             {"reflectance_scale_factor": 128, "data_gain_values": "{" + ", ".join(["0.0078125"] * len(NM)) + "}"})):
        same = equal(tiff("scaled.tif", expected.astype(np.float32)), cube("scaled", COUNTS + 1, 2, **changes))
        check(same[0], f"{name}: as numpy computes it", same[1])
    least = -3.4028234663852886e38  # of all floats
    for kind, ignored, word in ((2, -9999, "-9999"), (4, -9999.9, "-9999.9"), (4, least, "-3.40282347e+38"),
                                (4, least, "-3.4028235e38"), (5, np.nan, "NaN"), (12, 65535, "65535")):
        holes = COUNTS.astype(TYPES[kind])
        holes[2, 1, 1:4] = ignored
        expected = COUNTS.astype(np.float32)
        expected[2, 1, 1:4] = 0
        here = cube("ignored", holes, kind, data_ignore_value=word)
        same = equal(tiff("ignored.tif", expected), here)
        check(same[0], f"samples of the ignored value {word} are 0", same[1])
    bad = [1, 0, 1, 1, 0]
    keep = np.array(bad, bool)
    wrong = COUNTS.astype(np.float32)
    wrong[~keep] = -1
    nm = ["400", "3000", "500", "620", "1"]  # a bad band may be out of order
    for interleave in ORDER:
        same = equal(tiff("good.tif", COUNTS[keep].astype(np.float32), np.array(NM)[keep]),
                     cube("bad", wrong, 4, interleave, bbl="{" + ", ".join(map(str, bad)) + "}",
                          wavelength="{" + ", ".join(nm) + "}"))
        check(same[0], f"{interleave}: bad bands are left out, whatever they hold", same[1])
    result = run("info", path("bad.hdr"))
    check("bad bands         2 of 5, left out" in result.stdout, "info counts the bad bands", result.stdout)


def test_commands():
    """Other commands see the same in both files."""
    pixels = (COUNTS / 128).astype(np.float32)
    here, there = cube("seen.img", pixels, 5, "bil", True), tiff("seen.tif", pixels)
    for operand in (here, there):
        result = run("develop", operand, "--white", "d65", "--adaptation", "cat16", "-o", operand + "-developed.tif",
                     "--quiet")
        check(result.returncode == 0, f"{os.path.basename(operand)} is developed", result.stderr)
    same = [tifffile.imread(operand + "-developed.tif") for operand in (here, there)]
    check(np.array_equal(*same) and same[0].max() > same[0].min(), "both developed pictures are the same")
    for words in (("2", "3"), ("1", "2", "3", "4", "--csv")):
        seen, expected = (run("probe", operand, *words, "--white", "a").stdout for operand in (here, there))
        check(seen and seen.replace(here, there) == expected, f"probe {' '.join(words)} prints the same", seen,
              expected)
    csv = run("probe", here, "5", "6", "--csv").stdout.splitlines()[1:]
    check([float(row.split(",")[1]) for row in csv] == [float(x) for x in pixels[:, 6, 5]],
          "a probed spectrum is the cube's", csv)
    stacks = []
    for texture in (here, there):
        scene = write("textured.scene", "size 30 30\nwavelengths 400 700 20\nlight d65 1 direction 0 0 1\n"
                      f"material m {{ diffuse 1 spectral-texture {os.path.basename(texture)} linear }}\n"
                      "object plane 9 9 material m\n")
        stacks.append(texture + ".stack.tif")
        result = run("render", scene, "--renderer", "raster", "-o", stacks[-1], "--quiet")
        check(result.returncode == 0, f"{os.path.basename(texture)} is a spectral texture", result.stderr)
    result = run("plan", write("grey.scene", open(scene).read().replace("spectral-texture", "texture").replace(
        "seen.tif", "seen.img")))
    check(result.returncode == 2 and "grey.scene:4:24: error: " in result.stderr and "a cube is a spectral-texture" in
          result.stderr, "a cube is no texture of one page", result.stderr)
    same = equal(*stacks)
    check(same[0] and tifffile.imread(stacks[0]).max() > 0, "both textures give the same picture", same[1])


# Changes of the header of lines(). A row: a name, the words to replace ("": a line is added), the new words, and the
# words of the message behind the header's name.
REFUSED = (
    ("no ENVI header", "ENVI\n", "BYTEORDER I\n", ":1:1: error: expected ENVI in the first line"),
    ("a line without =", "", " nonsense", ":12:2: error: expected a line KEY = VALUE"),
    ("an open brace", "700}", "700", ":11:14: error: no } closes this {"),
    ("text behind a brace", "700}", "700} nm", ":11:42: error: expected the end of the line behind }"),
    ("a second line", "", "lines = 7", ":12:1: error: lines is given twice; the first is in line 3"),
    ("half a sample", "= 6", "= 6.5", ":2:11: error: samples must be a whole number, not '6.5'"),
    ("no row", "= 7", "= 0", ":3:9: error: lines 0 is out of range"),
    ("too many bands", "= 5", "= 70000", ":4:9: error: bands 70000 is out of range"),
    ("a negative offset", "offset = 0", "offset = -1", ":5:17: error: header offset -1 is out of range"),
    ("a spectral library", "Standard", "Spectral Library", ":6:13: error: unknown file type 'ENVI Spectral Library'"),
    ("an empty value", "ENVI Standard", "", ":6:13: error: expected one value of file type"),
    ("type 6", "type = 4", "type = 6", ":7:13: error: data type 6 is of complex numbers, two 32-bit floats each"),
    ("type 9", "type = 4", "type = 9", ":7:13: error: data type 9 is of complex numbers, two 64-bit floats each"),
    ("type 0", "type = 4", "type = 0", ":7:13: error: data type 0 is unknown"),
    ("type 7", "type = 4", "type = 7", ":7:13: error: data type 7 is unknown"),
    ("type 16", "type = 4", "type = 16", ":7:13: error: data type 16 is unknown"),
    ("another interleave", "bsq", "bsp", ":8:14: error: unknown interleave 'bsp'; did you mean bsq?"),
    ("another byte order", "order = 0", "order = 2", ":9:14: error: byte order 2 is out of range"),
    ("no unit", "wavelength units = Nanometers\n", "",
     ":10:15: error: the unit of the wavelengths is missing; add a line 'wavelength units = Nanometers'"),
    ("an unknown unit", "Nanometers", "Unknown", ":10:20: error: unknown wavelength units 'Unknown'; known are Nano"),
    ("too few wavelengths", ", 700", "", ":11:15: error: wavelength has 4 numbers; expected 5"),
    ("too many wavelengths", "700", "700, 701", ":11:15: error: wavelength has 6 numbers; expected 5"),
    ("a word", "500, 620", "500,\n\tx", ":12:2: error: wavelength must be a number such as 2.5 or 1e-3, not 'x'"),
    ("nan", "400", "nan", ":11:15: error: wavelength must be a number"),
    ("a comma too many", "700", "700,", ":11:41: error: expected a number of wavelength"),
    ("two commas", "400,", "400,,", ":11:19: error: expected a number of wavelength"),
    ("no comma", "450.5, ", "450.5\n", ":12:1: error: expected a comma between two numbers of wavelength"),
    ("wavelengths that decrease", "500", "300",
     ":11:15: error: band 3 is at 300 nm, the band before it at 450.5 nm; expected wavelengths that increase"),
    ("wavelengths that repeat", "450.5", "400", ":11:15: error: band 2 is at 400 nm, the band before it at 400 nm"),
    ("a wavelength of 0", "400", "0", ":11:15: error: band 1 is at 0 nm"),
    ("two scales", "", "reflectance scale factor = 2\ndata gain values = {1, 1, 1, 1, 1}",
     ":12:28: error: a reflectance scale factor of 2 and a gain of 1 in band 1 are two scales"),
    ("a factor of 0", "", "reflectance scale factor = 0", ":12:28: error: reflectance scale factor 0 must be above 0"),
    ("an infinite gain", "", "data gain values = {1e999, 1, 1, 1, 1}", ":12:21: error: data gain values 1e999 is too"),
    ("half a bad band", "", "bbl = {1, 0.5, 1, 1, 1}", ":12:8: error: number 2 of bbl is 0.5; expected 1 for a good"),
    ("bad bands alone", "", "bbl = {0, 0, 0, 0, 0}", ":12:8: error: bbl marks all bands as bad"),
    ("an ignored word", "", "data ignore value = none", ":12:21: error: data ignore value must be a number"),
    ("compression", "", "file compression = 1", ":12:20: error: file compression other than 0"),
    ("gaps in the file", "", "major frame offsets = {0, 4}", ":12:24: error: major frame offsets other than 0"),
    ("a NUL", "", "\0", ": error: byte 199 is NUL, so this is no text file"),
    *((f"no {key}", key + " =", "x =", f": error: the line '{key} = ...' is missing")
      for key in ("samples", "lines", "bands", "data type", "interleave", "byte order")))


def refuses(here, name, words):
    result = run("develop", here, "-o", path("none"))
    check(result.returncode == 2 and words in result.stderr and result.stderr.count("\n") == 1 and
          not os.path.exists(path("none")), f"{name} is refused: {words}", result.stderr)


def test_refused_headers():
    here = cube("refused", COUNTS)
    whole = open(here).read()
    for name, old, new, words in REFUSED:
        assert old in whole
        write("refused.hdr", whole.replace(old, new, 1) if old else whole + new + "\n")
        refuses(here, name, here + words)
    write("refused.hdr", "")
    refuses(here, "an empty header", f"{here}:1:1: error: expected ENVI")
    write("refused.hdr", whole.split("wavelength")[0])
    refuses(here, "a cube without wavelengths", f"{here}: records no wavelengths; expected a stack")
    kept = []
    for length in range(0, len(whole) - 1, 3):
        write("refused.hdr", whole[:length])
        result = run("info", here)
        if result.returncode != 2 or result.stderr.count("\n") != 1:
            kept.append((whole[:length], result.returncode))
    # info needs no wavelengths
    check(kept and all(status == 0 and "byte order = 0" in text and "wavelength =" not in text
                       for text, status in kept),
          "a header that is cut is refused, or still has all that info prints", kept)


def test_refused_files():
    here = cube("refused", COUNTS)
    whole = open(here).read()
    needed = COUNTS.size * 4
    for name, size in (("a file that is a byte too short", needed - 1), ("an empty file", 0)):
        os.truncate(path("refused"), size)
        refuses(here, name, f"{path('refused')}: error: the file has {size} bytes; its header describes {needed}: "
                "6 samples x 7 lines x 5 bands of 4 bytes behind the first 0")
    os.truncate(path("refused"), needed)
    write("refused.hdr", whole.replace("offset = 0", "offset = 8000000000"))
    refuses(here, "an offset beyond the end", "of 4 bytes behind the first 8000000000")
    write("refused.hdr", whole.replace("= 6", "= 2147483647").replace("= 7", "= 2147483647"))
    refuses(here, "a side above the longest", "samples 2147483647 is out of range; it lies between 1 and 262144")
    os.remove(path("refused"))
    refuses(here, "a header without its data file", f"{here}: its data file is missing; expected {path('refused')}, or")
    os.remove(here)
    refuses(here, "a missing header", f"cannot read {here}: No such file")
    scene = write("untextured.scene", "size 9 9\nlight d65 1 direction 0 0 1\n"
                  "material m { diffuse 1 spectral-texture refused.hdr }\nobject plane 9 9 material m\n")
    result = run("plan", scene)
    check(result.returncode == 2 and f"{scene}:3:24: error: no file {here}" in result.stderr,
          "a scene that names it is the place", result.stderr)


def test_read_error():
    """A read that fails is the system's failure, not another picture."""
    library, source = path("failing.so"), write("failing.c", """
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdlib.h>
#include <unistd.h>
ssize_t pread64(int file, void *bytes, size_t length, off_t at)
{
    ssize_t (*real)(int, void *, size_t, off_t) = (ssize_t (*)(int, void *, size_t, off_t))dlsym(RTLD_NEXT, "pread64");
    static int left = -1;
    if (left < 0)
        left = atoi(getenv("READS"));
    if (left-- > 0)
        return real(file, bytes, length > 5 ? 5 : length, at);
    left = 0;
    errno = EIO;
    return -1;
}
""")
    compiler = shutil.which("gcc") or shutil.which("cc")
    subprocess.run([compiler, "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)
    for interleave in ORDER:
        here = cube("failing", COUNTS, 4, interleave)
        for reads, status in (("0", 3), ("20", 3), ("100000", 0)):
            result = run("compare", here, path("expected.tif"),
                         env={**os.environ, "LD_PRELOAD": library, "READS": reads})
            check(result.returncode == status and
                  (status == 0 or "Input/output error" in result.stderr),
                  f"{interleave}: after {reads} short reads the status is {status}", result.stderr)


def test_memory():
    """Memory does not grow with the cube. A file of holes takes no room on the disk."""
    def peak(height, interleave):
        nm = "{" + ", ".join(str(400 + 20 * i) for i in range(9)) + "}"
        here = write("large.hdr", "\n".join(lines(samples=2000, lines=height, bands=9, data_type=1, wavelength=nm,
                                                  interleave=interleave)))
        with open(path("large"), "wb") as out:
            out.truncate(2000 * height * 9)
        child = subprocess.Popen([SPECTRAL, "develop", here, "-o", "/dev/null", "--quiet", "--threads", "1"])
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        os.remove(path("large"))
        return usage.ru_maxrss if child.returncode == 0 else None
    for interleave in ORDER:  # develop takes 1048 rows at a time: two whole pieces, and six
        small, large = peak(2 * 1048, interleave), peak(6 * 1048, interleave)  # 38 and 113 MB
        check(small and large and large < small + 16384, f"{interleave}: three times as many rows take the same memory",
              small, large)


# ---- cubes of other programs ----

def test_spy(spy):
    cube_of = COUNTS.transpose(1, 2, 0)
    differ = []
    for i, kind in enumerate(TYPES.values()):
        for j, interleave in enumerate(ORDER):
            spy.envi.save_image(path("spy.hdr"), cube_of.astype(kind), dtype=kind, interleave=interleave,
                                byteorder=(i + j) % 2, force=True, metadata={
                                    "wavelength": [str(nm) for nm in NM], "wavelength units": "Nanometers"})
            same = equal(path("expected.tif"), path("spy.hdr"))
            if not same[0]:
                differ.append((kind, interleave, same[1]))
    check(not differ, "cubes that SPy writes in all types, interleaves and byte orders are the same", *differ[:1])


def test_gdal(gdal):
    gdal.UseExceptions()
    names = {"u1": "Byte", "i2": "Int16", "i4": "Int32", "f4": "Float32", "f8": "Float64", "u2": "UInt16",
             "u4": "UInt32"}
    differ = []
    for kind, name in names.items():
        for interleave in ORDER:
            out = gdal.GetDriverByName("ENVI").Create(path("gdal.img"), WIDTH, HEIGHT, len(NM),
                                                      getattr(gdal, "GDT_" + name), ["INTERLEAVE=" + interleave])
            for i, nm in enumerate(NM):
                out.GetRasterBand(i + 1).WriteArray(COUNTS[i].astype(kind))
                out.GetRasterBand(i + 1).SetDescription(f"{nm} nm")
            out.SetMetadataItem("wavelength_units", "Nanometers", "ENVI")
            out.SetMetadataItem("wavelength", "{" + ", ".join(map(str, NM)) + "}", "ENVI")
            out = None
            same = equal(path("expected.tif"), path("gdal.img"))
            if not same[0]:
                differ.append((kind, interleave, same[1], open(path("gdal.hdr")).read()))
    check(not differ, "cubes that GDAL writes in its types and interleaves are the same", *differ[:1])


# ---- out ----

def header_of(name):
    """A header as this test reads it."""
    text = open(name).read()
    first, rest = text.split("\n", 1)
    assert first == "ENVI"
    values = {}
    while rest.strip():
        key, rest = rest.split("=", 1)
        end = rest.index("}") + 1 if rest.lstrip().startswith("{") else rest.index("\n")
        value, rest = rest[:end].strip(), rest[end:]
        values[key.strip()] = [part.strip() for part in value[1:-1].split(",")] if value[0] == "{" else value
    return values


def mapped(stack, header):
    """The samples as numpy maps them."""
    kind = TYPES[int(header["data type"])]
    shape = [int(header[key]) for key in ("bands", "lines", "samples")]
    order = ORDER[header["interleave"]]
    whole = np.memmap(stack, (">" if header["byte order"] == "1" else "<") + kind, "r", int(header["header offset"]),
                      tuple(shape[i] for i in order))
    return whole.transpose(np.argsort(order))


def describe(name, *options):
    """Renders a stack with its header."""
    stack = path(name)
    for old in (stack, stack + ".hdr"):
        if os.path.exists(old):
            os.remove(old)
    result = run("render", "patches", "--size", "30x20", "--renderer", "raster", "-o", stack, "--envi", *options)
    check(result.returncode == 0 and f"stack             {stack}\nheader            {stack}.hdr\n" in result.stdout,
          f"{name} is rendered with its header", result.stderr)
    return stack


def test_sidecars(spy, gdal):
    for name, options in (("counts.tif", ()), ("bytes.tif", ("--depth", "8")), ("floats.tif", ("--depth", "32f")),
                          ("list.tif", ("--wavelengths", "450,500.5,620")), ("one.tif", ("--wavelengths", "550")),
                          ("gauss.tif", ("--sampling", "gauss:4")), ("rgb.tif", ("--sampling", "rgb")),
                          ("basis.tif", ("--sampling", "basis:3"))):
        full = {"bytes.tif": 255, "floats.tif": None}.get(name, 65535)
        stack = describe(name, *options)
        header = header_of(stack + ".hdr")
        with tifffile.TiffFile(stack) as file:
            pages = np.array([page.asarray() for page in file.pages])
            labels = [page.tags[285].value for page in file.pages]
            scale = float(file.pages[0].tags[270].value.split("full_scale: ")[1].split("\n")[0])
        check(np.array_equal(mapped(stack, header), pages) and pages.max() > 0, f"{name}: numpy maps the same samples")
        check(header["band names"] == labels, f"{name}: bands have the pages' names", header["band names"])
        components = name in ("rgb.tif", "basis.tif")
        nm = [] if components else [float(label.split()[0]) for label in labels]
        check([float(x) for x in header.get("wavelength", [])] == nm and
              ("wavelength units" in header) == (not components) and
              (components or header["wavelength units"] == "Nanometers"),
              f"{name}: wavelengths are those of the pages", header.get("wavelength"))
        widths = [] if len(nm) < 2 else np.gradient(nm)
        check(np.allclose([float(x) for x in header.get("fwhm", [])], widths, rtol=1e-9),
              f"{name}: a width is the mean distance to the neighbours", header.get("fwhm"))
        gains = [float(x) for x in header.get("data gain values", [])]
        check(gains == ([] if full is None else [scale / full] * len(labels)), f"{name}: gains give radiance",
              gains[:1])
        if not components:
            same = equal(stack, stack + ".hdr")
            check(same[0], f"{name}: the program reads the same radiances by the header", same[1])
        again = path("again.hdr")
        result = run("envi", stack, "-o", again)
        check(result.returncode == 0 and open(again).read() == open(stack + ".hdr").read() and not result.stdout,
              f"{name}: the command envi writes the same header", result.stderr)
        if spy:
            image = spy.envi.open(stack + ".hdr")
            check(np.array_equal(image.open_memmap(interleave="bsq"), pages) and (image.bands.centers or []) == nm and
                  np.allclose(image.bands.bandwidths or [], widths) and image.scale_factor == 1,
                  f"{name}: SPy maps the samples, with wavelengths")
        if gdal:
            check_gdal(gdal, stack, pages, nm, labels, gains)


def check_gdal(gdal, stack, pages, nm, labels, gains):
    gdal.UseExceptions()
    image = gdal.OpenEx(stack, allowed_drivers=["ENVI"])
    bands = [image.GetRasterBand(1 + i) for i in range(image.RasterCount)]
    name = os.path.basename(stack)
    check(len(bands) == len(pages) and np.array_equal(image.ReadAsArray().reshape(pages.shape), pages),
          f"{name}: GDAL's ENVI driver reads all bands from one file")
    check([float(band.GetMetadataItem("wavelength")) for band in bands if nm] == nm and
          all(band.GetDescription().startswith(label) for band, label in zip(bands, labels)),
          f"{name}: GDAL finds wavelengths and names", [band.GetMetadata() for band in bands][:1])
    check([band.GetScale() for band in bands if gains] == gains, f"{name}: GDAL finds the scale",
          [band.GetScale() for band in bands][:1], gains[:1])


def test_reflectance(spy):
    """Under a light of 1, radiance is reflectance: SPy then reads it."""
    stack = describe("lit-by-one.tif", "--light", "1=1")
    header = header_of(stack + ".hdr")
    factor = float(header["reflectance scale factor"])
    check(abs(factor * float(header["data gain values"][0]) - 1) < 1e-15, "a scale factor under a light of 1", factor)
    check(equal(stack, stack + ".hdr")[0], "gain and factor are one scale")
    if spy:
        seen = spy.envi.open(stack + ".hdr").load().transpose(2, 0, 1)
        with tifffile.TiffFile(stack) as file:
            expected = np.array([page.asarray() for page in file.pages]) / factor
        check(np.allclose(seen, expected, rtol=1e-6) and 0.5 < seen.max() <= 1, "SPy reads reflectances", seen.max())
    check("reflectance scale factor" not in header_of(describe("lit-by-two.tif", "--light", "1=1*2") + ".hdr"),
          "no scale factor under a light of 2")


def test_foreign():
    """Any stack whose pages lie raw and without gaps has a header; any other is refused."""
    def pages(name, **more):
        with tifffile.TiffWriter(path(name), byteorder=more.pop("byteorder", "<")) as out:
            for page, wavelength in zip(COUNTS.astype(np.uint16), NM):
                out.write(page, metadata=None, contiguous=False, photometric=more.get("photometric", "minisblack"),
                          extratags=[(285, "s", 0, f"{wavelength} nm", True)], compression=more.get("compression"))
        return path(name)
    ome = path("foreign.ome.tif")
    for order in "<>":
        tifffile.imwrite(ome, COUNTS.astype(np.uint16), photometric="minisblack", byteorder=order, metadata={
            "axes": "CYX", "Channel": {"EmissionWavelength": NM, "EmissionWavelengthUnit": ["nm"] * len(NM)}})
        result = run("envi", ome)
        check(result.returncode == 0 and np.array_equal(mapped(ome, header_of(ome + ".hdr")), COUNTS),
              f"a foreign stack, byte order {order}, is described", result.stderr)
        check(equal(ome, ome + ".hdr", "--tolerance", "1e-9")[0], "both are the same radiances")
    os.remove(ome + ".hdr")
    for name, words, more in (("gaps.tif", "page 2 begins at byte", {}),
                              ("packed.tif", "page 1 is compressed", {"compression": "zlib"}),
                              ("white.tif", "page 1 stores white as 0", {"photometric": "miniswhite"})):
        stack = pages(name, **more)
        result = run("envi", stack)
        check(result.returncode == 2 and words in result.stderr and result.stderr.count("\n") == 1 and
              not os.path.exists(stack + ".hdr"), f"{name} is refused: {words}", result.stderr)
    result = run("envi", cube("kind", COUNTS, 12), "-o", path("none"))
    check(result.returncode == 2 and "is an ENVI cube, which has a header" in result.stderr, "a cube is refused",
          result.stderr)
    result = run("envi", "patches")
    check(result.returncode == 2 and "is a scene, not a stack" in result.stderr, "a scene is refused", result.stderr)
    result = run("envi", ome, "-o", ome)
    check(result.returncode == 2 and "would replace the input" in result.stderr,
          "the header does not replace the stack")
    gdal = module("osgeo.gdal")
    if gdal:
        gdal.UseExceptions()
        for interleave in ("BAND", "PIXEL"):
            out = gdal.GetDriverByName("GTiff").Create(path("bands.tif"), WIDTH, HEIGHT, len(NM), gdal.GDT_UInt16,
                                                       ["INTERLEAVE=" + interleave])
            for i, nm in enumerate(NM):
                out.GetRasterBand(i + 1).SetMetadata({"wavelength": str(nm), "wavelength_units": "Nanometers"})
                out.GetRasterBand(i + 1).WriteArray(COUNTS[i])
            out = None
            stack = path("bands.tif")
            result = run("envi", stack)
            check(result.returncode == 0 and np.array_equal(mapped(stack, header_of(stack + ".hdr")), COUNTS),
                  f"GDAL's bands, INTERLEAVE={interleave}, are described", result.stderr)


def test_whole_or_not():
    """The stack and its header appear together, or neither does."""
    small = ("render", "patches", "--size", "9x9", "--renderer", "raster", "--quiet")
    for output in ("/dev/null", "/dev/stdout", "-"):
        result = run(*small, "--envi", "-o", output)
        check(result.returncode == 2 and f"not {output}" in result.stderr and not result.stdout,
              f"--envi with -o {output} is refused", result.stderr)
    stack = path("whole.tif")
    os.makedirs(stack + ".hdr", exist_ok=True)
    result = run(*small, "--envi", "-o", stack)
    check(result.returncode == 2 and "it is a folder" in result.stderr and not os.path.exists(stack),
          "a folder in the header's place is refused before the stack is written", result.stderr)
    os.rmdir(stack + ".hdr")
    result = run(*small, "--envi", "-o", stack, "--json", stack + ".hdr")
    check(result.returncode == 2 and "is the header that --envi writes" in result.stderr and
          not os.path.exists(stack), "--json does not take the header's place", result.stderr)
    scene = write("own.tif.hdr", "material m { diffuse 0.5 }\nobject plane 2 2 material m\n"
                  "light d65 1 direction 0 0 1\n")
    result = run("render", scene, "--size", "9x9", "--renderer", "raster", "--envi",
                 "-o", path("own.tif"))
    check(result.returncode == 2 and "would replace the input" in result.stderr and
          not os.path.exists(path("own.tif")), "the header does not replace the scene", result.stderr)
    result = run(*small, "--envi", "-o", stack)
    old = open(stack + ".hdr").read()

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (3000, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
    # without restore_signals a file that grows beyond the limit is an error, not a signal
    result = run(*small, "--wavelengths", "400:700:1", "--envi", "-o", stack, preexec_fn=limit, restore_signals=False)
    check(result.returncode != 0 and open(stack + ".hdr").read() == old and equal(stack, stack + ".hdr")[0],
          "a full disk leaves the old pair", result.stderr)
    left = [name for name in os.listdir(TMP) if name.startswith(".whole")]
    check(not left, "and no temporary file", left)
    result = run(*small[:-1], "-o", stack)
    check(f"\nheader            {stack}.hdr is of an older stack; spectral envi {stack} renews it\n" in result.stdout,
          "without --envi a header that stays is named", result.stdout)
    result = run("render", "--again", stack, "--envi", "-o", path("new.tif"), "--quiet")
    check(result.returncode == 0 and open(path("new.tif.hdr")).read() == old, "--again writes the same header",
          result.stderr)
    result = run("render", "--again", stack, "--envi", "-o", "/dev/null", "--quiet")
    check(result.returncode == 2 and "--envi writes a header beside" in result.stderr,
          "--again into /dev/null has none", result.stderr)


def main():
    for name in os.listdir(TMP):
        if os.path.isfile(path(name)):
            os.remove(path(name))
    spy, gdal = module("spectral"), module("osgeo.gdal")
    test_kinds()
    test_extremes()
    test_header()
    test_names()
    test_scales()
    test_commands()
    test_refused_headers()
    test_refused_files()
    test_read_error()
    test_memory()
    if spy:
        test_spy(spy)
    if gdal:
        test_gdal(gdal)
    test_sidecars(spy, gdal)
    test_reflectance(spy)
    test_foreign()
    test_whole_or_not()
    done()


main()
