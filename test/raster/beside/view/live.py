#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile python3-pil chromium firefox-esr; makes: live
"""Tests live pages in headless Chromium and Firefox: the program in the page renders the bytes that the program itself
renders, and changes by mouse, touch, keys and text stand in the saved scene. Prints TAP."""
import json
import os
import re
import tarfile
import time

import numpy as np
from PIL import Image

from browser import Browser, Firefox
from rendered import LIVE, TMP, bytes_of, check, developed, done, output_of, path_of, run, write, write_camera

SCENES = ("colorchecker", "fluorescence", "metals", "metamers", "pasture", "patches", "relief", "room", "spheres", "textures")
SIZE = "96x64"


def live(*words, **options):
    """Returns the output of the program with live pages."""
    return output_of(*words, program=LIVE, **options)


def view(scene, *options):
    page = path_of("live.html")
    live("view", scene, "-o", page, "--quiet", *options)
    return page


def rendered(scene, *options, **more):
    """The bytes of the stack that the command line makes."""
    stack = os.path.abspath(path_of("native.tif"))
    live("render", scene, "--renderer", "raster", "--no-check", "--quiet", "-o", stack, *options, **more)
    return bytes_of(stack)


def stacks(browser, which):
    """The stack that the page saves has the bytes of the program's."""
    for scene in SCENES:
        browser.open(view(scene, "--size", SIZE))
        saved = bytes_of(browser.download("save-stack", scene + ".tif"))
        check(saved == rendered(scene, "--size", SIZE), f"{which}, {scene}: the stack that the page saves is that of render")



# ---- the start ----

def start(browser, which):
    """The page says that it starts, and can be used when a small picture is drawn; the first change does not show the old view again."""
    browser.size(1400, 1000)
    browser.open(view("room", "--size", "660x440"), until="document.body?.classList.contains('starting')")
    title, name, said, grey = browser.evaluate("[document.title, element('name').textContent, element('progress').textContent,"
                                               "[...document.querySelectorAll('[inert]')].map(one => one.id).join()]")
    check(title == "room – spectral" and name == "room" and said.startswith("Starting: ") and grey == "zooming,tools,spectrum,light-and-eye",
          f"{which}: until the program has drawn, the page has a title, says what it waits for, and controls are grey", title, name, said, grey)
    browser.wait("document.body.dataset.ready === 'true'")
    busy = browser.evaluate("element('shown').getAttribute('aria-busy') === 'true' && !document.querySelector('[inert]')")
    browser.evaluate("(() => { window.small = shown; })()")
    first, last = browser.painted(), browser.pixels()
    agreed = browser.evaluate("shown.filter((surface, i) => surface === small[i]).length / n_pixels")
    check(busy and np.abs(first.astype(int) - last).max() <= 1 and 0.9 < agreed < 1,
          f"{which}: a small picture is enough to begin, and the page shows the whole one from the start", busy, agreed,
          np.abs(first.astype(int) - last).max())
    browser.evaluate("(() => { const shows = show_picture, tells = set_text; window.seen = []; window.said = [];"
                     "const old = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;"
                     "show_picture = painted => { seen.push(painted.data.length === old.length && painted.data.every((byte, i) => byte === old[i])); shows(painted); };"
                     "set_text = (id, text) => { if (id === 'progress') said.push(text); tells(id, text); }; })()")
    browser.press("camera-d")
    moved, said, seen = browser.pixels(), browser.evaluate("said"), browser.evaluate("seen")
    check(seen and not any(seen) and (moved != last).any(), f"{which}: the first change is drawn, and not the old view before it", seen)
    check("Drawing …" in said and said[-1].startswith("Drawn in "), f"{which}: while it is drawn the page says so", *said)


# ---- what a person does ----

def line(start, end, n=12):
    return [(start[0] + (end[0] - start[0]) * i / n, start[1] + (end[1] - start[1]) * i / n) for i in range(n + 1)]


def path(browser, start, end):
    return line(browser.at(*start), browser.at(*end))


def text_of(browser):
    return browser.evaluate("is_text(state) ? text_of(state) : ''")


def words_of(browser, first):
    """The words of the first statement that begins with a word."""
    return next((statement.split() for statement in text_of(browser).splitlines() if statement.startswith(first + " ")), [])


def fill(browser, field, text):
    """Types a text into a field, in place of the one that it has."""
    browser.evaluate(f"(() => {{ const field = document.getElementById({field!r}); field.closest('details').open = true;"
                     "field.focus(); field.select(); })()")
    browser.type(text)
    browser.enter()
    browser.evaluate("document.activeElement.blur()")
    browser.settle()


