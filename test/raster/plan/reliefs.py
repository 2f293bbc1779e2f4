#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile libosmesa6-dev; makes: faults
"""Tests reliefs by the program ($SPECTRAL): the surface is the one that numpy displaces, whatever the format of the
picture; closed shapes let no light through; what plan says is counted; only objects with a relief pay. Prints TAP."""
import re
import struct
import zlib

import numpy as np
import tifffile

from rendered import FAULTS, check, done, judged, output_of, path_of, reference, refuses, render, run, stack_of, write

VIEW = """wavelengths 450 650 100
size 150 100
camera perspective 40 near 1 far 20 eye 0 -2 5
ambient d65 0.1
light d65 1 position 3 2 1.5 shadows
light a 0.4 direction 0 -1 2
material m { diffuse 0.6 specular 0.3 gloss 20 }
"""


# ---- the surface, made by numpy ----

def sampled(heights, s, t):
    """A linear texture that repeats; heights has the picture's bottom row first."""
    high, wide = heights.shape
    x, y = s * wide - 0.5, t * high - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    a, b = x - i, y - j
    at = lambda di, dj: heights[(j + dj) % high, (i + di) % wide]  # noqa: E731
    return (1 - b) * ((1 - a) * at(0, 0) + a * at(1, 0)) + b * ((1 - a) * at(0, 1) + a * at(1, 1))


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def plane(width, n, repeat, heights):
    """A plane of n x n cells as an OBJ file: its points, and normals that are means of those of faces, by their angles."""
    v, u = np.mgrid[0:n + 1, 0:n + 1] / n
    points = np.stack([width * (u - 0.5), width * (v - 0.5), sampled(heights, u * repeat[0], v * repeat[1])], -1).reshape(-1, 3)
    low = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate([np.stack([low, low + 1, low + n + 2], 1), np.stack([low, low + n + 2, low + n + 1], 1)])
    normals = np.zeros_like(points)
    for k in range(3):
        a, b, c = (points[faces[:, (k + i) % 3]] for i in range(3))
        angle = np.arccos((unit(b - a) * unit(c - a)).sum(1))
        np.add.at(normals, faces[:, k], unit(np.cross(b - a, c - a)) * angle[:, None])
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()] + [f"vn {x!r} {y!r} {z!r}" for x, y, z in unit(normals).tolist()]
    lines += [" ".join(["f"] + [f"{i + 1}//{i + 1}" for i in face]) for face in faces.tolist()]
    return "\n".join(lines) + "\n"


def png(name, rgb, chunks=b""):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + row.tobytes() for row in rgb)
    with open(path_of(name), "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", rgb.shape[1], rgb.shape[0], 8, 2, 0, 0, 0)) + chunks +
                  chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
    return name


def pictures():
    """Reliefs of each format: a name, and the heights that it means, 0 to 1 or floats, bottom row first."""
    numbers = np.random.default_rng(7)
    grey8, grey16 = numbers.integers(0, 256, (9, 14), np.uint8), numbers.integers(0, 65536, (16, 8), np.uint16)
    floats, colours = (3 * numbers.random((6, 7))).astype(np.float32), numbers.integers(0, 256, (8, 11, 3), np.uint8)
    for name, samples, full in ("grey-8.tif", grey8, 255), ("grey-16.tif", grey16, 65535), ("floats.tif", floats, 1), ("rgb.tif", colours, 255):
        tifffile.imwrite(path_of(name), samples, photometric="rgb" if samples.ndim == 3 else "minisblack", metadata=None)
        yield name, samples / full
    srgb = struct.pack(">I", 1) + b"sRGB\0" + struct.pack(">I", zlib.crc32(b"sRGB\0"))
    yield png("srgb.png", colours, srgb), colours / 255


def is_same(what, scene, other):
    """Both scenes agree with OpenGL, and the reference draws the same: but for a pixel in a thousand, where an edge is another one."""
    for text in scene, other:
        status, _, message = judged(write("judged.scene", VIEW + text))
        check(status == 0, f"{what}: OpenGL draws it", message)
    a, b = (tifffile.imread(reference(f"{i}.tif", write(f"{i}.scene", VIEW + text))).astype(int) for i, text in enumerate((scene, other)))
    off = np.abs(a - b).max(0)
    check((off > 1).mean() < 1e-3 and a.any() and a.std() > 1000, f"{what}: it is the surface that numpy displaces", (off > 1).mean(), off.max())


