#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""plan lists the files of a scene with their SHA-256, as sha256sum finds them: all kinds of files that a scene names, and no other. tar
makes an archive of them, by the line in scenes.md; unpacked elsewhere the scene has the same picture and the same record. The
program keeps nothing in the home folder. Prints TAP."""
import hashlib
import json
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import tifffile

from rendered import SPECTRAL, TMP, check, done

PLACE = os.path.abspath(TMP)
PROGRAM = os.path.abspath(SPECTRAL)
BLANKS = "folder with blanks/größe.csv"


def run(*words, folder="from", **more):
    return subprocess.run([PROGRAM, *words], check=False, cwd=os.path.join(PLACE, folder), stdout=subprocess.PIPE, stderr=subprocess.PIPE, **more)


def read(*path):
    return Path(PLACE, *path).read_bytes()


def put(path, text):
    path = Path(PLACE, "from", path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def make_scene():
    """A scene of all kinds of files, and some that it does not need. Returns those that it needs."""
    table = "400,0.5\n700,0.7\n#"
    put("all/all.scene", "size 60 40\nwavelengths 450 650 50\ncamera ortho 8\ninclude parts/lights.scene\n"
        'material table { diffuse tables/paint.csv specular "' + BLANKS + '" gloss 20 }\n'
        "material file materials/red.txt\nmaterial unused materials/unused.txt\n"
        "material picture { diffuse 0.9 texture pictures/grey.tif }\n"
        "material stack { diffuse 0.9 spectral-texture pictures/stack.tif }\n"
        "material glow { diffuse 0.3 donaldson tables/matrix.csv emission parts/../tables/glow.csv }\n"
        "object mesh models/house.obj unitize materials models/house.map translate -2 0 0\n"
        "object sphere 0.5 12 8 material table\nobject sphere 0.5 12 8 material file translate 1 0 0\n"
        "object plane 1 1 material picture translate 2 0 0\nobject plane 1 1 material stack translate 3 0 0\n"
        "object sphere 0.5 12 8 material glow translate 0 1.5 0\n")
    put("all/parts/lights.scene", "ambient ../tables/lamp.csv 0.3\nlight d65 1 direction 1 1 1\n")
    # SHA-256 works on blocks of 64 bytes; the last one has room for 55, before its end
    for length, name in ((55, "tables/paint.csv"), (56, "tables/lamp.csv"), (64, "tables/glow.csv"), (119, BLANKS)):
        put(f"all/{name}", table.ljust(length, "#"))
    put("all/tables/matrix.csv", "nm,400,450\n500,0.1,0.1\n550,0.1,0.1\n600,0,0\n")
    put("all/materials/red.txt", "400 0.1\n700 0.9\n")
    put("all/models/house.map", "roof mtl house.mtl\n")
    put("all/models/house.mtl", "newmtl roof\nKd 0.7 0.2 0.1\n")
    put("all/models/house.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl roof\nf 1 2 3\n")
    put("all/pictures/spare.txt", "")
    tifffile.imwrite(os.path.join(PLACE, "from/all/pictures/grey.tif"), np.arange(10 ** 6, dtype=np.uint32).astype(np.uint8).reshape(1000, 1000))
    run("render", "patches", "--size", "8x8", "--wavelengths", "450:650:100", "-q", "-o", "all/pictures/stack.tif")
    return sorted(f"all/{name}" for name in (
        "all.scene", "parts/lights.scene", "tables/paint.csv", BLANKS, "tables/lamp.csv", "tables/glow.csv", "tables/matrix.csv",
        "materials/red.txt", "models/house.map", "models/house.mtl", "models/house.obj", "pictures/grey.tif", "pictures/stack.tif"))


def lists(needed):
    printed = run("plan", "all/all.scene").stdout.decode()
    found = [(path, digest) for digest, path in re.findall(r"^file +([0-9a-f]{64}) (.*)$", printed, re.MULTILINE)]
    check(sorted(os.path.normpath(path) for path, _ in found) == needed, "plan lists the files that the scene needs, once", found)
    check(all(digest == hashlib.sha256(read("from", path)).hexdigest() for path, digest in found), "each with its SHA-256")
    report = json.loads(run("plan", "all/all.scene", "--json", "-").stdout)
    check(report["files"] == [f"{digest} {path}" for path, digest in found], "and so does its JSON", report["files"])
    check(json.loads(run("plan", "room", "--size", "30x20", "--json", "-").stdout)["files"] == [], "a scene of built-in files has none")
    words = ("plan", "patches", "--sampling", "gauss:4", "--detector")
    put("eye.csv", "nm,x,y,z\n400,0,0,1\n500,0,1,0\n600,1,0,0\n700,0,0,0\n")
    check([file[65:] for file in json.loads(run(*words, "eye.csv", "--json", "-").stdout)["files"]] == ["eye.csv"], "a detector's file counts")
    piped = run("plan", "-", "--json", "-", input=read("from/all/all.scene"), folder="from/all")
    check(piped.returncode == 0 and "all.scene" not in "".join(json.loads(piped.stdout)["files"]), "the text of a pipe is no file", piped.stderr)


def archive(needed):
    """The line of the page, with this scene."""
    page = Path("data/doc/scenes.md").read_text(encoding="utf-8")
    line = re.search(r"^spectral plan my.scene \| (.* tar .*)$", page, re.MULTILINE)[1].replace("my.tar", "../all.tar")
    made = subprocess.run(f"'{PROGRAM}' plan all/all.scene | {line}", shell=True, check=False, cwd=os.path.join(PLACE, "from"),
                          stderr=subprocess.PIPE)
    names = subprocess.run(["tar", "tf", "all.tar", "--quoting-style=literal"], check=False, cwd=PLACE, stdout=subprocess.PIPE).stdout.decode()
    check(not made.stderr and sorted(names.splitlines()) == needed, "tar has these files", made.stderr, names)
    os.makedirs(os.path.join(PLACE, "to"), exist_ok=True)
    subprocess.run(["tar", "xf", "../all.tar"], check=True, cwd=os.path.join(PLACE, "to"))
    for folder in ("from", "to"):
        run("render", "all/all.scene", "-o", "all.tif", "-q", folder=folder)
    check(read("from", "all.tif") == read("to", "all.tif"), "unpacked elsewhere the scene has the same stack, to the last byte")


def home():
    os.makedirs(os.path.join(PLACE, "home"), exist_ok=True)
    env = {**{name: value for name, value in os.environ.items() if not name.startswith("XDG_")}, "HOME": os.path.join(PLACE, "home")}
    for words in (("plan", "patches"), ("render", "colorchecker", "--renderer", "raster", "--no-check", "-q", "-o", "home.tif"), ("info", "home.tif")):
        check(run(*words, env=env).returncode == 0 and os.listdir(env["HOME"]) == [], f"{words[0]} leaves nothing in the home folder")


NEEDED = make_scene()
lists(NEEDED)
archive(NEEDED)
home()
done()
