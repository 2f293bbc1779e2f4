#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Renders pictures of single effects, and a surface in perspective, with both renderers and compares every band with
radiances in closed form. Prints TAP."""
import re

import numpy as np
import tifffile

from rendered import (D65, LAMP_A, RED, WAVELENGTHS, Picture, built_in, cases, check, done, objects_of, pages_of, path_of, per_band, reference,
                      run, write, write_stack)

SINGLE = 2.0 ** -24  # texels are kept in single precision, rounded once
UV = np.interp(WAVELENGTHS, *built_in("uv"))
FLAT = "size 12 8\ncamera ortho 12\n"
FACING = "light d65 1 direction 0 0 1\n"


def rotation(degrees, axis):
    """Right-handed rotation after Rodrigues."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.radians(degrees)
    return np.eye(3) + np.sin(turn) * cross + (1 - np.cos(turn)) * cross @ cross


def square(words, *statements):
    """A square of a material that fills the picture and faces it."""
    return FLAT + "".join(statements) + f"material m {{ {words} }}\nobject plane 12 8 material m"


def pixel_grid(width, height, extent):
    """x and y of the pixel centres in an orthographic view of that width."""
    step = extent / width
    return np.meshgrid((np.arange(width) + 0.5) * step - extent / 2,
                       extent * height / width / 2 - (np.arange(height) + 0.5) * step)


# ---- fluorescence ----

# rounded, so that the paint's file is the same on each processor
EXCITATION = np.round(np.exp(-((WAVELENGTHS - 390) / 35) ** 2), 6)
EMISSION = np.round(0.7 * np.exp(-((WAVELENGTHS - 530) / 30) ** 2), 6)


def excited(light):
    """Equations 6 to 9 of the 1998 thesis, on its 93 wavelengths, which are those of the tables."""
    return (light * EXCITATION).sum() / EXCITATION.sum() * EMISSION


def fluorescence(renderer):
    lines = (f"{nm} {r!r}\nf {nm} {ex!r} {em!r}\n" for nm, r, ex, em in
             zip(WAVELENGTHS, RED.tolist(), EXCITATION.tolist(), EMISSION.tolist()))
    write("paint.txt", "".join(lines))
    surface = "material paint paint.txt\nobject plane 12 8 material paint"

    def holds(name, lights, expected, *options):
        Picture("paint", renderer, FLAT + lights + surface, *options).agrees(per_band(expected),
                                                                             f"{renderer}: {name}")

    black_light = "light uv 0.8 direction 0 0 1\n"
    holds("under a black light a surface is uv R + N Em", black_light, 0.8 * (UV * RED + excited(UV)))
    holds("turned away by 60 degrees both terms are halved",
          "light uv 0.8 direction 1.7320508075688772 0 1\n", 0.4 * (UV * RED + excited(UV)))
    holds("ambient light and two lights each have their own N",
          "ambient a 0.3\nlight d65 0.5 direction 0 0 1\n" + black_light,
          0.3 * (LAMP_A * RED + excited(LAMP_A)) + 0.5 * (D65 * RED + excited(D65))
          + 0.8 * (UV * RED + excited(UV)))
    dark = UV == 0  # from 540 nm on
    holds("N Em is also added at wavelengths where the black light is 0", black_light, 0.8 * excited(UV)[dark],
          "--wavelengths", ",".join(map(str, WAVELENGTHS[dark])))
    emission = 0.5 * np.exp(-4 * np.log(2) * ((WAVELENGTHS - 520) / 60) ** 2)
    before, at, after = (UV[WAVELENGTHS == nm][0] for nm in (395, 400, 405))
    # the mean of |nm - 400| over the line is 1/sqrt(4 pi ln 2), and the light is linear on both sides; the
    # program's sum in steps of 1/40 of the line's width is off by less than a millionth
    n = at + (before + after - 2 * at) / 10 / np.sqrt(4 * np.pi * np.log(2))
    words = "diffuse RED fluorescence gaussian:400,1 gaussian:520,60*0.5"
    Picture("line", renderer, square(words, black_light)).agrees(
        per_band(0.8 * (UV * RED + n * emission)),
        f"{renderer}: the emission excited at a line follows the light at that line", slack=1e-6)


