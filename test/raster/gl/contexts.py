#!/usr/bin/env -S PYTHONPATH=test/shared:test/raster/check /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full release; packages: python3-numpy python3-tifffile libosmesa6
"""Checks --gl: OSMesa, EGL without a window and EGL's device draw the same colours, depths, triangles and fragments to
the last bit, with both of Mesa's drivers; a program without one of the libraries takes the other, and without both says
what to install. FULL: 40 random scenes, SOAK (`test release`): 200, and EGL's device with all scenes. Prints TAP."""
import json
import os
import re
import subprocess

import numpy as np

import random_scenes
from rendered import SCENES, SPECTRAL, TMP, amount, check, done, parts, objects_of, pages_of, refuses, render, run, unshadowed

LIBRARIES = ("osmesa", "egl", "egl:0")
NM = ("--wavelengths", "400:700:60")


def drawn(scene, *options):
    """All samples of a stack, its objects, and what the check counted and measured: of triangles, depths and
    fragments, too."""
    report = render(scene, *options, "--keep", "--depth", "32f", worst=1)
    stack = os.path.join(TMP, "stack.tif")
    return pages_of(stack), objects_of(stack), report["check"], (report["gl_library"], report["gl_renderer"].split()[0])


def are_alike(name, scene, *options, drivers=("llvmpipe", "softpipe")):
    for driver in drivers:
        words = (*options, "--renderer", driver)
        one = drawn(scene, *words, "--gl", "osmesa")
        check(one[3] == ("OSMesa", driver) and (one[0].max() > 0 or "random" in name), f"{name}: OSMesa draws with {driver}")
        for library in LIBRARIES[1:] if "FULL" in os.environ or name == SCENES[0] else ("egl",):
            two = drawn(scene, *words, "--gl", library)
            check(two[3] == ("EGL", driver) and np.array_equal(one[0], two[0], equal_nan=True) and np.array_equal(one[1], two[1]),
                  f"{name}: {library} draws the same with {driver}", two[3], np.abs(one[0] - two[0]).max())
            check(one[2] == two[2], f"{name}: {library} has the same depths and fragments with {driver}", one[2], two[2])


def scenes():
    for scene in SCENES:
        are_alike(scene, scene, *NM, "--size", "120x80")


def forms():
    for options in (("--buffer", "8"), ("--buffer", "16"), ("--size", "8300x20"), ("--size", "70x50", "--samples", "2"),
                    ("--shading", "flat"), ("--size", "60x40", "--accuracy", "0.5")):
        size = () if "--size" in options else ("--size", "60x40")
        are_alike(f"room {' '.join(options)}", "room", *NM, *size, *options, drivers=("llvmpipe",))


def ten_bits():
    """Only EGL has buffers of 10 bits. Softpipe stores the nearest step of a colour, llvmpipe floor(1024 colour), but for roundings."""
    options = (unshadowed("room"), *NM, "--size", "60x40")
    for driver, factor, lowest, highest in (("llvmpipe", 1024, -1, 0), ("softpipe", 1023, -0.5, 0.5)):
        words = (*options, "--renderer", driver, "--gl", "egl", "--depth", "32f")
        scale = render(*words, "--buffer", "10")["full_scale"]
        steps = pages_of(os.path.join(TMP, "stack.tif")).astype(float) / scale * 1023
        render(*words)
        colours = pages_of(os.path.join(TMP, "stack.tif")) / scale
        off = (steps - factor * colours)[colours > 0]
        check(lowest - 0.01 < off.min() < lowest + 0.1 and highest - 0.1 < off.max() < highest + 0.01 and np.abs(steps - np.rint(steps)).max() < 1e-3,
              f"EGL, {driver}: a buffer of 10 bits agrees, and has the expected steps", off.min(), off.max())
    refuses("OSMesa has no buffer of 10 bits", "OSMesa gives 16 bits of colour.*10, 24 and 8 are needed; --gl egl may have them",
            "render", *options, "--buffer", "10", "--gl", "osmesa", "-o", "/dev/null", status=3)


def random_ones():
    random_scenes.write_textures(TMP)
    for seed in range(1, 1 + amount(10, 40, 200)):
        are_alike(f"random scene {seed}", random_scenes.put(random_scenes.scene(seed, (64, 64)), TMP, str(seed)))


def without(*names):
    """A program that cannot find these libraries."""
    with open(SPECTRAL, "rb") as file:
        code = file.read()
    for name in names:
        found = f"lib{name}.so".encode()
        check(found in code, f"the program names {found.decode()}")
        code = code.replace(found, b"lib" + b"X" * len(name) + b".so")
    path = os.path.join(TMP, "without")
    with open(path, "wb") as file:
        file.write(code)
    os.chmod(path, 0o755)
    return path


