#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile python3-pil
"""Computes compare's output for two stacks once more with numpy, pixel by pixel, from published formulas; some
differences have closed forms. Prints TAP."""
import json
import os
import re

import numpy as np
import tifffile
from osgeo import gdal

from colours import cie94, cielab, ciede2000
from rendered import (built_in, check, done, output_of, pages_of, path_of, reference, refuses, response_of, run, weights, write,
                      write_stack)

gdal.UseExceptions()
NUMBER = r"([-+.e\d]+)"
SIX_DIGITS = 6e-6  # relative: printed numbers
FLOAT = 1e-7       # relative: values of the map


# ---- comparison with numpy ----

def angles(a, b):
    """Spectral angle in degrees, from half-angles of unit vectors (Kahan)."""
    a, b = a / np.sqrt((a * a).sum(0)), b / np.sqrt((b * b).sum(0))
    return np.degrees(2 * np.arctan2(np.sqrt(((a - b) ** 2).sum(0)), np.sqrt(((a + b) ** 2).sum(0))))


# ---- stacks and the program ----

def stack(name, pixels, nm, **options):
    return write_stack(name, np.asarray(pixels, np.float32), nm, **options)


def compare(*words, **options):
    return run("compare", "-v", *words, **options)


class Printed:
    """Numbers that compare -v printed: a line for each quantity, then a table of bands."""

    def __init__(self, text):
        rows = re.findall(rf"^{NUMBER} +{NUMBER} +(\d+),(\d+) +{NUMBER}$", text, re.M)
        self.bands = np.array(rows, float)
        largest = re.search(rf"^largest  .*? {NUMBER} W.* at {NUMBER} nm, at pixel (\d+),(\d+)$", text, re.M)
        self.largest = np.array(largest.groups(), float) if largest else None
        self.rms = float(re.search(rf"^RMS +{NUMBER}", text, re.M).group(1))
        self.angle = self.pixels("spectral angle", text)
        self.cie76, self.cie94, self.ciede2000 = (self.pixels(name, text)
                                                  for name in ("CIE76", "CIE94", "CIEDE2000"))

    @staticmethod
    def pixels(name, text):
        found = re.search(rf"^{name} +{NUMBER} \(mean\), {NUMBER} \(95th percentile\), {NUMBER} "
                          r"\(largest, at pixel (none|\d+,\d+)\)$", text, re.M)
        return [float(group) for group in found.groups()[:3]] + [found.group(4)] if found else None


def near(seen, expected, relative=SIX_DIGITS):
    return np.allclose(seen, expected, rtol=relative, atol=1e-30)


# ---- closed forms ----

def test_same():
    result = compare(A, A, "--white", "d65")
    printed = Printed(result.stdout)
    check(result.returncode == 0, "a stack equals itself", result.stderr)
    check(printed.largest is None and printed.rms == 0 and printed.angle == [0, 0, 0, "none"]
          and printed.ciede2000 == [0, 0, 0, "none"], "every statistic of equal stacks is 0", result.stdout)


def test_one_pixel():
    changed = PIXELS.copy()
    changed[3, 7, 5] += np.float32(0.125)
    step = float(changed[3, 7, 5]) - float(PIXELS[3, 7, 5])
    other = stack("one-pixel.tif", changed, NM)
    result = compare(A, other, "--white", "d65")
    printed = Printed(result.stdout)
    check(result.returncode == 1 and len(result.stderr.splitlines()) == 1,
          "one sample that differs makes exit 1, and one line says so", result.stderr)
    check(near(printed.largest, [step, NM[3], 5, 7]), "the line gives its wavelength, pixel and value", result.stdout)
    check(len(printed.bands) == 1 and near(printed.bands[0], [NM[3], step, 5, 7, step / np.sqrt(W * H)]),
          "no other wavelength is listed")
    check(printed.angle[1] == 0 < printed.angle[2] and printed.angle[3] == "5,7" and printed.ciede2000[3] == "5,7",
          "angle and CIEDE2000 are largest there, and 0 at 95 % of the pixels", printed.angle, printed.ciede2000)
    percent = 100 * step / float(PIXELS.max())
    for tolerance, status in ((f"{step:.17g}", 0), (f"{step * 0.999:.9g}", 1), (f"{percent * 1.001:.9g}%", 0),
                              (f"{percent * 0.999:.9g}%", 1), (f"{printed.ciede2000[2] * 1.001:.9g}dE00", 0),
                              (f"{printed.ciede2000[2] * 0.999:.9g}dE00", 1), (f"{printed.cie94[2] * 1.001:.9g}dE94",
                                                                               0),
                              (f"{printed.cie94[2] * 0.999:.9g}dE94", 1), (f"{printed.cie76[2] * 1.001:.9g}dE76", 0),
                              (f"{printed.cie76[2] * 0.999:.9g}dE76", 1)):
        result = compare(A, other, "--white", "d65", "--tolerance", tolerance)
        check(result.returncode == status, f"a tolerance of {tolerance} makes exit {status}", result.stderr)


