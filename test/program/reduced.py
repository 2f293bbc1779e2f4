#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile libosmesa6-dev; makes: faults spoil
"""Runs data/samples/reduce.py on planted faults: the scene that it leaves is small, fails with the fault and agrees without
it; the program in C compiles by one line, and says the same about OpenGL as the scene does. Prints TAP."""
import os
import re
import shutil
import subprocess
import sys

from rendered import FAULTS, SPECTRAL, SPOIL, TMP, bytes_of, check, done, write

SCRIPT = os.path.abspath("data/samples/reduce.py")
SMALL = ("--size", "150x100", "--wavelengths", "400:700:20")


def run(*words, **environment):
    return subprocess.run(words, check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
                          env={**os.environ, "SPECTRAL": os.path.abspath(SPECTRAL), **environment})


def shows(name, folder, libraries, options, environment):
    """Builds case.c by its line. It must find the fault, and none without it."""
    program = os.path.join(folder, "a.out")
    built = run("gcc", "-Wall", "-Wextra", "-Werror", *options, os.path.join(folder, "case.c"), *libraries, "-lm", "-o", program)
    check(built.returncode == 0, f"{name}: case.c compiles without a warning", built.stderr)
    wrong, right = run(program, **environment), run(program)
    pattern = r"pixel \d+,\d+: expected (not )?[-\d.e+]+, found [-\d.e+]+, bound [\d.e+-]+ \S"
    check(wrong.returncode == 1 and re.match(pattern, wrong.stdout), f"{name}: it finds that this OpenGL is wrong", wrong.stdout, wrong.stderr)
    check(right.returncode == 0 and re.match(pattern, right.stdout), f"{name}: it finds that OpenGL is right without the fault", right.stdout,
          right.stderr)


def reduced(name, scene, *options, egl=False, **environment):
    """Reduces a scene. Returns the text of the small one."""
    folder = os.path.join(TMP, f"{name}'s case")
    shutil.rmtree(folder, ignore_errors=True)
    result = run(sys.executable, SCRIPT, scene, folder, *options, **environment)
    check(result.returncode == 0 and os.path.exists(f"{folder}/case.scene"), f"{name}: the scene is made small", result.stdout, result.stderr)
    small = os.path.join(folder, "case.scene")
    text = bytes_of(small).decode()
    wavelengths, size = (re.search(f"^{word} (.*)$", text, re.MULTILINE).group(1).split() for word in ("wavelengths list", "size"))
    check(len(wavelengths) <= 2 and int(size[0]) * int(size[1]) <= 60, f"{name}: to two wavelengths and 60 pixels at most", text)
    command = re.search(r"^    .*spectral.* render .*$", result.stdout, re.MULTILINE).group(0)
    wrong, right = run("sh", "-c", command, **environment), run("sh", "-c", command)
    message = result.stdout.splitlines()[0]
    check(wrong.returncode == 1 and message in wrong.stderr.replace(folder + "/", ""), f"{name}: it fails by the command that is printed",
          command, wrong.stderr)
    check(right.returncode == 0, f"{name}: it agrees without the fault", right.stderr)
    lines = bytes_of(os.path.join(folder, "case.c")).count(b"\n")
    check(lines <= 200, f"{name}: case.c has at most 200 lines", lines)
    shows(name, folder, ["-lOSMesa"], [], environment)
    if egl:
        shows(f"{name} by EGL", folder, ["-lEGL", "-lGL"], ["-DEGL"], environment)
    return text


def own_scene():
    """A scene of many words, and files that name others."""
    write("lights.inc", "light d65*0.5 1 position 2 2 5 spot 0 0 -1 60 2\nlight blackbody:3000 0.5 direction 0 1 1\n")
    write("own red.csv", "400,0.1\n700,0.7\n")
    write("own.map", "* material n  # all parts\n")
    write("materials.list", "builtin:materials/metals/gold.txt\nbuiltin:materials/metals/copper.txt\n")
    return write("own.scene", """wavelengths 400 700 100
size 90 60
camera perspective 40 eye 0 0 6
include lights.inc
ambient gaussian:550,80 0.1
material m { diffuse "own red.csv*0.6" specular 0.3   # a file with a blank in its name
    gloss 20 texture checks }
material n { diffuse 0.3 metamer m }
checker materials.list torus 0.3 0.6 8 12
object sphere 0.8 12 8 material m two-sided rotate 30 0 1 0 scale 1 -1.2 1 translate -1 0 0
object mesh chair materials own.map translate 1 0 0
""")


def refusals():
    folder = os.path.join(TMP, "none")
    result = run(sys.executable, SCRIPT, "patches", folder, *SMALL)
    check(result.returncode == 1 and result.stderr.startswith("reduce.py: patches does not differ: ") and not os.path.exists(folder),
          "a scene that agrees is refused", result.stderr)
    os.makedirs(folder)
    result = run(sys.executable, SCRIPT, "patches", folder, *SMALL)
    check(result.returncode == 1 and result.stderr.count("\n") == 1 and "exists already" in result.stderr, "a folder is not replaced", result.stderr)
    os.rmdir(folder)


fault = {"LD_PRELOAD": FAULTS}
reduced("triangle", "test/cases/faults/crumb.scene", FAULT="2", **fault)
reduced("fragments", "colorchecker", *SMALL, FAULT="1", **fault)
reduced("softpipe", "patches", *SMALL, "--renderer", "softpipe", FAULT="15", **fault)
reduced("depth", "test/cases/faults/edge.scene", FAULT="69", **fault)
reduced("band", "fluorescence", *SMALL, FAULT="65", **fault)
reduced("lights", "test/cases/faults/lights.scene", FAULT="52", **fault)
kept = reduced("own", own_scene(), egl=True, SPOIL="diffuse", LD_PRELOAD=SPOIL)
check(kept.count("\nobject ") + kept.count("\nchecker ") == 1, "one object is left of the scene with many", kept)
if os.environ.get("FULL"):
    reduced("fluorescence", "fluorescence", "--gl", "egl", *SMALL, egl=True, SPOIL="diffuse", LD_PRELOAD=SPOIL)
refusals()
done()
