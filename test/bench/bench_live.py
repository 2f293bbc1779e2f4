#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Measures a live page in Chromium and Firefox: its size, the time until the first picture, pictures a second while the
view turns, in full and coarser, and memory. usage: bench_live.py PROGRAM FOLDER [SCENE [SIZE]]"""
import math
import os
import re
import subprocess
import sys
import time

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "run"))
from browser import Browser, Firefox

SECONDS = 4


def around(browser, coarseness):
    """Turns the view by the mouse for some seconds. Returns pictures a second."""
    browser.evaluate(f"(() => {{ adapt_coarseness = () => {{}}; coarseness = {coarseness}; canvas.scrollIntoView(); "
                     "globalThis.drawn = 0; count_frame = () => globalThis.drawn++; })()")
    left, top, width, height = browser.evaluate("(() => { const b = canvas.getBoundingClientRect();"
                                                "return [b.left, b.top, b.width, b.height]; })()")
    place = lambda i: (left + width * (0.5 + 0.3 * math.cos(i / 40)), top + height * (0.5 + 0.3 * math.sin(i / 40)))
    browser.pointer("mousePressed", *place(0), 1)
    since, i, first = time.monotonic(), 0, browser.evaluate("globalThis.drawn")
    while time.monotonic() - since < SECONDS:
        i += 1
        browser.pointer("mouseMoved", *place(i), 1)
    elapsed, drawn = time.monotonic() - since, browser.evaluate("globalThis.drawn") - first
    browser.pointer("mouseReleased", *place(i), 0)
    browser.wait("document.getElementById('shown').getAttribute('aria-busy') === 'false'")
    return drawn / elapsed


def memory_mb(browser):
    """The resident memory of the process that draws the page, and of its workers, which are its threads."""
    sizes = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/cmdline", "rb") as words, open(f"/proc/{pid}/status", encoding="ascii") as status:
                line, text = words.read(), status.read()
        except OSError:
            continue
        if browser.downloads.encode() in line and b"--type=renderer" in line:
            sizes.append(int(re.search(r"VmRSS:\s+(\d+)", text).group(1)) / 1000)
    return max(sizes)


def main():
    program, folder, scene, size = (sys.argv[1:] + ["colorchecker", "600x400"][len(sys.argv) - 3:])[:4]
    page = os.path.join(folder, "live.html")
    os.makedirs(folder, exist_ok=True)
    subprocess.run([program, "view", scene, "--size", size, "-o", page, "--quiet"], check=True)
    print(f"page                    {os.path.getsize(page) / 1e6:.2f} MB, of {scene}, {size}")
    for name, kind in (("Chromium", Browser), ("Firefox", Firefox)):
        browser = kind(os.path.join(folder, name))
        firsts = []
        for _ in range(3):
            browser.open(page)
            firsts.append(int(re.search(r"([\d.]+) ms", browser.evaluate("element('progress').textContent")).group(1)))
        print(f"{name}: first picture {sorted(firsts)[1]:4d} ms after the page is read")
        if kind is Browser:
            for coarseness, words in ((1, "in full"), (2, "half as fine"), (4, "a quarter as fine")):
                print(f"          turning       {around(browser, coarseness):4.1f} pictures a second {words}")
            print(f"          memory        {memory_mb(browser):.0f} MB, with its workers")
        browser.close()


main()
