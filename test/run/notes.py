#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile
"""Checks the notes of plan, render and view. Each note has a scene that gets it, and a scene next to it that does not.
The picture shows that a note is true; a scene changed as the note proposes gets it no more. Prints TAP."""
import json
import os
import re
import subprocess
import sys

import numpy as np
import tifffile

sys.dont_write_bytecode = True
from rendered import SPECTRAL, TMP, check, done, write

HEAD = "wavelengths 400 700 20\nsize 64 48\ncamera ortho 12\n"
LIGHT = "light d65 1 direction 0 0 1\n"
GREY = "material m { diffuse 0.5 }\n"
BALL = "object sphere 2 20 20 material m\n"
WALL = "object plane 8 8 material m\n"
expected_codes = set()
SHADED = {"colorchecker", "metals", "pasture", "room", "textures"}  # built-in scenes
ON_TOP = "light d65 1 position 0 0 4 spot 0 0 -1 "


def run(command, scene, *options):
    path = scene if not scene.count("\n") else write("notes.scene", scene)
    return subprocess.run([SPECTRAL, command, path, *options], check=False, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, universal_newlines=True)


def printed(result):
    return [line[18:] for line in result.stdout.splitlines() if line.startswith("note ")]


def notes_of(scene, *options):
    """The notes of a render but that on shading, as (code, text); its report; its pages."""
    stack = os.path.join(TMP, "notes.tif")
    result = run("render", scene, "--renderer", "raster", "--json", "-", "--quiet", "-o", stack, *options)
    if result.returncode != 0:
        return [("failed", result.stderr)], None, None
    report = json.loads(result.stdout)
    with tifffile.TiffFile(stack) as tiff:
        pages = np.array([page.asarray() for page in tiff.pages])
    return [(note["code"], note["text"]) for note in report["notes"] if note["code"] != "shading"], report, pages


def gets(name, scene, code, pattern, *options):
    """The scene gets this one note, in whose text the pattern is found. Returns the match, report and pages."""
    expected_codes.add(code)
    notes, report, pages = notes_of(scene, *options)
    found = re.search(pattern, notes[0][1]) if [note[0] for note in notes] == [code] else None
    check(found, f"{name}: a note '{code}'", notes)
    return found, report, pages


def gets_none(name, scene, *options):
    notes, report, pages = notes_of(scene, *options)
    check(notes == [], f"{name}: no note", notes)
    return report, pages


def is_black(name, pages):
    check(pages is not None and pages.max() == 0, f"{name}: the picture is black")


def shows(name, pages):
    check(pages is not None and pages.max() > 0, f"{name}: the picture is not black")


def no_light():
    for name, light, pattern in (
            ("no light", "", r"^the scene has no light: .* add a line such as (light .*)$"),
            ("a light of intensity 0", "light d65 0 direction 0 0 1\n", r"notes.scene:4\) has intensity 0$"),
            ("a light beyond the picture", "light gaussian:300,1 1 direction 0 0 1\n", r":4\) is 0 at every wavelength"),
            ("ambient light of intensity 0", "ambient d65 0\n", r"notes.scene:4\) has intensity 0$")):
        found, _, pages = gets(name, HEAD + light + GREY + BALL, "no-light", pattern)
        is_black(name, pages)
        if found and not light:
            _, pages = gets_none("the proposed light", HEAD + found[1] + "\n" + GREY + BALL)
            shows("the proposed light", pages)
    for name, scene in (("ambient light", "ambient d65 0.1\n" + GREY + BALL),
                        ("emission", "material m { diffuse 0.5 emission 0.1 }\n" + BALL),
                        ("fluorescence under a light beyond the picture", "light gaussian:300,1 1 direction 0 0 1\n"
                         "material m { diffuse 0.5 fluorescence gaussian:300,20 gaussian:500,50 }\n" + BALL)):
        _, pages = gets_none(name, HEAD + scene)
        shows(name, pages)


def no_object():
    found, _, _ = gets("no object", HEAD + LIGHT, "no-object", r"add lines such as (material .*) and (object .*)$")
    if found:
        _, pages = gets_none("the proposed object", HEAD + LIGHT + found[1] + "\n" + found[2] + "\n")
        shows("the proposed object", pages)


