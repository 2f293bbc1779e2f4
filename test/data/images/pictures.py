#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Pictures of other programs are read as these programs mean them: PNG and SGI textures, GDAL's nodata, overviews and missing
blocks, the spellings of units, the order of OME's pages. All are written here, without libtiff. Prints TAP."""
import json
import os
import struct
import zlib

import numpy as np
import tifffile

from rendered import TMP, check, done, run, write

RNG = np.random.default_rng(1)
SCENE = """size 24 16
wavelengths 450 650 100
camera ortho 2.4 eye 0 0 5 look 0 0 0
light 1 1 direction 0 0 1
"""


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def paeth(left, above, corner):
    near = [abs(left + above - corner - p) for p in (left, above, corner)]
    return (left, above, corner)[near.index(min(near))]


def png(samples, head=None):
    """A PNG whose rows go through the five filters in turn, in several IDAT chunks."""
    height, width, channels = samples.shape
    pixel = channels * samples.itemsize
    rows = [row.astype(samples.dtype.newbyteorder(">")).tobytes() for row in samples]
    raw, above = b"", bytes(width * pixel)
    for y, row in enumerate(rows):
        left, corner = bytes(pixel) + row[:-pixel], bytes(pixel) + above[:-pixel]
        guess = [lambda i: 0, lambda i: left[i], lambda i: above[i], lambda i: (left[i] + above[i]) // 2,
                 lambda i: paeth(left[i], above[i], corner[i])][y % 5]
        raw += bytes([y % 5]) + bytes((value - guess(i)) % 256 for i, value in enumerate(row))
        above = row
    packed = zlib.compress(raw)
    head = head or struct.pack(">IIBBBBB", width, height, 8 * samples.itemsize, (0, 4, 2, 6)[channels - 1], 0, 0, 0)
    data = b"".join(chunk(b"IDAT", packed[i:i + 40]) for i in range(0, len(packed), 40))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + data + chunk(b"IEND", b"")


def packed(row):
    """A row of an SGI file: two samples as they are, then runs of equal ones."""
    flag = np.array([128 + 2], row.dtype).tobytes() + row[:2].tobytes()
    runs = b"".join(np.array([1, value], row.dtype).tobytes() for value in row[2:])
    return flag + runs + np.array([0], row.dtype).tobytes()


def sgi(samples, packs):
    height, width, channels = samples.shape
    planes = np.moveaxis(samples[::-1], 2, 0).astype(samples.dtype.newbyteorder(">"))
    head = struct.pack(">HBBHHHHII", 474, packs, samples.itemsize, 3, width, height, channels, 0, 255).ljust(512, b"\0")
    if not packs:
        return head + planes.tobytes()
    rows = [packed(row) for plane in planes for row in plane]
    starts = 512 + 8 * len(rows) + np.cumsum([0] + [len(row) for row in rows[:-1]])
    return head + starts.astype(">u4").tobytes() + np.array([len(row) for row in rows], ">u4").tobytes() + b"".join(rows)


def drawn(name, lines):
    """the stack of a scene"""
    path = write(name + ".scene", SCENE + lines)
    result = run("render", path, "-o", f"{TMP}/{name}-out.tif", "--depth", "32f", "--quiet")
    return tifffile.imread(f"{TMP}/{name}-out.tif") if result.returncode == 0 else result.stderr


def save(name, content):
    with open(f"{TMP}/{name}", "wb") as file:
        file.write(content)


def textured(name):
    return drawn(name.replace(".", "-"), f"material m {{ diffuse 1 texture {name} }}\nobject plane 2.4 1.6 material m\n")


# ---- PNG and SGI ----
for channels in 1, 2, 3, 4:
    for dtype in np.uint8, np.uint16:
        samples = RNG.integers(0, np.iinfo(dtype).max, (7, 5, channels), dtype, endpoint=True)
        kind = f"{channels} channels of {samples.itemsize * 8} bits"
        tifffile.imwrite(f"{TMP}/t.tif", samples if channels > 1 else samples[..., 0],
                         photometric="rgb" if channels > 2 else "minisblack",
                         extrasamples=["unassalpha"] if channels in (2, 4) else None)
        expected = textured("t.tif")
        for name, content in ("t.png", png(samples)), ("t.sgi", sgi(samples, False)), ("t.rgb", sgi(samples, True)):
            save(name, content)
            got = textured(name)
            check(np.array_equal(got, expected), f"{name} of {kind} is the TIFF of its samples", got)
