# SPDX-License-Identifier: MIT
"""Writes the picture of test_image.c, in the variants listed there, into the given folder: with tifffile, which
shares no code with libtiff, and with GDAL."""
import os
import sys

import numpy as np
import tifffile
from osgeo import gdal as GDAL

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
    """Writes one page after the other; extratags: a list for each page."""
    with tifffile.TiffWriter(name + ".tif", **options.pop("file", {})) as tiff:
        for page, samples in enumerate(pages):
            tiff.write(samples, extratags=extratags[page] if extratags else [],
                       contiguous=False, metadata=None, **options)


def write_ome(name, pages, **channels):
    tifffile.imwrite(name + ".ome.tif", np.stack(pages), ome=True, photometric="minisblack",
                     metadata={"axes": "CYX", "Channel": {"Name": ["a", "b > c", "d"], **channels}})


def nanometers(nm):
    return {"wavelength": f"{nm}", "wavelength_units": "Nanometers"}


def bands(name, dtype, *options, metadata=nanometers, scales=None, offsets=None):
    """Writes one directory with GDAL; `metadata` returns a band's metadata, or its micrometres."""
    kinds = {"uint8": GDAL.GDT_Byte, "uint16": GDAL.GDT_UInt16, "float32": GDAL.GDT_Float32}
    n_bands = PAGES + ("ALPHA=YES" in options)
    file = GDAL.GetDriverByName("GTiff").Create(name + ".tif", WIDTH, HEIGHT, n_bands, kinds[dtype],
                                                [*options, "PHOTOMETRIC=MINISBLACK"])
    for page, nm in enumerate(NM):
        band = file.GetRasterBand(page + 1)
        described = metadata(nm)
        if isinstance(described, float):
            band.SetMetadataItem("CENTRAL_WAVELENGTH_UM", f"{described:.10g}", "IMAGERY")
        elif described:
            band.SetMetadata(described)
        if scales:
            band.SetScale(scales[page])
        if offsets:
            band.SetOffset(offsets[page])
        samples = picture(page, 1, "uint32" if dtype == "float32" else dtype)
        band.WriteArray(samples.astype(np.float32) / 64 if dtype == "float32" else samples)
    return file


def write_bands():
    GDAL.UseExceptions()
    GDAL.SetConfigOption("GDAL_PAM_ENABLED", "NO")
    apart, deflate = "INTERLEAVE=BAND", "COMPRESS=DEFLATE"
    tiles = ("TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=32")
    bands("bands", "uint16", metadata=lambda nm: nm / 1000, scales=[0.001] * PAGES, offsets=[0] * PAGES)
    bands("bands_apart", "uint16", apart, "BLOCKYSIZE=5")
    bands("bands_um", "uint16", "BLOCKYSIZE=4", metadata=lambda nm: {
        "wavelength": f"{nm / 1000:.10g}", "wavelength_units": "Micrometers"})
    bands("bands_bytes", "uint8", "BIGTIFF=YES")
    bands("bands_float", "float32", "BLOCKYSIZE=7")
    bands("bands_big_endian", "float32", "ENDIANNESS=BIG")
    bands("bands_deflated", "uint16", deflate, "PREDICTOR=2", "BLOCKYSIZE=8", "ENDIANNESS=BIG")
    bands("bands_tiles", "uint16", deflate, *tiles)
    bands("bands_tiles_apart", "float32", deflate, "PREDICTOR=3", apart, "BIGTIFF=YES", *tiles)
    bands("bands_lzw_apart", "uint8", "COMPRESS=LZW", apart, "BLOCKYSIZE=6")
    bands("bands_lacking", "uint16", metadata=lambda nm: nanometers(nm) if nm < 700 else {})
    bands("bands_furlong", "uint16", metadata=lambda nm: {
        "wavelength": f"{nm}", "wavelength_units": "Furlongs"})
    bands("bands_falling", "uint16", metadata=lambda nm: nanometers(700 if nm < 500 else nm))
    bands("bands_rgb", "uint8", "PHOTOMETRIC=RGB")
    bands("bands_untold", "uint16", metadata=lambda nm: {})
    bands("bands_alpha", "uint16", "ALPHA=YES")
    bands("bands_overviews", "uint16").BuildOverviews("NEAREST", [2])
    bands("bands_scales", "uint16", scales=[1, 2, 1])
    bands("bands_offset", "uint16", offsets=[0, 0, 0.5])


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
    for name, unit, length in (("ome", "nm", 1), ("ome_um", "µm", 1e-3), ("ome_angstrom", "Å", 10),
                               ("ome_m", "m", 1e-9), ("ome_furlong", "furlong", 1)):
        write_ome(name, grey, EmissionWavelength=[nm * length for nm in NM],
                  EmissionWavelengthUnit=[unit] * PAGES)
    write_ome("ome_lacking", grey, EmissionWavelength=[400.5, None, 700])
    write_bands()
    write("volume", [np.stack(grey)], volumetric=True, tile=(1, 16, 16), photometric="minisblack")


main()
