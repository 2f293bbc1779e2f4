#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile glmark2-data
"""Checks --accuracy: the error that a refined picture has against light at every point of the true surfaces (the
reference with phong shading and 8 times as many triangles, at every nm), and the error that the program promises and
prints. Checks that nothing is refined in vain, that no crack opens, and that both renderers agree. FULL: with more
errors, and for all built-in scenes. Prints TAP."""
import json
import os
import re
import subprocess
import sys

import numpy as np
import tifffile

sys.dont_write_bytecode = True
from rendered import SPECTRAL, TMP, check, colour_error_95, done, objects_of, tristimulus, write
from tap import bail_out

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
object plane 8 8 material floor rotate -90 1 0 0 translate 0 -1 0
""",
}


def run(command, *words):
    return subprocess.run([SPECTRAL, command, *words], check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True)


def path_of(scene, name="accuracy.scene"):
    return write(name, scene) if "\n" in scene else scene


def render(scene, *options, stack="stack.tif", agrees=True):
    """The report of a render; its stack is left in the file."""
    result = run("render", path_of(scene), "-o", os.path.join(TMP, stack), "--json", "-", "--quiet", *options)
    if result.returncode != 0 and agrees:
        bail_out(scene, options, result.stderr)
    return json.loads(result.stdout)


def seen_in(stack):
    path = os.path.join(TMP, stack)
    return tristimulus(path), objects_of(path)


def standard(scene, *options):
    render(scene, "--renderer", "raster", "--no-check", "--shading", "phong", "--tessellation", "8", "--depth", "32f",
           "--memory", "6000", stack="standard.tif", *SIZE, *options)
    return seen_in("standard.tif")


def keeps_its_promise(name, scene, errors):
    """Each error holds, and the estimate is within a factor of 2 of the measured one; below 0.02, the 16 bits of a
    sample and the texels of the estimate are in the way."""
    truth = standard(scene, "--sampling", "riemann:1")
    for error in errors:
        report = render(scene, "--accuracy", error, "--memory", "4000", *SIZE)
        measured, said = colour_error_95(truth, seen_in("stack.tif")), report["accuracy"]["error_95"]
        check(measured <= float(error), f"{name}: --accuracy {error} holds", measured, said)
        check(measured / 2 - 0.02 <= said <= 2 * measured + 0.02, f"{name}: --accuracy {error} says what it is",
              measured, said)
        refined = report["accuracy"]["refined"]
        print(f"# {name}, --accuracy {error}: {measured:.3g} ({said:.3g} said), {refined['triangles_before']} triangles "
              f"became {refined['triangles_after']}")


def says_the_error_before():
    """Without --accuracy, plan says what the shading costs."""
    for name, scene in SCENES.items():
        report = json.loads(run("plan", path_of(scene), "--json", "-").stdout)
        truth = standard(scene)
        render(scene, "--renderer", "raster", *SIZE)
        measured, said = colour_error_95(truth, seen_in("stack.tif")), report["accuracy"]["error_95"]
        check(measured / 2 <= said <= 2 * measured and report["accuracy"]["objects"][0]["error_95"] >= said,
              f"{name}: plan says the error of the shading", measured, said)


def bytes_of(stack):
    with open(os.path.join(TMP, stack), "rb") as file:
        return file.read()


def economy():
    """A scene that is good enough has not one triangle more, and the same samples."""
    for scene, error in (("patches", "1counts"), ("metamers", "2"), ("room", "2")):
        nm = ("--wavelengths", "380:730:5")
        plain = render(scene, "--no-check", *nm, *SIZE, stack="plain.tif")
        report = render(scene, "--no-check", "--accuracy", error, *nm, *SIZE)
        refined = report["accuracy"]["refined"]
        with tifffile.TiffFile(os.path.join(TMP, "plain.tif")) as one, \
                tifffile.TiffFile(os.path.join(TMP, "stack.tif")) as two:
            same = all(np.array_equal(a.asarray(), b.asarray()) for a, b in zip(one.pages, two.pages))
        check(refined["triangles_before"] == refined["triangles_after"] and refined["levels"] == 0 and same and
              report["work"]["vertices_lit"] == plain["work"]["vertices_lit"],
              f"{scene} needs no refinement for {error}, and gets none", refined)


def same_everywhere():
    scene = SCENES["gloss"]
    render(scene, "--accuracy", "0.2", "--threads", "1", stack="one.tif")
    for threads in ("2", "5"):
        render(scene, "--accuracy", "0.2", "--threads", threads)
        check(bytes_of("one.tif") == bytes_of("stack.tif"), f"{threads} threads give the same bytes as one")
    again = run("render", "--again", os.path.join(TMP, "one.tif"), "-o", os.path.join(TMP, "again.tif"))
    check(again.returncode == 0 and bytes_of("one.tif") == bytes_of("again.tif"), "--again makes it again", again.stderr)


def wavelengths():
    """Daylight needs few wavelengths, the lines of a tube more; those of the user stand, and a note says if they are
    too few; counts need none but the scene's."""
    bands = {}
    for light in ("d65", "f11"):
        report = render("patches", "--light", f"1={light}", "--accuracy", "0.5", *SIZE)
        bands[light] = len(report["wavelengths_nm"])
        truth = standard("patches", "--light", f"1={light}", "--sampling", "riemann:1")
        measured = colour_error_95(truth, seen_in("stack.tif"))
        check(measured <= 0.5, f"patches under {light}: --accuracy 0.5 holds with {bands[light]} bands", measured)
    check(20 <= bands["d65"] < bands["f11"] < 200, "lines need more bands than daylight", bands)
    for words, bands in ((("--wavelengths", "400:700:50"), 7), (("--sampling", "riemann:50"), 8)):
        result = run("render", "patches", "-o", "/dev/null", "--accuracy", "0.5", *words, *SIZE)
        check(result.returncode == 0 and f", {bands} wavelengths" in result.stdout and
              "the wavelengths are too few" in result.stdout,
              f"{' '.join(words)} stands, and a note says what it costs", result.stdout, result.stderr)
    counts = render("patches", "--accuracy", "8counts", *SIZE)
    plain = render("patches", *SIZE)
    check(counts["wavelengths_nm"] == plain["wavelengths_nm"], "counts leave the wavelengths as they are")
    render("patches", "--accuracy", "0.5", "--detector", "cie1964", *SIZE)
    about = run("info", os.path.join(TMP, "stack.tif")).stdout
    check(re.search("^sampled for +cie1964$", about, re.MULTILINE), "--detector is the observer of --accuracy", about)


