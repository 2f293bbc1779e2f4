#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile python3-gdal chromium; makes: live
"""Tests pages of stacks in headless Chromium and Firefox: pictures equal those of develop, bands, regions and maps those
that numpy computes from the file, for stacks of this program and for a cube that GDAL wrote. Prints TAP."""
import json
import os

import numpy as np
from osgeo import gdal

from browser import Browser, Firefox
from colours import srgb
from rendered import LIVE, SPECTRAL, check, developed, done, output_of, path_of, reference, run, values_of

gdal.UseExceptions()
PROGRAM = os.path.abspath(SPECTRAL)


def foreign(name="cube", first=400, last=1000, n=200):
    """A cube, written by GDAL, and its values as [band, y, x]."""
    height, width = 40, 60
    y, x = np.mgrid[0:height, 0:width]
    values = np.stack([np.abs(0.3 + 0.2 * np.sin(x / 9 + k / 20) + 0.2 * np.cos(y / 7 - k / 30)) for k in range(n)]).round(4).astype(np.float32)
    cube = gdal.GetDriverByName("GTiff").Create(path_of(name + ".tif"), width, height, n, gdal.GDT_Float32, ["INTERLEAVE=PIXEL"])
    for band, nm in enumerate(np.linspace(first, last, n)):
        cube.GetRasterBand(band + 1).WriteArray(values[band])
        cube.GetRasterBand(band + 1).SetMetadata({"wavelength": f"{nm:.3f}", "wavelength_units": "Nanometers"})
    del cube
    return path_of(name + ".tif"), values


kind = [PROGRAM]  # the program whose pages are tested: only live pages can open other stacks


def view(stack, *options):
    output_of("view", stack, "-o", path_of("stack.html"), "--quiet", *options, program=kind[0])
    return path_of("stack.html")


# ---- the page ----

def near(seen, expected):
    seen = seen[:, :, :3]
    return seen.shape == expected.shape and np.abs(seen.astype(float) - expected).max() <= 1


# ---- own stacks ----

EYES = ((), ("--adaptation=cat16", "--detector=cie2006-2"), ("--adaptation=fairchild", "--exposure=1.5"),
        ("--detector=dcs200-camera", "--display=monitor"), ("--exposure=auto", "--display=monitor"))


def eyes(browser, which, name, stack):
    browser.open(view(stack))
    for options in EYES:
        browser.see_by(options)
        seen, (expected, _) = browser.pixels()[:, :, :3], developed(stack, *options)
        check(near(seen, expected) and np.ptp(seen) > 100, f"{which}, {name}, {' '.join(options) or 'as it is'}: within 1 of develop",
              np.abs(seen.astype(int) - expected).max())


def spectra(browser, which, stack):
    browser.open(view(stack))
    values = values_of(stack)
    check("white" in browser.text("picked"), f"{which}: the page opens with an object before the background", browser.text("picked"))
    browser.click(*browser.at(20.5, 10.5))
    seen = np.array(browser.evaluate("[...stack_curves()[0].values]"))
    check(np.allclose(seen, values[:, 10, 20], rtol=1e-12, atol=0), f"{which}: a click shows the spectrum of the file",
          np.abs(seen - values[:, 10, 20]).max())
    check(browser.text("picked").startswith("Pixel 20, 10: "), f"{which}: and its object")
    browser.press("keep")
    browser.click(*browser.at(40.5, 30.5))
    browser.press("keep")
    check(browser.evaluate("kept_spectra.length") == 2 and len(browser.evaluate("stack_curves().map(({name}) => name)")) >= 3,
          f"{which}: several spectra are kept side by side")
    browser.choose("stack-view", "angle")
    kept = values[:, 10, 20]
    length = np.linalg.norm(values, axis=0) * np.linalg.norm(kept)
    angle = np.arccos(np.clip(np.tensordot(kept, values, (0, 0)) / np.where(length > 0, length, 1), -1, 1))
    shown = np.array(browser.evaluate("[...map.values]")).reshape(angle.shape)
    check(np.allclose(shown[length > 0], angle[length > 0], atol=2e-7), f"{which}: the map of spectral angles is numpy's",
          np.abs(shown - angle)[length > 0].max())
    browser.choose("stack-view", "difference")
    difference = np.array(browser.evaluate("[...map.values]")).reshape(angle.shape)
    legend = browser.evaluate("(() => { const {hidden, style, children} = element('map-legend');"
                              " return [hidden, style.background, ...[...children].map(({textContent}) => textContent)]; })()")
    check(not legend[0] and "gradient" in legend[1] and legend[2] == "0" and legend[6].endswith("CIEDE2000") and
          abs(float(legend[6].split()[0]) - difference.max()) < 1e-3 * difference.max(), f"{which}: a legend below a map has its colours and values", legend)
    check(difference[10, 20] < 1e-9 and difference.max() > 10, f"{which}: the map of CIEDE2000 is 0 where the spectrum was kept",
          difference[10, 20])
    browser.evaluate("document.querySelector('#kept-list button').click()")
    check(browser.evaluate("kept_spectra.length") == 1, f"{which}: a kept spectrum is forgotten")


