#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile python3-gdal
"""One picture, which has a closed form, is read from every variant of TIFF that GDAL and tifffile write, to the last bit: each lies on a
plane of its size, a texel a pixel, and all planes are in one scene. So are stacks, with their wavelengths and scales. Files that are
broken, cut short or of another kind are refused in a line. Prints TAP."""
import json
import os
import struct

import numpy as np
import tifffile
from osgeo import gdal as GDAL

from rendered import TMP, bytes_of, check, done, pages_of, path_of, reference, refuses, remove, run, write

WIDTH, HEIGHT, PAGES = 37, 29, 3
NM = [400.5, 500, 700]
KINDS = {"uint8": GDAL.GDT_Byte, "uint16": GDAL.GDT_UInt16, "float32": GDAL.GDT_Float32}


def picture(page, n_samples, dtype):
    """Neighbours, samples and pages all differ; floats are sixty-fourths."""
    y, x, s = np.mgrid[:HEIGHT, :WIDTH, :n_samples]
    counts = 7 * x + 131 * y + 1009 * s + 4099 * page + 1
    return (counts / 64 if dtype == "float32" else counts % (1 << 8 * np.dtype(dtype).itemsize)).astype(dtype).squeeze()


def radiance(samples, white_is_0=False):
    """ITU-R BT.709's luma of samples from 0 to 1."""
    parts = samples / (1 if samples.dtype == np.float32 else np.iinfo(samples.dtype).max)
    parts = parts[..., :3] @ [0.2126, 0.7152, 0.0722] if parts.ndim == 3 and parts.shape[2] > 2 else parts[..., 0] if parts.ndim == 3 else parts
    return 1 - parts if white_is_0 else parts


# ---- writers ----

def has_photometric(options):
    return any(option.startswith("PHOTOMETRIC=") for option in options)


def by_gdal(name, dtype, n_samples, *options, samples=None):
    """Returns the open file, whose bands have the samples."""
    samples = picture(0, n_samples, dtype) if samples is None else samples
    kind = [] if has_photometric(options) else ["PHOTOMETRIC=" + ("RGB" if n_samples > 2 else "MINISBLACK")]
    file = GDAL.GetDriverByName("GTiff").Create(path_of(name + ".tif"), *samples.shape[1::-1], n_samples, KINDS[dtype], [*options, *kind])
    for band in range(n_samples):
        file.GetRasterBand(band + 1).WriteArray(samples[..., band] if n_samples > 1 else samples)
    return file


def by_tifffile(name, pages, extratags=None, **options):
    """Writes one page after the other; extratags: a list for each page."""
    with tifffile.TiffWriter(path_of(name + ".tif"), **options.pop("file", {})) as tiff:
        for page, samples in enumerate(pages):
            tiff.write(samples, extratags=extratags[page] if extratags else [], contiguous=False, metadata=None, **options)


def items(*rows):
    """GDAL's metadata of a page: names, further attributes and values."""
    return 42112, 2, 0, "<GDALMetadata>" + "".join(f'<Item name="{name}" sample="0" {rest}>{value}</Item>' for name, rest, value in rows) + \
        "</GDALMetadata>", True


def scale(value):
    return "SCALE", 'role="scale"', value


def offset(value):
    return "OFFSET", 'role="offset"', value


def micrometres(nm):
    return "CENTRAL_WAVELENGTH_UM", 'domain="IMAGERY"', nm / 1000


def nanometers(nm):
    return ("wavelength", "", nm), ("wavelength_units", "", "Nanometers")


def named(text):
    return 285, 2, 0, text, True


def described(text):
    return 270, 2, 0, text, True


# ---- what the program reads ----

def read(names, words, pages, size=(WIDTH, HEIGHT)):
    """The radiances [file, page, y, x] of textures."""
    head = f"size {size[0] * len(names)} {size[1]}\nwavelengths list {pages}\ncamera ortho {size[0] * len(names)}\nambient 1 1\n"
    scene = write("read.scene", head + "".join(
        f"material m{i} {{ diffuse 1 {words} {name}.tif nearest }}\nobject plane {size[0]} {size[1]} material m{i} "
        f"translate {size[0] * (i - len(names) / 2 + 0.5)} 0 0\n" for i, name in enumerate(names)))
    return np.split(pages_of(reference("read.tif", scene, "--depth", "32f")), len(names), axis=2)


