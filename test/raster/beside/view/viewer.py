#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile python3-pil python3-gdal pngcheck chromium; makes: live
"""Tests the viewer's page in a headless Chromium: its pixels, spectra and numbers equal those of the program's own
commands for every choice in the menus. All of it is usable by pointer and keyboard, on a phone and in the dark.
Prints TAP."""
import base64
import io
import os
import re
import shutil
import subprocess

import numpy as np
import tifffile
from PIL import Image
from osgeo import gdal

from browser import Browser
from colours import OWN_DISPLAYS, ciede2000
from rendered import LIVE, SPECTRAL, TMP, built_in, check, developed, done, objects_of, output_of, pages_of, path_of, reference, write, write_camera

gdal.UseExceptions()
SIZE = "120x80"
PROGRAM = os.path.abspath(SPECTRAL)
browser = Browser(path_of("browser"))

STRANGE = 'a </script><b>&amp; \\ <!-- <script>'  # a name with characters that HTML, JSON and JavaScript interpret


def write_matrix():
    write("matrix.csv", "nm,360,400,440\n480,0.02,0.1,0.05\n520,0.05,0.2,0.1\n560,0.01,0.1,0.05\n")


def scene_of_strange_names():
    """A scene with a light that is off, a light from a file, a surface that fluoresces by a matrix, and a back."""
    write_matrix()
    write("lamp.csv", "wavelength_nm,power\n380,0.4\n500,1.2\n600,0.9\n720,1.5\n")
    grey = "material grey { diffuse 0.5 }"
    return write("a 'strange' & <b>name.scene", f"""wavelengths 400 700 20
camera ortho 3
viewer local
shading flat
ambient lamp.csv 0.2
light daylight:5003 0 direction 0 0 1
light lamp.csv 0.8 position 2 1 4 attenuation 0.5 0 0.02
material "{STRANGE}" {{ diffuse 0.3 donaldson matrix.csv specular 0.5 gloss 9 }}
{grey}
object sphere 0.6 20 20 material "{STRANGE}" translate -0.7 0 0
object plane 1 1 material grey two-sided rotate 160 0 1 0 translate 0.7 0 0
""")


def scene_of_two_of_each():
    """A scene with two ambient lights, where one makes a surface fluoresce, and spectral textures."""
    write_matrix()
    reference("texture.tif", "patches", "--size", "16x12", "--wavelengths", "420:680:20")
    return write("two.scene", """wavelengths 400 700 20
camera ortho 3
ambient daylight:6504 0.4
ambient uv 0.9
material glowing { diffuse 0.3 donaldson matrix.csv }
material near { diffuse 0.9 spectral-texture texture.tif nearest }
material smooth { diffuse 0.9 spectral-texture texture.tif linear }
object sphere 0.6 20 20 material glowing
object plane 0.7 0.9 material near translate -1 0 0
object plane 0.7 0.9 material smooth translate 1 0 0
""")


# ---- the program ----

kind = [PROGRAM]  # the program whose pages are tested


def view(scene, name, *options):
    path = path_of(name + ".html")
    output_of("view", scene, "-o", path, "--quiet", *(options or ("--size", SIZE)), program=kind[0])
    return path


def rendered(scene, *options):
    return reference("stack.tif", scene, "--size", SIZE, *options)


# ---- the page ----

def distance(seen, expected):
    return int(np.abs(seen[:, :, :3].astype(int) - expected[:, :, :3].astype(int)).max())


# ---- menus ----

# Lights as --light and --ambient take them, then options of develop.
COMBINATIONS = {
    "colorchecker": [
        ({}, []),
        ({"ambient": "fluorescent*0.25", 1: "a*0.7"}, ["--adaptation=von-kries"]),
        ({1: "a*1"}, ["--adaptation=fairchild", "--detector=cie1964"]),
        ({1: "fluorescent*0.5"}, ["--adaptation=fairchild:250", "--display=monitor"]),
        ({1: "d50*1.5"}, ["--adaptation=bradford", "--exposure=auto"]),
        ({1: "a*0.4", "ambient": "uv*0.6"},
         ["--adaptation=cat16", "--exposure=2.5", "--detector=cie-standard-deviate"]),
    ],
    "fluorescence": [
        ({1: "uv*1"}, []),
        ({1: "a*0.6", "ambient": "uv*0.8"}, ["--detector=dcs200-camera"]),
        ({1: "e*0.9"}, ["--detector=transparency-film", "--display=monitor", "--exposure=auto"]),
        ({1: "led-b5*0.7", "ambient": "f11*0.2"}, ["--adaptation=cat16"]),
    ],
    "metamers": [
        ({1: "a*1"}, ["--adaptation=cat16", "--detector=cie2006-2"]),
        ({1: "fluorescent*0.8"}, ["--detector=dcs200-camera", "--exposure=0.7"]),
    ],
    "room": [
        ({}, []),
        ({"ambient": "e*0.1", 1: "d65*0", 2: "uv*0.5", 3: "a*1"},
         ["--adaptation=bradford", "--detector=cie2006-10"]),
        ({2: "fluorescent*0.4"}, ["--detector=transparency-film", "--exposure=1.5"]),
    ],
}


# The object that a page opens with: it has the most pixels, but for one behind all others.
OPENS = {"colorchecker": "01-dark-skin (torus)", "fluorescence": "white, ", "metamers": "half (", "room": "rug (mesh)"}


def set_lights(lights):
    for light, lamp in lights.items():
        menu = "ambients-1" if light == "ambient" else f"lights-{light}"
        name, intensity = lamp.rsplit("*", 1)
        browser.choose(menu, name)
        browser.put(menu + "-intensity", intensity)


def figures(words):
    return np.array(re.findall(r"\d+(?:\.\d+)?", words), float)


def per_cent(words):
    """The numbers before per cent signs; the page shows them to a tenth."""
    return np.array(re.findall(r"([\d.]+)\s%", words), float)


