#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile
"""Checks spectral cost. Its errors are compared with theory; its times are never checked. Its recommendations are
rendered, developed and compared here with a separate reference, for a small scene; with FULL, also
under a tube, with several positions a pixel, and for all built-in scenes. An interrupted run must leave nothing behind. Prints TAP."""
import csv
import glob
import io
import json
import math
import os
import re
import shlex
import shutil
import signal
import subprocess
import time

import numpy as np
import tifffile

from rendered import (SPECTRAL, check, colour_error_95, done, objects_of, output_of, path_of, run, tristimulus,
                      write)

CHECKER = os.path.abspath("data/builtin/materials/colorchecker")
SCENE = f"""wavelengths 400 700 10
size 48 32
camera ortho 12
light a 1 position 0 0 8
light a 0.5 direction 1 1 1
material red {{ diffuse {CHECKER}/15-red.txt }}
material green {{ diffuse {CHECKER}/14-green.txt gloss 20 }}
material blue {{ diffuse {CHECKER}/13-blue.txt }}
material grey {{ diffuse 0.4 }}
object plane 14 10 material grey translate 0 0 -4
object sphere 2.4 10 8 material green
object plane 3 3 material red translate -4 0 0
object plane 3 3 material blue translate 4 0 0
"""
FEW = ["--runs", "5", "--threads", "1"]


def cost(scene, *options):
    """Returns the table by names; the text of the table comes last."""
    report = path_of("cost.json")
    printed = output_of("cost", scene, "--quiet", "--csv", "-", "--json", report, *FEW, *options)
    rows = list(csv.DictReader(io.StringIO(printed)))
    entries = json.load(open(report, encoding="utf-8"))["configurations"]
    check([(row["name"], row["frontier"]) for row in rows] ==
          [(entry["name"], str(int(entry["frontier"]))) for entry in entries] and
          all(math.isclose(float(row[column]), entry[field], rel_tol=1e-8) for row, entry in zip(rows, entries)
              for column, field in (("seconds", "seconds"), ("processor", "processor_seconds"))),
          f"the JSON has the table of {scene}")
    return {row["name"]: row for row in rows}


def error(table, name, column="dE00_mean"):
    return float(table[name][column])


# ---- the table ----

NUMBERS = ("seconds", "fastest", "slowest", "dE00_mean", "dE00_95", "dE00_largest")
TICK = 0.02  # a processor's seconds may be counted in such steps


def is_in_order(row):
    numbers = [float(row[name]) for name in NUMBERS]
    return (all(np.isfinite(numbers)) and 0 < numbers[1] <= numbers[0] <= numbers[2]
            and 0 <= numbers[3] <= numbers[5] and 0 <= numbers[4] <= numbers[5])


def is_plausible(row):
    """Processors work, all together, at most as long as there are of them."""
    return 0 < float(row["processor"]) <= os.cpu_count() * float(row["slowest"]) + TICK


def whole_table(scene):
    first = cost(scene)
    expected = {f"{name} phong x4" for name in (
        "own wavelengths", "riemann:40", "riemann:20", "riemann:10", "riemann:5", "riemann:1", "gauss:4",
        "gauss:8", "gauss:12", "gauss:16", "gauss:24", "gauss:8,open", "box:8", "box:16", "adaptive:0.01",
        "rgb", "xyz", "basis:1", "basis:2")}
    check(expected <= set(first), "every sampling is measured", expected - set(first))
    ends = ("flat", "smooth", "phong", "flat x2", "smooth x2", "phong x2", "flat x4", "smooth x4", "phong x4",
            "smooth llvmpipe", "smooth llvmpipe buffer 8", "smooth llvmpipe buffer 16",
            "smooth llvmpipe checked", "smooth softpipe", "smooth gl-shader:llvmpipe", "phong x4 depth 8", "phong x4 depth 32f")
    for end in ends:
        check(any(name.split(" ", 1)[1] == end for name in first), f"{end} is measured", *first)
    check(all(map(is_in_order, first.values())),
          "fastest, median and slowest are in this order, and so are errors", *first.values())
    check(all(map(is_plausible, first.values())), "seconds of processors are more than 0, and fit into those of the clock",
          *[row for row in first.values() if not is_plausible(row)])
    check([float(row["seconds"]) for row in first.values()]
          == sorted(float(row["seconds"]) for row in first.values()), "entries are in order of seconds")
    return first


