#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile python3-gdal python3-pil pngcheck
"""Computes developed pictures once more with numpy, from the stack, the tables and published matrices, and
compares them pixel by pixel; some have closed forms. Prints TAP."""
import os
import re
import pty
import subprocess

import numpy as np
import tifffile
from osgeo import gdal
from PIL import Image

from colours import MONITOR, MONITOR_GAIN, MONITOR_GAMMA, cielab, srgb
from rendered import (CAMERAS, SPECTRAL, TMP, built_in, check, developed, done, output_of, pages_of, path_of, reference,
                      refuses, remove, response_of, run, weights, widths, write, write_stack)

gdal.UseExceptions()
D65 = np.array([0.3127, 0.3290, 1 - 0.3127 - 0.3290]) * 100 / 0.3290
OBSERVERS = "cie1931", "cie1964", "cie2006-2", "cie-standard-deviate"
CONES = {  # from XYZ
    "von-kries": [[0.4002, 0.7076, -0.0808], [-0.2263, 1.1653, 0.0457], [0, 0, 0.9182]],
    "bradford": [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]],
    "cat16": [[0.401288, 0.650173, -0.051461], [-0.250268, 1.204414, 0.045854],
              [-0.002079, 0.048952, 0.953127]]}
CONES["fairchild"] = CONES["von-kries"]


# ---- development with numpy ----

def adaptation(kind, white, equal, luminance):
    if kind == "none":
        return np.eye(3)
    cones = np.array(CONES[kind])
    of_white, part = cones @ white, np.ones(3)
    if kind == "fairchild":
        ratio = of_white / (cones @ equal)
        m = 3 * ratio / ratio.sum()
        part = (1 + np.cbrt(luminance) + m) / (1 + np.cbrt(luminance) + 1 / m)
    return np.linalg.inv(cones) @ np.diag(part * (cones @ D65) / of_white) @ cones


def display_matrix(display):
    if display == "monitor":
        return MONITOR
    primaries = np.array([[0.64, 0.33, 0.03], [0.30, 0.60, 0.10], [0.15, 0.06, 0.79]]).T
    return np.linalg.inv(primaries * np.linalg.solve(primaries, D65))


def largest(display):
    return MONITOR_GAIN ** MONITOR_GAMMA if display == "monitor" else np.ones(3)


def encode(display, linear):
    if display == "monitor":
        return np.minimum(linear.clip(0) ** (1 / MONITOR_GAMMA) / MONITOR_GAIN, 1)
    return srgb(linear)


def lab(xyz, white):
    return np.moveaxis(cielab(np.moveaxis(xyz, -1, 0), white[:, None, None]), 0, -1)


class Stack:
    """Radiances [page, y, x] as the program reads them, in single precision, and the white of its lights."""

    def __init__(self, path, nm, radiance, white=None, illumination=1.0):
        self.path, self.nm, self.white, self.illumination = path, np.asarray(nm, float), white, illumination
        self.radiance = np.asarray(radiance, np.float32).astype(float)

    def channels(self, detector, kind="none", luminance=None):
        """Adapted XYZ, or the channels of a balanced camera, of the picture and of the white."""
        of = weights(detector, self.nm)
        white = of @ self.white if self.white is not None else None
        if detector in CAMERAS:
            matrix = np.diag(1 / white)
        else:
            matrix = adaptation(kind, white, of.sum(1), luminance or 10 * self.illumination)
        return np.tensordot(self.radiance, (matrix @ of).T, (0, 0)), \
            matrix @ white if self.white is not None else None


# ---- the program ----

def develop(*words, **options):
    return run("develop", *words, **options)


def printed(text, key):
    found = re.search(f"^{key} +(.*)$", text, re.M)
    return found.group(1) if found else ""


def number(text, key):
    return float((printed(text, key) or "nan").split()[0])


def is_near(seen, expected, name, relative=1e-6):
    """Checks values within a millionth of the largest: floats are stored in single precision."""
    error = np.abs(seen - expected).max() / np.abs(expected).max()
    check(error <= relative, name, f"relative error {error}")