def out_of_gamut(words):
    return int(words.split("out of gamut")[1].split()[0])


def light_options(lights):
    return [f"--ambient={lamp}" if light == "ambient" else f"--light={light}={lamp}"
            for light, lamp in lights.items()]


def menus(scene):
    what_kind = "still" if kind == [PROGRAM] else "live"
    browser.open(view(scene, scene))
    picked, surface, colour = browser.evaluate("[element('picked').textContent, shown[pixel], element('objects').value]")
    check(OPENS[scene] in picked and str(surface) == colour, f"{what_kind} {scene}: opens with {OPENS[scene]}", picked)
    for lights, options in COMBINATIONS[scene]:
        browser.evaluate("controls.reset()")
        browser.settle()
        set_lights(lights)
        browser.see_by(options)
        expected, words = developed(rendered(scene, *light_options(lights)), *options)
        seen = browser.pixels()
        what = " ".join(light_options(lights) + options) or "as it is"
        check(distance(seen, expected) <= 1 and seen[:, :, :3].max() > 30 and (seen[:, :, 3] == 255).all(),
              f"{what_kind} {scene}, {what}: pixels are within 1 of 255 of develop's picture",
              f"largest distance {distance(seen, expected)}")
        differ = np.mean(seen[:, :, :3] != expected)  # a fifth of it, by rounding to 16 bits
        check(differ < 0.01, f"{what_kind} {scene}, {what}: 99 of 100 samples are equal to develop's", differ)
        lost, unseen = per_cent(browser.text("lost")), per_cent(words.split("unseen")[1].split("\n")[0])
        check(np.abs(lost - unseen).max() <= 0.051,
              f"{what_kind} {scene}, {what}: the lost part of the sensitivity equals develop's",
              lost, unseen)
        if "observer" in words:
            white, recorded = figures(browser.text("white")), figures(words.split("white")[1].split("\n")[0])
            check(np.allclose(white, [*recorded[3:], recorded[1]], atol=0.006) and
                  np.allclose(white[:2], recorded[3:], atol=6e-5),
                  f"{what_kind} {scene}, {what}: the white is the one that develop prints", white, recorded)
        counted = int(browser.text("gamut").split(":")[1].split()[0])
        check(abs(counted - out_of_gamut(words)) <= expected[:, :, 0].size // 1000,
              f"{what_kind} {scene}, {what}: the number of pixels out of gamut is right to a thousandth",
              f"{counted}, develop says {out_of_gamut(words)}")
    browser.evaluate("controls.reset()")
    browser.settle()
    expected, _ = developed(rendered(scene), "--exposure=auto")
    check(distance(browser.pixels(), expected) <= 1, f"{what_kind} {scene}: reset shows the original scene, its exposure automatic")


# ---- the first picture ----

def first_pictures():
    """A page contains its first picture, at the place and in the size of the later ones, without any program."""
    corners = "(b => [b.left, b.top, b.width, b.height])(document.getElementById('%s').getBoundingClientRect())"
    expected, _ = developed(rendered("spheres"), "--exposure=auto")
    for program, kind_of_page in ((PROGRAM, "still"), (LIVE, "live")):
        path = path_of("first.html")
        output_of("view", "spheres", "-o", path, "--quiet", "--size", SIZE, program=program)
        packed = re.search('<img id="first"[^>]*src="data:image/png;base64,([^"]*)">', open(path).read())[1]
        with Image.open(io.BytesIO(base64.b64decode(packed, validate=True))) as image:
            seen = np.asarray(image)
        check(distance(seen, expected) <= 1 and np.mean(seen != expected) < 0.01,
              f"the {kind_of_page} page contains the picture of develop --exposure auto", distance(seen, expected))
        browser.send("Emulation.setScriptExecutionDisabled", value=True)
        browser.open(path, until="document.getElementById('first')?.complete && document.readyState === 'complete'")
        before = browser.evaluate(corners % "first")
        browser.send("Emulation.setScriptExecutionDisabled", value=False)
        browser.open(path)
        after = browser.evaluate(corners % "picture")
        check(before[2] > 100 and np.allclose(before, after, atol=[20, 30, 0.1, 0.1]) and browser.evaluate("!element('first')"),
              f"the {kind_of_page} page shows it without JavaScript, where its canvas stands later", before, after)


# ---- still pictures ----

def still(scene, *options):
    """The picture that view writes, and its bytes."""
    path = path_of("still.png")
    output_of("view", scene, "-o", path, "--quiet", *options)
    with Image.open(path) as image:
        return np.asarray(image), open(path, "rb").read()


def exposures():
    """The PNG of view and each kind of page begin with the same exposure, which a reset of the page brings back."""
    lamp = "--light=1=f11"
    stack = rendered("patches", lamp)
    for given, meant in (None, "auto"), ("auto", "auto"), ("0.07", "0.07"), ("1e0", "1"):
        words = [f"--exposure={given}"] if given else []
        expected, _ = developed(stack, f"--exposure={meant}")
        seen, _ = still("patches", "--size", SIZE, lamp, *words)
        check(distance(seen, expected) <= 1 and np.ptp(expected) > 100, f"--exposure {given}: the PNG of view is develop's picture", distance(seen, expected))
        check(meant == "1" or np.mean((seen == 255).all(2)) < 0.05, f"--exposure {given}: it is not burnt out under a bright lamp")
        for kind[:], subject in ([PROGRAM], "patches"), ([LIVE], "patches"), ([PROGRAM], stack):
            browser.open(view(subject, "exposed", *words, *(["--size", SIZE, lamp] if subject == "patches" else ["--display=srgb"])))
            opened = browser.pixels()
            browser.tick("auto", meant != "auto")
            browser.put("exposure", 0.01)
            browser.evaluate("controls.reset()")
            browser.settle()
            check(distance(opened, expected) <= 1 and distance(browser.pixels(), expected) <= 1 and browser.message() == "",
                  f"--exposure {given}: so opens a page of {os.path.basename(subject)} of {os.path.basename(kind[0])}, and so it is reset",
                  distance(opened, expected), distance(browser.pixels(), expected))
    kind[:] = [PROGRAM]