# Each control: something it does to the scene "spheres", and a pattern of a line that its text then has.
EDITS = (
    ("fill", "place-x", "0.25", "translate 0.25 "), ("fill", "turn-y", "30", "rotate 30 0 1 0"),
    ("fill", "grow", "1.5", "scale 1.5"), ("fill", "gloss", "7", "^material plastic .*gloss 7 "),
    ("choose", "texture", "checks", "texture checks linear"), ("choose", "relief", "weave", r"^object sphere 1.2 96 \d+ displace weave 0.1 "),
    ("choose", "object-shape", "mesh vase", "object mesh vase .*unitize .*material plastic"),
    ("choose", "material", "file metals/gold", "material gold metals/gold"), ("fill", "extent", "33", "perspective 33"),
    ("fill", "eye-x", "2.5", "eye 2.5"), ("fill", "look-y", "0.5", r"look \S+ 0.5 "), ("fill", "size-width", "96", "^size 96 "),
    ("fill", "size-height", "48", r"^size \d+ 48$"), ("fill", "wavelengths", "450:650:20", "wavelengths 450 650 20"),
    ("choose", "lights-1", "blackbody", "light blackbody:2856"), ("fill", "lights-1-intensity", "0.125", r"^light \S+ 0.125 "),
    ("fill", "lights-1-place-x", "3", "^light .* position 3 "), ("fill", "ambients-1-intensity", "0.625", r"^ambient \S+ 0.625"),
)
SHOWN = ("place-x", "gloss", "extent", "eye-x", "look-y", "size-width", "size-height", "lights-1-intensity", "lights-1-place-x",
         "ambients-1-intensity")


def edit(browser, kind, control, value):
    if kind == "fill":
        fill(browser, control, value)
    else:
        browser.choose(control, value)


def added(before, after):
    """The lines of a text that another one lacks."""
    return [one for one in after.splitlines() if one not in before.splitlines()]


def agrees(browser, name, what):
    """The saved scene, rendered by the command line, gives the stack that the page saves."""
    scene = browser.download("save-scene", name + ".scene")
    stack = bytes_of(browser.download("save-stack", name + ".tif"))
    check(rendered(name + ".scene", cwd=os.path.dirname(scene)) == stack,
          f"{what}: the saved scene gives the stack that the page saves")


def changes(browser, what, act, holds):
    """Does something that changes the text of the scene; undo and redo go back and forth."""
    before, n = text_of(browser), browser.evaluate("past.length")
    act()
    browser.settle()
    after = text_of(browser)
    check(after != before and holds(before, after), f"{what} changes the scene as it should", *added(before, after),
          browser.text("message"))
    check(browser.evaluate("past.length") == n + 1, f"{what}: undo takes it back in one step", n, browser.evaluate("past.length"))
    browser.press("undo")
    browser.settle()
    undone = text_of(browser)
    browser.press("redo")
    browser.settle()
    check(undone == before and text_of(browser) == after, f"{what}: undo and redo")


# ---- controls ----

def numbers_after(words, name):
    """The three numbers after the last place of a word."""
    place = len(words) - words[::-1].index(name)
    return np.array(words[place:place + 3], float)


def camera_of(text):
    words = next(one.split() for one in text.splitlines() if one.startswith("camera"))
    return numbers_after(words, "eye"), numbers_after(words, "look")


def turned(before, after):
    """The eye keeps its distance from the place that the camera looks at."""
    (eye, look), (new_eye, new_look) = camera_of(before), camera_of(after)
    return (np.allclose(look, new_look, atol=1e-6) and not np.allclose(eye, new_eye, atol=0.01) and
            np.isclose(np.linalg.norm(eye - look), np.linalg.norm(new_eye - new_look), rtol=1e-6))


def panned(before, after):
    (eye, look), (new_eye, new_look) = camera_of(before), camera_of(after)
    return np.allclose(eye - look, new_eye - new_look, atol=1e-6) and not np.allclose(eye, new_eye, atol=0.01)


def zoomed(before, after):
    (eye, look), (new_eye, new_look) = camera_of(before), camera_of(after)
    return np.linalg.norm(new_eye - look) < 0.99 * np.linalg.norm(eye - look)


def cameras(browser, which):
    across = lambda: path(browser, (20, 80), (60, 70))
    changes(browser, f"{which}, a drag", lambda: browser.drag(across()), turned)
    changes(browser, f"{which}, the key d", lambda: (browser.evaluate("canvas.focus()"), browser.type("d")), turned)
    changes(browser, f"{which}, the key D", lambda: (browser.evaluate("canvas.focus()"), browser.type("D")), panned)
    changes(browser, f"{which}, the key +", lambda: (browser.evaluate("canvas.focus()"), browser.type("+")), zoomed)
    changes(browser, f"{which}, the wheel", lambda: roll(browser), zoomed)
    changes(browser, f"{which}, a finger", lambda: browser.touch(across()), turned)
    changes(browser, f"{which}, two fingers", lambda: browser.touch(path(browser, (60, 50), (40, 50)), path(browser, (80, 50), (100, 50))),
            zoomed)
    browser.tool("pan")
    changes(browser, f"{which}, a drag with the tool Shift", lambda: browser.drag(across()), panned)


def roll(browser):
    browser.wheel(*browser.at(75, 50), -200)
    time.sleep(0.4)  # the wheel rests


