#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Makes the pictures of README and of the pages: every built-in scene, rendered and developed; maps of checks and differences; and
the viewer, a plot and charts of costs, drawn by Chromium.
usage: /usr/bin/python3 test/make/gallery.py FOLDER [NAME...]"""
import base64
import io
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
    "colorchecker": ("colorchecker", "450x300", (), AUTO),
    "patches": ("patches", "300x200", (), AUTO),
    "spheres": ("spheres", "450x300", (), AUTO),
    "metals": ("metals", "450x300", (), AUTO),
    "textures": ("textures", "450x300", (), AUTO),
    "pasture": ("pasture", "450x300", (), AUTO),
    "relief": ("relief", "450x300", (), AUTO),
    "room": ("room", "450x300", (), AUTO),
    "room-uv": ("room", "450x300", ALL_UV, AUTO),
    "fluorescence": ("fluorescence", "450x300", (), AUTO),
    "fluorescence-uv": ("fluorescence", "450x300", UV, AUTO),
    "my-scene": ("my.scene", "600x400", (), AUTO),
    "patches-a": ("patches", "300x200", A, ()),
    "patches-fairchild": ("patches", "300x200", A, ("--adaptation", "fairchild")),
    "patches-von-kries": ("patches", "300x200", A, ("--adaptation", "von-kries")),
}

SHEET = {"D65": "d65", "A, 2856 K": "a", "F2": "f2"}  # as seeing.md has it
METAMERS = (((), AUTO), (A + ("--ambient", "a*0.1"), AUTO + ADAPTED), ((), AUTO + ("--detector", "dcs200-camera")))

# name: scene, width, height, and the half of the map that is shown: the floor (0), or the floor in one band (1)
MAPS = {"check-map": ("pasture", 480, 320, 0), "check-map-band": ("pasture", 480, 320, 1)}

# name: command that writes the page; its kind; width and height of the window (of a plot: its own); where to click
SEEN = {
    "viewer": (("view", "room", "--size", "900x600", "-o"), "html", (1400, 900), (610, 430)),
    "probe": (("probe", "fluorescence", "700", "300", "--svg", "-o"), "svg", None, None),
    "cost": (("cost", "colorchecker", "--svg"), "svg", None, None),
    "cost-fluorescent": (("cost", "colorchecker", "--light", "1=fluorescent", "--svg"), "svg", None, None),
    "cost-fluorescence": (("cost", "fluorescence", "--svg"), "svg", None, None),
}


def run(*words):
    subprocess.run([SPECTRAL, *words, "--quiet"], check=True, cwd=WORK)


def make(folder, name, scene, size, rendered, developed):
    means = () if scene == "my.scene" else SMOOTH  # README shows the commands of its own scene
    # the picture records the name of its stack, as it is given
    run("render", scene, "--size", size, *means, "-o", name + ".tif", *rendered)
    run("develop", name + ".tif", "-o", os.path.abspath(os.path.join(folder, name + ".png")), *developed)


def show_map(folder, name, scene, width, height, half):
    run("render", scene, "--size", f"{width}x{height}", "-o", "/dev/null", "--check-map", "map.png")
    opened("map").crop((half * width, 0, (half + 1) * width, height)).save(os.path.join(folder, name + ".png"))


def opened(name):
    with Image.open(os.path.join(WORK, name + ".png")) as image:
        return image.convert("RGB")


def pasted(folder, name, size, *parts):
    """Puts pictures at their places into one."""
    whole = Image.new("RGB", size, "white")
    for image, place in parts:
        whole.paste(image, place)
    whole.save(os.path.join(folder, name + ".png"), optimize=True)


def room_checked(folder):
    """The room by day and by lamplight, above the map of its check."""
    make(WORK, "day", "room", "420x280", (), AUTO)
    make(WORK, "lamp", "room", "420x280", ALL_A, AUTO + ("--adaptation", "fairchild"))
    run("render", "room", "--size", "420x280", "-o", "/dev/null", "--check-map", "map.png")
    pasted(folder, "room-checked", (840, 560), (opened("day"), (0, 0)), (opened("lamp"), (420, 0)), (opened("map"), (0, 280)))


def metamers(folder):
    """Metameric pairs by day, under a lamp, and to a camera."""
    for number, (rendered, developed) in enumerate(METAMERS):
        make(WORK, str(number), "metamers", "300x150", rendered, developed)
    pasted(folder, "metamers", (900, 150), *((opened(str(number)), (300 * number, 0)) for number in range(3)))


def lights(folder):
    """A sheet of metameric pairs under three lamps."""
    for light in SHEET.values():
        run("render", "metamers", "--size", "300x150", "--light", f"1={light}", "--ambient", light + "*0.1", "-o", light + ".tif")
    stacks = [f"{name}={light}.tif" for name, light in SHEET.items()]
    subprocess.run([sys.executable, os.path.abspath("data/samples/sheet.py"), *stacks, "-o", os.path.abspath(os.path.join(folder, "lights.png")),
                    *AUTO, *ADAPTED], check=True, cwd=WORK, env={**os.environ, "PATH": os.path.dirname(SPECTRAL) + ":" + os.environ["PATH"]}, stdout=subprocess.DEVNULL)


def difference(folder):
    """The map that `compare` makes of the stacks of README."""
    for name, options in ("vertices", ()), ("pixels", ("--shading", "phong", "--renderer", "raster")):
        run("render", "metals", "--size", "450x300", *options, "-o", name + ".tif")
    run("compare", "vertices.tif", "pixels.tif", "--map", os.path.abspath(os.path.join(folder, "difference.png")), "--tolerance", "20dE00")


def gpu(folder):
    """The page of `verify --page` by Mesa's llvmpipe."""
    page = os.path.join(WORK, "gpu.html")
    subprocess.run([SPECTRAL + "-live", "verify", "--page", page], check=True, stdout=subprocess.DEVNULL)
    browser = Browser(os.path.join(WORK, "browser"), ("--use-angle=gl-egl", "--ignore-gpu-blocklist", "--enable-gpu"))
    browser.size(1100, 560)
    browser.open(page)
    save_shot(browser, folder, "gpu")


