#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile python3-gdal gdal-bin python3-spectral
"""ENVI cubes in and out.

In: a cube is refused with the command of GDAL that makes a stack of it, for cubes of every type, order of bytes and
interleave, written here by numpy: that stack has the cube's values and wavelengths.
Out: SPy, GDAL and numpy map a stack by its header, and find the samples, wavelengths and scales that tifffile finds."""
import os
import shlex
import shutil
import subprocess

import numpy as np
import spectral
import tifffile
from osgeo import gdal

from rendered import TMP, check, done, pages_of, refuses, remove, run, write, write_stack

gdal.UseExceptions()
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


# ---- in ----

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
    for words in (("develop",), ("probe", "1", "1"), ("compare", path("expected.tif")), ("view",), ("info",), ("envi",)):
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
    remove(stack, stack + ".hdr")
    run("render", "patches", "--size", "30x20", "--renderer", "raster", "-o", stack, *options)
    result = run("envi", stack)
    check(result.returncode == 0 and result.stdout == f"header            {stack}.hdr\n",
          f"{name} gets its header", result.stdout, result.stderr)
    return stack


def test_sidecars():
    for name, options in (("counts.tif", ()), ("bytes.tif", ("--depth", "8")), ("floats.tif", ("--depth", "32f")),
                          ("list.tif", ("--wavelengths", "450,500.5,620")), ("one.tif", ("--wavelengths", "550")),
                          ("gauss.tif", ("--sampling", "gauss:4")), ("rgb.tif", ("--sampling", "rgb")),
                          ("basis.tif", ("--sampling", "basis:3"))):
        full = {"bytes.tif": 255, "floats.tif": None}.get(name, 65535)
        stack = describe(name, *options)
        header = header_of(stack + ".hdr")
        pages = pages_of(stack)
        with tifffile.TiffFile(stack) as file:
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
        again = path("again.hdr")
        result = run("envi", stack, "-o", again)
        check(result.returncode == 0 and open(again).read() == open(stack + ".hdr").read() and
              result.stdout == f"header            {again}\n",
              f"{name}: the header in another place is the same", result.stdout, result.stderr)
        image = spectral.envi.open(stack + ".hdr")
        check(np.array_equal(image.open_memmap(interleave="bsq"), pages) and (image.bands.centers or []) == nm and
              np.allclose(image.bands.bandwidths or [], widths) and image.scale_factor == 1,
              f"{name}: SPy maps the samples, with wavelengths")
        check_gdal(stack, pages, nm, labels, gains)


def check_gdal(stack, pages, nm, labels, gains):
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


def test_reflectance():
    """Under a light of 1, radiance is reflectance: SPy then reads it."""
    stack = describe("lit-by-one.tif", "--light", "1=1")
    header = header_of(stack + ".hdr")
    factor = float(header["reflectance scale factor"])
    check(abs(factor * float(header["data gain values"][0]) - 1) < 1e-15, "a scale factor under a light of 1", factor)
    seen = spectral.envi.open(stack + ".hdr").load().transpose(2, 0, 1)
    check(np.allclose(seen, pages_of(stack) / factor, rtol=1e-6) and 0.5 < seen.max() <= 1, "SPy reads reflectances", seen.max())
    check("reflectance scale factor" not in header_of(describe("lit-by-two.tif", "--light", "1=1*2") + ".hdr"),
          "no scale factor under a light of 2")


def test_foreign():
    """Any stack whose pages lie raw and without gaps has a header; any other is refused."""
    ome = path("foreign.ome.tif")
    for order in "<>":
        tifffile.imwrite(ome, COUNTS.astype(np.uint16), photometric="minisblack", byteorder=order, metadata={
            "axes": "CYX", "Channel": {"EmissionWavelength": NM, "EmissionWavelengthUnit": ["nm"] * len(NM)}})
        result = run("envi", ome)
        check(result.returncode == 0 and np.array_equal(mapped(ome, header_of(ome + ".hdr")), COUNTS),
              f"a foreign stack, byte order {order}, is described", result.stderr)
    os.remove(ome + ".hdr")
    for name, words, options in (("gaps.tif", "page 2 begins at byte", {}),
                                 ("packed.tif", "page 1 is compressed", {"compression": "zlib"}),
                                 ("white.tif", "page 1 stores white as 0", {"photometric": "miniswhite"})):
        stack = write_stack(name, COUNTS.astype(np.uint16), NM, **options)
        refuses(f"{name}: {words}", words, "envi", stack, absent=stack + ".hdr")
    last = write_stack("last.tif", COUNTS[:2].astype(np.uint16), NM[:2])
    refuses("a gap before the last page", "page 2 begins at byte", "envi", last, absent=last + ".hdr")
    refuses("a scene", "is a scene, not a stack", "envi", "patches")
    for interleave in ("BAND", "PIXEL"):
        stack = path("bands.tif")
        out = gdal.GetDriverByName("GTiff").Create(stack, WIDTH, HEIGHT, len(NM), gdal.GDT_UInt16, ["INTERLEAVE=" + interleave])
        for i, nm in enumerate(NM):
            out.GetRasterBand(i + 1).SetMetadata({"wavelength": str(nm), "wavelength_units": "Nanometers"})
            out.GetRasterBand(i + 1).WriteArray(COUNTS[i])
        out = None
        result = run("envi", stack)
        check(result.returncode == 0 and np.array_equal(mapped(stack, header_of(stack + ".hdr")), COUNTS),
              f"GDAL's bands, INTERLEAVE={interleave}, are described", result.stderr)


def test_older():
    """A header that a new stack leaves where it is is named."""
    stack = describe("older.tif")
    result = run("render", "patches", "--size", "9x9", "--renderer", "raster", "-o", stack)
    check(f"\nheader            {stack}.hdr is of an older stack; spectral envi {stack} renews it\n" in result.stdout,
          "a header that stays is named", result.stdout)


def main():
    for name in os.listdir(TMP):
        if os.path.isfile(path(name)):
            os.remove(path(name))
    test_cubes()
    test_names()
    test_sidecars()
    test_reflectance()
    test_foreign()
    test_older()
    done()


main()
