#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Makes the textures of data/builtin/textures that hold soft shadows: `test/make/shadows.py FOLDER [NAME...]` writes
them into FOLDER. OpenGL's lighting casts none, and neither does the program; so these are computed before, as light
maps are: the share of the light at each place of a surface that no object keeps away. The program itself finds what
the lights see. For each light, some points on a sphere about it, and for the ambient light many points far away, it
renders the objects that cast shadows, as seen from there, and writes its object map: what it leaves empty is lit.
MIT licence."""
import os
import re
import subprocess
import sys
import tempfile

import numpy as np
import tifffile

sys.dont_write_bytecode = True
sys.path.append(os.path.dirname(os.path.abspath(__file__)))
import models
import textures

SPECTRAL = os.environ.get("SPECTRAL", "build/spectral")
SCENES = "data/builtin/scenes"
VIEW = 512  # pixels of a side of a view from a light
N_AMBIENT, N_POINTS = 96, 12


def spread(count):
    """`count` points spread evenly over a sphere of radius 1 (a spiral that turns by the golden angle)"""
    i = np.arange(count) + 0.5
    y, angle = 1 - 2 * i / count, np.pi * (3 - np.sqrt(5)) * i
    return np.column_stack([np.sqrt(1 - y * y) * np.cos(angle), y, np.sqrt(1 - y * y) * np.sin(angle)])


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def seen(scene, eye, centre, radius, points):
    """Renders `scene`, text without a camera, from `eye`, so that a sphere fits in; returns for each point whether
    nothing is seen at its place in that picture."""
    away = centre - eye
    distance = np.linalg.norm(away)
    angle = np.arcsin(min(radius / distance, 0.98))
    forward = away / distance
    up = np.array((0, 0, 1.0)) if abs(forward[1]) > 0.9 else np.array((0, 1.0, 0))
    right = unit(np.cross(forward, up))
    up = np.cross(right, forward)
    near = max(distance - radius, 0.05 * distance)
    with tempfile.NamedTemporaryFile("w", suffix=".scene") as file, \
            tempfile.NamedTemporaryFile(suffix=".tif") as stack:
        words = [f"camera perspective {2 * np.degrees(angle)} near {near} far {distance + radius}",
                 *(name + " " + " ".join(map(str, v)) for name, v in (("eye", eye), ("look", centre), ("up", up)))]
        file.write(f"wavelengths list 550\nsize {VIEW} {VIEW}\n" + " ".join(words) + "\n" + scene)
        file.flush()
        subprocess.run([SPECTRAL, "render", file.name, "--renderer", "raster", "--no-check", "--quiet", "-o",
                        stack.name], check=True)
        with tifffile.TiffFile(stack.name) as tiff:
            offset, size = map(int, re.search(r"object_map: (\d+) (\d)\n", tiff.pages[0].description).groups())
        empty = np.fromfile(stack.name, f"<u{size}", VIEW * VIEW, offset=offset).reshape(VIEW, VIEW) == 0
    there = points - eye
    depth = there @ forward
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = ((there @ axis / depth / np.tan(angle) * sign + 1) * VIEW / 2 - 0.5
                for axis, sign in ((right, 1), (up, -1)))
    inside = (depth > 0) & (x >= 0) & (x < VIEW - 1) & (y >= 0) & (y < VIEW - 1)
    x, y = np.where(inside, x, 0), np.where(inside, y, 0)
    i, j = x.astype(int), y.astype(int)
    a, b = x - i, y - j
    share = ((1 - b) * ((1 - a) * empty[j, i] + a * empty[j, i + 1])
             + b * ((1 - a) * empty[j + 1, i] + a * empty[j + 1, i + 1]))
    return np.where(inside, share, 1)


def lights(text):
    """(position, intensity, attenuation, spot) of each light of a scene, and the ambient intensity"""
    found, ambient = [], 0
    for line in text.split("\n"):
        words = line.split("#")[0].split()
        if words[:1] == ["ambient"]:
            ambient += float(words[2])
        if words[:1] == ["light"]:
            def numbers(word, count, otherwise):
                return [*map(float, words[words.index(word) + 1:][:count])] if word in words else otherwise
            place = np.array(numbers("position", 3, None) or 1000 * unit(np.array(numbers("direction", 3, None))))
            found.append((place, float(words[2]), numbers("attenuation", 3, (1, 0, 0)),
                          numbers("spot", 5, (0, 0, 1, 180, 0))))
    return found, ambient


def light_map(scene, casts, surface, size, centre, radius, softness):
    """The share of light, row by row from the top, that reaches a surface past the objects whose lines match `casts`;
    these lie in a sphere about `centre`. `softness` is the size of each light, as a share of its distance."""
    with open(f"{SCENES}/{scene}.scene", encoding="ascii") as file:
        text = file.read().replace("../", os.path.abspath(SCENES) + "/../")
    scene = "\n".join(line for line in text.split("\n") if not re.match("wavelengths|size|camera|light|ambient", line)
                      and (not line.startswith("object ") or re.search(casts, line)))
    u, v = np.meshgrid((np.arange(size[0]) + 0.5) / size[0], 1 - (np.arange(size[1]) + 0.5) / size[1])
    points, normals = surface(u, v)
    found, ambient = lights(text)
    total, lit = np.zeros_like(u), np.zeros_like(u)

    def add(eye, weight, spot):
        there = unit(eye - points)
        within = -there @ unit(np.array(spot[:3]))
        weight = weight * np.where(within >= np.cos(np.radians(spot[3])), within.clip(0) ** spot[4], 0)
        cosine = weight * np.einsum("ijk,ijk->ij", there, normals).clip(0)
        total[:] += cosine
        if cosine.max() > 0:
            lit[:] += cosine * seen(scene, eye, centre, radius, points)
    for way in spread(N_AMBIENT):
        add(centre + 40 * radius * way, 4 * ambient / N_AMBIENT, (0, 0, 1, 180, 0))  # the mean cosine is 1/4
    for place, intensity, (a, b, c), spot in found:
        distance = np.linalg.norm(place - centre)
        for way in spread(N_POINTS):
            add(place + way * softness * distance, intensity / (a + b * distance + c * distance ** 2) / N_POINTS, spot)
    return lit / np.maximum(total, 1e-9)


def flat(x0, x1, z0, z1, y):
    """A floor: u runs along x from x0 to x1, v from z0 to z1"""
    def surface(u, v):
        points = np.stack([x0 + u * (x1 - x0), np.full_like(u, y), z0 + v * (z1 - z0)], -1)
        return points, np.broadcast_to((0.0, 1.0, 0.0), points.shape)
    return surface


def upright(x0, x1, y0, y1, z):
    """A wall that faces +z: u runs along x from x0 to x1, v from y0 to y1"""
    def surface(u, v):
        points = np.stack([x0 + u * (x1 - x0), y0 + v * (y1 - y0), np.full_like(u, z)], -1)
        return points, np.broadcast_to((0.0, 0.0, 1.0), points.shape)
    return surface


def backdrop(u, v, scale=1):
    points = scale * np.array([[models.cove(*corner) for corner in zip(*row)] for row in zip(u, v)])
    return points, unit(np.cross(np.gradient(points, axis=1), -np.gradient(points, axis=0)))


def board(x, y):
    """Seven boards of wood along x"""
    joint = textures.off_centre(y, 7)
    return np.where(joint > 0.485, 0.4, 1) * textures.wood(2 * x % 1, (2 * y + 0.37 * np.floor(7 * y)) % 1)


def carpet(x, y):
    """A rug with a border, a field of lozenges, and fringes"""
    far = np.minimum(np.minimum(x, 1 - x) * 13, np.minimum(y, 1 - y) * 8)  # from the edge, in lengths of the room
    across, down = 13 * (x - 0.5), 8 * (y - 0.5)
    field = 0.62 + 0.3 * ((np.abs(across % 1 - 0.5) + np.abs(down % 1 - 0.5) < 0.28)
                          | (np.abs(across % 1 - 0.5) + np.abs(down % 1 - 0.5) > 0.9))
    border = 0.4 + 0.5 * (np.abs((across + down) * 2 % 1 - 0.5) < 0.22)
    value = np.where(far < 1.1, border, field)
    value = np.where((np.abs(far - 1.1) < 0.06) | (np.abs(far - 0.35) < 0.06), 0.98, value)
    value = np.where(far < 0.29, 0.5, value)
    return value * (0.94 + 0.06 * textures.wave(64 * x) * textures.wave(40 * y))


def corners(x, y):
    """Plaster that darkens towards the corners of the room"""
    far = [np.minimum(x, 1 - x) * 20, y * 11.7, (1 - y) * 11.7]
    return textures.plaster(5 * x % 1, 3 * y % 1) * np.prod([1 - 0.3 * np.exp(-each / 1.2) for each in far], axis=0)


# name: size; scene; pattern of the objects that cast shadows; surface; the sphere they lie in; softness of lights;
# the texture of the surface itself
MAPS = {
    "metals-shadow": ((512, 640), "metals", "material (gold|copper|silver|alu)", backdrop, (0, 1.5, -1), 12, 0.12, None),
    "spheres-shadow": ((384, 448), "spheres", "object sphere", lambda u, v: backdrop(u, v, 0.6), (0, 1.2, 0), 5, 0.2,
                       None),
    "room-table": ((512, 256), "room", "teapot|bowl|vase|torus|cone 0.3|sphere 0[.][23]|book|atlas",
                   flat(-4, 4, -8, -12, -1.4), (0, -0.8, -10), 4.4, 0.1, board),
    "room-rug": ((512, 320), "room", "table.obj|chair.obj", flat(-6.5, 6.5, -6.2, -14.2, -4.15), (0, -2.2, -9.8), 7.2,
                 0.1, carpet),
    "room-wall": ((384, 224), "room", "walnut repeat|frame|clock", upright(-10, 10, -4.2, 7.5, -17), (1, 0.5, -16), 7,
                  0.1, corners),
}


def main(folder, names):
    for name in names or MAPS:
        size, scene, casts, surface, centre, radius, softness, pattern = MAPS[name]
        share = light_map(scene, casts, surface, size, np.array(centre, float), radius, softness)
        if pattern:
            share *= pattern(*textures.grid(*size))
        samples = np.round(share.clip(0, 1) * 255).astype(np.uint8)
        tifffile.imwrite(os.path.join(folder, name + ".tif"), samples, metadata=None, compression="zlib",
                         predictor=True, software=False)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