def differences(browser, which):
    pairs = np.loadtxt("test/cases/ciede2000.cases")
    seen = [browser.evaluate(f"ciede2000({list(pair[:3])}, {list(pair[3:6])})") for pair in pairs.tolist()]
    check(np.allclose(seen, pairs[:, 6], atol=5e-5), f"{which}: CIEDE2000 has the published values", seen)


# ---- a foreign cube ----

def cube(browser, which, stack, values):
    browser.open(view(stack))
    browser.choose("stack-view", "band")
    for band in (0, 57, 199):
        browser.put("band", band)
        expected = 255 * srgb(values[band] / values.max())[:, :, None].repeat(3, 2)
        check(near(browser.pixels(), expected), f"{which}: the slider shows band {band}, {browser.text('band-nm')}",
              np.abs(browser.pixels()[:, :, :3] - expected).max())
    browser.choose("stack-view", "bands")
    for name, band in (("red", 150), ("green", 80), ("blue", 20)):
        browser.choose("band-" + name, str(band))
    expected = 255 * srgb(np.moveaxis(values[[150, 80, 20]], 0, 2) / values.max())
    check(near(browser.pixels(), expected), f"{which}: three bands are shown as red, green and blue")
    browser.tool("rectangle")
    browser.drag([browser.at(10.5, 5.5), browser.at(20, 15), browser.at(30.5, 24.5)])
    region = values[:, 5:25, 10:31].astype(float).reshape(len(values), -1)
    statistics = browser.evaluate("[[...region.statistics.mean], [...region.statistics.spread], region.n]")
    check(statistics[2] == region.shape[1] and np.allclose(statistics[0], region.mean(1), rtol=1e-9) and
          np.allclose(statistics[1], region.std(1), rtol=1e-6, atol=1e-9), f"{which}: mean and spread of a rectangle are numpy's",
          statistics[2], region.shape[1])
    named = browser.evaluate("[...document.querySelectorAll('#region label')].map(label => label.innerText.trim())")
    check(named == ["Left", "Top", "Width", "Height"], f"{which}: the boxes of a region have names that are seen", named)
    for field, value in zip("xywh", (3, 4, 5, 6)):
        browser.put("region-" + field, value)
    mean = browser.evaluate("[...region.statistics.mean]")
    check(np.allclose(mean, values[:, 4:10, 3:8].astype(float).reshape(len(values), -1).mean(1), rtol=1e-9),
          f"{which}: a rectangle in numbers")
    browser.tool("polygon")
    corners = [(5, 5), (50, 8), (40, 35), (12, 30)]
    for corner in corners:
        browser.click(*browser.at(*corner))
    placed = np.array(browser.evaluate("drawn_region"))
    browser.press("end-polygon")
    y, x = np.mgrid[0:values.shape[1], 0:values.shape[2]] + 0.5
    inside = np.zeros(x.shape, bool)
    for (x1, y1), (x2, y2) in zip(placed, np.roll(placed, -1, 0)):
        with np.errstate(divide="ignore", invalid="ignore"):
            inside ^= ((y1 > y) != (y2 > y)) & (x < x1 + (y - y1) / (y2 - y1) * (x2 - x1))
    mean = browser.evaluate("[...region.statistics.mean]")
    check(len(placed) == 4 and np.abs(placed - corners).max() < 0.6 and np.allclose(mean, values[:, inside].astype(float).mean(1), rtol=1e-9),
          f"{which}: the mean of a polygon is numpy's", placed.tolist())