def pixel_of(browser, name):
    """The centre of a pixel amid those that show an object."""
    return browser.evaluate(f"""(() => {{
        const all = [...shown.keys()].filter(i => shown[i] > 0 && scene.objects[shown[i] - 1].name === {name!r});
        const rows = new Map();
        for (const i of all) rows.set(place_of(i)[1], [...(rows.get(place_of(i)[1]) || []), place_of(i)[0]]);
        const [y, row] = [...rows].sort((a, b) => b[1].length - a[1].length)[0];
        return [row[row.length >> 1] + 0.5, y + 0.5];
    }})()""")


def object_line(text, name):
    return next(one for one in text.splitlines() if one.startswith("object") and f"material {name} " in one + " ")


def place_of(text, name):
    return numbers_after(object_line(text, name).split(), "translate")


def objects(browser, which):
    browser.tool("turn")
    browser.click(*browser.at(*pixel_of(browser, "plastic")))
    browser.settle()
    name = browser.evaluate("chosen_object().name")
    check(name == "plastic", f"{which}: a click chooses an object", name)
    moved = lambda before, after: not np.allclose(place_of(before, name), place_of(after, name))
    same_place = lambda before, after: not moved(before, after)
    for value, word, holds in (("move", "translate", moved), ("rotate", "rotate", same_place), ("scale", "scale", same_place)):
        browser.tool(value)
        changes(browser, f"{which}, a drag with the tool {value}", lambda: browser.drag(path(browser, (60, 60), (80, 55))),
                lambda before, after, word=word, holds=holds: word in object_line(after, name) and holds(before, after))
    browser.tool("turn")
    for kind, control, value, pattern in EDITS:
        if control.endswith("intensity"):
            continue  # each letter is an edit of its own
        changes(browser, f"{which}, {control}", lambda: edit(browser, kind, control, value),
                lambda before, after: any(re.search(pattern, one) for one in added(before, after)) and
                (control != "grow" or same_place(before, after)))


def lights(browser, which):
    light = lambda text: next(one for one in text.splitlines() if one.startswith("light")).split()
    changes(browser, f"{which}, another colour temperature", lambda: fill(browser, "lights-1-kelvin", "4000"),
            lambda _, after: light(after)[1] == "blackbody:4000")
    changes(browser, f"{which}, an illuminant", lambda: browser.choose("lights-1", "a"), lambda _, after: light(after)[1] == "a")
    handle = lambda: browser.evaluate("(() => { canvas.scrollIntoView({block: 'center'});"
                                      "const b = document.querySelector('#handles circle').getBoundingClientRect();"
                                      "return [b.left + b.width / 2, b.top + b.height / 2]; })()")
    changes(browser, f"{which}, a drag of a light's handle", lambda: browser.drag(line(handle(), [handle()[0] - 30, handle()[1] + 20])),
            lambda before, after: light(before)[4:7] != light(after)[4:7])


def shadows(browser, which):
    """A switch of each light: without shadows no pixel is darker, and some are brighter."""
    before = browser.pixels().astype(int)
    browser.tick("auto", False)
    changes(browser, f"{which}, a light without shadows", lambda: browser.press("lights-1-shadows"),
            lambda before, after: after.count(" shadows") == before.count(" shadows") - 1)
    check(not browser.evaluate("element('lights-1-shadows').checked"), f"{which}: its switch is off")
    lit = browser.pixels().astype(int)
    check((lit - before).min() >= -1 and np.mean((lit - before).max(axis=2) > 20) > 0.01, f"{which}: light comes where shadow was",
          (lit - before).min(), np.mean((lit - before).max(axis=2) > 20))
    changes(browser, f"{which}, a light with shadows", lambda: browser.press("lights-1-shadows"),
            lambda before, after: after.count(" shadows") == before.count(" shadows") + 1)
    check(np.abs(browser.pixels().astype(int) - before).max() <= 1, f"{which}: and goes again")
    browser.tick("auto", True)


def reliefs(browser, which):
    """A relief of a plane, which gets divisions; its height by number and by slider, which is one step back; and none."""
    browser.open(view(write("wall.scene", "camera ortho 3\nsize 120 80\nlight d65 1 direction 3 1 1\nmaterial wall { diffuse 0.7 }\n"
                                          "object plane 2 material wall\n")))
    browser.click(*browser.at(60, 40))
    browser.settle()
    flat = browser.pixels().astype(int)
    changes(browser, f"{which}, a relief", lambda: browser.choose("relief", "bricks"),
            lambda _, after: "object plane 2 2 64 displace bricks 0.1 material wall" in after)
    check(np.std(browser.pixels().astype(int)[30:50, 40:80]) > 2 > np.std(flat[30:50, 40:80, 0]), f"{which}: the wall shows the relief")
    height = lambda text: float(re.search(r"displace bricks (\S+)", text)[1])
    changes(browser, f"{which}, its height", lambda: fill(browser, "relief-height", "-0.05"), lambda _, after: height(after) == -0.05)
    at = lambda share: browser.evaluate("(() => { element('relief-slider').scrollIntoView({block: 'end'}); "
                                        "const b = element('relief-slider').getBoundingClientRect();"
                                        f"return [b.left + {share} * b.width, b.top + b.height / 2]; }})()")
    n = browser.evaluate("past.length")
    changes(browser, f"{which}, its slider", lambda: browser.drag(line(at(0.45), at(0.8))), lambda _, after: 0.1 < height(after) < 0.25)
    check(browser.evaluate("past.length") == n + 1, f"{which}: a drag of the slider is one change to undo", n, browser.evaluate("past.length"))
    agrees(browser, "wall", f"{which}, a relief")
    changes(browser, f"{which}, no relief", lambda: browser.choose("relief", ""), lambda _, after: "object plane 2 2 64 material wall" in after)
    check(browser.evaluate("element('relief-slider').disabled"), f"{which}: no height is asked for then")


