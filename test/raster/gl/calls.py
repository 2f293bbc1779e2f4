#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile libosmesa6-dev; makes: calls
"""Counts the calls of the program to OpenGL and to libtiff from outside, by a library that LD_PRELOAD loads
(test/raster/gl/calls.c): work that a scene does not call for makes no call, and nothing is set or uploaded twice. The
program's own counters (work.py) take no part. Prints TAP."""
import collections
import os

import numpy as np
import tifffile

from rendered import TMP, check, done, remove, run, unshadowed, write
from tap import bail_out

LIBRARY = os.path.abspath(os.environ.get("CALLS_LIBRARY", "build/test/calls.so"))
HEAD = "wavelengths 400 700 20\nsize 24 16\ncamera perspective 40 near 2 far 30 eye 0 0 10 look 0 0 0\n"
LIGHT = "light d65 1 position 0 1 8"
PLANE = "object plane 3 3 material m"
BANDS, FRAMES = 16, 6
GL_LIGHT0, GL_POSITION, GL_SPECULAR, GL_COLOUR_BIT = 0x4000, 0x1203, 0x1202, 0x4000


def scene_of(words="diffuse 0.5", light=LIGHT, more="", objects=PLANE):
    return f"{light}\nmaterial m {{ {words} }}\n{more}\n{objects}\n"


def calls_of(scene, *options):
    """{(name, detail): (count, again)} of a render."""
    path = scene if "\n" not in scene else write("calls.scene", HEAD + scene)
    report = os.path.join(TMP, "calls.txt")
    remove(report)
    result = run("render", path, "--quiet", "-o", os.path.join(TMP, "calls.tif"), *options, LD_PRELOAD=LIBRARY, CALLS=report)
    if result.returncode != 0:
        bail_out(result.stderr)
    rows = [line.split() for line in open(report)] if os.path.exists(report) else []
    return {(name, int(detail)): (int(n), int(again)) for name, detail, n, again in rows}


def sums(calls):
    out = collections.Counter()
    for (name, _), (n, _) in calls.items():
        out[name] += n
    return out


def of_gl(calls):
    return {key: counts for key, counts in calls.items() if not key[0].startswith("TIFF")}


def repeated(calls):
    return {key: counts for key, counts in calls.items() if counts[1] > 0}


def difference(one, other):
    return {key: (one.get(key), other.get(key)) for key in set(one) | set(other) if one.get(key) != other.get(key)}


def prepare():
    tifffile.imwrite(os.path.join(TMP, "two.tif"), np.array([[100, 200], [200, 100]], np.uint8))
    write("lamp.csv", "330 1\n350 1\n351 0\n")


def plain():
    calls = calls_of(scene_of())
    n = sums(calls)
    expected = {"OSMesaCreateContextExt": 1, "glDrawElements": FRAMES, "glDrawArrays": 1, "glClear": FRAMES + 1,
                "glFinish": FRAMES + 1, "glReadPixels": 1, "glGenBuffers": 2, "glBufferData": 2,
                "glGenTextures": 0, "glBindTexture": 0, "glTexParameteri": 0, "glTexImage2D": 0, "glTexCoordPointer": 0,
                "glEnableClientState": 4, "glLightModeli": 1, "glFrontFace": 0, "glMaterialf": 0,
                "TIFFWriteRawStrip": BANDS, "TIFFReadEncodedStrip": 0}
    found = {name: n[name] for name in expected}
    check(found == expected, "a matt square under a light: each call is made as often as the picture needs it",
          difference(expected, found))
    check(all(n[name] == 0 for name, _ in repeated(calls)), "no state is set to what it was, and no bytes go twice",
          repeated(calls))
    lights = [key for key in calls if key[0] == "glEnable" and GL_LIGHT0 <= key[1] < GL_LIGHT0 + 8]
    check(lights == [("glEnable", GL_LIGHT0)] and calls["glEnable", GL_LIGHT0][0] == 1, "one light is switched on, once",
          lights)
    check(calls["glLightfv", GL_POSITION][0] == 1, "it is placed once, and not for each frame", calls)
    check(("glLightfv", GL_SPECULAR) not in calls, "a matt material sets no colour of highlights", calls)
    check(sum(n for (name, bits), (n, _) in calls.items() if name == "glClear" and bits & GL_COLOUR_BIT) == 1,
          "colours are cleared once, and not for each frame", calls)
    return calls


