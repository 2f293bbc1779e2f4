#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile
"""Checks the notes of plan, render and view. Each note has a scene that gets it, and a scene next to it that does not.
The picture shows that a note is true. Prints TAP."""
import json
import os
import re

import numpy as np
import tifffile

from rendered import check, done, parts, pages_of, path_of, write
from rendered import run as run_program

HEAD = "wavelengths 400 700 20\nsize 64 48\ncamera ortho 12\n"
LIGHT = "light d65 1 direction 0 0 1\n"
GREY = "material m { diffuse 0.5 }\n"
BALL = "object sphere 2 20 20 material m\n"
WALL = "object plane 8 8 material m\n"
expected_codes = set()
SHADED = {"colorchecker", "metals", "pasture", "relief", "room", "textures"}  # built-in scenes
ON_TOP = "light d65 1 position 0 0 4 spot 0 0 -1 "


def run(command, scene, *options):
    path = scene if not scene.count("\n") else write("notes.scene", scene)
    return run_program(command, path, *options)


def printed(result):
    return [line[18:] for line in result.stdout.splitlines() if line.startswith("note ")]


def notes_of(scene, *options):
    """The notes of a render but that on shading, as (code, text); its pages."""
    stack = path_of("notes.tif")
    result = run("render", scene, "--renderer", "raster", "--json", "-", "--quiet", "-o", stack, *options)
    if result.returncode != 0:
        return [("failed", result.stderr)], None
    report = json.loads(result.stdout)
    return [(note["code"], note["text"]) for note in report["notes"] if note["code"] != "shading"], pages_of(stack)


def gets(name, scene, code, pattern, *options):
    """The scene gets this one note, in whose text the pattern is found. Returns the pages."""
    expected_codes.add(code)
    notes, pages = notes_of(scene, *options)
    check([note[0] for note in notes] == [code] and re.search(pattern, notes[0][1]), f"{name}: a note '{code}'", notes)
    return pages


def gets_none(name, scene, *options):
    notes, pages = notes_of(scene, *options)
    check(notes == [], f"{name}: no note", notes)
    return pages


def is_black(name, pages):
    check(pages is not None and pages.max() == 0, f"{name}: the picture is black")


def shows(name, scene):
    """The scene gets no note, and its picture is not black."""
    pages = gets_none(name, scene)
    check(pages is not None and pages.max() > 0, f"{name}: the picture is not black")


def no_light():
    for name, light in (("no light", ""), ("a light of intensity 0", "light d65 0 direction 0 0 1\n"),
                        ("a light beyond the picture", "light gaussian:300,1 1 direction 0 0 1\n"),
                        ("ambient light of intensity 0", "ambient d65 0\n")):
        is_black(name, gets(name, HEAD + light + GREY + BALL, "black", "^1 object is black, first m "))
    for name, scene in (("ambient light", "ambient d65 0.1\n" + GREY + BALL),
                        ("emission", "material m { diffuse 0.5 emission 0.1 }\n" + BALL),
                        ("fluorescence under a light beyond the picture", "light gaussian:300,1 1 direction 0 0 1\n"
                         "material m { diffuse 0.5 fluorescence gaussian:300,20 gaussian:500,50*0.4 }\n" + BALL)):
        shows(name, HEAD + scene)


def emission():
    light = HEAD + LIGHT
    write("down.csv", "nm 400 500\n500 0.3 0\n600 0.1 0.2\n")
    write("up.csv", "nm 400 500 600 700\n400 0.2 0.3 0.2 0\n550 0 0 0.1 0\n700 0 0 0 0.4\n")
    for name, words in (("emission at longer wavelengths", "diffuse 0.2 fluorescence gaussian:400,40 gaussian:500,60*0.6"),
                        ("curves that overlap", "diffuse 0.2 fluorescence gaussian:500,40 gaussian:525,40*0.9"),
                        ("a matrix of longer wavelengths", "diffuse 0.2 donaldson down.csv")):
        shows(name, light + f"material m {{ {words} }}\n" + BALL)
    for name, words, text in (
            ("excitation and emission exchanged", "diffuse 0.2 fluorescence gaussian:600,40 gaussian:450,40*0.9",
             "^100 % of the light that m emits has shorter wavelengths"),
            # the diagonal, 0.2 and 0.4, is no emission
            ("a matrix of shorter wavelengths", "donaldson up.csv", "^100 % of the light that m emits has shorter wavelengths"),
            ("more light than comes in", "diffuse 0.2 fluorescence gaussian:400,20 gaussian:500,50", "^m emits 2.5 times the light")):
        gets(name, light + f"material m {{ {words} }}\n" + BALL, "emission", text)


