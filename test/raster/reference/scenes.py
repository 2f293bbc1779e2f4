# SPDX-License-Identifier: MIT
"""Writes the scenes of random_scenes.py for test_reference.c into the given folder, as 1.scene and so on, with spectral
textures that are linear and without grey ones: slow.h knows no others."""
import os
import re
import sys

sys.path += ["test/shared", "test/raster/check"]
import random_scenes

FOLDER, COUNT, SIZE = sys.argv[1], int(sys.argv[2]), (int(sys.argv[3]), int(sys.argv[4]))
os.makedirs(FOLDER, exist_ok=True)
random_scenes.write_textures(FOLDER)
for seed in range(1, COUNT + 1):
    files = {end: re.sub(r" texture \S+( nearest| linear| bilinear)?|^t \S+$", "", re.sub(
        r"(spectral-texture \S+)( nearest| linear| bilinear)?", r"\1 bilinear", text), flags=re.MULTILINE)
        for end, text in random_scenes.scene(seed, SIZE).items()}
    random_scenes.put(files, FOLDER, str(seed))
