#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Makes data/builtin/textures/*.tif again, except for the rendered picture.tif, and data/builtin/reliefs/*.tif:
`test/make/textures.py data/builtin`. Each but the rug is a tile that repeats without a seam. The values of a texture
multiply the reflectance of the surface, those of a relief are heights. All are made from formulas and seeded noise, and
none is copied; MIT licence."""
import os
import sys

import numpy as np
import tifffile


def grid(width, height):
    """x, y of the pixels' centres, 0 to 1 over the tile, y downwards."""
    return np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)


def noise(x, y, seed, columns, rows, octaves=1):
    """Repeating smooth noise of mean 0, about -1 to 1: random values on a lattice, then on finer lattices of half the
    weight each."""
    total = np.zeros_like(x)
    for octave in range(octaves):
        across, down = columns << octave, rows << octave
        value = np.random.RandomState(seed + octave).uniform(-1, 1, (down, across))
        i, j = np.floor(x * across).astype(int), np.floor(y * down).astype(int)
        a, b = (t * t * (3 - 2 * t) for t in (x * across - i, y * down - j))
        corner = [value[(j + dj) % down, (i + di) % across] for dj in (0, 1) for di in (0, 1)]
        top, bottom = corner[0] + a * (corner[1] - corner[0]), corner[2] + a * (corner[3] - corner[2])
        total += (top + b * (bottom - top)) / (1 << octave)
    return total


def cells(x, y, seed, columns, rows):
    """Distances, in cells, to the nearest and second nearest of jittered points, one in each cell of the lattice;
    and a random number that belongs to the nearest."""
    value = np.random.RandomState(seed).uniform(0, 1, (3, rows, columns))
    i, j = np.floor(x * columns).astype(int), np.floor(y * rows).astype(int)
    distance, own = [], []
    for di, dj in ((di, dj) for di in (-2, -1, 0, 1, 2) for dj in (-2, -1, 0, 1, 2)):
        dx, dy, random = value[:, (j + dj) % rows, (i + di) % columns]
        distance.append(np.hypot(i + di + dx - x * columns, j + dj + dy - y * rows))
        own.append(random)
    nearest, next_nearest = np.sort(distance, axis=0)[:2]
    return nearest, next_nearest, np.choose(np.argmin(distance, axis=0), own)


def edge(signed, pixels):
    """1 for a positive distance and 0 for a negative one, with a ramp of one pixel between; distances are in
    tiles."""
    return np.clip(signed * pixels + 0.5, 0, 1)


def wave(phase):
    """A cosine of period 1, 0 to 1."""
    return 0.5 + 0.5 * np.cos(2 * np.pi * phase)


def off_centre(x, count):
    """Distance from the middle of the nearest of `count` equal parts, 0 to 0.5 parts."""
    return np.abs(x * count % 1 - 0.5)


def bricks(x, y, columns, rows, seed, joint, pixels):
    """Staggered rows: 1 inside a brick and 0 in the joints, and a random number for each brick."""
    row = np.floor(y * rows).astype(int)
    along = x + row % 2 * 0.5 / columns
    own = np.random.RandomState(seed).uniform(0, 1, (rows, columns))
    inside = np.minimum((0.5 - off_centre(along, columns)) / columns, (0.5 - off_centre(y, rows)) / rows)
    return edge(inside - joint, pixels), own[row, np.floor(along * columns).astype(int) % columns]


# ---- natural surfaces ----

def grass(x, y):
    blades = np.maximum(noise(x + 0.02 * noise(x, y, 1, 5, 5), y, 2, 42, 11),
                        noise(x + 0.02 * noise(x, y, 3, 4, 6), y, 4, 38, 9))
    return 0.58 + 0.38 * blades + 0.12 * noise(x, y, 5, 4, 4, 2)


def sand(x, y):
    return 0.72 + 0.1 * noise(x, y, 10, 24, 24, 2) + 0.16 * np.sin(
        2 * np.pi * (5 * y + 0.25 * noise(x, y, 12, 3, 3)))


def bark(x, y):
    near, next_near, own = cells(x + 0.05 * noise(x, y, 20, 4, 3), y, 21, 7, 3)
    return 0.25 + 0.5 * np.clip(2.2 * (next_near - near), 0, 1) + 0.15 * own + 0.1 * noise(x, y, 22, 16, 8)


def stone(x, y):
    near, next_near, own = cells(x, y, 30, 5, 5)
    return 0.2 + np.clip(5 * (next_near - near) - 0.2, 0, 1) * (
        0.45 + 0.25 * own + 0.12 * noise(x, y, 31, 12, 12, 2) - 0.15 * near)


def leather(x, y):
    near, next_near, own = cells(x, y, 40, 11, 11)
    return 0.55 + 0.3 * np.clip(3 * (next_near - near), 0, 1) + 0.12 * own - 0.1 * near


