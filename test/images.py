# SPDX-License-Identifier: MIT
"""Writes TIFF files with tifffile, which shares nothing with libtiff, into the folder named: the
picture of test_image.c in the variants that it lists there."""
import os
import sys

import numpy as np
import tifffile

WIDTH, HEIGHT, PAGES = 37, 29, 3
NM = [400.5, 500, 700]


def picture(page, n_samples, dtype):
    """The closed form of count_at in test_image.c."""
    y, x, s = np.mgrid[:HEIGHT, :WIDTH, :n_samples]
    counts = (7 * x + 131 * y + 1009 * s + 4099 * page + 1) % (1 << 8 * np.dtype(dtype).itemsize)
    return counts.astype(dtype).squeeze()


def gdal(items):
    text = "".join(f'<Item name="{name}" {rest}>{value}</Item>' for name, rest, value in items)
    text = f"<GDALMetadata>{text}</GDALMetadata>"
    return (42112, 2, len(text) + 1, text, True)


def write(name, pages, extratags=None, **options):
    """One page after the other; extratags: a list for each page."""
    with tifffile.TiffWriter(name + ".tif", **options.pop("file", {})) as tiff:
        for page, samples in enumerate(pages):
            tiff.write(samples, extratags=extratags[page] if extratags else [],
                       contiguous=False, metadata=None, **options)


def main():
    os.chdir(sys.argv[1])
    grey = [picture(page, 1, "uint16") for page in range(PAGES)]
    colour = picture(0, 3, "uint8")
    write("plain", grey[:1], photometric="minisblack")
    write("big", grey[:1], file={"bigtiff": True, "byteorder": ">"})
    write("deflated", grey[:1], compression="zlib", predictor=True, tile=(16, 32))
    write("lzma", grey[:1], compression="lzma", rowsperstrip=5)
    write("rgb", [colour], photometric="rgb")
    write("planes", [np.moveaxis(colour, 2, 0)], photometric="rgb", planarconfig="separate",
          tile=(16, 16))
    write("named", grey, [[(285, 2, 0, f"{nm:.10g} nm", True)] for nm in NM])
    write("micrometres", grey, [[gdal([
        ("CENTRAL_WAVELENGTH_UM", 'sample="0" domain="IMAGERY"', nm / 1000),
        ("OFFSET", 'sample="0" role="offset"', 0),
        ("SCALE", 'sample="0" role="scale"', 0.0001)])] for nm in NM])
    write("nanometers", grey, [[gdal([
        ("wavelength", 'sample="0"', nm),
        ("wavelength_units", 'sample="0"', "Nanometers")])] for nm in NM])
    for name, units in (("ome", ["nm"] * PAGES), ("ome_um", ["µm"] * PAGES)):
        tifffile.imwrite(name + ".ome.tif", np.stack(grey), ome=True, photometric="minisblack",
                         metadata={"axes": "CYX", "Channel": {
                             "Name": [f"{nm}" for nm in NM], "EmissionWavelength": NM,
                             "EmissionWavelengthUnit": units}})
    write("volume", [np.stack(grey)], volumetric=True, tile=(1, 16, 16), photometric="minisblack")


main()