os.makedirs(f"{TMP}/rgb", exist_ok=True)
save("rgb/wood0.rgb", sgi(RNG.integers(0, 255, (8, 8, 3), np.uint8), True))
write("wood0.txt", "300 0.5\n760 0.5\ng 20\ns 300 0.2\ns 760 0.2\nt rgb/wood0.rgb\n")
result = run("render", write("wood.list", "wood0.txt\n"), "--size", "60x40", "-o", f"{TMP}/wood.tif", "--json", "-", "--quiet")
check(result.returncode == 0 and json.loads(result.stdout)["check"]["unexplained_pixels"] == 0,
      "a material file of the thesis with its texture line, t rgb/wood0.rgb, is drawn and checked", result.stderr)
whole = png(RNG.integers(0, 255, (7, 5, 3), np.uint8))
for name, content, why in (
        ("cut.png", whole[:-30], "damaged or was cut"), ("bit.png", whole[:60] + bytes([whole[60] ^ 1]) + whole[61:], "damaged"),
        ("palette.png", png(np.zeros((2, 2, 1), np.uint8), struct.pack(">IIBBBBB", 2, 2, 8, 3, 0, 0, 0)), "grey or RGB"),
        ("interlaced.png", png(np.zeros((2, 2, 1), np.uint8), struct.pack(">IIBBBBB", 2, 2, 8, 0, 0, 0, 1)), "interlaced"),
        ("huge.png", png(np.zeros((2, 2, 1), np.uint8), struct.pack(">IIBBBBB", 2**31, 2, 8, 0, 0, 0, 0)), "262144"),
        ("cut.sgi", sgi(np.zeros((4, 4, 3), np.uint8), True)[:-9], "damaged or was cut"),
        ("tiny.sgi", b"\x01\xda\x00", "header")):
    save(name, content)
    got = textured(name)
    check(isinstance(got, str) and f"{name}: " in got and why in got, f"{name} is refused: {why}", got)

# ---- map_Kd: the texels of red, green and blue are those of the bands where an MTL's colours lie ----
write("quad.obj", "mtllib two words.mtl\nv -1.2 -0.8 0\nv 1.2 -0.8 0\nv 1.2 0.8 0\nv -1.2 0.8 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
      "usemtl my wood\nf 1/1 2/2 3/3 4/4\n")
colours = np.zeros((16, 24, 3), np.uint8)
colours[..., 0], colours[..., 1], colours[..., 2] = 255, 51, 102
save("tex.png", png(colours))
write("two words.mtl", "newmtl my wood\nKd 1 1 0.5\nmap_Kd -s 1 1 1 .\\tex.png\n")
got = drawn("quad", "object mesh quad.obj\n")
check(np.allclose([page[8, 12] for page in got], [0.2, 0.2, 1], atol=1e-6), "map_Kd is a picture of colours, times Kd", got)
result = run("render", write("note.scene", SCENE + "object mesh quad.obj\n"), "-o", f"{TMP}/note.tif")
check("\nnote" not in result.stdout, "a map_Kd that is drawn needs no note", result.stdout)
write("two words.mtl", "newmtl my wood\nKd 0.5 1 1\nmap_Kd none.jpg\nd 0.5\nKs 2 1 1\nNs 300\n")
result = run("render", f"{TMP}/note.scene", "-o", f"{TMP}/note.tif")
check(all(word in result.stdout for word in ("map_Kd", "transparency", "Ns", "Ks")) and result.stdout.count("not drawn of") == 1,
      "one note names all that a file loses", result.stdout)

# ---- stacks of other programs ----
NM = (450, 550, 650)


def items(unit="Nanometers", values=NM):
    text = "".join(f'<Item name="wavelength" sample="{i}">{nm}</Item><Item name="wavelength_units" sample="{i}">{unit}</Item>'
                   for i, nm in enumerate(values))
    return (42112, 2, 0, f"<GDALMetadata>{text}</GDALMetadata>", True)


def stack(name, samples, tags=(), **options):
    """Writes the bands as GDAL does, in one directory."""
    with tifffile.TiffWriter(f"{TMP}/{name}") as tiff:
        tiff.write(samples, photometric="minisblack", planarconfig="separate", extratags=[items(), *tags], metadata=None, **options)
    return f"{TMP}/{name}"


def spectrum(path, x, y):
    result = run("probe", path, str(x), str(y), "--json", "-")
    return json.loads(result.stdout)["radiance"] if result.returncode == 0 else result.stderr