def clouds(x, y):
    return 0.68 + 0.3 * noise(x, y, 50, 3, 3, 4)


def marble(x, y):
    vein = np.abs(np.sin(np.pi * (2 * x + y + 0.9 * noise(x, y, 60, 3, 3, 4))))
    return 0.5 + 0.45 * vein ** 0.4 + 0.05 * noise(x, y, 64, 8, 8, 2)


def plaster(x, y):
    return 0.85 + 0.09 * noise(x, y, 70, 8, 8, 3)


# ---- wood and clay ----

def grain(x, y, seed):
    """Growth lines along x."""
    ring = 6 * y + 0.8 * noise(x, y, seed, 2, 3, 2)
    return 0.5 * (ring % 1) ** 2 + 0.25 * noise(x, y, seed + 5, 5, 40) + 0.1 * noise(x, y, seed + 6, 16, 64)


def wood(x, y):
    return 0.82 - 0.38 * grain(x, y, 100)


def planks(x, y):
    board, own = bricks(x, y, 1, 5, 110, 0.006, 128)
    shifted = (x + own) % 1, (y + np.floor(own * 7) / 7) % 1
    return 0.25 + board * (0.42 + 0.25 * own - 0.22 * grain(*shifted, 111))


def brick(x, y):
    clay, own = bricks(x, y, 3, 8, 120, 0.01, 128)
    rough = noise(x, y, 121, 24, 24, 2)
    return 0.92 + 0.04 * rough - clay * (0.32 + 0.28 * own + 0.05 * rough)


def tiles(x, y):
    return 0.5 + 0.45 * edge(0.235 - np.maximum(off_centre(x, 2), off_centre(y, 2)) / 2, 64) - 0.12 * (
        (np.floor(2 * x) + np.floor(2 * y)) % 2)


# ---- cloth and prints ----

def weave(x, y):
    over = (np.floor(4 * x) + np.floor(4 * y)) % 2
    across, along = np.where(over, (off_centre(x, 4), off_centre(y, 4)), (off_centre(y, 4), off_centre(x, 4)))
    return 0.35 + 0.62 * np.cos(np.pi * across) * (1 - 1.2 * along)


def knit(x, y):
    side = off_centre(x, 3)
    return 0.4 + 0.55 * wave(4 * y + 1.2 * side) * np.sin(2 * np.pi * np.clip(side, 0.03, 0.47))


def tartan(x, y):
    def band(t):
        return 0.45 * edge(0.17 - np.abs(t - 0.4), 64) + 0.25 * edge(0.03 - np.abs(t - 0.8), 64)
    twill = (np.floor(64 * x) + np.floor(64 * y)) % 4 < 2
    return 0.95 - np.where(twill, band(x), band(y)) - 0.2 * (band(x) + band(y)) / 2


def checks(x, y):
    return 0.35 + 0.6 * ((np.floor(4 * x) + np.floor(4 * y)) % 2)


def stripes(x, y):
    return 0.4 + 0.55 * edge((0.25 - off_centre(x + y, 3)) / 3, 64)


def dots(x, y):
    return 0.95 - 0.55 * edge(0.13 - np.hypot(off_centre(x, 2), off_centre(y, 2)) / 2, 64) - 0.55 * edge(
        0.07 - np.hypot(0.5 - off_centre(x, 2), 0.5 - off_centre(y, 2)) / 2, 64)


def rings(x, y):
    return 0.35 + 0.6 * wave(5 * np.hypot(x - 0.5, y - 0.5)) * edge(0.5 - np.hypot(x - 0.5, y - 0.5), 64)


def zigzag(x, y):
    return 0.4 + 0.55 * edge((0.25 - off_centre(y + off_centre(x, 4) / 4, 4)) / 4, 64)


def scales(x, y):
    shade = np.zeros_like(x)
    for row in range(-1, 9):  # each tile overlaps the tile below it
        dx = (off_centre(x + row % 2 / 8, 4)) / 4
        far = np.hypot(dx, np.maximum(y - row / 8, 0) * 0.75)
        shade = np.where((far < 0.1768) & (y >= row / 8), 0.95 - 2.6 * far, shade)
    return np.maximum(shade, 0.4)


def honeycomb(x, y):
    def out(shift):  # 1/8 at a cell's rim
        dx, dy = off_centre(x + shift, 4) / 4, off_centre(y + 2 * shift, 2) / 2
        return np.maximum(dx, dx / 2 + 0.75 * dy)
    return 0.45 + 0.5 * edge(0.113 - np.minimum(out(0), out(0.125)), 64)


def lozenges(x, y):
    return 0.35 + 0.3 * (np.floor(2 * (x + y)) % 2) + 0.3 * (np.floor(2 * (x - y)) % 2)


