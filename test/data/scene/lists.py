#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Lists of materials as in the thesis: all objects in view, other shapes, a tetrahedron that is divided into a sphere, the
second lamp, and the texture of a metameric partner. Sizes, numbers of pixels and radiances are computed here. Prints TAP."""

import numpy as np
import tifffile

from rendered import check, done, objects_of, output_of, pages_of, path_of, refuses, write

WIDTH, HEIGHT = 180, 120
SHAPES = ("torus", "sphere", "teapot", "mesh chair", "box", "cylinder", "torus 1 2 40 80")


def listed(n, *options):
    """The stack of a list of n materials."""
    stack = path_of("list.tif")
    scene = write("many.list", "\n".join(["colorchecker/19-white"] * n) + "\n")
    output_of("render", scene, "--size", f"{WIDTH}x{HEIGHT}", "--wavelengths", "550", "--depth", "32f", "--renderer", "raster", "--no-check", "-q",
              "-o", stack, *options)
    return stack


def all_in_view(n, stack):
    """Returns that none of the n objects is at the border, and that all show as many pixels but for steps at their outlines."""
    shown = objects_of(stack)
    border = np.concatenate([shown[0], shown[-1], shown[:, 0], shown[:, -1]])
    pixels = np.bincount(shown.ravel(), minlength=n + 2)[2:]  # 1 is the sphere behind them
    return (border == 1).all() and len(pixels) == n and pixels.min() > 0.75 * pixels.max(), pixels


def views():
    cut = [n for n in range(1, 31) if not all_in_view(n, listed(n))[0]]
    check(cut == [], "lists of 1 to 30 materials are wholly in view", cut)


def shapes():
    for shape in SHAPES:
        cut = [n for n in (1, 10, 30) if not all_in_view(n, listed(n, "--shape", shape))[0]]
        check(cut == [], f"--shape {shape}: all objects are in view", cut)
    for n, scale in ((1, 1), (3, 2 / 3)):
        pixels = all_in_view(n, listed(n, "--shape", "sphere", "--tessellation", "4"))[1]
        expected = np.pi * (2.8 * scale * WIDTH / 12) ** 2
        check(np.all(np.abs(pixels / expected - 1) < 0.03), f"the spheres of {n} materials have the thesis's radius, 2.8", pixels, expected)
    ring = listed(5), listed(5, "--shape", "torus")
    check(np.array_equal(*map(pages_of, ring)), "a torus is the thesis's torus already")
    twice = pages_of(listed(5, "--shape", "teapot", "--shape", "sphere"))
    check(np.array_equal(twice, pages_of(listed(5, "--shape", "sphere"))), "the last shape counts")
    refuses("--shape where there is no list", "--shape is for a list of materials", "plan", "spheres", "--shape", "sphere")
    refuses("an unknown shape", "--shape:1:1: error: unknown shape 'ball'", "plan", "colorchecker", "--shape", "ball")
    refuses("a mesh that is not there", "--shape:1:6: error: no file none.obj", "plan", "colorchecker", "--shape", "mesh none.obj")


def lamps():
    both, one, none = (pages_of(listed(4, *options)).astype(float) for options in (
        ["--light", "2=a"], [], ["--light", "1=d65*0"]))
    second = pages_of(listed(4, "--light", "1=d65*0", "--light", "2=a")).astype(float)
    check(np.allclose(both - one, second - none, atol=1e-6) and (second - none).max() > 0.1, "--light 2=a adds the second lamp")
    check((second - none)[0, HEIGHT // 2:].sum() > 1.2 * (second - none)[0, :HEIGHT // 2].sum(), "it shines from below")
    half = pages_of(listed(4, "--light", "1=d65*0", "--light", "2=a*0.5")).astype(float)
    check(np.allclose(2 * (half - none), second - none, atol=1e-6), "its intensity is 1 unless the option says otherwise")


def partners():
    """A square of a material whose partner, at positive x, has a texture of its own; ambient light 1 shows reflectance x texel."""
    tifffile.imwrite(path_of("left.tif"), np.full((2, 2), 255, np.uint8))
    tifffile.imwrite(path_of("right.tif"), np.full((2, 2), 51, np.uint8))
    for name, lines, left, right in (
            ("mt", "mt right.tif\n", 0.5, 0.4 / 5), ("MT beside t", "t right.tif\nMT left.tif\n", 0.5 / 5, 0.4)):
        write("pair.txt", "300 0.5\n760 0.5\nmr 300 0.4\nmr 760 0.4\n" + lines)
        scene = write("pair.scene", "wavelengths list 550\nsize 40 20\ncamera ortho 4\nambient 1 1\nmaterial m pair.txt\nobject plane 4 2 material m\n")
        stack = path_of("pair.tif")
        output_of("render", scene, "--depth", "32f", "-q", "-o", stack)
        page = pages_of(stack)[0]
        check(np.allclose(page[:, :20], left) and np.allclose(page[:, 20:], right), f"{name} is the texture of the partner", page[0, ::10])
    write("pair.txt", "550 0.5\nmr 550 0.4\nmt rgb/wood0.rgb\n")
    refuses("a partner's texture that is not there", "pair.txt:3:1: error: no file .*rgb/wood0.rgb", "plan", scene)


def tetrahedra():
    """Figure 3 of the thesis: a tetrahedron is divided one, two and three times into a sphere. tables.py makes it anew."""
    volumes = []
    for level in range(4):
        name = f"tetrahedron{-level or ''}"
        text = open(f"data/builtin/models/{name}.obj", encoding="ascii").read()
        lines = [line.split() for line in text.splitlines()]
        points = np.array([line[1:] for line in lines if line[0] == "v"], float)
        corners = np.array([line[1:] for line in lines if line[0] == "f"], int) - 1
        edges = {(a, b) for face in corners for a, b in zip(face, np.roll(face, -1))}
        closed = all((b, a) in edges for a, b in edges) and len(edges) == 3 * len(corners)
        check(len(corners) == 4 ** (level + 1) and closed and len(points) - len(edges) // 2 + len(corners) == 2 and
              np.allclose(np.linalg.norm(points, axis=1), 1, atol=2e-6), f"{name} has {4 ** (level + 1)} triangles, is closed, and lies in the sphere")
        volumes.append((np.linalg.det(points[corners]) / 6).sum())
        check((np.linalg.det(points[corners]) > 0).all(), f"all triangles of {name} face outwards")
    check(np.isclose(volumes[0], 8 / (9 * np.sqrt(3)), rtol=1e-5) and volumes == sorted(volumes) and 0.93 < volumes[3] * 0.75 / np.pi < 1,
          "the volumes grow from that of a tetrahedron to nearly that of the sphere", volumes)
    pixels = all_in_view(1, listed(1, "--shape", "mesh tetrahedron-3"))[1]
    check(0.93 < pixels[0] / (np.pi * (2.8 * WIDTH / 12) ** 2) < 1.03, "a list shows it as large as a sphere", pixels)


views()
tetrahedra()
shapes()
lamps()
partners()
done()
