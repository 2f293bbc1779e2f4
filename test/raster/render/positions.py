#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Checks --samples, which stores the mean of K x K positions of each pixel: it is the mean of a picture that is K times
as wide, on every page type and renderer; areas, edges and a checkerboard up to the horizon come near their closed forms
as K grows. Checks that each position is checked, and that other commands see the same pixels. FULL=1 draws more and larger pictures, by
more renderers. Prints TAP."""
import json
import math
import os
import re

import numpy as np
import tifffile

import rendered
from rendered import TMP, bytes_of, check, done, parts, objects_of, pages_of, path_of, run, write

FULL = "FULL" in os.environ
SIDES = (1, 2, 4, 8, 16) if FULL else (1, 2, 4)
SIZE = (60, 40) if FULL else (30, 20)
NM = ("--wavelengths", "450,550,650")
FLAT = "wavelengths 500 500 1\nsize {size}\ncamera ortho {extent}\nambient 1 1\nmaterial white {{ diffuse 1 }}\n"


def render(scene, *options, stack="stack.tif"):
    """The pages of radiance [band, y, x] of a stack, and the report."""
    report = rendered.render(scene, *options, stack=stack)
    return pages_of(os.path.join(TMP, stack)), report


def blocks(picture, side):
    """The positions of each pixel [..., y, x, position]."""
    *others, height, width = picture.shape
    parts = picture.reshape(*others, height // side, side, width // side, side)
    return np.moveaxis(parts, -3, -2).reshape(*others, height // side, width // side, side * side)


def is_mean_of_a_wider_picture():
    """The floats of a mean are rounded once, to half a unit in their last place, those of the wider picture each."""
    for side, (options, step) in ((2, (("--depth", "32f"), 0)), (4, (("--depth", "32f", "--renderer", "raster"), 0)),
                                  (4, ((), 1)), (8, (("--depth", "8", "--renderer", "softpipe"), 1)),
                                  (2, (("--buffer", "8", "--depth", "32f"), 0)), (16, (("--renderer", "raster"), 1)))[:None if FULL else 3]:
        for scene in ("textures", "metals" if "softpipe" in options else "room")[:None if FULL else 1]:  # see mesa.md: the rug's rim
            means, report = render(scene, *NM, "--size", "{}x{}".format(*SIZE), "--samples", str(side), *options)
            wide, other = render(scene, *NM, "--size", f"{SIZE[0] * side}x{SIZE[1] * side}", *options, stack="wide.tif")
            error = np.abs(means - blocks(wide, side).mean(-1)).max()
            check(means.shape == (3, *SIZE[::-1]) and error <= (step if step else 1e-6 * wide.max()) and np.ptp(means) > 0,
                  f"{scene} {' '.join(options)}: a pixel is the mean of {side} x {side} positions", error)
            same = [report["check"][key] == other["check"][key]
                    for key in ("samples", "pixels", "exact", "ambiguous_pixels", "unexplained_pixels")]
            check(all(same) and report["positions_per_pixel"] == side * side and report["width"] == SIZE[0],
                  f"{scene} {' '.join(options)}: each position is checked as a pixel of the wider picture is")


def maps():
    """The map of objects has what most positions show, that of the check what is worst."""
    stack, wide = (os.path.join(TMP, name) for name in ("stack.tif", "wide.tif"))
    for options in ((), ("--renderer", "raster")):
        render("room", *NM, "--size", "{}x{}".format(*SIZE), "--samples", "4", *options, "--check-map", path_of("map.tif"))
        render("room", *NM, "--size", f"{4 * SIZE[0]}x{4 * SIZE[1]}", *options, "--check-map", path_of("wide-map.tif"), stack="wide.tif")
        seen, positions = objects_of(stack), blocks(objects_of(wide), 4)
        counts = np.array([(positions == number).sum(-1) for number in range(positions.max() + 1)])
        often = np.take_along_axis(counts, seen[None].astype(int), 0)[0]
        check((often == counts.max(0)).all() and len(np.unique(seen)) > 5,
              "the map of objects has the object of most positions", *options)
        check((often >= 8).mean() > 0.9, "which are mostly half of them", *options)
        ours, theirs = (pages_of(os.path.join(TMP, name)) for name in ("map.tif", "wide-map.tif"))
        check((ours == blocks(theirs, 4).max(-1)).all() and ours.shape == (4, *SIZE[::-1]),
              "the map of the check has the largest of all positions", *options)


def coverage(a, b, c, width, height):
    """The part of each pixel where a x + b y < c, from the exact area of a clipped square."""
    out = np.empty((height, width))
    for y in range(height):
        for x in range(width):
            inside = []
            corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
            for one, two in zip(corners, corners[1:] + corners[:1]):
                d1, d2 = (a * p[0] + b * p[1] - c for p in (one, two))
                if d1 < 0:
                    inside.append(one)
                if d1 * d2 < 0:
                    inside.append(tuple(p + d1 / (d1 - d2) * (q - p) for p, q in zip(one, two)))
            out[y, x] = abs(sum(p[0] * q[1] - p[1] * q[0] for p, q in zip(inside, inside[1:] + inside[:1]))) / 2
    return out


def edges():
    """The half plane x cos + y sin < 0.3 in a view of 32 pixels of size 1. In each of the K rows of a pixel the edge lies
    at most half a position beside the counted positions: the mean is off by 1 / 2K at most. Rows err independently: the
    root mean square falls as K to the power of -1.5, which the fifth of this factor leaves room for."""
    for degrees in (3, 17, 40):
        turn = math.radians(degrees)
        scene = write("edge.scene", FLAT.format(size="32 32", extent=32) +
                      f"object plane 100 100 material white translate {0.3 - 50} 0 0 rotate {-degrees} 0 0 1\n")
        exact = coverage(math.cos(turn), math.sin(turn), 0.3 + 16 * (math.cos(turn) + math.sin(turn)), 32, 32)
        errors = []
        for side in SIDES:
            picture, _ = render(scene, "--samples", str(side), "--depth", "32f")
            error = picture[0] - exact
            check(np.abs(error).max() <= 0.5 / side + 1e-3, f"an edge at {degrees} degrees is right within 1/{2 * side}",
                  np.abs(error).max())
            errors.append(np.sqrt(np.mean(error ** 2)))
        print(f"# edge at {degrees} degrees, root mean square:", *(f"{error:.4f}" for error in errors))
        check(errors[-1] <= errors[0] * SIDES[-1] ** -1.5 * 5, f"its error falls at {degrees} degrees", errors)


def areas():
    """A disk of 500 corners: its area is 250 r^2 sin(2 pi / 500). A grid of N positions across its radius counts it
    with an error of some sqrt(N), as of the N^2 in the disk: 2 sqrt(K r) positions are allowed."""
    radius, errors = 10.3, []
    scene = write("disk.scene", FLAT.format(size="32 32", extent=32) +
                  f"object disk {radius} 500 material white translate 0.17 0.11 0\n")
    area = 250 * radius ** 2 * math.sin(2 * math.pi / 500)
    for side in SIDES:
        picture, _ = render(scene, "--samples", str(side), "--depth", "32f")
        errors.append(picture[0].sum() - area)
        check(abs(errors[-1]) <= 2 * math.sqrt(side * radius) / side ** 2,
              f"the area of a disk, of {side} x {side} positions a pixel", errors[-1])
    print("# area of a disk of", f"{area:.3f} pixels, errors:", *(f"{error:+.4f}" for error in errors))


def horizon():
    """A checkerboard of 0 and 1 up to the horizon: where many squares lie in a pixel, its mean is 1/2. K x K positions
    of independent squares would deviate from it by 1 / 2K (root mean square). The K rows of a pixel see independent
    squares; those of a row lie at equal distances and may be alike, so that 1 / (2 sqrt K) is allowed."""
    tifffile.imwrite(os.path.join(TMP, "squares.tif"), np.array([[0, 255], [255, 0]], np.uint8))
    scene = write("horizon.scene", """wavelengths 500 500 1