def statements(text, word):
    return [one for one in text.splitlines() if one.startswith(word)]


def more_and_fewer(browser, which):
    """Lights and objects come and go; the handles of lights carry their numbers."""
    n = lambda text, word: len(statements(text, word))
    changes(browser, f"{which}, a light more", lambda: browser.press("add-light"),
            lambda before, after: n(after, "light") == n(before, "light") + 1)
    numbers = browser.evaluate("[...document.querySelectorAll('#handles text')].map(node => node.textContent)")
    check(numbers == ["1", "2", "3"], f"{which}: handles have the numbers of their lights", numbers)
    agrees(browser, "spheres", f"{which}, a light more")
    changes(browser, f"{which}, a light fewer", lambda: browser.press("lights-1-remove"),
            lambda before, after: statements(after, "light") == statements(before, "light")[1:])
    browser.click(*browser.at(*pixel_of(browser, "plastic")))
    browser.settle()
    name = browser.evaluate("chosen_object().name")
    of = lambda text: [one for one in statements(text, "object") if f"material {name}" in one]
    changes(browser, f"{which}, an object more", lambda: browser.press("copy-object"),
            lambda before, after: len(of(after)) == 2 and of(after)[0] == of(before)[0] and of(after)[1] != of(before)[0])
    agrees(browser, "spheres", f"{which}, an object more")
    changes(browser, f"{which}, an object fewer", lambda: browser.press("remove-object"), lambda before, after: len(of(after)) == 1)
    check(browser.evaluate("element('copy-object').disabled"), f"{which}: no object is chosen then")


def own(name):
    """A copy of a built-in scene."""
    live("show", name, "-o", path_of(name + ".scene"))
    return path_of(name + ".scene")


def controls(browser, which):
    browser.size(1400, 1000)
    browser.open(view(own("spheres"), "--size", "150x100"))
    cameras(browser, which)
    agrees(browser, "spheres", f"{which}, after changes of the camera")
    browser.open(view(own("spheres"), "--size", "150x100"))
    objects(browser, which)
    lights(browser, which)
    agrees(browser, "spheres", f"{which}, after all other changes")
    browser.open(view(own("spheres"), "--size", "150x100"))
    more_and_fewer(browser, which)
    reliefs(browser, which)
    browser.open(view(own("spheres"), "--size", "150x100"))
    shadows(browser, which)
    browser.open(view(own("colorchecker"), "--size", "150x100"))
    browser.click(*browser.at(*pixel_of(browser, "02-light-skin")))
    changes(browser, f"{which}, an object of a checker", lambda: fill(browser, "place-z", "1.5"),
            lambda _, after: after.count("\nobject torus") == 24 and "\nchecker" not in after)
    agrees(browser, "colorchecker", f"{which}, a checker opened")


def first_edits(browser, which):
    """The first edit of a built-in scene is made with the value that was chosen, while the page reads the scene's text."""
    browser.size(1400, 1000)
    page = view("spheres", "--size", "90x60")
    before = live("show", "spheres")
    for kind, control, value, pattern in EDITS:
        browser.open(page)
        browser.click(*browser.at(*pixel_of(browser, "plastic")))
        browser.settle()
        edit(browser, kind, control, value)
        new = added(before, text_of(browser))
        check(any(re.search(pattern, one) for one in new), f"{which}: the first edit, by {control}, is made", new,
              browser.message())
        if control in SHOWN:
            seen = float(browser.evaluate(f"element('{control}').value"))
            check(seen == float(value), f"{which}: {control} then shows it", seen)


def quick_edits(browser, which):
    """An ambient light that the scene does not have gets one statement, also from the second edit before the picture comes."""
    browser.open(view(write("dark.scene", "camera ortho 3\nsize 60 40\nmaterial m { diffuse 0.5 }\nobject sphere 1 material m\n")))
    browser.evaluate("(() => { for (const intensity of [0.25, 0.5]) edit_light('ambients', 0, {intensity}); })()")
    browser.settle()
    found = [one for one in text_of(browser).splitlines() if one.startswith("ambient")]
    check(len(found) == 1 and found[0].endswith(" 0.5"), f"{which}: two quick edits of an ambient light make one statement", found)


def typing(browser, which):
    """Digits go on to the same field when the rows of lights are made anew between them."""
    browser.open(view(own("spheres"), "--size", "60x40"))
    browser.evaluate("(() => { const field = element('ambients-1-intensity'); field.closest('details').open = true; field.focus(); field.select(); })()")
    browser.type("0.")
    browser.evaluate("(() => { element('sources').dataset.key = ''; refresh_sources(); })()")
    browser.type("625")
    browser.settle()
    seen = browser.evaluate("element('ambients-1-intensity').value")
    check(seen == "0.625" and words_of(browser, "ambient")[-1:] == ["0.625"],
          f"{which}: a number that is typed while rows are made anew is whole", seen, words_of(browser, "ambient"))