def is_encoded(seen, expected, bits, name):
    """Checks samples. The last bit may differ if the exact value is within 1e-6 of half-way between two steps."""
    exact = expected * (2**bits - 1)
    wrong = (np.abs(seen - exact) > 0.5 + 1e-6) | np.isnan(seen)
    check(seen.shape == expected.shape and not wrong.any() and np.ptp(expected) > 0.3, name,
          f"{wrong.sum()} samples differ; {np.ptp(expected)}")


def foreign(name, nm, radiance, **options):
    """Writes a stack of floats with OME-XML, without the program."""
    path = path_of(name + ".ome.tif")
    radiance = np.asarray(radiance, np.float32)
    tifffile.imwrite(path, radiance, ome=True, photometric="minisblack", **options, metadata={
        "axes": "CYX", "Channel": {"EmissionWavelength": list(map(float, nm)),
                                   "EmissionWavelengthUnit": ["nm"] * len(nm)}})
    return Stack(path, nm, radiance)


def rendered():
    """Two lights: the white is their mean by intensity."""
    scene = write("lights.scene", "size 90 60\nlight d65 0.5 direction 1 1 1\nambient a 0.3\n"
                  "material red { diffuse gaussian:640,80 }\nmaterial green { diffuse gaussian:520,60 }\n"
                  "material white { diffuse 1 }\nmaterial blue { diffuse gaussian:440,50*0.8 }\n"
                  "object sphere 1 30 30 material red translate -3 0 0\n"
                  "object sphere 1 30 30 material green translate -1 0 0\n"
                  "object sphere 1 30 30 material white translate 1 0 0\n"
                  "object sphere 1 30 30 material blue translate 3 0 0\n")
    path = reference("lights.tif", scene)
    counts = pages_of(path)
    with tifffile.TiffFile(path) as tiff:
        nm = np.array(tiff.pages[0].tags[65000].value, float)
        scale = float(re.search(r"full_scale: (\S+)", tiff.pages[0].description).group(1))
    white = (0.5 * np.interp(nm, *built_in("d65")) + 0.3 * np.interp(nm, *built_in("a"))) / 0.8
    return Stack(path, nm, counts / 65535 * scale, white, 0.8)


# ---- closed forms ----

def flat_spectra():
    nm, *curves = built_in("cie1931")
    flat = foreign("flat", nm, np.ones((len(nm), 4, 5)))
    sums = np.sum(curves, 1)
    xyz, _ = developed(flat.path, "--xyz")
    is_near(xyz, np.broadcast_to(100 * sums / sums[1], (4, 5, 3)),
            "a radiance of 1 everywhere has Y = 100, and X and Z of equal energy")
    for kind in "von-kries", "bradford", "cat16":
        xyz, _ = developed(flat.path, "--xyz", "--white", "1", "--adaptation", kind)
        is_near(xyz, np.broadcast_to(D65, (4, 5, 3)), f"{kind} takes the white to D65")
        for bits in "8", "16":
            rgb, text = developed(flat.path, "--white", "1", "--adaptation", kind, "--bits", bits)
            check((rgb == 2 ** int(bits) - 1).all() and number(text, "out of gamut") == 0,
                  f"{kind}: the white is white in {bits} bits and in gamut", text)
    values, _ = developed(flat.path, "--lab", "--white", "1")
    check(np.abs(values - [100, 0, 0]).max() <= 1e-4, "the white is L* = 100, a* = b* = 0")
    for camera in CAMERAS:
        rgb, _ = developed(flat.path, "--white", "1", "--detector", camera)
        check((rgb == 255).all(), f"{camera} is balanced to the white")