FAR_BALL = "object sphere 1 9 7 material "
UNNEEDED = (
    ("a light of intensity 0", {"light": LIGHT + "\nlight d65 0 direction 0 0 1"}),
    ("a light that is 0 at all of the picture's wavelengths",
     {"light": LIGHT + "\nlight gaussian:300,1 1 direction 0 0 1"}),
    ("a light behind the square", {"light": LIGHT + "\nlight a 1 direction 0.1 0 -1"}),
    ("a spot that turns away", {"light": LIGHT + "\nlight a 1 position 0 0 9 spot 0 0 1 30 2"}),
    ("a light that no material reflects", {"light": LIGHT + "\nlight gaussian:650,5 1 direction 0 0 1",
                                           "words": "diffuse gaussian:450,5"}),
    ("a material without an object", {"more": "material n { diffuse 0.3 gloss 4 texture two.tif }"}),
    ("an object left of the view", {"objects": f"{PLANE}\n{FAR_BALL} m translate -60 0 0"}),
    ("an object right of the view", {"objects": f"{PLANE}\n{FAR_BALL} m translate 60 0 0"}),
    ("an object below the view", {"objects": f"{PLANE}\n{FAR_BALL} m translate 0 -60 0"}),
    ("an object above the view", {"objects": f"{PLANE}\n{FAR_BALL} m translate 0 60 0"}),
    ("an object before the near plane", {"objects": f"{PLANE}\n{FAR_BALL} m scale 0.3 0.3 0.3 translate 0 0 9"}),
    ("an object behind the eye", {"objects": f"{PLANE}\n{FAR_BALL} m translate 0 0 40"}),
    ("an object beyond the far plane", {"objects": f"{PLANE}\n{FAR_BALL} m translate 0 0 -60"}),
    ("a light on an object out of view", {"light": LIGHT + "\nlight lamp.csv 1 direction 0 0 1",
                                          "more": "material n { diffuse 0 fluorescence uv a }",
                                          "objects": f"{PLANE}\n{FAR_BALL} n translate 60 0 0"}),
    ("a textured object out of view", {"more": "material n { diffuse 0.3 gloss 4 texture two.tif }",
                                       "objects": f"{PLANE}\n{FAR_BALL} n translate 60 0 0"}),
    ("attenuation 1 0 0", {"light": LIGHT + " attenuation 1 0 0"}),
    ("an effect that nothing shows", {"more": "viewer local"}))


def unneeded(before):
    for name, scene in UNNEEDED:
        words = scene.get("words", "")
        with_one = of_gl(calls_of(scene_of(**scene)))
        without = of_gl(before)
        if "gaussian:450" in words:
            without = of_gl(calls_of(scene_of(words)))
        check(with_one == without, f"{name}: the same calls to OpenGL as without it", difference(without, with_one))


def textures():
    n = sums(calls_of(scene_of("diffuse 0.5 texture two.tif")))
    check((n["glGenTextures"], n["glTexImage2D"], n["glBindTexture"], n["glBufferData"]) == (1, 1, 1, 2),
          "a texture is uploaded once, and bound once, for the upload and for all frames", n)
    dark = sums(calls_of(scene_of("diffuse 0.5 texture none.tif", light="")))
    check(dark["glTexImage2D"] + dark["TIFFReadEncodedStrip"] + dark["glDrawElements"] == 0,
          "in the dark no texture is read, and no frame is drawn", dark)
    two = "material n { diffuse 0.4 texture two.tif }\nobject plane 1 1 material n translate 0 0 1"
    n = sums(calls_of(scene_of("diffuse 0.5 texture two.tif", objects=PLANE + "\n" + two)))
    check(n["glTexImage2D"] == 1, "two materials share a texture", n)