def surfaces():
    for i, (name, values) in enumerate(pictures()):
        by, repeat = (0.2, -0.15, 0.1, 0.3, 0.25)[i], ((1, 1), (2, 1.5), (1, 1), (0.7, 3), (1, 1))[i]
        heights = by * np.flipud(values.mean(2) if values.ndim == 3 else values)
        write("displaced.obj", plane(4, 24, repeat, heights))
        is_same(name, f"object plane 4 4 24 material m displace {name} {by} repeat {repeat[0]} {repeat[1]}\n",
                "object mesh displaced.obj material m\n")
    flat = np.zeros((2, 2))
    write("flat.obj", plane(4, 24, (1, 1), flat))
    rows, faces = plane(4, 24, (1, 1), flat).split("f ", 1)
    vt = "".join(f"vt {i / 24!r} {j / 24!r}\n" for j in range(25) for i in range(25))
    write("mapped.obj", rows + vt + "f " + re.sub(r"(\d+)//(\d+)", r"\1/\1/\2", faces))
    tifffile.imwrite(path_of("grey.tif"), (255 * np.random.default_rng(8).random((5, 5))).astype(np.uint8))
    is_same("a mesh", "object mesh flat.obj planar displace grey.tif 0.2 material m\n", "object plane 4 4 24 displace grey.tif 0.2 material m\n")
    is_same("a mesh with vt", "object mesh mapped.obj repeat 2 3 displace grey.tif 0.2 material m\n",
            "object plane 4 4 24 repeat 2 3 displace grey.tif 0.2 material m\n")


# ---- closed shapes ----

SHAPES = ("sphere 1 24 16", "torus 0.5 1 16 32", "box 1.6 1.6 1.6 10", "cylinder 0.8 1.6 24 8", "cone 1 2 24 8")


def closed():
    """A light within a displaced solid lights nothing outside, at no seam, pole or edge."""
    tifffile.imwrite(path_of("noise.tif"), np.random.default_rng(9).integers(0, 65536, (8, 8), np.uint16))
    for shape in SHAPES:
        inside = "1 0 0" if shape.startswith("torus") else "0 0 -0.2"
        text = f"""wavelengths 500 500 1
size 160 120
camera perspective 70 near 0.5 far 30 eye 0 0 9
light 1 1 position {inside} shadows
material m {{ diffuse 0.8 }}
object {shape} displace noise.tif 0.3 repeat 3 2 material m
object box 20 20 20 20 material m two-sided
"""
        path = write("closed.scene", text)
        pixels = tifffile.imread(reference("closed.tif", path))
        check(not pixels.any(), f"{shape.split()[0]}: a light within it lets nothing through", (pixels > 0).sum())
        opened = tifffile.imread(reference("opened.tif", write("opened.scene", text.replace(" material m\nobject box", " casts no material m\nobject box"))))
        check(opened.any(), f"{shape.split()[0]}: the walls are lit where it casts no shadow")
        status, _, message = judged(path)
        check(status == 0, f"{shape.split()[0]}: and OpenGL agrees", message)


# ---- plan ----

def counted():
    tifffile.imwrite(path_of("noise.tif"), np.random.default_rng(9).integers(0, 65536, (8, 12), np.uint16))
    text = VIEW + "object plane 2 2 6 displace noise.tif 0.5 repeat 3 2 material m\nobject box material m\n"
    said = output_of("plan", write("plan.scene", text))
    check("displace          yes (1 of 2 objects)" in said, "plan counts the objects with a relief", said)
    v, u = np.mgrid[0:6, 0:6] / 6
    heights = 0.5 * np.flipud(tifffile.imread(path_of("noise.tif")) / 65535)
    at = lambda du, dv: sampled(heights, 3 * (u + du / 6), 2 * (v + dv / 6))  # noqa: E731
    off = [at(2 / 3, 1 / 3) - (at(0, 0) + at(1, 0) + at(1, 1)) / 3, at(1 / 3, 2 / 3) - (at(0, 0) + at(1, 1) + at(0, 1)) / 3]
    line = re.search(r"noise.tif: (\S+) texels a triangle of the plane \(\S+:8\), which misses heights by (\S+) \(rms\) of 0.5", said)
    check(line and float(line[1]) == float(f"{12 * 3 * 8 * 2 / 72:.3g}") and float(line[2]) == float(f"{np.sqrt(np.square(off).mean()):.2g}"),
          "plan has the texels in a triangle, and the heights that triangles miss", said, np.sqrt(np.square(off).mean()))
    several = "".join(f"object plane 2 2 6 displace {words} material m\n" for words in (
        "noise.tif 0.5", "noise.tif 0.4", "weave 0.5", "noise.tif 0.5 repeat 2 1", "noise.tif 0.5"))
    said = output_of("plan", write("several.scene", VIEW + several))
    check(said.count("texels a triangle") == 4, "shapes of another relief, height or repeat have meshes of their own", said)
    finer = output_of("plan", path_of("plan.scene"), "--tessellation", "2")
    check(re.search(r"noise.tif: 2 texels", finer), "finer shapes have fewer texels in a triangle", finer)
    check(re.search(r"^file +[0-9a-f]{64} \S*noise.tif$", finer, re.M), "plan lists the picture as a file of the scene", said)
    none = text.replace("noise.tif 0.5", "no-such.tif 0")
    report = render(none)
    check(not report["effects"]["displace"], "height 0 is no relief, and reads no file")
    flat = tifffile.imread(path_of("stack.tif"))
    render(none.replace(" displace no-such.tif 0", ""))
    check(np.array_equal(flat, tifffile.imread(path_of("stack.tif"))), "and changes no pixel")
    check(render(text)["effects"]["displace"], "a report says that reliefs are simulated")


