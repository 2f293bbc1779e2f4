#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first
"""Each figure of sizes, times, shares and counts in the sentences of README and the pages has a source: the program's own constant,
which is compared, or the test or bench that measures it. A figure without one is found, and so is a row of the table below that no
sentence needs. Blocks of the pages are run by pages.py, and tables of measurements stand beside the command that prints them."""
import glob
import os
import re

from tap import check, done

UNITS = (r"%|KB|MB|GB|MiB|GiB|KiB|s\b|ms\b|seconds?|minutes?|hours?|times|scenes|small scenes|lines|counts?|CIEDE2000|pixels|inputs|texels|deep|tori|"
         r"wavelengths")
FIGURE = re.compile(rf"(?<![\w.,])(\d[\d.,]*\d|\d)\s?(?:{UNITS})")


def constant(path, pattern):
    """The number that a source gives, in decimal or as a shift."""
    with open(path, encoding="utf-8") as file:
        found = re.search(pattern, file.read())
    return eval(found.group(1)) if found else None


def limit(name, number=r"([\d<< ]+)"):
    return constant("spectral.h", f"{name} = {number}")


HARD, BUILT_IN = (len(glob.glob(f"data/builtin/{folder}/*.scene")) for folder in ("hard", "scenes"))
# page: rows of words in the sentence, and its source: the figure itself, or the file of a test
SOURCES = {
    "README.md": [
        ("stands for 1 count of 65535", 1),
        ("a program of 550 KB (stripped)", "test/builds/minimal.sh"), ("120 x 80 pixels", "test/builds/minimal.sh"),
        ("a ColorChecker of 24 tori in 93 wavelengths", "test/documents/pages.py"),
        ("(45 MB)", "test/documents/pages.py"), (f"The page draws {HARD + BUILT_IN} scenes", HARD + BUILT_IN)],
    "accuracy.md": [
        ("worst object if it is off by more than 1 CIEDE2000 at 95 %", constant("raster/beside/accuracy/refine.c", r"just_seen = (\d+)")),
        ("", "test/raster/beside/accuracy/accuracy.py")],
    "building.md": [("", "test/builds/minimal.sh"), ("stacks past 2 GiB and 4 GiB", "test/builds/containers.py")],
    "camera.md": [("no pixel is 0.1 CIEDE2000 off", "test/documents/pages.py")],
    "exchange.md": [
        ("at 150 x 100 pixels and 7 wavelengths", "test/raster/beside/verify/gpu.py"), ("more than 1 % of their pixels", "test/raster/beside/verify/gpu.py"),
        ("A picture has at most 8192 pixels a side", constant("raster/plan/plan.c", r"LARGEST_TILE = (\d+)"))],
    "maps.md": [("0.502 counts", "test/raster/beside/see/maps.py")],
    "materials.md": [("of lights: 0.5 %", "test/data/spectra/headings.py")],
    "mesa.md": [("", "test/raster/gl/test_mesa.c"), ("320 texels", "test/cases/mesa/blocks.scene"), ("32 texels", "test/cases/mesa/blocks.scene")],
    "parts.md": [("with 8000 × 8000 pixels and 31 wavelengths", "test/bench"), ("one render", "test/bench"), ("8 parts by", "test/bench")],
    "performance.md": [("", "test/bench")],
    "recipes.md": [("it is 20 pixels wide", "test/documents/recipes.py"), ("An HDF4 file holds at most 2 GB", "test/documents/recipes.py")],
    "scenes.md": [("A text file has at most 256 MB", constant("spectral.h", r"LONGEST_TEXT = (\d+)")),
                  ("at most 1000 files", limit("MOST_INCLUDES"))],
    "seeing.md": [("40 MB) is reduced", "test/raster/beside/view/stack_viewer.py"), ("is 0.8 MB smaller", "test/raster/beside/view/wasm.sh")],
    "stack.md": [("Stacks above 4 GiB are BigTIFF", "test/data/stack/parts.py")],
    "trust.md": [
        ("at most 740 lines of code", constant("test/program/house.py", r'"raster/reference": .*, (\d+)')),
        ("at most 1024 MiB beyond the 300", constant("data/text/options.c", r"usual_mib = (\d+)")),
        ("10^6 lines", "test/program/linear.py"), ("500 of them at 13,000 pixels take 5 s", "test/raster/check/hard.py"),
        ("rendered or read | 262,144 pixels", limit("LONGEST_SIDE")),
        ("sides of a texture | 16,384 texels", "test/data/images"), ("a text file; a mesh", constant("spectral.h", r"LONGEST_TEXT = (\d+)")),
        ("a line of text | 64 MB", constant("spectral.h", r"LONGEST_LINE = (\d+)")),
        ("in another | 1,000; 32 deep", limit("DEEPEST_INCLUDE"))],
    "verification.md": [
        ("apart, it could", 256), ("8 counts) to red", "test/make/gallery.py"), ("a floor above 256 counts", 256),
        ("at most 1 % of the pixels", "test/raster/check/verdict.py"),
        ("as long as they are at most 25 times as many", constant("data/stack/stack.h", r"EDGE_SHARES = (\d+)")),
        ("at 300 x 200 pixels and 31 wavelengths", "test/raster/beside/verify/verify.py"), (f"{HARD} small scenes", HARD),
        ("at half and at 99.9 %", "test/raster/beside/verify/verify.py"), ("within 1, 8 and 256 counts", 256),
        ("at most 200 lines of C", "test/program/reduced.py"), ("1 count wide", "test/raster/beside/verify/bounds.py"),
        ("up to 16 times as far off", "test/raster/beside/measure/traits.py")],
}


def sentences(page):
    """The lines of a page without its blocks, and without what stands between ` and `."""
    with open(page, encoding="utf-8") as file:
        text = re.sub(r"^```.*?^```", lambda match: re.sub(r"[^\n]", "", match.group()), file.read(), flags=re.M | re.S)
    return text.split("\n")


def number(text):
    return float(text.replace(",", ""))


used = set()
for page in ["README.md", *sorted(glob.glob("data/doc/*.md"))]:
    name, without = os.path.basename(page), []
    rows = SOURCES.get(name, [])
    lines = sentences(page)
    for at, line in enumerate(lines, 1):
        for figure in FIGURE.finditer(re.sub(r"`[^`]*`", lambda match: " " * len(match.group()), line)):
            near = [(words, source) for words, source in rows if words and words in line]
            near = near or [(words, source) for words, source in rows if not words]
            used.update((name, words) for words, _ in near)
            good = any(isinstance(source, str) and os.path.exists(source) for _, source in near) or \
                any(not isinstance(source, str) and source is not None and
                    any(number(n) == source for n in re.findall(r"\d[\d,]*\d|\d", line)) for _, source in near)
            if not good:
                without.append(f"{page}:{at}: {figure.group()}")
    check(not without, f"{page}: each figure has a source", *without)
spare = [(page, words) for page, rows in SOURCES.items() for words, _ in rows if (page, words) not in used]
check(not spare, "each row of the table is the source of a figure", *spare)
done()