def camera(head, words):
    return re.sub(r"(camera .*)\n", r"\1 " + words + "\n", head)


def out_of_view():
    perspective = HEAD.replace("ortho 12", "perspective 60")
    for where, place, pattern, head in (
            ("to the right of", "10 3 0", r"(look 10 3 0)$", HEAD), ("to the left of", "-10 3 0", r"(look .*)$", HEAD),
            ("above", "0 8 -1", r"(look .*)$", HEAD), ("below", "0 -7 -1", r"(look .*)$", HEAD),
            ("beyond the far plane", "0 0 -20", r"distances there are 18 to 22; write (far .*)$", HEAD),
            ("before the near plane", "0 0 20", r"distances there are -22 to -18; write (near .*)$", HEAD),
            ("before the near plane", "0 0 -2.5", r"write (near .*)$", camera(perspective, "near 5")),
            ("behind the eye", "1 2 5", r"(look 1 2 5)$", perspective)):
        name = f"an object that lies {where.replace(' of', ' of the view')}"
        scene = LIGHT + "ambient d65 1\n" + GREY + f"{BALL[:-1]} translate {place}\n"
        found, _, pages = gets(name, head + scene, "nothing-in-view",
                                    f"lies {where}.*{pattern}")
        is_black(name, pages)
        if found:
            head = re.sub(r"near 5", "", head)
            _, pages = gets_none(f"{name}, as proposed", camera(head, found[1]) + scene)
            shows(f"{name}, as proposed", pages)
    gets("two objects beside the view", HEAD + LIGHT + GREY + 2 * (BALL[:-1] + " translate 10 3 0\n"),
         "nothing-in-view", r"2 of 2 objects lie to the right of the view, first m \(")
    gets("one of two objects beside the view", HEAD + LIGHT + GREY + BALL + BALL[:-1] + " translate 8.1 0 0\n",
         "out-of-view", r"^1 of 2 objects are not in view; the first, m \(.*:7\), lies to the right of the view$")
    gets_none("an object at the edge of the view", HEAD + LIGHT + GREY + BALL + BALL[:-1] + " translate 7.9 0 0\n")
    gets_none("an object around the view", HEAD + LIGHT + GREY + "object plane 900 900 material m\n")
    gets_none("an object around the eye", perspective + LIGHT + GREY +
              "object sphere 30 20 20 material m two-sided\n")
    gets("an object seen edge-on", HEAD + LIGHT + GREY + WALL[:-1] + " rotate 90 0 1 0\n", "nothing-in-view",
         "lies exactly edge-on; move the eye$")
    gets("an object of less than a pixel", HEAD + LIGHT + GREY + BALL[:-1] + " scale 0.01\n", "small",
         r"cover 0\.035 pixels")


def ball():
    """A closed mesh: an octahedron whose faces are cut into 64 triangles each, moved to a sphere."""
    points, faces = {}, []

    def corner(at):
        return points.setdefault(tuple(np.round(np.array(at) / np.linalg.norm(at), 9)), len(points) + 1)
    n = 8
    for signs in ((x, y, z) for x in (1, -1) for y in (1, -1) for z in (1, -1)):
        def at(i, j, signs=signs):
            return corner(np.array([i, j, n - i - j]) * signs)
        for i in range(n):
            for j in range(n - i):
                some = [(at(i, j), at(i + 1, j), at(i, j + 1))]
                if i + j < n - 1:
                    some.append((at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)))
                faces += [face if np.prod(signs) > 0 else face[::-1] for face in some]
    return "".join("v {} {} {}\n".format(*point) for point in points) + "".join(
        "f {} {} {}\n".format(*face) for face in faces)


