#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile glmark2-data
"""Checks --accuracy: the error that a refined picture has against light at every point of the true surfaces (the
reference with phong shading and shapes 8 times as fine, at the same wavelengths), and the error that the program
prints. Checks that wavelengths stay, that nothing is divided in vain, that no crack opens, and that both renderers agree.
FULL: with more errors, and for all built-in scenes, as a table. Prints TAP."""
import json
import os
import re

import numpy as np

from rendered import SCENES as BUILT_IN
from rendered import TMP, bytes_of, check, colour_error_95, done, parts, objects_of, pages_of, render, run, tristimulus, write

BUNNY = "/usr/share/glmark2/models/bunny.obj"
SIZE = ("--size", "300x200")
HEAD = "wavelengths 400 700 20\nsize 300 200\nambient d65 0.05\n"
FLOOR = "material floor { diffuse 0.5 }\n"
VIEW = "camera perspective 40 near 1 far 100 eye 0 6 8 look 0 0 0\n"
SCENES = {
    "near light": HEAD + VIEW + FLOOR + """light d65 1 position 0 0.5 0 attenuation 0 0 1
object plane 20 20 material floor rotate -90 1 0 0
""",
    "edge of a spot": HEAD + VIEW + FLOOR + """light d65 1 position 1 5 0 spot -0.2 -1 0 15 10
object plane 10 10 material floor rotate -90 1 0 0
""",
    "gloss": HEAD + """camera perspective 40 near 1 far 100 eye 0 0 4 look 0 0 0
viewer local
light d65 1 direction 1 1 1
material shiny { diffuse colorchecker/15-red specular 0.6 gloss 128 }
object sphere 1 12 8 material shiny
""",
    "bunny": HEAD + f"""camera perspective 30 near 0.1 far 100 eye 0 0.5 5 look 0 0 0
light d65 0.8 position 2 2 2
light a 0.6 position -2 1 1.5
material fur {{ diffuse colorchecker/02-light-skin specular 0.3 gloss 40 }}
material floor {{ diffuse 0.4 }}
object mesh {BUNNY} unitize material fur
object plane 8 8 32 material floor rotate -90 1 0 0 translate 0 -1 0
""",
    "behind a wall": HEAD + VIEW + FLOOR + """light d65 0.5 position 10 30 20
light d65 1 position 0 0.5 -2.5 attenuation 0 0 1 shadows
object plane 20 20 material floor rotate -90 1 0 0
object plane 20 16 material floor two-sided translate 0 0 -2
""",
}
FACETS = "relief",  # the facets are the true surface: more divisions show more of a relief


def path_of(scene, name="accuracy.scene"):
    return write(name, scene) if "\n" in scene else scene


def seen_in(stack):
    path = os.path.join(TMP, stack)
    return tristimulus(path), objects_of(path)


def standard(scene, tessellation=8):
    render(scene, "--renderer", "raster", "--no-check", "--shading", "phong", "--tessellation", str(tessellation), "--depth", "32f",
           "--memory", "6000", stack="standard.tif", *SIZE)
    return seen_in("standard.tif")


def triangles_of(report):
    refined = report["accuracy"]["refined"]
    return refined["triangles_before"], refined["triangles_after"]


def keeps_its_promise(name, scene, errors):
    """Each error holds, or the program says that it has too few triangles; and the estimate is within a factor of 2 of
    the measured one; below 0.02, the 16 bits of a sample and the texels of the estimate are in the way. Pixels are the
    reference's: a driver takes other levels of detail."""
    truth = None if name in FACETS else standard(scene)
    for error in errors:
        report = render(scene, "--accuracy", error, "--max-triangles", "5000000", "--memory", "4000", "--renderer", "raster", "--no-check", *SIZE)
        if name in FACETS:
            truth = standard(scene, 2 ** report["accuracy"]["refined"]["levels"])
        measured, said = colour_error_95(truth, seen_in("stack.tif")), report["accuracy"]["error_95"]
        stopped = report["accuracy"]["refined"]["stopped"]
        check(measured <= float(error) or (stopped and said > float(error)),
              f"{name}: --accuracy {error} holds, or is said not to", measured, said)
        check(stopped or
              all(found["error_95"] <= float(error) for found in report["accuracy"]["objects"] if found["points"] >= 20),
              f"{name}: each object is good enough by the estimate", *report["accuracy"]["objects"])
        check(measured / 2 - 0.02 <= said <= 2 * measured + 0.02, f"{name}: --accuracy {error} says what it is",
              measured, said)
        before, after = triangles_of(report)
        print(f"# | {name} | {error} | {said:.3g} | {measured:.3g} | {before} | {after} |")


def says_the_error_before():
    """Without --accuracy, plan says what the shading costs."""
    for name, scene in SCENES.items():
        report = json.loads(run("plan", path_of(scene), "--json", "-").stdout)
        truth = standard(scene)
        render(scene, "--renderer", "raster", *SIZE)
        measured, said = colour_error_95(truth, seen_in("stack.tif")), report["accuracy"]["error_95"]
        check(measured / 2 <= said <= 2 * measured and report["accuracy"]["objects"][0]["error_95"] >= said,
              f"{name}: plan says the error of the shading", measured, said)


