#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile busybox-static
"""Packs scenes: tar, busybox and Python read the archive, and the scene that they unpack has the same picture and the same record.
Equal files make equal archives. Files that another machine would not find are refused. A stack records all files of its scene with
their SHA-256. Prints TAP."""
import hashlib
import io
import os
import re
import resource
import shutil
import subprocess
import sys
import tarfile

import numpy as np
import tifffile

sys.dont_write_bytecode = True
from rendered import SPECTRAL, TMP, check, done

HOME = os.path.abspath(TMP)
PROGRAM = os.path.abspath(SPECTRAL)
LONG = "folder with a name of many characters/" * 3 + "größe.csv"


def run(*words, folder="", **more):
    return subprocess.run([PROGRAM, *words], check=False, cwd=os.path.join(HOME, folder), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, **more)


def read(*path):
    with open(os.path.join(HOME, *path), "rb") as file:
        return file.read()


def put(path, text):
    path = os.path.join(HOME, path)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def make_scene(folder):
    """A scene of all kinds of files. Returns those that it needs."""
    table = "400,0.5\n700,0.7\n"
    put(f"{folder}/all.scene", "size 60 40\nwavelengths 450 650 50\ncamera ortho 8\ninclude parts/lights.scene\n"
        'material table { diffuse tables/paint.csv specular "' + LONG + '" gloss 20 }\n'
        "material file materials/red.txt\n"
        "material picture { diffuse 0.9 texture pictures/grey.tif }\n"
        "material cube { diffuse 0.9 spectral-texture pictures/cube.img }\n"
        "material glow { diffuse 0.3 donaldson tables/matrix.csv emission parts/../tables/glow.csv }\n"
        "material unused materials/unused.txt\n"
        "object mesh models/house.obj unitize materials models/house.map translate -2 0 0\n"
        "object sphere 0.5 12 8 material table\nobject sphere 0.5 12 8 material file translate 1 0 0\n"
        "object plane 1 1 material picture translate 2 0 0\nobject plane 1 1 material cube translate 3 0 0\n"
        "object sphere 0.5 12 8 material glow translate 0 1.5 0\n")
    put(f"{folder}/parts/lights.scene", "ambient ../tables/lamp.csv 0.3\nlight d65 1 direction 1 1 1\n")
    for name in ("tables/paint.csv", "tables/lamp.csv", "tables/glow.csv"):
        put(f"{folder}/{name}", table)
    put(f"{folder}/{LONG}", "#" * 511 + "\n" + table)
    put(f"{folder}/tables/matrix.csv", "nm,400,450\n500,0.1,0.1\n550,0.1,0.1\n600,0,0\n")
    put(f"{folder}/materials/red.txt", "400 0.1\n700 0.9\n")
    put(f"{folder}/models/house.map", "roof mtl house.mtl\n")
    put(f"{folder}/models/house.mtl", "newmtl roof\nKd 0.7 0.2 0.1\n")
    put(f"{folder}/models/house.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl roof\nf 1 2 3\n")
    os.makedirs(os.path.join(HOME, folder, "pictures"))
    tifffile.imwrite(os.path.join(HOME, folder, "pictures", "grey.tif"), np.arange(64, dtype=np.uint8).reshape(8, 8))
    np.full((2, 4, 4), 0.5, "<f4").tofile(os.path.join(HOME, folder, "pictures", "cube.img"))
    put(f"{folder}/pictures/cube.hdr", "ENVI\nsamples = 4\nlines = 4\nbands = 2\nheader offset = 0\ndata type = 4\ninterleave = bsq\nbyte order = 0\n"
        "wavelength units = Nanometers\nwavelength = {450, 650}\n")
    return sorted(("all.scene", "parts/lights.scene", "tables/paint.csv", LONG, "tables/lamp.csv", "tables/glow.csv", "tables/matrix.csv",
                   "materials/red.txt", "models/house.map", "models/house.mtl", "models/house.obj", "pictures/grey.tif", "pictures/cube.img",
                   "pictures/cube.hdr"))


