#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile python3-scipy python3-gdal gdal-bin octave python3-h5py python3-hdf4 python3-xarray python3-netcdf4 openexr imagemagick
"""Runs each block of data/doc/recipes.md as it stands, in the order of the page, and reads each result with a program
that did not write it. Radiance and wavelengths must be those that GDAL reads in the stack: to the last bit where a
format keeps doubles, else within the roundings that a comment derives. All is done twice: for the stack of the page,
and for one of 8 bits, with wavelengths that are no whole numbers. Prints TAP."""
import csv
import os
import re
import shutil
import struct
import sys

import numpy as np
import scipy.io
import tifffile
from osgeo import gdal

from documents import put_in_path, read, run
from rendered import TMP, check, done, table

gdal.UseExceptions()
BLOCK = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SECTION = re.compile(r"^## (.*?)$(.*?)(?=^## |\Z)", re.MULTILINE | re.DOTALL)
RUNS = {"sh": ["sh", "-e"], "python": [sys.executable], "octave": ["octave-cli", "--quiet", "--no-history"]}
OTHER_STACK = """
spectral render patches --size 50x30 --light 1=d65*2 --wavelengths 401.25:700:12.3 --depth 8 -o stack.tif --quiet
"""
X, Y = 15, 15  # the pixel that recipes print
REGION = np.s_[:, 8:20, 10:30]
UNIT = "W sr-1 m-2 nm-1 (relative)"
PLANCK, LIGHT = 6.626176e-34, 2.99792458e8  # ISETCam's vcConstants

BLOCKS = [(heading, *block) for heading, text in SECTION.findall(read("recipes.md")) for block in BLOCK.findall(text)]
D65 = table("data/builtin/tables/d65.csv", ",")


# ---- running the page ----

def run_page(name, other_stack):
    """Runs the blocks in a folder of their own; `other_stack`, unless empty, replaces the first. Returns what the blocks
    below each heading printed."""
    folder = os.path.join(TMP, name)
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    os.chdir(folder)
    printed = {}
    for number, (heading, language, file, code) in enumerate(BLOCKS, 1):
        file = file or f"block{number}.{language}"
        with open(file, "w", encoding="utf-8") as out:
            out.write(other_stack if other_stack and number == 1 else code)
        result = run(*RUNS[language], file)
        check(result.returncode == 0, f"{name}: {heading}: block {number} runs, {language}", result.stdout)
        printed.setdefault(heading, []).append(result.stdout)
    return printed


# ---- the stack, as GDAL reads it ----

class Stack:
    def __init__(self):
        pages = [gdal.Open(name) for name, _ in gdal.Open("stack.tif").GetSubDatasets()]
        self.counts = np.array([page.ReadAsArray() for page in pages])
        self.scale = pages[0].GetRasterBand(1).GetScale()
        self.nm = np.array([float(page.GetRasterBand(1).GetMetadataItem("wavelength")) for page in pages])
        self.radiance = self.counts * self.scale
        self.made = set(os.listdir("."))  # results that nobody has read yet

    def read(self, *files):
        self.made -= set(files)


def is_close(seen, expected, relative):
    seen, expected = np.asarray(seen, float), np.asarray(expected, float)
    return seen.shape == expected.shape and bool((np.abs(seen - expected) <= relative * np.abs(expected)).all())


def numbers(text):
    return np.array([line.split() for line in text.splitlines()], float)


def check_printed(stack, printed):
    """Spectra that recipes print at one pixel."""
    python, mapped, netcdf, envi = (numbers(printed[heading][number]) for heading, number in (
        ("Radiance from counts", 1), ("A stack mapped into memory", 0), ("NetCDF", 1), ("ENVI", 1)))
    spectrum = stack.radiance[:, Y, X]
    check(np.array_equal(python, np.column_stack([stack.nm, spectrum])), "Python: radiance")
    check(np.array_equal(envi, np.column_stack([stack.nm, spectrum])), "SPy, by an ENVI header: radiance")
    cube = np.array([line.split(",")[:2] for line in printed["ENVI"][3].splitlines()[1:]], float)
    check(np.array_equal(cube[:, 0], stack.nm) and is_close(cube[:, 1], stack.counts[:, Y, X] / 1000, 2**-22),  # floats of 24 bits
          "a stack that GDAL makes of SPy's cube: wavelengths and values", cube[:3])
    stack.read("stack.tif.hdr", "cube.hdr", "cube.img", "cube.tif")
    check(np.array_equal(mapped[0], stack.counts[:, Y, X]), "mapped into memory: counts")
    nearest = np.abs(stack.nm - 556).argmin()
    check(np.array_equal(netcdf[0], [stack.nm[nearest], spectrum[nearest]]), "xarray: page by wavelength")


