#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""within.py STACK.tif BOUNDS.tif: is each sample of a stack of 16 bits within the legal counts, which
spectral render --bounds or spectral export writes? Prints the pixels that are not, and ends with 1."""
import sys

import numpy as np
import tifffile

stack, bounds = (pages.reshape(-1, *pages.shape[-2:]) for pages in map(tifffile.imread, sys.argv[1:]))
with tifffile.TiffFile(sys.argv[2]) as file:
    names = [page.tags[285].value for page in file.pages]
low, high = bounds[::2], bounds[1::2]
if stack.dtype != np.uint16 or stack.shape != low.shape:
    sys.exit(f"expected {low.shape} counts of 16 bits, found {stack.shape} of {stack.dtype}")
outside = (stack < low) | (stack > high)
for band, y, x in np.argwhere(outside)[:20]:
    print(f"{x},{y} at {names[2 * band][:-4]}: {stack[band, y, x]}, legal {low[band, y, x]} to {high[band, y, x]}")
print(f"{outside.any(axis=0).sum()} of {outside[0].size} pixels are outside; nothing bounds "
      f"{((low == 0) & (high == 65535)).any(axis=0).sum()}")
sys.exit(bool(outside.any()))