def bispectral(renderer):
    def picture(name, excitation, emission, share, light):
        rows = [",".join(map(repr, [nm, *row])) for nm, row in zip(emission, share.tolist())]
        write("matrix.csv", "\n".join(["nm," + ",".join(map(repr, excitation)), *rows]) + "\n")
        scene = square("diffuse 0.3 donaldson matrix.csv", f"light {light} 1 direction 0 0 1\n")
        return Picture(name, renderer, scene)

    emission = [500.0, 510.0, 530.0]
    share = np.zeros((3, 3))
    share[:, 1] = 0.1, 0.3, 0.2
    write("line.csv", "399 0\n400 2\n401 0\n")
    given = 2 * share[:, 1] / [10, 15, 20]  # a line of 1 nm, spread over the bands of emission
    expected = np.interp(WAVELENGTHS, emission, given, 0, 0) + 0.3 * 2 * (WAVELENGTHS == 400)
    picture("column", [380.0, 400.0, 420.0], emission, share, "line.csv").agrees(
        per_band(expected), f"{renderer}: a line light excites its column of a Donaldson matrix")
    excitation = [float(nm) for nm in WAVELENGTHS if nm <= 430]
    emission = [float(nm) for nm in range(450, 610, 10)]
    share = np.random.default_rng(2).uniform(0, 0.04, (len(emission), len(excitation)))
    given = share @ UV[WAVELENGTHS <= 430] * 5 / 10
    expected = np.interp(WAVELENGTHS, emission, given, 0, 0) + 0.3 * UV
    picture("matrix", excitation, emission, share, "uv").agrees(
        per_band(expected), f"{renderer}: on the light's own grid the emission is matrix x light")


def diagonals(renderer):
    """Matrices as bispectrometers measure them: the diagonal is the reflectance. The sums are plain ones, on the lights' grid."""
    n = len(WAVELENGTHS)
    dice = np.random.default_rng(3)
    emitted = np.tril(dice.uniform(0, 0.006, (n, n)), -1)  # [emission][excitation], at longer wavelengths
    reflectance = np.round(dice.uniform(0.1, 0.4, n), 4)
    cells = {"shares": emitted + np.diag(reflectance), "densities": emitted / 5 + np.diag(reflectance)}
    for word, matrix in cells.items():
        rows = [",".join(map(repr, [int(nm), *row])) for nm, row in zip(WAVELENGTHS, matrix.tolist())]
        write(f"{word}.csv", "\n".join(["nm," + ",".join(str(int(nm)) for nm in WAVELENGTHS), *rows]) + "\n")
    for light in ("d65", "a", "fluorescent"):
        spectrum = np.interp(WAVELENGTHS, *built_in(light))
        expected = per_band(reflectance * spectrum + emitted @ spectrum)
        for words in ("donaldson shares.csv", "diffuse 0 donaldson shares.csv shares", "donaldson densities.csv densities"):
            Picture("diagonal", renderer, square(words, f"light {light} 1 direction 0 0 1\n")).agrees(
                expected, f"{renderer}: {words} under {light} is reflectance x light and the sum of each row")
    write("mirror.csv", "nm 300 400 530 540 760\n" + "".join(
        f"{nm} {' '.join('0.3' if nm == other else '0' for other in (300, 400, 530, 540, 760))}\n" for nm in (300, 400, 530, 540, 760)))
    line = np.interp(WAVELENGTHS, *built_in("fluorescent"))
    Picture("mirror", renderer, square("donaldson mirror.csv", "light fluorescent 1 direction 0 0 1\n")).agrees(
        per_band(0.3 * line), f"{renderer}: a line lamp is reflected by the diagonal where the lamp shines, {0.3 * line.max():.3f} at its peak")


# ---- textures ----

def sample(texels, u, v, linear):
    """A repeating texture at u, v in texels from its lower left corner; texels[0] is its top row."""
    height, width = texels.shape

    def at(i, j):
        return texels[height - 1 - j.astype(int) % height, i.astype(int) % width]
    if not linear:
        return at(np.floor(u), np.floor(v))
    i, j = np.floor(u - 0.5), np.floor(v - 0.5)
    x, y = u - 0.5 - i, v - 0.5 - j
    return ((at(i, j) * (1 - x) + at(i + 1, j) * x) * (1 - y)
            + (at(i, j + 1) * (1 - x) + at(i + 1, j + 1) * x) * y)


def textured(renderer, name, texels, mode, width, height, repeat, *options):
    scene = (f"size {width} {height}\ncamera ortho {width}\n{FACING}"
             f"material m {{ diffuse RED texture {name}.tif {mode} }}\n"
             f"object plane {width} {height} material m repeat {repeat[0]} {repeat[1]}")
    x, y = pixel_grid(width, height, width)
    u = (x / width + 0.5) * texels.shape[1] * repeat[0]
    v = (y / height + 0.5) * texels.shape[0] * repeat[1]
    Picture("texture", renderer, scene, *options).agrees(
        per_band(D65 * RED) * sample(texels, u, v, mode == "linear"),
        f"{renderer}: {name} texels, {mode}, repeated {repeat[0]} x {repeat[1]}, {width} x {height} pixels",
        slack=2 * SINGLE)