def waves(x, y):
    return 0.65 + 0.3 * np.sin(2 * np.pi * (5 * y + 0.3 * np.sin(4 * np.pi * x)))


def boards(x, y):
    """Seven boards along x"""
    joint = off_centre(y, 7)
    return np.where(joint > 0.485, 0.4, 1) * wood(2 * x % 1, (2 * y + 0.37 * np.floor(7 * y)) % 1)


def rug(x, y):
    """13 by 8: a border, a field of lozenges, and fringes"""
    far = np.minimum(np.minimum(x, 1 - x) * 13, np.minimum(y, 1 - y) * 8)  # from the edge
    across, down = 13 * (x - 0.5), 8 * (y - 0.5)
    field = 0.62 + 0.3 * ((np.abs(across % 1 - 0.5) + np.abs(down % 1 - 0.5) < 0.28)
                          | (np.abs(across % 1 - 0.5) + np.abs(down % 1 - 0.5) > 0.9))
    border = 0.4 + 0.5 * (np.abs((across + down) * 2 % 1 - 0.5) < 0.22)
    value = np.where(far < 1.1, border, field)
    value = np.where((np.abs(far - 1.1) < 0.06) | (np.abs(far - 0.35) < 0.06), 0.98, value)
    value = np.where(far < 0.29, 0.5, value)
    return value * (0.94 + 0.06 * wave(64 * x) * wave(40 * y))


# ---- reliefs ----

def weave_relief(x, y):
    """Plain weave, two by two round threads: those along x lie above where those along y lie below."""
    i, j = np.floor(2 * x), np.floor(2 * y)
    over = np.where((i + j) % 2 == 0, 1, -1)
    bend_x, bend_y = np.sin(np.pi * 2 * x) * (-1) ** i, np.sin(np.pi * 2 * y) * (-1) ** j
    thread_x = np.sqrt(np.maximum(1 - (2.2 * (2 * y - j - 0.5)) ** 2, 0)) + 0.5 * over * np.abs(bend_x)
    thread_y = np.sqrt(np.maximum(1 - (2.2 * (2 * x - i - 0.5)) ** 2, 0)) - 0.5 * over * np.abs(bend_y)
    return np.maximum(np.maximum(thread_x, thread_y), 0) / 1.5


def bricks_relief(x, y):
    """Four rows of two, with round edges and a rough face"""
    row = np.floor(y * 4).astype(int)
    along = x + row % 2 * 0.25
    own = np.random.RandomState(90).uniform(0, 1, (4, 2))[row, np.floor(along * 2).astype(int) % 2]
    inside = np.minimum((0.5 - off_centre(along, 2)) / 2, (0.5 - off_centre(y, 4)) / 4)
    face = 0.85 + 0.1 * own + 0.05 * noise(x, y, 91, 8, 8, 3)
    rise = np.clip((inside - 0.012) / 0.03, 0, 1)
    return np.where(inside > 0.012, face * np.sqrt(1 - (1 - rise) ** 4), 0.1 + 0.1 * noise(x, y, 92, 16, 16, 2)).clip(0)


def ripples_relief(x, y):
    """Sand that wind has moved: steep on one side"""
    phase = 6 * y + 0.35 * noise(x, y, 93, 3, 3, 2)
    return (0.5 + 0.36 * np.sin(2 * np.pi * phase + 0.5 * np.sin(2 * np.pi * phase)) + 0.08 * noise(x, y, 94, 6, 6, 2))


RELIEFS = (weave_relief, bricks_relief, ripples_relief)
SIZES = {(512, 256): (boards,), (512, 320): (rug,), (128, 128): (grass, stone, marble, planks, brick), (128, 64): (wood,), (64, 128): (bark,),
         (64, 64): (sand, leather, clouds, plaster, tiles, weave, knit, tartan, checks, stripes, dots,
                    rings, zigzag, scales, honeycomb, lozenges, waves)}


def write(name, samples):
    tifffile.imwrite(name + ".tif", samples, metadata=None, compression="zlib", software=False)


def main(folder):
    for make in RELIEFS:  # 4096 steps are fine enough for normals
        heights = np.round(make(*grid(128, 128)).clip(0, 1) * 4095).astype(np.uint16) * 16
        write(os.path.join(folder, "reliefs", make.__name__.replace("_relief", "")), heights)
    for size, makers in SIZES.items():
        for make in makers:
            share = make(*grid(*size)).clip(0, 1)
            if make is plaster:  # faint, so that 16 bits are needed to keep it smooth
                samples = np.round(share * 1023).astype(np.uint16) * 64
            else:  # 64 steps are fine enough for the eye, and deflate well
                samples = np.round(share * 63).astype(np.uint8) * 4 + 3
            write(os.path.join(folder, "textures", make.__name__), samples)


if __name__ == "__main__":
    main(sys.argv[1])
