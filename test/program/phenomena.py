#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile
"""Checks phenomena that need spectra, which the captions of the 1998 thesis state (its figures 22 to 41), on
pictures that the program renders and develops. materials.py has metameric and fluorescent pairs alone, effects.py metals and
textures in closed form. Prints TAP."""

import numpy as np
import tifffile

from rendered import check, developed, done, parts, objects_of, reference


def render(name, *options, scene=None):
    return reference(name + ".tif", scene or name, "--depth", "32f", *options)


def develop(stack, *options):
    """Rows of pixels of three values: RGB of 8 bits, or the kind that the options select."""
    return developed(stack, *options)[0]


def chromaticities(xyz):
    """chromaticity; 0 for black"""
    return xyz[..., :2] / np.maximum(xyz.sum(-1, keepdims=True), 1e-9)


# ---- shapes ----

def check_shapes():
    """figures 22, 24 and 25: the colour of a patch does not depend on its shape"""
    options = ("--size", "300x200", "--wavelengths", "380:730:10")
    flat = chromaticities(develop(render("patches", *options), "--xyz"))
    round_ = chromaticities(develop(render("colorchecker", *options), "--xyz"))
    rows, columns = (np.round(100 - 25 * np.array([3, 1, -1, -3])).astype(int),
                     np.round(150 + 25 * np.array([-5, -3, -1, 1, 3, 5])).astype(int))
    tube = 25 * 1.65 / 3  # half-way round the tube of a torus, which has a hole in its middle
    worst = max(abs(flat[y, x] - round_[y, round(x + tube)]).max() for y in rows for x in columns)
    check(worst < 2e-5, "each patch has the same chromaticity as a square and as a torus", worst)


# ---- adaptation ----

def check_adaptation():
    """figures 34 to 36: under A everything looks yellow; von Kries removes the tint, Fairchild a part of it"""
    stack = render("patches-a", "--light", "1=a", "--size", "300x200", scene="patches")
    kinds = ("none", "von-kries", "fairchild", "bradford", "cat16")
    grey = {kind: develop(stack, "--adaptation", kind)[175, 75] for kind in kinds} # patch 20
    tint = {kind: rgb[0] - rgb[2] for kind, rgb in grey.items()}
    check(tint["none"] > 60, "a grey patch is yellow without adaptation", grey)
    for kind in ("von-kries", "bradford", "cat16"):
        check(np.ptp(grey[kind]) <= 4, f"{kind}: the patch is grey", grey)
    check(10 < tint["fairchild"] < tint["none"] - 10, "Fairchild: the patch keeps some of the tint", grey)
    tints = [np.diff(develop(stack, "--adaptation", f"fairchild:{luminance}")[175, 75][[2, 0]])[0]
             for luminance in (0.1, 10, 1000, 100000)]
    check(all(np.diff(tints) < 0), "Fairchild: dimmer light leaves more of the tint", tints)
    stack = render("patches-d65", "--size", "300x200", scene="patches")
    near = np.abs(develop(stack, "--adaptation", "von-kries") - develop(stack)).max()
    check(near <= 6, "under D65 von Kries changes little", near)


# ---- a room ----

def objects(stack):
    """{name: mask} of the objects that a stack records"""
    with tifffile.TiffFile(stack) as tiff:
        lines = tiff.pages[0].description.split("<Description>")[1].split("<")[0].split("\n")
    names = [line[len("object: "):] for line in lines if line.startswith("object: ")]
    numbers = objects_of(stack)
    return [(name, numbers == i) for i, name in enumerate(names, 1)]


def room(light=None, *options):
    """The room in its own light, or all of it in another."""
    lamps = [word for i in range(1, 9) for word in ("--light", f"{i}={light}")] + ["--ambient", f"{light}*0.24"]
    return render(f"room-{light}", "--size", "600x400", "--wavelengths", "300:760:10", *(lamps if light else ()),
                  *options, scene="room")


def check_room():
    """figures 39 to 41: metameric chairs that match under D65, and do not under A adapted by Fairchild; fluorescent
    things on the table and on the wall under ultraviolet; all of them among other objects"""
    stacks = {light: room(light) for light in (None, "d65", "a", "uv")}
    pictures = {light: develop(stack, "--xyz", *(("--adaptation", "fairchild") if light == "a" else ()))
                for light, stack in stacks.items()}
    masks = objects(stacks["d65"])
    halves = [[mask for name, mask in masks if name == half] for half in ("halves", "illuminant-5-blue-flower")]
    check([len(half) for half in halves] == [2, 2] and all(mask.sum() > 500 for half in halves for mask in half),
          "the room shows both halves of two chairs", [name for name, _ in masks])
    for light, holds, truth in ((None, lambda far: far < 1e-3, "match in the scene's own light"),
                                ("d65", lambda far: far < 1e-3, "match under D65"),
                                ("a", lambda far: far > 0.01, "differ under A")):
        far = [np.ptp([np.median(chromaticities(pictures[light][mask]), 0) for mask in chair], axis=0).max()
               for chair in zip(*halves)]
        check(all(map(holds, far)), f"the halves of both chairs {truth}", far)
    shares = sorted(((pictures["uv"][mask][:, 1].mean() / pictures["d65"][mask][:, 1].mean(), name)
                     for name, mask in masks if mask.sum() > 50), reverse=True)
    print("# the objects that keep most of their luminance under ultraviolet:", shares[:8])
    glow = ["fluorescent-green", "fluorescent-orange", "fluorescent-green", "fluorescent-orange", "yellow"]
    check(sorted(name for _, name in shares[:5]) == sorted(glow) and shares[4][0] > 3 * shares[5][0],
          "the clock's rim and hands, and three things on the table, glow under ultraviolet", shares[:6])


parts(check_shapes, check_adaptation, check_room)
done()