def factors(stack):
    base, _ = developed(stack.path, "--xyz")
    for factor in 2, 0.125:
        xyz, text = developed(stack.path, "--xyz", "--exposure", str(factor))
        check((xyz == factor * base).all() and base.max() > 10 and number(text, "exposure") == factor,
              f"exposure {factor} multiplies XYZ by {factor}")
        scaled = foreign("scaled", stack.nm, stack.radiance * factor)
        xyz, _ = developed(scaled.path, "--xyz")
        check((xyz == factor * base).all(), f"radiances times {factor} multiply XYZ by {factor}")
    for options in ((), ("--detector", "dcs200-camera"), ("--display", "monitor"), ("--adaptation", "cat16")):
        for bits in "8", "16":
            rgb, text = developed(stack.path, "--exposure", "auto", "--bits", bits, *options)
            check(rgb.max() == 2 ** int(bits) - 1 and "auto" in printed(text, "exposure"),
                  f"auto reaches the top of {bits} bits {' '.join(options)}")
    xyz, text = developed(stack.path, "--exposure", "auto", "--xyz")
    check(xyz[..., 1].max() == 100, "auto brings the largest Y to exactly 100")
    is_near(xyz, base / base[..., 1].max() * 100, "auto multiplies all values by the same factor")
    black = foreign("black", [400, 500, 600], np.zeros((3, 4, 5)))
    rgb, text = developed(black.path, "--exposure", "auto")
    check((rgb == 0).all() and number(text, "exposure") == 1, "a black picture stays black at exposure 1")


# ---- pictures compared with numpy ----

def recomputed(stack):
    for observer in OBSERVERS:
        xyz, white = stack.channels(observer)
        seen, text = developed(stack.path, "--detector", observer, "--xyz")
        is_near(seen, xyz, f"{observer}: XYZ")
        shown = [float(word) for word in re.findall(r"[-\d.e]+", printed(text, "white"))[:3]]
        check(np.allclose(shown, white, rtol=1e-5), f"{observer}: develop prints the white's XYZ", text)
        own, *curves = built_in(observer)
        covered = (own > stack.nm[0] - 2.5) & (own < stack.nm[-1] + 2.5)
        lost = [np.abs(curve[~covered]).sum() / np.abs(curve).sum() for curve in curves]
        shown = [float(word) / 100 for word in re.findall(r"[\d.e-]+(?= %)", printed(text, "unseen"))]
        check(np.allclose(shown, lost, atol=2e-6),
              f"{observer}: develop prints the part outside the wavelengths", shown, lost)
    for kind, options in (("none", {}), ("von-kries", {}), ("bradford", {}), ("cat16", {}), ("fairchild", {}),
                          ("fairchild", {"luminance": 318.3})):
        word = kind + "".join(f":{value}" for value in options.values())
        xyz, white = stack.channels("cie1931", kind, **options)
        seen, _ = developed(stack.path, "--adaptation", word, "--xyz")
        is_near(seen, xyz, f"{word}: XYZ")
        seen, _ = developed(stack.path, "--adaptation", word, "--lab")
        is_near(seen, lab(xyz, white), f"{word}: CIELAB beside the adapted white")
        for display in "srgb", "monitor":
            linear = xyz @ display_matrix(display).T
            for bits in 8, 16:
                seen, text = developed(stack.path, "--adaptation", word, "--display", display, "--bits", str(bits))
                is_encoded(seen, encode(display, linear), bits, f"{word}: {display}, {bits} bits")
            beyond = ((linear < -1e-6) | (linear > largest(display) + 1e-6)).any(2).sum()
            check(number(text, "out of gamut") == beyond, f"{word}: {display} has {beyond} pixels out of gamut", text)
    for camera in CAMERAS:
        linear, _ = stack.channels(camera)
        for display in "srgb", "monitor":
            for bits in 8, 16:
                seen, _ = developed(stack.path, "--detector", camera, "--display", display, "--bits", str(bits))
                is_encoded(seen, encode(display, linear), bits, f"{camera}: {display}, {bits} bits")
    other = Stack(stack.path, stack.nm, stack.radiance, np.interp(stack.nm, *built_in("a")), 0.8)
    linear = other.channels("cie1931", "cat16")[0] @ display_matrix("srgb").T
    seen, _ = developed(stack.path, "--adaptation", "cat16", "--white", "a")
    is_encoded(seen, encode("srgb", linear), 8, "--white a stands for the recorded lights")


