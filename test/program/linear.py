#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: valgrind python3-numpy python3-tifffile; makes: test_linear
"""Every reader takes a time in proportion to its input. The measure of time is the number of instructions, which
valgrind counts: it is the same on a slow and on a busy machine. Eight times as many things must take less than 16
times as many instructions, so that n log n passes and n^1.5 does not. Prints TAP."""
import concurrent.futures
import io
import math
import os
import random
import re
import shutil
import subprocess

import numpy as np
import tifffile

from tap import bail_out, check, done, parts

BUILD = os.environ.get("BUILD", "build")
PROGRAM = f"{BUILD}/test/test_linear"
FOLDER = os.path.join(os.environ.get("TEST_TMP", f"{BUILD}/tmp"), "linear")
TIMES, MOST = 8, 16
LIMIT_S = 300  # a reader that takes longer has failed
HEAD = "size 8 8\nwavelengths list 500\nambient 1 1\nlight 1 1 direction 0 0 1\n"
GREY = "material m { diffuse 0.5 }\n"


def joined(n, line):
    return "".join(line(i) for i in range(n))


# ---- scenes of n things: each function returns {file: text} ----

def mesh(obj, more=None, words="material m"):
    return {"a.scene": HEAD + GREY + f"object mesh a.obj {words}\n", "a.obj": obj, **(more or {})}


def scene(text):
    return {"a.scene": HEAD + text}


def used(n):
    return "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + joined(n, lambda i: f"usemtl u{i}\nf 1 2 3\n")


def cone(n):
    """Faces at a point with a crease between them; none has a normal."""
    return mesh("v 0 0 0.2\n" + joined(n, lambda i: "v {:.9f} {:.9f} -3\n".format(
        math.cos(2 * math.pi * i / n), math.sin(2 * math.pi * i / n))) +
                joined(n, lambda i: f"f 1 {i + 2} {(i + 1) % n + 2}\n"))


def apex(n):
    """Faces at a point where each has another normal."""
    return mesh("v 0 0 0\n" + joined(n, lambda i: f"v 1 {i / n} 0\nvn 1 {i / n} 1\n") +
                joined(n - 1, lambda i: f"f 1//{i + 1} {i + 2}//{i + 1} {i + 3}//{i + 1}\n"))


def grid(n):
    side = math.isqrt(n)
    corner = [i + j * (side + 1) + 1 for j in range(side) for i in range(side)]
    return mesh(joined((side + 1) ** 2, lambda i: f"v {i % (side + 1)} {i // (side + 1)} {i % 3}\n") +
                "".join(f"f {c} {c + 1} {c + side + 2} {c + side + 1}\n" for c in corner))


# ---- pictures of n pages or lines ----

def tiff(n_pages, description):
    """A TIFF file of pages of one pixel. The first has a description."""
    out, pixel = io.BytesIO(), np.zeros((1, 1), np.uint8)
    with tifffile.TiffWriter(out) as pages:
        for page in range(n_pages):
            pages.write(pixel, description=None if page else description, metadata=None, contiguous=False, photometric="minisblack")
    return {"a.tif": out.getvalue()}


def ome(n):
    channels = joined(n, lambda i: f'<Channel ID="{i}" EmissionWavelength="{300 + i / 100:.2f}"/>')
    return tiff(n, f"<OME><Image><Pixels>{channels}</Pixels></Image></OME>")


def record(n):
    return tiff(1, "<Description>program: x\n" + "no colon\n" * n + "</Description>")