def compare(name, seen, expected, exact=True):
    """Grey is exact: the nearest float. A sum of three may be a unit in the last place off."""
    off = np.abs(seen - expected.astype(np.float32)).max()
    check(off <= (0 if exact else 1.2e-7 * expected.max()), f"{name}: every value is right", off)


def pictures():
    apart, tiled = "INTERLEAVE=BAND", ("TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=16")
    large = ("TILED=YES", "BLOCKXSIZE=48", "BLOCKYSIZE=48")
    kinds = [("grey 8", "uint8", 1), ("strips of 5 rows", "uint16", 1, "BLOCKYSIZE=5"), ("big-endian strips", "uint16", 1, "BLOCKYSIZE=5", "ENDIANNESS=BIG"),
             ("RGB apart, big-endian", "uint16", 3, apart, "BLOCKYSIZE=4", "ENDIANNESS=BIG"), ("RGB apart, a strip each", "uint8", 3, apart),
             ("white is 0", "uint8", 1, "PHOTOMETRIC=MINISWHITE"), ("white is 0 of 16 bits", "uint16", 1, "PHOTOMETRIC=MINISWHITE"),
             ("float", "float32", 1), ("float, big-endian", "float32", 1, "ENDIANNESS=BIG"), ("float, big-endian, tiles", "float32", 1, *tiled, "ENDIANNESS=BIG"),
             ("float, predicted", "float32", 1, "COMPRESS=DEFLATE", "PREDICTOR=3"), ("grey and alpha", "uint16", 2, "ALPHA=YES"),
             ("grey and alpha apart", "uint8", 2, "ALPHA=PREMULTIPLIED", apart), ("RGB in tiles", "uint16", 3, *tiled),
             ("RGB apart", "uint16", 3, apart, "BLOCKYSIZE=4"), ("RGB apart in tiles", "uint16", 3, apart, *tiled), ("RGBA 8", "uint8", 4, "ALPHA=PREMULTIPLIED"),
             ("RGBA 16 apart", "uint16", 4, "ALPHA=YES", apart), ("LZW, predicted", "uint16", 3, "COMPRESS=LZW", "PREDICTOR=2", "BLOCKYSIZE=7"),
             ("deflate in tiles", "uint16", 1, "COMPRESS=DEFLATE", *large), ("PackBits", "uint8", 1, "COMPRESS=PACKBITS", "BLOCKYSIZE=3"),
             ("Zstandard, predicted", "uint16", 1, "COMPRESS=ZSTD", "PREDICTOR=2"), ("LERC", "float32", 1, "COMPRESS=LERC"),
             ("WebP", "uint8", 3, "COMPRESS=WEBP", "WEBP_LOSSLESS=YES")]
    files = [(name, f"picture{i}", picture(0, n, dtype)) for i, (name, dtype, n, *_) in enumerate(kinds)]
    for (_, file, _), (_, dtype, n, *options) in zip(files, kinds):
        by_gdal(file, dtype, n, *options).FlushCache()
    grey, colour = picture(0, 1, "uint16"), picture(0, 3, "uint8")
    for name, samples, options in (("plain", grey, {"photometric": "minisblack"}), ("big", grey, {"file": {"bigtiff": True, "byteorder": ">"}}),
                                   ("deflated", grey, {"compression": "zlib", "predictor": True, "tile": (16, 32)}),
                                   ("lzma", grey, {"compression": "lzma", "rowsperstrip": 5}), ("rgb", colour, {"photometric": "rgb"}),
                                   ("turned", grey, {"rowsperstrip": 15})):
        by_tifffile(name, [samples], **options)
        files.append((name, name, samples))
    by_tifffile("planes", [np.moveaxis(colour, 2, 0)], photometric="rgb", planarconfig="separate", tile=(16, 16))
    by_tifffile("bits", [np.packbits(np.unpackbits(grey.view(np.uint8)).reshape(-1, 8)[:, ::-1]).view("<u2").reshape(grey.shape)],
                [[(265, 3, 1, 2, True)]])  # tifffile writes no order of bits: this tag becomes it
    patch("bits", struct.pack("<HHI", 265, 3, 1), struct.pack("<HHI", 266, 3, 1))
    exchange_strips("turned")
    files += [("planes of RGB", "planes", colour), ("bits in the other order", "bits", grey)]
    for (name, _, samples), seen in zip(files, read([file for _, file, _ in files], "texture", 550)):
        compare(name, seen[0], radiance(samples, name.startswith("white")), samples.ndim < 3 or samples.shape[2] < 3)


