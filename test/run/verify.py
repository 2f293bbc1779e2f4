#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile python3-junitparser libosmesa6-dev; makes: faults spoil
"""Runs spectral verify: its verdicts are those of render, JUnit's XML is read by a real reader, a baseline parts known
failures from new ones, planted faults are found on each library and reduced to a case that fails by itself, and a driver
that crashes does not end the run. With FULL, more faults are reduced. Prints TAP."""
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time

from junitparser import JUnitXml

sys.dont_write_bytecode = True
from rendered import SPECTRAL, TMP, check, done, write

SPOIL = os.path.abspath(os.environ.get("SPOIL_LIBRARY", "build/test/spoil.so"))
FAULTS = os.path.abspath(os.environ.get("FAULTS", "build/test/fault.so"))
LLVMPIPE = ("--gl", "osmesa", "--renderer", "llvmpipe")


def run(*words, program=SPECTRAL, **environment):
    return subprocess.run([program, *words], check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, env={**os.environ, **environment})


def path(name):
    return os.path.join(TMP, name)


def remove(*names):
    for name in names:
        if os.path.exists(path(name)):
            os.remove(path(name))


def four_drivers():
    remove("four.xml", "four.json")
    scenes = ("patches", "spheres", "hard/mirror")
    result = run("verify", *scenes, "--junit", path("four.xml"), "--json", path("four.json"))
    check(result.returncode == 0 and result.stderr == "", "three scenes agree on all drivers", result.stdout, result.stderr)
    heads = re.findall(r"^--gl (\S+)(?: --renderer (\S+))?: ([^\s,]+).*, by (\S+), bounds of (\S+)$", result.stdout, re.MULTILINE)
    drawn = {(library, renderer.split(":")[0] if "shader" in renderer else "", by, name)
             for library, renderer, name, by, bounds in heads if name == bounds}
    check({(gl, way, by, name) for name in ("llvmpipe", "softpipe") for gl, by, ways in (("osmesa", "OSMesa", ("",)), ("egl", "EGL", (
        "", "gl-shader", "es-shader"))) for way in ways} <= drawn, "these are OSMesa and EGL with llvmpipe and softpipe, and their shaders", heads)
    check(len(drawn) == len(heads) and result.stdout.count("\n  3 of 3 scenes agree\n") == len(heads), "each driver once", result.stdout)
    with open(path("four.json")) as file:
        report = json.load(file)
    for driver in report["drivers"]:
        for found in driver["scenes"]:
            scene = found["scene"]
            words = ["builtin:hard/mirror.scene"] if "/" in scene else [scene, "--size", "300x200", "--wavelengths", "400:700:10"]
            words += ["--gl", driver["gl"]] + (["--renderer", driver["renderer"]] if driver["renderer"] else [])
            alone = json.loads(run("render", *words, "-o", "/dev/null", "--json", "-").stdout)["check"]
            check(all(found[key] == alone[key] for key in ("samples", "pixels", "ambiguous_pixels", "unexplained_pixels", "max_counts",
                                                           "worst_error_over_bound")),
                  f"{driver['gl']} {driver['gl_renderer'].split()[0]}: the figures of {scene} are those of render", found, alone)
    suites = list(JUnitXml.fromfile(path("four.xml")))
    check(len(suites) == len(heads) and all((s.tests, s.failures, s.errors) == (3, 0, 0) and [c.name for c in s] == list(scenes) and
                                            all(c.time > 0 for c in s) for s in suites), "JUnit has a suite a driver, a case a scene")
    check({p.name: p.value for p in suites[0].properties()}["gl_library"] == "OSMesa", "a suite's properties name the library")


def everything():
    result = run("verify", *LLVMPIPE)
    count = re.search(r"^  (\d+) of (\d+) scenes agree$", result.stdout, re.MULTILINE)
    check(result.returncode == 0 and count and count.group(1) == count.group(2) and int(count.group(1)) > 100 and
          re.search(r"^  \d\d hard cases +agreed", result.stdout, re.MULTILINE), "all built-in scenes and hard cases agree", result.stdout)


