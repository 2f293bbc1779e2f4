#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Writes inputs for test/fuzz to begin with: the blocks of the pages for users, the records of stacks that lie there, and small
stacks as other programs write them: all compressions and layouts of GDAL's TIFF driver.

    test/make/fuzz_seeds.py FOLDER"""
import glob
import os
import re
import sys

import numpy as np
from osgeo import gdal

gdal.UseExceptions()
WIDTH, HEIGHT, BANDS = 7, 5, 3
TYPES = {"u1": gdal.GDT_Byte, "u2": gdal.GDT_UInt16, "f4": gdal.GDT_Float32}


def samples(kind):
    counts = np.arange(BANDS * HEIGHT * WIDTH).reshape(BANDS, HEIGHT, WIDTH)
    return (counts * (2 if kind == "u1" else 500 if kind == "u2" else 0.01)).astype(kind)


def bands(path, kind, *options):
    """One directory with a band for each wavelength, as GDAL writes cubes."""
    data = gdal.GetDriverByName("GTiff").Create(path, WIDTH, HEIGHT, BANDS, TYPES[kind],
                                                ["PHOTOMETRIC=MINISBLACK", *options])
    for i, plane in enumerate(samples(kind)):
        band = data.GetRasterBand(i + 1)
        band.WriteArray(plane)
        band.SetMetadataItem("wavelength", str(400 + 100 * i))
        band.SetMetadataItem("wavelength_units", "nm")


def page(path, kind, *options):
    data = gdal.GetDriverByName("GTiff").Create(path, WIDTH, HEIGHT, 3 if "RGB" in options[0] else 1, TYPES[kind],
                                                list(options))
    for i in range(data.RasterCount):
        data.GetRasterBand(i + 1).WriteArray(samples(kind)[i])


def blocks(folder):
    """The blocks of README and data/doc that are files of some kind."""
    for page_path in ["README.md", *sorted(glob.glob("data/doc/*.md"))]:
        with open(page_path, encoding="utf-8") as file:
            found = re.findall(r"^```(scene|csv|mtl|map)\b[^\n]*\n(.*?)^```", file.read(), re.MULTILINE | re.DOTALL)
        for i, (kind, text) in enumerate(found):
            with open(f"{folder}/{os.path.basename(page_path)[:-3]}-{i}.{kind}", "w", encoding="utf-8") as file:
                file.write(text)
    with open(f"{folder}/entries.mtl", "w", encoding="utf-8") as file:
        file.write("newmtl a\nKa 0 0 0\nKd 0.8 0.5 0.1\nKs 0.1 0.2 0.3\nKe 0 0 0.5\nNs 20\nillum 2\nnewmtl b\nKd 1 1 1\n")
    with open(f"{folder}/parts.map", "w", encoding="utf-8") as file:
        file.write('# parts\na material a\n"b c" mtl maps/mtl-entry-twice.mtl\n* material b\n')


def records(folder):
    """The descriptions of the stacks in the folder, which hold their records; '-' before those without wavelengths."""
    for stack in glob.glob(f"{folder}/stack-*.tif"):
        text = gdal.Open(stack).GetMetadataItem("TIFFTAG_IMAGEDESCRIPTION")
        mark = "-" if "components: yes" in text else "+"
        with open(stack.replace("/stack-", "/record-").replace(".tif", ""), "w", encoding="utf-8") as file:
            file.write(mark + text)


def main(folder):
    blocks(folder)
    records(folder)
    def path(name):
        return os.path.join(folder, name)
    compressions = ["NONE", "LZW", "DEFLATE", "PACKBITS", "JPEG", "ZSTD", "LZMA", "WEBP", "LERC"]
    offered = gdal.GetDriverByName("GTiff").GetMetadataItem("DMD_CREATIONOPTIONLIST")
    for compression in (name for name in compressions if f"<Value>{name}</Value>" in offered):
        kind = "u1" if compression in ("JPEG", "WEBP") else "u2"
        if compression != "WEBP":
            bands(path(f"foreign-{compression}.tif"), kind, f"COMPRESS={compression}")
            bands(path(f"foreign-{compression}-planes.tif"), kind, f"COMPRESS={compression}", "INTERLEAVE=BAND")
            page(path(f"page-{compression}.tif"), kind, f"COMPRESS={compression}")
        page(path(f"page-{compression}-rgb.tif"), "u1", "PHOTOMETRIC=RGB", f"COMPRESS={compression}")
    bands(path("foreign-predictor.tif"), "f4", "COMPRESS=DEFLATE", "PREDICTOR=3")
    bands(path("foreign-tiles.tif"), "u2", "TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=16", "COMPRESS=LZW", "PREDICTOR=2")
    bands(path("foreign-big.tif"), "u2", "BIGTIFF=YES", "ENDIANNESS=BIG")
    for kind in TYPES:
        bands(path(f"foreign-{kind}.tif"), kind)


if __name__ == "__main__":
    main(sys.argv[1])
