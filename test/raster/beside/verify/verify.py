#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile python3-junitparser libosmesa6-dev; makes: faults spoil
"""Runs spectral verify: its verdicts are those of render, JUnit's XML is read by real readers, planted faults are found, the
commands that it prints repeat them, and a driver that crashes does not end the run. Prints TAP."""
import json
import os
import re
import shlex
import signal
import subprocess
import time
import xml.etree.ElementTree

from junitparser import JUnitXml

import documents
from rendered import FAULTS, SPECTRAL, SPOIL, TMP, check, done, path_of, refuses, remove, run, write

LLVMPIPE = ("--gl", "osmesa", "--renderer", "llvmpipe")


def four_drivers():
    remove(path_of("four.xml"), path_of("four.json"))
    scenes = ("patches", "spheres", "hard/mirror")
    result = run("verify", *scenes, "--junit", path_of("four.xml"), "--json", path_of("four.json"))
    check(result.returncode == 0 and result.stderr == "", "three scenes agree on all drivers", result.stdout, result.stderr)
    heads = re.findall(r"^--gl (\S+)(?: --renderer (\S+))?: ([^\s,]+).*, by (\S+), bounds of (\S+)$", result.stdout, re.MULTILINE)
    drawn = {(library, renderer.split(":")[0] if "shader" in renderer else "", by, name)
             for library, renderer, name, by, bounds in heads if name == bounds}
    check({(gl, way, by, name) for name in ("llvmpipe", "softpipe") for gl, by, ways in (("osmesa", "OSMesa", ("",)), ("egl", "EGL", (
        "", "gl-shader", "es-shader"))) for way in ways} <= drawn, "these are OSMesa and EGL with llvmpipe and softpipe, and their shaders", heads)
    check(len(drawn) == len(heads) and result.stdout.count("\n  3 of 3 scenes agree\n") == len(heads), "each driver once", result.stdout)
    with open(path_of("four.json")) as file:
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
    suites = list(JUnitXml.fromfile(path_of("four.xml")))
    check(len(suites) == len(heads) and all((s.tests, s.failures, s.errors) == (3, 0, 0) and [c.name for c in s] == list(scenes) and
                                            all(c.time > 0 for c in s) for s in suites), "JUnit has a suite a driver, a case a scene")
    check({p.name: p.value for p in suites[0].properties()}["gl_library"] == "OSMesa", "a suite's properties name the library")


def everything():
    result = run("verify", *LLVMPIPE)
    count = re.search(r"^  (\d+) of (\d+) scenes agree$", result.stdout, re.MULTILINE)
    check(result.returncode == 0 and count and count.group(1) == count.group(2) and int(count.group(1)) > 100 and
          re.search(r"^  \d+ hard cases +agreed", result.stdout, re.MULTILINE), "all built-in scenes and hard cases agree", result.stdout)


def failures():
    remove(path_of("fault.xml"))
    result = run("verify", "patches", "hard/mirror", *LLVMPIPE, "--junit", path_of("fault.xml"), "--strict", FAULT="5", LD_PRELOAD=FAULTS)
    check(result.returncode == 1 and result.stderr == "error: 2 of 2 pictures differ, or are not verified\n", "a fault in all pictures",
          result.stderr)
    suite = next(iter(JUnitXml.fromfile(path_of("fault.xml"))))
    messages = [entry.message for case in suite for entry in case.result]
    check((suite.tests, suite.failures, suite.errors) == (2, 2, 0) and all(re.match(r"the pictures differ at \d+ of \d+ pixels, first at ", m)
                                                                           for m in messages), "JUnit has the first pixel", messages)
    commands = re.findall(r"^  spectral (.*)$", result.stdout.split("to repeat what failed:\n")[1], re.MULTILINE)
    check(len(commands) == 2, "each failure has a command", result.stdout)
    for command, message in zip(commands, messages):
        again = run(*shlex.split(command), FAULT="5", LD_PRELOAD=FAULTS)
        check(again.returncode == 1 and message in again.stderr and "--strict" in command, f"it repeats the failure: {command}", again.stderr)


