#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile
"""The samples around a camera: metamer.py makes pairs that agree under one lamp, to this integration and to probe, and bend less than
other pairs; electrons.py has the mean and the variance of shot and read noise; matrix.py fits what another least squares does. Prints TAP."""
import csv
import io
import json
import re
import subprocess
import sys

import numpy as np
import tifffile

from rendered import (TMP, built_in, bytes_of, check, ciede2000, cielab, done, objects_of, output_of, pages_of, parts, path_of, table, weights,
                      widths, write, write_stack)

RNG = np.random.default_rng(78)
CAMERA = "nm,violet,green,orange,red\n400,0.9,0.1,0,0\n460,0.3,0.2,0,0\n520,0,0.9,0.1,0\n580,0,0.3,0.8,0.1\n640,0,0,0.5,0.9\n700,0,0,0,0.4\n"
CHART = "patches", "--size", "120x80", "--wavelengths", "400:700:10", "--depth", "32f", "--quiet"


def sample(name, *words):
    return subprocess.run([sys.executable, f"data/samples/{name}.py", *map(str, words)], capture_output=True, text=True, check=False)


def refused(name, what, pattern, *words):
    """Some words on standard error; no output, and no trace of Python's."""
    result = sample(name, *words)
    check(result.returncode and not result.stdout and re.search(pattern, result.stderr) and "Traceback" not in result.stderr,
          f"{name}.py refuses {what}", result.returncode, result.stdout, result.stderr)


def write_table(name, heading, *columns):
    return write(name, heading + "\n" + "".join(",".join(f"{value:.9g}" for value in row) + "\n" for row in zip(*columns)))


def curves(name):
    """The path of a built-in table, as show writes it."""
    return write(f"{name.replace('/', '-')}.csv", output_of("show", name, "--csv"))


# ---- metamer.py ----

def bends(black):
    """The sum of squared second differences of a black that is 0 beyond its ends."""
    return (np.diff(np.concatenate([[0, 0], black, [0, 0]]), 2) ** 2).sum()


def least_bends(seen):
    """The least bends of a black whose squares have the sum 1: the smallest eigenvalue among blacks, by a projection."""
    n = seen.shape[1]
    bend = np.diff(np.concatenate([np.zeros((2, n)), np.eye(n), np.zeros((2, n))]), 2, axis=0)
    dark = np.eye(n) - np.linalg.pinv(seen) @ seen
    return np.linalg.eigvalsh(dark @ bend.T @ bend @ dark)[len(seen)]


def pair(*words):
    result = sample("metamer", *words)
    check(result.returncode == 0 and result.stdout.startswith("nm,original,metamer\n"), "metamer.py writes a pair", result.stderr)
    path = write("pair.csv", result.stdout)
    return table(path, ",")


def blacks():
    """Measured reflectances, and one whose wavelengths have steps of two widths."""
    nm = np.concatenate([np.arange(400.0, 500, 10), np.arange(500.0, 701, 5)])
    own = write_table("own.csv", "nm,own", nm, 0.3 + 0.2 * np.sin(nm / 50))
    for path, lamp in ((curves("colorchecker/13-blue"), "d65"), (curves("colorchecker/15-red"), "a"), (own, "f11"), (own, "d65")):
        nm, original, metamer = pair(path, curves("cie1931"), curves(lamp))
        name = f"{path.split('/')[-1]} under {lamp}"
        seen = weights("cie1931", nm) * np.interp(nm, *built_in(lamp), 0, 0)
        black = metamer - original
        check(np.allclose(original, table(path, ",")[1], rtol=1e-8) and np.abs(seen @ black).max() < 1e-12 * (seen @ original).max(), f"{name}: XYZ are equal", seen @ black)
        check(metamer.min() >= 0 and metamer.max() <= 1 and min(metamer.min(), 1 - metamer.max()) < 1e-12 and np.abs(black).max() > 0.05,
              f"{name}: within 0 and 1, and as large as they allow", metamer.min(), metamer.max(), np.abs(black).max())
        others = RNG.normal(size=(200, len(nm)))
        others -= others @ np.linalg.pinv(seen) @ seen
        others *= np.sqrt((black ** 2).sum() / (others ** 2).sum(1))[:, None]
        check(min(map(bends, others)) > bends(black) and abs(bends(black) / (black ** 2).sum() / least_bends(seen) - 1) < 1e-6,
              f"{name}: no black of its size bends less", bends(black), min(map(bends, others)), least_bends(seen))
        half = pair(path, curves("cie1931"), curves(lamp), "0.5")[2] - original
        check(np.allclose(half, black / 2, atol=1e-12), f"{name}: an amount of 0.5 is half of it")