def unseen(browser, which):
    """A cube in the infrared, which no built-in detector sees."""
    stack, values = foreign("infrared", 1000, 2500, 20)
    browser.open(view(stack))
    browser.choose("stack-view", "band")
    browser.put("band", 3)
    expected = 255 * srgb(values[3] / values.max())[:, :, None].repeat(3, 2)
    check(near(browser.pixels(), expected), f"{which}: bands that nobody sees are shown", browser.text("message"))
    browser.click(*browser.at(20.5, 10.5))
    check(np.allclose(browser.evaluate("[...stack_curves()[0].values]"), values[:, 10, 20]), f"{which}: and their spectra")


# ---- zooming, in pages of all kinds ----

def zoom(browser):
    """The size of a pixel, and the scale; at 1 the picture fits. The page shows the size in per cent."""
    size, scale, shown = browser.evaluate("[pixel_size(), zoom.scale, element('zoom-figure').textContent]")
    return size if shown == f"{100 * size:.0f}\u00a0%" else shown, scale


def wheel(browser, x, y, by=-120, ctrl="false"):
    """Turns the wheel over the picture. Returns whether the page does not scroll."""
    return browser.evaluate(f"!canvas.dispatchEvent(new WheelEvent('wheel', {{clientX: {x}, clientY: {y}, deltaY: {by}, ctrlKey: {ctrl}, "
                            "bubbles: true, cancelable: true}))")


def key(browser, name, shift="false"):
    browser.evaluate(f"canvas.dispatchEvent(new KeyboardEvent('keydown', {{key: {name!r}, shiftKey: {shift}, bubbles: true, cancelable: true}}))")


def fits(browser, what):
    """Pictures of all sizes keep one rule: each fills its place if it is larger, and is else enlarged by the largest whole number."""
    wrong = browser.evaluate("""(() => {
        const own = shape, wrong = [], rem = 16;
        const height = matchMedia("(max-width: 62rem) and (min-height: 34rem)").matches ? 0.38 * innerHeight : Math.max(innerHeight - 22 * rem, 14 * rem);
        for (const width of [1, 7, 60, 96, 120, 300, 301, 450, 600, 601, 1200, 8300])
            for (const rows of [1, 20, 40, 64, 200, 300, 400, 800]) {
                shape = {...shape, width, height: rows};
                fit_frame();
                const most = Math.min(element("frame").parentElement.clientWidth / width, height / rows), expected = most < 1 ? most : Math.floor(most + 1e-9);
                if (Math.abs(pixel_size() - expected) * width > 0.6) wrong.push([width, rows, pixel_size(), most]);
            }
        shape = own;
        fit_frame();
        return wrong;
    })()""")
    check(not wrong, f"{what}: one rule enlarges pictures of 96 sizes", wrong)