def failures():
    remove("fault.xml")
    result = run("verify", "patches", "hard/mirror", *LLVMPIPE, "--junit", path("fault.xml"), "--strict", FAULT="5", LD_PRELOAD=FAULTS)
    check(result.returncode == 1 and result.stderr == "error: 2 of 2 pictures differ, or are not verified\n", "a fault in all pictures",
          result.stderr)
    suite = next(iter(JUnitXml.fromfile(path("fault.xml"))))
    messages = [entry.message for case in suite for entry in case.result]
    check((suite.tests, suite.failures, suite.errors) == (2, 2, 0) and all(re.match(r"the pictures differ at \d+ of \d+ pixels, first at ", m)
                                                                           for m in messages), "JUnit has the first pixel", messages)
    commands = re.findall(r"^  spectral (.*)$", result.stdout.split("to repeat what failed:\n")[1], re.MULTILINE)
    check(len(commands) == 2, "each failure has a command", result.stdout)
    for command, message in zip(commands, messages):
        again = run(*shlex.split(command), FAULT="5", LD_PRELOAD=FAULTS)
        check(again.returncode == 1 and message in again.stderr and "--strict" in command, f"it repeats the failure: {command}", again.stderr)


def baselines():
    remove("base.txt")
    words = ("verify", "patches", "hard/mirror", *LLVMPIPE, "--baseline", path("base.txt"))
    check(run(*words).returncode == 2, "a missing baseline is refused")
    check(run(*words, "--update-baseline").returncode == 0, "a baseline is written")
    lines = open(path("base.txt")).read().splitlines()
    check(len(lines) == 3 and re.fullmatch(r'"OSMesa" "llvmpipe .*" "patches" agreed 0', lines[1]), "it has a line a scene", lines)
    check(run(*words).returncode == 0, "nothing has changed")
    result = run(*words, FAULT="5", LD_PRELOAD=FAULTS)
    check(result.returncode == 1 and "2 results are not as in" in result.stderr and
          re.search(r"^patches --gl osmesa --renderer llvmpipe: differs, \d+ pixels not explained; in the baseline agreed, 0 pixels$",
                    result.stdout, re.MULTILINE), "new failures fail", result.stdout, result.stderr)
    check(run(*words, "--update-baseline", FAULT="5", LD_PRELOAD=FAULTS).returncode == 0, "the failures are taken into the baseline")
    check(run(*words, FAULT="5", LD_PRELOAD=FAULTS).returncode == 0, "known failures do not fail")
    result = run(*words)
    check(result.returncode == 1 and "; in the baseline differs, " in result.stdout, "a failure that is gone is a difference, too", result.stdout)
    with open(path("base.txt"), "a") as file:
        file.write('"OSMesa" "llvmpipe" "patches" wrong 0\n')
    result = run(*words)
    check(result.returncode == 2 and re.match(re.escape(path("base.txt")) + r":4:31: error: ", result.stderr), "a wrong line is refused at its place",
          result.stderr)


def size_of(folder):
    text = open(os.path.join(folder, "case.scene")).read()
    triangles = sum(line.startswith("f ") for name in os.listdir(folder) if name.endswith(".obj") for line in open(os.path.join(folder, name)))
    return triangles, len(re.search("^wavelengths list (.*)$", text, re.MULTILINE).group(1).split())


def reduced(name, words, environment):
    """Reduces a failure. Its case fails again, and agrees without the fault."""
    folder = path(f"case-{name}")
    subprocess.run(["rm", "-rf", folder], check=True)
    result = run("verify", *words, "--reduce", folder, **environment)
    check(result.returncode == 1 and os.path.exists(f"{folder}/README.txt"), f"{name}: a fault is found, and reduced", result.stdout, result.stderr)
    triangles, bands = size_of(folder)
    check(triangles <= 3 and bands <= 2, f"{name}: to {triangles} triangles and {bands} wavelengths")
    driver = words[words.index("--gl"):]
    again = run("render", f"{folder}/case.scene", *driver, "-o", "/dev/null", **environment)
    readme = open(f"{folder}/README.txt").read()
    message = again.stderr[len("error: "):].split("; no stack")[0]
    check(again.returncode == 1 and message in readme and "Why no rounding explains it" in readme,
          f"{name}: the case fails by itself, as its README says", again.stderr, readme)
    check(run("verify", f"{folder}/case.scene", *driver, **environment).returncode == 1, f"{name}: verify finds it in the case")
    check(run("render", f"{folder}/case.scene", *driver, "-o", "/dev/null").returncode == 0, f"{name}: without the fault the case agrees")
    result = run("verify", *words, "--reduce", folder, **environment)
    check(result.returncode == 2 and "exists already" in result.stderr, f"{name}: an existing folder is refused", result.stderr)