def textures(renderer):
    random = np.random.default_rng(3)
    grey8 = random.integers(0, 256, (2, 3)).astype(np.uint8)
    grey16 = random.integers(0, 65536, (2, 3)).astype(np.uint16)
    colour = random.integers(0, 256, (2, 3, 3)).astype(np.uint8)
    luma = colour @ np.array([0.2126, 0.7152, 0.0722]) / 255
    for name, stored, texels in (("grey8", grey8, grey8 / 255), ("grey16", grey16, grey16 / 65535),
                                 ("colour", colour, luma)):
        tifffile.imwrite(path_of(name + ".tif"), stored,
                         photometric="rgb" if stored.ndim == 3 else "minisblack")
        # 3 pixels a texel, the middle one at its centre
        for mode in ("nearest", "linear"):
            textured(renderer, name, texels, mode, 9, 6, (1, 1))
            textured(renderer, name, texels, mode, 18, 18, (2, 3))
        # 3 pixels for 2 texels: some are half-way between centres, where the nearest is either
        textured(renderer, name, texels, "linear", 9, 9, (2, 3))
    whole = "diffuse RED gloss 10 specular 0.4 emission 0.2 texture grey8.tif"
    picture = Picture("whole", renderer, "size 9 6\ncamera ortho 9\nambient a 0.3\n" + FACING
                      + f"material m {{ {whole} }}\nobject plane 9 6 material m")
    radiance = D65 * (RED + 0.4) + 0.3 * LAMP_A * RED + 0.2
    picture.agrees(per_band(radiance) * np.kron(grey8 / 255, np.ones((3, 3))),
                   f"{renderer}: a texture multiplies light, highlight, ambient light and emission",
                   slack=2 * SINGLE)


def two_repeats(renderer):
    """Objects of one shape, each with its own repeat: 3 and 1 pixels a texel, and 1 of them in one direction only."""
    texels = np.random.default_rng(5).integers(0, 256, (2, 3)).astype(np.uint8)
    tifffile.imwrite(path_of("both.tif"), texels)
    repeats = (1, 1), (3, 3), (1, 3), (3, 1.5)
    scene = f"size 36 6\ncamera ortho 36\n{FACING}material m {{ diffuse RED texture both.tif nearest }}\n" + "".join(
        f"object plane 9 6 material m {f'repeat {across} {up} ' if across + up > 2 else ''}translate {9 * i - 13.5} 0 0\n"
        for i, (across, up) in enumerate(repeats))
    x, y = (np.arange(9) + 0.5) / 9, (np.arange(6)[::-1] + 0.5) / 6
    expected = np.hstack([texels[::-1][np.ix_((y * up * 2).astype(int) % 2, (x * across * 3).astype(int) % 3)] for across, up in repeats]) / 255
    Picture("both", renderer, scene).agrees(per_band(D65 * RED) * expected,
                                            f"{renderer}: objects of one shape repeat a texture differently", slack=2 * SINGLE)


def twins(renderer):
    """The first of two squares in one place is seen."""
    scene = f"{FLAT}{FACING}material m {{ diffuse RED }}\nmaterial n {{ diffuse 1 }}\nobject plane 12 8 material m\nobject plane 12 8 material n"
    Picture("twins", renderer, scene).agrees(per_band(D65 * RED), f"{renderer}: of two squares in one place the first is seen")


def flat_texture(renderer):
    """Flat shading takes the light of one vertex; a texture is smooth all the same."""
    texels = np.random.default_rng(7).integers(0, 256, (2, 3)).astype(np.uint8)
    tifffile.imwrite(path_of("flat.tif"), texels)
    scene = (f"size 9 6\ncamera ortho 9\nshading flat\n{FACING}material m {{ diffuse RED texture flat.tif nearest }}\nobject plane 9 6 material m")
    Picture("flat-texture", renderer, scene).agrees(per_band(D65 * RED) * np.kron(texels, np.ones((3, 3))) / 255,
                                                    f"{renderer}: under flat shading a texture is not flat", slack=2 * SINGLE)