def economy():
    """A scene that is good enough has not one triangle more, and the same samples."""
    for scene, error in (("patches", "1counts"), ("metamers", "2"), ("fluorescence", "2")):
        plain = render(scene, "--no-check", *SIZE, stack="plain.tif")
        report = render(scene, "--no-check", "--accuracy", error, *SIZE)
        refined = report["accuracy"]["refined"]
        same = np.array_equal(*(pages_of(os.path.join(TMP, name)) for name in ("plain.tif", "stack.tif")))
        check(refined["triangles_before"] == refined["triangles_after"] and refined["levels"] == 0 and same and
              report["work"]["vertices_lit"] == plain["work"]["vertices_lit"],
              f"{scene} needs no division for {error}, and gets none", refined)


def same_everywhere():
    scene = SCENES["gloss"]
    render(scene, "--accuracy", "0.2", "--threads", "1", stack="one.tif")
    for threads in ("2", "5"):
        render(scene, "--accuracy", "0.2", "--threads", threads)
        check(bytes_of(os.path.join(TMP, "one.tif")) == bytes_of(os.path.join(TMP, "stack.tif")), f"{threads} threads give the same bytes as one")
    again = run("render", "--again", os.path.join(TMP, "one.tif"), "-o", os.path.join(TMP, "again.tif"))
    check(again.returncode == 0 and bytes_of(os.path.join(TMP, "one.tif")) == bytes_of(os.path.join(TMP, "again.tif")), "--again makes it again", again.stderr)


def wavelengths():
    """The wavelengths are those of the scene or of --sampling, so that the stack can be compared with any other."""
    for words in ((), ("--sampling", "riemann:50"), ("--sampling", "gauss:8"), ("--wavelengths", "400:700:50")):
        plain = render("spheres", *words, *SIZE, stack="plain.tif")
        finer = render("spheres", "--accuracy", "0.2", *words, *SIZE)
        before, after = triangles_of(finer)
        check(finer["wavelengths_nm"] == plain["wavelengths_nm"] and after > before,
              f"spheres {' '.join(words)}: --accuracy keeps the wavelengths", finer["wavelengths_nm"], before, after)
        result = run("compare", *(os.path.join(TMP, name) for name in ("plain.tif", "stack.tif")), "--tolerance", "60000")
        check(result.returncode == 0, "compare takes both stacks", result.stderr)
    with_other = render("spheres", "--accuracy", "0.2", "--detector", "cie1964", *SIZE)["accuracy"]
    with_usual = render("spheres", "--accuracy", "0.2", *SIZE)["accuracy"]
    check(with_other["error_95"] != with_usual["error_95"], "--detector is the observer of --accuracy", with_other)