def seen_by_probe():
    """The pair in a scene: equal under one lamp, to an observer or a camera, and different under the other."""
    write("scene.scene", "wavelengths 400 700 10\nsize 40 20\ncamera ortho 4\nlight d65 1 direction 0 0 1\n"
          "material original { diffuse pair.csv:original }\nmaterial other { diffuse pair.csv:metamer }\n"
          "object plane 1.6 1.6 material original translate -1 0 0\nobject plane 1.6 1.6 material other translate 1 0 0\n")
    nm = np.arange(400.0, 701, 10)
    for name, observer in (("13-blue", curves("cie1931")), ("22-neutral-5", curves("cie1931")), ("08-purplish-blue", write("camera.csv", CAMERA))):
        full, values = table(f"data/builtin/materials/colorchecker/{name}.txt")
        _, original, metamer = pair(write_table("own.csv", "nm,own", nm, np.interp(nm, full, values)), observer, curves("d65"))
        output_of("render", path_of("scene.scene"), "-o", path_of("pair.tif"), "--depth", "32f", "--quiet")
        if observer == path_of("camera.csv"):
            objects = json.loads(output_of("probe", path_of("pair.tif"), "--objects", "--detector", observer, "--json", "-"))["objects"]
            raw = [np.array(entry["channels"]) for entry in objects]
            check(np.allclose(*raw, rtol=1e-6) and np.abs(original - metamer).max() > 0.05, f"{name}: a camera has the same raw values", raw)
            continue
        said = output_of("probe", path_of("pair.tif"), "original", "--against", "other", "--light", "a")
        equal, other, index = map(float, re.search(r"CIEDE2000 +(\S+) under the recorded light\nCIEDE2000 +(\S+) under a, metamerism index (\S+)", said).groups())
        lit = weights("cie1931", nm) * np.interp(nm, *built_in("a"))
        expected = ciede2000(*(cielab(lit @ values, lit.sum(1)) for values in (original, metamer)))
        print(f"# {name}: CIEDE2000 {equal} under d65, {other} under a, metamerism index {index}")
        check(equal < 1e-3 and index > 1 and abs(other - expected) < 1e-3, f"{name}: probe finds 0 under d65, and more under a", said[:400], expected)