def texel_borders(renderer):
    """Two texels a pixel: each pixel centre lies on a corner of four texels, and the nearest one is the
    one to its upper right, floor(u), floor(v). OpenGL may take any of them, so that hardly a pixel is checked."""
    texels = np.random.default_rng(4).integers(0, 256, (64, 64)).astype(np.uint8)
    tifffile.imwrite(path_of("borders.tif"), texels)
    if renderer == "raster":
        textured(renderer, "borders", texels / 255, "nearest", 32, 32, (1, 1), "--no-check")
        return
    path = write("borders.scene", f"size 32 32\ncamera ortho 32\n{FACING}material m {{ diffuse 1 texture borders.tif nearest }}\n"
                 "object plane 32 32 material m")
    result = run("render", path, "-o", "/dev/null", "-q")
    check(result.returncode == 1 and re.search(r"not verified: .*its texture changes too much within a rounding", result.stderr),
          "where OpenGL may take any of four texels, the picture is not verified", result.stderr)


def dark_texture(renderer):
    texels = np.array([[51, 102]], np.uint8)
    tifffile.imwrite(path_of("dark.tif"), texels)
    picture = Picture("dark", renderer, square("diffuse RED texture dark.tif nearest", FACING))
    expected = np.max(D65 * RED) * 102 / 255
    check(abs(picture.report["full_scale"] / expected - 1) <= 2 * SINGLE,
          f"{renderer}: the full scale is light x reflectance x the largest texel, which is below 1",
          f"{picture.report['full_scale']}, not {expected}")


def tiles_of_steps(renderer):
    """Two tiles of a buffer of 8 bits: numbers of triangles are drawn before each, in a context of their own. The object that
    is drawn first has no texture, also in the second tile."""
    tifffile.imwrite(path_of("half.tif"), np.full((1, 1), 128, np.uint8))
    scene = (f"size 8300 4\ncamera ortho 8300\n{FACING}material plain {{ diffuse 0.5 }}\n"
             "material half { diffuse 0.5 texture half.tif }\n"
             "object plane 8300 2 material plain translate 0 1 0\nobject plane 8300 2 material half translate 0 -1 0\n")
    steps = ("--buffer", "8") if renderer == "gl" else ()
    picture = Picture("tiles", renderer, scene, "--wavelengths", "550", *steps)
    rows = picture.radiance[0] / picture.report["full_scale"]
    check(np.abs(rows - np.array([[1], [1], [128 / 255], [128 / 255]])).max() <= 0.51 / 255,
          f"{renderer}: an object without a texture has none in the second tile either", rows[:, [0, 8299]])


def spectral_textures(renderer):
    size = "size 24 18\ncamera ortho 24\n"
    source = Picture("source", renderer, size + "ambient a 0.2\nlight d65 1 position 3 4 20\n"
                     "material red { diffuse RED gloss 20 }\nobject sphere 8 20 20 material red\n",
                     "--wavelengths", "400:700:20")
    pages = source.radiance.astype(np.float32).astype(float)

    def scene_of(texture, mode):
        return (f"{size}ambient 1 1\nmaterial m {{ diffuse 1 spectral-texture {texture}.tif {mode} }}\n"
                "object plane 24 18 material m")

    def shown(name, mode, wavelengths, expected, texture=f"source-{renderer}"):
        Picture("shown", renderer, scene_of(texture, mode), "--wavelengths", wavelengths).agrees(
            expected, f"{renderer}: {name}, {mode}", slack=2 * SINGLE)

    write_stack("single.tif", np.float32(pages[5:6]), [500])
    for mode in ("nearest", "linear"):
        shown("a stack as texture shows its own radiances", mode, "400:700:20", pages)
        shown("between two pages a texture is interpolated linearly", mode, "405:685:20",
              0.75 * pages[:-1] + 0.25 * pages[1:])
        shown("beyond its pages a texture keeps the end pages", mode, "350,399,701,760", pages[[0, 0, -1, -1]])
        shown("a texture of one page is the same at all wavelengths", mode, "300,500,760", pages[[5, 5, 5]], "single")
    bright = np.float32([0 * pages[0], 2.0 ** 60 + 0 * pages[0], pages[0]])
    write_stack("bright.tif", bright, [400, 500, 700])
    seen = pages_of(reference("seen.tif", write("bright.scene", scene_of("bright", "nearest")), "--wavelengths", "400,700",
                              "--depth", "32f"))
    write_stack("last.tif", np.float32([0.5, 4])[:, None, None] + 0 * np.float32(pages[0]), [400, 700])
    scale = Picture("last", renderer, scene_of("last", "nearest"), "--wavelengths", "400").report["full_scale"]
    check(scale == 4, f"{renderer}: the last page of a texture counts for its largest value, on all pages", scale)
    check((seen == bright[[0, 2]]).all(), "not the smallest part of a page, however bright, is in its neighbours")


# ---- lights ----