def foreign_stacks():
    random = np.random.default_rng(6)
    nm = [380, 405.5, 450, 500, 520, 560, 590, 640, 650, 720]  # more than the program adds up at a time
    radiance = random.random((len(nm), 30, 40)) * 2
    stacks = [("OME-XML", foreign("random", nm, radiance)),
              ("deflated OME-XML", foreign("deflated", nm, radiance, compression="zlib"))]
    path = path_of("gdal.tif")
    counts = (radiance * 32767).astype(np.uint16)
    with tifffile.TiffWriter(path, byteorder=">") as tiff:
        for centre, page in zip(nm, counts):
            tag = (f'<GDALMetadata><Item name="wavelength" sample="0">{centre}</Item>'
                   '<Item name="wavelength_units" sample="0">Nanometers</Item></GDALMetadata>')
            tiff.write(page, contiguous=False, metadata=None, extratags=[(42112, 2, len(tag) + 1, tag, True)])
    stacks.append(("GDAL metadata", Stack(path, nm, counts / 65535)))
    for name, stack in stacks:
        xyz, _ = stack.channels("cie1931")
        seen, text = developed(stack.path, "--xyz")
        is_near(seen, xyz, f"a stack with {name}: XYZ")
        check("not recorded" in printed(text, "white"), f"a stack with {name} records no white")
        stack.white = np.interp(nm, *built_in("d65"))
        linear = stack.channels("cie1931", "fairchild")[0] @ display_matrix("srgb").T
        seen, _ = developed(stack.path, "--white", "d65", "--adaptation", "fairchild")
        is_encoded(seen, encode("srgb", linear), 8, f"a stack with {name} is adapted to a given white")
    single = foreign("single", [550], np.full((1, 2, 2), 3))
    xyz, _ = developed(single.path, "--xyz")
    own, *curves = built_in("cie1931")
    expected = 3 * 100 * np.array([np.interp(550, own, curve) for curve in curves]) / (curves[1] * widths(own)).sum()
    is_near(xyz, np.broadcast_to(expected, (2, 2, 3)), "a single wavelength stands for 1 nm")
    infrared = foreign("infrared", [500, 200000], np.full((2, 2, 2), 3)).path
    check(">200000</text>" in output_of("probe", infrared, 0, 0, "--white", "e", "--svg"), "an axis of long wavelengths has all digits")


# ---- files ----

def readers(stack):
    path = path_of("read.tif")
    for bits in "8", "16":
        develop(stack.path, "-o", path, "--bits", bits)
        with tifffile.TiffFile(path) as tiff:
            page, pixels = tiff.pages[0], tiff.asarray()
            profile = page.tags[34675].value
            check(page.photometric == 2 and page.bitspersample == int(bits) and len(tiff.pages) == 1,
                  f"{bits} bits: the picture has one page of RGB")
        check(np.array_equal(gdal.Open(path).ReadAsArray().transpose(1, 2, 0), pixels),
              f"{bits} bits: GDAL reads the same values")
        check(profile[36:40] == b"acsp" and profile[16:20] == b"RGB " and
              int.from_bytes(profile[:4],
                             "big") == len(profile), f"{bits} bits: the picture has an ICC profile of RGB")
    develop(stack.path, "-o", path)
    with Image.open(path) as image:
        check(image.mode == "RGB" and np.array_equal(np.asarray(image), tifffile.imread(path))
              and image.info["icc_profile"] == profile, "Pillow reads the same values and the profile")
    develop(stack.path, "-o", path, "--xyz", "--adaptation", "fairchild", "--exposure", "2")
    with tifffile.TiffFile(path) as tiff:
        names = [page.tags["PageName"].value for page in tiff.pages]
        floats, how = tiff.asarray(), tiff.pages[0].description
    check(names == ["X", "Y", "Z"] and floats.shape == (3,) + stack.radiance.shape[1:],
          "XYZ: the picture has three named pages")
    whole = gdal.Open(path)
    check(all(np.array_equal(gdal.Open(name).ReadAsArray(), page)
              for (name, _), page in zip(whole.GetSubDatasets(), floats)), "XYZ: GDAL reads the same values")
    with Image.open(path) as image:
        for page in range(3):
            image.seek(page)
            check(np.array_equal(np.asarray(image), floats[page]),
                  f"XYZ: Pillow reads the same values on page {page + 1}")
    for words in ("developed by +spectral", "stack +.*lights[.]tif", "detector +cie1931",
                  "white +XYZ .* [(]recorded[)]", "adaptation +fairchild to 8 cd/m2", "exposure +2"):
        check(re.search(words, how), f"the file records: {words}", how)