def zoomed(browser, what, page):
    """The wheel, buttons and keys enlarge the picture about the pointer or the cross, and none else moves the camera of a live page."""
    live = what.endswith("live page")
    browser.open(page)
    fits(browser, what)
    start, _ = zoom(browser)
    x, y = browser.at(20.5, 10.5)
    stays = wheel(browser, x, y)
    browser.settle()
    check(zoom(browser) == (start, 1) and stays == live, f"{what}: the wheel over a picture that fits scrolls the page, or moves the camera", stays)
    n = browser.evaluate("typeof past === 'object' && past.length")
    stays = wheel(browser, x, y, -240, "true")
    check(stays and abs(zoom(browser)[1] - 2) < 1e-9 and browser.evaluate("typeof past === 'object' && past.length") == n,
          f"{what}: with Ctrl it enlarges the picture, and moves no camera", zoom(browser))
    stays = wheel(browser, x, y, -240)
    check(stays and abs(zoom(browser)[1] - (2 if live else 4)) < 1e-9, f"{what}: and without, once the picture is enlarged", zoom(browser))
    steps = {"fit": (start, "0"), "one-to-one": (1, "1"), "enlarge": (2, "+="), "reduce": (1, "-")}
    for button, (expected, keys) in steps.items():
        browser.press(button)
        check(zoom(browser)[0] == expected, f"{what}: the button {button} gives {100 * expected} %", zoom(browser))
    browser.press("fit")
    for button, (expected, keys) in steps.items():
        for name in keys if not live or button in ("fit", "one-to-one") else "":
            browser.evaluate("zoom_to(1.5)" if name in "=-" else "0")
            key(browser, name)
            check(zoom(browser)[0] == expected, f"{what}: the key {name} gives {100 * expected} %", zoom(browser))
    browser.press("fit")
    for _ in range(4):
        browser.press("enlarge")
    out_of_sight = []
    for step in ("Left", "Up", "Right", "Down", "Left"):
        for _ in range(browser.evaluate("Math.ceil(Math.max(shape.width, shape.height) / 10)")):
            key(browser, "Arrow" + step, "true")
            seen = browser.evaluate("""(() => {
                const cross = element("cross").getBoundingClientRect(), place = element("frame").parentElement.getBoundingClientRect();
                return cross.left >= place.left - 1 && cross.right <= place.right + 1 && cross.top >= place.top - 1 && cross.bottom <= place.bottom + 1;
            })()""")
            out_of_sight += [] if seen else [browser.evaluate("[cursor.x, cursor.y]")]
    check(not out_of_sight and zoom(browser)[1] > 1, f"{what}: the arrow keys lead to all borders of an enlarged picture", out_of_sight)
    browser.evaluate("element('controls').reset()")
    browser.settle()
    check(zoom(browser)[1] == 1 and browser.evaluate("[zoom.x, zoom.y]") == [0, 0], f"{what}: Reset shows all of it", zoom(browser))


def pointed(browser, which, stack):
    """A click on an enlarged picture picks the pixel that is seen there, and a drag shifts it."""
    browser.open(view(stack))
    x, y = browser.at(20.5, 10.5)
    for _ in range(6):
        wheel(browser, x, y, ctrl="true")
    scale, rendering = browser.evaluate("[zoom.scale, canvas.style.imageRendering]")
    check(abs(scale - 8) < 1e-9 and rendering == "pixelated", f"{which}: the wheel zooms in to pixels", scale, rendering)
    browser.click(x, y)
    check(browser.text("picked").startswith("Pixel 20, 10"), f"{which}: the pixel under the pointer stays there", browser.text("picked"))
    step, before = browser.evaluate("(({left, width}) => [width / shape.width, left])(canvas.getBoundingClientRect())")
    x, y = x + browser.evaluate("canvas.getBoundingClientRect().left") - before, y
    browser.click(x + step, y + step)
    check(browser.text("picked").startswith("Pixel 21, 11"), f"{which}: its neighbour is picked beside it", browser.text("picked"))
    before = browser.evaluate("canvas.getBoundingClientRect().left")
    browser.evaluate(f"""[['pointerdown', 0], ['pointermove', 30], ['pointerup', 30], ['click', 30]].forEach(([name, dx]) =>
        canvas.dispatchEvent(new PointerEvent(name, {{pointerId: 1, clientX: {x} + dx, clientY: {y}, bubbles: true}})))""")
    moved = browser.evaluate("canvas.getBoundingClientRect().left") - before
    check(browser.text("picked").startswith("Pixel 21, 11") and abs(moved - 30) <= 1, f"{which}: a drag shifts it, and picks nothing",
          browser.text("picked"), moved)