# Squares behind one another on the z axis, below the eye at the origin, each larger than the one before it.
# A light on the axis reaches the four corners of a square equally, so that each square is a frame of one
# radiance. The whole scene is turned, because the picture must not depend on it, by a quarter about 1 2 2: all
# numbers of the scene are ninths, on each processor. The largest square reaches beyond the view.
RADII = np.arange(1, 8)
DEPTHS = -0.5 - 0.7 * RADII
CORNERS = np.array([RADII, RADII, DEPTHS], float).T
NINTHS = (1, -4, 8), (8, 4, 1), (-4, 7, 4)


def turned(*along):
    return " ".join(repr(sum(ninths * float(a) for ninths, a in zip(row, along)) / 9) for row in NINTHS)


def frames(values):
    """The picture in which each square has its spectrum [square, band]."""
    x, y = pixel_grid(54, 54, 13.5)
    return np.moveaxis(values[np.ceil(np.maximum(abs(x), abs(y))).astype(int) - 1], -1, 0)


def spots(renderer):
    squares = "".join(f"object plane {2 * r} {2 * r} material m translate 0 0 {z!r} rotate 90 1 2 2\n" for r, z in zip(RADII.tolist(), DEPTHS.tolist()))
    light = np.array([0, 0, 3.0])
    path = light - CORNERS
    distance = np.linalg.norm(path, axis=1)
    cosine = path[:, 2] / distance
    angles = np.round(np.degrees(np.arccos(cosine)), 6)

    def holds(name, words, weights):
        scene = (f"size 54 54\ncamera ortho 13.5 eye 0 0 0 look {turned(0, 0, -1)} up {turned(0, 1, 0)}\n"
                 f"light d65 1 position {turned(*light)} {words}\nmaterial m {{ diffuse RED }}\n{squares}")
        Picture("spot", renderer, scene).agrees(frames(weights[:, None] * D65 * RED), f"{renderer}: {name}")

    ahead, back = turned(0, 0, -1), turned(0, 0, 1)
    inside = np.arange(len(angles)) <= 3
    holds("a spot lights a corner just inside its cutoff",
          f"spot {ahead} {angles[3] + 1e-3:.6f} 0", cosine * inside)
    holds("a spot does not light a corner just outside its cutoff",
          f"spot {ahead} {angles[4] - 1e-3:.6f} 0", cosine * inside)
    holds("a spot weakens with the cosine's power", f"spot {ahead} 90 7.5", cosine * cosine ** 7.5)
    holds("the cutoff ends this power", f"spot {ahead} {angles[2] + 1e-3:.6f} 2",
          cosine ** 3 * (np.arange(len(angles)) <= 2))
    holds("a light of cutoff 180 is no spot, for any exponent", f"spot {back} 180 9", cosine)
    holds("a light weakens with distance by 1/(kc + kl d + kq d^2)", "attenuation 0.5 0.2 0.03",
          cosine / (0.5 + 0.2 * distance + 0.03 * distance ** 2))
    holds("attenuation may have a constant part alone", "attenuation 2 0 0", cosine / 2)
    holds("attenuation may lack the constant part", "attenuation 0 0 0.1", cosine / (0.1 * distance ** 2))
    holds("spot and distance multiply", f"attenuation 0.5 0 0.1 spot {ahead} 60 3",
          cosine ** 4 * (angles < 60) / (0.5 + 0.1 * distance ** 2))
    light[2] = DEPTHS[3] - 0.3  # the light is between the squares and lights those behind it
    path = light - CORNERS
    cosine = path[:, 2] / np.linalg.norm(path, axis=1)
    holds("a spot of cutoff 90 lights squares in front of it", f"spot {ahead} 90 0", np.maximum(cosine, 0))
    holds("a spot of cutoff 90 lights no square behind it", f"spot {back} 90 0\nambient d65 0.1", 0.1 + 0 * cosine)

    scene = square("diffuse RED", f"light d65 1 position 0 0 3 spot 0 0 -1 {np.degrees(np.arccos(3 / 61 ** 0.5)) + 1e-3:.6f} 0\n")
    Picture("rim", renderer, scene).agrees(per_band(3 / 61 ** 0.5 * D65 * RED),
                                           f"{renderer}: a spot whose rim alone reaches the corners of the only square lights it")


def grazing(renderer):
    """A highlight needs a cosine above 0 (OpenGL 2.1, section 2.14.1), also where the half-way direction has one of 0.7. Full scale is
    given, since noise could decide it."""
    scene = square("diffuse RED gloss 1", "ambient a 0.3\n", "light d65 1 direction 1 0 0\n")
    Picture("grazing", renderer, scene, "--full-scale", "1").agrees(
        per_band(0.3 * LAMP_A * RED), f"{renderer}: a light in the plane of a surface makes no highlight there")