def stills():
    auto = "--exposure=auto"
    for scene in COMBINATIONS:
        browser.open(view(scene, scene))
        shown, expected = browser.pixels(), developed(rendered(scene), auto)[0]
        seen, _ = still(scene, "--size", SIZE)
        check(distance(seen, expected) <= 1 and np.mean(seen != expected) < 0.01 and np.ptp(expected) > 100,
              f"{scene}: the PNG of view is within 1 of 255 of develop's picture", distance(seen, expected))
        check(distance(seen, shown) <= 1, f"{scene}: and of what the page shows", distance(seen, shown))
    lamp = "--light=1=a*0.7", "--ambient=fluorescent*0.2"
    expected, _ = developed(rendered("metamers", *lamp), auto)
    seen, _ = still("metamers", "--size", SIZE, *lamp)
    check(distance(seen, expected) <= 1, "the PNG of view shows the lights of the command line")
    camera = f"--detector={write_camera()}"
    expected, _ = developed(rendered("metamers"), camera, auto)
    seen, _ = still("metamers", "--size", SIZE, camera)
    check(distance(seen, expected) <= 1, "the PNG of view sees with a detector of one's own", distance(seen, expected))
    for subject, words in (("metamers", ("--size", SIZE, camera)), (rendered("metamers"), (camera,))):
        browser.open(view(subject, "camera", *words))
        check(distance(browser.pixels(), expected) <= 1 and browser.evaluate("eye.detector.name") == camera.split("=")[1],
              f"and so does a page of {os.path.basename(subject)}", distance(browser.pixels(), expected))
    wide = "--size", "8300x20"  # two tiles side by side
    expected, _ = developed(rendered("room", *wide), auto)
    pictures = [still("room", *wide, "--threads", threads) for threads in ("1", "2", "5")]
    check(distance(pictures[0][0], expected) <= 1, "the PNG of view has several tiles")
    check(pictures[0][1] == pictures[1][1] == pictures[2][1], "1, 2 and 5 threads give the same PNG")
    subprocess.run(["pngcheck", "-q", path_of("still.png")], check=True)


def own_display():
    """A display by its numbers is in the menu of each page, which shows it first. Live pages have the file."""
    path = write("my crt.csv", OWN_DISPLAYS["crt"].text())
    stack, display = rendered("metamers"), f"--display={path}"
    pictures = {name: developed(stack, f"--display={name}", "--exposure=0.8")[0] for name in (path, "srgb", "monitor")}
    first, _ = developed(stack, display, "--exposure=auto")
    for kind[:] in ([LIVE], [PROGRAM]):
        for subject, words in (("metamers", ("--size", SIZE)), (stack, ())):
            page, which = view(subject, "display", *words, display), f"{'still' if kind == [PROGRAM] else 'live'} page of {os.path.basename(subject)}"
            packed = re.search('<img id="first"[^>]*src="data:image/png;base64,([^"]*)">', open(page).read())
            if packed:
                with Image.open(io.BytesIO(base64.b64decode(packed[1], validate=True))) as image:
                    check(distance(np.asarray(image), first) <= 1, f"{which}: its first picture is on the display of one's own")
            browser.open(page)
            offered = browser.evaluate("[...element('display').options].map(({text}) => text)")
            check(offered == ["srgb", "monitor", path] and browser.evaluate("eye.display.name") == path and browser.message() == "",
                  f"{which}: the menu has the display of one's own, which is chosen", offered, browser.evaluate("eye.display.name"), browser.message())
            browser.tick("auto", False)
            browser.put("exposure", 0.8)
            for name in (path, "srgb", "monitor"):
                browser.choose("display", str(offered.index(name)))
                seen = browser.pixels()
                check(distance(seen, pictures[name]) <= 1 and np.mean(seen[:, :, :3] != pictures[name]) < 0.01,
                      f"{which}: {os.path.basename(name)} shows develop's picture", distance(seen, pictures[name]))
            browser.choose("display", "2")
            check(f"--display '{path}' " in browser.text("commands"), f"{which}: its commands quote the display", browser.text("commands"))
    kind[:] = [LIVE]
    browser.open(view("metamers", "display", "--size", SIZE, display))
    check(browser.evaluate("Object.keys(state.files)") == [path], "a live page has the file of the display")
    browser.drop(os.path.abspath(write("plain.scene", "camera ortho 3\nsize 60 40\nmaterial m { diffuse 0.5 }\nobject sphere 1 material m\n")))
    browser.wait("state.scene === 'plain.scene' && element('display').options.length === 2")
    check(browser.evaluate("eye.display.name") == "srgb" and browser.message() == "", "and forgets it with the scene", browser.message())
    kind[:] = [PROGRAM]
    browser.open(view("metamers", "display", "--size", SIZE, "--display=monitor"))
    check(browser.evaluate("[eye.display.name, element('display').options.length]") == ["monitor", 2], "a page shows first the monitor that the program knows")


def encoded(part):
    """IEC 61966-2-1, from 0 to 255."""
    return np.round(255 * np.where(part <= 0.0031308, 12.92 * part, 1.055 * part ** (1 / 2.4) - 0.055))


