#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile; makes: faults
"""Draws pictures in parts, and joins them: the stack is that of one process, byte for byte, with its verdict. Parts that are
missing, double, cut, changed or of another render are refused in one line, and leave no file. With FULL, more kinds of
pictures. Prints TAP."""
import os
import random
import shutil
import subprocess
import time

from rendered import FAULTS, SPECTRAL, TMP, bytes_of, check, done, parts, remove, run, write

FULL = "FULL" in os.environ
SEED = int(os.environ.get("SEED", time.time()))
WHOLE, JOINED = os.path.join(TMP, "whole.tif"), os.path.join(TMP, "joined.tif")
PATCHES = ("patches", "--size", "1600x1300", "--wavelengths", "450:650:100")  # three rows of tiles
ROOM = ("room", "--size", "1600x1300", "--wavelengths", "500")
MANY = "size 1600 1300\nwavelengths 500 600 100\nambient d65 1\nmaterial m { diffuse 0.5 }\n" + "".join(
    f"object box 0.2 0.2 0.2 material m translate {i % 20 - 9.5} {i // 20 - 7.5} 0\n" for i in range(300)) + "camera ortho 20\n"
PHONG = "size 2100 1500\nwavelengths 450 550 50\nshading phong\nlight d65 1 direction 1 1 1\ncamera ortho 8\n" \
    "material m { diffuse 0.5 specular 0.5 gloss 20 }\nobject sphere 3 30 30 material m\n"
BACKS = "size 1600 1300\nwavelengths 500 600 50\nlight d65 1 direction 1 1 1\ncamera ortho 3\nmaterial m { diffuse 0.5 }\n" \
    "object plane 2 2 material m two-sided rotate 160 0 1 0\n"


def save(name, content):
    path = os.path.join(TMP, name)
    with open(path, "wb") as file:
        file.write(content)
    return path


def draw(count, scene, *options, name="part", **environment):
    """Draws all parts. Returns their names, and the results of the program."""
    names = [os.path.join(TMP, f"{name} {i} of {count}.tif") for i in range(1, count + 1)]
    return names, [run("render", *scene, "--part", f"{i + 1}/{count}", "-o", names[i], "-q", *options, **environment)
                   for i in range(count)]


def is_same(what, scene, count=3):
    """Draws a picture in one process and in parts, and joins these in any order."""
    whole = run("render", *scene, "-o", WHOLE, "-q")
    names, parts = draw(count, scene)
    random.shuffle(names)
    remove(JOINED)
    joined = run("join", "-o", JOINED, "-q", *names)
    results = whole, joined, *parts
    check(all(result.returncode == 0 and not result.stderr for result in results) and bytes_of(JOINED) == bytes_of(WHOLE),
          f"{count} parts are joined to the same bytes: {what}", *(result.stderr for result in results))
    return names


def refused(what, pattern, *parts, status=2):
    remove(JOINED)
    before = sorted(os.listdir(TMP))
    result = run("join", "-o", JOINED, *parts)
    check(result.returncode == status and pattern in result.stderr and result.stderr.count("\n") == 1 and
          sorted(os.listdir(TMP)) == before, f"refused: {what}", result.returncode, result.stderr)


# ---- the same bytes ----

def kinds():
    shown = (("the reference", ("room", "--renderer", "raster", "--size", "1800x1600", "--wavelengths", "500")),
             ("floats of components", ("patches", "--sampling", "rgb", "--depth", "32f", "--size", "1600x1300")),
             ("numbers of objects of two bytes", (write("many.scene", MANY), "--unchecked", "0.5")))
    more = (("no check", (*PATCHES, "--no-check")),
            ("every pixel", (*PATCHES, "--strict")),
            ("positions", ("patches", "--samples", "4", "--size", "501x1403", "--wavelengths", "500")),
            ("components of 8 bits", ("patches", "--sampling", "basis:3", "--depth", "8", "--size", "1600x1300")),
            ("wavelengths of a quadrature", ("patches", "--sampling", "gauss:7", "--size", "1600x1300")),
            ("steps of 8 bits", (*PATCHES, "--buffer", "8", "--depth", "8")),
            ("phong shading", (write("phong.scene", PHONG), "--renderer", "raster")),
            ("two sides", (write("backs.scene", BACKS),)),
            ("softpipe", (*PATCHES, "--renderer", "softpipe")),
            ("shaders", ("textures", "--renderer", "es-shader", "--size", "1600x1300", "--wavelengths", "450:550:50")))
    for what, scene in shown + more * FULL:
        is_same(what, scene)
    for count in (1, 2) if FULL else (2,):
        is_same("the default", PATCHES, count)