OTHERS = {"room-checked": room_checked, "metamers": metamers, "lights": lights, "difference": difference, "gpu": gpu}


def plot_size(path):
    with open(path, encoding="utf-8") as plot:
        return tuple(int(side) for side in re.search(r'width="(\d+)" height="(\d+)"', plot.read()).groups())


def see(folder, name, command, ending, size, click):
    page = os.path.join(WORK, f"{name}.{ending}")
    subprocess.run([SPECTRAL + "-live" if click else SPECTRAL, *command, page], check=True, stdout=subprocess.DEVNULL)
    browser = Browser(os.path.join(WORK, "browser"))
    browser.size(*(size or plot_size(page)))
    browser.send("Page.navigate", url="file://" + page)
    browser.wait(f"location.href.endsWith('{ending}') && document.readyState === 'complete'")
    if click:
        browser.wait("document.body.dataset.ready === 'true'")
        browser.wait("document.getElementById('gallery').hidden || document.body.dataset.gallery === 'true'")
        browser.settle()
        browser.click(*click)
        browser.settle()
    save_shot(browser, folder, name)


def save_shot(browser, folder, name):
    shot = browser.send("Page.captureScreenshot", format="png")["data"]
    browser.close()
    with Image.open(io.BytesIO(base64.b64decode(shot))) as image:  # 256 colours are enough for pages and plots
        image.convert("RGB").quantize(256).save(os.path.join(folder, name + ".png"), optimize=True)


with tempfile.TemporaryDirectory() as WORK:
    with open("README.md", encoding="utf-8") as readme:  # has the files of my.scene: ```scene my.scene
        for file, text in re.findall(r"^```\w+ (\S+[.]\S+)\n(.*?)^```$", readme.read(), re.MULTILINE | re.DOTALL):
            with open(os.path.join(WORK, file), "w", encoding="utf-8") as out:
                out.write(text)
    for each in sys.argv[2:] or [*PICTURES, *OTHERS, *MAPS, *SEEN]:
        if each in OTHERS:
            OTHERS[each](sys.argv[1])
        elif each in MAPS:
            show_map(sys.argv[1], each, *MAPS[each])
        elif each in SEEN:
            see(sys.argv[1], each, *SEEN[each])
        else:
            make(sys.argv[1], each, *PICTURES[each])