def bands(which):
    """One band of a scene, in grey and in false colours, and two lights side by side."""
    browser.open(view("fluorescence", "bands"))
    page = pages_of(rendered("fluorescence", "--depth", "32f", "--light=1=a*0.7"))
    set_lights({1: "a*0.7"})
    browser.choose("scene-view", "band")
    for band in (0, 40, len(page) - 1):
        browser.put("scene-band", band)
        expected = encoded(page[band] / page[band].max())[:, :, None].repeat(3, 2)
        seen = browser.pixels()
        check(distance(seen, expected) <= 1 and np.ptp(expected) > 100,
              f"{which}: band {band} is shown in grey, its largest radiance white", distance(seen, expected))
    check(browser.text("scene-band-nm") == "760 nm" and browser.text("commands").endswith(f"# page {len(page)} is this band"),
          f"{which}: the page names the band", browser.text("scene-band-nm"), browser.text("commands"))
    browser.choose("scene-view", "map")
    browser.put("scene-band", 40)
    ramp = np.array([[20, 20, 70], [40, 90, 160], [30, 150, 140], [120, 195, 80], [250, 230, 60]], float)
    part = page[40] / page[40].max() * 4
    expected, seen = np.stack([np.interp(part, range(5), column) for column in ramp.T], 2), browser.pixels()
    legend = browser.evaluate("[...element('map-legend').children].map(one => one.textContent)")
    check(distance(seen, expected) <= 1 and legend[0] == "0" and len(legend) == 5 and
          np.allclose([float(one.split()[0]) for one in legend], np.linspace(0, page[40].max(), 5), rtol=2e-3),
          f"{which}: false colours have a legend up to the largest radiance",
          distance(seen, expected), legend, page[40].max())
    browser.choose("scene-view", "detector")
    check(browser.evaluate("element('map-legend').hidden"), f"{which}: the detector's picture has none")
    before, title = browser.pixels(), browser.evaluate("document.title")
    browser.press("keep-picture")
    set_lights({1: "uv*1"})
    browser.settle()
    kept = browser.evaluate("""(() => { const second = element("picture-2"), {width, height} = second;
        return [...second.getContext("2d").getImageData(0, 0, width, height).data]; })()""")
    check((np.array(kept, np.uint8).reshape(before.shape) == before).all() and distance(browser.pixels(), before) > 10 and
          [browser.text("caption-2"), browser.text("caption")] ==
          [one.replace(" – spectral", "") for one in (title, browser.evaluate("document.title"))] and
          browser.text("caption") != browser.text("caption-2"),
          f"{which}: a kept picture stays beside the one that changes, both with captions", browser.text("caption"), browser.text("caption-2"))
    browser.press("keep-picture")
    check(browser.evaluate("element('frame-2').hidden"), f"{which}: it is taken away again")


def all_offered():
    """Checks that the combinations include every option."""
    browser.open(view("metamers", "metamers"))
    options = [word for pairs in COMBINATIONS.values() for _, words in pairs for word in words]
    for menu in ("detector", "adaptation", "display"):
        offered = set(browser.evaluate(f"[...document.getElementById({menu!r}).options].map(o => o.text)"))
        used = {word.split("=")[1].split(":")[0] for word in options if word.startswith(f"--{menu}=")}
        default = {"detector": "cie1931", "adaptation": "none", "display": "srgb"}[menu]
        check(offered and offered <= used | {default}, f"every {menu} was tried", offered - used)