def chunks_and_threads():
    """A picture of more pixels than are developed at once, and stacks of some of its rows."""
    size, nm = 2100, [450, 550, 610]
    y, x = np.mgrid[:size, :size]
    counts = np.array([(x * (3 + page) + y * (7 + page) * 5) % 65536 for page in range(3)], np.uint16)
    files = []
    for name, rows in (("whole", np.s_[:]), ("top", np.s_[:40]), ("middle", np.s_[1980:2020]), ("end", np.s_[2060:])):
        files.append((write_stack(name + ".tif", counts[:, rows], nm), rows))
    for ending, *options in (".tif",), (".tif", "--xyz"), (".tif", "--exposure", "auto", "--bits", "16"), (".png",):
        pictures = []
        for threads in "1", "2", "5":
            path = path_of(f"threads{threads}{ending}")
            said = output_of("develop", files[0][0], "-o", path, "--threads", threads, *options)
            pictures.append((said.replace(path, ""), open(path, "rb").read()))
        check(pictures[0] == pictures[1] == pictures[2],
              f"1, 2 and 5 threads give the same bytes of a {ending[1:]} {' '.join(options)}")
        if ending == ".png" or "auto" in options:
            continue
        whole = np.moveaxis(pages_of(path), 0, -1)
        for path, rows in files[1:]:
            seen, _ = developed(path, *options)
            check(np.array_equal(seen, whole[rows]),
                  f"rows developed alone equal those of the whole picture {' '.join(options)}")


# ---- PNG ----

def pngcheck(path, words):
    """The output of pngcheck, which lists the chunks with -v."""
    result = subprocess.run(["pngcheck", words, path], capture_output=True, text=True, check=False)
    check(result.returncode == 0, f"pngcheck finds no fault in {os.path.basename(path)}", result.stdout)
    return result.stdout


def png_pair(stack, *options):
    """The paths of a stack developed as PNG and as TIFF."""
    paths = [path_of("pair" + ending) for ending in (".png", ".tif")]
    for path in paths:
        output_of("develop", stack, "-o", path, "--quiet", *options)
    return paths


def png_readers(stack):
    for bits in "8", "16":
        for display in "srgb", "monitor":
            png, tiff = png_pair(stack.path, "--bits", bits, "--display", display, "--exposure", "2")
            what, pixels = f"PNG, {bits} bits, {display}", tifffile.imread(tiff)
            kinds = re.findall(r"^  chunk (\w+) at offset", pngcheck(png, "-v"), re.MULTILINE)
            expected = ["IHDR", *(["sRGB"] if display == "srgb" else ["iCCP"]), "tEXt", "tEXt"]
            check(kinds[:len(expected)] == expected and set(kinds[len(expected):-1]) == {"IDAT"} and kinds[-1] == "IEND",
                  f"{what}: its chunks are whole and in order", kinds)
            seen = gdal.Open(png)
            check(seen.GetDriver().ShortName == "PNG" and
                  np.array_equal(seen.ReadAsArray().transpose(1, 2, 0), pixels) and np.ptp(pixels) > 0,
                  f"{what}: GDAL reads the samples of the TIFF")
            with Image.open(png) as image, Image.open(tiff) as other:
                image.load()
                if bits == "8":
                    check(image.mode == "RGB" and np.array_equal(np.asarray(image), pixels),
                          f"{what}: Pillow reads the samples of the TIFF")
                profile = image.info.get("icc_profile")
                check(profile == (tifffile.TiffFile(tiff).pages[0].tags[34675].value if display == "monitor" else None),
                      f"{what}: the profile is that of the TIFF, and sRGB needs none")
                check(image.info["Software"] == other.tag_v2[305] and image.info["Description"] == other.tag_v2[270],
                      f"{what}: program and description are those of the TIFF", image.info)
                if display == "srgb":
                    check(image.info["srgb"] == 0, f"{what}: it says that it is sRGB", image.info)