def black():
    for shade in (0, 200):
        tifffile.imwrite(os.path.join(TMP, f"grey{shade}.tif"), np.full((2, 2), shade, np.uint8))
    for name, scene, pattern in (
            ("a black texture", LIGHT + "material m { diffuse 0.5 texture grey0.tif }\n" + WALL, "its texture is black$"),
            ("reflectance beyond the light", LIGHT + "material m { diffuse gaussian:300,1 }\n" + WALL,
             "its light or its reflectance is 0$"),
            ("a light behind", "light d65 1 direction 0 0 -1\n" + GREY + WALL, "its normals face no light"),
            ("a spot between vertices", ON_TOP + "10 0\n" + GREY + WALL, "outside the cones of the spots"),
            ("a back that is not lit", LIGHT + GREY + WALL[:-1] + " rotate 180 0 1 0\n", "write two-sided if its back"),
            ("two objects, light behind", "light d65 1 direction 0 0 -1\n" + GREY + 2 * WALL,
             r"2 objects, first m \(.*:6\): its normals")):
        _, _, pages = gets(name, HEAD + scene, "black", pattern)
        is_black(name, pages)
    behind = "light d65 1 direction 0 0.1 -1\n" + GREY
    write("ball.obj", ball())
    for name, shape in (("a sphere", BALL), ("a torus", "object torus 1 2 20 20 material m rotate 9 1 1 1\n"),
                        ("a mesh", "object mesh ball.obj material m rotate 20 1 2 3 scale 1 1 -1\n"),
                        ("a two-sided plane", WALL[:-1] + " two-sided\n")):
        _, _, pages = gets(f"{name} lit from behind", HEAD + behind + shape, "black", "light reaches only a side that")
        check(pages is not None and (pages > 0).any(axis=0).mean() < 0.02, f"{name} lit from behind is dark")
        _, pages = gets_none(f"{name} lit from the side", HEAD + behind.replace("-1", "0.3") + shape)
        shows(f"{name} lit from the side", pages)
    _, pages = gets_none("the inside of a mesh", HEAD.replace("ortho 12", "perspective 60 near 0.1") +
                         "light d65 1 position 0 0 -9\n" + GREY + "object mesh ball.obj material m scale 5\n")
    shows("the inside of a mesh", pages)
    dim = "material dim { diffuse 0.000001 }\nobject plane 1 1 material dim translate -5 0 0\n"
    _, _, pages = gets("an object of less than half a count", HEAD + LIGHT + GREY + BALL + dim, "black",
                       "less than half a count")
    check(pages is not None and (pages[:, 24, 5] == 0).all(), "its pixels are 0")
    gets_none("the same object in floats", HEAD + LIGHT + GREY + BALL + dim, "--depth", "32f")
    gets_none("an object of more than half a count", HEAD + LIGHT + GREY + BALL + dim.replace("0.000001", "0.00001"))
    gets_none("an object that is meant to be black", HEAD + LIGHT + GREY + BALL + "material b { diffuse 0 }\n"
              "object plane 9 9 material b translate 0 0 -3\n")
    for name, scene in (("a grey texture", LIGHT + "material m { diffuse 0.5 texture grey200.tif }\n" + WALL),
                        ("a back that is lit", LIGHT + GREY + WALL[:-1] + " two-sided rotate 180 0 1 0\n"),
                        ("a spot that reaches a vertex", ON_TOP + "60 0\n" + GREY + WALL),
                        ("a spot between vertices, phong", "shading phong\n" + ON_TOP + "10 0\n" + GREY + WALL)):
        _, pages = gets_none(name, HEAD + scene)
        shows(name, pages)


def wavelengths():
    scene = HEAD.split("\n", 1)[1] + "ambient 1 0.1\n" + GREY + WALL
    for unit, line in (("micrometres", "0.4 0.7 0.01"), ("metres", "4e-7 7e-7 1e-8")):
        found, _, _ = gets(f"wavelengths in {unit}", f"wavelengths {line}\n{scene}", "wavelengths",
                           f"look like {unit}; in nanometres they are: (wavelengths 400 700 10)$")
        if found:
            gets_none(f"wavelengths in {unit}, as proposed", f"{found[1]}\n{scene}")
    gets("an option in micrometres", HEAD + "ambient 1 0.1\n" + GREY + WALL, "wavelengths", "look like micrometres",
         "--wavelengths", "0.4:0.7:0.1")
    gets_none("extreme ultraviolet", f"wavelengths 20 30 1\n{scene}")