def out_of_view():
    far = BALL[:-1] + " translate 10 3 0\n"
    for name, objects, where in (("no object", "", ""), ("an object beside the view", far, "; the first lies right of the view (near -10, far 10)"),
                                 ("an object beyond far", BALL[:-1] + " translate 0 0 -500\n",
                                  "; the first lies beyond the far plane (near -10, far 10)")):
        scene = HEAD + LIGHT + "ambient d65 1\n" + GREY + objects
        is_black(name, gets(name, scene, "nothing-in-view", f"^the picture is black: no object is in view{re.escape(where)}$"))
        check(printed(run("plan", scene)) == [f"the picture is black: no object is in view{where}"], f"{name}: plan says so, too")
    for name, objects in (("an object seen edge-on", WALL[:-1] + " rotate 90 0 1 0\n"), ("a small object", BALL[:-1] + " scale 0.001\n")):
        scene = HEAD + "ambient d65 1\n" + GREY + objects
        is_black(name, gets_none(f"{name}, by the reference alone", scene, "--no-check"))
        gets(name, scene, "nothing-in-view", "^the picture is black: no object is in view$")
    shows("one of two objects beside the view", HEAD + LIGHT + GREY + BALL + far)
    check(re.search(r"^left out +instances: count 1, of 2, reason right of the view$", run("plan", HEAD + LIGHT + GREY + BALL + far).stdout, re.MULTILINE),
          "plan says where the other one lies")


def turns():
    for turn in "0 1 0 90", "1 0 0 45", "0 0 -1 -30":
        gets(f"rotate {turn}", HEAD + LIGHT + GREY + BALL[:-1] + f" rotate {turn}\n", "rotate",
             r"^.*notes\.scene:\d+:\d+: a turn by 1 degree or less; expected ANGLE X Y Z$")
    for turn in "90 0 1 0", "0 0 0 1", "1 1 1 1", "45 1 0 90", "0 3 4 5":
        shows(f"rotate {turn}", HEAD + LIGHT + GREY + BALL[:-1] + f" rotate {turn}\n")


def black():
    tifffile.imwrite(path_of("grey0.tif"), np.zeros((2, 2), np.uint8))
    wall = "object plane 1 1 material n translate -4 0 0\n"
    for name, scene, n in (
            ("a black texture", LIGHT + "material n { diffuse 0.5 texture grey0.tif }\n" + wall, 1),
            ("reflectance beyond the light", LIGHT + "material n { diffuse gaussian:300,1 }\n" + wall, 1),
            ("a back that is not lit", LIGHT + "material n { diffuse 0.5 }\n" + wall[:-1] + " rotate 180 0 1 0\n", 1),
            ("a spot between vertices", "light d65 1 position -4 0 4 spot 0 0 -1 1 0\nambient gaussian:300,1 1\n"
             "material n { diffuse 0.5 }\nmaterial m { emission 0.1 }\n" + BALL + wall, 1),
            ("two objects", LIGHT + "material n { diffuse gaussian:300,1 }\n" + 2 * wall, 2)):
        scene = HEAD + scene + (GREY + BALL if "material m" not in scene else "")
        objects = "1 object is" if n == 1 else f"{n} objects are"
        pages = gets(name, scene, "black", f"^{objects} black, first n \\(.*notes.scene:[0-9]+\\): "
                     "no light that it shows reaches its vertices$")
        check(pages is not None and (pages[:, 24, 10] == 0).all() and pages.max() > 0,
              f"{name}: its pixels are 0, and those of another object are not")
    shows("a back that is lit", HEAD + LIGHT + GREY + WALL[:-1] + " two-sided rotate 180 0 1 0\n")
    shows("a spot between vertices, phong", HEAD + "shading phong\n" + ON_TOP + "10 0\n" + GREY + WALL)
    gets_none("an object that is meant to be black", HEAD + LIGHT + GREY + BALL + "material b { diffuse 0 }\n"
              "object plane 9 9 material b translate 0 0 -3\n")


