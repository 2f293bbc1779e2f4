#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Makes the pictures of README: every built-in scene, rendered, developed and stored as a PNG; maps of
checks; and the viewer, a plot and charts of costs, drawn by Chromium.
usage: /usr/bin/python3 test/make/gallery.py FOLDER [NAME...]"""
import base64
import os
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np
import tifffile

sys.dont_write_bytecode = True
sys.path.append("test/run")
from browser import Browser

SPECTRAL = os.environ.get("SPECTRAL", "build/spectral")
A, UV = ("--light", "1=a"), ("--light", "1=uv")
AUTO, ADAPTED = ("--exposure", "auto"), ("--adaptation", "cat16")
# name: scene, size, options of render, options of develop
PICTURES = {
    "colorchecker": ("colorchecker", "480x320", (), AUTO),
    "patches": ("patches", "480x320", (), AUTO),
    "spheres": ("spheres", "480x320", (), AUTO),
    "metals": ("metals", "480x320", (), AUTO),
    "textures": ("textures", "480x320", (), AUTO),
    "pasture": ("pasture", "480x320", (), AUTO),
    "room": ("room", "480x320", (), AUTO),
    "metamers": ("metamers", "480x240", (), AUTO),
    "metamers-a": ("metamers", "480x240", A, AUTO + ADAPTED),
    "metamers-camera": ("metamers", "480x240", (), AUTO + ("--detector", "dcs200-camera")),
    "fluorescence": ("fluorescence", "480x320", (), AUTO),
    "fluorescence-a": ("fluorescence", "480x320", A, AUTO + ADAPTED),
    "fluorescence-uv": ("fluorescence", "480x320", UV, AUTO),
    "patches-a": ("patches", "480x320", A, ()),
    "patches-fairchild": ("patches", "480x320", A, ("--adaptation", "fairchild")),
    "patches-von-kries": ("patches", "480x320", A, ("--adaptation", "von-kries")),
}

# name: scene, size, page of the map
MAPS = {"check-map": ("pasture", "480x320", "floor"), "check-map-band": ("pasture", "480x320", "floor in one band")}
# Colours of floors up to 1/16, 1/8, ... counts; the last one is not checked.
STEPS = np.array([(8, 29, 88), (34, 72, 155), (29, 120, 180), (45, 160, 190), (110, 195, 188), (180, 222, 190),
                  (225, 240, 190), (250, 245, 180), (254, 217, 118), (254, 178, 76), (253, 120, 50), (227, 50, 26),
                  (160, 10, 30), (90, 0, 40)], np.uint8)

# name: command that writes the page; its kind; width and height of the window; where to click
SEEN = {
    "viewer": (("view", "fluorescence", "--size", "600x400", "-o"), "html", (1100, 1250), (390, 160)),
    "probe": (("probe", "fluorescence", "700", "300", "--svg", "-o"), "svg", (900, 520), None),
    "cost": (("cost", "colorchecker", "--svg"), "svg", (800, 984), None),
    "cost-fluorescent": (("cost", "colorchecker", "--light", "1=fluorescent", "--svg"), "svg", (800, 984), None),
    "cost-fluorescence": (("cost", "fluorescence", "--svg"), "svg", (800, 1044), None),
}


def png(path, pixels):
    height, width, _ = pixels.shape
    up = np.diff(pixels, axis=0, prepend=np.zeros((1, width, 3), np.uint8))  # PNG's filter 2
    rows = b"".join(b"\2" + row.tobytes() for row in up)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0))
                  + chunk(b"sRGB", b"\0") + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def make(folder, name, scene, size, rendered, developed):
    with tempfile.TemporaryDirectory() as work:
        stack, picture = os.path.join(work, "stack.tif"), os.path.join(work, "picture.tif")
        subprocess.run([SPECTRAL, "render", scene, "--size", size, "-o", stack, "--quiet", *rendered],
                       check=True)
        subprocess.run([SPECTRAL, "develop", stack, "-o", picture, "--quiet", *developed], check=True)
        png(os.path.join(folder, name + ".png"), tifffile.imread(picture))


def show_map(folder, name, scene, size, page):
    with tempfile.TemporaryDirectory() as work:
        path = os.path.join(work, "map.tif")
        subprocess.run([SPECTRAL, "render", scene, "--size", size, "-o", "/dev/null", "--check-map", path, "--quiet"],
                       check=True)
        with tifffile.TiffFile(path) as tiff:
            floors = next(each.asarray() for each in tiff.pages if each.tags["PageName"].value == page)
        steps = np.ceil(np.log2(np.clip(floors, 1 / 16, 512))).astype(int) + 4
        png(os.path.join(folder, name + ".png"), STEPS[np.clip(steps, 0, len(STEPS) - 1)])


def see(folder, name, command, ending, size, click):
    with tempfile.TemporaryDirectory() as work:
        page = os.path.join(work, f"{name}.{ending}")
        subprocess.run([SPECTRAL, *command, page], check=True, stdout=subprocess.DEVNULL)
        browser = Browser(os.path.join(work, "browser"))
        browser.size(*size)
        browser.send("Page.navigate", url="file://" + page)
        browser.wait(f"location.href.endsWith('{ending}') && document.readyState === 'complete'")
        if click:
            browser.wait("document.body.dataset.ready === 'true'")
            browser.click(*click)
            browser.evaluate("new Promise(requestAnimationFrame)")
        shot = browser.send("Page.captureScreenshot", format="png")["data"]
        browser.close()
    with open(os.path.join(folder, name + ".png"), "wb") as out:
        out.write(base64.b64decode(shot))


for each in sys.argv[2:] or [*PICTURES, *MAPS, *SEEN]:
    if each in MAPS:
        show_map(sys.argv[1], each, *MAPS[each])
    elif each in SEEN:
        see(sys.argv[1], each, *SEEN[each])
    else:
        make(sys.argv[1], each, *PICTURES[each])