def lamps():
    """Menus have lamps in the order of people, and equal energy once, also where the scene says 1."""
    order = lambda name: [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", name)]
    scene = write("one.scene", "camera ortho 3\nambient 1 0.5\nmaterial m { diffuse 0.5 }\nobject sphere 1 material m\n")
    for subject, equal in (("metamers", "e (equal energy)"), (scene, "1 (equal energy)")):
        browser.open(view(subject, "lamps"))
        offered = browser.evaluate("[...element('ambients-1').options].map(({text}) => text)")
        check(offered.index("f9") == offered.index("f8") + 1 < offered.index("f10") and offered == sorted(offered, key=order),
              f"{equal}: f9 stands between f8 and f10", offered)
        radiances = browser.evaluate("[...element('ambients-1').options].map(({value}) => [...scene.illuminants[value].radiance].join())")
        check(len(set(radiances)) == len(radiances) > 20 and equal in offered, f"{equal}: no two lamps of a menu are the same", offered)


# ---- pixels and their spectra ----

def click_pixel(x, y):
    browser.click(*browser.at(x + 0.5, y + 0.5))
    browser.settle()


def values():
    """The table of values at each wavelength: its columns by name."""
    browser.evaluate("document.getElementById('values-shown').open = true")
    browser.settle()
    rows = browser.evaluate("[...document.querySelectorAll('#values tr')]"
                            ".map(row => [...row.cells].map(cell => cell.textContent))")
    return dict(zip(rows[0], np.array(rows[1:], float).T))


def numbers():
    rows = browser.evaluate("[...document.querySelectorAll('#numbers tr')]"
                            ".map(row => [...row.cells].map(cell => cell.textContent))")
    return {row[0]: np.array([word.replace("\u2212", "-") for word in row[1:] if word], float)
            for row in rows}


def spectra(scene, name, places, lights=None):
    """A weight is rounded to 1 / (2 x 65535) of the largest weight of its plane. That is 1 unless a light is nearer
    than the distance of attenuation 1, so a few terms are off by 1e-4 of the light."""
    browser.open(view(scene, name))
    lights = lights or {}
    click_pixel(*places[0])
    values()
    set_lights(lights)
    browser.settle()
    stack = rendered(scene, "--depth", "32f", *light_options(lights))
    radiance = pages_of(stack)
    tolerance = 1e-4 * radiance.max()
    x, y = places[0]
    check(np.abs(values()["radiance"] - radiance[:, y, x]).max() <= tolerance,
          f"{name}: the spectrum follows the menus")
    xyz, _ = developed(stack, "--xyz")
    lab, _ = developed(stack, "--lab")
    for x, y in places:
        click_pixel(x, y)
        check(browser.text("picked").startswith(f"Pixel {x}, {y}: "), f"{name}: a click picks pixel {x}, {y}",
              browser.text("picked"))
        seen, shown = values(), numbers()
        error = np.abs(seen["radiance"] - radiance[:, y, x]).max()
        check(error <= tolerance and radiance[:, y, x].max() > 50 * tolerance,
              f"{name}: the spectrum of pixel {x}, {y} is the stack's", f"error {error}, tolerance {tolerance}")
        check(np.abs(shown["XYZ"] - xyz[y, x]).max() < 0.01 and np.abs(shown["L*a*b*"] - lab[y, x]).max() < 0.05,
              f"{name}: XYZ and CIELAB are the stack's", shown, xyz[y, x], lab[y, x])
        check((shown["RGB, 0 to 255"] == browser.pixels()[y, x, :3]).all(), f"{name}: RGB is the picture's")


def causes():
    """The spectra behind a pixel's radiance equal the columns of the files."""
    browser.open(view("fluorescence", "fluorescence"))
    browser.choose("objects", browser.evaluate(
        "[...objects.options].find(({text}) => text.includes('yellow')).text.split(' ')[0]"))
    set_lights({1: "uv*0.5"})
    browser.settle()
    halves = browser.evaluate("[...objects.options].map(o => o.text).filter(text => text.includes('yellow'))")
    check(len(halves) == 2, "the list of objects has each half of an object", halves)
    for half in halves:
        browser.choose("objects", half.split(" ")[0])
        seen = values()
        if "excitation" in seen:
            break
    light = 0.5 * np.interp(seen["nm"], *built_in("uv"))
    check(np.allclose(seen["light 1 (uv)"], light, rtol=1e-5),
          "the light's spectrum is its table x its intensity")
    check("emission" in seen and "reflectance" in seen and seen["excitation"].max() > 0.1,
          "reflectance, excitation and emission are shown, too", list(seen))
    part = seen["fluorescence"] / seen["emission"].clip(1e-9)
    part = part[seen["emission"] > 0.1]
    check(part.min() > 0 and np.ptp(part) < 1e-3 * part.max(),
          "the fluorescent radiance has the shape of the emission")
    check((seen["radiance"] >= seen["fluorescence"] - 1e-6).all(),
          "the fluorescent radiance is a part of the radiance")


def difference(one, other):
    """CIEDE2000 of two pixels, as the page shows it if one is kept and the other picked."""
    click_pixel(*one)
    browser.press("keep")
    kept = numbers()["L*a*b*"]
    click_pixel(*other)
    shown = numbers()
    beside = any(name.startswith("kept") for name in values())
    browser.press("keep")
    expected = float(ciede2000(kept, shown["L*a*b*"]))
    return shown["ΔE00 to the kept"][0], expected, beside


def metamers():
    """Two pixels on both sides of the cut through an object with halves that match under D65."""
    browser.open(view("metamers", "metamers"))
    y, left = browser.evaluate("""(() => {
        const at = surfaces.findIndex((surface, i) => surface === 2 && surfaces[i + 1] === 3);
        return [Math.floor(at / shape.width) + 3, at % shape.width];
    })()""")
    alike, expected, beside = difference((left, y), (left + 1, y))
    check(abs(alike - expected) < 2e-3 and beside, "a kept pixel is compared by CIEDE2000 and its spectrum",
          alike, expected, beside)
    browser.press("keep")
    for detector in ("cie1964", "cie2006-2", "cie1931"):
        browser.choose("detector", detector)
        check(numbers()["ΔE00 to the kept"] == [0], f"{detector}: a pixel does not differ from itself")
    browser.press("keep")
    browser.choose("lights-1", "a")
    apart, _, _ = difference((left, y), (left + 1, y))
    check(alike < 2 and apart > 5, "halves that match under D65 differ under A", alike, apart)
    own, other = {}, {}
    for name in browser.evaluate("[...objects.options].map(({text}) => text).filter(text => text.includes('half'))"):
        browser.choose("objects", name.split(" ")[0])
        seen, side = values(), re.search("(left|right) half", name)[1]
        partner = {"left": "right", "right": "left"}[side]
        pair = name.split(". ")[1].replace(side, "%s")
        own[pair % side], other[pair % partner] = seen["reflectance"], seen[f"reflectance of the {partner} half"]
    check(len(own) == 24 and own.keys() == other.keys() and all((own[name] == other[name]).all() for name in own),
          "the plot of each half has the reflectance of the other one, too", sorted(own))


def means():
    """With several positions a pixel, the page has their means, as the PNG and the stack have."""
    words = "--samples", "4"
    browser.open(view("textures", "means", "--size", SIZE, *words))
    browser.settle()
    expected, _ = developed(rendered("textures", *words))
    browser.see_by([])
    seen = browser.pixels()
    check(distance(seen, expected) <= 1, "a page of 4 x 4 positions shows develop's picture", distance(seen, expected))
    seen, _ = still("textures", "--size", SIZE, "--exposure=1", *words)
    check(distance(seen, expected) <= 1, "and so does the PNG of view", distance(seen, expected))
    click_pixel(10, 10)
    stack = rendered("textures", "--depth", "32f", *words)
    radiance = pages_of(stack)
    objects, names = objects_of(stack), output_of("info", stack)
    for x, y in ((10, 10), (21, 13), (49, 40), (100, 71)):
        click_pixel(x, y)
        error = np.abs(values()["radiance"] - radiance[:, y, x]).max()
        check(error <= 1e-4 * radiance.max(), f"the spectrum of pixel {x}, {y} is the mean of its positions", error)
        number = browser.evaluate("document.getElementById('objects').value")
        check(int(number) == objects[y, x], "its object is that of most positions", number, objects[y, x], names)
    command_line("textures", "means", {1: "a*0.75"}, *words)


def command_line(scene, name, lights, *options):
    """The page shows the commands that make its picture; they work from any folder."""
    browser.open(view(scene, name, *(("--size", SIZE, *options) if options else ())))
    set_lights(lights)
    browser.see_by(["--detector=cie1964", "--adaptation=fairchild:40", "--exposure=1.25", "--display=monitor"])
    seen = browser.pixels()
    folder = os.path.abspath(path_of("bin"))
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    os.symlink(PROGRAM, os.path.join(folder, "spectral"))
    subprocess.run(["sh", "-c", browser.text("commands")], cwd=folder, check=True, stdout=subprocess.DEVNULL,
                   env={**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"})
    made = tifffile.imread(os.path.join(folder, "developed.tif"))
    check(distance(seen, made) <= 1, f"{name}: the commands that the page shows make its picture", browser.text("commands"))


# ---- people ----

def tab_to(element):
    for _ in range(60):
        browser.key("Tab")
        if browser.evaluate("document.activeElement.id") == element:
            return True
    return False


def outlined():
    return browser.evaluate("getComputedStyle(document.activeElement).outlineStyle !== 'none' && "
                            "parseFloat(getComputedStyle(document.activeElement).outlineWidth) >= 2")


def keyboard():
    browser.open(view("colorchecker", "colorchecker"))
    browser.evaluate("document.activeElement.blur()")
    check(tab_to("picture") and outlined(), "the keyboard reaches the picture, which shows that it has the focus")
    browser.evaluate("move_cursor(60, 40)")
    for _ in range(3):
        browser.key("ArrowLeft", shift=True)
    for key in ("ArrowRight", "ArrowUp", "ArrowUp", "ArrowDown", "Enter"):
        browser.key(key)
    check(browser.text("picked").startswith("Pixel 31, 39: "), "arrow keys and Enter pick a pixel", browser.text("picked"))
    before = browser.pixels()
    check(tab_to("lights-1") and outlined(), "the keyboard reaches the menu of a light")
    browser.key("ArrowDown")
    chosen = browser.evaluate("document.activeElement.selectedOptions[0].text")
    expected, _ = developed(rendered("colorchecker", f"--light=1={chosen}"), "--exposure=auto")
    seen = browser.pixels()
    check(distance(seen, expected) <= 1 and distance(seen, before) > 10,
          f"an arrow key changes the light, to {chosen}")
    check(tab_to("objects"), "the keyboard reaches the list of objects")
    browser.key("ArrowDown")
    browser.settle()
    check(browser.text("picked").split(": ")[1] == browser.evaluate("objects.selectedOptions[0].text"),
          "an arrow key picks another object", browser.text("picked"))


def names():
    """Every control has an accessible name, as Chromium's accessibility tree gives it."""
    browser.evaluate("document.querySelectorAll('details').forEach(group => group.open = true)")
    nodes = browser.send("Accessibility.getFullAXTree")["nodes"]
    roles = {"combobox", "slider", "spinbutton", "button", "checkbox", "application"}
    controls = [node for node in nodes if node.get("role", {}).get("value") in roles]
    nameless = [node for node in controls if not node.get("name", {}).get("value")]
    check(len(controls) >= 15 and not nameless, f"all {len(controls)} controls have names", nameless)


def relative_luminance(colour):
    """WCAG 2.1."""
    part = np.array([float(word) for word in colour[colour.index("(") + 1:-1].split(",")[:3]]) / 255
    return np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]


def contrast(selector):
    colours = browser.evaluate(f"""(() => {{
        const text = document.querySelector({selector!r}), panel = text.closest("section, body");
        return [getComputedStyle(text).color, getComputedStyle(panel).backgroundColor];
    }})()""")
    darker, lighter = sorted(map(relative_luminance, colours))
    return (lighter + 0.05) / (darker + 0.05)


def schemes():
    paper = {}
    for scheme in ("light", "dark"):
        browser.scheme(scheme)
        browser.settle()
        paper[scheme] = relative_luminance(browser.evaluate("getComputedStyle(document.body).backgroundColor"))
        worst = min(map(contrast, ("#picked", "#gamut", "#about", "#numbers td", "#numbers th")))
        check(worst >= 4.5, f"text stands out in the {scheme} scheme", worst)
    check(paper["dark"] < 0.1 < 0.5 < paper["light"], "the page is dark where dark is preferred", paper)
    browser.scheme("light")


def widths():
    for width in (360, 768, 1280):
        browser.size(width, 740)
        browser.settle()
        wide = browser.evaluate("[document.documentElement.scrollWidth, innerWidth]")
        check(wide[0] <= wide[1] == width, f"the page fits a screen of {width} pixels", wide)
    browser.size(360, 740)
    browser.evaluate("detector.scrollIntoView()")
    browser.settle()
    bottom = browser.evaluate("picture.getBoundingClientRect().bottom")
    top = browser.evaluate("picture.getBoundingClientRect().top")
    check(0 <= top < bottom <= 400, "on a phone the picture stays in sight while the menus scroll", top, bottom)
    browser.size(1280, 900)


def saving():
    saved = np.moveaxis(gdal.Open(browser.download("save", "colorchecker.png")).ReadAsArray(), 0, 2)
    check(distance(browser.pixels(), saved[:, :, :3]) == 0, "the saved PNG has the picture's pixels")
    rows = open(browser.download("save-values", "colorchecker.csv")).read().splitlines()
    saved = np.array([row.split(",")[1] for row in rows[1:]], float)
    check(np.allclose(saved, values()["radiance"], rtol=1e-5), "the saved values equal the table's", rows[:2])


# ---- the file ----

def file():
    path = view("colorchecker", "large", "--size", "600x400")
    size = os.path.getsize(path)
    check(size < 3e6, f"the colorchecker at 600x400 takes {size} bytes, not 3 MB")
    blocked = browser.evaluate("""new Promise(then => {
        document.addEventListener("securitypolicyviolation", event => then(event.effectiveDirective));
        fetch("data:,nothing").catch(() => {});
        setTimeout(() => then("nothing"), 5000);
    })""")
    check(blocked == "connect-src", "its policy blocks all loading", blocked)
    browser.complaints.clear()  # Chromium reports that on the console
    with open(path, encoding="utf-8") as page:
        said = re.search('content="(.*)"', page.read()).group(1)
    check(said == "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src blob: data:; "
          "base-uri 'none'; form-action 'none'", "and all bases and forms", said)
    again = path_of("again.html")
    os.replace(path, again)
    check(open(view("colorchecker", "large", "--size", "600x400"), "rb").read() == open(again, "rb").read(),
          "the same scene gives the same bytes")


def strange_names():
    scene = os.path.abspath(scene_of_strange_names())
    spectra(scene, "strange", [(32, 40), (40, 30), (88, 40)], {"ambient": "d65*0.5", 1: "uv*0.7"})
    named = browser.evaluate("[...objects.options].map(({text}) => text)")
    check(any(name.endswith(f". {STRANGE} (sphere)") for name in named),
          "names with strange characters are shown literally", named)
    check(scene in browser.evaluate("document.title") and browser.text("name") == scene,
          "the scene's name is shown literally")


def two_of_each():
    scene = scene_of_two_of_each()
    spectra(scene, "two", [(60, 40)])
    browser.see_by([])
    expected, _ = developed(rendered(scene))
    check(distance(browser.pixels(), expected) <= 1, "two ambient lights add up, and two textures do not mix")


def small():
    """A picture that the page enlarges."""
    browser.open(view("colorchecker", "small", "--size", "60x40"))
    check(browser.evaluate("getComputedStyle(picture).imageRendering") == "pixelated",
          "enlarged pixels are not blurred")
    for width, scale in ((1280, 1), (360, 3)):
        browser.size(width, 740, scale)
        places = [(x + part, y + part) for x, y in ((0, 0), (20, 13), (59, 39)) for part in (-0.35, 0.35)]
        for x, y in places:
            click_pixel(x, y)
            check(browser.text("picked").startswith(f"Pixel {round(x)}, {round(y)}: "),
                  f"{width} pixels wide: a click at {x}, {y} picks the pixel below", browser.text("picked"))
    browser.size(1280, 900)
    browser.open(view("patches", "one", "--size", "60x40", "--wavelengths", "550"))
    check("one wavelength, 550 nm" in browser.text("about") and not browser.complaints, "a single wavelength is shown")


def axis(anchor, across):
    """Returns the function from places on an axis of the plot to values, from the axis's first and last numbers."""
    labels = browser.evaluate(f"""[...document.querySelectorAll('#chart text[text-anchor={anchor}]')]
        .map(node => [Number(node.getAttribute({across!r})), Number(node.textContent)])""")
    ticks = [label for label in labels if label[1] is not None]
    (a, first), (b, last) = ticks[0], ticks[-1]
    return lambda place: first + (place - a) * (last - first) / (b - a)


def plot():
    """Reads the values of the curve from the SVG, by its axes."""
    browser.open(view("colorchecker", "colorchecker"))
    seen = values()
    points = np.array(re.findall(r"[\d.]+", browser.evaluate(
        "document.querySelector('#chart .radiance').getAttribute('d')")), float).reshape(-1, 2)
    nm = axis("middle", "x")(points[:, 0])
    radiance = axis("end", "y")(points[:, 1] + 4)
    lights = np.array(re.findall(r"[\d.]+", browser.evaluate(
        "document.querySelector('#chart .curve.light').getAttribute('d')")), float).reshape(-1, 2)
    labels = np.array(browser.evaluate("[...document.querySelectorAll('#chart .of-light:not([text-anchor])')]"
                                       ".map(node => [Number(node.getAttribute('y')), Number(node.textContent)])"))
    light_at = np.polyval(np.polyfit(labels[:, 0] - 4, labels[:, 1], 1), lights[:, 1])
    check(len(labels) > 2 and np.abs(light_at - seen["light 1 (d65)"]).max() < 0.004,
          "an axis of its own shows the light", light_at, seen["light 1 (d65)"])
    check(np.abs(nm - seen["nm"]).max() < 0.02, "the plot's lower axis shows the wavelengths")
    left, width = browser.evaluate("['x', 'width'].map(name => Number(document.querySelector('#chart .axis')"
                                   ".getAttribute(name)))")
    check(np.abs(points[[0, -1], 0] - [left, left + width]).max() < 0.02,
          "the axis extends from the first to the last wavelength")
    check(np.abs(radiance - seen["radiance"]).max() < 0.002, "the plot's left axis shows the radiances",
          radiance, seen["radiance"])
    check(points[seen["radiance"].argmax(), 1] < points[seen["radiance"].argmin(), 1],
          "a larger radiance is higher in the plot")
    missed = browser.evaluate("""(() => {
        const svg = document.querySelector("#chart svg"), drawn = curves_at(pixel).filter(curve => !is_hidden(curve)), frame = plot_frame(drawn);
        const box = svg.getBoundingClientRect(), scale = box.width / frame.width, missed = [];
        const place_of = ({axis, values}, i) => frame.y_of[axis || "radiance"](values[i]);
        for (const curve of drawn)
            scene.wavelengths.forEach((nm, i) => {
                svg.dispatchEvent(new PointerEvent("pointermove", {clientX: box.left + scale * frame.x(nm), clientY: box.top + scale * place_of(curve, i)}));
                const said = element("at-cursor").textContent, named = drawn.find(({name}) => said.startsWith(`${nm} nm, ${name}: `));
                if (!named || Math.abs(place_of(named, i) - place_of(curve, i)) > 1e-6 || Math.abs(Number(said.split(": ").pop()) / (named.values[i] || 1) - 1) > 1e-3 && named.values[i] !== 0)
                    missed.push(said);
            });
        return [drawn.length, missed];
    })()""")
    check(missed[0] >= 4 and not missed[1], "on each curve, at each wavelength, the plot shows its name and value", missed)
    browser.pointer("mouseMoved", *browser.at(60.5, 40.5), 0)
    browser.settle()
    said, under = browser.text("at-cursor"), values()["under the pointer"]
    click_pixel(60, 40)
    check(said == "Under the pointer: p" + browser.text("picked")[1:] and (values()["radiance"] == under).all(),
          "the pixel under the pointer has its name and its spectrum before it is picked", said)
    drawn = "document.querySelectorAll('#chart .curve').length"
    before = browser.evaluate(drawn)
    browser.evaluate("document.querySelector('#curves input').click()")
    browser.settle()
    check(browser.evaluate(drawn) == before - 1, "a curve can be hidden")
    observed = numbers()["XYZ"]
    browser.choose("detector", "dcs200-camera")
    check((numbers()["XYZ"] == observed).all(), "XYZ are those of the CIE 1931 observer even with a camera")


def many_curves():
    """Colours of curves never repeat; of ten those with the same dashes differ in lightness; all stand out of the page."""
    looks = browser.evaluate("Array.from({length: 500}, (_, i) => look_of(i))")
    hues = [look.split(";")[0] for look in looks]
    check(len(set(hues)) == 500, "500 curves have 500 hues")
    for scheme in ("light", "dark"):
        browser.scheme(scheme)
        shown = browser.evaluate("""Array.from({length: 10}, (_, i) => {
            const path = draw_curve(document.querySelector("#chart svg"), {style: "numbered", look: look_of(i)}, "M0 0"), {stroke, strokeDasharray} = getComputedStyle(path);
            const context = new OffscreenCanvas(1, 1).getContext("2d");
            path.remove();
            context.fillStyle = stroke;
            context.fillRect(0, 0, 1, 1);
            return [`rgb(${[...context.getImageData(0, 0, 1, 1).data.slice(0, 3)]})`, strokeDasharray];
        })""")
        paper = relative_luminance(browser.evaluate("getComputedStyle(element('spectrum')).backgroundColor"))
        ratio = lambda a, b: (max(a, b) + 0.05) / (min(a, b) + 0.05)
        bright = [relative_luminance(colour) for colour, _ in shown]
        check(min(ratio(one, paper) for one in bright) >= 3, f"{scheme}: they stand out of the page", shown)
        pairs = [ratio(bright[i], bright[j]) for i in range(10) for j in range(i) if shown[i][1] == shown[j][1]]
        check(len(pairs) == 5 and min(pairs) > 1.7, f"{scheme}: of ten curves those of one dash pattern differ in lightness", pairs)
    browser.scheme("light")


def slider():
    browser.open(view("colorchecker", "colorchecker"))
    browser.see_by([])
    browser.put("lights-1-slider", 0.25)
    expected, _ = developed(rendered("colorchecker", "--light=1=d65*0.25"))
    check(distance(browser.pixels(), expected) <= 1, "a slider changes its light")
    browser.put("lights-1-intensity", "")
    check(browser.evaluate("document.getElementById('lights-1-slider').value") == "0",
          "an empty number means no light, and the slider shows it")
    browser.put("ambients-1-intensity", "")
    browser.choose("adaptation", "von-kries")
    check("cannot adapt" in browser.message(), "the page says so if the eye cannot adapt", browser.text("message"))


def troubles():
    browser.open(view("colorchecker", "colorchecker"))
    check(browser.message() == "", "the page shows no message without a problem")
    browser.see_by([])
    browser.evaluate("element('eye-group').open = true")
    for value in (0.123456, 0.000123456, 123456):
        browser.put("exposure", value)
        room = browser.evaluate("[element('exposure').scrollWidth, element('exposure').clientWidth]")
        check(room[0] <= room[1], f"the box of the exposure has room for {value}", room)
    browser.put("exposure", 1)
    once = numbers()["RGB, linear"]
    browser.put("exposure", 2)
    check(np.allclose(numbers()["RGB, linear"], 2 * once, atol=2e-5), "linear channels are shown after exposure")
    for wrong in ("", "0", "-1"):
        browser.put("exposure", wrong)
        check("exposure" in browser.message(), f"the page rejects an exposure of '{wrong}'", browser.text("message"))
    script = browser.send("Page.addScriptToEvaluateOnNewDocument", source="delete window.DecompressionStream")
    browser.put("exposure", 1)
    browser.send("Page.reload")
    browser.wait("document.getElementById('message')?.hidden === false")
    check("This browser cannot" in browser.message(), "an old browser shows a message", browser.text("message"))
    browser.send("Page.removeScriptToEvaluateOnNewDocument", **script)
    browser.complaints.clear()  # Chromium reports that on the console


def main():
    browser.size(1280, 900)
    for kind[:] in ([LIVE], [PROGRAM]):
        for scene in COMBINATIONS:
            if kind == [PROGRAM] or scene in ("fluorescence", "room") or os.environ.get("FULL"):
                menus(scene)
    for kind[:] in ([LIVE], [PROGRAM]):
        bands("still" if kind == [PROGRAM] else "live")
    first_pictures()
    stills()
    exposures()
    own_display()
    all_offered()
    lamps()
    spectra("colorchecker", "colorchecker", [(10, 10), (25, 20), (60, 40)])
    spectra("room", "room", [(67, 25), (60, 60), (57, 40), (25, 25), (110, 32)], {2: "uv*0.9", "ambient": "e*0.3"})
    causes()
    metamers()
    command_line("colorchecker", "colorchecker", {"ambient": "uv*0.3", 1: "a*0.75"})
    command_line(os.path.abspath(scene_of_strange_names()), "lights of files",
                 {"ambient": "lamp.csv*0.1", 1: "daylight:5003*0.3", 2: "lamp.csv*0.6"})
    means()
    keyboard()
    names()
    schemes()
    widths()
    saving()
    check(not browser.complaints, "the console stays empty, and no exception is thrown", *browser.complaints)
    strange_names()
    two_of_each()
    check(not browser.complaints, "the console stays empty for strange scenes, too", *browser.complaints)
    small()
    plot()
    many_curves()
    slider()
    troubles()
    inside = ("file://" + os.path.abspath(TMP), "blob:", "data:")
    outside = [url for url in browser.requests if not url.startswith(inside)]
    check(browser.requests and not outside, "no request leaves the page", outside)
    file()
    done()


try:
    main()
finally:
    browser.close()