def extrapolated():
    write("short.csv", "440 0.2\n450 0.3\n640 0.4\n650 0.5\n")
    write("step.csv", "410 0.2\n430 0.3\n670 0.4\n690 0.5\n")
    write("lamp.csv", "390 0\n450 1\n630 1\n640 1\n")
    write("ends.csv", "420 0\n450 1\n640 1\n650 0\n")
    short = "material m { diffuse short.csv }\n"
    gets("a reflectance that ends early", HEAD + LIGHT + short + WALL, "extrapolated",
         "^diffuse m: the table covers 440 to 650 nm; 5 of the 16 wavelengths .* outside, where the end value holds$")
    gets("two of them", HEAD + LIGHT + short + WALL + short.replace("m {", "n {") + WALL.replace("material m", "material n"),
         "extrapolated", "^diffuse m and 1 more: ")
    gets("a lamp that ends early", HEAD + "light lamp.csv 1 direction 0 0 1\n" + GREY + WALL, "extrapolated",
         "^light lamp.csv: .* 390 to 640 nm; 3 of the 16 .* where it is taken as 0$")
    gets_none("a lamp that ends at 0", HEAD + "light ends.csv 1 direction 0 0 1\n" + GREY + WALL)
    gets_none("a reflectance that ends within its step", HEAD + LIGHT + short.replace("short", "step") + WALL)


def percent():
    write("percent.csv", "350 90\n750 90\n")
    lamp = "light percent.csv{} {} direction 0 0 1\n"
    found, _, _ = gets("a light in percent", HEAD + lamp.format("", 1) + GREY + WALL, "percent",
                       r"^light percent\.csv is 90 on average .* write percent\.csv(\*0\.01)$")
    if found:
        gets_none("a light in percent, as proposed", HEAD + lamp.format(found[1], 1) + GREY + WALL)
    gets_none("a light in percent with an intensity", HEAD + lamp.format("", 0.01) + GREY + WALL)
    gets("ambient light in percent", HEAD + "ambient percent.csv 1\n" + GREY + WALL, "percent", "^ambient percent.csv")
    for name in subprocess.check_output([SPECTRAL, "list", "illuminants"], universal_newlines=True).split()[1:]:
        notes, _, _ = notes_of(HEAD + f"light {name} 1 direction 0 0 1\n" + GREY + WALL)
        check(not {"percent", "failed"} & {note[0] for note in notes}, f"the built-in light {name} is not in percent",
              notes)


def full_scale():
    scene = (HEAD + LIGHT + "material dark { diffuse {} }\nmaterial shiny { diffuse 0.02 specular 1 gloss 128 }\n"
             "object plane 14 14 material dark translate 0 0 -3\nobject sphere 2 60 60 material shiny\n")
    found, report, pages = gets("a highlight before a dark wall", scene.replace("{}", "0.02"), "full-scale",
                                r"its full scale, (\S+), .* of vertex \d+ of shiny .* try --full-scale (\S+)$")
    check(pages is not None and (pages.max(axis=0) > 65535 / 8).mean() < 0.01,
          "less than a hundredth of the picture is brighter than an eighth of full scale")
    if found:
        check(abs(float(found[1]) / report["full_scale"] - 1) < 0.01, "the note has the full scale of the report")
        _, pages = gets_none("the proposed full scale", scene.replace("{}", "0.02"), "--full-scale", found[2])
        check(pages is not None and np.median(pages.max(axis=0)) > 65535 / 2, "most of the picture is then bright")
    _, pages = gets_none("a highlight before a grey wall", scene.replace("{}", "0.2"))
    check((pages.max(axis=0) > 65535 / 8).mean() > 0.5, "most of the picture is brighter than an eighth of full scale")