def test_angles():
    printed = Printed(compare(A, stack("twice.tif", 2 * PIXELS, NM)).stdout)
    check(printed.angle == [0, 0, 0, "none"], "twice the radiance everywhere gives spectral angles of 0")
    nm = [500, 600]
    rows = (([1, 0], [0, 1], 90), ([0, 0], [0, 0], 0), ([0, 0], [0.5, 0], 90), ([1, 1], [0, 3], 45),
            ([3, 4], [4, 3], np.degrees(np.arctan2(7, 24))))
    for a, b, expected in rows:
        one, two = (stack(f"{n}.tif", np.reshape(p, (2, 1, 1)), nm) for n, p in (("one", a), ("two", b)))
        printed = Printed(compare(one, two).stdout)
        check(near(printed.angle[2], expected), f"{a} and {b}: {expected:.6g} degrees", printed.angle)
    step = 2.0 ** -23
    one, two = stack("flat.tif", np.ones((2, 1, 1)), nm), stack("tilted.tif", [[[1]], [[1 + step]]], nm)
    printed = Printed(compare(one, two).stdout)
    check(near(printed.angle[2], np.degrees(np.arctan(step / (2 + step)))),
          "the angle of a single bit of a float has 6 digits, where an arc cosine would have none", printed.angle)


# ---- random stacks, compared with numpy ----