# ---- opening and saving ----

def drop(browser, *paths):
    n = browser.evaluate("past.length")
    browser.drop(*paths)
    browser.wait(f"past.length > {n}")
    browser.settle()


def opening(browser, which):
    write("lamp.csv", "nm,power\n400,0.2\n550,1\n700,0.4\n")
    write("red.txt", "g 20\n400 0.05\n600 0.3\n700 0.6\n")
    write("my.list", "red.txt\nred.txt\n")
    write("tri.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    scene = write("my.scene", "wavelengths 400 700 50\ncamera ortho 3\nsize 90 60\nambient lamp.csv 0.5\n"
                              "light d65 1 position 1 2 3\nmaterial red red.txt\nobject sphere 1 material red\n")
    words = "patches", "--size", "60x40", "--light", f"1={path_of('lamp.csv')}*0.5"
    browser.open(view(*words))
    check(browser.message() == "" and bytes_of(browser.download("save-stack", "patches.tif")) == rendered(*words),
          f"{which}: a built-in scene under a light from a file", browser.message())
    changes(browser, f"{which}, that scene", lambda: fill(browser, "size-width", "66"), lambda _, after: "size 66 40" in after and
            f"light {path_of('lamp.csv')} 0.5 " in after)
    fill(browser, "lights-1-intensity", "0.25")
    check(browser.evaluate("scene.lights[0].intensity") == 0.25, f"{which}: a light of an option can be changed")
    page = view("colorchecker", "--size", "60x40")
    browser.open(page)
    drop(browser, scene, path_of("lamp.csv"), path_of("red.txt"))
    check(browser.evaluate("state.scene") == "my.scene" and browser.message() == "" and browser.evaluate("canvas.width") == 90,
          f"{which}: a scene that is dropped with its files is drawn", browser.message())
    saved = bytes_of(browser.download("save-stack", "my.tif"))
    check(saved == rendered("my.scene", cwd=TMP), f"{which}: its stack is that of render")
    archive = browser.download("save-scene", "my.tar")
    with tarfile.open(archive) as tar:
        kept = {member.name: tar.extractfile(member).read() for member in tar.getmembers()}
    check({"my/my.scene", "my/lamp.csv", "my/red.txt"} <= set(kept) and
          all(kept[f"my/{name}"] == open(path_of(name), "rb").read() for name in ("my.scene", "lamp.csv", "red.txt")),
          f"{which}: with files of its own it is saved as an archive of them", sorted(kept))

    browser.choose("lights-1", "lamp.csv")
    check(words_of(browser, "light")[1] == "lamp.csv", f"{which}: a table that was dropped lights the scene", words_of(browser, "light"))
    before = browser.pixels()
    drop(browser, write_camera())
    seen = browser.evaluate("[element('detector').selectedOptions[0].text, eye.detector.name]")
    stack = browser.download("save-stack", "my.tif")
    expected, _ = developed(stack, f"--detector={path_of('camera.csv')}", "--exposure=auto")
    apart = np.abs(browser.pixels()[:, :, :3].astype(int) - expected).max()
    check(seen == ["camera.csv"] * 2 and apart <= 1 and (browser.pixels() != before).any(),
          f"{which}: a detector that was dropped sees the scene", seen, apart, browser.message())
    browser.choose("detector", "cie1931")
    seen = browser.pixels()
    check((seen == before).all(), f"{which}: the others stay in the menu", np.abs(seen.astype(int) - before).max())
    browser.choose("detector", "camera.csv")
    browser.press("undo")
    browser.settle()
    check((browser.pixels() == before).all() and browser.evaluate("[...element('detector').options].length") == 7,
          f"{which}: undo takes the detector away", browser.evaluate("eye.detector.name"))
    browser.choose("scene-view", "band")
    browser.put("scene-band", 6)
    fill(browser, "wavelengths", "400:700:100")
    check(browser.text("scene-band-nm") == "700 nm", f"{which}: fewer bands: the last one is shown", browser.text("scene-band-nm"))
    browser.press("undo")
    browser.choose("scene-view", "detector")
    drop(browser, path_of("tri.obj"))
    browser.click(*browser.at(*pixel_of(browser, "red")))
    browser.choose("object-shape", "mesh tri.obj")
    check("object mesh tri.obj" in text_of(browser) and browser.message() == "", f"{which}: a mesh that was dropped is a shape",
          browser.message())

    browser.choose("detector", "cie1964")
    browser.choose("lights-1", "a")
    text, picture = text_of(browser), browser.pixels()
    browser.press("copy-link")
    browser.wait("location.hash.length > 20")
    fragment = browser.evaluate("location.hash")
    browser.open(page, fragment)
    browser.settle()
    check(text_of(browser) == text and np.array_equal(browser.pixels(), picture) and
          browser.evaluate("element('detector').selectedOptions[0].text") == "cie1964",
          f"{which}: a link holds scene, files and eye ({len(fragment)} characters)")

    drop(browser, path_of("my.list"), path_of("red.txt"))
    check(browser.evaluate("[state.scene, scene.objects.length]") == ["my.list", 3] and browser.message() == "",
          f"{which}: a list is drawn as a grid", browser.message())
    browser.choose("builtin-scene", "spheres")
    check(browser.evaluate("state.scene") == "spheres" and browser.message() == "", f"{which}: a built-in scene is chosen",
          browser.message())