READERS = {
    "materials": (500, lambda n: scene(joined(n, lambda i: f"material m{i} {{ diffuse 0.5 }}\n"
                                                            f"object plane 1 1 material m{i}\n"))),
    "metameric partners": (300, lambda n: scene(joined(
        n, lambda i: f"material a{i} {{ diffuse 0.5 }}\nmaterial b{i} {{ diffuse 0.4 metamer a{i} }}\n"
                     f"object plane 1 1 material b{i}\n"))),
    "materials whose tables end early": (1000, lambda n: {
        "t.csv": "499,0.5\n499.6,0.6\n",
        **scene(joined(n, lambda i: f"material m{i} {{ diffuse t.csv }}\nobject plane 1 1 material m{i}\n"))}),
    "shapes": (2500, lambda n: scene(GREY + joined(n, lambda i: f"object plane {1 + i} 1 material m\n"))),
    "objects": (500, lambda n: scene(GREY + joined(n, lambda i: f"object plane 1 1 material m translate {i} 0 0\n"))),
    "lights of one spectrum": (3000, lambda n: scene(
        GREY + "object plane 1 1 material m\n" + joined(n, lambda i: f"light 1 1 position {i} 0 5\n"))),
    "usemtl": (500, lambda n: mesh(used(n), {"a.map": "* material m\n"}, "materials a.map")),
    "lines of a material map": (300, lambda n: mesh(
        used(n), {"a.map": joined(n, lambda i: f"u{i} material m\n")}, "materials a.map")),
    "entries of an MTL file": (150, lambda n: mesh(
        used(n), {"a.map": joined(n, lambda i: f"u{i} mtl a.mtl\n"),
                   "a.mtl": joined(n, lambda i: f"newmtl u{i}\nKd 0.5 0.5 0.5\n")}, "materials a.map")),
    "faces of a mesh": (800, grid),
    "faces at the tip of a cone": (400, cone),
    "normals at one point": (1000, apex),
    "rows of a table": (800, lambda n: {
        "t.csv": joined(n, lambda i: f"{300 + 400 * i / n:.6f},0.5\n"),
        **scene("material m { diffuse t.csv }\nobject plane 1 1 material m\n")}),
    "samples of a set": (200, lambda n: {
        "s.ti3": "CTI3\nBEGIN_DATA_FORMAT\nSAMPLE_ID SPEC_400 SPEC_500 SPEC_600\nEND_DATA_FORMAT\nBEGIN_DATA\n" +
                 joined(n, lambda i: f"A{i} 0.2 0.3 0.4\n") + "END_DATA\n",
        **scene("checker s.ti3 plane 1 1\n")}),
    "columns of a set": (200, lambda n: {
        "s.csv": "nm" + joined(n, lambda i: f",c{i}") + "".join(f"\n{nm}" + n * ",0.5" for nm in (400, 500, 600)) + "\n",
        **scene("checker s.csv plane 1 1\n")}),
    "materials of one table": (100, lambda n: {
        "s.csv": "nm" + joined(n, lambda i: f",c{i}") + "".join(f"\n{nm}" + n * ",0.5" for nm in (400, 500, 600)) + "\n",
        **scene(joined(n, lambda i: f"material m{i} {{ diffuse s.csv:c{i} }}\nobject plane 1 1 material m{i}\n"))}),
    "bands in one line": (2000, lambda n: {
        "s.ti3": f"CGATS.17\nSPECTRAL_BANDS {n}\nSPECTRAL_START_NM 400\nSPECTRAL_END_NM 700\nBEGIN_DATA\n" + n * "0.5 " + "\nEND_DATA\n",
        **scene("material m { diffuse s.ti3 }\nobject plane 1 1 material m\n")}),
    "comments": (3000, lambda n: scene(GREY + "object plane 1 1 material m\n" + "# nothing\n" * n)),
    "pages that OME-XML describes": (1500, ome),
    "lines of a record": (1000, record),
}


def write(folder, files):
    """Writes the files, and returns the one to read."""
    os.makedirs(folder)
    for name, text in files.items():
        with open(os.path.join(folder, name), "wb") as file:
            file.write(text if isinstance(text, bytes) else text.encode())
    return os.path.join(folder, next(name for name in files if name in ("a.scene", "a.tif")))