# ---- errors known from theory ----

def falls(table, names, what):
    errors = [error(table, name) for name in names]
    check(all(a > b for a, b in zip(errors, errors[1:])), what, *zip(names, errors))


def smooth_light(table):
    falls(table, [f"riemann:{n} phong x4" for n in (40, 20, 10, 5, 1)], "riemann's error falls with the step")
    own, same = (table[f"{name} phong x4"] for name in ("own wavelengths", "riemann:10"))
    check(all(own[key] == same[key] for key in own if key.startswith(("dE", "radiance"))),
          "the scene's own wavelengths, every 10 nm, are as accurate as riemann:10 in colours and radiances", own,
          same)
    check(error(table, "gauss:8 phong x4") < error(table, "riemann:40 phong x4"),
          "under smooth light 8 nodes of gauss are better than 8 samples of riemann",
          error(table, "gauss:8 phong x4"), error(table, "riemann:40 phong x4"))
    bases = sorted((name for name in table if name.startswith("basis:") and name.endswith(" phong x4")),
                   key=lambda name: int(name[6:].split()[0]))
    falls(table, bases, "a basis's error falls with its components")
    check(error(table, bases[-1], "radiance_error") < 1e-4,
          "with all components a basis has the error of 16-bit samples", table[bases[-1]])
    good = bases[-1].split()[0]
    falls(table, [f"{good} {name}" for name in ("smooth", "smooth x2", "smooth x4")],
          "smooth shading approaches phong with finer tessellation")
    falls(table, [f"{good} {name}" for name in ("phong x4 depth 8", "phong x4", "phong x4 depth 32f")],
          "deeper pages are more accurate")
    check(error(table, f"{good} phong x4 depth 32f") < 1e-4, "float pages of all components are exact",
          table[f"{good} phong x4 depth 32f"])
    check(all(table[f"{name} phong x4"]["radiance_error"] == "" for name in ("rgb", "xyz")),
          "rgb and xyz have no radiances")


def emission_lines(scene):
    table = cost(scene, "--light", "1=fluorescent", "--light", "2=fluorescent")
    poor = error(table, "gauss:8 phong x4", "dE00_95")
    good = error(table, "adaptive:0.001 phong x4", "dE00_95")
    check(poor > 1 and good < 0.5, "under a fluorescent tube gauss:8 is poor, and adaptive recovers", poor, good)
    notes = json.load(open(path_of("cost.json"), encoding="utf-8"))["notes"]
    check(any("has emission peaks" in note for note in notes), "a note says why", *notes)


# ---- recommendations ----

def render(stack, scene, options):
    result = run("render", scene, "--quiet", "-o", stack, *options)
    check(result.returncode == 0, f"render {os.path.basename(scene)} {' '.join(options)}", result.stderr)


def quantile(scene, options, given, observer):
    mine, reference = path_of("mine.tif"), path_of("reference.tif")
    render(mine, scene, [option for option in options if option != "--no-check"])  # OpenGL's own stack then has a map of objects
    render(reference, scene, [*given, "--sampling=riemann:1", "--detector", observer, "--shading=phong",
                              "--tessellation=4", "--renderer=raster", "--depth=32f"])
    return colour_error_95(*[(tristimulus(stack, "--observer", observer), objects_of(stack)) for stack in (reference, mine)])


def radiances(stack):
    """Wavelengths of a stack of float pages, and the radiance of each pixel there."""
    with tifffile.TiffFile(stack) as tiff:
        return (np.array([float(page.tags["PageName"].value.split()[0]) for page in tiff.pages]),
                np.array([page.asarray().ravel() for page in tiff.pages], float))