# ---- other words of the language ----

def together():
    """Reliefs beside all else: halves, several materials, grids, samples, finer triangles, shaders, tiles."""
    words = {"halves": "material h { diffuse 0.5 metamer m }\nobject sphere 1 40 30 displace weave 0.2 repeat 4 3 material h\n",
             "grid": "checker colorchecker sphere 2.8 24 12 displace ripples 0.4\n",
             "textured": "material t { diffuse 0.7 texture checks linear }\nobject torus 0.5 1.2 24 48 displace weave 0.2 repeat 9 5 material t\n",
             "folded": "object sphere 1 30 20 displace noise.tif -2.5 material m\n",
             "parts": "material halves { diffuse 0.5 }\nmaterial walnut { diffuse 0.2 }\nobject mesh chair materials chair crease 40 planar displace ripples 0.1 translate 0 -1 0\n"}
    for name, text in words.items():
        for options in [], ["--renderer", "softpipe"], ["--renderer", "gl-shader"], ["--accuracy", "2"]:
            if name == "folded" and options[:1] == ["--accuracy"]:
                continue  # finer triangles end in each other's shadow, so that too much cannot be checked
            status, _, message = judged(write(f"{name}.scene", VIEW + text), *options)
            check(status == 0, f"{name} {' '.join(options)}: agreed", message)
    status, _, message = judged(path_of("folded.scene"), LD_PRELOAD=FAULTS, FAULT="24")
    check(status == 1 and "OpenGL" in message, "a planted fault is found on a relief", message)
    status, _, message = judged(path_of("textured.scene"), "--samples", "2")
    check(status == 0, "several positions a pixel agree", message)


def inside_out():
    """A sphere that is turned through its centre shows backs, which hide what lies behind them."""
    tifffile.imwrite(path_of("one.tif"), np.ones((2, 2), np.float32))
    text = "wavelengths list 500 550 600\nsize 60 60\ncamera ortho 3\nlight 1 1 direction 0 0 1\nmaterial m { diffuse 0.8 }\n"
    text += "object sphere 1 24 16 displace one.tif -2 material m\nobject plane 0.5 0.5 material m translate 1.2 1.2 0\n"
    for options in ["--renderer", "raster"], []:
        pixels = stack_of(write("turned.scene", text), *options)
        check(not pixels[:, 20:40, 20:40].any() and pixels.any(), "the back of a sphere inside out is black, and hides its front",
              pixels[:, 20:40, 20:40].max())
    pixels = stack_of(write("turned.scene", text.replace("-2 material", "-2 two-sided material")))
    check(pixels[:, 20:40, 20:40].all(), "and is lit where the object is two-sided")
    within = text.replace("ortho 3", "ortho 3 near 0.05 far 10").replace("0 0 1\n", "0 0 1 shadows\n") + "object plane 1 material m translate 0 0 -0.2\n"
    pixels = stack_of(write("within.scene", within))
    check(not pixels[:, 22:38, 22:38].any(), "its backs throw a shadow on what lies within it", pixels[:, 22:38, 22:38].max())


def refused():
    for value in np.nan, np.inf, -0.5:
        samples = np.full((4, 4), 0.5, np.float32)
        samples[2, 1] = value
        tifffile.imwrite(path_of("odd.tif"), samples)
        refuses(f"a relief with {value}", rf"odd.scene:8:\d+: error: .*odd.tif: page 1: the value at column 1, row 2 is {value}", "plan",
                write("odd.scene", VIEW + "object plane 1 1 4 displace odd.tif 0.1 material m\n"))


def built_in():
    said = output_of("list", "reliefs").split()
    check(said == ["reliefs", "bricks", "ripples", "weave"], "list has the built-in reliefs", said)
    for name in said[1:]:
        output_of("show", f"builtin:reliefs/{name}.tif", "-o", path_of("shown.tif"))
        samples = tifffile.imread(path_of("shown.tif"))
        check(samples.dtype == np.uint16 and samples.shape == (128, 128) and samples.max() - samples.min() > 40000,
              f"{name}: 16 bits, of much of their range", samples.shape, samples.max())
        seam = max(np.abs(np.diff(np.concatenate([samples, samples[:1]], 0).astype(int), axis=0)[-1]).max(),
                   np.abs(np.diff(np.concatenate([samples, samples[:, :1]], 1).astype(int), axis=1)[:, -1]).max())
        steps = max(np.abs(np.diff(samples.astype(int), axis=k)).max() for k in (0, 1))
        check(seam <= steps, f"{name}: it repeats without a seam", seam, steps)
    status, found, message = judged("relief", "--size", "240x160", "--wavelengths", "450:650:100")
    check(status == 0 and found["effects"]["displace"], "the scene relief agrees", message)
    check(run("plan", "relief").stdout.count("texels a triangle of the") == 5, "plan names its five reliefs")


surfaces()
closed()
counted()
together()
inside_out()
refused()
built_in()
done()
