#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile python3-gdal gdal-bin parallel make; makes: faults
"""Runs each command of the column "use instead" in CHANGELOG's table as it stands there, in a folder with the files that it names. Left
out are those of build.sh, which other tests run. A scene that fails fails by a planted fault. Prints TAP."""
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
from osgeo import gdal

from tap import check, done

gdal.UseExceptions()
BUILD = os.path.abspath(os.environ.get("BUILD", "build"))
FOLDER = os.path.join(BUILD, "tmp", "instead")
SCENE = """size 60 40
wavelengths 400 700 20
light d65 1 direction 0 0 1
material red { diffuse paint.csv }
object sphere 0.3 20 20 material red
"""


def prepare():
    shutil.rmtree(FOLDER, ignore_errors=True)
    shutil.copytree("data/samples", FOLDER)
    for name, text in (("a.scene", SCENE), ("failing.scene", SCENE), ("list.txt", "a.scene -o listed.tif\n")):
        Path(FOLDER, name).write_text(text, encoding="ascii")
    cube = gdal.GetDriverByName("ENVI").Create(os.path.join(FOLDER, "cube.img"), 6, 4, 3, gdal.GDT_Float32)
    for band in range(3):
        cube.GetRasterBand(band + 1).WriteArray(np.full((4, 6), 0.25 * (band + 1), np.float32))
    del cube
    with open(os.path.join(FOLDER, "cube.hdr"), "a", encoding="ascii") as header:
        header.write("wavelength units = Nanometers\nwavelength = {450, 550, 650}\n")
    page = Path("data/doc/parts.md").read_text(encoding="utf-8")
    Path(FOLDER, "Makefile").write_text(re.search(r"^```make Makefile\n(.*?)^```", page, re.DOTALL | re.MULTILINE).group(1), encoding="ascii")


def commands():
    """The words behind backticks that begin with the name of a program."""
    changes = Path("CHANGELOG.md").read_text(encoding="utf-8")
    rows = re.search(r"^\| was \| use instead \|\n\|[-|]+\|\n((?:\|.*\n)+)", changes, re.MULTILINE).group(1).splitlines()
    for row in rows:
        right = re.split(r"(?<!\\)\|", row)[2].replace("\\|", "|")
        for command in re.findall(r"`([^`]+)`", right):
            if command.split()[0] in ("sed", "make", "spectral", "gdal_translate", "python3"):
                yield command


def main():
    prepare()
    found = list(commands())
    check(len(found) >= 12, "the table has commands", found)
    os.makedirs(os.path.join(FOLDER, "bin"))
    os.symlink(os.path.join(BUILD, "spectral"), os.path.join(FOLDER, "bin", "spectral"))
    for command in found:
        environment = {**os.environ, "SPECTRAL": os.path.join(BUILD, "spectral"), "PATH": os.path.join(FOLDER, "bin") + ":" + os.environ["PATH"]}
        if "failing.scene" in command:
            environment.update(LD_PRELOAD=os.path.abspath(os.environ.get("FAULTS", "build/test/fault.so")), FAULT="52")
        ran = subprocess.run(["bash", "-c", "set -o pipefail; " + command], cwd=FOLDER, env=environment, stdin=subprocess.DEVNULL,
                             capture_output=True, text=True, timeout=600, check=False)
        check(ran.returncode == 0, command, ran.returncode, ran.stdout[-500:], ran.stderr[-500:])
    for name in ("listed.tif", "a.tif", "a.tar", "whole.tif", "cube.tif", "case/case.scene", "case/case.c", "few.tif", "cost.csv"):
        check(os.path.getsize(os.path.join(FOLDER, name)) > 0 if os.path.exists(os.path.join(FOLDER, name)) else False,
              f"{name} is there")
    done()


main()
