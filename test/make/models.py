#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Makes bowl.obj, chair.obj, clock.obj, cove.obj, vase.obj and tetrahedron*.obj of data/builtin/models again:
`test/make/models.py FOLDER` writes them into FOLDER. Each part is a surface over u and v, 0 to 1. Only the backdrop
has them as texture coordinates, too; without them a mesh is smaller. MIT licence."""
import math
import sys

from material_files import write

# Radius and height at the corners of outlines, from the middle of the foot to the bottom inside. Negative numbers
# mark sharp corners (the sign of the radius only).
VASE = ((0, 0), (-0.38, 0), (-0.42, 0.04), (0.48, 0.25), (0.575, 0.45), (0.657, 0.63), (0.7, 0.8), (0.689, 0.97),
        (0.624, 1.13), (0.503, 1.3), (0.369, 1.47), (0.298, 1.6), (0.277, 1.72), (0.305, 1.84), (0.358, 1.93),
        (-0.42, 2), (-0.39, 2), (0.25, 1.75), (0.18, 1.6))
BOWL = ((0, 0), (-0.42, 0), (-0.42, 0.05), (0.3, 0.1), (0.55, 0.2), (0.8, 0.38), (0.93, 0.56), (-1, 0.75), (-0.96, 0.75),
        (0.88, 0.57), (0.74, 0.4), (0.5, 0.25), (0.25, 0.17), (0, 0.15))


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


def turned(outline):
    """An outline, turned about the y axis; between its corners run cubic curves (Catmull and Rom's)"""
    sharp = {i for i, (radius, _) in enumerate(outline) if radius < 0} | {0, len(outline) - 1}
    outline = [(abs(radius), height) for radius, height in outline]
    lengths = [math.dist(*ends) for ends in zip(outline, outline[1:])]

    def surface(u, v):
        t, i = v * sum(lengths), 0
        while i + 2 < len(outline) and t >= lengths[i]:
            t, i = t - lengths[i], i + 1
        t = min(t / lengths[i], 1)
        a, b = outline[i], outline[i + 1]
        before = a if i in sharp else outline[i - 1]
        after = b if i + 1 in sharp else outline[i + 2]
        radius, height = (q + t * (r - p + t * (2 * p - 5 * q + 4 * r - s + t * (3 * (q - r) + s - p))) / 2
                          for p, q, r, s in zip(before, a, b, after))
        angle = 2 * math.pi * u
        return radius * math.sin(angle), height, radius * math.cos(angle)
    return surface


def cushion(centre, sizes, lean=0):
    """A box with round edges and corners (a superellipsoid), leaning back by an angle in degrees"""
    def power(value):
        return math.copysign(abs(value) ** 0.35, value) / 2
    cos, sin = math.cos(math.radians(lean)), math.sin(math.radians(lean))

    def surface(u, v):
        around, up = 2 * math.pi * (u + 0.125), math.pi * (v - 0.5)
        x, y, z = (size * value for size, value in zip(sizes, (
            2 * power(math.cos(up)) * power(math.sin(around)), power(math.sin(up)),
            2 * power(math.cos(up)) * power(math.cos(around)))))
        return centre[0] + x, centre[1] + cos * y + sin * z, centre[2] + cos * z - sin * y
    return surface


def rod(start, end, radii):
    """A round rod between two places, closed at its ends"""
    def surface(u, v):
        along = min(max(3 * v - 1, 0), 1)
        radius = 0 if v in (0, 1) else radii[0] + along * (radii[1] - radii[0])
        x, y, z = (a + along * (b - a) for a, b in zip(start, end))
        angle = 2 * math.pi * u
        return x + radius * math.sin(angle), y, z + radius * math.cos(angle)
    return surface


def bar(inner, outer, width, hour, z):
    """A flat bar of a clock's face, from one radius to another, towards an hour"""
    cos, sin = math.cos(math.pi * hour / 6), math.sin(math.pi * hour / 6)

    def surface(u, v):
        across, along = width * (u - 0.5), inner + v * (outer - inner)
        return sin * along + cos * across, cos * along - sin * across, z
    return surface


def ring(u, v):
    """The rim of a clock of radius 1"""
    radius, angle = 1 + 0.07 * math.cos(2 * math.pi * v), 2 * math.pi * u
    return radius * math.sin(angle), radius * math.cos(angle), -0.07 * math.sin(2 * math.pi * v)


def face(u, v):
    angle = 2 * math.pi * u
    return v * math.sin(angle), v * math.cos(angle), 0


# name: what it is; its parts: name, surface, how often it is divided along u and v
MODELS = {
    "bowl": ("a bowl of radius 1, 0.75 high, on y = 0", [(None, turned(BOWL), 40, 24)]),
    "chair": ("a chair 1.9 wide and 4 high that stands on y = 0 and looks along +z; parts: seat, frame", [
        ("seat", cushion((0, 1.95, 0), (1.9, 0.4, 1.8)), 24, 12),
        ("seat", cushion((0, 3.3, -0.98), (1.7, 1.25, 0.3), 8), 24, 12),
        *(("frame", rod((0.82 * x, 0, 0.82 * z), (0.75 * x, 1.85, 0.7 * z), (0.07, 0.11)), 12, 3)
          for x in (-1, 1) for z in (-1, 1)),
        *(("frame", rod((0.72 * x, 1.8, -0.78), (0.72 * x, 4, -1.12), (0.09, 0.07)), 12, 3) for x in (-1, 1))]),
    "clock": ("a clock of radius 1 on the plane z = 0; parts: face, rim, mark", [
        ("face", face, 48, 1), ("rim", ring, 48, 8),
        *(("mark", bar(0.72 if hour % 3 else 0.64, 0.9, 0.05 if hour % 3 else 0.1, hour, 0.01), 1, 1)
          for hour in range(12)),
        ("mark", bar(-0.12, 0.5, 0.1, 10 + 1 / 6, 0.02), 1, 1), ("mark", bar(-0.15, 0.78, 0.06, 2, 0.03), 1, 1)]),
    "cove": ("a backdrop: a floor of 34 x 22 on y = 0 that curves up into a wall at its back",
             [(None, cove, 16, 28)]),
    "vase": ("a vase, 2 high, on y = 0", [(None, turned(VASE), 36, 40)]),
}


def number(value, digits):
    return f"{round(value, digits) + 0.0:g}"


def mesh(parts, textured):
    """The lines of a mesh. Corners at one place are one vertex, so that normals are smooth across the seam."""
    vertices, coordinates, faces = {}, {}, []

    def corner(surface, u, v):
        place = " ".join(number(value, 3) for value in surface(u, v))
        coordinate = f"{number(u, 4)} {number(v, 4)}"
        return vertices.setdefault(place, len(vertices) + 1), coordinates.setdefault(coordinate, len(coordinates) + 1)
    named = None
    for name, surface, columns, rows in parts:
        if name != named:
            faces.append(f"usemtl {name}")
            named = name
        for j in range(rows):
            for i in range(columns):
                around = [corner(surface, u / columns, v / rows)
                          for u, v in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
                kept = [a for a, b in zip(around, around[1:] + around[:1]) if a[0] != b[0]]
                if len(kept) > 2:
                    faces.append("f " + " ".join(f"{v}/{t}" if textured else str(v) for v, t in kept))
    return ["v " + place for place in vertices] + ["vt " + place for place in coordinates if textured] + faces


def divided(levels):
    """The lines of a tetrahedron in the sphere of radius 1, each of whose triangles is cut into four at the middles of its
    edges, which are moved outwards to the sphere: so many times"""
    side = 1 / math.sqrt(3)
    points = [(side, side, side), (side, -side, -side), (-side, side, -side), (-side, -side, side)]
    faces, middles = [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], {}

    def middle(a, b):
        key = min(a, b), max(a, b)
        if key not in middles:
            total = [x + y for x, y in zip(points[a], points[b])]
            points.append(tuple(x / math.hypot(*total) for x in total))
            middles[key] = len(points) - 1
        return middles[key]

    for _ in range(levels):
        faces = [face for a, b, c in faces for ab, bc, ca in [(middle(a, b), middle(b, c), middle(c, a))]
                 for face in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    return ["v " + " ".join(number(x, 6) for x in point) for point in points] + [
        "f " + " ".join(str(i + 1) for i in face) for face in faces]


def main(folder):
    for levels in range(4):
        what = f"# A tetrahedron in a sphere of radius 1, divided {levels} times into that sphere. Made by test/make/models.py."
        write(f"{folder}/tetrahedron{-levels or ''}.obj", "\n".join([what, "# MIT licence.", *divided(levels)]) + "\n")
    for name, (what, parts) in MODELS.items():
        lines = [f"# {what[0].upper()}{what[1:]}. Made by test/make/models.py.", "# MIT licence.", *mesh(parts, name == "cove")]
        write(f"{folder}/{name}.obj", "\n".join(lines) + "\n")


if __name__ == "__main__":
    main(sys.argv[1])