def test_statistics(name, a_pixels, b_pixels, nm, observer):
    a, b = stack(name + "-a.tif", a_pixels, nm), stack(name + "-b.tif", b_pixels, nm, compression="zlib")
    out = path_of(name + "-map.tif")
    result = compare(a, b, "--white", "a", "--detector", observer, "--map", out)
    printed, seen = Printed(result.stdout), pages_of(out)
    a, b = a_pixels.astype(np.float64), b_pixels.astype(np.float64)
    difference = abs(a - b)
    flat = difference.reshape(len(nm), -1)
    at = flat.argmax(1)
    expected = np.array([nm, flat.max(1), at % a.shape[2], at // a.shape[2], np.sqrt((flat ** 2).mean(1))]).T
    check(result.returncode == 1 and near(printed.bands, expected),
          f"{name}: each wavelength has the right largest difference, pixel and RMS")
    check(near(printed.largest, expected[flat.max(1).argmax()][[1, 0, 2, 3]]) and
          near(printed.rms, np.sqrt((flat ** 2).mean())),
          f"{name}: the largest difference and the RMS of all are right", printed.largest, printed.rms)
    of = weights(observer, np.array(nm, float))
    white = of @ np.interp(nm, *built_in("a"), 0, 0)
    labs = [cielab(of @ pixels.reshape(len(nm), -1), white[:, None]).reshape(3, *a.shape[1:])
            for pixels in (a, b)]
    pictures = difference.max(0), angles(a, b), ciede2000(*labs)
    not_in_map = np.linalg.norm(labs[0] - labs[1], axis=0), cie94(*labs)
    for values, statistics, row, what in zip(
            pictures[1:] + not_in_map, (printed.angle, printed.ciede2000, printed.cie76, printed.cie94),
            (*seen[1:], *not_in_map), ("spectral angles", "CIEDE2000", "CIE76", "CIE94")):
        most = values.max()
        quantile = np.quantile(values, 0.95, method="inverted_cdf")
        y, x = np.unravel_index(values.argmax(), values.shape)
        check(near(statistics[0], values.mean(), 1e-5) and near(statistics[2], most, 1e-5) and
              statistics[3] == f"{x},{y}", f"{name}: mean, largest value and pixel of {what} are right", statistics)
        check(quantile * (1 - 1e-5) <= statistics[1] <= quantile * (1 + 1 / 1024 + 1e-5),
              f"{name}: the 95th percentile of {what} is at most 1/1024 too high", statistics[1], quantile)
        check(abs(row - values).max() <= 1e-6 * most, f"{name}: the map holds {what} pixel by pixel",
              abs(row - values).max())
    check(abs(seen[0] - pictures[0]).max() <= FLOAT * pictures[0].max(),
          f"{name}: the map holds the largest difference of all wavelengths")


def test_threads(a, b):
    for ending in ".tif", ".png":
        outputs = []
        for threads in "1", "2", "7":
            result = compare(a, b, "--white", "d65", "--threads", threads, "--map", path_of("threads" + ending))
            outputs.append((result.stdout, open(path_of("threads" + ending), "rb").read()))
        check(outputs[0] == outputs[1] == outputs[2], f"text and {ending[1:]} do not depend on the number of threads")


# ---- a map in colours ----

def steps(values, least):
    """0 of 0, otherwise the number of the first power of two that holds the value, up to 14."""
    with np.errstate(divide="ignore"):
        return np.where(values == 0, 0, np.clip(np.ceil(np.log2(values / least)), 0, 13) + 1)


def test_colours(what, b, page, least, *options):
    """The colours of a PNG stand for the steps of the TIFF's values, each for one."""
    png, tiff = (path_of("colours" + ending) for ending in (".png", ".tif"))
    compare(A, b, "--map", tiff, *options)
    table = compare(A, b, "--map", png, *options).stdout
    image = gdal.Open(png).ReadAsArray().astype(int)
    colours, expected = image[0] << 16 | image[1] << 8 | image[2], steps(pages_of(tiff)[page], least)
    pairs = set(zip(expected.ravel(), colours.ravel()))
    check(len(pairs) == len({step for step, _ in pairs}) == len({colour for _, colour in pairs}) > 5 and
          (0, 0) in pairs, f"{what}: each power of two has a colour, and 0 is black", sorted(pairs))
    check(colours.shape == expected.shape, f"{what}: the picture has the size of the stacks", colours.shape)
    navy = 8 << 16 | 29 << 8 | 88
    check((1, navy) in pairs and f"map colours       {what}: 0 black, up to 1/{1 / least:.0f} navy, " in table,
          f"{what}: the table says what navy stands for", table[-400:])


def coloured_maps():
    """Differences of 0, of less than the first step, and of all powers of two."""
    changed = PIXELS.astype(float)
    changed[:, 2:] += 2 ** random.uniform(-30, 3, (H - 2, W))
    other = stack("coloured.tif", changed, NM)
    test_colours("CIEDE2000", other, 2, 1 / 64, "--white", "d65")
    test_colours("largest difference of radiance", other, 0, 1 / 16384)
    result = compare(A, other, "--map", "-", text=False)
    check(result.stdout.startswith(b"II*") and b"spectral angle" in result.stderr
          and not os.path.exists("-"), "--map - writes to standard output, and the table to standard error", result.stderr)


# ---- components ----

def rendered(name, sampling):
    stack = f"{name}-{sampling.partition(':')[0]}.tif"
    return reference(stack, path_of(f"{name}.scene"), "--sampling", sampling, "--depth", "32f")


def components():
    """Components are compared if their sampling is the same; their colours come from the recorded response."""
    scene = "wavelengths 400 700 10\nsize 16 12\ncamera ortho 4\nobject plane 3 2 material m\nlight d65 1 direction 0 0 1\n"
    for name, paint in ("one", "0.5"), ("other", "gaussian:600,90"):
        write(f"{name}.scene", scene + f"material m {{ diffuse {paint} }}\n")
    one, other, xyz = (rendered(*words) for words in (("one", "rgb"), ("other", "rgb"), ("one", "xyz")))
    bases = [rendered(name, "basis:1") for name in ("one", "other")]
    response, white = response_of(one)
    labs = [cielab(np.tensordot(response, pages_of(each), (1, 0)), white[:, None, None]) for each in (one, other)]
    expected = ciede2000(*labs).max()
    result = compare(one, other)
    seen = float(re.search(r"CIEDE2000 .* (\S+) \(largest", result.stdout).group(1))
    check(abs(seen - expected) < 1e-5 * expected and "16 x 12 pixels, 96 not black in both; 3 components" in result.stdout
          and " nm" not in result.stdout, "components of one sampling are compared", seen, expected, result.stdout)
    compare(one, other, "--map", path_of("components.tif"))
    with tifffile.TiffFile(path_of("components.tif")) as tiff:
        names = [page.tags[285].value for page in tiff.pages]
    check(names == ["largest difference of components", "component angle in degrees", "CIEDE2000"],
          "the map of components names no spectra", names)
    check(compare(bases[0], bases[0]).returncode == 0, "a basis equals itself")
    for pair, what in ((bases, "bases of other spectra"), ((one, xyz), "rgb and xyz")):
        said = compare(*pair).stdout
        check("other components: colours are compared, nothing else" in said and "angle" not in said and "largest of A" not in said,
              f"of {what} the colours are compared", said)
        refused(*pair, "colours alone can be compared; expected --map with .png")
    refused(one, other, "expected --detector cie1931", "--detector", "cie1964")


def other_wavelengths():
    """Stacks of other wavelengths have their colours compared, by the weights of each, with the white of the first; pixels that are black
    in both do not count."""
    scene = write("ball.scene", "wavelengths 400 700 10\nsize 40 30\ncamera ortho 4\nobject sphere 1.5 20 20 material m\nlight d65 1 direction 1 1 1\n"
                  "material m { diffuse gaussian:600,40 }\n")
    fine, coarse = (path_of(f"{name}.tif") for name in ("fine", "coarse"))
    for stack_path, step in (fine, 5), (coarse, 25):
        output_of("render", scene, "--wavelengths", f"400:700:{step}", "--depth", "32f", "-q", "-o", stack_path)
    xyz = [np.tensordot(weights("cie1931", np.arange(400.0, 701, step)), pages_of(each), 1) for each, step in ((fine, 5), (coarse, 25))]
    shown = (pages_of(fine) != 0).any(0) | (pages_of(coarse) != 0).any(0)
    white = weights("cie1931", np.arange(400.0, 701, 5)) @ np.interp(np.arange(400.0, 701, 5), *built_in("d65"))
    found = np.sort(ciede2000(*(cielab(each[:, shown], white[:, None]) for each in xyz)))
    report = json.loads(output_of("compare", fine, coarse, "--tolerance", "100dE00", "--json", "-"))
    said = report["dE00"]
    expected = found.mean(), found[len(found) - len(found) // 20 - 1], found[-1]
    check(np.allclose([said["mean"], said["quantile_95"], said["largest"]], expected, rtol=2e-3) and expected[0] > 0.05,
          "the colours of other wavelengths are compared, as numpy does", said, expected)
    check(report["pixels_not_black"] == shown.sum() < 1200 and report["colours_alone"] and report["largest"] is None and not report["bands"],
          "black pixels do not count, and there are no differences of pages", report)
    result = compare(fine, coarse)
    check(result.returncode == 1 and "61 wavelengths\n                  and 13 other wavelengths: colours are compared, nothing else" in result.stdout,
          "compare says so, and without a tolerance they differ", result.stdout)
    refused(fine, coarse, "expected --tolerance as 0.5dE00", "--tolerance", "1%")
    check(compare(fine, coarse, "--tolerance", "100dE00", "--map", path_of("other.png")).returncode == 0 and os.path.exists(path_of("other.png")),
          "the map is a PNG of colour differences")


# ---- refused stacks ----

def refused(a, b, pattern, *options):
    refuses(f"{pattern} {' '.join(options)}", pattern, "compare", a, b, "--map", path_of("never.tif"), *options,
            absent=path_of("never.tif"))


def test_refusals():
    refused(A, stack("wide.tif", PIXELS[:, :, 1:], NM), rf"wide.tif: .*{W - 1} x {H} pixels, but .* {W} x {H}")
    refused(A, stack("few.tif", PIXELS[1:], NM[1:]), "colours alone can be compared; expected --map with .png")
    refused(A, stack("moved.tif", PIXELS, [*NM[:-1], NM[-1] + 1]), "colours alone can be compared; expected --map with .png")
    refused(A, stack("near.tif", PIXELS, [*NM[:-1], NM[-1] + 1e-5]), "colours alone can be compared; expected --map with .png")
    bad = PIXELS.copy()
    bad[2, 3, 4] = np.nan
    refused(A, stack("nan.tif", bad, NM), "nan.tif")
    refused(A, A, "has no white", "--tolerance", "1dE00")
    printed = Printed(compare(A, stack("some.tif", PIXELS + 1, NM)).stdout)
    check(printed.ciede2000 is None and printed.angle is not None, "without a white there is no CIEDE2000")


NM = [400, 450, 500, 550, 600, 650, 700]
W, H = 33, 17
random = np.random.default_rng(6)
PIXELS = random.random((len(NM), H, W)).astype(np.float32)
A = stack("a.tif", PIXELS, NM)
NOISY = (PIXELS * random.lognormal(0, 0.1, PIXELS.shape)).astype(np.float32)
test_same()
test_one_pixel()
test_angles()
test_statistics("random", PIXELS, NOISY, NM, "cie1931")
test_statistics("other-observer", PIXELS, NOISY, NM, "cie1964")
LARGE = random.random((40, 500, 900), dtype=np.float32)  # read in two chunks of rows
test_statistics("large", LARGE, LARGE * random.random(LARGE.shape, dtype=np.float32),
                list(range(400, 600, 5)), "cie1931")
test_threads(A, path_of("one-pixel.tif"))
test_threads(path_of("large-a.tif"), path_of("large-b.tif"))
coloured_maps()
components()
other_wavelengths()
test_refusals()
done()