def in_counts():
    """Against float radiances, in counts of the full scale."""
    scene = SCENES["near light"]
    for error in (200, 20):
        report = render(scene, "--accuracy", f"{error}counts")
        render(scene, "--renderer", "raster", "--no-check", "--shading", "phong", "--depth", "32f", stack="standard.tif")
        shown = objects_of(os.path.join(TMP, "stack.tif")) > 0
        counts, exact = (pages_of(os.path.join(TMP, name))[:, shown] for name in ("stack.tif", "standard.tif"))
        difference = np.sort(np.abs(counts - exact / report["full_scale"] * 65535).max(0))
        measured, said = difference[len(difference) * 95 // 100], report["accuracy"]["error_95"]
        check(report["accuracy"]["unit"] == "counts" and measured <= error + 1 and measured / 2 - 1 <= said <= 2 * measured + 1,
              f"{error} counts hold, as it says", measured, said)


def few_triangles():
    """A further division would have made four triangles of one, or more."""
    for most in (100, 1000):
        result = run("render", path_of(SCENES["near light"]), "--accuracy", "0.02", "--max-triangles", str(most),
                     "-o", os.path.join(TMP, "stack.tif"), "--json", os.path.join(TMP, "few.json"))
        with open(os.path.join(TMP, "few.json"), encoding="utf-8") as file:
            report = json.load(file)["accuracy"]
        check(report["refined"]["stopped"] and most / 4 < report["refined"]["triangles_after"] <= most,
              f"at most {most} triangles", report)
        left = re.search(r"the error is still ([0-9.]+) CIEDE2000 on floor .*, since --max-triangles", result.stdout)
        check(left and abs(float(left.group(1)) / report["objects"][0]["error_95"] - 1) < 0.01,
              "the note says what error is left", result.stdout)
    flat = render(SCENES["near light"], "--accuracy", "0.5", "--shading", "flat")
    check(flat["accuracy"]["refined"]["levels"] == 0, "flat shading stays as it is")
    teapot = HEAD + "camera perspective 40 near 1 far 100 eye 0 0 4 look 0 0 0\nlight d65 1 position 1 1 1\n" + FLOOR + \
        "object teapot 1 64 material floor\n"
    refined = render(teapot, "--accuracy", "0.001", "--max-triangles", "4000000", "--no-check")["accuracy"]["refined"]
    check(refined["levels"] == 0 and not refined["stopped"], "a shape that is as fine as can be stays as it is", refined)


def what_is_hidden():
    """An object that another one hides, in the same place, is divided like that one, and stays hidden."""
    scene = HEAD + "camera ortho 6\nlight d65 1 direction 0 0 1\nmaterial dull { diffuse 0.5 }\n" \
        "material shiny { diffuse 0.2 specular 0.7 gloss 100 }\nobject sphere 1 16 8 material dull translate -1.5 0 0\n" \
        "object sphere 1 16 8 material shiny translate 1.5 0 0\nobject sphere 1 16 8 material dull translate 1.5 0 0\n"
    before, after = triangles_of(render(scene, "--accuracy", "0.2"))
    check(after > before and (objects_of(os.path.join(TMP, "stack.tif")) == 3).sum() == 0, "what was hidden stays hidden", before, after)


def in_memory():
    """The finest picture that the usual limit of triangles allows fits into the usual memory, with its shadows."""
    result = run("render", "room", "--accuracy", "20counts", "-o", os.path.join(TMP, "stack.tif"))
    check(result.returncode == 0 and "the error is still" in result.stdout, "room is refined in the usual memory",
          result.stdout, result.stderr)


def no_cracks():
    """No pixel of a mesh file shows the light behind it, nor do the halves of a material with a partner, or the parts of
    a mesh differ from the reference, with either driver."""
    wall = "".join(f"v {x} {y} 0\n" for y in range(4) for x in range(4)) + "vn 0 0 1\nvn 0.3 0 0.95\n" + "".join(
        f"f {4 * y + x + 1}//1 {4 * y + x + 2}//2 {4 * y + x + 6}//1 {4 * y + x + 5}//2\n" for y in range(3) for x in range(3))
    write("wall.obj", wall)
    mesh = HEAD + "camera ortho 1.1\nlight d65 1 position 0.1 0.2 0.3 attenuation 0 0 1\n" + FLOOR + \
        "object mesh wall.obj unitize material floor scale 2 rotate 17 1 2 3\n"
    halves = HEAD + "camera ortho 3\nlight d65 1 position -0.4 0.5 1.3 attenuation 0 0 1\n" \
        "material halves metamers/illuminant-5-blue-flower\nobject sphere 1 20 10 material halves\n"
    parts = HEAD + "camera perspective 40 near 1 far 50 eye 3 3 6 look 0 1.5 0\nlight d65 1 position 0.5 2 2 attenuation 0 0 1\n" \
        "material walnut { diffuse 0.4 }\nmaterial halves { diffuse 0.6 }\nmaterial brass { diffuse 0.5 gloss 50 }\n" \
        "object mesh chair crease 40 materials chair\n"
    for driver in ("llvmpipe", "softpipe"):
        for name, scene in (("a mesh file", mesh), ("halves", halves), ("parts", parts)):
            report = render(scene, "--accuracy", "0.2", "--renderer", driver)
            before, after = triangles_of(report)
            check(report["check"]["unexplained_pixels"] == 0 and after > before,
                  f"{name}: {driver} agrees with the reference", before, after)
            holes = (objects_of(os.path.join(TMP, "stack.tif")) == 0).sum()
            check(name != "a mesh file" or (holes == 0 or driver == "softpipe"), f"{name}: no hole with {driver}", holes)


def other_commands():
    scene = path_of(SCENES["near light"])
    render(SCENES["near light"], "--accuracy", "0.5", "--renderer", "raster", "--depth", "32f")
    of_stack = json.loads(run("probe", os.path.join(TMP, "stack.tif"), "150", "120", "--json", "-").stdout)
    of_scene = json.loads(run("probe", scene, "150", "120", "--accuracy", "0.5", "--json", "-").stdout)
    check(np.allclose(of_stack["XYZ"], of_scene["XYZ"], rtol=1e-6) and of_stack["XYZ"][1] > 0,
          "probe sees the pixel that render stores", of_stack["XYZ"], of_scene["XYZ"])
    page = run("view", scene, "--accuracy", "0.5", "-o", os.path.join(TMP, "page.html"))
    check(page.returncode == 0 and "2 triangles became" in page.stdout, "view refines, too", page.stdout, page.stderr)
    plan = run("plan", scene, "--accuracy", "0.5")
    check(re.search(r"^  refined\n(    .*\n)*    triangles before +2\n    triangles after +\d{3,}$", plan.stdout, re.MULTILINE),
          "plan says how many triangles there are", plan.stdout)


FULL = "FULL" in os.environ
for scene_name, text in SCENES.items():
    keeps_its_promise(scene_name, text, ("2", "0.5", "0.1") if FULL else ("0.5",))
for scene_name in BUILT_IN if FULL else ("spheres",):
    keeps_its_promise(scene_name, scene_name, ("2", "0.5", "0.1") if FULL else ("0.1",))
parts(says_the_error_before, economy, same_everywhere, wavelengths, in_counts, few_triangles, what_is_hidden, in_memory, no_cracks, other_commands)
done()
