#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Checks the program's own counters of work: an effect that a scene does not use costs nothing, and a used effect
costs no more than it needs. Prints TAP."""
import itertools
import json
import os

import numpy as np
import tifffile

import rendered
from rendered import TMP, check, done, output_of, write

HEAD = "wavelengths 400 700 20\nsize 24 16\ncamera ortho 12\n"
LIGHT = "light d65 1 position 0 0 8"
PLANE = "object plane 3 3 material m"  # 4 vertices
PASSES = 6  # 16 bands, 3 a pass


def run(command, scene, *options):
    return rendered.run(command, write("work.scene", HEAD + scene), *options)


def report(scene, *options):
    return rendered.render(HEAD + scene, *options, stack="/dev/null")


def scene_of(words="diffuse 0.5", light=LIGHT, more="", objects=PLANE):
    return f"{light}\nmaterial m {{ {words} }}\n{more}\n{objects}\n"


def used(effects):
    return {name for name, is_used in effects.items() if is_used}


def plain():
    result = report(scene_of())
    check(result["work"] == {"gl_passes": PASSES, "draw_calls": PASSES, "vertices_lit": 4, "points_lit": 0,
                             "specular_vertices": 0, "power_functions": 0, "excitation_integrals": 0,
                             "textures_loaded": 0, "materials_loaded": 1, "terms": 1, "unseen_instances": 0,
                             "idle_lights": 0, "undrawn_textures": 0, "dark_passes": 0, "repeated_passes": 0},
          "a matt square under a light has one term and no power function", result["work"])
    check(used(result["effects"]) == {"lights", "diffuse"} and result["effects"]["lights"] == 1,
          "its only effects are a light and diffuse reflection", result["effects"])
    return result


def prepare():
    tifffile.imwrite(os.path.join(TMP, "grey.tif"), np.full((2, 2), 200, np.uint8))
    write("matrix.csv", "nm,380,400\n500,0.1,0.2\n510,0.1,0.1\n520,0,0.1\n")
    write("square.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nusemtl a\nf 1 2 3 4\n")
    write("square.map", "a material m\n")
    rendered.render(HEAD + scene_of())


# Words added to the plain scene, the effects that they turn on, and the counters that they raise, with the rise. The
# reference computes a power function at each of 4 vertices; its bound computes it again, and at
# both ends of the bound. A cut through a square meets 3 edges, which each half has.
POWERS = {"power_functions": 16}
HIGHLIGHT = {"terms": 1, "specular_vertices": 4, **POWERS}
ADDED = (
    ("ambient light", {"more": "ambient a 0.1"}, "ambient", {"terms": 1}),
    ("gloss", {"words": "diffuse 0.5 gloss 9"}, "specular", HIGHLIGHT),
    ("a metal", {"words": "diffuse 0.5 specular 0.7 gloss 9"}, "specular", HIGHLIGHT),
    ("a local viewer", {"words": "diffuse 0.5 gloss 9", "more": "viewer local"}, "specular local_viewer",
     HIGHLIGHT),
    ("attenuation", {"light": LIGHT + " attenuation 1 0.1 0"}, "attenuation", {}),
    ("a spot without exponent", {"light": LIGHT + " spot 0 0 -1 40 0"}, "spot", {}),
    ("a spot with an exponent", {"light": LIGHT + " spot 0 0 -1 40 2"}, "spot", POWERS),
    ("fluorescence", {"words": "diffuse 0.5 fluorescence uv gaussian:550,60*0.3"}, "fluorescence",
     {"excitation_integrals": 1}),
    ("a Donaldson matrix", {"words": "diffuse 0.5 donaldson matrix.csv"}, "bispectral",
     {"excitation_integrals": 3}),
    ("a texture", {"words": "diffuse 0.5 texture grey.tif"}, "texture", {"textures_loaded": 1}),
    ("a spectral texture", {"words": "diffuse 0.5 spectral-texture stack.tif bilinear"}, "spectral_texture",
     {"textures_loaded": 1}),
    ("emission", {"words": "diffuse 0.5 emission 0.1"}, "emission", {"terms": 1}),
    ("a metameric partner", {"words": "diffuse 0.5 metamer n", "more": "material n { diffuse 0.4 }"},
     "metamer", {"terms": 1, "materials_loaded": 1, "draw_calls": PASSES, "vertices_lit": 6}),
    ("a back", {"objects": PLANE + " two-sided"}, "two_sided", {}),
    ("flat shading", {"more": "shading flat"}, "flat", {}),
    ("a material map", {"objects": "object mesh square.obj materials square.map"}, "material_map", {}),
    ("a second light", {"more": "light a 1 direction 0 0 1"}, "", {"terms": 1}),
    ("a second object", {"objects": f"{PLANE}\n{PLANE} translate 3 0 0"}, "",
     {"draw_calls": PASSES, "vertices_lit": 4}),
    ("an object out of view", {"objects": f"{PLANE}\n{PLANE} translate 30 0 0"}, "",
     {"unseen_instances": 1, "vertices_lit": 4}),
    ("a light behind the object", {"more": "light d65 1 direction 0 0 -1"}, "", {"idle_lights": 1}))

NOTHING = (
    ("a light of intensity 0", {"more": "light d65 0 position 0 0 8 spot 0 0 -1 40 2"}),
    ("a light of spectrum 0", {"more": "light 0 1 position 0 0 8"}),
    ("a light of factor 0", {"more": "light d65*0 1 direction 0 0 1"}),
    ("eight lights of intensity 0", {"more": "light d65 0 direction 0 0 1\n" * 8}),
    ("a light that is 0 at all of the picture's wavelengths",
     {"more": "light gaussian:300,1 1 direction 0 0 1"}),
    ("ambient light of intensity 0", {"more": "ambient d65 0"}),
    ("ambient light of spectrum 0", {"more": "ambient 0 1"}),
    ("emission 0", {"words": "diffuse 0.5 emission 0"}),
    ("gloss 0", {"words": "diffuse 0.5 specular 0.5 gloss 0"}),
    ("specular 0", {"words": "diffuse 0.5 specular 0 gloss 20"}),
    ("a local viewer of matt objects", {"more": "viewer local"}),
    ("attenuation 1 0 0", {"light": LIGHT + " attenuation 1 0 0"}),
    ("a texture that would repeat, without one", {"objects": PLANE + " repeat 40 40"}),
    ("a spot of cutoff 180", {"light": LIGHT + " spot 0 0 -1 180 5"}),
    ("materials without an object, whose files do not exist",
     {"more": "material a none.txt\nmaterial b { diffuse 0.5 texture none.tif donaldson none.csv }"}))


def additions(before):
    for name, scene, effects, raised in ADDED:
        after = report(scene_of(**scene))
        expected = {key: n + raised.get(key, 0) for key, n in before["work"].items()}
        check(after["work"] == expected and used(after["effects"]) - {"lights", "diffuse"}
              == set(effects.split()), f"{name} adds {raised or 'no counted work'}",
              expected, after["work"], after["effects"])
    for name, scene in NOTHING:
        after = report(scene_of(**scene))
        check(after["work"] == before["work"] and after["effects"] == before["effects"],
              f"{name}: the work is the same as without it", after["work"], after["effects"])


def minimal_terms():
    two = LIGHT + "\nlight a 1 direction 0 1 1"
    for name, words, light, terms in (
            ("matt under ambient light and two lights", "diffuse 0.5", two + "\nambient a 1", 3),
            ("plastic under ambient light and two lights", "diffuse 0.5 gloss 5", two + "\nambient a 1", 5),
            ("emission joins ambient light", "diffuse 0.5 emission 1", LIGHT + "\nambient a 1", 2),
            ("two ambient lights join", "diffuse 0.5", "ambient a 1\nambient d65 1", 1),
            ("lights of one spectrum share their terms", "diffuse 0.5 gloss 5",
             two + "\nlight d65*2 0.3 position 1 1 9 spot 0 0 -1 50 2\nlight 0.5 1 direction 0 0 1"
             "\nlight 0.7 2 direction 0 1 1", 6),
            ("black with a highlight", "diffuse 0 specular 0.5 gloss 5", LIGHT, 1),
            ("an object that only emits", "emission 1", LIGHT, 1),
            ("black", "diffuse 0", two, 0)):
        work = report(scene_of(words, light))["work"]
        check(work["terms"] == terms, f"{name}: there are {terms} terms", work["terms"])
    check(report(scene_of("emission 1", two))["effects"]["lights"] == 0,
          "lights that no material reflects are not computed")
    unlit = report(scene_of("diffuse 0.5 texture none.tif", ""))
    check(unlit["work"]["textures_loaded"] == 0, "a texture in the dark is not opened")


def excitation():
    lights = (LIGHT + "\nlight uv 1 direction 0 0 1\nlight d65 0 direction 0 0 1\nlight 0 1 direction 0 0 1\n"
              "ambient a 0.1\nambient d65 0")
    second = f"{PLANE}\nmaterial n {{ diffuse 0.5 }}\nobject plane 1 1 material n translate 4 0 0"
    work = report(scene_of("diffuse 0.5 fluorescence uv 0.1", lights, objects=second))["work"]
    check(work["excitation_integrals"] == 3,
          "one fluorescent object of two takes one integral for each of two lights and the ambient light",
          work["excitation_integrals"])
    work = report(scene_of("diffuse 0.5 fluorescence uv 0.1", "light uv 1 direction 0 0 1"),
                  "--wavelengths", "600:700:50")["work"]
    check(work["excitation_integrals"] == 1 and work["terms"] == 1,
          "a black light outside the picture's wavelengths still excites")


def passes():
    eight = f"{LIGHT}\n" * 8
    for name, light, groups in (("eight lights take the passes of one", eight, 1),
                                ("the ninth takes them twice", eight + LIGHT, 2),
                                ("16 too", eight * 2, 2), ("17 thrice", eight * 2 + LIGHT, 3),
                                ("lights of intensity 0 do not count",
                                 eight + "light d65 0 direction 0 0 1\n" * 8, 1)):
        work = report(scene_of(light=light))["work"]
        check(work["gl_passes"] == groups * PASSES, name, work["gl_passes"])


def left_out():
    """plan and render agree on what is left out; the test calls.py counts what OpenGL really gets."""
    scene = scene_of("diffuse 0.5", "light gaussian:450,15 1 direction 0 0 1\nlight a 1 direction 0 0 -1",
                     "material n { diffuse 0.5 texture grey.tif }",
                     f"{PLANE}\nobject plane 3 3 material n translate 30 0 0\n{PLANE} translate 0 0 -5000")
    work = report(scene)["work"]
    found = {(entry["what"], entry["reason"]): (entry["count"], entry["of"])
             for entry in json.loads(run("plan", scene, "--json", "-").stdout)["left_out"]}
    passes_drawn = json.loads(run("plan", scene, "--json", "-").stdout)["work"]["passes"]
    check(work["unseen_instances"] == 2 and found.get(("instances", "right of the view")) == (1, 3) and
          found.get(("instances", "beyond the far plane")) == (1, 3), "two objects are out of view", work, found)
    check(work["idle_lights"] == 1 and found.get(("lights", "they reach no object in view")) == (1, 2),
          "a light reaches nothing", work, found)
    check(work["undrawn_textures"] == 1 and [n for (what, _), n in found.items() if what == "textures"] == [(1, 1)],
          "a texture is out of view", work, found)
    dark = found.get(("passes", "nothing in view has light in their bands"), (0, PASSES))
    check(0 < work["dark_passes"] == dark[0] and work["gl_passes"] == passes_drawn == PASSES - dark[0],
          "plan counts the passes that are drawn, and those that are dark", work, found)
    even = scene_of(light="light 1 1 direction 0 0 1")
    work = report(even)["work"]
    plan = json.loads(run("plan", even, "--json", "-").stdout)
    check(work["repeated_passes"] == plan["left_out"][0]["count"] == PASSES - 2 and plan["work"]["passes"] == 2,
          "passes that show the same are drawn once", work, plan["left_out"])
    words = run("render", scene, "-o", "/dev/null", "--verbose").stdout
    check("left out instances: count 1, of 3, reason right of the view" in " ".join(words.split()), "an object out of view is said to be", words)


def sharing():
    many = "\n".join(f"{PLANE} translate {i} 0 {-i / 64}" for i in range(24))
    work = report(scene_of("diffuse 0.5 texture grey.tif fluorescence uv 0.1", objects=many))["work"]
    check((work["materials_loaded"], work["textures_loaded"], work["terms"], work["excitation_integrals"])
          == (1, 1, 1, 1), "24 objects of one material take one material, texture, term and integral", work)
    for filters, loaded in (("nearest", 1), ("linear", 2)):
        work = report(scene_of("diffuse 0.5 texture grey.tif nearest",
                               more=f"material n {{ diffuse 0.4 texture grey.tif {filters} }}",
                               objects=PLANE + "\nobject plane 1 1 material n"))["work"]
        check(work["textures_loaded"] == loaded,
              f"one texture in two materials, nearest and {filters}: loads {loaded}")


def reasons():
    words = run("plan", scene_of(
        "diffuse 0.5 gloss 3", more="material n { diffuse 0.4 }\nlight d65 0 direction 0 0 1\n"
        "light 0 1 direction 0 0 1\nlight gaussian:300,1 2 direction 0 0 1",
        objects=PLANE + "\nobject plane 1 1 material n")).stdout
    lines = {" ".join(line.split()) for line in words.splitlines()}
    for line in ("specular yes (1 of 2 materials)", "lights yes (1 of 4 shine)",
                 "ambient no (no ambient light reflected)",
                 "fluorescence no (no material has excitation)",
                 "bispectral no (no material has a Donaldson matrix)", "spot no (no light is a spot)",
                 "texture no (no lit material has a texture)", "emission no (no material emits)",
                 "metamer no (no material has a partner)", "flat no (shading is smooth)",
                 "excitation integrals 0", "materials 2", "terms 3",
                 "light d65: intensity 1", "light d65: intensity 0, off intensity 0",
                 "light 0: intensity 1, off spectrum 0 at every wavelength shown",
                 "light gaussian:300,1: intensity 2, off spectrum 0 at every wavelength shown"):
        check(line in lines, "plan says: " + line, words)
    # every order of four lights: two throw shadows, and come last in the plan; one reaches nothing; one is 0
    kinds = {"1 0 0 1 shadows": None, "1 1 0 1 shadows": None, "1 0 0 -1": "it reaches no object in view", "0 0 0 1": "intensity 0"}
    for order in itertools.permutations(kinds):
        lights = "".join(f"light d65 {kind[0]} direction {kind[2:]}\n" for kind in order)
        plan = json.loads(output_of("plan", write("order.scene", f"size 9 6\ncamera ortho 9\n{lights}material m {{ diffuse 0.5 }}\n"
                                                  "object plane 9 6 material m\nobject plane 2 2 material m translate 0 0 2\n"), "--json", "-"))
        check([light["off"] for light in plan["lights"]] == [kinds[kind] for kind in order],
              "plan says which lights shine, in every order: " + ", ".join(order), plan["lights"])
    words = run("plan", scene_of("emission 1")).stdout
    check("no material reflects it" in words and "no light shines" in words,
          "plan says that no material reflects a light", words)


prepare()
additions(plain())
minimal_terms()
excitation()
passes()
left_out()
sharing()
reasons()
done()