def lights_alike(renderer):
    """Lights of one spectrum share their terms, each with its factor and its direction."""
    lights = FACING + "light d65*0.25 1 direction 0 0 1\nlight d65 0.5 direction 1.7320508075688772 0 1\n"
    Picture("alike", renderer, square("diffuse RED", lights)).agrees(
        per_band((1 + 0.25 + 0.5 * 0.5) * D65 * RED), f"{renderer}: lights of one spectrum and several factors add up")
    lights = "".join(f"light gaussian:{nm},40 1 direction 0 0 1\n" for nm in (450, 600))
    Picture("unlike", renderer, square("diffuse RED", lights)).agrees(
        per_band(sum(np.exp(-4 * np.log(2) * ((WAVELENGTHS - nm) / 40) ** 2) for nm in (450, 600)) * RED),
        f"{renderer}: lights of one formula and several parameters have spectra of their own")


def light_of_option(renderer):
    """--light gives a light another spectrum; it keeps its intensity, unless the option has one."""
    scene = square("diffuse RED", "light d65 0.5 direction 0 0 1\n")
    for option, expected in ("1=a", 0.5 * LAMP_A), ("1=a*0.25", 0.25 * LAMP_A), ("1=1*2", 2 + 0 * LAMP_A):
        Picture("option", renderer, scene, "--light", option).agrees(
            per_band(expected * RED), f"{renderer}: --light {option} has the table's spectrum and the right intensity")


def full_scale(renderer):
    """A sample of full scale is not clipped, in 8 bits or in 16; one beyond half a count more is."""
    for bits, counts in ("8", 255), ("16", 65535):
        for part in 100.4, 100.6:
            picture = Picture("round", renderer, square(f"diffuse {part / counts!r}", "light 1 1 direction 0 0 1\n"), "--depth", bits,
                              "--wavelengths", "500", "--full-scale", "1")
            check((pages_of(picture.stack) == round(part)).all(), f"{renderer}: {part} counts of {bits} bits are rounded", pages_of(picture.stack).max())
        for over, clipped in ((0, 0), (0.4, 0), (0.6, 96)):
            picture = Picture("full", renderer, square("diffuse 1", "light 1 1 direction 0 0 1\n"), "--depth", bits, "--wavelengths", "500",
                              "--full-scale", repr(1 / (1 + over / counts)))
            check(picture.report["clipped_samples"] == clipped, f"{renderer}: {over} counts above full scale, {bits} bits: {clipped} samples are clipped",
                  picture.report["clipped_samples"])


# ---- surfaces ----

def sums(renderer):
    """The report counts the samples that are equal, and those that are 1 count apart at most."""
    if renderer == "gl":
        own, other = (Picture("sums", kind, open("test/cases/faults/patches.scene").read().replace("../../../data/builtin/materials/colorchecker.list", "colorchecker"), "--buffer", "8")
                      for kind in ("gl", "raster"))
        apart = np.abs(own.radiance / own.count - other.radiance / other.count).round()
        counted = own.report["check"]
        check((counted["exact"], counted["within_1"]) == ((apart == 0).sum(), (apart <= 1).sum()) and apart.max() > 5,
              "gl: samples that are equal, or a count apart, are counted", counted, (apart == 0).sum(), (apart <= 1).sum())


def emission(renderer):
    glow = 0.4 * np.exp(-4 * np.log(2) * ((WAVELENGTHS - 600) / 80) ** 2)
    words = "emission gaussian:600,80*0.4"
    Picture("glow", renderer, square(words)).agrees(per_band(glow), f"{renderer}: emission needs no light")
    Picture("glow", renderer, square(words + " diffuse RED gloss 9", "ambient a 0.3\n", FACING)).agrees(
        per_band(glow + 0.3 * LAMP_A * RED + D65 * RED + D65), f"{renderer}: emission adds to the reflected light and the highlight, which is white")


def fill_rule(renderer):
    """Edges run through pixel centres: those on the left and on the lower edge belong to the square, others do not."""
    scene = FLAT + "ambient 1 1\nmaterial m { diffuse 0.5 }\nobject plane 4 3 material m translate 0.5 0 0\n"
    expected = np.zeros((8, 12))
    expected[3:6, 4:8] = 0.5
    Picture("fill", renderer, scene, "--wavelengths", "550").agrees(
        expected, f"{renderer}: a square has the pixels on its left and lower edge, not those on its right and upper edge")


