#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Writes inputs for test/fuzz to begin with: the blocks of the pages for users, and the records of the stacks that lie there. Pictures of
other programs, in all compressions and layouts, are among the kept inputs.

    test/fuzz/fuzz_seeds.py FOLDER"""
import glob
import os
import re
import sys

import tifffile


def blocks(folder):
    """The blocks of README and data/doc that are files of some kind."""
    for page_path in ["README.md", *sorted(glob.glob("data/doc/*.md"))]:
        with open(page_path, encoding="utf-8") as file:
            found = re.findall(r"^```(scene|csv|mtl|map)\b[^\n]*\n(.*?)^```", file.read(), re.MULTILINE | re.DOTALL)
        for i, (kind, text) in enumerate(found):
            with open(f"{folder}/{os.path.basename(page_path)[:-3]}-{i}.{kind}", "w", encoding="utf-8") as file:
                file.write(text)
    with open(f"{folder}/entries.mtl", "w", encoding="utf-8") as file:
        file.write("newmtl a\nKa 0 0 0\nKd 0.8 0.5 0.1\nKs 0.1 0.2 0.3\nKe 0 0 0.5\nNs 20\nillum 2\nnewmtl b\nKd 1 1 1\n")
    with open(f"{folder}/parts.map", "w", encoding="utf-8") as file:
        file.write('# parts\na material a\n"b c" mtl maps/mtl-entry-twice.mtl\n* material b\n')


def records(folder):
    """The descriptions of the stacks in the folder, which hold their records; '-' before those without wavelengths."""
    for stack in glob.glob(f"{folder}/stack-*.tif"):
        with tifffile.TiffFile(stack) as tiff:
            text = tiff.pages[0].description
        mark = "-" if "components: yes" in text else "+"
        with open(stack.replace("/stack-", "/record-").replace(".tif", ""), "w", encoding="utf-8") as file:
            file.write(mark + text)


blocks(sys.argv[1])
records(sys.argv[1])