def instructions(path, *words):
    """Counts those of reading a file; infinite: it takes too long. An input without an object, or a TIFF file that
    is no stack, is refused in the end, which is no matter here."""
    words = words or (PROGRAM, "info" if path.endswith(".tif") else "plan")
    try:
        result = subprocess.run(["valgrind", "--tool=cachegrind", "--cache-sim=no",
                                 "--cachegrind-out-file=/dev/null", *words, path],
                                check=False, timeout=LIMIT_S, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                universal_newlines=True)
    except subprocess.TimeoutExpired:
        return math.inf, "takes more than five minutes"
    found = re.search(r"I +refs: +([\d,]+)", result.stderr)
    if not found:
        bail_out("valgrind counted nothing:", result.stderr)
    said = "\n".join(line for line in result.stderr.splitlines() if not line.startswith(("==", "--")))
    return int(found.group(1).replace(",", "")), said


def compare(name):
    n, make = READERS[name]
    folder = os.path.join(FOLDER, name.replace(" ", "-"))
    return [instructions(write(f"{folder}/{k}", make(k))) for k in (n, TIMES * n)]


def starts():
    """Counts the instructions that a file of almost nothing takes, by its ending."""
    inputs = {"scene": scene(GREY + "object plane 1 1 material m\n"), "tif": record(1)}
    return {ending: instructions(write(f"{FOLDER}/{ending}", files))[0] for ending, files in inputs.items()}


def check_readers():
    start = starts()
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for name, counts in zip(READERS, pool.map(compare, READERS)):
            n, make = READERS[name]
            few, many = (count - start["tif" if make in (ome, record) else "scene"] for count, _ in counts)
            refused = [said for _, said in counts if said and "has no record" not in said]
            check(not refused and many < MOST * few,
                  f"{TIMES * n} {name} take less than {MOST} times the instructions of {n}",
                  f"{few} and {many} instructions: {many / max(few, 1):.1f} times as many", *refused)


def ring(shuffled):
    """A torus above a plane, which throws a shadow: its triangles in the order of its rings, or in any order."""
    rings, sides = 96, 32
    at = [(2 * math.pi * i / rings, 2 * math.pi * k / sides) for i in range(rings) for k in range(sides)]
    number = [[i % rings * sides + k % sides + 1 for k in range(sides + 1)] for i in range(rings + 1)]
    faces = [f"f {number[i][k]} {number[i][k + 1]} {number[i + 1][k + 1]}\nf {number[i][k]} {number[i + 1][k + 1]} {number[i + 1][k]}\n"
             for i in range(rings) for k in range(sides)]
    if shuffled:
        random.Random(1).shuffle(faces)
    return {"a.scene": HEAD.replace("0 0 1", "1 3 2 shadows") + "camera perspective 40 eye 0 3 4 look 0 0 0\n" + GREY +
            "object mesh a.obj material m\nobject plane 8 8 1 material m rotate -90 1 0 0 translate 0 -0.6 0\n",
            "a.obj": "".join(f"v {(1 + 0.4 * math.cos(b)) * math.cos(a):.6f} {0.4 * math.sin(b):.6f} "
                             f"{(1 + 0.4 * math.cos(b)) * math.sin(a):.6f}\n" for a, b in at) + "".join(faces)}


def check_order():
    words = "render", "--renderer", "raster", "--no-check", "--size", "60x40", "-q", "-o", "/dev/null"
    counts = [instructions(write(f"{FOLDER}/ring-{shuffled}", ring(shuffled)), f"{BUILD}/spectral", *words) for shuffled in (False, True)]
    (sorted_count, said), (shuffled_count, also_said) = counts
    check(not said and not also_said and shuffled_count < 1.5 * sorted_count, "the order of a mesh's triangles does not matter for its shadow",
          f"{sorted_count} and {shuffled_count} instructions", said, also_said)


shutil.rmtree(FOLDER, ignore_errors=True)
parts(check_readers, check_order)
shutil.rmtree(FOLDER, ignore_errors=True)
done()