def no_pairs():
    red, eye, lamp = curves("colorchecker/15-red"), curves("cie1931"), curves("d65")
    nm = np.arange(400.0, 701, 20)
    bad = {"two lamps": (red, eye, write_table("two.csv", "nm,a,b", nm, nm, nm)), "two reflectances": (path_of("two.csv"), eye, lamp),
           "fewer wavelengths than curves": (write_table("few.csv", "nm,R", nm[:3], 0 * nm[:3] + 0.5), eye, lamp),
           "a lamp that is not seen": (red, eye, write_table("ir.csv", "nm,lamp", nm + 500, nm)), "an amount of 2": (red, eye, lamp, "2"), "an amount of 0": (red, eye, lamp, "0"),
           "an amount that is not a number": (red, eye, lamp, "nan")}
    for what, words in bad.items():
        refused("metamer", what, "expected one reflectance, of more wavelengths", *words)
    for what, text in (("no heading", "400,0.5\n500,0.5\n"), ("wavelengths that fall", "nm,R\n500,1\n400,1\n"), ("NaN", "nm,R\n400,nan\n500,1\n"), ("no values", "nm\n400\n500\n"), ("one row", "nm,R\n400,1\n")):
        refused("metamer", what, "odd.csv: expected a heading, and wavelengths that rise", write("odd.csv", text), eye, lamp)
    for what, values in (("values of 0 and 1 alone", np.arange(len(nm)) % 2), ("percent", 0 * nm + 50)):
        refused("metamer", what, "room.csv: expected values from 0 to 1 that leave room", write_table("room.csv", "nm,R", nm, values), eye, lamp)
    refused("metamer", "a word in a table", "odd.csv: could not convert", write("odd.csv", "nm,R\n400,red\n"), eye, lamp)
    refused("metamer", "an amount that is a word", "could not convert", red, eye, lamp, "much")
    refused("metamer", "a table that is not there", "No such file", red, eye, path_of("absent.csv"))
    refused("metamer", "no lamp", "metamer.py REFLECTANCE.csv OBSERVER.csv LAMP.csv", red, eye)


# ---- electrons.py ----

def noisy(raw, *words, out="electrons.tif"):
    result = sample("electrons", raw, path_of(out), *words)
    check(result.returncode == 0, f"electrons.py makes {out} {' '.join(words)}", result.stderr)
    return pages_of(path_of(out)), result.stdout


def agrees(samples, mean, variance, what):
    """Their mean and their variance, within five standard errors."""
    n = samples.size
    check(abs(samples.mean() - mean) < 5 * np.sqrt(variance / n) and abs(samples.var() - variance) < 5 * variance * np.sqrt((2 + 1 / max(mean, 1)) / n),
          f"{what}: {mean:g} electrons, with a variance of {variance:g}", samples.mean(), samples.var())


def noise():
    """Flat pages: a rounding to whole electrons adds a variance of 1/12."""
    values = np.array([0.002, 0.05, 0.3, 0.8], np.float32)
    flat = write_stack("flat.tif", [np.full((200, 300), value) for value in values], (400, 450, 500, 550))
    for well, read, kind in ((20000, 6.5, np.uint16), (65535, 20, np.uint16), (200000, 6.5, np.float32)):
        words = "--full-well", f"{well}", "--read", f"{read}", "--saturation", "1"
        pages, said = noisy(flat, *words, "--seed", "5", "--bound", "0.0001")
        for page, value in zip(pages, values):
            agrees(page, value * well, value * well + read ** 2 + 1 / 12, f"full well {well}, value {value:g}")
        check(tifffile.imread(path_of("electrons.tif")).dtype == kind and (pages == np.rint(pages)).all(), f"full well {well}: whole electrons, {kind.__name__}")
        stated = [float(number) for number in re.search(
            r"^noise (\S+) electrons at the mean of ([^,]+), (\S+) in the .*; the bound of the raw value is (\S+) el", said, re.MULTILINE).groups()]
        expected = np.sqrt(values.mean() * well + read ** 2), values.mean() * well, np.sqrt(values.min() * well + read ** 2), 0.0001 * well
        check(np.allclose(stated, expected, rtol=6e-3), f"full well {well}: noise and bound are printed", said, expected)
        noisy(flat, *words, "--seed", "5", out="again.tif")
        other, _ = noisy(flat, *words, "--seed", "6", out="other.tif")
        check(bytes_of(path_of("again.tif")) == bytes_of(path_of("electrons.tif")) and (other != pages).mean() > 0.9, f"full well {well}: one seed, one picture")
        correlation = np.abs(np.corrcoef(np.concatenate([pages, other]).reshape(8, -1)) - np.eye(8)).max()
        check(correlation < 5 / np.sqrt(pages[0].size), f"full well {well}: pages and seeds have noise of their own", correlation)
    pages, said = noisy(flat, "--full-well", "1000", "--read", "3", "--seed", "1", "--saturation", "0.1")
    check((pages[2:] == 1000).all() and pages.max() == 1000 and pages.min() >= 0 and "50 % of the samples fill the well" in said, "no sample is above the full well", said)
    pages, _ = noisy(flat, "--full-well", "1000", "--read", "3", "--seed", "1")
    check(abs((pages[3] == 1000).mean() - 0.5) < 0.02, "without --saturation the largest value fills the well", (pages[3] == 1000).mean())
    pages, said = noisy(flat, "--full-well", "1000", "--read", "0", "--seed", "1", "--saturation", "1e-30")
    check((pages == 1000).all(), "a saturation far below all values fills the well", said)


