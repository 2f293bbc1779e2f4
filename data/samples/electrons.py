#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""electrons.py RAW.tif OUT.tif --full-well ELECTRONS --read ELECTRONS --seed N: turns raw values into the electrons of a sensor,
with shot noise and read noise, and says how much that is. --saturation VALUE is the raw value that fills the well (default: the
largest one); --bound VALUE is how far a raw value may be from that of the exact picture, to be compared with the noise.

RAW.tif has pages of floats: raw values of spectral develop --raw, or radiances of a stack of --depth 32f. A sample of OUT.tif is
a number of Poisson's distribution, whose mean is the value times the full well / VALUE, plus one of the normal distribution of
the read noise; it is rounded, and cut off at 0 and at the full well, so that black with read noise has a mean above 0. One seed
draws one picture. The pages keep their names. They have 16 bits, and full_scale / 65535 makes raw values of them again, so that
spectral reads such a file as it reads RAW.tif; a full well above 65535 calls for floats, which are electrons."""
import argparse
import html
import re
import sys

import numpy as np
import tifffile

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("raw", metavar="RAW.tif")
parser.add_argument("out", metavar="OUT.tif")
for name, kind in (("full-well", int), ("read", float), ("seed", int), ("saturation", float), ("bound", float)):
    parser.add_argument("--" + name, type=kind, required=name not in ("saturation", "bound"), metavar="N")
options = parser.parse_args()
well, read, bound = options.full_well, options.read, options.bound
try:
    with tifffile.TiffFile(options.raw) as file:
        values, names = np.array([page.asarray() for page in file.pages]), [page.tags[285].value for page in file.pages]
        facts = re.findall("^(?:raw values of|detector|exposure|unit): .*\n", html.unescape(file.pages[0].description), re.MULTILINE)
except (OSError, KeyError, ValueError, tifffile.TiffFileError) as why:
    sys.exit(f"electrons.py: {options.raw}: expected a TIFF file whose pages have names and one size: {why}")
if values.dtype != np.float32 or not (np.isfinite(values).all() and values.min() >= 0):
    sys.exit(f"electrons.py: {options.raw}: expected floats, none below 0; develop --raw writes them without --bits")
saturation = float(values.max()) if options.saturation is None else options.saturation
if not (0 < well <= 1 << 24 and 0 <= read <= well and options.seed >= 0 and 0 < saturation < np.inf and (bound is None or bound >= 0)):
    sys.exit("electrons.py: expected a full well from 1 to 16777216, a read noise from 0 to it, a seed and a bound of at least 0, "
             f"and a saturation above 0; the largest raw value is {values.max():g}")
mean, draw = values.astype(float) * (well / saturation), np.random.default_rng(options.seed)
electrons = np.rint(draw.poisson(np.minimum(mean, 1e9)) + draw.normal(0, read, mean.shape))  # 1e9 fills any well
kind, scale = (np.uint16, f"{65535 / well * saturation:.17g}\nscale: raw value = count x full_scale / 65535") if well < 65536 else (
    np.float32, "1\nscale: electrons = sample")
made = f"electrons: full well {well} at a raw value of {saturation:g}, read noise {read:g}, seed {options.seed}\n"
description = "".join(["full_scale: ", scale, "\n", *facts, made])
with tifffile.TiffWriter(options.out) as out:
    for i, (page, name) in enumerate(zip(electrons.clip(0, well).astype(kind), names)):
        out.write(page, metadata=None, contiguous=False, photometric="minisblack", description=None if i else description,
                  extratags=[(285, "s", 0, name, True)])
noise = np.sqrt(mean.mean() + read ** 2)
print(f"an electron is a raw value of {saturation / well:.4g}; {100 * (electrons >= well).mean():.3g} % of the samples fill the well, "
      f"{100 * (electrons < 0).mean():.3g} % were below 0")
print(f"noise {noise:.4g} electrons at the mean of {mean.mean():.4g}, {np.sqrt(mean.min() + read ** 2):.4g} in the darkest sample"
      + ("" if bound is None else f"; the bound of the raw value is {bound * well / saturation:.3g} electrons"))