def budgets(browser, which, stack, values):
    page = view(stack, "--budget", "1")
    browser.open(page)
    factor, width = browser.evaluate("[stack.facts.factor, stack.facts.width]")
    said = [output_of("view", stack, "-o", page, "--budget", "1", program=program) for program in (LIVE, PROGRAM)]
    check(factor > 1 and all(f"means of {factor} x {factor} pixels" in one for one in said) and ["drop" in one for one in said] ==
          [True, False] and "drop" in browser.text("about"),
          f"{which}: a large stack is reduced, and lines say so", factor, said)
    blocks = values[:, :values.shape[1] // factor * factor, :values.shape[2] // factor * factor].astype(float)
    blocks = blocks.reshape(len(values), -1, factor, blocks.shape[2] // factor, factor).mean((2, 4))
    seen = np.array(browser.evaluate("[...stack.pages[77]]")).reshape(-1, width)[:blocks.shape[1], :blocks.shape[2]]
    check(np.allclose(seen, blocks[77], rtol=1e-6), f"{which}: its pixels are means")
    browser.click(*browser.at(10.5, 5.5))
    x, y = 10 * factor, 5 * factor
    probed = [float(line.split(",")[1]) for line in output_of("probe", stack, x, y, factor, factor, "--csv").splitlines()[1:]]
    csv = browser.evaluate("values_csv(stack_curves())").splitlines()
    check(browser.text("picked").startswith(f"Pixel {x}, {y} (mean of {factor} × {factor})") and f"pixel {x}, {y} (mean" in csv[0],
          f"{which}: a reduced page names places of the stack", browser.text("picked"), csv[0])
    check(np.allclose([float(line.split(",")[1]) for line in csv[1:]], probed, rtol=2e-6), f"{which}: and its CSV has the values of probe there")
    browser.evaluate(f"""(() => {{
        [{2 * factor}, {3 * factor}, {8 * factor}, {4 * factor}].forEach((value, i) => {{ element(RECTANGLE[i]).value = value; }});
        take_rectangle();
    }})()""")
    probed = [float(line.split(",")[1]) for line in
              output_of("probe", stack, 2 * factor, 3 * factor, 8 * factor, 4 * factor, "--csv").splitlines()[1:]]
    check(np.allclose(browser.evaluate("[...region.statistics.mean]"), probed, rtol=2e-6) and
          f"32 means of {factor} × {factor} pixels" in browser.text("picked"), f"{which}: so has a rectangle", browser.text("picked"))
    browser.drop(stack)
    browser.wait("stack.facts.factor === 1")
    seen = np.array(browser.evaluate("[...stack.pages[77]]"), np.float32).reshape(values[77].shape)
    check((seen == values[77]).all(), f"{which}: the whole stack is read where it is dropped onto the page")


def two(browser, which, one, other):
    """Two stacks side by side, with one cursor, and their difference."""
    browser.open(view(one))
    browser.evaluate("element('opens-beside').checked = true")
    browser.drop(other)
    browser.wait("beside !== null")
    values = [values_of(stack) for stack in (one, other)]
    browser.click(*browser.at(20.5, 10.5))
    curves = browser.evaluate("stack_curves().map(({values}) => [...values])")
    check(np.allclose(curves[0], values[0][:, 10, 20], rtol=1e-12) and np.allclose(curves[1], values[1][:, 10, 20], rtol=1e-12) and
          browser.evaluate("element('cross-2').style.left === element('cross').style.left"), f"{which}: two stacks have one cursor",
          browser.evaluate("[element('picked').textContent, stack_curves().map(({name}) => name)]"))
    browser.choose("stack-view", "beside-radiance")
    seen = np.array(browser.evaluate("[...map.values]")).reshape(values[0].shape[1:])
    check(np.allclose(seen, np.abs(values[0] - values[1]).max(0), rtol=1e-9, atol=1e-12), f"{which}: their difference is numpy's")
    browser.choose("stack-view", "beside-colour")
    line = next(line for line in run("compare", one, other).stdout.splitlines() if line.startswith("CIEDE2000"))
    expected = [float(line.split()[1]), float(line.split("percentile), ")[1].split()[0])]
    seen = browser.evaluate("[map.values.reduce((sum, one) => sum + one, 0) / map.values.length, map.largest]")
    check(np.allclose(seen, expected, rtol=1e-4), f"{which}: mean and largest CIEDE2000 are those of compare", seen, expected)
    browser.press("close-beside")
    check(browser.evaluate("beside === null && element('frame-2').hidden"), f"{which}: the second stack is closed")


def alone(browser, which, header):
    """A page of the usual program has no other program in it: it offers nothing that needs one."""
    browser.open(view(header, "--budget", "1"))
    hidden = browser.evaluate("[...document.querySelectorAll('#second-stack, #open, #module')].filter(one => !one.hidden).length")
    about = browser.text("about")
    check(hidden == 0 and "means of" in about and "drop" not in about, f"{which}: a page without the program offers no other stack", about)
    policy = browser.evaluate("document.querySelector('meta[http-equiv]').content")
    check("wasm" not in policy and "worker" not in policy and policy.endswith("base-uri 'none'; form-action 'none'"),
          f"{which}: its policy allows none", policy)


def packed():
    """The budget is one of the page: samples that compress well are not reduced."""
    stack = path_of("flat.tif")
    output_of("render", "patches", "--size", "300x200", "-o", stack, "--quiet")
    facts = json.loads(output_of("view", stack, "-o", path_of("x.html"), "--quiet", "--json", "-", "--budget", "3"))
    check(facts["factor"] == 1 and facts["bytes"] < 3e6 < 300 * 200 * 71 * 2, "a stack that fits compressed is not reduced", facts)


def refusals():
    stack = path_of("own.tif")
    facts = json.loads(output_of("view", stack, "-o", path_of("x.html"), "--quiet", "--json", "-"))
    check(facts["width"] == 60 and facts["bands"] == 93 and facts["factor"] == 1 and
          facts["bytes"] == os.path.getsize(path_of("x.html")), "--json has the figures of a page of a stack", facts)
    check(not os.path.exists(path_of("x.png")), "and nothing is written")


def main():
    own = reference("own.tif", "fluorescence", "--size", "60x40")
    deep = reference("deep.tif", "metamers", "--size", "60x40", "--depth", "32f")
    gauss = reference("gauss.tif", "colorchecker", "--size", "60x40", "--sampling", "gauss:8")
    other = reference("other.tif", "fluorescence", "--size", "60x40", "--light", "1=a*0.9")
    stack, values = foreign()
    for which, opened in (("Chromium", Browser), ("Firefox", Firefox)):
        browser = opened(path_of(which))
        browser.size(1400, 1000)
        kind[0] = PROGRAM if which == "Chromium" else LIVE
        for name, one in (("counts", own), ("floats", deep), ("gauss:8", gauss))[:3 if which == "Chromium" else 1]:
            eyes(browser, which, name, one)
        spectra(browser, which, own)
        differences(browser, which)
        cube(browser, which, stack, values)
        unseen(browser, which)
        if which == "Chromium":
            alone(browser, which, stack)
        kind[0] = LIVE
        pointed(browser, which, stack)
        zoomed(browser, f"{which}, a page of a stack", view(stack))
        for words, program in (("a live page", LIVE), ("a still page", PROGRAM)):
            output_of("view", "spheres", "--size", "120x80", "-o", path_of("zoomed.html"), "--quiet", program=program)
            zoomed(browser, f"{which}, {words}", path_of("zoomed.html"))
        budgets(browser, which, stack, values)
        two(browser, which, own, other)
        if which == "Chromium":
            check(not browser.complaints and all(one.startswith(("file:", "blob:", "data:")) for one in browser.requests),
                  "Chromium: no page fetches or complains", *browser.complaints)
        browser.close()
    packed()
    refusals()
    done()


main()
