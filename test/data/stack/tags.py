#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""The tags of a stack record its wavelengths for each reader in that reader's own way, and its pages lie where a program that maps the file
expects them. effects.py has the samples and the map of objects, parts.py compares bytes. Prints TAP."""
import re
import xml.etree.ElementTree as tree

import numpy as np
import tifffile

from rendered import check, done, reference, write

OME = "{http://www.openmicroscopy.org/Schemas/OME/2016-06}"
NM = [300, 305, 452.5, 760]
SCENE = "size 7 5\nlight d65 1 direction 1 2 3\nmaterial m { diffuse 0.5 }\nobject sphere 5 12 8 material m\n" \
    "material n { diffuse gaussian:500,50 }\nobject plane 9 9 material n translate 0 0 -4\n"
ONE_NM = "--wavelengths", "555", "--depth", "32f"


def holds(name, truth, *remarks):
    check(truth, f"{KIND}: {name}", *remarks)


def layout(tiff, path):
    offsets, sizes = (np.array([getattr(page, name)[0] for page in tiff.pages]) for name in ("dataoffsets", "databytecounts"))
    with open(path, "rb") as file:
        content = file.read()
    at, size = map(int, re.search(r"\nobject_map: (\d+) (\d)\n", tiff.pages[0].description).groups())
    holds("the file is a classic little-endian TIFF", content[:4] == b"II*\0")
    holds("the pixels begin at a multiple of 4 bytes, and pages follow each other without gaps",
          offsets[0] % 4 == 0 and (np.diff(offsets) == sizes[:-1]).all(), offsets, sizes)
    holds("behind the last pixel there is only the map of objects", at == offsets[-1] + sizes[-1] and len(content) == at + 35 * size, at, len(content))


def first_page(tiff, labels, has_nm):
    page = tiff.pages[0]
    root = tree.fromstring(page.description)
    channels = list(root.iter(OME + "Channel"))
    pixels = next(root.iter(OME + "Pixels"))
    holds("OME-XML has the kind of the samples, and a channel for each page",
          pixels.get("Type") == {"uint16": "uint16", "uint8": "uint8", "float32": "float"}[str(page.dtype)] and
          pixels.get("SizeC") == str(len(tiff.pages)), pixels.attrib)
    holds("a channel has its label and its wavelength, or none", [(one.get("Name"), one.get("EmissionWavelength")) for one in channels] ==
          [(label, label.removesuffix(" nm") if has_nm else None) for label in labels], [one.attrib for one in channels])
    holds("the scene's name is in it, whatever its characters", any(one.get("Name", "").endswith('a<b>&"c".scene') for one in root.iter()),
          page.description[:400])
    holds("so are the full scale and the renderer", re.search(r"<Description>full_scale: \S+\n", page.description) and
          "\nrenderer: raster\n" in page.description)
    holds("the software has its name, and 65111 the verdict", page.tags["Software"].value.startswith("spectral ") and page.tags[65111].value.strip())
    holds("65000 has all wavelengths, or is not there", np.allclose(page.tags[65000].value, NM[:len(tiff.pages)] if len(labels) > 1 else 555, rtol=1e-7)
          if has_nm else 65000 not in page.tags)
    holds("ImageJ's labels are those of the channels", np.atleast_1d(page.tags[50839].value["Labels"]).tolist() == labels)
    holds("tifffile takes the pages for one stack", len(tiff.series) == 1 and tiff.series[0].shape[-2:] == (5, 7), tiff.series)


def later_page(tiff, full_scale):
    page = tiff.pages[2].aspage()
    tags = page.tags
    holds("page 2 has its wavelength as description, and as name", page.description == "wavelength_nm=452.5" and tags["PageName"].value == "452.5 nm")
    holds("it is page 2 of 4, one of several, and has no orientation", tags["PageNumber"].value == (2, 4) and
          tags["NewSubfileType"].value == 2 and 274 not in tags)
    for what, words in (("wavelength in micrometres", 'name="CENTRAL_WAVELENGTH_UM" sample="0" domain="IMAGERY">0.4525<'),
                        ("spacing, half of 760 - 305, as its width", ">0.2275<")):
        holds(f"GDAL's metadata have its {what}", words in tags[42112].value, tags[42112].value)
    scale = float(re.search(r'role="scale">([^<]*)<', tags[42112].value)[1])
    holds("and the radiance of a count", scale == full_scale / np.iinfo(page.dtype).max, scale, full_scale)


ALL_NM = "--full-scale", "2.5", "--wavelengths", ",".join(map(str, NM))
for KIND, LABELS, OPTIONS in (
        ("counts", [f"{nm:g} nm" for nm in NM], ALL_NM), ("bytes", [f"{nm:g} nm" for nm in NM], (*ALL_NM, "--depth", "8")),
        ("components", ["component 1", "component 2"], ("--sampling", "basis:2")), ("one page of floats", ["555 nm"], ONE_NM)):
    PATH = reference("tags.tif", write('a<b>&"c".scene', SCENE), *OPTIONS)
    with tifffile.TiffFile(PATH) as TIFF:
        layout(TIFF, PATH)
        first_page(TIFF, LABELS, KIND != "components")
        if len(LABELS) > 2:
            later_page(TIFF, 2.5)
        if OPTIONS == ONE_NM:
            holds("GDAL's metadata have no width, and scale 1", "FWHM" not in TIFF.pages[0].tags[42112].value and
                  'role="scale">1<' in TIFF.pages[0].tags[42112].value)
done()