def png_sizes():
    """Pictures of odd sizes, smooth and of noise."""
    random = np.random.default_rng(15)
    nm = [450, 550, 610]
    for height, width in (1, 1), (5, 7), (1, 400), (400, 1), (3, 30000), (301, 300):
        y, x = np.mgrid[:height, :width] / max(height, width)
        smooth = np.array([x, y, x * y])
        noise = random.random((3, height, width)) * (y > 0.5)
        stack = write_stack("sized.tif", np.float32(smooth / 2 + noise / 4), nm)
        for bits in "8", "16":
            png, tiff = png_pair(stack, "--bits", bits)
            check(np.array_equal(gdal.Open(png).ReadAsArray().transpose(1, 2, 0), gdal.Open(tiff).ReadAsArray()
                                 .transpose(1, 2, 0)), f"a PNG of {width}x{height} pixels and {bits} bits is exact")
            pngcheck(png, "-q")


def endings(stack):
    for name, start in ("x.PNG", b"\x89PNG"), ("x.Tiff", b"II*"), ("x", b"II*"), ("x.", b"II*"), (".x", b"II*"):
        path = os.path.join(TMP, name)
        result = develop(stack.path, "-o", path, "--quiet")
        check(result.returncode == 0 and open(path, "rb").read(4).startswith(start), f"{name} chooses its format",
              result.stderr)
        os.unlink(path)


def named_by_default(stack):
    for options, name in ((), "lights.png"), (("--xyz",), "lights-xyz.tif"), (("--lab",), "lights-lab.tif"), (("--raw",), "lights-raw.tif"):
        result = develop(os.path.basename(stack.path), *options, cwd=TMP)
        check(result.returncode == 0 and os.path.exists(path_of(name)), f"without -o the picture is {name}", result.stderr)


def standard_output(stack):
    path = path_of("file.tif")
    table = develop(stack.path, "-o", path).stdout
    result = develop(stack.path, "-o", "-", text=False)
    check(result.returncode == 0 and result.stdout == open(path, "rb").read() and
          result.stderr.decode() == table.replace(path, "-"),
          "-o - writes the file to standard output, and the table to standard error")
    check(not os.path.exists("-"), "-o - makes no file of that name")
    for name in "-", "/dev/stdout":
        ours, theirs = pty.openpty()
        result = subprocess.run([SPECTRAL, "develop", stack.path, "-o", name], stdout=theirs, stderr=subprocess.PIPE,
                                check=False)
        os.close(theirs)
        os.close(ours)
        check(result.returncode == 2 and b"is a terminal" in result.stderr, f"-o {name} to a terminal is refused",
              result.stderr)


# ---- sampling ----

def sampled_stack(name, *options):
    return reference(name, "metamers", "--size", "60x40", "--wavelengths", "380:730:1", "--depth", "32f", *options)


def samplings():
    """A stack records how its spectra were sampled, and develop says so."""
    stacks = []
    own, *curves = built_in("cie1931")
    lost = [curve[(own < 380) | (own > 730)].sum() / curve.sum() for curve in curves]
    for name, method in (("box", "box:6"), ("rgb", "rgb"), ("fixed", "gauss:9,xyz")):
        stacks.append(sampled_stack(f"{name}.tif", "--sampling", method))
        _, text = developed(stacks[-1], "--xyz")
        shown = [float(word) / 100 for word in re.findall(r"[\d.e-]+(?= %)", printed(text, "unseen"))]
        check(len(shown) == 3 and np.allclose(shown, lost, rtol=1e-3) and printed(text, "sampling") == f"{method} for cie1931 (recorded)",
              f"{method} is recorded, and the unseen part lies outside the cells of 1 nm", text, lost)
    return stacks[1]


