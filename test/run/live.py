#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Tests live pages in headless Chromium and Firefox: the program in the page renders the bytes that the program itself
renders, and changes by mouse, touch, keys and text stand in the saved scene. Prints TAP."""
import hashlib
import os
import subprocess
import sys
import time

sys.dont_write_bytecode = True
from browser import Browser, Firefox
from rendered import SPECTRAL, TMP, check, done
from tap import bail_out

PROGRAM = os.path.abspath(SPECTRAL)
SCENES = ("colorchecker", "fluorescence", "metals", "metamers", "pasture", "patches", "room", "spheres", "textures")
SIZE = "96x64"
SETTLED = "document.getElementById('shown').getAttribute('aria-busy') === 'false'"


def run(*words, **options):
    result = subprocess.run([PROGRAM, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False,
                            **options)
    if result.returncode != 0:
        bail_out(words, result.stderr)
    return result.stdout


def path_of(name):
    return os.path.join(TMP, name)


def view(scene, *options):
    page = path_of("live.html")
    run("view", scene, "-o", page, "--quiet", *options)
    return page


def digest(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def rendered(scene, *options):
    stack = path_of("native.tif")
    run("render", scene, "--renderer", "raster", "--no-check", "--quiet", "-o", stack, *options)
    return digest(stack)


def click(browser, element):
    browser.evaluate(f"document.getElementById({element!r}).click()")


def settle(browser):
    browser.wait(SETTLED)


def download(browser, button, name):
    """Clicks a button, and returns the path of the file that the page then saves."""
    path = os.path.join(browser.downloads, name)
    if os.path.exists(path):
        os.remove(path)
    click(browser, button)
    since, size = time.monotonic(), -1
    while size < 0 or size != os.path.getsize(path) or size == 0:
        if time.monotonic() - since > 60:
            bail_out(f"{name} was not saved")
        size = os.path.getsize(path) if os.path.exists(path) else -1
        time.sleep(0.1)
    return path


def stacks(browser, which):
    """The stack that the page saves has the bytes of the program's."""
    for scene in SCENES:
        browser.open(view(scene, "--size", SIZE))
        saved = digest(download(browser, "save-stack", scene + ".tif"))
        check(saved == rendered(scene, "--size", SIZE), f"{which}, {scene}: the stack that the page saves is that of render")


BROWSERS = {"Chromium": Browser, "Firefox": Firefox}


def main():
    for which, kind in BROWSERS.items():
        browser = kind(path_of(which))
        stacks(browser, which)
        browser.close()
    done()


main()