def patch(name, old, new):
    content = bytes_of(path_of(name + ".tif"))
    assert content.count(old) == 1
    save(name + ".tif", content.replace(old, new))


def save(name, content):
    with open(path_of(name), "wb") as out:
        out.write(content)


def exchange_strips(name):
    """The first of two strips then lies behind the second."""
    with tifffile.TiffFile(path_of(name + ".tif")) as tiff:
        tag, (first, second) = tiff.pages[0].tags["StripOffsets"], tiff.pages[0].tags["StripByteCounts"].value
        at = tag.value
    content = bytearray(bytes_of(path_of(name + ".tif")))
    content[at[0]:at[1] + second] = content[at[1]:at[1] + second] + content[at[0]:at[0] + first]
    content[tag.valueoffset:tag.valueoffset + 8] = struct.pack("<II", at[0] + second, at[0])
    save(name + ".tif", content)


def greys():
    """Three equal samples give the same grey as one, to the bit; white is 1. JPEG keeps a uniform colour but for rounding."""
    every = np.arange(65536, dtype=np.uint16).reshape(256, 256)
    by_tifffile("one", [every])
    by_tifffile("three", [np.stack([every] * 3, 2)], photometric="rgb")
    one, three = read(["one", "three"], "texture", 550, (256, 256))
    compare("all 65536 greys", one[0], every / 65535)
    check(np.array_equal(one, three), "they are equal from one sample and three")
    flat = np.full((32, 32, 3), (200, 100, 50), np.uint8)
    by_gdal("jpeg", "uint8", 3, "COMPRESS=JPEG", "PHOTOMETRIC=YCBCR", samples=flat).FlushCache()
    seen, = read(["jpeg"], "texture", 550, (32, 32))
    check(np.abs(seen - radiance(flat)).max() <= 1.5 / 255, "JPEG is read as RGB and reduced to its luma", seen)


# ---- wavelengths and scales ----

def bands(name, dtype, *options, metadata=lambda nm: dict((key, value) for key, _, value in nanometers(nm)), scales=None, offsets=None):
    """Writes one directory with GDAL; `metadata` returns a band's metadata, or its micrometres."""
    samples = np.stack([picture(page, 1, dtype) for page in range(PAGES)] + [picture(0, 1, dtype)] * ("ALPHA=YES" in options), 2)
    file = by_gdal(name, dtype, samples.shape[2], *options, *([] if has_photometric(options) else ["PHOTOMETRIC=MINISBLACK"]), samples=samples)
    for page, nm in enumerate(NM):
        band, says = file.GetRasterBand(page + 1), metadata(nm)
        if isinstance(says, float):
            band.SetMetadataItem("CENTRAL_WAVELENGTH_UM", f"{says:.10g}", "IMAGERY")
        elif says:
            band.SetMetadata({key: str(value) for key, value in says.items()})
        if scales:
            band.SetScale(scales[page])
        if offsets:
            band.SetOffset(offsets[page])
    return file


def ome(name, **channels):
    tifffile.imwrite(path_of(name + ".tif"), np.stack(GREY), ome=True, photometric="minisblack",
                     metadata={"axes": "CYX", "Channel": {"Name": ["a", "b > c", "d"], **channels}})


GREY = [picture(page, 1, "uint16") for page in range(PAGES)]
UNITS = (("nm", 1), ("µm", 1e-3), ("Å", 10), ("m", 1e-9))
LAYOUTS = (  # of bands in one directory
    ("apart", "uint16", "INTERLEAVE=BAND", "BLOCKYSIZE=5"), ("bytes", "uint8", "BIGTIFF=YES"), ("float", "float32", "BLOCKYSIZE=7"),
    ("big_endian", "float32", "ENDIANNESS=BIG"), ("deflated", "uint16", "COMPRESS=DEFLATE", "PREDICTOR=2", "BLOCKYSIZE=8", "ENDIANNESS=BIG"),
    ("tiles", "uint16", "COMPRESS=DEFLATE", "TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=32"),
    ("tiles_apart", "float32", "COMPRESS=DEFLATE", "PREDICTOR=3", "INTERLEAVE=BAND", "BIGTIFF=YES", "TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=32"),
    ("lzw_apart", "uint8", "COMPRESS=LZW", "INTERLEAVE=BAND", "BLOCKYSIZE=6"), ("packbits", "uint16", "COMPRESS=PACKBITS", "BLOCKYSIZE=6"),
    ("zstd", "uint16", "COMPRESS=ZSTD", "INTERLEAVE=BAND", "BLOCKYSIZE=6"), ("lzma", "uint16", "COMPRESS=LZMA", "BLOCKYSIZE=6"))