def commands():
    dark, raster = HEAD + GREY + BALL, ("--renderer", "raster", "-o", "/dev/null")
    plan, render = run("plan", dark), run("render", dark, *raster)
    view = run("view", dark, "-o", os.path.join(TMP, "notes.html"))
    texts = [text for _, text in notes_of(dark)[0]]
    check(plan.returncode == render.returncode == view.returncode == 0, "a note leaves the exit status at 0")
    check(printed(plan) == printed(render) == printed(view) == texts and len(texts) == 1,
          "plan, render, view and the JSON have the same notes", plan.stdout, render.stdout, view.stdout, texts)
    quiet = [run("render", dark, *raster, "--quiet"),
             run("view", dark, "-o", os.path.join(TMP, "notes.html"), "--quiet")]
    check(all(result.stdout == result.stderr == "" for result in quiet), "--quiet prints no note", quiet)
    report = json.loads(run("render", HEAD + LIGHT + GREY + WALL, "--json", "-", "--quiet", *raster).stdout)
    check(report["notes"] == [], "without notes the array is empty")


def weak_light():
    weak = "light a 1e-6 direction 0 1 1\n"
    _, _, pages = gets("a light of less than half a count", HEAD + LIGHT + weak + GREY + BALL, "weak-light",
                       r"^1 of 2 lights, first .*notes.scene:5, add less than half a count anywhere")
    shows("a weak light beside another", pages)
    gets_none("a light of some counts", HEAD + LIGHT + "light a 1e-3 direction 0 1 1\n" + GREY + BALL)
    gets_none("a weak light in a picture of floats", HEAD + LIGHT + weak + GREY + BALL, "--depth", "32f")


def shading():
    """A wall under a near light: its shading is taken at four corners. The note names it, and what it says to type
    mends it."""
    near = HEAD + "light d65 1 position 0 0 0.5 attenuation 0 0 1\n" + GREY + WALL
    notes = printed(run("plan", near))
    found = re.search(r"^the shading of m \(.*notes.scene:6\) is off by up to ([0-9.]+) CIEDE2000 .* add (.*)$",
                      notes[0] if len(notes) == 1 else "")
    if not check(found and float(found.group(1)) > 10, "a wall under a near light gets a note", notes):
        return
    expected_codes.add("shading")
    mended = run("render", near, "-o", "/dev/null", *found.group(2).split())
    check(mended.returncode == 0 and not printed(mended) and "triangles became" in mended.stdout,
          "what the note says to type mends the scene", mended.stdout, mended.stderr)
    few = run("render", near, "-o", "/dev/null", "--accuracy", "0.01", "--max-triangles", "50")
    found = re.search(r"^note +the error is still ([0-9.]+) CIEDE2000, since --max-triangles 50 allows no more$",
                      few.stdout, re.MULTILINE)
    check(few.returncode == 0 and found and float(found.group(1)) > 0.01, "too few triangles get a note", few.stdout)
    expected_codes.add("accuracy")
    for name, scene, options in (("an ambient wall", HEAD + "ambient d65 1\n" + GREY + WALL, ()),
                                 ("a wall under a far light", HEAD + LIGHT + GREY + WALL, ()),
                                 ("flat shading", near, ("--shading", "flat"))):
        notes = printed(run("plan", scene, *options))
        check(notes == [], f"{name} gets no note on shading", notes)


def manual():
    with open("spectral.1", encoding="utf-8") as page:
        documented = set(re.findall(r"[a-z-]+", " ".join(re.findall(r"^\.It (.*)", page.read(), re.MULTILINE))))
    check(expected_codes <= documented, "the manual lists all codes", expected_codes - documented)


def builtin():
    """Every note on a built-in scene must be meant. The reflectances of the thesis's chart begin at 380 nm. Curved
    objects of few triangles get the note on shading."""
    expected = {"colorchecker": ["diffuse 01-dark-skin and 23 more: the table covers 380 to 780 nm; 16 of the 93 "
                                 "wavelengths of the picture lie outside, where the end value holds"]}
    for name in sorted(os.listdir("data/builtin/scenes")):
        scene = name.replace(".scene", "")
        notes = printed(run("plan", scene))
        shading = [note for note in notes if re.match("the shading of .* is off by", note)]
        check([note for note in notes if note not in shading] == expected.get(scene, []) and
              (len(shading) == 1) == (scene in SHADED), f"{scene} has the expected notes", notes)


no_light()
no_object()
out_of_view()
black()
wavelengths()
extrapolated()
percent()
full_scale()
commands()
weak_light()
shading()
manual()
builtin()
done()
