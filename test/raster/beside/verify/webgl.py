#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy chromium
"""Draws exported scenes by WebGL2 in a browser (data/samples/draw.html), whose corners lie on a grid of 1/16 pixel, and judges the
pixels. Measured by its targets the browser agrees; so it does by the bits that it states; by the bounds of Mesa's drivers nearly
every pixel differs. One sample, one triangle and one band that are changed are found. Prints TAP."""
import glob
import json
import os
import shutil
import subprocess
import time

import numpy as np

from browser import Browser
from rendered import bail_out, check, done, output_of, path_of, run, unshadowed

SIZE = (480, 320)


def draw(scene, *options):
    """Exports a scene, and lets the browser draw it. Returns both folders."""
    exported, drawn = os.path.abspath(path_of("exported")), os.path.abspath(path_of("drawn"))
    for folder in (exported, drawn):
        shutil.rmtree(folder, ignore_errors=True)
    output_of("export", scene, "--size", f"{SIZE[0]}x{SIZE[1]}", *options, "-o", exported)
    browser = Browser(path_of("browser"))
    browser.send("Page.navigate", url="file://" + os.path.abspath("data/samples/draw.html"))
    browser.wait("document.getElementById('files') !== null")
    page = browser.send("DOM.getDocument")["root"]["nodeId"]
    files = browser.send("DOM.querySelector", nodeId=page, selector="#files")["nodeId"]
    browser.send("DOM.setFileInputFiles", nodeId=files, files=glob.glob(exported + "/*"))
    browser.wait("document.getElementById('message').textContent !== ''")
    said = browser.evaluate("document.getElementById('message').textContent")
    archive = os.path.join(browser.downloads, "drawn.tar")
    since = time.monotonic()
    while not os.path.exists(archive) and time.monotonic() - since < 60:
        time.sleep(0.1)
    browser.close()
    if not said.startswith("drawn.tar has "):
        bail_out(said)
    os.makedirs(drawn)
    subprocess.run(["tar", "xf", archive, "-C", drawn], check=True)
    return exported, drawn


def judge(exported, drawn, *options):
    result = run("judge", exported, drawn, "--unchecked", "1", "--json", "-", *options)
    return result, json.loads(result.stdout)["check"] if result.stdout else {}


def figures(seen):
    return (f"floors: median {seen['floor_median_counts']:.3g} counts, in one band {seen['band_floor_median_counts']:.3g}; "
            f"{100 * seen['unchecked_pixels'] / seen['object_pixels']:.1f} % not checked")


def changed(drawn, name, kind, change):
    """Changes the numbers of a file for as long as the generator lives."""
    pixels = np.memmap(os.path.join(drawn, name), kind, "r+").reshape(SIZE[1], SIZE[0], -1)
    old = pixels.copy()
    change(pixels)
    pixels.flush()
    yield
    pixels[:] = old
    pixels.flush()


def finds(what, exported, drawn, name, change, where):
    for _ in changed(drawn, name, "<f4", change):
        result, seen = judge(exported, drawn)
        check(result.returncode == 1 and where in result.stderr and seen["unexplained_pixels"] > 0, f"{what} is found", result.stderr[:300], seen["unexplained_pixels"])


def leave_out_bits(drawn):
    path = os.path.join(drawn, "drawn.txt")
    lines = [line for line in open(path) if "-bits " not in line]
    open(path, "w").write("".join(lines))


def scene(name, *options):
    exported, drawn = draw(name, *options)
    result, seen = judge(exported, drawn)
    bounds = [line for line in result.stderr.splitlines() if line.startswith("bounds ")]
    check(result.returncode == 0 and "measured: edges to 0.0312 pixel, values to 0.0312" in str(bounds),
          f"{name}: measured by its targets, the browser agrees ({figures(seen)})", bounds, result.stderr[:500])
    y, x = SIZE[1] // 2, SIZE[0] // 2

    def brighter(pixels):
        pixels[y, x, 1] += np.float32(3 * seen["floor_worst_counts"] / 65535 if seen["floor_worst_counts"] < 256 else 0.02)

    def exchange(pixels):
        pixels[y, x, 0] += 7

    def scale(pixels):
        pixels[:, :, 1] *= np.float32(1.001)

    finds(f"{name}: one sample", exported, drawn, "colours-3.bin", brighter, f"first at {x},{y} ")
    finds(f"{name}: one triangle", exported, drawn, "numbers.bin", exchange, f"first at {x},{y} ")
    finds(f"{name}: one band times 1.001", exported, drawn, "colours-3.bin", scale, "differ")
    os.remove(os.path.join(drawn, "targets-drawn.txt"))
    result, seen = judge(exported, drawn)
    check(result.returncode == 0 and "stated by drawn.txt: edges to 0.0625 pixel" in result.stderr,
          f"{name}: by the bits that drawn.txt states, it agrees ({figures(seen)})", result.stderr[:500])
    leave_out_bits(drawn)
    result, seen = judge(exported, drawn)
    check(result.returncode == 1 and seen["unexplained_pixels"] > 0.5 * seen["object_pixels"],
          f"{name}: by the bounds of Mesa's drivers, {seen['unexplained_pixels']} of {SIZE[0] * SIZE[1]} pixels differ", result.stderr[:300])


for each in ("colorchecker", "spheres", "textures", "metals"):  # the page draws no shadows
    scene(unshadowed(each), "--wavelengths", "400:700:30")
done()
