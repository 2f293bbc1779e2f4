#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Runs the hard cases: those that must agree in data/builtin/hard, which `spectral verify` draws, too, and the others in
test/cases/hard. Lines `# holds: ...` of a scene list the conditions that its picture must
fulfil, in the reference and in OpenGL, with both of Mesa's software drivers. Prints TAP.

    agreed                   exit 0, no pixel unexplained, every sample finite
    refused WORDS            exit 2 and one line: a place in a scene, mesh or table, then these
                             words (a regular expression); the same line on every path
    agreed or refused WORDS  either result, but the same one on every path
    full                     no pixel shows the background
    convex                   the visible pixels of every row and column are connected: no crack, no speck
    even                     all pixels are equal within a count
    black                    every sample is 0; without this word some sample is not
    same-as SCENE            the samples of that scene
    same-as SCENE within N   the samples of that scene, with differences up to N counts
    mirror-of SCENE          sample x equals sample W - 1 - x of that scene
    times F SCENE within N   the samples of that scene times a factor, with differences up to N counts
                             (the last three: OpenGL may also differ by both bounds, and by any amount
                             at ambiguous pixels)
    floor COUNTS             the check would find an error of so many counts at half of the pixels
    bounded                  every pixel has a bound on OpenGL's error
    unverified PATH...       on these paths more than 1 % of the object pixels, besides edges, cannot be
                             checked, and on no others; the scene is then rendered with --unchecked 1
    from VERSION unverified PATH...  likewise, with Mesa from that version on
    smooth NUMBER            the check counts exactly so many smooth interior pixels
    seconds MOST             processor seconds of each run