bands = RNG.integers(1, 60000, (3, 48, 64), np.uint16)
for dtype, mark in (np.uint16, 65535), (np.uint8, 255), (np.float32, -9999), (np.float32, float("nan")):
    marked = (bands % 200).astype(dtype)
    marked[1, 2, 3] = mark
    got = spectrum(stack("nodata.tif", marked, [(42113, 2, 0, str(mark), True)]), 3, 2)
    scale = 1 if dtype == np.float32 else np.iinfo(dtype).max
    check(np.allclose(got, [marked[0, 2, 3] / scale, 0, marked[2, 2, 3] / scale]), f"nodata {mark} of {dtype.__name__} is 0", got)
path = stack("overviews.tif", bands)
for kind in 1, 4, 5:  # tifffile writes masks of one bit only
    with tifffile.TiffWriter(path, append=True) as tiff:
        tiff.write(bands[0, ::2, ::2], subfiletype=1, photometric="minisblack", metadata=None)
    with tifffile.TiffFile(path) as file:
        at = file.pages[-1].tags["NewSubfileType"].valueoffset
    with open(path, "r+b") as file:
        file.seek(at)
        file.write(struct.pack("<I", kind))
got = spectrum(path, 5, 6)
check(np.allclose(got, bands[:, 6, 5] / 65535), "overviews and masks behind the bands are passed over", got)
for unit, factor in (("nm", 1), ("NANOMETRE", 1), ("Microns", 1000), ("micrometer", 1000), ("\u03bcm", 1000), ("Angstroms", 0.1)):
    with tifffile.TiffWriter(f"{TMP}/unit.tif") as tiff:
        values = [nm / factor for nm in NM]
        tiff.write(bands, photometric="minisblack", planarconfig="separate", metadata=None, extratags=[
            (42112, 2, 0, items(unit, values)[3].encode("utf-8"), True)])
    result = run("info", f"{TMP}/unit.tif", "--json", "-")
    nm = json.loads(result.stdout)["wavelengths_nm"] if result.returncode == 0 else result.stderr
    check(np.allclose(nm, NM), f"wavelengths in {unit} become nm", nm)
for order in (0, 1, 2), (2, 1, 0):
    channels = "".join(f'<Channel ID="Channel:0:{i}" EmissionWavelength="{nm}"/>' for i, nm in enumerate(NM))
    places = "".join(f'<TiffData FirstC="{c}" IFD="{ifd}" PlaneCount="1"/>' for ifd, c in enumerate(order))
    xml = f'<?xml version="1.0"?><OME><Image ID="Image:0"><Pixels>{channels}{places}</Pixels></Image></OME>'
    with tifffile.TiffWriter(f"{TMP}/ome.tif") as tiff:
        for page in range(3):
            tiff.write(bands[page], description=xml if page == 0 else None, photometric="minisblack", metadata=None)
    got = spectrum(f"{TMP}/ome.tif", 5, 6)
    if order == (0, 1, 2):
        check(np.allclose(got, bands[:, 6, 5] / 65535), "OME's pages in the order of its channels are read", got)
    else:
        check("channel 2 page 0" in got, "another order of OME's pages is refused", got)

# ---- blocks that GDAL leaves out hold zeros ----
sparse = np.zeros((3, 48, 64), np.uint16)
sparse[:, 32:, 32:] = bands[:, 32:, 32:]
path = stack("sparse.tif", sparse, tile=(16, 16))
with tifffile.TiffFile(path) as file:
    tags = file.pages[0].tags
    places = [(tags[name].valueoffset, {3: "<H", 4: "<I"}[int(tags[name].dtype)]) for name in ("TileOffsets", "TileByteCounts")]
    tiles = len(tags["TileOffsets"].value)
with open(path, "r+b") as file:
    for at, form in places:
        for tile in (t for t in range(tiles) if t % 12 < 8 or t % 4 < 2):
            file.seek(at + tile * struct.calcsize(form))
            file.write(struct.pack(form, 0))
got = spectrum(path, 40, 40), spectrum(path, 3, 3)
check(np.allclose(got[0], bands[:, 40, 40] / 65535) and not np.any(got[1]), "missing tiles hold zeros, others their samples", got)
result = run("info", path)
check("record            none" in result.stdout and "wavelengths nm    450 to 650" in result.stdout,
      "info prints pages and wavelengths of a stack without a record", result.stdout, result.stderr)
for name in "made.tif", "made.png":
    run("develop", f"{TMP}/quad-out.tif", "-o", f"{TMP}/{name}")
    result = run("info", f"{TMP}/{name}")
    check("developed by" in result.stdout, f"info of {name}, a developed picture, says how it was made", result.stdout, result.stderr)
done()