def stacks():
    """Names of stacks, the kind of their samples, and what a sample of 1 means."""
    by_tifffile("named", GREY, [[named(f"{nm:.10g} nm")] for nm in NM])
    by_tifffile("micrometres", GREY, [[items(micrometres(nm), offset(0), scale(0.0001))] for nm in NM])
    by_tifffile("nanometers", GREY, [[items(*nanometers(nm))] for nm in NM])
    by_tifffile("mixed", GREY, [[named("4005e-1 nm"), items(micrometres(300))], [named("500"), items(*nanometers(500), micrometres(300))],
                                [named("Page 3"), items(micrometres(700))]])
    by_tifffile("exact", GREY, [[named(f"{nm} nm"), items(scale("3.8e-05")), *[described("a\nfull_scale: 2.5\nscale: x")] * (nm < 500)] for nm in NM])
    by_tifffile("scaled_bytes", [picture(page, 1, "uint8") for page in range(PAGES)], [[named(f"{nm} nm"), items(scale(2))] for nm in NM])
    by_tifffile("scaled_floats", [picture(page, 1, "float32") for page in range(PAGES)],
                [[named(f"{nm} nm"), items(scale(1)), *[described("full_scale: 7\n")] * (nm < 500)] for nm in NM])
    for unit, length in UNITS:
        ome(f"ome{length:g}", EmissionWavelength=[nm * length for nm in NM], EmissionWavelengthUnit=[unit] * PAGES)
    bands("bands", "uint16", metadata=lambda nm: nm / 1000, scales=[0.001] * PAGES, offsets=[0] * PAGES).FlushCache()
    bands("bands_um", "uint16", "BLOCKYSIZE=4", metadata=lambda nm: {
        "wavelength": f"{nm / 1000:.10g}", "wavelength_units": "Micrometers"}).FlushCache()
    bands("bands_overviews", "uint16").BuildOverviews("NEAREST", [2])
    for name, dtype, *options in LAYOUTS:
        bands(f"bands_{name}", dtype, *options).FlushCache()
    return [("named", "uint16", 1), ("micrometres", "uint16", 0.0001 * 65535), ("nanometers", "uint16", 1), ("mixed", "uint16", 1), ("exact", "uint16", 2.5),
            ("scaled_bytes", "uint8", 510), ("scaled_floats", "float32", 1), *((f"ome{length:g}", "uint16", 1) for _, length in UNITS),
            ("bands", "uint16", 0.001 * 65535), ("bands_um", "uint16", 1), ("bands_overviews", "uint16", 1),
            *((f"bands_{name}", dtype, 1) for name, dtype, *_ in LAYOUTS)]


def wavelengths(files):
    for (name, dtype, factor), seen in zip(files, read([name for name, *_ in files], "spectral-texture", " ".join(map(str, NM)))):
        expected = np.stack([radiance(picture(page, 1, dtype)) * factor for page in range(PAGES)])
        compare(name, seen, expected)
        report = run("info", path_of(name + ".tif"), "--json", "-")
        check(report.returncode == 0 and np.allclose(json.loads(report.stdout)["wavelengths_nm"], NM, rtol=0, atol=1e-12),
              f"{name}: its wavelengths", report.stdout, report.stderr)
        for x, y, w, h in ((0, HEIGHT - 1, WIDTH, 1), (5, 7, 9, 4), (WIDTH - 1, 0, 1, HEIGHT)):  # rows alone
            said = run("probe", path_of(name + ".tif"), x, y, w, h, "--csv").stdout.splitlines()[1:]
            check(np.allclose([float(line.split(",")[1]) for line in said], expected[:, y:y + h, x:x + w].mean((1, 2)), rtol=1e-6),
                  f"{name}: {w} x {h} pixels from {x},{y}", said)
    by_tifffile("close", GREY[:2], [[named("500 nm")], [named("500.0000001 nm")]])
    check(json.loads(run("info", path_of("close.tif"), "--json", "-").stdout)["wavelengths_nm"] == [500, 500.0000001], "names of ten digits")