def in_counts():
    """Against float radiances, in counts of the full scale."""
    scene = SCENES["near light"]
    for error in (200, 20):
        report = render(scene, "--accuracy", f"{error}counts")
        render(scene, "--renderer", "raster", "--no-check", "--shading", "phong", "--depth", "32f", stack="standard.tif")
        with tifffile.TiffFile(os.path.join(TMP, "stack.tif")) as tiff, \
                tifffile.TiffFile(os.path.join(TMP, "standard.tif")) as standard_tiff:
            n, shown = len(report["wavelengths_nm"]), objects_of(os.path.join(TMP, "stack.tif")) > 0
            counts = np.array([page.asarray()[shown] for page in tiff.pages[:n]], float)
            exact = np.array([page.asarray()[shown] for page in standard_tiff.pages[:n]], float)
        difference = np.sort(np.abs(counts - exact / report["full_scale"] * 65535).max(0))
        measured, said = difference[len(difference) * 95 // 100], report["accuracy"]["error_95"]
        check(report["accuracy"]["unit"] == "counts" and measured <= error + 1 and measured / 2 - 1 <= said <= 2 * measured + 1,
              f"{error} counts hold, as it says", measured, said)


def few_triangles():
    for most in (100, 1000):
        report = render(SCENES["near light"], "--accuracy", "0.02", "--max-triangles", str(most))
        refined = report["accuracy"]["refined"]
        check(refined["stopped"] and most / 2 < refined["triangles_after"] <= most, f"at most {most} triangles", refined)
    flat = render(SCENES["near light"], "--accuracy", "0.5", "--shading", "flat")
    check(flat["accuracy"]["refined"]["levels"] == 0, "flat shading stays as it is")


def no_cracks():
    """Two planes meet at an edge, askew, under a light near to one of them: background never shines through, with
    either driver. The same with the halves of a material with a partner, and with the parts of a mesh."""
    turn = "rotate 17 1 2 3 translate 0.1 0.2 0"
    planes = HEAD + "camera ortho 10\nlight d65 1 position -1.2 0.4 0.9 attenuation 0 0 1\n" + FLOOR + \
        f"object plane 10 10 material floor translate -5 0 0 {turn}\nobject plane 10 10 material floor translate 5 0 0 {turn}\n"
    halves = HEAD + "camera ortho 3\nlight d65 1 position -0.4 0.5 1.3 attenuation 0 0 1\n" \
        "material halves metamers/illuminant-5-blue-flower\nobject sphere 1 20 10 material halves\n"
    parts = HEAD + "camera perspective 40 near 1 far 50 eye 3 3 6 look 0 1.5 0\nlight d65 1 position 0.5 2 2 attenuation 0 0 1\n" \
        "material walnut { diffuse 0.4 }\nmaterial halves { diffuse 0.6 }\nmaterial brass { diffuse 0.5 gloss 50 }\n" \
        "object mesh chair crease 40 materials chair\n"
    for driver in ("llvmpipe", "softpipe"):
        for name, scene in (("two planes that meet", planes), ("halves", halves), ("parts", parts)):
            report = render(scene, "--accuracy", "0.2", "--renderer", driver)
            check(report["check"]["unexplained_pixels"] == 0 and
                  report["accuracy"]["refined"]["triangles_after"] > report["accuracy"]["refined"]["triangles_before"],
                  f"{name}: {driver} agrees with the reference")
            holes = (objects_of(os.path.join(TMP, "stack.tif"))[60:140, 100:200] == 0).sum()
            check(name != "two planes that meet" or holes == 0, f"{name}: no hole with {driver}", holes)


def outlines():
    """Where only the outline is wrong, it alone is refined: a disk of six corners under ambient light."""
    scene = HEAD + "camera ortho 3\nambient 1 1\nmaterial white { diffuse 1 }\nobject disk 1 6 material white\n"
    report = render(scene, "--accuracy", "1")
    seen = (objects_of(os.path.join(TMP, "stack.tif")) > 0).sum()
    refined, area = report["accuracy"]["refined"], np.pi * 100 ** 2
    check(refined["triangles_before"] == 6 and 12 < refined["triangles_after"] < 200, "an outline is refined alone", refined)
    check(abs(seen - area) < 2 * np.pi * 100 * 0.25, "it is as round as a quarter of a pixel allows", seen, area)


def coarse_sphere():
    """Most edges of the outline of a coarse sphere belong to facets that are seen from behind."""
    scene = HEAD + "camera perspective 40 near 1 far 100 eye 0 0 4 look 0 0 0\nlight d65 1 direction 1 1 1\n" \
        "material white { diffuse 0.8 }\nobject sphere 1 12 8 material white rotate 20 1 2 0\n"
    render(scene, "--accuracy", "1")
    radius = 100 / np.tan(np.radians(20)) * np.tan(np.arcsin(1 / 4))
    seen, area = (objects_of(os.path.join(TMP, "stack.tif")) > 0).sum(), np.pi * radius ** 2
    check(abs(seen - area) < 2 * np.pi * radius * 0.25, "the outline of a coarse sphere becomes round", seen, area)


def other_commands():
    scene = path_of(SCENES["near light"])
    nm = ("--wavelengths", "400:700:20")
    render(SCENES["near light"], "--accuracy", "0.5", "--renderer", "raster", "--depth", "32f", *nm)
    of_stack = json.loads(run("probe", os.path.join(TMP, "stack.tif"), "150", "120", "--json", "-").stdout)
    of_scene = json.loads(run("probe", scene, "150", "120", "--accuracy", "0.5", *nm, "--json", "-").stdout)
    check(np.allclose(of_stack["XYZ"], of_scene["XYZ"], rtol=1e-6) and of_stack["XYZ"][1] > 0,
          "probe sees the pixel that render stores", of_stack["XYZ"], of_scene["XYZ"])
    page = run("view", scene, "--accuracy", "0.5", "-o", os.path.join(TMP, "page.html"))
    check(page.returncode == 0 and "2 triangles became" in page.stdout, "view refines, too", page.stdout, page.stderr)
    plan = run("plan", scene, "--accuracy", "0.5")
    check(re.search(r"^refined +2 triangles became \d+ on floor ", plan.stdout, re.MULTILINE),
          "plan lists the refined objects", plan.stdout)


def refusals():
    scene = path_of(SCENES["near light"])
    for words, pattern in ((("--accuracy", "0"), "0 is below 0.001"), (("--accuracy", "none"), "must be a number"),
                           (("--accuracy", "8count"), "must be a number"), (("--accuracy", "counts"), "must be a number"),
                           (("--accuracy", "1", "--sampling", "gauss:8", "--detector", "DETECTOR"),
                            "needs an observer, and .* is none; expected counts")):
        detector = path_of("# a camera\n" + "".join(f"{nm},{nm % 7},{nm % 3},1\n" for nm in range(400, 701, 10)), "camera.csv")
        result = run("render", scene, "-o", "/dev/null", *[word.replace("DETECTOR", detector) for word in words])
        check(result.returncode == 2 and re.search(pattern, result.stderr), f"{' '.join(words)} is refused", result.stderr)


FULL = "FULL" in os.environ
for scene_name, text in SCENES.items():
    keeps_its_promise(scene_name, text, ("2", "0.5", "0.1") if FULL else ("0.5",))
for scene_name in sorted(name[:-6] for name in os.listdir("data/builtin/scenes")) if FULL else ("spheres",):
    keeps_its_promise(scene_name, scene_name, ("2", "0.5", "0.1") if FULL else ("0.1",))
says_the_error_before()
economy()
same_everywhere()
wavelengths()
in_counts()
few_triangles()
no_cracks()
outlines()
coarse_sphere()
other_commands()
refusals()
done()