def backs(renderer):
    """A light that reaches no front; brute.py has sheets with one side only."""
    scene = FLAT + FACING + "material m { diffuse RED }\nobject plane 12 8 material m two-sided rotate 180 0 1 0"
    Picture("back", renderer, scene).agrees(per_band(D65 * RED), f"{renderer}: the back of a two-sided square is lit by its reversed normal")


# ---- metameric halves, several materials ----

GREY, STEEP = 0.4, 0.8 * np.exp(-4 * np.log(2) * ((WAVELENGTHS - 560) / 120) ** 2)
PAIR = ("ambient 1 1\nmaterial grey { diffuse 0.4 metamer steep }\n"
        "material steep { diffuse gaussian:560,120*0.8 }\n")


def is_steep(picture, name, inside):
    """Mask of the pixels that show the partner, in ambient light; checks that every pixel `inside` shows one of
    both."""
    error = [np.abs(picture.radiance - per_band(spectrum)).max(axis=0)
             for spectrum in (GREY + 0 * STEEP, STEEP)]
    check(np.minimum(*error)[inside].max() <= picture.tolerance, name)
    return error[1] <= picture.tolerance


def halves(renderer):
    x, y = pixel_grid(60, 40, 6)
    head = "size 60 40\ncamera ortho 6\n" + PAIR
    for name, shape, inside in (
            ("sphere", "sphere 1.8 24 24", x ** 2 + y ** 2 < 1.7 ** 2),
            ("box", "box 3 2.6 2", (abs(x) < 1.5) & (abs(y) < 1.3)),
            ("plane", "plane 3 3", (abs(x) < 1.5) & (abs(y) < 1.5)),
            ("disk", "disk 1.8 32", x ** 2 + y ** 2 < 1.75 ** 2),
            ("torus", "torus 0.5 1.2 20 30", abs(np.hypot(x, y) - 1.2) < 0.45)):
        picture = Picture("half", renderer, f"{head}object {shape} material grey")
        steep = is_steep(picture, f"{renderer}: {name}: every pixel shows one of the two halves", inside)
        check((steep[inside] == (x > 0)[inside]).all(), f"{renderer}: {name}: the partner is on the right")
    turned = "object sphere 1.8 24 24 material grey rotate 40 0 0 1 rotate 50 1 2 0"
    picture = Picture("turned", renderer, head + turned)
    disk = x ** 2 + y ** 2 < 1.7 ** 2
    steep = is_steep(picture, f"{renderer}: a turned sphere has no crack", disk)
    front = np.array([x, y, np.sqrt(np.maximum(1.8 ** 2 - x ** 2 - y ** 2, 0))])
    matrix = rotation(50, (1, 2, 0)) @ rotation(40, (0, 0, 1))
    across = np.tensordot(matrix[:, 0], front, 1)  # x in the object's own coordinates
    clear = disk & (abs(across) > 0.1)
    check((steep == (across > 0))[clear].all() and 100 < (steep & clear).sum() < clear.sum() - 100,
          f"{renderer}: the sphere is cut where its own x is 0")


def equal_halves(renderer):
    head = "size 60 40\ncamera ortho 6\nambient d65 1\nmaterial same { diffuse RED }\nmaterial m { diffuse RED"
    for shape in ("plane 7 5", "sphere 1.8 24 24", "box 3 2 2", "teapot 1.5 6"):
        one, two = (Picture(name, renderer, f"{head} {partner} }}\nobject {shape} material m")
                    for name, partner in (("one", ""), ("two", "metamer same")))
        check((one.radiance == two.radiance).all(),
              f"{renderer}: a {shape.split()[0]} of two equal halves looks as if it were not cut",
              f"{(one.radiance != two.radiance).any(axis=0).sum()} pixels differ")


def textured_halves(renderer):
    """Edges cross x = 0, but never in their middle: texture and outline continue across the cut."""
    write("askew.obj", "v -2.5 -1.5 0\nv 1.2 -1.9 0.3\nv 2.7 1.4 0\nv -0.6 1.8 -0.2\nvn 0 0 1\nvt 0.1 0.3\n"
          "vt 0.9 0.1\nvt 0.8 0.7\nvt 0.2 0.9\nf 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1\n")
    texture = "diffuse RED texture grey8.tif linear"
    head = (f"size 60 40\ncamera ortho 6\nambient d65 1\nmaterial same {{ {texture} }}\n"
            f"material m {{ {texture}")
    one, two = (Picture(name, renderer, f"{head} {partner} }}\nobject mesh askew.obj material m")
                for name, partner in (("one", ""), ("two", "metamer same")))
    error = np.abs(one.radiance - two.radiance).max()
    check(error <= one.tolerance + two.tolerance <= 8 * one.count and one.radiance.max() > 0.3,
          f"{renderer}: a texture and an outline continue across the cut as without it",
          f"error {error / one.count} counts")