size 60 40
camera perspective 40 near 0.5 far 100000 eye 0.3 1 0.2 look 0.4 0.98 -1
ambient 1 1
material checks { diffuse 1 texture squares.tif nearest }
object plane 60000 60000 material checks repeat 30000 30000 rotate -90 1 0 0
""")
    errors = []
    for side in SIDES:
        picture, _ = render(scene, "--samples", str(side), "--depth", "32f", "--renderer", "raster", "--no-check")
        rows = np.flatnonzero((picture[0] > 0).any(1))
        far = picture[0][rows[0] + 1:rows[0] + 4]
        errors.append(np.sqrt(np.mean((far - 0.5) ** 2)))
        check(errors[-1] <= 0.5 / math.sqrt(side), f"near the horizon, {side} x {side} positions have the mean of a checkerboard",
              errors[-1])
    check(errors[-1] < errors[0] / SIDES[-1] * 2.5, "a checkerboard comes near it about as fast as with independent positions", errors)
    print("# checkerboard near the horizon, root mean square:", *(f"{error:.4f}" for error in errors))


def other_commands():
    render("room", *NM, "--size", "60x40", "--samples", "4", "--depth", "32f", "--renderer", "raster")
    stack = os.path.join(TMP, "stack.tif")
    words = (*NM, "--size", "60x40", "--samples", "4")
    for place in (("30", "20"), ("17", "22"), ("10", "5", "9", "7")):
        one = json.loads(run("probe", stack, *place, "--json", "-").stdout)
        two = json.loads(run("probe", "room", *place, *words, "--json", "-").stdout)
        check(np.allclose(one["XYZ"], two["XYZ"], rtol=1e-5) and
              np.allclose(one["radiance"], two["radiance"], rtol=1e-5, atol=1e-7) and
              np.allclose(one["standard_deviation"], two["standard_deviation"], rtol=1e-3, atol=1e-6),
              f"probe of the scene sees the pixels that render stores: {' '.join(place)}", one, two)
    again = run("render", "--again", stack, "-o", os.path.join(TMP, "again.tif"))
    check(again.returncode == 0, "--again makes it again", again.stderr)
    plan = run("plan", "room", "--samples", "4").stdout
    check(re.search(r"^positions per pixel +16$", plan, re.MULTILINE), "plan prints the positions", plan)
    for threads in ("1", "3"):
        render("room", *words, "--threads", threads, stack=f"{threads}.tif")
    check(bytes_of(path_of("1.tif")) == bytes_of(path_of("3.tif")), "the number of threads does not matter")


parts(is_mean_of_a_wider_picture, maps, edges, areas, horizon, *([other_commands] if FULL else []))
done()
