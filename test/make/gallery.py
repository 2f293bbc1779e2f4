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
    "room": ("room", "450x300", (), AUTO),
    "room-uv": ("room", "450x300", ALL_UV, AUTO),
    "fluorescence": ("fluorescence", "450x300", (), AUTO),
    "fluorescence-uv": ("fluorescence", "450x300", UV, AUTO),
    "my-scene": ("my.scene", "600x400", (), AUTO),
    "patches-a": ("patches", "300x200", A, ()),
    "patches-fairchild": ("patches", "300x200", A, ("--adaptation", "fairchild")),
    "patches-von-kries": ("patches", "300x200", A, ("--adaptation", "von-kries")),
}

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


def opened(work, name):
    with Image.open(os.path.join(work, name + ".png")) as image:
        return image.convert("RGB")


def pasted(folder, name, size, *parts):
    """Puts pictures at their places into one."""
    whole = Image.new("RGB", size, "white")
    for image, place in parts:
        whole.paste(image, place)
    whole.save(os.path.join(folder, name + ".png"), optimize=True)


def room_checked(folder):
    """The room by day and by lamplight, above the map of its check."""
    with tempfile.TemporaryDirectory() as work:
        make(work, "day", "room", "420x280", (), AUTO)
        make(work, "lamp", "room", "420x280", ALL_A, AUTO + ("--adaptation", "fairchild"))
        subprocess.run([SPECTRAL, "render", "room", "--size", "420x280", "-o", "/dev/null", "--quiet", "--check-map",
                        os.path.join(work, "map.png")], check=True)
        day, lamp, checked = (opened(work, name) for name in ("day", "lamp", "map"))
        pasted(folder, "room-checked", (840, 560), (day, (0, 0)), (lamp, (420, 0)), (checked, (0, 280)))


def metamers(folder):
    """Metameric pairs by day, under a lamp, and to a camera."""
    with tempfile.TemporaryDirectory() as work:
        for number, (rendered, developed) in enumerate(METAMERS):
            make(work, str(number), "metamers", "300x150", rendered, developed)
        pasted(folder, "metamers", (900, 150), *((opened(work, str(number)), (300 * number, 0)) for number in range(3)))


def difference(folder):
    """The map that `compare` makes of the stacks of README."""
    with tempfile.TemporaryDirectory() as work:
        for name, options in ("vertices", ()), ("pixels", ("--shading", "phong", "--renderer", "raster")):
            subprocess.run([SPECTRAL, "render", "metals", "--size", "450x300", *options, "-o", name + ".tif", "--quiet"], check=True, cwd=work)
        subprocess.run([SPECTRAL, "compare", "vertices.tif", "pixels.tif", "--map",
                        os.path.abspath(os.path.join(folder, "difference.png")), "--tolerance", "20dE00", "--quiet"], check=True, cwd=work)


OTHERS = {"room-checked": room_checked, "metamers": metamers, "difference": difference}


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
    with Image.open(io.BytesIO(base64.b64decode(shot))) as image:  # 256 colours are enough for pages and plots
        image.convert("RGB").quantize(256).save(os.path.join(folder, name + ".png"), optimize=True)


for each in sys.argv[2:] or [*PICTURES, *OTHERS, *MAPS, *SEEN]:
    if each in OTHERS:
        OTHERS[each](sys.argv[1])
    elif each in MAPS:
        show_map(sys.argv[1], each, *MAPS[each])
    elif each in SEEN:
        see(sys.argv[1], each, *SEEN[each])
    else:
        make(sys.argv[1], each, *PICTURES[each])
