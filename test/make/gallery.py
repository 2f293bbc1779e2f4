#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Makes the pictures of README: every built-in scene, rendered and developed; maps of checks; and the viewer, a plot
and charts of costs, drawn by Chromium.
usage: /usr/bin/python3 test/make/gallery.py FOLDER [NAME...]"""
import base64
import os
import re
import subprocess
import sys
import tempfile

from PIL import Image

sys.dont_write_bytecode = True
sys.path.append("test/shared")
from browser import Browser

SPECTRAL = os.path.abspath(os.environ.get("SPECTRAL", "build/spectral"))
A, UV = ("--light", "1=a"), ("--light", "1=uv")
ALL_A, ALL_UV = ([word for i in range(1, 9) for word in ("--light", f"{i}={light}")] + ["--ambient", light + "*0.24"]
                 for light in ("a", "uv"))
AUTO, ADAPTED = ("--exposure", "auto"), ("--adaptation", "cat16")
SMOOTH = ("--samples", "4")
# name: scene, size, options of render, options of develop
PICTURES = {
    "colorchecker": ("colorchecker", "1200x800", (), AUTO),
    "patches": ("patches", "1200x800", (), AUTO),
    "spheres": ("spheres", "1200x800", (), AUTO),
    "metals": ("metals", "1200x800", (), AUTO),
    "textures": ("textures", "1200x800", (), AUTO),
    "pasture": ("pasture", "1200x800", (), AUTO),
    "room": ("room", "1200x800", (), AUTO),
    "room-a": ("room", "1200x800", ALL_A, AUTO + ("--adaptation", "fairchild")),
    "room-uv": ("room", "1200x800", ALL_UV, AUTO),
    "metamers": ("metamers", "1200x600", (), AUTO),
    "metamers-a": ("metamers", "1200x600", A + ("--ambient", "a*0.1"), AUTO + ADAPTED),
    "metamers-camera": ("metamers", "1200x600", (), AUTO + ("--detector", "dcs200-camera")),
    "fluorescence": ("fluorescence", "1200x800", (), AUTO),
    "fluorescence-a": ("fluorescence", "1200x800", A, AUTO + ADAPTED),
    "fluorescence-uv": ("fluorescence", "1200x800", UV, AUTO),
    "my-scene": ("my.scene", "1200x800", (), AUTO),
    "patches-a": ("patches", "1200x800", A, ()),
    "patches-fairchild": ("patches", "1200x800", A, ("--adaptation", "fairchild")),
    "patches-von-kries": ("patches", "1200x800", A, ("--adaptation", "von-kries")),
}

# name: scene, width, height, and the half of the map that is shown: the floor (0), or the floor in one band (1)
MAPS = {"check-map": ("pasture", 480, 320, 0), "check-map-band": ("pasture", 480, 320, 1)}

# name: command that writes the page; its kind; width and height of the window (of a plot: its own); where to click
SEEN = {
    "viewer": (("view", "room", "--size", "900x600", "-o"), "html", (1400, 900), (610, 430)),
    "viewer-gallery": (("view", "--gallery", "--size", "600x400", "-o"), "html", (1400, 900), (600, 330)),
    "probe": (("probe", "fluorescence", "700", "300", "--svg", "-o"), "svg", None, None),
    "cost": (("cost", "colorchecker", "--svg"), "svg", None, None),
    "cost-fluorescent": (("cost", "colorchecker", "--light", "1=fluorescent", "--svg"), "svg", None, None),
    "cost-fluorescence": (("cost", "fluorescence", "--svg"), "svg", None, None),
}


def readme_files():
    """the files that README gives: ```scene my.scene"""
    with open("README.md", encoding="utf-8") as readme:
        blocks = re.findall(r"^```\w+ (\S+[.]\S+)\n(.*?)^```$", readme.read(), re.MULTILINE | re.DOTALL)
    return dict(blocks)


def make(folder, name, scene, size, rendered, developed):
    picture = os.path.abspath(os.path.join(folder, name + ".png"))
    files = readme_files()
    means = () if scene in files else SMOOTH  # README shows the commands of its own scene
    with tempfile.TemporaryDirectory() as work:  # the picture records the name of its stack, as it is given
        for file, text in files.items():
            with open(os.path.join(work, file), "w", encoding="utf-8") as out:
                out.write(text)
        for words in (("render", scene, "--size", size, *means, "-o", name + ".tif", *rendered),
                      ("develop", name + ".tif", "-o", picture, *developed)):
            subprocess.run([SPECTRAL, *words, "--quiet"], check=True, cwd=work)


def show_map(folder, name, scene, width, height, half):
    with tempfile.TemporaryDirectory() as work:
        path = os.path.join(work, "map.png")
        subprocess.run([SPECTRAL, "render", scene, "--size", f"{width}x{height}", "-o", "/dev/null", "--quiet",
                        "--check-map", path], check=True)
        with Image.open(path) as image:
            image.crop((half * width, 0, (half + 1) * width, height)).save(os.path.join(folder, name + ".png"))


def plot_size(path):
    with open(path, encoding="utf-8") as plot:
        return tuple(int(side) for side in re.search(r'width="(\d+)" height="(\d+)"', plot.read()).groups())


def see(folder, name, command, ending, size, click):
    with tempfile.TemporaryDirectory() as work:
        page = os.path.join(work, f"{name}.{ending}")
        subprocess.run([SPECTRAL + "-live" if click else SPECTRAL, *command, page], check=True, stdout=subprocess.DEVNULL)
        browser = Browser(os.path.join(work, "browser"))
        browser.size(*(size or plot_size(page)))
        browser.send("Page.navigate", url="file://" + page)
        browser.wait(f"location.href.endsWith('{ending}') && document.readyState === 'complete'")
        if click:
            browser.wait("document.body.dataset.ready === 'true'")
            browser.wait("document.getElementById('gallery').hidden || document.body.dataset.gallery === 'true'")
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
