#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile
"""Checks spectral cost. Its errors are computed again here, by numpy from the stacks of the commands that it names, and by compare;
its times are never checked. An interrupted run must leave nothing behind. Prints TAP."""
import csv
import io
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import time
import xml.etree.ElementTree as ElementTree

import numpy as np
import tifffile

from colours import ciede2000, cielab
from rendered import (SPECTRAL, bytes_of, check, done, output_of, path_of, refuses, response_of, run, tristimulus, values_of, weights,
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


ALONE = "--renderer=raster", "--no-check"


def cost(scene, *options):
    """The answer as text, and as JSON."""
    report = path_of("cost.json")
    said = output_of("cost", scene, "--json", report, *options)
    with open(report, encoding="utf-8") as file:
        return said, json.load(file)


def rows_of(report):
    return {row["options"].split("=")[1]: row for row in report["samplings"]}


# ---- the same errors by others ----

def rendered(name, scene, *options):
    output_of("render", scene, *options, "-q", "-o", path_of(name))
    return path_of(name)


def compared(one, other, observer):
    """The CIEDE2000 that compare prints: mean, 95 %, largest."""
    said = run("compare", one, other, "--detector", observer).stdout
    return [float(number) for number in re.search(r"CIEDE2000 +(\S+) \(mean\), (\S+) \(95th percentile\), (\S+) \(", said).groups()]


def xyz_of(stack, sampling, observer):
    """Colours by the tables alone where a page has a wavelength or is a component; by develop where a page stands for a segment."""
    if sampling.startswith(("gauss", "box", "adaptive")):
        return tristimulus(stack, "--detector", observer)[0]
    if not sampling.startswith("riemann"):
        return np.tensordot(response_of(stack)[0] if "basis" not in sampling else matrix_of(stack), values_of(stack), 1)
    with tifffile.TiffFile(stack) as tiff:
        nm = np.array([float(page.tags["PageName"].value.split()[0]) for page in tiff.pages])
        is_float = tiff.pages[0].dtype == np.float32
        pages = np.array([page.asarray() for page in tiff.pages], float)
    return np.tensordot(weights(observer, nm), pages if is_float else values_of(stack), 1)


def matrix_of(stack):
    with tifffile.TiffFile(stack) as tiff:
        numbers = re.search("^response: (.*)$", tiff.pages[0].description, re.MULTILINE).group(1).split()
        return np.array(numbers, float).reshape(3, len(tiff.pages))


def by_numpy(truth, seen, white):
    """Mean, 95 % and largest, of the pixels that are not black in both."""
    lit = (truth != 0).any(0) | (seen != 0).any(0)
    difference = np.sort(ciede2000(cielab(truth[:, lit], white[:, None]), cielab(seen[:, lit], white[:, None])))
    return difference.mean(), difference[len(difference) - len(difference) // 20 - 1], difference[-1]


def same_errors(name, scene, report, *given, observer="cie1931"):
    """Each row, by compare in all digits that it prints, and by numpy."""
    own = [*given, *(["--detector", observer] if observer != "cie1931" else [])]
    every_nm = rendered("every-nm.tif", scene, *own, "--sampling=riemann:1", "--depth=32f", *ALONE)
    truth = xyz_of(every_nm, "riemann:1", observer)
    white = tristimulus(every_nm, "--detector", observer)[1][:, 0]
    apart = []
    for sampling, row in rows_of(report).items():
        stack = rendered("row.tif", scene, *own, row["options"], *([] if row["checked_seconds"] else ALONE))
        said = [row["dE00_mean"], row["dE00_95"], row["dE00_largest"]]
        if [float(f"{number:.6g}") for number in said] != compared(every_nm, stack, observer):
            apart.append((sampling, said, compared(every_nm, stack, observer)))
        seen = by_numpy(truth, xyz_of(stack, sampling, observer), white)
        if not np.allclose(said, seen, rtol=2e-3, atol=2e-4):  # a quantile is that of its bin, less than 1/1000 above
            apart.append((sampling, said, seen))
    check(len(rows_of(report)) >= 8 and not apart, f"{name}: {len(rows_of(report))} rows have the errors that compare and numpy find", *apart)


# ---- the answer ----

def answers(name, scene, said, report, *given):
    """Each line names the cheapest of the table within its error; its command runs, and it is short."""
    table = rows_of(report)
    lines = re.findall(r"^within ([\d., ]+?) +(--\S+|none)(.*)$", said, re.MULTILINE)
    wrong = []
    for errors, options, rest in lines:
        for error in map(float, errors.split(", ")):
            good = [row for row in table.values() if row["spectra"] and row["dE00_95"] <= error]
            best = min(good, key=lambda row: row["unchecked_seconds"])["options"] if good else "none"
            if best != options or (best != "none" and not table[best.split("=")[1]]["checked_seconds"] > 0):
                wrong.append((error, options, best))
    check(len(said.splitlines()) <= 12 and {float(e) for line in lines for e in line[0].split(", ")} == {2, 1, 0.5, 0.1} and not wrong,
          f"{name}: at most twelve lines name the cheapest within 2, 1, 0.5, 0.1", *wrong, said)
    command = shlex.split(said.splitlines()[-1])
    check(command[:3] == ["spectral", "render", scene] and command[-2:] == ["-o", "every-nm.tif"] and
          all(word in command for word in given) and run(*command[1:-1], path_of("said.tif"), "-q").returncode == 0,
          f"{name}: the last line renders what errors are from", command)
    best = [row for row in report["samplings"] if row["best"]]
    check(all(row["unchecked_seconds"] > 0 for row in [*report["samplings"], report["every_nm"]]), f"{name}: each takes seconds", *best)
    for kind in (True, False):
        errors = [row["dE00_95"] for row in best if row["spectra"] == kind]
        check(errors == sorted(errors, reverse=True), f"{name}: a dearer one is closer", *best)


def theory(report):
    table = rows_of(report)
    errors = [table[f"riemann:{step}"]["dE00_95"] for step in (40, 20, 10, 5, 2) if f"riemann:{step}" in table]
    check(len(errors) > 1 and errors == sorted(errors, reverse=True), "riemann's error falls with the step", *errors)
    check(table["basis:8"]["dE00_95"] < table["rgb"]["dE00_95"], "eight components are closer than three numbers under lamp A")
    triangles, positions = report["triangles"], report["positions"]
    check(triangles["after"] < triangles["before"] and positions["after"] < positions["before"] and
          triangles["options"] == f"--accuracy={triangles['before'] / 2:.2g}" and positions["options"] == "--samples=2",
          "finer triangles and more positions are closer", triangles, positions)


def refinements(scene, report):
    """The errors of light and of outlines are those of the commands that the room's comments name."""
    typical = report["typical"]
    stack = rendered("typical.tif", scene, typical)
    true_light = rendered("true.tif", scene, typical, "--shading=phong", "--tessellation=4", "--depth=32f", "--full-scale=65535", *ALONE)
    means = rendered("means.tif", scene, typical, "--samples=4", *ALONE)
    for kind, finest, which in (("triangles", true_light, 1), ("positions", means, 0)):
        finer = rendered("finer.tif", scene, typical, report[kind]["options"])
        found = [compared(finest, each, "cie1931")[which] for each in (stack, finer)]
        check([float(f"{report[kind][key]:.6g}") for key in ("before", "after")] == found, f"compare finds the errors of {kind}", report[kind], found)


def tube(scene):
    _, report = cost(scene, "--light", "1=fluorescent", "--light", "2=fluorescent", "--observer", "cie1964")
    table = rows_of(report)
    check(table["gauss:8"]["dE00_95"] > 1 and table["adaptive:0.001"]["dE00_95"] < 0.5,
          "under a fluorescent tube gauss:8 is poor, and adaptive is good", table["gauss:8"], table["adaptive:0.001"])
    same_errors("under a tube, cie1964", scene, report, "--light=1=fluorescent", "--light=2=fluorescent", observer="cie1964")


def tables(scene):
    """CSV, JSON and the chart show the same."""
    chart = path_of("cost.svg")
    result = run("cost", scene, "--csv", "-", "--svg", chart, "--json", path_of("cost.json"), "-v")
    rows = list(csv.DictReader(io.StringIO(result.stdout)))
    with open(path_of("cost.json"), encoding="utf-8") as file:
        report = json.load(file)
    pairs = (("unchecked", "unchecked_seconds"), ("checked", "checked_seconds"), ("dE00_95", "dE00_95"))
    check(len(rows) == len(report["samplings"]) and all(
        (row[one] == "" and entry[two] is None) or np.isclose(float(row[one]), entry[two], rtol=1e-8)
        for row, entry in zip(rows, report["samplings"]) for one, two in pairs),
        "CSV and JSON have the same table", *rows)
    texts = [text.text for text in ElementTree.fromstring(bytes_of(chart)).iter("{http://www.w3.org/2000/svg}text")]
    best = [row["options"].split("=")[1] for row in report["samplings"] if row["best"]]
    check({*best, "checked", "unchecked", "seconds of processors"} <= set(texts) and "nan" not in bytes_of(chart).decode(),
          "the chart names what to type", best, texts)
    listed = re.findall(r"^--sampling=(\S+) ", result.stderr.split("\nsampling ")[1], re.MULTILINE)
    folded = re.search(r"^dearer, not closer:(.*)$", result.stderr, re.MULTILINE).group(1).split()
    check(listed == best and set(folded) == set(rows_of(report)) - set(best), "-v prints them, and the others in a line",
          listed, folded)


def odd_scenes(scene):
    """Phong shading has no OpenGL; a dark scene has no colours; spectral textures have no components."""
    said, report = cost(write("phong.scene", SCENE + "shading phong\n"), "--size=12x8")
    check("check               none" in said and "checked (" not in said and report["opengl_seconds"] is None,
          "phong shading is measured by the reference alone", said)
    refuses("a scene without light", "no light shines at the wavelengths", "cost", write("dark.scene", re.sub("light .*\n", "", SCENE)), "-q")
    said, report = cost("patches", "--size=12x8", "--samples=8")
    check("samples of a pixel  not known: there is nothing finer\n" in said and report["positions"]["before"] is None,
          "more samples than 16 x 16 cannot be tried, and the answer says so", said)
    refuses("a camera", "no tristimulus values", "cost", scene, "--detector", "dcs200-camera")
    _, report = cost("room", "--size=12x8")
    check(not any(not row["spectra"] for row in report["samplings"]) and len(report["notes"]) == 3,
          "a spectral texture has no components, which notes say", *report["notes"])


# ---- programs, as seen from outside ----

def descendants(pid):
    """Command lines of the processes below one, the files of their programs, and whether a variable of llvmpipe was handed to them."""
    found = set()
    try:
        with open(f"/proc/{pid}/task/{pid}/children", encoding="utf-8") as file:
            children = file.read().split()
    except OSError:
        return found
    for child in children:
        found |= descendants(child)
        try:
            with open(f"/proc/{child}/cmdline", encoding="utf-8") as file, open(f"/proc/{child}/environ", "rb") as given:
                found.add((os.readlink(f"/proc/{child}/exe"), tuple(file.read().split("\0")[:-1]), b"LP_NUM_THREADS=" in given.read()))
        except OSError:
            pass
    return found


def programs():
    """Renders run as programs of their own. The user's name of the program may be one that the shell finds by PATH."""
    folder, name = os.path.split(os.path.realpath(SPECTRAL))
    process = subprocess.Popen([name, "cost", "patches", "--size=60x40", "--memory=900", "--light", "1=a"],
                               env={**os.environ, "PATH": folder + ":" + os.environ["PATH"]}, stdin=subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, universal_newlines=True)
    seen = set()
    while process.poll() is None:
        seen |= descendants(process.pid)
        time.sleep(0.002)
    said = process.communicate()[1]
    check(process.returncode == 0 and re.fullmatch(r"about [\d.e+]+ s\n", said), "cost says how long it will take", process.returncode, said)
    check({file for file, _, _ in seen} == {os.path.realpath(SPECTRAL)}, "no other program runs", *{file for file, _, _ in seen})
    lines = [words for _, words, _ in seen if words[1:2] == ("render",)]
    check(not any(set_before for _, words, set_before in seen if words[1:2] == ("render",)), "renders choose their threads as a user's do")
    check(lines and all(words[0] == name and words[2:4] == ("--size=60x40", "--light=1=a") and "--memory=900" in words
                        and words[-2:] == ("--", "patches") for words in lines),
          "renders are command lines of the program, with all that the user gave", *lines[:3])


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
    while not os.listdir(folder) and process.poll() is None:
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
    for wait in (0, 0.4, 3):
        interrupt(signal.SIGINT, wait)
        interrupt(signal.SIGTERM, wait)
    result = run("cost", scene, env={**os.environ, "TMPDIR": path_of("missing")})
    check(result.returncode == 3 and len(result.stderr.splitlines()) == 1 and not result.stdout,
          "a missing TMPDIR gives one line and exit 3", result.returncode, result.stderr)


small = write("small scene's.scene", SCENE)
text, found = cost(small, "--size=60x40")
answers("a small scene", small, text, found, "--size=60x40")
theory(found)
same_errors("a small scene", small, found, "--size=60x40")
text, found = cost(small)
refinements(small, found)
tube(small)
tables(small)
odd_scenes(small)
programs()
interruptions(small)
done()