def depth():
    """At a distance d depth is 1 - (1 / d - 1 / f) / (1 / n - 1 / f): within 4 steps of 24 bits of 1, an object may be lost."""
    scene = HEAD.replace("ortho 12", "perspective 60 near NEAR far 1e9") + "ambient d65 1\n" + GREY + "object box 2e8 2e8 2e8 material m translate 0 0 -5e8\n"
    limit = 4 / 2**24 / (1 / 4e8 - 1 / 1e9)
    gets("a box 4 steps before the far plane", scene.replace("NEAR", repr(limit * 0.999)), "depth",
         r"^the depth of m \(.*notes.scene:6\) rounds to that of the far plane, so that OpenGL may lose it; move the near plane away", "--unchecked", "1")
    gets_none("a box further before it", scene.replace("NEAR", repr(limit * 1.001)), "--unchecked", "1")
    gets_none("a box that no check will see", scene.replace("NEAR", repr(limit * 0.999)), "--no-check")


def extrapolated():
    write("short.csv", "440 0.2\n450 0.3\n640 0.4\n650 0.5\n")
    write("step.csv", "410 0.2\n430 0.3\n670 0.4\n690 0.5\n")
    write("lamp.csv", "390 0\n450 1\n630 1\n640 1\n")
    write("ends.csv", "420 0\n450 1\n640 1\n650 0\n")
    short = "material m { diffuse short.csv }\n"
    early = HEAD + LIGHT + short + WALL
    line = "diffuse m: 5 of 16 wavelengths outside 440..650 nm, the end value holds there"
    gets("a reflectance that ends early", early, "extrapolated", f"^extrapolated: {re.escape(line)}$")
    check(f"\nextrapolated      {line}\n" in run("plan", early).stdout, "plan has a line for it")
    gets("two of them", early + short.replace("m {", "n {") + WALL.replace("material m", "material n"),
         "extrapolated", f"^extrapolated: 2 spectra, first {re.escape(line)}$")
    gets("a lamp that ends early", HEAD + "light lamp.csv 1 direction 0 0 1\n" + GREY + WALL, "extrapolated",
         r"^extrapolated: light .*lamp\.csv: 3 of 16 wavelengths outside 390\.\.640 nm, 0 there$")
    for name, scene, n in (("a lamp that ends at 0", HEAD + "light ends.csv 1 direction 0 0 1\n" + GREY + WALL, 4),
                           ("a reflectance that ends within its step", HEAD + LIGHT + short.replace("short", "step") + WALL, 2)):
        gets_none(name, scene)
        check(re.search(f"^extrapolated .* {n} of 16 wavelengths", run("plan", scene).stdout, re.MULTILINE), f"{name}: plan has a line for it")


def commands():
    dark, raster = HEAD + GREY + BALL, ("--renderer", "raster", "-o", "/dev/null")
    plan, render = run("plan", dark), run("render", dark, *raster)
    view = run("view", dark, "-o", path_of("notes.html"))
    texts = [text for _, text in notes_of(dark)[0]]
    check(plan.returncode == render.returncode == view.returncode == 0, "a note leaves the exit status at 0")
    check(printed(plan) == printed(render) == printed(view) == texts and len(texts) == 1,
          "plan, render, view and the JSON have the same notes", plan.stdout, render.stdout, view.stdout, texts)
    quiet = [run("render", dark, *raster, "--quiet"),
             run("view", dark, "-o", path_of("notes.html"), "--quiet")]
    check(all(result.stdout == result.stderr == "" for result in quiet), "--quiet prints no note", quiet)
    report = json.loads(run("render", HEAD + LIGHT + GREY + WALL, "--json", "-", "--quiet", *raster).stdout)
    check(report["notes"] == [], "without notes the array is empty")