def radiance_errors(scene, table):
    """The error of a small picture counts every pixel; a stack is linear between its pages."""
    stack, fine = path_of("stack.tif"), ["--shading=phong", "--tessellation=4", "--renderer=raster",
                                                   "--depth=32f"]
    render(stack, scene, ["--sampling=riemann:1", *fine])
    every_nm, truth = radiances(stack)
    for sampling in ("riemann:40", "gauss:8"):
        render(stack, scene, [f"--sampling={sampling}", *fine])
        nm, seen = radiances(stack)
        between = np.array([np.interp(every_nm, nm, pixel) for pixel in seen.T]).T
        relative = np.sqrt(((between - truth) ** 2).sum() / (truth ** 2).sum())
        said = error(table, f"{sampling} phong x4", "radiance_error")
        check(abs(said - relative) <= 1e-3 * relative, f"the radiance's error of {sampling} is that of its stack",
              said, relative)


def advice(text):
    """The lines that recommend, without those on noise, which depend on the run."""
    return [line for line in text.splitlines() if not line.startswith("  as good within noise: ")]


def holds(scene, given, observer, named, command):
    """Returns the line that names a configuration, and the command that renders it."""
    name = " ".join([os.path.basename(scene), *given, observer, *named.split(":")[:1]])
    words = shlex.split(command)
    check(words[:3] == ["spectral", "render", scene], f"{name}: the printed command is complete", command)
    said, seen = float(named.rsplit(" ", 1)[1]), quantile(scene, words[3:], given, observer)
    check(seen <= 0.5 and abs(seen - said) <= 0.01 * said + 1e-4,
          f"{name}: rendered and compared separately, 95 % of the pixels are within 0.5", seen, said)
    with tifffile.TiffFile(path_of("mine.tif")) as tiff:
        return tiff.pages[0].tags["PageName"].value.endswith(" nm")


def recommends(scene, *given, observer="cie1931"):
    """If the first recommendation has no spectra, cost names a second one that has them. A budget of time gets its own
    recommendations."""
    result = run("cost", scene, "--tolerance", "0.5dE00", "--budget", "1e6", "--quiet", "--observer", observer, *FEW, *given)
    lines = advice(result.stdout)
    first = next((i for i, line in enumerate(lines) if line.startswith("seconds within 1000000: ")), 0)
    lines, affordable = lines[:first], lines[first:]
    check(result.returncode == 0 and lines and affordable and lines[0].startswith("95 % within 0.5 CIEDE2000: "),
          f"{scene}: cost names a configuration within 0.5", result.stdout, result.stderr)
    spectral = [holds(scene, given, observer, *lines[i:i + 2]) for i in range(0, len(lines) - 1, 2)]
    check(spectral == [True] or (spectral == [False, True] and lines[2].startswith("with spectra: ")),
          f"{scene}: that configuration, or a second one, renders a stack of wavelengths", *lines)
    return affordable


def means(scene):
    """With --samples, fewer positions are configurations, too; their errors are those of a separate comparison with
    twice as many as were asked for."""
    size = "--size=24x16"
    report = path_of("means.json")
    result = run("cost", scene, "--samples", "2", size, "--tolerance", "0.01dE00", "--json", report, *FEW)
    entries = json.load(open(report, encoding="utf-8"))["configurations"]
    fewer = [entry for entry in entries if "--samples=1" in entry["options"]]
    all_of_them = [entry for entry in entries if "--samples=1" not in entry["options"]]
    check(result.returncode == 1 and "the standard has 4 x 4" in result.stdout and fewer and all_of_them and
          min(entry["dE00_95"] for entry in all_of_them) < 0.6 * min(entry["dE00_95"] for entry in fewer),
          "more positions a pixel come nearer to the standard", result.stdout, result.stderr)
    for entry in (fewer[0], all_of_them[-1]):
        seen = quantile(scene, [size, "--samples=2", *entry["options"]], [size, "--samples=4"], "cie1931")
        check(abs(seen - entry["dE00_95"]) <= 0.01 * seen + 1e-4, f"{entry['name']}: its error is that of its stack",
              seen, entry["dE00_95"])


# ---- programs, as seen from outside ----

def descendants(pid):
    """Command lines of the processes below one, and the files of their programs."""
    found = set()
    try:
        with open(f"/proc/{pid}/task/{pid}/children", encoding="utf-8") as file:
            children = file.read().split()
    except OSError:
        return found
    for child in children:
        found |= descendants(child)
        try:
            with open(f"/proc/{child}/cmdline", encoding="utf-8") as file:
                found.add((os.readlink(f"/proc/{child}/exe"), tuple(file.read().split("\0")[:-1])))
        except OSError:
            pass
    return found