A line `# with: ...` holds options for the program."""
import concurrent.futures
import glob
import json
import math
import os
import re
import shutil
import subprocess
import time

import numpy as np
import tifffile

from rendered import SPECTRAL, TMP, cases, check, done, write

FOLDERS = ("data/builtin/hard", "test/cases/hard")
PATHS = {"reference": ("raster", "llvmpipe"), "llvmpipe": ("gl", "llvmpipe"),
         "softpipe": ("gl", "softpipe")}
MESA = float(re.search(r"Mesa (\d+\.\d+)", subprocess.run([SPECTRAL, "drivers"], stdout=subprocess.PIPE, check=True, text=True).stdout)[1])
LONGEST = 600  # seconds until the test kills a run
MANY = 100_000


class Scene:
    def __init__(self, path):
        lines = open(path).read().splitlines()
        self.name = os.path.basename(path)[:-len(".scene")]
        holds = [line.split(":", 1)[1].split() for line in lines if line.startswith("# holds:")]
        self.holds = [words[2:] if words[0] == "from" else words for words in holds if words[0] != "from" or MESA >= float(words[1])]
        self.unverified = [path for words in self.holds if words[0] == "unverified" for path in words[1:]]
        self.options = [word for line in lines if line.startswith("# with:")
                        for word in line.split(":", 1)[1].split()]


class Run:
    """One run of a scene by one path: exit status, messages, report, and samples [band, y, x] in counts."""

    def __init__(self, scene, path):
        renderer, driver = PATHS[path]
        stack = os.path.join(TMP, f"{scene.name}-{path}.tif")
        options = ["--renderer", renderer, "--depth", "32f", "--threads", "1", "--json", "-",
                   "--quiet"]
        if path == "reference":
            options.append("--no-check")  # which the other paths do
        elif scene.unverified:
            options += ["--unchecked", "1"]
        start = time.monotonic()
        try:
            result = subprocess.run(
                [SPECTRAL, "render", os.path.join(TMP, scene.name + ".scene"), "-o", stack,
                 *options, *scene.options], capture_output=True, text=True, check=False,
                timeout=LONGEST, env={**os.environ, "GALLIUM_DRIVER": driver})
            self.status, self.says = result.returncode, result.stderr
        except subprocess.TimeoutExpired:
            self.status, self.says = None, f"no end after {LONGEST} seconds"
        self.seconds = time.monotonic() - start
        self.exact = path == "reference"
        self.counts = self.report = None
        if self.status == 0:
            self.report = json.loads(result.stdout)
            self.seconds = self.report["seconds"]["processor"]
            with tifffile.TiffFile(stack) as tiff:
                stored = np.array([page.asarray() for page in tiff.pages])
            scale = 65535 / self.report["full_scale"] if stored.dtype.kind == "f" else 1
            self.counts = stored.astype(float) * scale
            os.remove(stack)


# ---- truths: each returns the fault, or nothing ----

def agreed(run):
    if run.status != 0:
        return run.says
    if not np.isfinite(run.counts).all():
        return "samples that are not finite"
    unexplained = 0 if run.exact else run.report["check"]["unexplained_pixels"]
    return f"{unexplained} pixels unexplained" if unexplained else None


def refused(run, *words):
    place = r"[^ :]+\.(scene|obj|csv):\d+:\d+: error: "
    if run.status != 2 or not re.match(place + ".*" + " ".join(words) + ".*\n$", run.says):
        return f"exit {run.status}: {run.says}"
    return None


def full(run):
    holes = int((run.counts.sum(axis=0) == 0).sum())
    return f"{holes} pixels show the background" if holes else None


def convex(run):
    seen = run.counts.sum(axis=0) > 0
    for axis in (0, 1):
        starts = np.diff(seen.astype(int), axis=axis, prepend=0) == 1
        if starts.sum(axis=axis).max() > 1:
            return "cracks or specks"
    return None


def even(run):
    spread = np.ptp(run.counts, axis=(1, 2)).max()
    return f"samples of a band differ by {spread} counts" if spread > 1 else None


def black(run):
    return f"{(run.counts != 0).sum()} samples are not 0" if run.counts.any() else None


def bounded(run):
    pixels = 0 if run.exact else run.report["check"]["unbounded_pixels"]
    return f"{pixels} pixels without a bound" if pixels else None


def unverified(run, path, paths):
    """Says where too much is checked, or too little."""
    if run.exact:
        return None
    report = run.report["check"]
    edges = report["open_edge_pixels"] if report["open_edge_pixels"] <= 0.25 * report["object_pixels"] else 0
    share = (report["unchecked_pixels"] - edges) / report["object_pixels"]
    return f"{100 * share} % are not checked" if (share > 0.01) != (path in paths) else None


def apart(run, other, counts, within, factor, exactly):
    """Says how far the samples of two runs are apart if they exceed the limit."""
    if other.counts is None:
        return f"the other scene: {other.says}"
    ratio = run.report["full_scale"] / other.report["full_scale"] / factor
    difference = np.sort(abs(counts * ratio - other.counts).max(axis=0).ravel())
    if not (exactly or run.exact):
        reports = run.report["check"], other.report["check"]
        within += sum(report["floor_worst_counts"] or 0 for report in reports)
        ambiguous = sum(report["ambiguous_pixels"] for report in reports)
        difference = difference[:max(len(difference) - ambiguous, 1)]
    return f"{difference[-1]} counts apart, not {within}" if difference[-1] > within else None


TRUTHS = {"agreed": agreed, "full": full, "convex": convex, "even": even, "black": black,
          "bounded": bounded}


def holds(runs, scene, path, words):
    run, word, rest = runs[scene.name, path], words[0], words[1:]
    if word == "refused" or (rest and word == "agreed" and run.counts is None):
        return refused(run, *words[words.index("refused") + 1:])
    if word == "seconds":
        return f"{run.seconds} seconds" if run.seconds > float(rest[0]) else None
    if run.counts is None:
        return run.says
    if word == "unverified":
        return unverified(run, path, rest)
    if word == "floor":
        counts = 0 if run.exact else run.report["check"]["floor_median_counts"]
        return f"only {counts} would be seen" if counts > float(rest[0]) else None
    if word == "smooth":
        pixels = int(rest[0]) if run.exact else run.report["check"]["smooth_pixels"]
        return f"{pixels} smooth pixels" if pixels != int(rest[0]) else None
    if word in TRUTHS:
        return TRUTHS[word](run)
    within = float(rest[-1]) if "within" in rest else 0
    factor = float(rest.pop(0)) if word == "times" else 1
    counts = run.counts[:, :, ::-1] if word == "mirror-of" else run.counts
    return apart(run, runs[rest[0], path], counts, within, factor, words[::2] == ["same-as"])


# ---- meshes too large for the repository ----

def fan():
    """A fan about a vertex at the centre of a pixel, wider than the picture."""
    rim = [f"v {4 * math.cos(turn):.9f} {4 * math.sin(turn):.9f} 0\n"
           for turn in (2 * math.pi * i / MANY for i in range(MANY))]
    faces = [f"f 1 {i + 2} {(i + 1) % MANY + 2}\n" for i in range(MANY)]
    write("fan.obj", "".join(["v 0 0 0\n", *rim, *faces]))


def crowd():
    """200,000 triangles within four pixels: each is smaller than the error of its corners."""
    side = 317
    at = [f"{2 * i / (side - 1) - 1:.9f}" for i in range(side)]
    faces = [f"f {i} {i + 1} {i + side + 1} {i + side}\n" for i in range(1, side * (side - 1)) if i % side]
    write("crowd.obj", "".join([f"v {x} {y} 0\n" for y in at for x in at] + faces))


def pile(name, depth):
    """Triangles behind one another; each covers the whole pixel."""
    rows = [f"v -1 -1 {z!r}\nv 3 -1 {z!r}\nv -1 3 {z!r}\nf -3//1 -2//1 -1//1\n"
            for z in map(depth, range(MANY))]
    write(name, "vn 0 0 1\n" + "".join(rows))


def sheets(n):
    """Squares above one another."""
    corners = (-1, -1), (1, -1), (1, 1), (-1, 1)
    write(f"sheets-{n}.obj", "".join(f"v {x} {1 + i / 500} {y}\n" for i in range(n) for x, y in corners) +
          "".join(f"f {i + 4} {i + 3} {i + 2} {i + 1}\n" for i in range(0, 4 * n, 4)))


def reach(name, near, aside, first, second):
    """A triangle from a point near the eye to a million away, and its mirror image behind the eye: the centre of the mesh is the
    eye, so that the near corner is nearly exact, and the others are off by 0.73 in depth."""
    corners = [(aside + near * bool(aside), 0, -near), (*first, -1e6), (*second, -1e6)]
    rows = [f"v {sign * x!r} {sign * y!r} {sign * z!r}\n" for sign in (1, -1) for x, y, z in corners]
    write(name, "".join(rows) + "f 1 2 3\nf 4 5 6\n")


def main():
    paths = [path for folder in FOLDERS for path in sorted(glob.glob(folder + "/*.scene"))]
    scenes = [Scene(path) for path in cases(paths, lambda path: os.path.basename(path)[:-6])]
    for folder in FOLDERS:
        shutil.copytree(folder, TMP, dirs_exist_ok=True)
    fan()
    crowd()
    sheets(256)
    sheets(512)
    reach("eye-reached.obj", 2, 0, (-3e5, -3e5), (3e5, -3e5))
    reach("eye-reached-beside.obj", 2, 0.5, (1e6 + 0.5, -3e5), (1e6 + 0.5, 3e5))
    reach("eye-cleared.obj", 8, 0, (-3e5, -3e5), (3e5, -3e5))
    pile("pile-apart.obj", lambda i: -1.9 + 1.8 * i / MANY)
    pile("pile-close.obj", lambda i: -1 + 1e-13 * i)
    pile("pile-equal.obj", lambda i: -1.0)
    keys = [(scene, path) for scene in scenes for path in PATHS]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        done_runs = pool.map(lambda key: Run(*key), keys)
        runs = {(scene.name, path): run for (scene, path), run in zip(keys, done_runs)}
    for scene in cases(scenes, lambda scene: scene.name):
        own = [runs[scene.name, path] for path in PATHS]
        if scene.holds[0][0] == "agreed" and ["black"] not in scene.holds:
            check(all(run.counts is None or run.counts.any() for run in own),
                  f"{scene.name}: the scene is not black")
        for truth in scene.holds:
            wrong = [(path, holds(runs, scene, path, list(truth))) for path in PATHS]
            check(all(remark is None for _, remark in wrong), f"{scene.name}: {' '.join(truth)}",
                  *(f"{path}: {remark}".strip() for path, remark in wrong if remark))
        if any("refused" in truth for truth in scene.holds):
            check(len({(run.status, run.says) for run in own}) == 1,
                  f"{scene.name}: every path gives the same result")
    done()


main()