def several_materials(renderer):
    names = ("pair", "paint", "other", "more")
    corners = [f"v {x} {y} 0\n" for y in (-4, -2, 0, 2, 4) for x in (-6, 6)]
    faces = [f"usemtl {name}\nf {i} {i + 1} {i + 3} {i + 2}\n" for i, name in zip((1, 3, 5, 7), names)]
    write("strips.obj", "".join(corners + faces))
    write("colours.mtl", "newmtl unused\nKd 2 2 2\nnewmtl paint\nKd 0.1 0.6 0.9\n")
    write("strips.map", "pair material grey\n* material steep\npaint mtl colours.mtl\n")
    picture = Picture("strips", renderer, FLAT + PAIR + "object mesh strips.obj materials strips.map")
    # blue up to 480 nm, green from 500 to 570, red from 600 on
    painted = np.interp(WAVELENGTHS, (480, 500, 570, 600), (0.9, 0.6, 0.6, 0.1))
    expected = np.empty((len(WAVELENGTHS), 8, 12))
    expected[:, :4] = per_band(STEEP)  # the strips named other and more
    expected[:, 4:6] = per_band(painted)
    expected[:, 6:, :6] = GREY
    expected[:, 6:, 6:] = per_band(STEEP)
    picture.agrees(expected, f"{renderer}: parts of a mesh: a pair, bands of RGB, and * for all others")


# ---- perspective ----

# ---- object maps ----

def many_objects(renderer):
    """Each pixel shows an object of its own: 255 numbers fit in a byte, 256 do not."""
    squares = [f"object plane 1 1 material m translate {x - 7.5} {7.5 - y} 0\n" for y in range(16) for x in range(16)]
    for n, size in ((255, 1), (256, 2)):
        scene = "size 16 16\ncamera ortho 16\nambient 1 1\nmaterial m { diffuse 0.5 }\n" + "".join(squares[:n])
        objects = objects_of(Picture("many", renderer, scene, "--wavelengths", "550").stack).ravel()
        check(objects.itemsize == size and (objects[:n] == np.arange(n) + 1).all() and not objects[n:].any(),
              f"{renderer}: the map of {n} objects has their numbers in {size} bytes a pixel", objects)
    for sides in (-0.25, 0.25), (0.25, -0.25):
        scene = "size 1 1\ncamera ortho 1\nambient 1 1\nmaterial m { diffuse 0.5 }\n" + "".join(
            f"object plane 0.5 1 material m translate {x} 0 0\n" for x in sides)
        objects = objects_of(Picture("two", renderer, scene, "--wavelengths", "550", "--samples", "2").stack)
        check(objects == sides.index(-0.25) + 1, f"{renderer}: of two objects with as many positions the first position's is shown", objects)


# ---- the thesis's own formats ----

def thesis_list(renderer):
    tifffile.imwrite(path_of("ramp.tif"), np.arange(16, dtype=np.uint8).reshape(4, 4) * 15)
    whole = ["300 0.5", "760 0.7", "g 20", "s 300 0.3", "s 760 0.9", "t ramp.tif", "f 300 1 0",
             "f 450 0 0", "f 500 0 0.8", "f 760 0 0"]
    partner = ["mr 300 0.2", "mr 760 0.6", "mg 5", "ms 300 0.5", "ms 760 0.1", "mf 300 0.5 0",
               "mf 500 0 0.4", "mf 760 0 0"]
    write("whole.txt", "\n".join(whole + partner) + "\n")
    write("plain.txt", "300 0.5\n760 0.1\n")
    picture = Picture("thesis", renderer, "whole.txt\nplain.txt\n", "--size", "90x60")
    used = picture.report["effects"]
    check(picture.report["check"]["unexplained_pixels"] == 0 and picture.radiance.max() > 0
          and all(used[name] for name in ("diffuse", "specular", "fluorescence", "texture", "metamer")),
          f"{renderer}: a list of files with every kind of line renders and agrees")


EFFECTS = (fluorescence, bispectral, diagonals, textures, two_repeats, twins, flat_texture, texel_borders, dark_texture, tiles_of_steps, spectral_textures, spots,
           grazing, lights_alike, light_of_option, full_scale, sums, emission, fill_rule, backs, halves,
           equal_halves, textured_halves, several_materials, many_objects, thesis_list)
for each in ("raster", "gl"):
    for effect in cases(EFFECTS, lambda effect: effect.__name__):
        effect(each)
done()