def names():
    """A name may have blanks, quotes, and bytes that are no UTF-8."""
    scene = os.fsencode(path_of("it's a \"b\" & <c> ")) + b"\xff\x01.scene"
    with open(scene, "wb") as file, open("data/builtin/hard/mirror.scene", "rb") as mirror:
        file.write(mirror.read())
    result = run("verify", scene, *LLVMPIPE, "--unchecked", "0", "--junit", path_of("names.xml"), "--quiet", FAULT="5", LD_PRELOAD=FAULTS)
    case = xml.etree.ElementTree.parse(path_of("names.xml")).find("testsuite/testcase")
    check(result.returncode == 1 and case.get("name").endswith("it's a \"b\" & <c> ??.scene"), "XML has a scene's name, if not its strange bytes",
          case.attrib, result.stderr)
    os.rename(scene, path_of("it's a \"b\".scene"))
    result = run("verify", path_of("it's a \"b\".scene"), *LLVMPIPE, "--ambient", "d65*0.5", FAULT="5", LD_PRELOAD=FAULTS)
    command = result.stdout.split("to repeat what failed:\n  spectral ")[1]
    again = subprocess.run(["sh", "-c", f"{shlex.quote(SPECTRAL)} {command}"], check=False, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                           universal_newlines=True, env={**os.environ, "FAULT": "5", "LD_PRELOAD": FAULTS})
    check(again.returncode == 1 and again.stderr.startswith("error: the pictures differ at "), "a shell repeats the failure of such a scene", command,
          again.stderr)


def nothing_checked():
    """A scene without objects has no object pixels: there is no floor and no share."""
    empty = write("empty.scene", "wavelengths 400 700 100\nsize 30 20\nlight d65 1 direction 0 0 1\n")
    result = run("verify", empty, *LLVMPIPE, "--json", path_of("empty.json"))
    with open(path_of("empty.json")) as file:
        found = json.load(file)["drivers"][0]["scenes"][0]
    check(found["verdict"] == "agreed" and found["object_pixels"] == 0 and all(found[key] is None for key in (
        "worst_error_over_bound", "floor_median", "floor_99_9", "checked_within_1", "checked_within_8", "checked_within_256")),
        "JSON says null where nothing was checked", found)
    check(re.search(r"^  \S*empty.scene +agreed +- +- +- +- +- +600 ", result.stdout, re.MULTILINE), "and the table has no figure there", result.stdout)


def compared():
    """The recipe of the page finds what has changed, and passes over what has not."""
    recipe = re.search(r"^verdicts\(\).*?(?=^```$)", documents.read("verification.md"), re.MULTILINE | re.DOTALL).group(0)
    before, after = recipe.replace("--gl egl", "--gl osmesa --renderer llvmpipe").rsplit("\n", 2)[:2]
    definition = before.splitlines()[0]
    fault = f"export FAULT=5 LD_PRELOAD={FAULTS}\n"
    for name, first, second, status in (("nothing", "", "", 0), ("a new failure", "", fault, 1), ("a known failure", fault, fault, 0),
                                        ("a failure that is gone", fault, "", 1)):
        subprocess.run(["sh", "-c", first + before], check=True, cwd=TMP, stderr=subprocess.DEVNULL)
        result = subprocess.run(["sh", "-c", second + definition + "\n" + after], check=False, cwd=TMP, stdout=subprocess.PIPE,
                                stderr=subprocess.DEVNULL, universal_newlines=True)
        check(result.returncode == status and bool(result.stdout) == bool(status), f"diff of two tables finds {name}", result.stdout)


def crashes():
    remove(path_of("crash.xml"))
    result = run("verify", "textures", "patches", "--gl", "egl", "--junit", path_of("crash.xml"), SPOIL="crash", LD_PRELOAD=SPOIL)
    check(result.returncode == 1 and re.search(r"^  textures +failed +\n    a run ended without a result: Segmentation fault$", result.stdout, re.MULTILINE)
          and re.search(r"^  patches +agreed", result.stdout, re.MULTILINE), "a crash is a result, and the next scene is drawn", result.stdout, result.stderr)
    suite = next(iter(JUnitXml.fromfile(path_of("crash.xml"))))
    check((suite.tests, suite.failures, suite.errors) == (2, 0, 1), "in JUnit it is an error")


def refusals():
    refuses("a device that is missing", "there is no egl:60", "verify", "patches", "--gl", "egl:60", status=3)
    remove(path_of("stopped.json"))
    process = subprocess.Popen([SPECTRAL, "verify", "--json", path_of("stopped.json")], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    time.sleep(1.5)
    process.send_signal(signal.SIGINT)
    start = time.monotonic()
    process.communicate()
    check(process.returncode != 0 and time.monotonic() - start < 5 and not os.path.exists(path_of("stopped.json")), "an interruption ends it, without a file")


four_drivers()
everything()
failures()
names()
nothing_checked()
documents.put_in_path()
compared()
crashes()
refusals()
done()
