#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile python3-pil chromium gdal-bin imagemagick libgdk-pixbuf2.0-bin file python3-spectral octave
"""Runs the commands of the table in data/doc/tools.md with the real tools. Each row says whether a tool opens a stack, and
whether it shows the wavelength and the radiance scale of a page; the tool must print as much, and no more. Readers that
compare every sample are in stack_readers.py and recipes.py. Prints TAP."""
import base64
import os
import re
import shlex

import numpy as np
import tifffile
from PIL import Image

from browser import Browser
from documents import put_in_path, read, run
from rendered import TMP, check, done

COLUMNS = "tool", "opens the stack", "wavelengths", "radiance scale", "command", "otherwise", "verified by"
STACK = os.path.join(TMP, "stack.tif")
# Rows without a command that this test can run as it stands.
OTHERS = {"ImageJ 1.53": "`stack_readers.py`", "QGIS": "not run", "ISETCam's loader": "not run", "MATLAB": "not run",
          "a browser: Chromium": "`tools.py`"}


def rows():
    lines = [line for line in read("tools.md").splitlines() if line.startswith("|")]
    head, _, *body = ([cell.strip() for cell in line.strip("|").split("|")] for line in lines)
    check(tuple(head) == COLUMNS and all(len(row) == len(head) for row in body) and len(body) == 14, "14 tools, 7 columns")
    return [dict(zip(COLUMNS, row)) for row in body]


def says_yes(cell):
    return not cell.startswith("no")


class Page:
    """Page 17 of the stack that the table names, and the figures that a tool can print."""

    def __init__(self):
        command, = re.findall(r"^    (spectral render .*)$", read("tools.md"), re.MULTILINE)
        result = run(*shlex.split(command), "--quiet", cwd=TMP)
        check(result.returncode == 0, "the stack of the table is rendered", result.stdout)
        with tifffile.TiffFile(STACK) as tiff:
            label = tiff.pages[16].tags["PageName"].value
            self.first = tiff.pages[0].asarray()
            full_scale = re.search(r"full_scale: (\S+)", tiff.pages[0].description)[1]
            self.n_pages = len(tiff.pages)
        check(self.n_pages == 71 and label == "460 nm", "71 pages, and page 17 holds 460 nm")
        self.wavelength = re.compile(r"\b460\b")
        digits = f"{float(full_scale) / 65535:.15e}"[:12]
        self.scale = re.compile(f"{re.escape(full_scale)}|{re.escape(digits)}")
        self.size = re.compile(r"\b120\b.*\b80\b|\b80\b.*\b120\b", re.DOTALL)


def check_row(row, page):
    """A tool that does not open the stack must say so by its exit status, and show nothing of the page."""
    result = run("sh", "-c", row["command"].strip("`"), cwd=TMP)
    check(result.returncode != 127 and "ModuleNotFoundError" not in result.stdout, f"{row['tool']}: is installed",
          result.stdout)
    opened = result.returncode == 0 and bool(page.size.search(result.stdout))
    refused = result.returncode != 0
    check(opened if says_yes(row["opens the stack"]) else refused, f"{row['tool']}: opens: {row['opens the stack']}",
          result.returncode, result.stdout[-2000:])
    for column, pattern in (("wavelengths", page.wavelength), ("radiance scale", page.scale)):
        check(bool(pattern.search(result.stdout)) == says_yes(row[column]), f"{row['tool']}: {column}: {row[column]}",
              result.stdout[-2000:])


def check_viewer(page):
    """The viewer's loader shows page 1 in grey: 257 counts are one step of 8 bits, which it may cut off or round."""
    with Image.open(os.path.join(TMP, "thumbnail.png")) as picture:
        seen = np.asarray(picture.convert("RGB"), float)
    check(seen.shape == (80, 120, 3) and seen.max() > 0 and np.abs(seen - page.first[:, :, None] / 257).max() <= 1,
          "an image viewer: page 1, in grey")


# ---- a browser ----

PIXELS = """(async () => {
    const image = new Image();
    image.src = "data:image/%s;base64,%s";
    try { await image.decode(); } catch { return null; }
    const canvas = new OffscreenCanvas(image.naturalWidth, image.naturalHeight).getContext("2d");
    canvas.drawImage(image, 0, 0);
    return [canvas.canvas.width, canvas.canvas.height,
        ...canvas.getImageData(0, 0, canvas.canvas.width, canvas.canvas.height).data];
})()"""


def pixels_in(browser, path):
    """Width, height, and red, green, blue, alpha of each pixel; None if the browser cannot decode the picture."""
    with open(path, "rb") as file:
        data = base64.b64encode(file.read()).decode()
    return browser.evaluate(PIXELS % (path.rpartition(".")[2].replace("tif", "tiff"), data))


def check_picture(browser):
    """The browser shows the picture of `spectral develop`, whose profile it may round by 1 of 255."""
    png, tif = (os.path.join(TMP, "picture." + ending) for ending in ("png", "tif"))
    for path in png, tif:
        result = run("spectral", "develop", STACK, "-o", path)
        check(result.returncode == 0, f"develops {os.path.basename(path)}", result.stdout)
    width, height, *pixels = pixels_in(browser, png) or (0, 0)
    expected = tifffile.imread(tif)
    seen = np.array(pixels, int).reshape(height, width, 4)[:, :, :3]
    check(seen.shape == expected.shape and expected.max() > 0 and np.abs(seen - expected.astype(int)).max() <= 1,
          "a browser: shows the developed picture")


def check_browser(row):
    browser = Browser(os.path.join(TMP, "browser"))
    blank = os.path.join(TMP, "blank.html")
    with open(blank, "w", encoding="utf-8") as file:
        file.write('<!DOCTYPE html><body data-ready="true"></body>')
    browser.open(blank)
    check((pixels_in(browser, STACK) is not None) == says_yes(row["opens the stack"]),
          f"{row['tool']}: opens: {row['opens the stack']}")
    check_picture(browser)
    browser.close()


def main():
    put_in_path()
    page = Page()
    table = rows()
    unknown = [row["tool"] for row in table if row["verified by"].split(",")[0] != OTHERS.get(row["tool"], "`tools.py`")]
    check(not unknown, "the table says which rows this test verifies", *unknown)
    for row in table:
        if row["tool"] not in OTHERS:
            check_row(row, page)
    check_viewer(page)
    check_browser(next(row for row in table if "Chromium" in row["tool"]))
    done()


main()
