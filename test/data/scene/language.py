#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Two texts give the same picture by the reference, where the second says in the plainest words what a scene, a material file, an MTL
file or a map leaves out, or says in another way; manual.sh has the defaults of the manual. effects.py and brute.py compute the
pictures of plain words once more; test/cases/bad has refused ones. Prints TAP."""
import json
import os

import numpy as np
import tifffile

from rendered import TMP, check, done, output_of, pages_of, path_of, reference, run, write

VIEW = "size 31 21\nwavelengths 450 650 10\n"
LIT = VIEW + "light d65 1 direction 1 2 3\nambient a 0.2\nmaterial m { diffuse gaussian:550,90 gloss 5 }\n"
EVEN = VIEW + "ambient 1 1\nmaterial m { diffuse 0.5 }\nmaterial n { diffuse 0.25 }\n"  # normals and sides do not matter
FAR = "object box 3 3 40 material m rotate 20 1 1 0\nobject plane 400 400 material m rotate -80 1 0 0 translate 0 -1 0\n"
BALL = "object sphere 3 12 8 material m\n"


def stack(text, *options):
    name = (write("case.scene", text),) if "\n" in text else (text, "--size", "31x21")
    return reference("case.tif", *name, "--depth", "32f", *options)


def same(name, one, other, *options):
    """The options are for the first scene alone."""
    seen, expected = pages_of(stack(one, *options)), pages_of(stack(other))
    check(seen.shape == expected.shape and np.allclose(seen, expected, rtol=1e-6, atol=1e-9) and np.ptp(expected) > 0, name,
          f"{(~np.isclose(seen, expected, rtol=1e-6, atol=1e-9)).sum()} samples of {seen.size} differ")


# ---- the picture ----

def pictures():
    for name, one, other in (
            ("the words of a camera come in any order", "camera ortho 9 up 0 0 1 far 7 near -3 look 1 0 0 eye 2 0 0\n",
             "camera ortho 9 near -3 far 7 eye 2 0 0 look 1 0 0 up 0 0 1\n"),
            ("a file may be included twice", 'include lamps.scene\ninclude "lamps.scene"\n', LAMPS + LAMPS)):
        same(name, LIT + one + FAR, LIT + other + FAR)
    same("--ambient replaces all ambient light", LIT + "ambient 1 1\n" + BALL, LIT.replace("a 0.2", "d65 0.1") + BALL, "--ambient", "d65*0.1")
    same("and has an intensity of 1", LIT + BALL, LIT.replace("a 0.2", "d65 1") + BALL, "--ambient", "d65")
    same("a list of materials is shown in the scene of the thesis", "builtin:materials/colorchecker.list", "colorchecker")
    plan = json.loads(output_of("plan", write("case.scene", "light d65 1 position 0 0 8\n"), "--json", "-"))
    check((plan["width"], plan["height"], plan["wavelengths_nm"]) == (1200, 800, list(range(300, 765, 5))),
          "a picture has 1200 x 800 pixels, and 93 wavelengths from 300 to 760 nm", plan)


def wavelengths():
    for words, n, last in (("400 700 7", 43, 694), ("400 700 299.9999", 2, 699.9999), ("555 555 1e300", 1, 555), ("380 730 0.1", 3501, 730),
                           ("list 400 450.5 1e3 1000000", 4, 1e6), ("1 65535 1", 65535, 65535)):
        nm = json.loads(output_of("plan", write("case.scene", f"wavelengths {words}\n"), "--json", "-"))["wavelengths_nm"]
        check(len(nm) == n and abs(nm[-1] - last) <= 2.0 ** -43, f"wavelengths {words} are {n}, up to {last:.10g} nm", len(nm), nm[-1])
        if n == 3501:
            check(max(abs(at - (3800 + i) / 10) for i, at in enumerate(nm)) <= 2.0 ** -43, "each within one rounding of its decimal")


# ---- objects ----

def objects():
    for words, whole in (("sphere", "sphere 1 48 24"), ("sphere 2", "sphere 2 48 24"), ("box 2", "box 2 2 2 1"), ("box 2 3", "box 2 3 2 1"),
                         ("plane 3", "plane 3 3 1"), ("cone 0.5", "cone 0.5 1 48 1"), ("torus 0.5", "torus 0.5 1.5 24 48")):
        same(f"{words} is {whole}", *(LIT + f"object {shape} material m rotate 40 1 2 0\n" for shape in (words, whole)))
    for name, one, other in (
            ("transforms apply in the order written", "box 1 1 1 material m scale 2 3 4 rotate 90 0 0 5 translate 1 0 0",
             "box 3 2 4 material m translate 1 0 0"),
            ("one factor scales all axes, and may be negative", "plane 1 1 translate 1 0 0 rotate 90 0 0 1 scale -2 material m",
             "plane 2 2 material m translate 0 -2 0"),
            ("words of an object come in any order", "plane 6 6 two-sided repeat 2.5 1.5 material t planar",
             "plane 6 6 material t planar repeat 2.5 1.5 two-sided")):
        same(name, *(EVEN + f"material t {{ diffuse 1 texture checks }}\nobject {words}\n" for words in (one, other)))
    for n, columns, rows, scale in ((1, 1, 1, 1), (3, 3, 1, 2 / 3), (4, 2, 2, 0.66), (5, 3, 2, 0.66), (8, 4, 2, 0.5), (9, 3, 3, 4 / 9),
                                    (15, 5, 3, 0.4), (16, 4, 4, 0.333), (24, 6, 4, 0.333), (30, 8, 4, 0.25)):
        write("grid.list", "".join(f"{GREY} # {i}\n" for i in range(n)))
        words = "plane 1 1 two-sided translate 0 0 2 scale 3"
        same(f"{n} objects of a checker stand in {columns} columns, {scale:.3g} times as large",
             EVEN + f"checker grid.list {words}\n", EVEN + f"material grey {GREY}\n" + "".join(
                 f"object {words} material grey translate {6 * (i % columns) - 3 * (columns - 1)} {3 * (rows - 1) - 6 * (i // columns)} 0 "
                 f"scale {scale!r}\n" for i in range(n)))
    least = "sphere 1 3 2", "torus 1 2 3 4096", "box 1 2 3", "cylinder 1 2 3 1", "cone 1 2 3 1", "disk 1 3", "teapot 1 64"
    result = run("plan", write("case.scene", LIT + "".join(f"object {words} material m\n" for words in least)))
    check(result.returncode == 0, "every shape accepts its smallest or its largest counts", result.stderr)


# ---- materials ----

def materials():
    """A sphere of a material in two forms: a file, or words."""
    for name, one, other in (
            ("a material may be used before it is defined", BALL.replace("m\n", "late\n") + "material late matt.v2.txt\n",
             "material late matt.v2.txt\n" + BALL.replace("m\n", "late\n")),
            ("a file has wavelengths and reflectances", "material p matt.v2.txt\n", "material p { diffuse matt.csv }\n"),
            ("lines of a file mix in any order, small or capital", "material p full.txt\n",
             'material p { diffuse down.csv specular up.csv gloss 128 fluorescence ex.csv em.csv texture "my wood.tif" }\n'),
            ("lines with m describe a partner", "material p pair.txt\n",
             "material p { diffuse 0.5 gloss 10 metamer q }\nmaterial q { diffuse 0.25 specular 0.75 gloss 20 fluorescence one.csv one.csv }\n"),
            ("words may span lines, with comments between them",
             "material p { diffuse 0.4*0.5 # comment }\n  gloss\n\t30 specular uv*0.1\ntexture dots linear\n emission blackbody:2856*0.5 }\n",
             "material p { diffuse 0.2 gloss 30 specular uv*0.1 texture dots linear emission blackbody:2856*0.5 }\n"),
            ("emission alone reflects nothing", "material p { emission 1 }\n", "material p { diffuse 0 emission 1 }\n"),
            ("a texture of a stack is nearest", "material p { diffuse 1 spectral-texture builtin:textures/picture.tif }\n",
             "material p { diffuse 1 spectral-texture builtin:textures/picture.tif nearest }\n")):
        ball = "" if "late" in one else BALL.replace("m\n", "p\n")
        same(name, LIT + one + ball, LIT + other + ball)


def maps():
    """Strips of a mesh have their materials by a map; the same strips are meshes of their own."""
    names = "", "usemtl two words\n", "usemtl wall\n", "usemtl other\n"
    corners = "".join(f"v {x} {y} 0\n" for y in (-4, -2, 0, 2, 4) for x in (-6, 6))
    faces = [f"f {i} {i + 1} {i + 3} {i + 2}\n" for i in (1, 3, 5, 7)]
    write("strips.obj", corners + "".join(name + face for name, face in zip(names, faces)))
    for i, face in enumerate(faces):
        write(f"strip{i}.obj", corners + face)
    write("maps/a.mtl", "newmtl wall\nKd 0.5 0.5 0.5\n")
    write("maps/strips.map", '# strips\nwall mtl a.mtl\n\n  "" material late # none\n"two words" material half\n* material wall\n')
    used = "material wall { diffuse 0.125 }\nmaterial half { diffuse 1 metamer n }\n"
    same("a map names materials of the scene, defined later, and entries of MTL files beside it",
         EVEN + "object mesh strips.obj materials maps/strips.map\n" + used + "material late matt.v2.txt\n",
         EVEN + used + "material late matt.v2.txt\n" + "".join(
             f"object mesh strip{i}.obj material {name}\n" for i, name in enumerate(("late", "half", "m", "wall"))))


def mtl():
    """The entry's neighbours are wrong; nobody names them."""
    write("x.map", "x mtl x.mtl\n")
    write("x.obj", "v -6 -4 0\nv 6 -4 0\nv 6 4 1\nv -6 4 1\nusemtl x\nf 1 2 3 4\n")
    write("rgb.csv", "480 0.2\n500 0.6\n570 0.6\n600 1\n")
    write("red.csv", "300 0\n570 0\n600 1\n900 1\n")
    for name, entry, words in (
            ("colours become bands, Ns is at most 128, Ks a highlight, and Ke emission",
             "Ka 1 1\nKd 1 .6 .2\nillum 2\nKs 0.5 0.5 0.5\nNs 1000\nd 1.0\nKe 3 3 3\nKrzl\n", "diffuse rgb.csv specular 0.5 gloss 128 emission 3"),
            ("a black highlight is none", "Kd 0 0 0\nKs 0 0 0\nNs 20\nKe 0 0 1\n", "diffuse 0 emission blue.csv"),
            ("without Kd diffuse is 0, and without Ns nothing is specular", "Ks 0.5 0.5 0.5\nKe 1 0 0\nNs 0\n", "emission red.csv")):
        write("x.mtl", f"Kd no number\nnewmtl other\nKd wrong\nnewmtl x # here\n{entry}newmtl y\n")
        same(f"MTL: {name}", LIT + "object mesh x.obj materials x.map\n", LIT + f"material x {{ {words} }}\nobject mesh x.obj material x\n")


