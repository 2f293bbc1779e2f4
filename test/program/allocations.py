#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full release; packages: python3-numpy python3-tifffile python3-pil; makes: fail
"""Lets each of the first 500 allocations of the program and of libtiff fail, one a run, in commands that read files of all kinds: a
PNG texture, tables, a CGATS set, an MTL file, a stack. Each run ends with the right result, or with status 3 and a line that names
memory. Without SOAK=1 (`test release`) every seventh allocation fails. See test/program/fail.c."""
import concurrent.futures
import os
import random
import re
import shutil

from PIL import Image, PngImagePlugin

from rendered import amount, FAIL, bytes_of, check, done, output_of, path_of, run, write

MOST = 500
STEP = amount(7, 7, 1)
SMALL = "--size", "12x8", "--wavelengths", "400:700:100"
SCENE = """wavelengths 400 700 100
size 12 8
camera ortho 4
light r.csv:a 1 direction 0 1 2
light d65 0.4 direction 1 1 1 shadows
light daylight:5000 0.1 direction 0 0 1
material m { diffuse r.csv:b texture t.png linear }
material n { diffuse set.ti3:A2 }
material p { diffuse 0.2 donaldson d.csv }
object plane 2 2 2 material m
object sphere 0.5 8 6 material n translate 1 0 1
object box 1 1 1 material p translate -1 0 1
object mesh a.obj materials a.map
"""
SCENE_PATH, SET, STACK, EXPORTED = (path_of(name) for name in ("a.scene", "set.ti3", "a.tif", "exported"))
COMMANDS = {  # words; {} stands for an output
    "plan": ["plan", SCENE_PATH, "--json", "{}"],
    "render by the reference": ["render", SCENE_PATH, "--renderer", "raster", "--no-check", "-q", "-j", "1", "-o", "{}.tif"],
    "render with a check": ["render", SCENE_PATH, "-q", "-j", "1", "--unchecked", "1", "-o", "{}.tif", "--check-map", "{}.png"],
    "develop": ["develop", STACK, "-q", "-o", "{}.png"],
    "develop for a camera": ["develop", STACK, "-q", "--raw", "--detector", path_of("camera.csv"), "-o", "{}.tif"],
    "probe": ["probe", STACK, "3", "3", "-o", "{}"],
    "probe objects": ["probe", STACK, "--objects", "--csv", "-o", "{}"],
    "compare": ["compare", STACK, STACK, "--white", "d65", "--map", "{}.tif"],
    "list a set": ["list", SET],
    "show spectra": ["show", path_of("r.csv") + ":a", SET + ":A1", "--csv", "-o", "{}"],
    "info": ["info", path_of("t.png")],
    "info of a stack": ["info", STACK, "--json", "{}"],
    "view a stack": ["view", STACK, "-o", "{}.html"],
    "export": ["export", SCENE_PATH, "-o", "{}"],
    "judge": ["judge", EXPORTED, "-q", "--check-map", "{}.tif"],
}


WITHOUT_TIFF = "plan", "list a set", "show spectra", "info", "export"  # here nothing may crash; elsewhere libtiff does: see trust.md


def files():
    picture, words = Image.new("RGB", (24, 16)), PngImagePlugin.PngInfo()
    picture.putdata([(random.Random(i).randrange(256),) * 3 for i in range(24 * 16)])
    words.add_text("Description", "a texture")
    picture.save(path_of("t.png"), pnginfo=words)
    write("a.scene", SCENE)
    write("r.csv", "wavelength,a,b\n400,0.2,0.3\n700,0.5,0.6\n")
    write("camera.csv", "nm,r,g,b\n400,0,0.1,0.9\n700,0.2,0,0\n")
    write("d.csv", "nm,700\n400,0.001\n500,0.002\n")
    write("set.ti3", "CTI3\nBEGIN_DATA_FORMAT\nSAMPLE_ID SPEC_400 SPEC_700\nEND_DATA_FORMAT\nBEGIN_DATA\nA1 0.2 0.3\nA2 0.4 0.5\nEND_DATA\n")
    write("m.mtl", "newmtl u\nKd 0.5 0.5 0.5\n")
    write("a.map", "u mtl m.mtl\n")
    write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl u\nf 1 2 3\n")
    output_of("render", SCENE_PATH, "-q", "-o", STACK, "--renderer", "raster", "--no-check")
    shutil.rmtree(EXPORTED, ignore_errors=True)
    output_of("export", SCENE_PATH, "-o", EXPORTED)


def tried(words, number):
    """Runs a command whose allocation of this number fails. Returns status, errors, and all that it wrote; files by their endings."""
    folder = path_of(f"out-{number}")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    attack = {"FAIL": f"own:{number}"} if number else {}
    result = run(*(word.replace("{}", os.path.join(folder, "out")) for word in words), text=False, LD_PRELOAD=FAIL, **attack)
    wrote = {name[len(folder):]: bytes_of(name)
             for name in sorted(os.path.join(at, name) for at, _, names in os.walk(folder) for name in names)}
    shutil.rmtree(folder)
    out = re.sub(rb'"(seconds|peak_memory_mib)": [^,}]*(\{[^}]*\})?', b"", result.stdout)
    return result.returncode, result.stderr.decode(errors="replace"), (out.replace(folder.encode(), b""), wrote)


def fault_of(name, words, right, number):
    status, says, wrote = tried(words, number)
    if status == 3:
        good = re.search("memory|MiB|libtiff|thread|shared object", says) and says.count("error:") == 1 and not wrote[1] and \
            not (name in WITHOUT_TIFF and "crashed" in says)
    else:
        good = status == right[0] and wrote == right[2]
    return None if good else f"FAIL=own:{number}: status {status}, {says[:300]}"


def main():
    files()
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, words in COMMANDS.items():
            right = tried(words, 0)
            if "judge" not in name:
                check(right[0] == 0, f"{name}: nothing fails", *right[:2])
            faults = [fault for fault in pool.map(lambda n: fault_of(name, words, right, n), range(1, MOST + 1, STEP)) if fault]
            check(not faults, f"{name}: allocations that fail", *faults[:5])
    done()


main()