def whole():
    needed = make_scene("from/all")
    result = run("pack", "all/all.scene", "-o", "../all.tar", folder="from")
    check(result.returncode == 0 and not result.stdout and not result.stderr, "a scene is packed", result.stderr)
    with tarfile.open(os.path.join(HOME, "all.tar")) as archive:
        members = archive.getmembers()
        check(sorted(member.name for member in members) == [f"all/{name}" for name in needed], "the archive has the files that the scene needs, once",
              sorted(member.name for member in members))
        check(all(archive.extractfile(member).read() == read("from", member.name) for member in members), "each has its bytes")
        check({(member.mode, member.uid, member.gid, member.mtime, member.uname) for member in members} == {(0o644, 0, 0, 0, "")},
              "no date, owner or mode is stored")
    run("render", "all/all.scene", "-o", "all.tif", "-q", folder="from")
    for name, words in (("tar", ["tar", "xf"]), ("busybox", ["busybox", "tar", "xf"])):
        os.makedirs(os.path.join(HOME, name))
        unpacked = subprocess.run([*words, "../all.tar"], check=False, cwd=os.path.join(HOME, name), stderr=subprocess.PIPE)
        drawn = run("render", "all/all.scene", "-o", "all.tif", "-q", folder=name)
        check(unpacked.returncode == 0 and not unpacked.stderr and drawn.returncode == 0 and read(name, "all.tif") == read("from", "all.tif"),
              f"{name} unpacks it, and the stack is the same to the last byte", unpacked.stderr, drawn.stderr)


def same():
    """Another machine, another day, other ways to name the scene."""
    one = read("all.tar")
    shutil.copytree(os.path.join(HOME, "from", "all"), os.path.join(HOME, "copy", "all"))
    for path, _, names in os.walk(os.path.join(HOME, "copy")):
        for name in names:
            os.utime(os.path.join(path, name), (1e9, 1e9))
            os.chmod(os.path.join(path, name), 0o600)
    for words, folder in ((("all/all.scene",), "copy"), (("all.scene",), "copy/all"), (("./all.scene",), "copy/all"), (("../all/all.scene",), "copy/parts"),
                          ((os.path.join(HOME, "copy/all/all.scene"),), "")):
        os.makedirs(os.path.join(HOME, folder), exist_ok=True)
        result = run("pack", *words, "-o", "-", folder=folder)
        check(result.returncode == 0 and result.stdout == one, f"the same archive by {words[0].replace(HOME, '')} in {folder or 'another folder'}",
              result.stderr)
    run("pack", "all.scene", folder="copy/all")
    check(read("copy/all/all.tar") == one, "the archive has the scene's name")
    put("copy/all/tables/paint.csv", "400,0.5\n700,0.71\n")
    check(run("pack", "all.scene", "-o", "-", folder="copy/all").stdout != one, "another table makes another archive")


def record():
    """A stack records the files, as sha256sum prints them."""
    printed = run("info", "all.tif", folder="from").stdout.decode()
    found = {path: digest for digest, path in re.findall(r"^file +([0-9a-f]{64}) (.*)$", printed, re.MULTILINE)}
    names = {re.sub(r"^all/parts/\.\./", "all/", path): digest for path, digest in found.items()}
    wanted = [name for name in make_scene("again") if not name.endswith((".scene", ".map"))]
    check(sorted(names) == [f"all/{name}" for name in wanted], "info lists the files of the scene, whose text has a digest of its own", sorted(names))
    check(all(digest == hashlib.sha256(read("from", path)).hexdigest() for path, digest in names.items()), "each with its SHA-256")
    run("render", "room", "--size", "30x20", "-o", "room.tif", "-q")
    check(b"\nfile " not in run("info", "room.tif").stdout, "a scene of built-in files has none")


def spared():
    """No output replaces a file of the scene."""
    for name in ("tables/paint.csv", "pictures/cube.img", "models/house.obj", "parts/lights.scene"):
        before = read("from/all", name)
        for command in ("render", "pack"):
            result = run(command, "all.scene", "-o", name, folder="from/all")
            check(result.returncode == 2 and b"would replace the input" in result.stderr and read("from/all", name) == before,
                  f"{command} does not replace {name}", result.stderr)


