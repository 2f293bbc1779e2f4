#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile
"""Checks the seconds that plan expects: they are those of the last render of this machine, by a model that a small file
in the user's cache adjusts. A file that is missing, broken or in the way changes nothing else. Checks the bytes of disk and
memory, too: the disk's are exact, but for the heads of the pages. Parts share the picture's. Prints TAP."""
import json
import os
import re
import shutil
import subprocess
import sys

sys.dont_write_bytecode = True
from rendered import SPECTRAL, TMP, check, done
from tap import bail_out

CACHE = os.path.abspath(os.path.join(TMP, "cache"))
PACE = os.path.join(CACHE, "spectral", "pace")
BARE = {name: value for name, value in os.environ.items() if name not in ("HOME", "XDG_CACHE_HOME")}
OURS = {**BARE, "XDG_CACHE_HOME": CACHE}
LARGE = ("colorchecker", "--size", "900x600")
ALONE = ("--renderer", "raster", "--no-check", "--samples", "2")


def run(*words, env=OURS):
    return subprocess.run([SPECTRAL, *words], check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, env=env)


def render(*words, env=OURS):
    """The seconds of a render, without those of reading and planning."""
    result = run("render", *words, "-o", "/dev/null", "--quiet", "--json", "-", env=env)
    if result.returncode != 0:
        bail_out(words, result.stderr)
    seconds = json.loads(result.stdout)["seconds"]
    return seconds["total"] - seconds["read"] - seconds["plan"]


def plan(*words, env=OURS):
    """The seconds that plan expects."""
    result = run("plan", *words, "--json", "-", env=env)
    if result.returncode != 0:
        bail_out(words, result.stderr)
    return json.loads(result.stdout)["seconds"]


def content():
    if not os.path.exists(PACE):
        return None
    with open(PACE, encoding="ascii") as file:
        return file.read()


def learns():
    shutil.rmtree(CACHE, ignore_errors=True)
    before = plan(*LARGE)
    words = run("plan", *LARGE).stdout
    check(not before["learnt"] and re.search("^seconds +about [0-9.]+ with OpenGL and its check, [0-9.]+ by the reference alone; "
                                             "known better", words, re.MULTILINE), "plan expects seconds before any render", words)
    checked = render(*LARGE)
    expected = plan(*LARGE)
    check(expected["learnt"] and abs(expected["checked"] / checked - 1) < 1e-3, "it expects the seconds of the same render",
          expected, checked)
    alone = render(*LARGE, *ALONE)
    expected = plan(*LARGE, "--samples", "2")
    check(abs(expected["reference"] / alone - 1) < 1e-3, "and so for the reference alone", expected, alone)
    larger = plan("colorchecker", "--size", "1800x1200", "--samples", "2")
    check(larger["reference"] > 1.5 * expected["reference"], "a larger picture takes longer", larger, expected)
    check(re.fullmatch(r"checked [0-9.]+\nreference [0-9.]+\n", content()), "the file has a line for each", content())


def leaves():
    before = content()
    for words in (("patches", "--size", "30x20"), (*LARGE, "--threads", "1"), (*LARGE, "--no-check"), (*LARGE, "--buffer", "8"),
                  ("patches", "--renderer", "softpipe"), (*LARGE, *ALONE, "--shading", "phong")):
        render(*words)
        check(content() == before, f"{' '.join(words)} teaches nothing", content())


def survives():
    for name, text in (("no text", b"\xff\x00\n"), ("a wrong number", b"checked 1e9\n"), ("nothing", b""), ("no number", b"checked\n")):
        with open(PACE, "wb") as file:
            file.write(text)
        check(not plan(*LARGE)["learnt"], f"a file of {name} is as good as none")
    render(*LARGE)
    check(re.fullmatch(r"checked [0-9.]+\n", content()), "the next render writes it again", content())
    os.remove(PACE)
    os.mkdir(PACE)
    render(*LARGE)
    check(not plan(*LARGE)["learnt"] and os.listdir(os.path.dirname(PACE)) == ["pace"], "a folder in its place stays")
    for env in (BARE, {**BARE, "XDG_CACHE_HOME": "cache"}, {**BARE, "HOME": "/dev/null"}, {**BARE, "XDG_CACHE_HOME": "/proc/none"}):
        result = run("render", *LARGE, *ALONE, "-o", "/dev/null", "--quiet", env=env)  # Mesa has a cache, too
        check(result.returncode == 0 and not result.stderr and not os.path.exists("cache"), "a render needs no cache", result.stderr)
        check(not plan(*LARGE, env=env)["learnt"], "nor does plan")
    home = os.path.abspath(os.path.join(TMP, "home"))
    shutil.rmtree(home, ignore_errors=True)
    os.mkdir(home)
    render(*LARGE, env={**BARE, "HOME": home})
    check(os.path.exists(os.path.join(home, ".cache", "spectral", "pace")), "without XDG_CACHE_HOME it is below HOME")


def planned(*words):
    return json.loads(run("plan", *words, "--json", "-").stdout)


def needs():
    stack = os.path.join(TMP, "stack.tif")
    for words in (("colorchecker", "--size", "900x700"), ("metals", "--size", "300x200", "--wavelengths", "500"), ("textures", "--size", "64x64")):
        expected = planned(*words)
        for kind, options in (("checked", ()), ("reference", ("--renderer", "raster", "--no-check"))):
            result = json.loads(run("render", *words, *options, "-o", stack, "--json", "-", "-q").stdout)
            ratio = result["peak_bytes"] / expected["peak_bytes"][kind]
            check(2 / 3 < ratio < 1.5, f"the memory of {words[0]}, {kind}, is as expected", f"{ratio:.2f} of {expected['peak_bytes'][kind]:.0f}")
        heads = os.path.getsize(stack) - expected["disk_bytes"]
        check(0 < heads < 2048 * (expected["bands"] + 4), f"the file of {words[0]} has the bytes that plan expects, and {heads:.0f} of heads", heads)


def parts():
    words = ("patches", "--size", "9000x3000", "--wavelengths", "450:650:100")
    whole = planned(*words)
    all_parts = [planned(*words, "--part", f"{i}/7") for i in range(1, 8)]
    check(sum(part["disk_bytes"] for part in all_parts) == whole["disk_bytes"], "the parts have the bytes of the whole")
    check(sum(part["part"]["tiles"] for part in all_parts) == whole["work"]["tiles"], "and its tiles")
    check([(part["part"]["number"], part["part"]["of"]) for part in all_parts] == [(i, 7) for i in range(1, 8)] and "part" not in whole, "each has its number")
    for kind in ("checked", "reference"):
        seconds = [part["seconds"][kind] for part in all_parts]
        check(max(seconds) < 0.5 * whole["seconds"][kind] and sum(seconds) > whole["seconds"][kind],
              f"each takes less than the whole, all of them more: {kind}", seconds, whole["seconds"])
        check({part["peak_bytes"][kind] for part in all_parts} == {whole["peak_bytes"][kind]}, "each takes the memory of the whole")
    words = run("plan", *words, "--part", "2/7").stdout
    check(re.search(r"^part +2 of 7: \d+ tiles; the lines below are of these\ndisk +[0-9.]+ MB for the part\n"
                    r"peak memory +about \d+ MiB with OpenGL and its check, \d+ MiB by the reference alone\nseconds ", words, re.MULTILINE),
          "plan prints the figures of the part", words)
    refused = run("plan", "patches", "--part", "8/7")
    check(refused.returncode == 2 and "expected a part" in refused.stderr, "a part that does not exist is refused", refused.stderr)


learns()
leaves()
survives()
needs()
parts()
done()