def shading():
    """A wall under a near light: its shading is taken at four corners. The note names it; --accuracy mends it."""
    near = HEAD + "light d65 1 position 0 0 0.5 attenuation 0 0 1\n" + GREY + WALL
    notes = printed(run("plan", near))
    found = re.search(r"^the shading of m \(.*notes.scene:6\) is off by up to ([0-9.]+) CIEDE2000 at 95 % of its pixels \(see --accuracy\)$",
                      notes[0] if len(notes) == 1 else "")
    check(found and float(found.group(1)) > 10, "a wall under a near light gets a note", notes)
    expected_codes.add("shading")
    mended = run("render", near, "-o", "/dev/null", "--accuracy", "1")
    check(mended.returncode == 0 and not printed(mended) and "triangles became" in mended.stdout, "--accuracy 1 mends the scene",
          mended.stdout, mended.stderr)
    few = run("render", near, "-o", "/dev/null", "--accuracy", "0.01", "--max-triangles", "50")
    found = re.search(r"^note +the error is still ([0-9.]+) CIEDE2000 on .*, since --max-triangles 50 allows no more$",
                      few.stdout, re.MULTILINE)
    check(few.returncode == 0 and found and float(found.group(1)) > 0.01, "too few triangles get a note", few.stdout)
    expected_codes.add("accuracy")
    for name, scene, options in (("an ambient wall", HEAD + "ambient d65 1\n" + GREY + WALL, ()),
                                 ("a wall under a far light", HEAD + LIGHT + GREY + WALL, ()),
                                 ("flat shading", near, ("--shading", "flat"))):
        notes = printed(run("plan", scene, *options))
        check(notes == [], f"{name} gets no note on shading", notes)


def fine():
    """A sphere of so many triangles that each is smaller than a pixel: a quarter of them is off by what the note says."""
    def plan_of(n, *options):
        return run("plan", HEAD + LIGHT + GREY + f"object sphere 5 {n} {n} material m\n", *options)
    notes = printed(plan_of(200))
    found = re.search(r"^the triangles of m \(.*notes.scene:6\) are smaller than a pixel: a quarter of them would be off by some "
                      r"([0-9.]+) CIEDE2000, and take less time$", notes[0] if len(notes) == 1 else "")
    check(found, "a sphere finer than the pixels gets a note", notes)
    expected_codes.add("fine")
    off = float(re.search(r"error 95 +([0-9.e-]+)", plan_of(100).stdout)[1])
    check(found and 0.7 < float(found[1]) / off < 1.4, "and a quarter of the triangles is off by that", found and found[1], off)
    relief = run("plan", HEAD + LIGHT + GREY + "object plane 12 9 300 displace weave 0.02 material m\n")
    for name, plan in (("coarser one", plan_of(50)), ("larger picture", plan_of(200, "--size", "2000x2000")),
                       ("relief, which fewer would not show", relief)):
        check(printed(plan) == [], f"a {name} gets none", printed(plan))


def manual():
    with open("spectral.1", encoding="utf-8") as page:
        documented = set(re.findall(r"[a-z-]+", " ".join(re.findall(r"^\.It (.*)", page.read(), re.MULTILINE))))
    check(expected_codes <= documented, "the manual lists all codes", expected_codes - documented)


def builtin():
    """Every note on a built-in scene must be meant. The reflectances of the thesis's chart begin at 380 nm. Curved
    objects of few triangles get the note on shading."""
    expected = {"colorchecker": ["extrapolated: 24 spectra, first diffuse 01-dark-skin: 16 of 93 wavelengths outside "
                                 "380..780 nm, the end value holds there"]}
    for name in sorted(os.listdir("data/builtin/scenes")):
        scene = name.replace(".scene", "")
        notes = printed(run("plan", scene))
        shading = [note for note in notes if re.match("the shading of .* is off by", note)]
        check([note for note in notes if note not in shading] == expected.get(scene, []) and
              (len(shading) == 1) == (scene in SHADED), f"{scene} has the expected notes", notes)


parts(no_light, emission, out_of_view, turns, black, depth, extrapolated, commands, shading, fine, manual, builtin)
done()
