#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile gdal-bin
"""An ENVI cube is refused with the command of GDAL that makes a stack of it, for cubes of every type, order of bytes and
interleave, written here by numpy: that stack has the cube's values and wavelengths."""
import os
import shlex
import shutil
import subprocess

import numpy as np

from rendered import TMP, check, done, refuses, run, write, write_stack

TYPES = {1: "u1", 2: "i2", 3: "i4", 4: "f4", 5: "f8", 12: "u2", 13: "u4", 14: "i8", 15: "u8"}
ORDER = {"bsq": (0, 1, 2), "bil": (1, 0, 2), "bip": (1, 2, 0)}  # from band, row, column
NM = [400, 450.5, 500, 620, 700]
HEIGHT, WIDTH = 7, 6
COUNTS = np.random.default_rng(1).integers(0, 128, (len(NM), HEIGHT, WIDTH))  # each type holds them


def path(name):
    return os.path.abspath(os.path.join(TMP, name))


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


def refused(name, data, tif):
    """The words of the command that the refusal names."""
    result = run("info", path(name))
    check(result.returncode == 2 and result.stderr.count("\n") == 1 and
          f"{path(name)} is an ENVI cube; expected TIFF" in result.stderr, f"{name} is refused as a cube", result.stderr)
    words = shlex.split(result.stderr.partition(" by: ")[2])
    check(words[-2:] == [path(data), tif], f"{name}: the command names {data} and {tif}", words)
    return words


def test_cubes():
    """The command that the refusal names makes a stack with the values and the wavelengths of the cube."""
    scaled = {"data_gain_values": "{" + ", ".join(["0.5"] * len(NM)) + "}", "data_offset_values": "{1, 1, 1, 1, 1}"}
    metres = {"wavelength_units": "Micrometers", "wavelength": "{" + ", ".join(str(nm / 1000) for nm in NM) + "}"}
    for changes in ({}, scaled, metres):
        expected = write_stack("expected.tif", (COUNTS * 0.5 + 1 if changes is scaled else COUNTS).astype(np.float32), NM)
        differ = []
        for kind, name in TYPES.items():
            for interleave, big in (("bsq", False), ("bil", True), ("bip", False)):
                cube("a kind.img", COUNTS, kind, interleave, big, 37 * big, header="a kind.hdr", **changes)
                words = run("info", path("a kind.img")).stderr.partition(" by: ")[2]
                done_run = subprocess.run(shlex.split(words), cwd=TMP, check=False, capture_output=True)
                result = run("compare", expected, path("a kind.tif"))
                if (kind < 14 or done_run.returncode == 0) and result.returncode != 0:  # GDAL 3.6 reads no 64-bit integers
                    differ.append((name, interleave, big, done_run.stderr, result.stdout, result.stderr))
        check(not differ, f"gdal_translate keeps values and wavelengths of cubes of all types, {list(changes)}", *differ[:1])
    probed = run("probe", path("a kind.tif"), "2", "3", "--csv").stdout.splitlines()[1:]
    check([[float(x) for x in row.split(",")[:2]] for row in probed] == [[nm, count] for nm, count in zip(NM, COUNTS[:, 3, 2])],
          "probe prints the cube's spectrum", probed)


def test_names():
    """Each command names a cube that takes the place of a stack; either file is known."""
    here = cube("it's.img", COUNTS, 12, header="it's.hdr")
    for words in (("develop",), ("probe", "1", "1"), ("compare", path("expected.tif")), ("view",), ("info",)):
        for operand in (path("it's.img"), here):
            refuses(f"{words[0]} {operand}", "is an ENVI cube; expected TIFF", words[0], operand, *words[1:])
    for ending in ("", ".img", ".dat", ".raw", ".bsq", ".bil", ".bip"):
        cube("names" + ending, COUNTS, 12, header="names.hdr")
        for name in ("names.hdr", "names" + ending):
            words = refused(name, "names" + ending, "names.tif")
        os.remove(path("names" + ending))
    cube("odd.xyz", COUNTS, 12)
    refused("odd.xyz", "odd.xyz", "odd.tif")
    cube("other.xyz", COUNTS, 12, header="other.hdr")
    result = run("info", path("other.xyz"))
    check(result.returncode == 2 and "ENVI" not in result.stderr, "NAME.hdr belongs to known endings only", result.stderr)
    scene = write("textured.scene", "light d65 1 direction 0 0 1\nmaterial m { diffuse 1 spectral-texture odd.xyz }\n"
                  "object plane 9 9 material m\n")
    refuses("a spectral texture that is a cube", "textured.scene:2:24: error: .*is an ENVI cube", "plan", scene)
    shutil.copy(path("expected.tif"), path("named.tif"))
    cube("unused", COUNTS, header="named.tif.hdr")
    refuses("the header of a stack", f"is the ENVI header of {path('named.tif')}", "info", path("named.tif.hdr"))
    check(run("probe", path("named.tif"), "0", "0").returncode == 0, "a stack with a header is a stack")


def main():
    for name in os.listdir(TMP):
        if os.path.isfile(path(name)):
            os.remove(path(name))
    test_cubes()
    test_names()
    done()


main()