def missing():
    drawing = ("render", "patches", "--size", "30x20", *NM, "-o", "/dev/null")
    program = without("OSMesa")
    result = run(*drawing, program=program)
    check(result.returncode == 0 and re.search("^drawn by .* by EGL$", result.stdout, re.MULTILINE),
          "without OSMesa the program takes EGL", result.stdout, result.stderr)
    result = run(*drawing, "--gl", "osmesa", program=program)
    check(result.returncode == 3 and re.fullmatch(r"error: OpenGL is missing: there is no libXXXXXX[^\n]*libosmesa6[^\n]*\n", result.stderr),
          "it says which package has OSMesa", result.stderr)
    program = without("OSMesa", "EGL")
    result = run(*drawing, program=program)
    check(result.returncode == 3 and result.stderr.count("\n") == 1 and "libosmesa6" in result.stderr and "libegl1 and libgl1-mesa-dri" in
          result.stderr and "--renderer raster needs none" in result.stderr, "without both it says which packages have them", result.stderr)
    check(run(*drawing, "--renderer", "raster", "--no-check", program=program).returncode == 0, "the reference needs neither")
    check(run("cost", "patches", "--size", "30x20", "--quiet", "--csv", "/dev/null", program=program).returncode == 0, "cost measures the reference")
    check("\nOpenGL cannot draw: OpenGL is missing: there is no libXXXXXX" in run("--version", program=program).stdout, "--version says that there is no OpenGL")
    libraries = subprocess.run(["ldd", SPECTRAL], check=True, stdout=subprocess.PIPE, universal_newlines=True).stdout
    check(not re.search("OSMesa|EGL|libGL|LLVM", libraries), "no library of OpenGL is linked", libraries)


def environment():
    """GALLIUM_DRIVER of a driver that cannot draw without a window: the message names it. Mesa alone would crash."""
    for library, words in (("egl", "EGL gives no display without a window by GALLIUM_DRIVER=zink of the environment"),
                           ("osmesa", "OSMesa draws by llvmpipe and softpipe, not by GALLIUM_DRIVER=zink of the environment")):
        line = [SPECTRAL, "render", "patches", "--gl", library, "-o", "/dev/null"]
        zink = {**{name: value for name, value in os.environ.items() if name != "DISPLAY"}, "GALLIUM_DRIVER": "zink"}
        result = subprocess.run(line, env=zink, capture_output=True, text=True)
        check(result.returncode == 3 and f"error: {words}; unset that, or add --renderer llvmpipe\n" in result.stderr, f"zink by {library}: refused by name",
              result.returncode, result.stderr)
        check(subprocess.run([*line, "--renderer", "llvmpipe"], env=zink, capture_output=True).returncode == 0, f"{library}: --renderer llvmpipe helps")


def drivers():
    """Each that is listed draws, by the options that are printed, and is what was listed."""
    listed = json.loads(run("drivers", "--json", "-").stdout)["drivers"]
    text = run("drivers").stdout
    ways = {(one["gl"], one["renderer"]) for one in listed}
    check({(library, None) for library in LIBRARIES} <= ways and {(library, "softpipe") for library in LIBRARIES} <= ways,
          "both libraries and the device are listed, with both of Mesa's drivers", ways)
    for one in listed:
        words = ["--gl", one["gl"]] + (["--renderer", one["renderer"]] if one["renderer"] else [])
        result = run("render", "patches", "--size", "30x20", *NM, "-o", "/dev/null", "--quiet", "--json", "-", *words)
        report = json.loads(result.stdout)
        check(one["usable"] and result.returncode == 0 and
              all(report[key] == one[key] for key in ("gl_library", "gl_renderer", "gl_version", "driver_profile")),
              f"{' '.join(words)} draws as it is listed", one, result.stderr)
        check(re.search(f"^{' '.join(words)}  +" + re.escape(f"{one['gl_renderer']}, {one['gl_version']}, {one['subpixel_bits']} subpixel and "
                                                          f"{one['depth_bits']} depth bits, can be checked\n"), text, re.MULTILINE),
              f"{' '.join(words)} has a line", text)
    program = without("OSMesa")
    result = run("drivers", program=program)
    check(result.returncode == 0 and re.search("^--gl osmesa +cannot draw: OpenGL is missing: ", result.stdout, re.MULTILINE),
          "a library that is missing is listed, with the package that has it", result.stdout)
    result = run("drivers", program=without("OSMesa", "EGL"))
    check(result.returncode == 3 and result.stdout.count("cannot draw") == 2 and result.stderr.count("\n") == 1,
          "without both, exit 3", result.stdout, result.stderr)


parts(scenes, forms, ten_bits, random_ones, missing, environment, drivers)
refuses("a device that is missing", "there is no egl:63", "render", "patches", "-o", "/dev/null", "--gl", "egl:63", status=3)
done()