def reductions():
    faults = {"FAULT": "1", "LD_PRELOAD": FAULTS}
    reduced("triangle", ("colorchecker", *LLVMPIPE), faults)
    if os.environ.get("FULL"):
        reduced("band", ("fluorescence", *LLVMPIPE), {**faults, "FAULT": "65"})
        reduced("lights", ("metals", *LLVMPIPE), {**faults, "FAULT": "52"})
    for driver in ("llvmpipe", "softpipe") if os.environ.get("FULL") else ("llvmpipe",):
        reduced(f"egl-{driver}", ("room", "--gl", "egl", "--renderer", driver), {"SPOIL": "diffuse", "LD_PRELOAD": SPOIL})
    own = write("own.scene", """wavelengths 400 700 100
size 90 60
camera perspective 40 eye 0 0 6
light d65*0.5 1 position 2 2 5 spot 0 0 -1 60 2
light blackbody:3000 0.5 direction 0 1 1
ambient gaussian:550,80 0.1
material m { diffuse 0.6 specular 0.3 gloss 20 texture checks }
material n { diffuse 0.3 metamer m }
checker materials.list torus 0.3 0.6 8 12
object sphere 0.8 12 8 material m two-sided rotate 30 0 1 0 scale 1 -1.2 1 translate -1 0 0
object mesh chair materials own.map translate 1 0 0
""")
    write("own.map", "* material n\n")
    write("materials.list", "builtin:materials/metals/gold.txt\nbuiltin:materials/metals/copper.txt\n")
    reduced("own", (own, *LLVMPIPE), {"SPOIL": "diffuse", "LD_PRELOAD": SPOIL})


def crashes():
    remove("crash.xml")
    result = run("verify", "textures", "patches", "--gl", "egl", "--junit", path("crash.xml"), SPOIL="crash", LD_PRELOAD=SPOIL)
    check(result.returncode == 1 and re.search(r"^  textures +failed +\n    a run ended without a result: Segmentation fault$", result.stdout, re.MULTILINE)
          and re.search(r"^  patches +agreed", result.stdout, re.MULTILINE), "a crash is a result, and the next scene is drawn", result.stdout, result.stderr)
    suite = next(iter(JUnitXml.fromfile(path("crash.xml"))))
    check((suite.tests, suite.failures, suite.errors) == (2, 0, 1), "in JUnit it is an error")


def refusals():
    for words, status, pattern in ((("nosuch",), 2, "no file nosuch"), (("--update-baseline",), 2, "--baseline FILE"),
                                   (("--renderer", "raster"), 2, "needs no verification"), (("--gl", "egl:60"), 3, "there is no egl:60")):
        result = run("verify", "patches" if words[0].startswith("-") else "spheres", *words)
        check(result.returncode == status and result.stderr.count("\n") == 1 and re.search(pattern, result.stderr), f"refused: {' '.join(words)}",
              result.stderr)
    remove("stopped.json")
    process = subprocess.Popen([SPECTRAL, "verify", "--json", path("stopped.json")], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    time.sleep(1.5)
    process.send_signal(signal.SIGINT)
    start = time.monotonic()
    process.communicate()
    check(process.returncode != 0 and time.monotonic() - start < 5 and not os.path.exists(path("stopped.json")), "an interruption ends it, without a file")


four_drivers()
everything()
failures()
baselines()
reductions()
crashes()
refusals()
done()