def broken_links(browser, which):
    """A link that was cut says so, and goes on; one to a scene with an error shows its text, which can be mended."""
    page = view("spheres", "--size", "60x40")
    browser.open(page)
    fill(browser, "lights-1-intensity", "0.25")

    def link():
        before = browser.evaluate("location.hash")
        browser.press("copy-link")
        browser.wait(f"location.hash !== {before!r}")
        return browser.evaluate("location.hash")

    whole = link()
    for end in (2, 3, len(whole) // 2, len(whole) - 1):
        browser.open(page, whole[:end])
        first = browser.text("notice")
        fill(browser, "lights-1-intensity", "0.5")
        check("was cut" in first and browser.text("notice") == first and browser.message() == "" and browser.evaluate("state.scene") == "spheres.scene",
              f"{which}: a link cut to {end} of {len(whole)} characters says so, and goes on when the scene changes", first, browser.text("notice"))
    link()
    check(browser.text("notice") == "", f"{which}: it says no more when the address is a link again")
    browser.evaluate("(() => { const name = state.scene; commit({...state, files: {[name]: text_of(state).replace('camera perspective', 'camera perspectif')}}, 3); })()")
    browser.settle()
    browser.open(page, link())
    browser.settle()
    check(browser.evaluate("state.scene") == "spheres.scene" and "perspectif" in browser.message() and browser.evaluate("element('text-group').open")
          and "perspectif" in browser.evaluate("element('text').value") and browser.evaluate("canvas.width") == 60,
          f"{which}: a link to a scene with an error shows the error, the text, and the page's own scene", browser.message())
    write_text(browser, text_of(browser).replace("perspectif", "perspective"))
    check(browser.message() == "" and words_of(browser, "light")[2] == "0.5", f"{which}: the text can be mended", browser.message())


def pictures(browser, which):
    """A picture of each format that the program reads is a texture and a relief; of others it says what it lacks."""
    squares = Image.fromarray(np.kron(np.indices((4, 4)).sum(axis=0) % 2 * 200 + 20, np.ones((4, 4))).astype(np.uint8))
    names = [f"squares{ending}" for ending in (".png", ".sgi", ".tif")]
    wall = write("wall.scene", "camera ortho 3\nsize 60 40\nlight d65 1 direction 3 1 1\nmaterial wall { diffuse 0.7 }\nobject plane 2 material wall\n")
    for name in names:
        squares.save(path_of(name))
        browser.open(view(wall))
        drop(browser, path_of(name))
        check(name in browser.text("notice"), f"{which}, {name}: the page says where it is now", browser.text("notice"))
        browser.click(*browser.at(30, 20))
        browser.settle()
        for menu, word in (("texture", f"texture {name} linear"), ("relief", f"displace {name} 0.1")):
            before = browser.pixels()
            browser.choose(menu, name)
            check(word in text_of(browser) and browser.message() == "" and (browser.pixels() != before).any(),
                  f"{which}, {name}: it is in the menu {menu}", text_of(browser), browser.message())
    seen = browser.evaluate("eye.detector.name")
    drop(browser, write("six.csv", "nm,a,b,c,d,e,f\n400,0,0,0,0,0,1\n700,1,0,0,0,0,0\n"))
    check("six.csv has 6 channels" in browser.text("notice") and browser.evaluate("eye.detector.name") == seen,
          f"{which}: a camera of six channels is told that a page sees by three", browser.text("notice"))


def all_shapes(browser, which):
    """Each choice of shape holds for all objects but the background, also those of a checker."""
    for scene, kept in (("spheres", ""), ("colorchecker", "object sphere 14 40 40 material background translate 0 0 -16")):
        browser.open(view(scene, "--size", "30x20"))
        shapes = browser.evaluate("[...element('all-shapes').options].map(({value}) => value).filter(value => value)")
        wrong = []
        for words in shapes:
            browser.choose("all-shapes", words)
            shaped = [one for one in text_of(browser).splitlines() if re.match("object |checker ", one) and one != kept]
            wrong += [one for one in shaped if not re.match(f"(object|checker colorchecker) {words}( |$)", one)] + [browser.message()]
        check(len(shapes) > 15 and shaped and not any(wrong) and kept in text_of(browser), f"{which}, {scene}: all objects get each shape", wrong)


# ---- the gallery and the plot ----

POLICY = ("default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; style-src 'unsafe-inline'; "
          "img-src blob: data:; worker-src blob:; base-uri 'none'; form-action 'none'")


def policy(browser, which):
    browser.open(view("patches", "--size", "30x20"))
    said = browser.evaluate("document.querySelector('meta[http-equiv]').content")
    check(said == POLICY, f"{which}: the policy allows the program that the page holds, and nothing more than a still page", said)
    blocked = browser.evaluate("fetch('data:text/plain,x').then(() => 'fetched', () => 'blocked')")
    check(blocked == "blocked", f"{which}: the policy blocks a fetch", blocked)
    evaluated = browser.evaluate("(() => { try { return new Function('return 1')(); } catch { return 'blocked'; } })()")
    check(evaluated == "blocked", f"{which}: and a text that would become a script", evaluated)
    if which == "Chromium":
        browser.complaints.clear()  # of these


def gallery(browser, which):
    live("view", "--gallery", "--size", "60x40", "-o", path_of("gallery.html"), "--quiet")
    browser.open(path_of("gallery.html"))
    browser.wait("document.body.dataset.gallery === 'true'")
    drawn = browser.evaluate("""[...document.querySelectorAll("#gallery canvas")].map(one =>
        new Set(one.getContext("2d").getImageData(0, 0, one.width, one.height).data).size)""")
    check(len(drawn) == len(SCENES) and min(drawn) > 30, f"{which}: the gallery shows all built-in scenes", drawn)
    browser.press("gallery-room")
    browser.settle()
    check(browser.evaluate("state.scene") == "room" and browser.evaluate("canvas.width") == 60 and browser.message() == "",
          f"{which}: a click in the gallery opens a scene")


def plot(browser, which):
    browser.open(view("fluorescence", "--size", "60x40"))
    curves = browser.evaluate("curves_at(pixel).map(({name}) => name)")
    names = {"radiance", "reflectance", "light 1 (d65)", "cie1931 x", "cie1931 y", "cie1931 z"}
    check(names <= set(curves), f"{which}: the plot has radiance, reflectance, light and the detector's functions", curves)
    drawn = lambda: browser.evaluate("document.querySelectorAll('#chart .sees-g').length")
    before = drawn()
    browser.evaluate("[...document.querySelectorAll('#curves label')].find(({textContent}) => textContent === 'cie1931 y').firstChild.click()")
    check((before, drawn()) == (0, 1), f"{which}: the detector's functions are drawn when they are switched on")
    if hasattr(browser, "pointer"):
        browser.evaluate("document.getElementById('chart').scrollIntoView({block: 'center'})")
        left, top, width, height = browser.evaluate(
            "(() => { const b = document.querySelector('#chart svg').getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()")
        browser.pointer("mouseMoved", left + width / 2, top + height / 2, 0)
        said = browser.evaluate("element('at-cursor').textContent")
        nm = float(said.split(" nm")[0])
        name, said_value = said.split(" nm, ")[1].rsplit(": ", 1)
        value = browser.evaluate(f"curves_at(pixel).find(({{name}}) => name === {name!r}).values[scene.wavelengths.indexOf({nm})]")
        check(abs(float(said_value) - value) <= 1e-3 * abs(value) and abs(nm - 530) < 60,
              f"{which}: the value at the pointer is that of the curve", said, value)


# ---- the text ----

# A word of the text, a wrong one in its place, and a part of the message.
MISTAKES = (
    ("size 150 100", "size 150", "height"),
    ("camera perspective", "camera perspectif", "unknown"),
    ("gloss 40", "gloss 400", "gloss"),
    ("colorchecker/15-red", "colorchecker/15-redd", "15-red"),
    ("material green translate", "material gren translate", "green"),
    ("object sphere 1.2 40 40 material red", "object spere 1.2 40 40 material red", "sphere"),
    ("{ diffuse 0.04 specular 0.9  gloss 100 }", "{ diffuse 0.04 specular 0.9  gloss 100", "}"),
    ("light a 0.95", "light a -0.95", "intensity"),
    ("wavelengths 400 700 10", "wavelengths 400 700 1e999", "STEP"),
    ("viewer local", "viewer local\ninclude spheres.scene", "include"),
)


def paste(browser, text):
    """Puts a text into the editor."""
    browser.evaluate(f"""(() => {{
        element("text-group").open = true;
        element("text").focus();
        element("text").select();
        document.execCommand("insertText", false, {json.dumps(text)});
    }})()""")


def write_text(browser, text):
    """Puts a text into the editor, and waits for its picture."""
    paste(browser, text)
    browser.wait(f"(is_text(state) && text_of(state) === {json.dumps(text)}) || element('text').value !== {json.dumps(text)}")
    browser.settle()


def mistakes(browser, which):
    with open(own("spheres"), encoding="utf-8") as file:
        good = file.read().replace("size 480 320", "size 150 100")
    path_name = path_of("spheres.scene")
    write("spheres.scene", good)
    browser.open(view(path_name))
    browser.evaluate("element('text-group').open = true")
    browser.wait("element('text').value !== ''")
    before = browser.pixels()
    for right, wrong, part in MISTAKES:
        check(good.count(right) >= 1, f"{which}, {wrong.strip()!r}: a mistake is made")
        write_text(browser, good.replace(right, wrong))
        shown = browser.evaluate("element('text-error').firstChild?.textContent || ''").strip()
        write("spheres.scene", good.replace(right, wrong))
        run_error = run("plan", "spheres.scene", program=LIVE, cwd=TMP).stderr.strip()
        check(shown == run_error and part in shown and browser.message() == shown,
              f"{which}, {wrong.strip()!r}: the page shows the message of the command line",
              shown, run_error)
        check(np.array_equal(browser.pixels(), before), f"{which}, {wrong.strip()!r}: the last good picture stays")
    browser.press("to-error")
    browser.wait("document.activeElement === element('text')")
    chosen = browser.evaluate("element('text').value.slice(element('text').selectionStart, element('text').selectionEnd)")
    check("include spheres.scene" in chosen, f"{which}: a button leads to the line", chosen)
    write_text(browser, good.replace("light d65 1.8", "light d65 0.9"))
    check(browser.message() == "" and not np.array_equal(browser.pixels(), before), f"{which}: the mended text is drawn",
          browser.message())
    write_text(browser, good)
    check(np.array_equal(browser.pixels(), before), f"{which}: the old text gives the old picture")
    late = good.replace("light d65 1.8", "light d65 0.7")
    paste(browser, late)
    with open(browser.download("save-scene", "spheres.scene"), encoding="utf-8") as file:
        check(file.read() == late, f"{which}: a scene that is saved at once has what was typed last")
    write("part.scene", "include spheres\n")
    write("whole.scene", "include part.scene\n# a comment\n")
    browser.open(view(path_of("whole.scene"), "--size", "90x60"))
    browser.click(*browser.at(*pixel_of(browser, "plastic")))
    browser.settle()
    fill(browser, "place-x", "1")
    check("is built in" in browser.message() and "translate" not in text_of(browser),
          f"{which}: an object of a built-in scene that another file includes is not changed", browser.message(),
          text_of(browser))


# ---- hostile scenes ----

STRANGE = 'a </script><img src=x onerror=document.title=1><b>&amp; \\ <!-- <script>document.title=2</script>'
HOSTILE = (
    ("size 99999 99999", "a page shows at most"),
    ("size 100 100\nobject sphere 1 4096 4096 material m", "memory"),
    ("size 100 100\ninclude hostile.scene", "no file hostile.scene"),
    ("size 100 100\nobject mesh nowhere.obj material m", "nowhere.obj"),
    ("wavelengths 1 100000 0.001", "wavelengths"),
)


def hostile(browser, which):
    head = f'material "{STRANGE}" {{ diffuse 0.5 }}\nmaterial m {{ diffuse 0.5 }}\nlight d65 1 direction 0 0 1\n'
    body = f'object sphere 1 material "{STRANGE}"\n'
    name = write("a 'strange' & <b>name.scene", "camera ortho 3\nsize 90 60\n" + head + body)
    browser.open(view(name))
    browser.click(*browser.at(45, 30))
    browser.settle()
    check(browser.evaluate("document.querySelectorAll('b, img, i').length") == 0 and STRANGE in
          browser.text("chosen"), f"{which}: markup in names is shown as it is",
          browser.text("chosen"))
    changes(browser, f"{which}, a scene of strange names: a place", lambda: fill(browser, "place-x", "0.5"),
            lambda before, after: "translate 0.5 0 0" in after and STRANGE in after)
    for lines, part in HOSTILE:
        write_text(browser, "camera ortho 3\n" + head + lines + "\n" + body)
        check(part in browser.message(), f"{which}: {lines!r} is refused", browser.message())
    check(browser.evaluate("document.title").startswith("a 'strange'"), f"{which}: no name has run as a script",
          browser.evaluate("document.title"))
    paste(browser, "camera ortho 3\nsize 3000 3000\n" + head + "object sphere 1 1500 1500 material m\n" * 3)
    time.sleep(0.5)
    since = time.monotonic()
    busy = browser.evaluate("element('shown').getAttribute('aria-busy') === 'true'")
    check(busy and time.monotonic() - since < 1, f"{which}: the page answers while a worker draws for long")
    write_text(browser, "camera ortho 3\nsize 90 60\n" + head + body)
    check(browser.message() == "" and browser.evaluate("canvas.width") == 90, f"{which}: a good scene is drawn again",
          browser.message())


SELDOM = (start, gallery, plot, opening, broken_links, pictures, all_shapes, hostile)  # in Firefox, with FULL only
BROWSERS = {"Chromium": Browser, "Firefox": Firefox}


def main():
    for which, kind in BROWSERS.items():
        browser = kind(path_of(which))
        for part in (start, policy, gallery, plot, first_edits, quick_edits, typing, controls, opening, broken_links, pictures, all_shapes, mistakes,
                     hostile, stacks):
            if which == "Chromium" or part not in SELDOM or os.environ.get("FULL"):
                part(browser, which)
        if which == "Chromium":
            foreign = [one for one in browser.requests if not one.startswith(("file:", "blob:", "data:"))]
            check(not foreign and not browser.complaints, "Chromium: no page fetches or complains", foreign, *browser.complaints)
        browser.close()
    done()


main()