def components(path):
    """A stack of components is developed by the response that it records."""
    with tifffile.TiffFile(path) as tiff:
        names = [page.tags[285].value for page in tiff.pages]
    response, _ = response_of(path)
    seen, shown = developed(path, "--xyz")
    expected = np.moveaxis(np.tensordot(response, pages_of(path), (1, 0)), 0, -1)
    check(abs(seen - expected).max() <= 1e-6 * expected.max() and "components        3, of 380 to 730 nm" in shown,
          "rgb is developed by its recorded response", shown)
    linear = display_matrix("srgb") @ response
    check(abs(linear - np.eye(3)).max() < 1e-3 and len(set(names)) == 3 and "nm" not in "".join(names),
          "that response is sRGB's, and its pages have names", linear, names)


def black_and_forged(rgb):
    """A response without components is 0, and the picture is black. Control characters of a file do not reach the
    terminal."""
    scene = ("wavelengths 400 700 10\nsize 8 6\ncamera ortho 4\nobject plane 3 2 material m\n"
             "light d65 1 direction 0 0 1\nmaterial m { diffuse 0 }\n")
    for name, text in ("black", scene), ("unlit", re.sub("light.*", "", scene)):
        path = reference(f"{name}.tif", write(f"{name}.scene", text), "--sampling", "basis:3")
        check(not developed(path, "--exposure", "auto")[0].any(), f"components of {name} scenes are black")
    forged = path_of("forged.tif")
    with open(forged, "wb") as out:
        out.write(open(rgb, "rb").read().replace(b"sampling: rgb\nsampling_detector: cie1931",
                                                 b"sampling: %1B\nsampling_detector: cie1931"))
    result = develop(forged, "-o", out.name + ".seen.tif")
    check(result.returncode == 0 and "? for cie1931 (recorded)" in result.stdout and "\33" not in result.stdout,
          "a control character is not printed", result.stdout, result.stderr)


# ---- refusals ----

def refusals(rgb):
    path = path_of("refused.tif")
    remove(path)
    plain = foreign("plain", [400, 500, 600], np.ones((3, 4, 5)))
    infrared = foreign("infrared", [1000, 1100], np.ones((2, 4, 5)))
    red = foreign("red", [700, 710, 720], np.ones((3, 4, 5)))
    negative = foreign("negative", [400, 500], np.array([np.ones((2, 2)), -np.ones((2, 2))]))
    twice = write_stack("twice.tif", np.ones((2, 4, 5), np.uint16), (500, 500))
    wide = write_stack("wide.tif", np.ones((2, 4, 5), np.uint32), (400, 500))
    coloured = write_stack("coloured.tif", np.ones((2, 4, 5, 3), np.uint8), (400, 500), photometric="rgb")
    for says, source, *options in (
            ("twice.tif.*its wavelengths repeat: page 2 records 500 nm after 500 nm", twice),
            ("wide.tif.*its samples are 1 of 32 bits, unsigned", wide),
            ("coloured.tif.*its pages are RGB", coloured),
            ("--white", plain.path, "--lab"),
            ("--white", plain.path, "--detector", "dcs200-camera"),
            ("channel 3 of transparency-film responds to the white with 0", plain.path, "--detector", "transparency-film",
             "--white", "gaussian:600,1"),
            *((f"{kind} adaptation needs a white with cone responses above 0", red.path, "--white", "e", "--adaptation", kind)
              for kind in ("von-kries", "fairchild", "bradford")),
            ("sees nothing from 1000 to 1100 nm", infrared.path),
            ("expected --detector cie1931", rgb, "--detector", "cie1964"),
            ("is -1; expected a finite number that is not negative", negative.path)):
        refuses(says, says, "develop", source, "-o", path, *options, absent=path)


lights = rendered()
flat_spectra()
factors(lights)
recomputed(lights)
foreign_stacks()
readers(lights)
png_readers(lights)
png_sizes()
endings(lights)
named_by_default(lights)
standard_output(lights)
chunks_and_threads()
SAMPLED = samplings()
components(SAMPLED)
black_and_forged(SAMPLED)
refusals(SAMPLED)
done()
