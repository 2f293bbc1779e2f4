#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sheet.py STACK... -o SHEET.png [--columns N] [OPTIONS of spectral develop]: develops stacks side by side, each above its name.

A name is that of the stack's file; NAME=STACK gives another one. SHEET.tif is a TIFF. All options behind the stacks are those of
spectral develop, and hold for all: detector, white, adaptation, display, bits. The pixels are those that develop writes, with its
profile. So that the pictures can be compared, they have one exposure: of --exposure auto the least of all, by which nothing is
brighter than the display in any. Stacks have one size."""
import json
import os
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np
import tifffile
from PIL import Image, ImageDraw, ImageFont

FONT = "DejaVuSans.ttf"  # of Debian's fonts-dejavu-core; without it, Pillow's own


def fail(why, status=2):
    print(f"sheet.py: {why}", file=sys.stderr)
    sys.exit(status)


def read_words(words):
    """Returns [(name, path)] of the stacks, the sheet's path, its number of columns (0: not given), and develop's options."""
    first = next((i for i, word in enumerate(words) if word.startswith("-")), len(words))
    own, options, rest = {"-o": "", "--columns": "0"}, [], iter(words[first:])
    for word in rest:
        if word in own:
            own[word] = next(rest, "")
        else:
            options.append(word)
    if first == 0 or os.path.splitext(own["-o"])[1] not in (".png", ".tif", ".tiff") or not own["--columns"].isdecimal():
        sys.exit(__doc__)
    named = [("", word) if os.path.exists(word) else word.rpartition("=")[::2] for word in words[:first]]
    return ([(name or os.path.splitext(os.path.basename(path))[0], path) for name, path in named], own["-o"], int(own["--columns"]),
            options)


def develop(path, options, folder):
    """Returns the picture of a stack, its profile, its description and its exposure."""
    out = os.path.join(folder, "picture.tif")
    result = subprocess.run(["spectral", "develop", path, *options, "-o", out, "--json", "-", "--quiet"],
                            capture_output=True, text=True, check=False)
    if result.returncode:
        fail(result.stderr.strip(), result.returncode)
    with tifffile.TiffFile(out) as file:
        page = file.pages[0]
        if len(file.pages) != 1:
            fail("a sheet is RGB; develop --xyz, --lab and --raw take one stack")
        return page.asarray(), page.tags[34675].value, page.description, json.loads(result.stdout)["exposure"]


def develop_all(paths, options, folder):
    """Returns the same of all stacks, as four lists."""
    pictures, *others = zip(*(develop(path, options, folder) for path in paths))
    for path, picture in zip(paths, pictures):
        if picture.shape != pictures[0].shape:
            fail(f"{path}: {picture.shape[1]} x {picture.shape[0]} pixels, but {paths[0]} has {pictures[0].shape[1]} x {pictures[0].shape[0]}")
    return pictures, *others


def font_of(height):
    """Pillow's own font has sizes from version 10.1 on."""
    for make in lambda: ImageFont.truetype(FONT, height), lambda: ImageFont.load_default(height):
        try:
            return make()
        except (OSError, TypeError):
            pass
    return ImageFont.load_default()


def draw_name(name, width, height):
    """Returns a name as an area of ink, 0 to 1: as high as wanted, and narrower if it is too long."""
    font = font_of(4 * height)
    if not isinstance(font, ImageFont.FreeTypeFont):
        name = name.encode("latin-1", "replace").decode("latin-1")
    area = Image.new("L", (max(1, font.getbbox(name)[2]), font.getbbox("|g")[3]))
    ImageDraw.Draw(area).text((0, 0), name, 255, font)
    shrunk = min(height / area.height, width / area.width)
    return np.asarray(area.resize([max(1, round(side * shrunk)) for side in area.size], Image.LANCZOS)) / 255


def lay_out(pictures, names, columns):
    """Puts pictures into rows, above their names, with white around them."""
    height, width, _ = pictures[0].shape
    columns, letters = min(columns or -(-len(names) // int(len(names) ** 0.5)), len(names)), max(11, width // 18)
    margin, white = letters // 2, np.iinfo(pictures[0].dtype).max
    across, down = width + 2 * margin, height + 3 * margin + letters
    sheet = np.full((-(-len(names) // columns) * down, columns * across, 3), white, pictures[0].dtype)
    for i, (picture, name) in enumerate(zip(pictures, names)):
        cell = sheet[i // columns * down:, i % columns * across:]
        cell[margin:margin + height, margin:margin + width] = picture
        ink = draw_name(name, width, letters)
        left = (across - ink.shape[1]) // 2
        cell[2 * margin + height:][:ink.shape[0], left:left + ink.shape[1]] = np.rint(white * (1 - ink))[..., None]
    return sheet


def write_png(path, pixels, profile, description):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    height, width, _ = pixels.shape
    rows = np.ascontiguousarray(pixels, pixels.dtype.newbyteorder(">")).view(np.uint8).reshape(height, -1)
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8 * pixels.itemsize, 2, 0, 0, 0)) +
                  chunk(b"iCCP", b"display\0\0" + zlib.compress(profile)) + chunk(b"tEXt", b"Description\0" + description.encode("latin-1")) +
                  chunk(b"IDAT", zlib.compress(np.insert(rows, 0, 0, 1).tobytes())) + chunk(b"IEND", b""))


def write(path, pixels, profile, description):
    """Writes the sheet, whole or not at all."""
    with tempfile.TemporaryDirectory(dir=os.path.dirname(path) or ".", prefix=".sheet-") as folder:
        whole = os.path.join(folder, os.path.basename(path))
        if path.endswith(".png"):
            write_png(whole, pixels, profile, description)
        else:
            tifffile.imwrite(whole, pixels, photometric="rgb", description=description, metadata=None,
                             extratags=[(34675, 7, len(profile), profile, True)])
        os.replace(whole, path)


def main():
    stacks, sheet, columns, options = read_words(sys.argv[1:])
    names, paths = zip(*stacks)
    if os.path.exists(sheet) and any(os.path.exists(path) and os.path.samefile(path, sheet) for path in paths):
        fail(f"{sheet} would replace an input; expected another file")
    with tempfile.TemporaryDirectory(prefix="sheet-") as folder:
        pictures, profiles, descriptions, exposures = develop_all(paths, options, folder)
        if min(exposures) < max(exposures):
            pictures, profiles, descriptions, _ = develop_all(paths, [*options, "--exposure", repr(min(exposures))], folder)
    write(sheet, lay_out(pictures, names, columns), profiles[0], "".join(descriptions))
    print(f"sheet             {sheet}, {len(names)} pictures, exposure {min(exposures):.10g}")


if __name__ == "__main__":
    try:
        main()
    except OSError as system:
        fail(system, 3)