def check_octave(stack):
    """Octave multiplies by the full scale of the description, which has 11 digits: it is within 5e-11 of the scale."""
    seen = scipy.io.loadmat("octave.mat", squeeze_me=True)
    check(np.array_equal(seen["wavelengths"], stack.nm), "Octave: wavelengths")
    check(is_close(np.moveaxis(seen["radiance"], 2, 0), stack.radiance, 5e-11), "Octave: radiance")
    stack.read("octave.mat")


def check_gdal_page(stack):
    """GDAL rounds the scale, and the product, to single precision: 2 x 2^-24."""
    with tifffile.TiffFile("page17.tif") as tiff:
        check(is_close(tiff.asarray(), stack.radiance[16], 2**-23) and tiff.asarray().max() > 0, "GDAL: radiance")
        check(f'name="wavelength" sample="0">{stack.nm[16]:.10g}<' in tiff.gdal_metadata, "GDAL: wavelength")
    stack.read("page17.tif")


def read_csv(path):
    with open(path, encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    return head, np.array(rows, float).T


def check_csv(stack):
    """The program rounds the scale and each product to single precision; means and deviations follow within as much."""
    nm, mean, _ = read_csv("pixel.csv")[1]
    check(np.array_equal(nm, stack.nm) and is_close(mean, stack.radiance[:, Y, X], 2**-23), "CSV of a pixel")
    nm, mean, deviation = read_csv("region.csv")[1]
    region = stack.radiance[REGION].reshape(len(stack.nm), -1)
    slack = 2**-23 * np.sqrt((region**2).mean(1))
    check(np.array_equal(nm, stack.nm) and is_close(mean, region.mean(1), 2**-23) and deviation.min() > 0
          and (np.abs(deviation - region.std(1)) <= slack).all(), "CSV of the mean of a region")
    head, (x, y, *spectra) = read_csv("pixels.csv")
    check(head[:2] == ["x", "y"] and np.array_equal(np.array(head[2:], float), stack.nm)
          and np.array_equal(spectra, stack.radiance[:, y.astype(int), x.astype(int)])
          and np.array_equal(spectra, region), "CSV of the pixels of a region")
    stack.read("pixel.csv", "region.csv", "pixels.csv")


def check_bands(stack):
    result = run("spectral", "compare", "stack.tif", "bands.tif", "--white", "1")
    check(result.returncode == 0, "bands in one page: spectral reads the same stack", result.stdout)
    with tifffile.TiffFile("bands.tif") as tiff:
        counts, metadata = tiff.asarray(), tiff.gdal_metadata
    counts = counts if counts.shape == stack.counts.shape else np.moveaxis(counts, 2, 0)
    check(np.array_equal(counts, stack.counts), "bands in one page: tifffile reads the counts")
    for item, expected in (('name="wavelength"', stack.nm), ('name="CENTRAL_WAVELENGTH_UM"', stack.nm / 1000),
                           ('name="SCALE"', np.full(len(stack.nm), stack.scale))):
        seen = [float(value) for value in re.findall(item + r"[^>]*>([^<]*)<", metadata)]
        check(is_close(seen, expected, 1e-9 if "UM" in item else 0), f"bands in one page: {item} of each band")
    stack.read("bands.tif")


def check_arrays(stack):
    """GDAL's multidimensional readers of three formats."""
    for path in "stack.h5", "stack.hdf", "stack.nc":
        root = gdal.OpenEx(path, gdal.OF_MULTIDIM_RASTER).GetRootGroup()
        group = root.OpenGroup("scientific_datasets") if path == "stack.hdf" else root
        radiance = group.OpenMDArray("radiance")
        check(np.array_equal(radiance.ReadAsArray(), stack.radiance) and radiance.GetUnit() == UNIT, f"{path}: radiance")
        first = radiance.GetDimensions()[0]
        nm = first.GetIndexingVariable()
        check(first.GetName() == "wavelength" and np.array_equal(nm.ReadAsArray(), stack.nm), f"{path}: wavelengths")
        check(nm.GetUnit() == "nm", f"{path}: wavelengths are in nm")
        texts = [each.ReadAsString() for holder in (root, radiance) for each in holder.GetAttributes()]
        if path == "stack.hdf":
            texts = gdal.Open(path).GetMetadata().values()
        check(any("full_scale: " in text and "white: " in text for text in texts), f"{path}: the record")
        stack.read(path)


def check_hdf5_in_octave(stack):
    result = run(*RUNS["octave"], "--eval", 'load stack.h5; printf("%.17g ", wavelength, radiance(16, 16, :));')
    seen = np.array(re.findall(r"[-+.e\d]+(?= )", result.stdout), float)
    check(np.array_equal(seen, np.append(stack.nm, stack.radiance[:, Y, X])), "stack.h5: Octave loads it", result.stdout)


# ---- OpenEXR ----

def read_tile(path, bands, height, width):
    """Samples [channel, y, x] of a file of OpenEXR's with one tile, floats without compression."""
    with open(path, "rb") as file:
        data = file.read()
    at = 8
    while data[at]:  # attributes: name, type, size, value
        at = data.index(b"\0", data.index(b"\0", at) + 1) + 1
        at += 4 + struct.unpack_from("<i", data, at)[0]
    place, = struct.unpack_from("<Q", data, at + 1)
    *tile, size = struct.unpack_from("<5i", data, place)
    assert tile == [0, 0, 0, 0] and size == 4 * bands * height * width, "one tile of all samples"
    lines = np.frombuffer(data, "<f4", size // 4, place + 20)
    return lines.reshape(height, bands, width).swapaxes(0, 1)


def check_exr(stack):
    """OpenEXR's own tools read the file; one of them writes what it has read as one tile. Names keep six decimals."""
    header = run("exrheader", "stack.exr").stdout
    names = re.findall(r"^    S0[.](\d+,\d{6})nm, 32-bit floating-point, sampling 1 1$", header, re.MULTILINE)
    nm = np.array([float(name.replace(",", ".")) for name in names])
    check(len(nm) == len(stack.nm) and np.abs(nm - stack.nm).max() <= 5e-7, "OpenEXR: a channel for each wavelength", header)
    check('spectralLayoutVersion (type string): "1.0"' in header
          and 'emissiveUnits (type string): "W.m^-2.sr^-1"' in header, "OpenEXR: attributes of the layout", header)
    result = run("exrmaketiled", "-o", "-t", "512", "512", "-z", "none", "stack.exr", "tile.exr")
    check(result.returncode == 0, "OpenEXR: the library reads all lines", result.stdout)
    seen = read_tile("tile.exr", *stack.radiance.shape)
    check(np.array_equal(seen, stack.radiance.astype("f4")), "OpenEXR: radiance, rounded to single precision")
    stack.read("stack.exr")


# ---- ISETCam ----

ISETCAM_RULES = """
names = {whos("-file", "stack.mat").name};
printf("%d ", ismember({"mcCOEF", "photons", "wave", "comment", "illuminant"}, names));
load("stack.mat");
printf("%d ", isfield(illuminant, {"data", "wavelength", "type"}), size(photons), numel(wave), ischar(comment));
file = fopen("photons.raw", "w");
fwrite(file, [wave(:); illuminant.wavelength(:); illuminant.data(:); photons(:)], "double");
fclose(file);
"""


def check_isetcam(stack, intensity):
    """Octave loads the variables that ISETCam's loader asks for: photons, and neither coefficients nor a modern illuminant,
    which has a type. ISETCam turns photons into energy by h c / wavelength; that rounds five times."""
    result = run(*RUNS["octave"], "--eval", ISETCAM_RULES)
    bands, height, width = stack.radiance.shape
    expected = [0, 1, 1, 1, 1, 1, 1, 0, height, width, bands, bands, 1]
    check([int(word) for word in re.findall(r"\d+(?= )", result.stdout)] == expected, "ISETCam: variables", result.stdout)
    values = np.fromfile("photons.raw")
    nm, light_nm, light = values[:3 * bands].reshape(3, bands)
    photons = values[3 * bands:].reshape(bands, width, height).swapaxes(1, 2)
    energy = photons * (PLANCK * LIGHT) / (stack.nm[:, None, None] * 1e-9)
    check(np.array_equal(nm, stack.nm) and np.array_equal(light_nm, stack.nm), "ISETCam: wavelengths")
    check(is_close(energy, stack.radiance, 5 * 2**-53), "ISETCam: energy equals radiance")
    check(is_close(light, np.interp(stack.nm, *D65) * intensity, 5e-6), "ISETCam: the illuminant is D65, in 6 digits")
    stack.read("stack.mat")


def main():
    put_in_path()
    home = os.getcwd()
    for name, other_stack in (("16 bits", ""), ("8 bits", OTHER_STACK)):
        printed = run_page(name, other_stack)
        stack = Stack()
        stack.read("stack.tif", "stack.py", "__pycache__", *(file for file in stack.made if file.startswith("block")))
        check_printed(stack, printed)
        for check_results in (check_octave, check_gdal_page, check_csv, check_bands, check_arrays,
                              check_hdf5_in_octave, check_exr):
            check_results(stack)
        check_isetcam(stack, 2 if other_stack else 1)
        check(not stack.made, "this test reads all files that the recipes make", *stack.made)
        os.chdir(home)
    done()


main()
