#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Writes inputs for test/fuzz to begin with: the blocks of the pages for users, and the records of the stacks that lie there. Pictures of
other programs, in all compressions and layouts, are among the kept inputs.

    test/fuzz/fuzz_seeds.py FOLDER"""
import glob
import os
import re
import struct
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


def sgi(folder):
    """Textures of SGI, as they stand and in runs: of grey and RGB, of 8 and 16 bits."""
    for name, packed, size, channels in ("grey", 0, 1, 1), ("rgb", 0, 1, 3), ("wide", 0, 2, 3), ("runs", 1, 1, 1), ("wide-runs", 1, 2, 3):
        width, height = 5, 3
        head = struct.pack(">HBBHHHHII", 474, packed, size, 3, width, height, channels, 0, 255 ** size).ljust(512, b"\0")
        number = ">H" if size == 2 else ">B"
        run = b"".join(struct.pack(number, value) for value in (128 | 2, 7, 9, 3, 200, 0))  # two samples, one three times, the end
        rows = height * channels
        start = 512 + 8 * rows
        tables = struct.pack(f">{rows}I", *(start + i * len(run) for i in range(rows))) + struct.pack(f">{rows}I", *[len(run)] * rows)
        with open(f"{folder}/{name}.sgi", "wb") as file:
            file.write(head + (tables + rows * run if packed else bytes(range(width * size)) * rows))


def pngs(folder):
    """Filtered rows of PNG files, behind four bytes of their header: see fuzz_png."""
    for colour, channels in (0, 1), (2, 3), (4, 2), (6, 4):
        for size in 1, 2:
            with open(f"{folder}/png-{colour}-{size}", "wb") as file:
                file.write(bytes((3, 6, 8 * size, colour)) + b"".join(bytes([y % 5, *range(3 * channels * size)]) for y in range(6)))


def sets(folder):
    """Measured sets: CGATS with and without names of fields, a sample a row, IES TM-27."""
    texts = {
        "named": "CTI3\n\nDEVICE_CLASS \"OUTPUT\"\nSPECTRAL_BANDS \"3\"\nSPECTRAL_START_NM \"400.0\"\nSPECTRAL_END_NM \"600.0\"\n"
                 "SPECTRAL_NORM \"100.0\"\nNUMBER_OF_FIELDS 5\nBEGIN_DATA_FORMAT\nSAMPLE_ID SAMPLE_NAME SPEC_400 SPEC_500 SPEC_600\n"
                 "END_DATA_FORMAT\nNUMBER_OF_SETS 2\nBEGIN_DATA\n1 \"a b\" 10 20 30\n2 c 1.5 2,5 99\nEND_DATA\n",
        "unnamed": "CGATS.17\nSPECTRAL_BANDS 3\nSPECTRAL_START_NM 400\nSPECTRAL_END_NM 700\nBEGIN_DATA\n0.1 0.2 0.3\nEND_DATA\n",
        "tabs": "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME\tnm400\tnm500\nEND_DATA_FORMAT\nBEGIN_DATA\nlight skin\t0.1\t0.2\nEND_DATA\n",
        "rows": "name;400;500;600\nred;0,1;0,2;0,3\nblue;0,3;0,2;0,1\n",
        "tm27": '<?xml version="1.0"?>\n<IESTM2714><SpectralDistribution>\n<SpectralData wavelength="400">0.5</SpectralData>\n'
                '<SpectralData wavelength="500.5">1e-3</SpectralData></SpectralDistribution></IESTM2714>\n',
    }
    for name, text in texts.items():
        with open(f"{folder}/{name}.ti3", "w", encoding="utf-8") as file:
            file.write(text)


blocks(sys.argv[1])
sgi(sys.argv[1])
pngs(sys.argv[1])
sets(sys.argv[1])
records(sys.argv[1])
