#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Renders a closed surface of many triangles and a surface in perspective with both renderers, and compares every band with
radiances in closed form; effects.py has those of lights and materials. Prints TAP."""

import numpy as np

from rendered import D65, RED, Picture, check, done, per_band, write


def watertight(renderer):
    """A square of 3200 triangles; corners lie on pixel centres or, at random, beside them."""
    cells, random = 40, np.random.default_rng(1)
    steps = np.arange(cells + 1) / cells * 4 - 2
    x, y = (v + random.integers(0, 2, v.shape) * random.uniform(-0.04, 0.04, v.shape)
            for v in np.meshgrid(steps, steps))
    mesh = ["v %.17g %.17g 0\n" % point for point in zip(x.flat, y.flat)]
    for row in range(cells):
        for column in range(cells):
            first = row * (cells + 1) + column + 1
            mesh.append(f"f {first} {first + 1} {first + cells + 2}\n"
                        f"f {first} {first + cells + 2} {first + cells + 1}\n")
    write("square.obj", "".join(mesh))
    scene = ("size 80 80\ncamera ortho 3.2\nambient d65 1\nmaterial red RED\n"
             "object mesh square.obj material red")
    picture = Picture("watertight", renderer, scene)
    picture.agrees(per_band(D65 * RED), f"{renderer}: thousands of triangles leave no hole")


def perspective(renderer):
    """A square leaning back by 60 degrees, lit from a point in its plane of symmetry: corners left and
    right are equally bright, so that radiance is linear along the square, not along the picture."""
    size, half, distance, angle = 81, 2.0, 6.0, np.radians(-60)
    light = np.array([0.0, 1.0, 3.0])
    up = np.array([0, np.cos(angle), np.sin(angle)])
    normal = np.array([0, -np.sin(angle), np.cos(angle)])

    def corner(along):
        position = np.array([half, 0, -distance]) + along * half * up
        path = light - position
        return normal @ path / np.linalg.norm(path)

    tangent = np.tan(np.radians(20))
    centre = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(centre * tangent, -centre * tangent)
    # ray (x, y, -1) t meets the plane where normal . (ray t) = normal . (0, 0, -distance)
    t = normal[2] * -distance / (normal[1] * y - normal[2])
    along = (y * t * up[1] + (-t + distance) * up[2]) / half
    inside = (np.abs(along) < 0.97) & (np.abs(x * t) < 0.97 * half)
    low, high = corner(-1), corner(1)
    expected = (low + (high - low) * (along + 1) / 2)[inside][None, :] * (D65 * RED)[:, None]
    scene = (f"size {size} {size}\ncamera perspective 40 near 1 far 20\nlight d65 1 position 0 1 3\n"
             "material red RED\nobject plane 4 4 material red rotate -60 1 0 0 translate 0 0 -6")
    picture = Picture("perspective", renderer, scene)
    error = np.abs(picture.radiance[:, inside] - expected).max()
    check(inside.sum() > 500 and abs(high - low) > 0.15 and error <= picture.tolerance,
          f"{renderer}: a gradient in perspective is linear on the square, not in the picture",
          f"{inside.sum()} pixels, corners {low} {high}, error {error}, tolerance {picture.tolerance}")


for each in ("raster", "gl"):
    watertight(each)
    perspective(each)
done()