def of_the_camera():
    """Electrons of a render: names and facts are kept, and counts are raw values again."""
    output_of("render", *CHART, "-o", path_of("chart.tif"), "--check-map", path_of("map.tif"))
    camera = write("camera.csv", CAMERA)
    output_of("develop", path_of("chart.tif"), "--detector", camera, "--raw", "-o", path_of("raw.tif"), "--quiet")
    raw = pages_of(path_of("raw.tif"))
    floor, _, _, kind = tifffile.imread(path_of("map.tif"))
    nm, *sensitivities = table(camera, ",")
    own = np.arange(400.0, 701, 10)
    with tifffile.TiffFile(path_of("chart.tif")) as file:
        full_scale = float(re.search(r"full_scale: (\S+)", file.pages[0].description).group(1))
    bound = floor[kind == 0].max() * full_scale / 65535 * max((np.interp(own, nm, row, 0, 0) * widths(own)).sum() for row in sensitivities)
    pages, said = noisy(path_of("raw.tif"), "--full-well", "30000", "--read", "4", "--seed", "2", "--bound", f"{bound:.3g}")
    print("#", said.replace("\n", "\n# "))
    check(0 < float(re.search(r"raw value is (\S+) electrons", said).group(1)) < 0.2, "the bound of a raw value is far below the noise", said)
    with tifffile.TiffFile(path_of("electrons.tif")) as file:
        names = [page.tags[285].value for page in file.pages]
        scale = float(re.search(r"full_scale: (\S+)\n", file.pages[0].description).group(1)) / 65535
    check(names == ["violet", "green", "orange", "red"], "pages keep their names", names)
    for i, at in enumerate(objects_of(path_of("chart.tif")) == number for number in (1, 8, 15, 19)):
        expected = raw[i][at].mean()
        error = np.sqrt((expected / scale + 16) / at.sum()) * scale
        check(abs(pages[i][at].mean() * scale - expected) < 5 * error, f"{names[i]}: full_scale makes raw values of counts", pages[i][at].mean() * scale, expected, error)
    info = output_of("info", path_of("electrons.tif"))
    check(f"detector: {camera}\n" in info and "electrons: full well 30000 at a raw value of" in info and "unit: W sr-1 m-2 (relative)\n" in info, "info prints how electrons were made", info)
    noisy(path_of("chart.tif"), "--full-well", "60000", "--read", "2", "--seed", "2")
    rows = {name: list(csv.reader(io.StringIO(output_of("probe", path_of(name), 25, 25, 10, 10, "--csv"))))[1:] for name in ("chart.tif", "electrons.tif")}
    clean, seen = (np.array([row[1] for row in rows[name]], float) for name in rows)
    check(len(seen) == 31 and clean.min() > 0.01 and np.allclose(clean, seen, rtol=0.05), "a stack of radiances becomes one that probe reads", clean, seen)