GREY = "colorchecker/22-neutral-5"
LAMPS = "light 1 0.2 position 0 0 8\nlight 1 0.1 position 0 -6 8\n"
os.makedirs(path_of("maps"), exist_ok=True)
write("lamps.scene", LAMPS)
write("matt.v2.txt", "# nothing\n\n  400 0.25 # end\r\n700\t0.75")
write("matt.csv", "400,0.25\n700,0.75\n")
write("full.txt", 'g 128\ns 400 0\n400 1\ns 700 1\nf 400 2 0\nf 600 0 3\nT "my wood.tif"\n700 0\n')
write("pair.txt", "500 0.5\ng 10\nmr 500 0.25\nMG 20\nmS 500 0.75\nmf 500 1 1\n")
for file, text in (("down", "400,1\n700,0\n"), ("up", "400,0\n700,1\n"), ("ex", "400,2\n600,0\n"), ("em", "400,0\n600,3\n"), ("one", "500,1\n"),
                   ("blue", "300,1\n480,1\n500,0\n900,0\n")):
    write(f"{file}.csv", text)
tifffile.imwrite(os.path.join(TMP, "my wood.tif"), np.arange(64, dtype=np.uint8).reshape(8, 8) * 4)
for part in pictures, wavelengths, objects, materials, maps, mtl:
    part()
done()
