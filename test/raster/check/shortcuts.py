#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: libosmesa6-dev
"""Shortcuts change nothing: the program without them (see SHORTCUTS) reports of each hard and
each built-in scene what the program reports. Prints TAP."""
import concurrent.futures
import json
import os
import shutil
import subprocess
from pathlib import Path

from rendered import SPECTRAL, TMP, check, done, path_of, write

BUILD = os.environ.get("BUILD", "build")
# Text of a file that takes a shortcut, and what takes none.
SHORTCUTS = (("raster/candidates/fragments.c", "    return plain;\n", "    return plain && false;\n"),
             ("raster/candidates/triangle.c", "if (is_inside(polygon, &plane))", "if (false && is_inside(polygon, &plane))"))
# Two corners a rounding inside of the picture's border, which clipping may cut off.
CORNERS = "v -1.99999999 -1.5 0\nv -1.99999998 1.5 0\nv 0.3 1.7 0\nv -1.99999999 -1.5 0.5\nv 2.5 -1 0.5\nv 0.3 1.7 0.5\nf 1 2 3\nf 4 5 6\n"
BORDER = "wavelengths 400 700 20\nsize 48 48\ncamera ortho 4\nlight d65 1 direction 0 0 1\nmaterial m { diffuse 0.5 }\n" \
         "object mesh corners.obj two-sided material m\n"


def without_shortcuts():
    """Builds the program in a copy of its sources. Returns its path; None: it does not build."""
    folder = os.path.abspath(os.path.join(TMP, "sources"))
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(".", folder, symlinks=True, ignore=lambda at, _: {".git", os.path.basename(BUILD)} if at == "." else ())
    for name, old, new in SHORTCUTS:
        path = Path(folder, name)
        text = path.read_text(encoding="utf-8")
        check(text.count(old) == 1, f"{name} takes the shortcut at one place", old)
        path.write_text(text.replace(old, new), encoding="utf-8")
    built = subprocess.run(["./build.sh"], cwd=folder, env={**os.environ, "BUILD": "build"}, capture_output=True, text=True)
    check(built.returncode == 0, "the program without shortcuts is built", built.stderr[-500:])
    return os.path.join(folder, "build", "spectral")


def report(program, scene):
    size = ("--size", "300x200") if "/" not in scene else ()
    result = subprocess.run([program, "render", scene, *size, "--quiet", "--json", "-", "-o", "/dev/null"], capture_output=True, text=True)
    return json.loads(result.stdout)["check"] if result.returncode in (0, 1) else result.stderr


write("corners.obj", CORNERS)
scenes = [write("border.scene", BORDER), *(f"{folder}{path.stem}" for folder, of in (("hard/", "hard"), ("", "scenes"))
                                           for path in sorted(Path("data/builtin", of).glob("*.scene")))]
bare = without_shortcuts()
with concurrent.futures.ThreadPoolExecutor(2) as pool:
    reports = pool.map(lambda scene: (report(SPECTRAL, scene), report(bare, scene)), scenes)
different = [scene for scene, (one, other) in zip(scenes, reports) if one != other]
check(len(scenes) > 100 and not different, f"{len(scenes)} scenes have the same reports without shortcuts", *different)
shutil.rmtree(path_of("sources"), ignore_errors=True)
done()