def frames():
    for name, words, light, drawn in (
            ("light in three bands", "diffuse 0.5", "light gaussian:440,1 1 direction 0 0 1", 1),
            ("the same light in all bands", "diffuse 0.5", "light 1 1 direction 0 0 1", 2),
            ("light of an object out of view", "diffuse 0.5", "light gaussian:440,1 1 direction 0 0 1", 1)):
        more = ""
        if "out of view" in name:
            more = f"material n {{ emission d65 }}\n{FAR_BALL} n translate 60 0 0"
        n = sums(calls_of(scene_of(words, light, objects=PLANE + "\n" + more)))
        check(n["glDrawElements"] == drawn and n["glClear"] == n["glFinish"] == drawn + 1,
              f"{name}: OpenGL draws {drawn} frames", n)
        check(n["TIFFWriteRawStrip"] == BANDS, f"{name}: all bands are pages", n)
    # the lights take turns in OpenGL's eight, and are placed in each turn
    twelve = "".join(f"light d65 0.1 direction 0.{i} 0 1\n" for i in range(12))
    n = sums(calls_of(scene_of(light=twelve)))
    check(n["glDrawElements"] == 2 * FRAMES, "twelve lights take two passes a frame", n)
    behind = "".join(f"light d65 0.1 direction 0.{i} 0 -1\n" for i in range(4))
    n = sums(calls_of(scene_of(light="".join(twelve.splitlines(True)[:8]) + behind)))
    check(n["glDrawElements"] == FRAMES, "a second group of lights that reaches nothing takes none", n)


def options():
    n = sums(calls_of(scene_of(), "--no-check"))
    check(n["glDrawArrays"] + n["glReadPixels"] + n["glStencilOp"] == 0 and n["glDrawElements"] == FRAMES,
          "without a check nothing is numbered, counted or read back", n)
    for words in ("--renderer", "raster", "--no-check"), ("--shading", "phong", "--renderer", "raster"):
        calls = calls_of(scene_of(), *words)
        check(of_gl(calls) == {}, f"{' '.join(words)}: no call to OpenGL", calls)


RICH = (LIGHT + "\nlight a 0.4 direction 1 1 2\nambient d65 0.1\n"
        "material m { diffuse 0.5 gloss 9 texture two.tif }\nmaterial n { diffuse 0.3 }\n"
        "material o { diffuse 0.2 spectral-texture colours.tif }\n"
        "object plane 3 3 material m two-sided\nobject sphere 1 9 7 material n translate 1 0 1\n"
        "object sphere 1 9 7 material n scale -1 1 1 rotate 40 1 0 0 translate -1 0 1\nobject box 1 2 1 material o translate 0 1 1\n"
        "object plane 3 3 material m translate 0 1 0.5\n")


def nothing_twice():
    with tifffile.TiffWriter(os.path.join(TMP, "colours.tif")) as stack:
        for nm in (390, 710):
            page = np.random.default_rng(nm).integers(0, 65535, (4, 4)).astype(np.uint16)
            stack.write(page, contiguous=False, extratags=[(285, 2, 0, f"{nm} nm", True)])
    for name, scene, *words in (
            ("a scene of many effects", RICH), ("the same, shaded flat", RICH, "--shading", "flat"),
            ("the same into 16 bits", RICH, "--buffer", "16"),
            ("the same of softpipe", RICH, "--renderer", "softpipe"), ("the same, not checked", RICH, "--no-check")):
        calls = calls_of(scene, *words)
        check(sums(calls)["glTexImage2D"] == 1 + FRAMES and repeated(calls) == {},
              f"{name}: no state is set to what it was, and no bytes are uploaded twice", repeated(calls))
    one, two = (calls_of(unshadowed("room"), "--wavelengths", "400:700:60", "--size", size) for size in ("300x200", "1200x800"))
    check((sums(one)["glReadPixels"], sums(two)["glReadPixels"]) == (1, 2), "a picture of one tile, and one of two")
    for name in ("glBufferData", "glGenBuffers", "glGenTextures", "glLightf"):
        check(sums(one)[name] == sums(two)[name] > 0, f"two tiles: as many calls of {name} as for one",
              sums(one)[name], sums(two)[name])
    check(not any("Light" in key[0] for key in repeated(two)), "lights are not placed anew for a tile", repeated(two))


prepare()
before_all = plain()
unneeded(before_all)
textures()
frames()
options()
nothing_twice()
done()
