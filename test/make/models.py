#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Makes cove.obj and vase.obj of data/builtin/models again: `test/make/models.py FOLDER` writes them into FOLDER.
Each is a surface over u and v, 0 to 1, which are its texture coordinates, too. MIT licence."""
import math
import os
import sys

# Radius and height at the corners of a vase's outline, from the middle of its foot to the bottom inside.
VASE = ((0, 0), (0.38, 0), (0.42, 0.04), (0.48, 0.25), (0.575, 0.45), (0.657, 0.63), (0.7, 0.8), (0.689, 0.97),
        (0.624, 1.13), (0.503, 1.3), (0.369, 1.47), (0.298, 1.6), (0.277, 1.72), (0.305, 1.84), (0.358, 1.93),
        (0.42, 2), (0.39, 2), (0.25, 1.75), (0.18, 1.6))


def cove(u, v):
    """A floor of 34 x 22 that curves up with a radius of 6 into a wall 8 higher"""
    arc = 3 * math.pi
    along, x = v * (30 + arc), 34 * (u - 0.5)
    if along <= 22:
        return x, 0, 12 - along
    if along <= 22 + arc:
        angle = (along - 22) / 6
        return x, 6 * (1 - math.cos(angle)), -10 - 6 * math.sin(angle)
    return x, along - 16 - arc, -16


def vase(u, v):
    """The outline, turned about the y axis; between its corners run cubic curves (Catmull and Rom's)"""
    lengths = [math.dist(*ends) for ends in zip(VASE, VASE[1:])]
    t, i = v * sum(lengths), 0
    while i + 2 < len(VASE) and t >= lengths[i]:
        t, i = t - lengths[i], i + 1
    t = min(t / lengths[i], 1)
    sharp = {0, 1, 15, 16}  # corners where the curve starts anew
    a, b = VASE[i], VASE[i + 1]
    before = a if i in sharp else VASE[i - 1]
    after = b if i + 1 in sharp or i + 2 == len(VASE) else VASE[i + 2]
    radius, height = (q + t * (r - p + t * (2 * p - 5 * q + 4 * r - s + t * (3 * (q - r) + s - p))) / 2
                      for p, q, r, s in zip(before, a, b, after))
    angle = 2 * math.pi * u
    return radius * math.sin(angle), height, radius * math.cos(angle)


# name: what it is; its surface; parts along u and v
MODELS = {
    "cove": ("a backdrop: a floor of 34 x 22 on y = 0 that curves up into a wall at its back", cove, 16, 28),
    "vase": ("a vase, 2 high, on y = 0", vase, 40, 44),
}


def number(value, digits):
    return f"{round(value, digits) + 0.0:g}"


def mesh(surface, columns, rows):
    """The lines of a mesh. Corners at one place are one vertex, so that normals are smooth across the seam."""
    vertices, coordinates, faces = {}, {}, []

    def corner(i, j):
        place = " ".join(number(value, 3) for value in surface(i / columns, j / rows))
        coordinate = f"{number(i / columns, 4)} {number(j / rows, 4)}"
        return vertices.setdefault(place, len(vertices) + 1), coordinates.setdefault(coordinate, len(coordinates) + 1)
    for j in range(rows):
        for i in range(columns):
            around = corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)
            kept = [a for a, b in zip(around, around[1:] + around[:1]) if a[0] != b[0]]
            if len(kept) > 2:
                faces.append("f " + " ".join(f"{v}/{t}" for v, t in kept))
    return ["v " + place for place in vertices] + ["vt " + place for place in coordinates] + faces


def main(folder):
    for name, (what, surface, columns, rows) in MODELS.items():
        lines = [f"# {what[0].upper()}{what[1:]}. Made by test/make/models.py.", "# MIT licence.",
                 *mesh(surface, columns, rows)]
        with open(os.path.join(folder, name + ".obj"), "w", encoding="ascii") as out:
            out.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main(sys.argv[1])
