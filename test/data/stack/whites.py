#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""The white of a stack is the mean of its lights by their intensities, under each sampling, too, and --white stands for them.
develop.py computes the adaptations to it. Prints TAP."""
import json
import re

import numpy as np

from rendered import bytes_of, check, developed, done, output_of, path_of, reference, refuses, weights, write

NM = np.arange(380.0, 731)
PLANE = "size 4 4\ncamera ortho 4\nobject plane 2 2 material m\n"
LAMP = f"wavelengths 380 730 1\n{PLANE}material m {{ diffuse 0.5 }}\nlight lamp.csv 1 direction 0 0 1\n"
# Samplings, the relative error of the white of a spectrum that rises evenly, and whether they are fixed for one detector. The
# recorded wavelengths of the first two have 10 digits.
SAMPLINGS = (("gauss:8", 1e-9, False), ("gauss:8,open", 1e-9, False), ("gauss:9,xyz", 1e-12, True), ("gauss:9,lms", 1e-12, True),
             ("gauss:8,acc", 1e-12, True), ("basis:2", 1e-12, True), ("rgb", 1e-12, True), ("xyz", 1e-12, True), ("box:12", 0.05, False),
             ("adaptive:0.001", 0.001, False), ("riemann:10", 0.01, False))
KINDS = "gauss:8", "gauss:9,xyz", "basis:2", "rgb"


def stack(text, *options):
    return reference("stack.tif", write("case.scene", text), "--depth", "32f", *options)


def white(path, *options):
    """XYZ of the white; None: there is none."""
    return json.loads(output_of("develop", path, "--xyz", "--quiet", "-o", path_of("seen.tif"), "--json", "-", *options))["white"]


def refused(what, pattern, *words):
    refuses(f"{what}: {pattern}", pattern, "develop", *words, "-o", path_of("none.tif"), absent=path_of("none.tif"))


def means():
    """(3 lamp + 1 x 0.5 + 4 x 2) / 8, where the lamp is 1 at 400 nm, 4 at 700 nm and 0 at 800 nm."""
    lamp = write("lamp.csv", "400,1\n700,4\n")
    path = stack(f"wavelengths 400 800 100\n{PLANE}material m {{ diffuse 0.5 }}\nlight lamp.csv 3 direction 0 0 1\nambient 2 4\n"
                 "light 0.25*2 1 position 0 0 9\n")
    of = weights("cie1931", np.arange(400.0, 801, 100))
    for name, options, expected in (("two lights and an ambient one", (), np.array([11.5, 14.5, 17.5, 20.5, 8.5]) / 8),
                                    ("--white", ("--white", lamp + "*2"), [2, 4, 6, 8, 0])):
        check(np.allclose(white(path, *options), of @ expected, rtol=1e-12), f"{name}: the white is their mean", white(path, *options))
    for word, pattern in (("0", "the white is 0 at all of the stack's wavelengths"), ("no light", "--white:1:1: error: "),
                          ("-1", "--white:1:1: error: "), ("", "must not be empty")):
        refused(f"--white '{word}'", pattern, path, "--white", word)


def samplings():
    lamp = write("lamp.csv", "380,1\n730,4\n")
    exact = weights("cie1931", NM) @ (1 + 3 * (NM - 380) / 350)
    adapted = "--xyz", "--white", "1", "--adaptation", "fairchild"
    unsampled, _ = developed(stack(LAMP), *adapted)
    for method, error, fixed in SAMPLINGS:
        path = stack(LAMP, "--sampling", method)
        own, given = white(path), white(path, "--white", lamp)
        check(np.allclose([own, given], exact, rtol=error), f"{method}: the recorded white and the given one are those of the lamp", own, given, exact)
        if fixed:
            refused(method, "expected --detector cie1931", path, "--detector", "cie1964")
        if method in KINDS:
            check(np.allclose(developed(path, *adapted)[0], unsampled, rtol=1e-5), f"{method}: a white of 1 is a radiance of 1 everywhere")
    path = stack(LAMP, "--sampling", "box:7")
    check(np.allclose(white(path), white(path, "--white", lamp), rtol=1e-12), "boxes have the means of a white that is given")


def huge():
    """Numbers of a file that are finite, although their sums are not."""
    whole = bytes_of(stack(LAMP, "--sampling", "gauss:9,xyz"))
    for place, pattern in ((rb"\nwhite_response: \S+ (\S+)", "the white has 1e[+]300 in channel 2"),
                           (rb"\nresponse: (?:\S+ )*?(\S{8,})", "weight 1e[+]300 of page . cannot be used")):
        start, end = re.search(place, whole).span(1)
        with open(path_of("huge.tif"), "wb") as out:
            out.write(whole[:start] + b"1." + b"0" * (end - start - 6) + b"e300" + whole[end:])
        refused("a forged record", pattern, path_of("huge.tif"), "--adaptation", "cat16")


def unseen():
    """A light that the detector does not see gives no white to adapt to, but still a picture."""
    lamp = write("lamp.csv", "300,1\n350,1\n")
    for method in KINDS:
        path = stack(LAMP.replace("380 730", "400 700").replace("0.5 }", "0.5 emission 1 }"), "--sampling", method)
        check(white(path) is None, f"{method}: ultraviolet light makes no white", white(path))
        refused(method, "has no white", path, "--adaptation", "cat16")
        refused(method, "0 at all of the stack's wavelengths", path, "--white", lamp)


means()
samplings()
huge()
unseen()
done()