def untold():
    ome("ome_furlong", EmissionWavelength=NM, EmissionWavelengthUnit=["furlong"] * PAGES)
    ome("ome_lacking", EmissionWavelength=[400.5, None, 700])
    by_tifffile("zero", GREY[:2], [[named("0 nm")], [named("400 nm")]])
    by_tifffile("unknown", GREY[:1], [[items(("wavelength", "", 0.5))]])
    bands("bands_lacking", "uint16", metadata=lambda nm: {"wavelength": nm, "wavelength_units": "Nanometers"} if nm < 700 else {}).FlushCache()
    bands("bands_furlong", "uint16", metadata=lambda nm: {"wavelength": nm, "wavelength_units": "Furlongs"}).FlushCache()
    bands("bands_falling", "uint16", metadata=lambda nm: {"wavelength": 700 if nm < 500 else nm, "wavelength_units": "Nanometers"}).FlushCache()
    bands("bands_rgb", "uint8", "PHOTOMETRIC=RGB").FlushCache()
    for name, why in (("ome_furlong", "page 1 records its wavelength in 'furlong'; expected"), ("ome_lacking", "page 2 records no wavelength"),
                      ("bands_lacking", "page 3 records no wavelength"), ("bands_furlong", "page 1 records its wavelength in 'Furlongs'; expected"),
                      ("bands_falling", "decrease: page 2 records 500 nm after 700 nm"), ("zero", "wavelength"), ("unknown", "wavelength"),
                      ("bands_rgb", "its pages are RGB")):
        refuses(f"{name} as a stack", why, "probe", path_of(name + ".tif"), 0, 0)


# ---- refusals ----

def refused(file, what):
    """A line begins with the place in the scene, and names the file."""
    kind = "spectral-texture" if "nm)" in what or file.startswith("bands") else "texture"
    scene = write("refused.scene", f"size 4 4\nambient 1 1\nmaterial m {{ diffuse 1 {kind} {file} }}\nobject plane 99 99 material m\n")
    result = run("render", scene, "-o", "/dev/null", "--renderer", "raster", "--no-check")
    check(result.returncode == 2 and "refused.scene:3:" in result.stderr and result.stderr.count("\n") == 1 and file in result.stderr and what in result.stderr,
          f"refused: {file}: {what}", result.stderr)


def refused_pages():
    grey, byte, colour = GREY[0], picture(0, 1, "uint8"), picture(0, 3, "uint8")
    odd = {value: picture(0, 1, "float32") for value in (np.nan, np.inf, -0.5)}
    for value, samples in odd.items():
        samples[-1, -1] = value
    for i, (what, samples, options, *tags) in enumerate((
            ("neither grey", byte, {"photometric": "palette", "colormap": np.zeros((3, 256), np.uint16)}),
            ("neither grey", picture(0, 4, "uint8"), {"photometric": "separated"}), ("neither grey", colour, {"photometric": "cielab"}),
            ("1 of 16 bits, of another kind", grey.astype(np.int16), {}), ("1 of 32 bits, unsigned", grey.astype(np.uint32), {}),
            ("3 of 32 bits, float", picture(0, 3, "float32"), {"photometric": "rgb"}),
            ("1 of 32 bits, float", picture(0, 1, "float32"), {"photometric": "miniswhite"}),
            ("5 samples", picture(0, 5, "uint8"), {"photometric": "rgb", "extrasamples": ["unspecified"] * 2}),
            ("2 samples a pixel and records no", picture(0, 2, "uint8"), {"photometric": "minisblack", "planarconfig": "contig", "extrasamples": ["unspecified"]}),
            ("orientation is 4", byte, {}, (274, 3, 1, 4, True)),
            ("page 1 (305 nm): the value at column 36, row 28 is nan", odd[np.nan], {}, named("305 nm")),
            ("page 1: the value at column 36, row 28 is inf", odd[np.inf], {}), ("is -0.5; expected", odd[-0.5], {}),
            *(("scale is not positive", grey, {}, items(scale(value))) for value in ("0", "-1", "2x")),
            ("scale is not positive", grey, {}, described("full_scale: nan\n")),
            ("is inf; expected a finite number", byte, {"photometric": "miniswhite"}, described("full_scale: 1e300 \n")),
            ("an offset", grey, {}, items(offset(-1))))):
        by_tifffile(f"page{i}", [samples], [list(tags)], **{"photometric": "minisblack", **options})
        refused(f"page{i}.tif", what)
    for name, other, what, tags in (("bands_wide", byte, "page 2 (500 nm): it has 37x29x8 bits, the first page 37x29x16", ((), ())),
                                    ("bands_narrow", grey[:, 1:], "page 2 (500 nm): it has 36x29x16 bits", ((), ())),
                                    ("bands_scaled", grey, "page 2 (500 nm): its scale is not positive, or not that", (items(scale(1)), items(scale(2))))):
        by_tifffile(name, [grey, other], [[named("400 nm"), *tags[0:1] * bool(tags[0])], [named("500 nm"), *tags[1:] * bool(tags[1])]])
        refused(f"{name}.tif", what)