def no_electrons():
    good = "--full-well", "1000", "--read", "2", "--seed", "1"
    flat = write_stack("flat.tif", np.full((2, 8, 8), 0.5, np.float32), (400, 500))
    for what, words in (("a full well of 0", ("--full-well", "0")), ("a full well that floats cannot hold", ("--full-well", "16777217")), ("a read noise below 0", ("--read", "-1")),
                        ("a read noise that is no number", ("--read", "nan")), ("a seed below 0", ("--seed", "-1")), ("a saturation of 0", ("--saturation", "0")),
                        ("a bound below 0", ("--bound", "-1"))):
        refused("electrons", what, "expected a full well from 1 to 16777216", flat, path_of("no.tif"), *good, *words)
    refused("electrons", "black pages", "largest raw value is 0", write_stack("black.tif", np.zeros((2, 8, 8), np.float32), (400, 500)), path_of("no.tif"), *good)
    for what, pages in (("counts", np.ones((2, 8, 8), np.uint16)), ("values below 0", np.full((2, 8, 8), -1, np.float32)), ("NaN", np.full((2, 8, 8), np.nan, np.float32))):
        refused("electrons", what, "expected floats, none below 0", write_stack("odd.tif", pages, (400, 500)), path_of("no.tif"), *good)
    tifffile.imwrite(path_of("nameless.tif"), np.ones((2, 8, 8), np.float32))
    for what, path in (("pages without names", path_of("nameless.tif")), ("a text", write("text.tif", "no picture\n")), ("a file that is not there", path_of("none.tif"))):
        refused("electrons", what, "expected a TIFF file whose pages have names", path, path_of("no.tif"), *good)
    refused("electrons", "no seed", "--seed", flat, path_of("no.tif"), *good[:4])


# ---- matrix.py ----

def fitted(*words):
    """The names and the rows of the matrix."""
    result = sample("matrix", *words)
    heading, *rows = csv.reader(io.StringIO(result.stdout)) if result.returncode == 0 else [[]]
    check(heading == ["channel", "X", "Y", "Z"], "matrix.py writes a table", result.stderr)
    return [row[0] for row in rows], np.array([row[1:] for row in rows], float)


def objects_table(name, channels, raw, xyz):
    """As probe --objects --csv writes it, with an object that has no pixels."""
    lines = [["object", "pixels", "X", "Y", "Z", "L", "a", "b", "400 nm", *channels, "400 nm standard deviation",
              *(channel + " standard deviation" for channel in channels)]]
    lines += [[f"object, {i}", 9, *map(repr, map(float, colour)), 0, 0, 0, 1, *map(repr, map(float, values)), 0, *(0 for _ in channels)]
              for i, (values, colour) in enumerate(zip(raw, xyz))]
    lines += [["none", 0, *[""] * (len(lines[0]) - 2)]]
    out = io.StringIO()
    csv.writer(out).writerows(lines)
    return write(name, out.getvalue())


def linear():
    for n in 1, 3, 6, 40:
        channels, matrix, raw = [f"c {i}" for i in range(n)], RNG.normal(size=(n, 3)), RNG.uniform(0.1, 9, (n + 18, n))
        names, found = fitted(objects_table("linear.csv", channels, raw, raw @ matrix))
        check(names == channels and np.abs(found - matrix).max() < 1e-9, f"{n} channels: a matrix is found again", np.abs(found - matrix).max())
        xyz = raw @ matrix + RNG.normal(size=(n + 18, 3))
        names, found = fitted(objects_table("near.csv", channels, raw, xyz))
        check(np.allclose(found, np.linalg.lstsq(raw, xyz, rcond=None)[0], rtol=1e-9) and np.allclose(raw.T @ (raw @ found - xyz), 0, atol=1e-8),
              f"{n} channels: the least squares of the rest", found)


