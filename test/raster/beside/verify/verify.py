#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile python3-junitparser libosmesa6-dev; makes: faults spoil
"""Runs spectral verify: its verdicts are those of render, JUnit's XML is read by real readers, planted faults are found, the
commands that it prints repeat them, what an earlier report knows passes, and whatever a driver does there is a report. Prints TAP."""
import json
import os
import re
import shlex
import signal
import subprocess
import time
import xml.etree.ElementTree

from junitparser import JUnitXml

from rendered import FAULTS, SPECTRAL, SPOIL, TMP, check, done, parts, path_of, refuses, remove, run, write

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
    check(len(drawn) == len(heads) and result.stdout.count("\n  agreed 3, differ 0, not verified 0, died 0\n") == len(heads), "each driver once", result.stdout)
    with open(path_of("four.json")) as file:
        report = json.load(file)
    for driver in report["drivers"]:
        for found in driver["scenes"]:
            scene = found["scene"]
            words = [scene] if "/" in scene else [scene, "--size", "300x200", "--wavelengths", "400:700:10"]
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
    listed = run("verify", "--list").stdout.split()
    result = run("verify", *LLVMPIPE)
    names = re.findall(r"^  (\S+) +agreed ", result.stdout, re.MULTILINE)
    check(result.returncode == 0 and names == listed and len(listed) > 100 and f"\n  agreed {len(listed)}, differ 0, not verified 0, died 0\n" in result.stdout,
          "all built-in scenes and hard cases agree, a line each, and --list names them", result.stdout)


def named():
    """Patterns of a shell, hard cases by name in each command, in their own size."""
    hard = re.findall(r"^  (hard/\S+)$", run("list", "hard").stdout, re.MULTILINE)
    for words, expected in (("hard/mirror*", [name for name in hard if name.startswith("hard/mirror")]), ("hard", hard), ("p*", ["pasture", "patches"]),
                            ("hard/mirror", ["hard/mirror"])):
        check(sorted(run("verify", "--list", words).stdout.split()) == sorted(expected) and expected, f"{words} names its scenes", expected)
    check("hard/" not in run("list").stdout, "a list of all does not have them")
    refuses("a pattern of nothing", "no file x\\* and no built-in scene of that name", "verify", "x*")
    for command in ("verify", "render"):
        refuses("a hard case that is not there", "did you mean hard/mirror\\?", command, "hard/miror")
    sizes = [json.loads(run("render", "hard/mirror", "-o", "/dev/null", "--json", "-", *words).stdout)["check"]["pixels"] for words in ((), ("--size", "9x9"))]
    report = json.loads(run("verify", "hard/mirror", "patches", *LLVMPIPE, "--size", "9x9", "--json", "-").stdout)
    check([scene["pixels"] for scene in report["drivers"][0]["scenes"]] == [sizes[0], 81] and sizes[1] == 81, "verify leaves a hard case its size", report)


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


def expected():
    """Known defects pass, new ones and worse ones fail, and what has gone away is said."""
    old, scenes = path_of("old.json"), ("patches", "spheres", "hard/mirror")
    fault = {"FAULT": "5", "LD_PRELOAD": FAULTS}

    def verify(*words, **environment):
        return run("verify", *scenes, *LLVMPIPE, *words, **environment)

    for name, first, second, status, words in (
            ("nothing", {}, {}, 0, ()), ("a new failure", {}, fault, 1, ("expected: agreed; this is worse",)), ("a known failure", fault, fault, 0, ()),
            ("a failure that is gone", fault, {}, 0, ("expected: differs; this is better",))):
        verify("--json", old, **first)
        result = verify("--expect", old, "--junit", path_of("expect.xml"), **second)
        said = re.findall("expected: .*", result.stdout)
        suites = JUnitXml.fromfile(path_of("expect.xml"))
        check(result.returncode == status and set(said) == set(words) and (suites.failures > 0) == (status == 1) and (
            suites.skipped > 0) == (first == second != {}), f"--expect finds {name}", result.stdout, result.stderr)
    with open(old) as file:
        text = file.read()
    with open(old, "w") as file:  # written anew by another program, with a scene less, and of another version
        report = json.loads(text)
        report["drivers"][0]["gl_version"] = 'the "old" one'
        del report["drivers"][0]["scenes"][0]
        json.dump(report, file, indent=4)
    result = verify("--expect", old, **fault)
    check(result.returncode == 1 and "error: 1 of 3 pictures are worse than in " in result.stderr and
          re.search("^then gl_version was 'the \"old\" one', now it is '.*Mesa", result.stdout, re.MULTILINE), "a scene that the report lacks is expected to agree; another version is named",
          result.stdout, result.stderr)
    refuses("a file that is no report", "is no report of verify --json", "verify", "patches", *LLVMPIPE, "--expect", "README.md")