def refusals():
    put("out/table.csv", "400,0.5\n700,0.7\n")
    for what, text, expected in (("a file outside of the folder", "diffuse ../out/table.csv", b"in/../out/table.csv is not below the folder of the scene"),
                                 ("a path from / on", f"diffuse {HOME}/out/table.csv", b"/out/table.csv is not below the folder of the scene"),
                                 ("a missing table", "diffuse no.csv", b"in/refused.scene:3:22: error: no built-in spectrum and no file 'no.csv'"),
                                 ("a missing texture", "diffuse 1 texture no.tif", b"no.tif")):
        put("in/refused.scene", f"size 8 8\nlight d65 1 direction 0 0 1\nmaterial m {{ {text} }}\nobject sphere 1 material m\n")
        for scene in ("in/refused.scene", os.path.join(HOME, "in/refused.scene")):
            result = run("pack", scene, "-o", "refused.tar")
            check(result.returncode == 2 and expected in result.stderr.replace(b"/./", b"/") and result.stderr.count(b"\n") == 1 and
                  not os.path.exists(os.path.join(HOME, "refused.tar")), f"refused: {what}", result.stderr)
    for words, expected in (((), b"pack needs SCENE"), (("-",), b"reads no standard input"), (("room",), b"room is built in"), (("nothing.scene",), b"no file"),
                            (("from/all.tif",), b"is a TIFF file, not a scene")):
        result = run("pack", *words)
        check(result.returncode == 2 and expected in result.stderr and result.stderr.count(b"\n") == 1, f"refused: pack {' '.join(words)}", result.stderr)
    os.symlink("tables/paint.csv", os.path.join(HOME, "from/all/link.csv"))
    put("from/all/link.scene", "size 8 8\nlight d65 1 direction 0 0 1\nmaterial m { diffuse link.csv }\nobject sphere 1 material m\n")
    result = run("pack", "link.scene", "-o", "-", folder="from/all")
    with tarfile.open(fileobj=io.BytesIO(result.stdout)) as archive:
        check(archive.extractfile("link/link.csv").read() == read("from/all/tables/paint.csv"), "a link becomes the file that it leads to")


def full_disk():
    limited = run("pack", "from/all/all.scene", "-o", "limited.tar", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)))
    check(limited.returncode == 3 and limited.stderr.count(b"\n") == 1 and not os.path.exists(os.path.join(HOME, "limited.tar")),
          "a full disk leaves no archive", limited.stderr)
    check(run("pack", "from/all/all.scene", "-o", "/dev/full").returncode == 3, "nor does /dev/full pass")


def moved():
    """A part on a machine that lacks a file says so."""
    os.remove(os.path.join(HOME, "tar/all/pictures/grey.tif"))
    result = run("render", "all/all.scene", "--part", "1/2", "-o", "all.tif", "-q", folder="tar")
    check(result.returncode == 2 and b"all/all.scene:7:" in result.stderr and b"pictures/grey.tif" in result.stderr, "a part names the file that it lacks",
          result.stderr)
    run("render", "all/all.scene", "--part", "1/2", "-o", "parts.tif", "-q", folder="from")
    put("busybox/all/tables/paint.csv", "400,0.5\n700,0.71\n")
    run("render", "all/all.scene", "--part", "2/2", "-o", "parts.tif", "-q", folder="busybox")
    shutil.copy(os.path.join(HOME, "busybox/parts.tif.2-of-2.part"), os.path.join(HOME, "from"))
    result = run("join", "parts.tif", folder="from")
    check(result.returncode == 2 and result.stderr.startswith(b"error: parts.tif: part 1 has 'file: ") and result.stderr.count(b"\n") == 1,
          "parts whose files differ are not joined", result.stderr)


shutil.rmtree(TMP, ignore_errors=True)
os.makedirs(TMP)
whole()
same()
record()
spared()
refusals()
full_disk()
moved()
done()