def programs():
    """Renders run as programs of their own. The user's name of the program may be one that the shell finds by PATH."""
    report = path_of("programs.json")
    folder, name = os.path.split(os.path.realpath(SPECTRAL))
    process = subprocess.Popen([name, "cost", "patches", "--size=60x40", "--memory=900", "--light", "1=a", "--budget=1e-9",
                                "--json", report], env={**os.environ, "PATH": folder + ":" + os.environ["PATH"]},
                               stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                               universal_newlines=True)
    seen = set()
    while process.poll() is None:
        seen |= descendants(process.pid)
        time.sleep(0.002)
    said = process.communicate()[1]
    check(process.returncode == 1 and
          re.fullmatch(r"about \d+ s, for 5 runs of about \d+ configurations\n.*no configuration has [^\n]*\n", said),
          "cost says how long it will take, and that no configuration takes at most 1e-9 s", process.returncode, said)
    check({file for file, _ in seen} == {os.path.realpath(SPECTRAL)}, "no other program runs", *{file for file, _ in seen})
    lines = [words for _, words in seen if words[1:2] == ("render",)]
    check(lines and all(words[0] == name and words[2:4] == ("--size=60x40", "--light=1=a") and "--memory=900" in words
                        and words[-2:] == ("--", "patches") for words in lines),
          "renders are command lines of the program, with all that the user gave", *lines[:3])
    entries = json.load(open(report, encoding="utf-8"))["configurations"]
    run_words = {tuple(words[4:words.index("--memory=900")]) for words in lines}
    check({tuple(entry["options"]) for entry in entries} <= run_words, "each configuration of the table has been run",
          *run_words)


# ---- nothing stays behind ----

def interrupt(number, wait):
    """A terminal sends signals to the whole group; kills.py sends them to the program alone."""
    folder = path_of("temporary")
    shutil.rmtree(folder, ignore_errors=True)
    os.mkdir(folder)
    process = subprocess.Popen([SPECTRAL, "cost", "colorchecker", "--size", "300x200", "-q"], start_new_session=True,
                               env={**os.environ, "TMPDIR": folder}, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE,  # shells ignore SIGINT in background jobs
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    while not glob.glob(folder + "/*/stack.tif") and process.poll() is None:
        time.sleep(0.01)
    time.sleep(wait)
    os.killpg(process.pid, number)
    output = process.communicate(timeout=30)[0]
    left, until = True, time.monotonic() + 10  # the system may take its time to bury the dead
    while left and time.monotonic() < until:
        try:
            os.killpg(process.pid, 0)
            time.sleep(0.01)
        except ProcessLookupError:
            left = False
    name = f"{signal.Signals(number).name} to the group after {wait} s"
    check(process.returncode == -number and not output, f"{name}: cost ends by the signal and prints nothing",
          process.returncode, output)
    check(not os.listdir(folder) and not left, f"{name}: no file and no process is left", os.listdir(folder))


def interruptions(scene):
    for wait in (0, 0.4):
        interrupt(signal.SIGINT, wait)
        interrupt(signal.SIGTERM, wait)
    result = run("cost", scene, env={**os.environ, "TMPDIR": path_of("missing")})
    check(result.returncode == 3 and len(result.stderr.splitlines()) == 1 and not result.stdout,
          "a missing TMPDIR gives one line and exit 3", result.returncode, result.stderr)


small = write("small scene's.scene", SCENE)
measured = whole_table(small)
smooth_light(measured)
radiance_errors(small, measured)
emission_lines(small)
best = recommends(small)
check(len(best) == 4 and "basis:" in best[0] and best[2].startswith("with spectra: riemann:1 phong x4"),
      "a basis is the most accurate configuration, and every nm the most accurate one with wavelengths", *best)
programs()
interruptions(small)
if os.environ.get("FULL"):
    means(small)
    recommends(small, "--light=1=fluorescent", observer="cie1964")
    for built_in in sorted(glob.glob("data/builtin/scenes/*.scene")):
        recommends(os.path.basename(built_in)[:-6], "--size=24x16")
done()