def deaths():
    """Whatever a driver does, there is a report, and the exit status is 1."""
    for spoil, scenes, verdicts, words in (
            ("crash", ("textures", "patches"), ("failed", "agreed"), "a run ended without a result: Segmentation fault"),
            ("die", ("textures", "patches"), ("failed", "failed"), "a run ended without a result: Segmentation fault"),
            ("hang", ("textures", "patches"), ("failed", "agreed"), "a run had no result in its time"),
            ("start", ("textures", "patches"), ("failed", "failed"), "a run had no result in its time"),
            ("black", ("spheres", "patches"), ("differs", "differs"), "the pictures differ at ")):
        xml_path, json_path = path_of("dead.xml"), path_of("dead.json")
        remove(xml_path, json_path)
        start = time.monotonic()
        result = run("verify", *scenes, "--gl", "egl", "--limit", "3", "--junit", xml_path, "--json", json_path, SPOIL=spoil, LD_PRELOAD=SPOIL)
        seconds = time.monotonic() - start
        with open(json_path) as file:
            found = [(scene["verdict"], scene["message"]) for scene in json.load(file)["drivers"][0]["scenes"]]
        suite = next(iter(JUnitXml.fromfile(xml_path)))
        check(result.returncode == 1 and tuple(verdict for verdict, _ in found) == verdicts and words in found[0][1] and
              (suite.tests, suite.errors, suite.failures) == (2, verdicts.count("failed"), verdicts.count("differs")) and
              f"agreed {verdicts.count('agreed')}, differ {verdicts.count('differs')}, not verified 0, died {verdicts.count('failed')}\n" in result.stdout,
              f"{spoil}: a report, and status 1", found, result.stdout, result.stderr)
        print(f"# {spoil}: {seconds:.1f} s")


def at_once():
    """A line comes as soon as its scene ends, also in a pipe."""
    process = subprocess.Popen([SPECTRAL, "verify", "patches", "textures", "--gl", "egl", "--limit", "20"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                               env={**os.environ, "SPOIL": "hang", "LD_PRELOAD": SPOIL})
    lines = [process.stdout.readline() for _ in range(3)]
    check(lines[2].startswith(b"  patches  ") and process.poll() is None, "the first scene's line does not wait for the second", lines)
    process.kill()
    process.communicate()


def refusals():
    with open(path_of("lamp.csv"), "w") as file:
        file.write("nm,e\n400,1\n700,1\n")
    scene = write("lamp.scene", "wavelengths 400 700 100\nlight lamp.csv 1 direction 0 0 1\nmaterial m { diffuse 0.5 }\nobject plane 1 1 material m\n")
    for words in ((scene, "--junit", path_of("lamp.csv")), ("patches", "--light", f"1={path_of('lamp.csv')}", "--json", path_of("lamp.csv"))):
        refuses("a report in place of an input of a scene that ends the driver", "would replace an input", "verify", *words, "--gl", "egl",
                SPOIL="die", LD_PRELOAD=SPOIL)
    result = run("verify", "patches", "--gl", "egl:60")
    check(result.returncode == 1 and "there is no egl:60" in result.stdout, "a device that is missing cannot draw", result.stdout, result.stderr)
    remove(path_of("stopped.json"))
    process = subprocess.Popen([SPECTRAL, "verify", "--json", path_of("stopped.json")], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    time.sleep(1.5)
    process.send_signal(signal.SIGINT)
    start = time.monotonic()
    process.communicate()
    check(process.returncode != 0 and time.monotonic() - start < 5 and not os.path.exists(path_of("stopped.json")), "an interruption ends it, without a file")


parts(four_drivers, everything, named, failures, names, nothing_checked, expected, deaths, at_once, refusals)
done()