def names():
    """Channels have names of coordinates, too, and blanks."""
    raw, matrix = RNG.uniform(0.1, 9, (20, 3)), RNG.normal(size=(3, 3))
    for channels in ["r", "g", "b"], ["X", "a", "Y"], ["c 1", "c 2", "450"]:
        names, found = fitted(objects_table("names.csv", channels, raw, raw @ matrix))
        check(names == channels and np.abs(found - matrix).max() < 1e-9, f"channels {channels}", names, found)
    write("camera.csv", CAMERA.replace("violet", '"deep violet"').replace("red", "b"))
    output_of("render", *CHART, "-o", path_of("chart.tif"))
    output_of("probe", path_of("chart.tif"), "--objects", "--detector", path_of("camera.csv"), "--csv", "-o", path_of("objects.csv"))
    write("fit.csv", sample("matrix", path_of("objects.csv")).stdout)
    output_of("develop", path_of("chart.tif"), "--detector", path_of("camera.csv"), "--matrix", path_of("fit.csv"), "-q", "-o", path_of("chart.png"))


def fits():
    """The chart of 24 patches: the fit is that of probe's JSON, and takes the picture's raw values near its XYZ."""
    output_of("render", *CHART, "-o", path_of("chart.tif"))
    words = "probe", path_of("chart.tif"), "--objects", "--detector", write("camera.csv", CAMERA)
    output_of(*words, "--csv", "-o", path_of("objects.csv"))
    objects = json.loads(output_of(*words, "--json", "-"))["objects"]
    raw, xyz = (np.array([entry[key] for entry in objects]) for key in ("channels", "XYZ"))
    names, found = fitted(path_of("objects.csv"))
    expected = np.linalg.solve(raw.T @ raw, raw.T @ xyz)
    check(names == ["violet", "green", "orange", "red"] and np.allclose(found, expected, rtol=1e-9), "the fit of 24 patches", found, expected)
    nm = np.arange(400.0, 701, 10)
    white = weights("cie1931", nm) @ np.interp(nm, *built_in("d65"))
    error = ciede2000(cielab(xyz.T, white[:, None]), cielab((raw @ found).T, white[:, None]))
    print(f"# CIEDE2000 of the fit: {error.mean():.4f} in the mean, {error.max():.4f} at most")
    check(error.max() < 8, "the fit has the colours of the patches", error)
    names, found = fitted(path_of("objects.csv"), "red", "violet")
    check(names == ["red", "violet"] and np.allclose(found, np.linalg.lstsq(raw[:, [3, 0]], xyz, rcond=None)[0], rtol=1e-9), "channels of one's choice, in their order", found)


def no_fits():
    raw = RNG.uniform(1, 2, (9, 3))
    good = objects_table("good.csv", ["r", "g", "u"], raw, raw)
    refused("matrix", "a channel that is not there", "expected one column y, found 0; its channels: r, g, u", good, "r", "y")
    refused("matrix", "two channels of one name", "expected one column r, found 2", objects_table("twice.csv", ["r", "r"], raw[:, :2], raw))
    refused("matrix", "fewer objects than channels", "its 3 channels need as many objects .*, found 2", objects_table("few.csv", ["r", "g", "u"], raw[:2], raw[:2]))
    refused("matrix", "two channels that are alike", "its 3 channels need as many objects .*, found 2", objects_table("alike.csv", ["r", "g", "u"], raw[:, [0, 1, 1]], raw))
    refused("matrix", "objects without channels", "expected channels of a camera", objects_table("none.csv", [], raw[:, :0], raw))
    refused("matrix", "NaN", "numbers that are finite", objects_table("nan.csv", ["r", "g", "u"], raw * np.nan, raw))
    refused("matrix", "another table", "expected one column X", write("other.csv", "nm,R\n400,1\n"))
    refused("matrix", "an empty file", "expected one column X", write("empty.csv", ""))
    refused("matrix", "a word for a number", "could not convert", write("word.csv", "object,pixels,X,Y,Z,L,a,b,r,r standard deviation\no,1,1,2,3,4,5,6,red,0\n"))
    refused("matrix", "a table that is not there", "No such file", f"{TMP}/absent.csv")
    refused("matrix", "no table", "matrix.py OBJECTS.csv")


parts(blacks, seen_by_probe, no_pairs, noise, of_the_camera, no_electrons, linear, names, fits, no_fits)
done()