def refused_files():
    """test/cases/bad/textures has more: files of other kinds, and false claims of size."""
    bands("bands_untold", "uint16", metadata=lambda nm: {}).FlushCache()
    bands("bands_alpha", "uint16", "ALPHA=YES").FlushCache()
    bands("bands_scales", "uint16", scales=[1, 2, 1]).FlushCache()
    bands("bands_offset", "uint16", offsets=[0, 0, 0.5]).FlushCache()
    by_tifffile("volume", [np.stack(GREY)], volumetric=True, tile=(1, 16, 16), photometric="minisblack")
    save("empty.tif", b"")
    save("head.tif", b"II*\0\0\0\0\0")
    remove(path_of("pipe.tif"))
    os.mkfifo(path_of("pipe.tif"))
    by_gdal("short", "uint8", 1, "COMPRESS=JPEG").FlushCache()
    with tifffile.TiffFile(path_of("short.tif")) as tiff:  # libtiff only warns about a JPEG stream that ends early
        at = tiff.pages[0].tags["StripByteCounts"].valueoffset
    content = bytes_of(path_of("short.tif"))
    save("short.tif", content[:at] + struct.pack("<I", 400) + content[at + 4:])
    for file, what in (("bands_untold.tif", "it has 3 samples a pixel and records no wavelengths for them"),
                       ("bands_alpha.tif", "it has 4 samples a pixel instead of 1 and at most an alpha"),
                       ("bands_scales.tif", "page 2 (500 nm): its scale is not positive, or not that"),
                       ("bands_offset.tif", "page 3 (700 nm): its samples have an offset"), ("volume.tif", "37x29x3"), ("empty.tif", "libtiff: "),
                       ("head.tif", "libtiff: "), ("builtin:tables/d65.csv", "is a text file; expected TIFF"), ("pipe.tif", "it is no regular file"),
                       ("short.tif", "Premature end of JPEG")):
        refused(file, what)


def cuts():
    """A file without its end is refused, wherever it is cut."""
    own = reference("own.tif", "patches", "--size", f"{WIDTH}x{HEIGHT}", "--wavelengths", "400,500,600", "--depth", "32f")
    for path in (own, *(path_of(f"bands_{name}.tif") for name, *_ in LAYOUTS)):
        content = bytes_of(path)
        end = len(content) - (WIDTH * HEIGHT if path == own else 0)  # a stack of spectral ends with the map of its objects
        passed = []
        for length in {0, 7, 8, 40, end - 1, *np.linspace(1, end - 1, 24, dtype=int).tolist()}:
            save("cut.tif", content[:length])
            if run("probe", path_of("cut.tif"), 0, 0, WIDTH, HEIGHT).returncode != 2:
                passed.append(length)
        check(not passed, f"{os.path.basename(path)}: every shorter file is refused", passed)


GDAL.UseExceptions()
GDAL.SetConfigOption("GDAL_PAM_ENABLED", "NO")
os.makedirs(TMP, exist_ok=True)
pictures()
greys()
wavelengths(stacks())
untold()
refused_pages()
refused_files()
cuts()
done()