def outputs():
    """Joined stacks go into a pipe, and are made again as one process makes them."""
    names = sorted(is_same("the default", PATCHES))
    piped = subprocess.run([SPECTRAL, "join", "-o", "-", *names], check=False, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    check(piped.stdout == bytes_of(WHOLE), "a pipe gets the same bytes")
    again = run("render", "--again", JOINED, "-o", "/dev/null", "-q")
    check(again.returncode == 0, "render --again makes the joined stack again", again.stderr)
    return names


# ---- refusals ----

def changed(path, old, new):
    """Returns the name of a copy with another text of the same length in its record."""
    content = bytes_of(path)
    check(len(old) == len(new) and old in content, f"there is {old!r}")
    return save("changed.tif", content.replace(old, new))


def others(first, second):
    """A part beside those of another render is named, with the line of its record that differs."""
    for options, pattern in ((("--full-scale", "2"), "'option: --full-scale=2'"), (("--depth", "8"), "'option: --depth=8'"),
                             (("--renderer", "raster"), "'option: --renderer=raster'"), (("--no-check",), "'option: --no-check'")):
        names, _ = draw(3, PATCHES, *options, name="other")
        refused(f"a part with {options[0]}", pattern, first, *names[1:])
    for old, new in ((b"spectral 0.", b"spectral 9."), (b"llvmpipe", b"softpipe")):
        refused(f"a part of {new.decode()}", new.decode(), first, changed(second, old, new))
    texts = [f"size 1600 1300\nwavelengths 500 600 100\nambient d65 1\nmaterial m {{ diffuse spectrum.txt }}\n"
             f"object sphere 1 material m\n{remark}" for remark in ("", "# a remark\n")]
    scene = (write("own.scene", texts[0]), "--renderer", "raster")
    write("spectrum.txt", "400 0.5\n700 0.5\n")
    names, _ = draw(3, scene)
    write("spectrum.txt", "400 0.5\n700 0.6\n")
    refused("a part of a file that has changed", "spectrum.txt'", names[0], *draw(3, scene, name="file")[0][1:])
    write("own.scene", texts[1])
    refused("a part of a scene that has changed", "'scene_sha256: ", names[0], *draw(3, scene, name="scene")[0][1:])


def refusals(names):
    one, two, three = names
    refused("no parts", "join takes -o STACK")
    refused("a missing part", "rows 592 to 1183 of the picture are missing", one, three)
    refused("missing parts at the end", "rows 592 to 1299 of the picture are missing", one)
    refused("a part that is given twice", f"{two}: another part has its row 592", two, one, two, three)
    refused("parts of two numbers", "another part has its row 0", one, *draw(2, PATCHES, name="half")[0])
    refused("a whole stack", f"{WHOLE} is no part of a picture", one, WHOLE)
    refused("a file that is not there", "cannot read nowhere.tif", one, "nowhere.tif")
    refused("a folder", "it is a folder", one, TMP)
    for kept in (100, 100_000, 3_000_000):
        cut = save("cut.tif", bytes_of(two)[:-kept])
        refused(f"a part without its last {kept} bytes", "cut.tif", one, cut, three)
        refused(f"a first part without its last {kept} bytes", "cut.tif", cut, one, three)
    refused("a part of a higher picture", "changed.tif", one, changed(two, b"rows: 592 592 1300", b"rows: 592 592 9300"), three)
    refused("rows outside of the picture", "changed.tif", one, changed(two, b"rows: 592 592 1300", b"rows: 992 592 1300"), three)
    for words, pattern in ((("--part", "0/3"), "not '0/3'"), (("--part", "4/3"), "not '4/3'"), (("--part", "3"), "not '3'"),
                           (("--part", "1/4"), "expected at most 3 parts"), (("--part", "1/2", "--check-map", "a.tif"), "takes no --check-map"),
                           (("--part", "1/2", "--again", two), "--again takes no --part")):
        result = run("render", *PATCHES[:5 if "--again" not in words else 0], "-o", JOINED, *words)
        check(result.returncode == 2 and pattern in result.stderr and not os.path.exists(JOINED), f"refused: {' '.join(words)}",
              result.stderr)


# ---- verdicts ----

def verdicts():
    """A fault of OpenGL is found in its part. The joined stack differs as that of one process does, and is stored if it is kept."""
    fault = {"FAULT": "1", "LD_PRELOAD": FAULTS}
    whole = run("render", *PATCHES, "-o", WHOLE, "-q", "--keep", **fault)
    names, parts = draw(3, PATCHES, "--keep", **fault)
    check([result.returncode for result in (whole, *parts)].count(1) > 1, "parts differ", whole.stderr, *(part.stderr for part in parts))
    refused("a picture that differs", "the joined picture: differs; ", *names, status=1)
    result = run("join", "-o", JOINED, "--keep", *names)
    check(result.returncode == 1 and bytes_of(JOINED) == bytes_of(WHOLE), "--keep stores the bytes and the verdict of one process", result.stderr)


def unchecked():
    """A part that lacks too much of its check is stored, and the whole is judged by its own share."""
    is_same("a part is not verified", (*ROOM, "--unchecked", "0.0005"))
    names, parts = draw(3, ROOM, "--unchecked", "0.0005")
    words = [run("info", name).stdout.split("verdict ")[1].split(";")[0].strip() for name in names]
    check(sorted(words) == ["agreed", "agreed", "not verified"], "a part alone is not verified", words, *(part.stderr for part in parts))
    names, _ = draw(3, ROOM, "--unchecked", "0")
    refused("a picture of which too little is checked", "the joined picture: not verified; ", *names, status=1)


random.seed(SEED)
shutil.rmtree(TMP, ignore_errors=True)
os.makedirs(TMP)
print(f"# SEED={SEED}")
PARTS = outputs()
refusals(PARTS)
others(*PARTS[:2])
parts(kinds, verdicts, unchecked)
done()
