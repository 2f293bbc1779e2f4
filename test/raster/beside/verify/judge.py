#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile; makes: fail
"""Exports scenes, lets the sample program data/samples/draw.c draw them, which has no part of spectral, and judges its
pixels: they agree, and are those of `render --gl egl` to the last bit. Each kind of change is found at its place, and the
report says what was not given. Pixels of another scene, and broken files, are refused. With FULL, all built-in scenes.
Prints TAP."""
import contextlib
import json
import os
import re
import resource
import shutil
import subprocess

import numpy as np
import tifffile

from foreign import draw_from
from rendered import EFFECTS, FAIL, SPECTRAL, bail_out, check, done, output_of, pages_of, path_of, refuses, remove, run, write

DRAW = path_of("draw")
DRAWN = path_of("drawn")
EXPORTED = path_of("exported")
SIZE = (90, 60)
COMMON = ("--size", f"{SIZE[0]}x{SIZE[1]}", "--full-scale", "4")  # a power of two rounds nothing
SHORT = ("--wavelengths", "400:700:50")


def compile_sample():
    source = "data/samples/draw.c"
    result = subprocess.run([os.environ.get("CC", "cc"), "-std=c99", "-D_POSIX_C_SOURCE=200809L", "-pedantic", "-Wall", "-Wextra",
                             "-Werror", "-O2", source, "-o", DRAW, "-lEGL", "-lGL", "-lm"],
                            check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
    check(result.returncode == 0 and '#include "' not in open(source).read(), "the sample compiles, without a header of ours",
          result.stdout)


def export(scene, *options):
    shutil.rmtree(EXPORTED, ignore_errors=True)
    return output_of("export", scene, *COMMON, *options, "-o", EXPORTED)


def draw(scene, driver, *options):
    """Exports a scene and draws it into DRAWN."""
    shutil.rmtree(DRAWN, ignore_errors=True)
    said = export(scene, *options)
    result = subprocess.run([DRAW, EXPORTED, DRAWN], check=False, stderr=subprocess.PIPE, text=True,
                            env={**os.environ, "GALLIUM_DRIVER": driver})
    if result.returncode != 0 or said != f"folder            {EXPORTED}\n":
        bail_out("draw", scene, said, result.stderr)


def judge(*options, pixels=DRAWN):
    return run("judge", EXPORTED, pixels, *options)


def figures():
    return json.loads(judge("--json", "-").stdout)["check"]


def colours(first_band):
    return os.path.join(DRAWN, f"colours-{first_band}.bin")


def agrees(scene, driver, *options):
    draw(scene, driver, *options)
    name = f"{os.path.basename(scene)} by {driver} {' '.join(options)}"
    result = judge()
    check(result.returncode == 0 and result.stderr == "" and re.search(rf"^drawn by +{driver}.*, by another program$", result.stdout, re.MULTILINE) and
          "agreed: every pixel is what" in result.stdout and "\nnot checked " not in result.stdout, f"{name}: agreed",
          result.stdout, result.stderr)
    seen = figures()
    check(seen["triangles_checked"] and seen["depths_checked"] and seen["worst_depth_error_over_bound"] > 0, f"{name}: all is checked")
    stack = path_of("render.tif")
    output_of("render", scene, *COMMON, *options, "--gl", "egl", "--renderer", driver, "--depth", "32f", "-o", stack)
    if "--samples" in options:
        return
    pages = pages_of(stack)
    drawn = [4 * np.fromfile(colours(i // 3 * 3), "<f4").reshape(SIZE[1], SIZE[0], 4)[:, :, i % 3] for i in range(len(pages))]
    check(all(np.array_equal(a, b) for a, b in zip(pages, drawn)), f"{name}: its colours are those of render --gl egl")


# ---- an exported folder ----

def in_place(scene, *options, program=DRAW):
    """Exports a scene, and lets a program draw it into the same folder, as a renderer that is not known."""
    folder = path_of("room")
    shutil.rmtree(folder, ignore_errors=True)
    output_of("export", scene, *options, "-o", folder)
    subprocess.run([program, folder], check=True, env={**os.environ, "GALLIUM_DRIVER": "llvmpipe"})
    for name in ("drawn.txt", "targets-drawn.txt"):
        with open(os.path.join(folder, name)) as file:
            text = file.read()
        with open(os.path.join(folder, name), "w") as file:
            file.write(text.replace("renderer llvmpipe", "renderer Other"))
    return folder


def strictly(scene):
    result = run("judge", in_place(scene, "--size", "90x60", *SHORT), "--strict")
    check(result.returncode == 0, "a strict judgement of a scene without shadows needs no more", result.stdout, result.stderr)


def folder_alone(scene):
    folder = in_place(scene, "--size", "90x60", *SHORT)
    result = run("judge", folder)
    check(result.returncode == 0 and " 90 x 60 pixels, 7 wavelengths" in result.stdout, "judge needs the folder alone", result.stdout, result.stderr)
    refuses("options of the scene", r"judge has no option '--size'", "judge", folder, "--size", "600x400")
    strict = run("judge", folder, "--strict")
    check(strict.returncode == 1 and "error: not verified: " in strict.stderr, "a strict judgement counts pixels along edges of shadows",
          strict.stdout, strict.stderr)
    drawn = os.path.join(folder, "drawn.txt")
    with open(drawn) as file:
        lines = file.read()
    with open(drawn, "w") as file:
        file.write(lines.replace("size 90 60", "size 91 60"))
    refuses("another size", r"drawn.txt:4:1: error: drawn at 91x60, exported at 90x60", "judge", folder)


def beside_folder():
    """The built-in room stays the scene of an export beside a folder of that name."""
    os.makedirs(path_of("beside/room"), exist_ok=True)
    shutil.rmtree(path_of("beside/exported"), ignore_errors=True)
    output_of("export", "room", "--size", "30x20", *SHORT, "-o", "exported", cwd=path_of("beside"))
    check(open(path_of("beside/exported/exported.txt")).readline() == "room\n", "a folder is not taken for the scene")


def measured(scene):
    """A driver that moves all corners by up to 1/32 pixel is a legal one of 4 bits: its targets say so. One of 1/8 pixel is not."""
    source = open("data/samples/draw.c").read()
    bounds = {}
    for steps in (0, 1, 4):
        moved = write(f"moved-{steps}.c", source.replace("    load_matrix(GL_PROJECTION, scene.projection);", f"""
            for (int i = 0; i < 4; i++) {{
                scene.projection[i] += {steps} / 16.0 / scene.width * scene.projection[12 + i];
                scene.projection[4 + i] -= {steps} / 16.0 / scene.height * scene.projection[12 + i];
            }}
            load_matrix(GL_PROJECTION, scene.projection);"""))
        program = path_of(f"moved-{steps}")
        subprocess.run([os.environ.get("CC", "cc"), "-D_POSIX_C_SOURCE=200809L", moved, "-o", program, "-lEGL", "-lGL", "-lm"], check=True)
        folder = in_place(scene, "--size", "90x60", *SHORT, program=program)
        result = run("judge", folder, "--unchecked", "1")
        if steps == 4:
            check(result.returncode == 3 and "the driver cannot be checked: its targets differ by more than OpenGL leaves free: " in result.stderr,
                  "corners moved by 1/8 pixel: refused", result.stdout, result.stderr)
            continue
        found = re.search(r"^bounds +measured: edges to (\S+) pixel", result.stdout, re.MULTILINE)
        bounds[steps] = float(found.group(1)) if found else 0
        check(result.returncode == 0, f"corners moved by {steps}/32 pixel: agreed", result.stdout, result.stderr)
        taken_over(folder, steps)
        with open(os.path.join(folder, "colours-3.bin"), "r+b") as file:
            pixels = np.memmap(file, "<f4", "r+").reshape(60, 90, 4)
            pixels[30, 45, 1] *= 1.1
            pixels.flush()
        broken = run("judge", folder, "--unchecked", "1")
        check(broken.returncode == 1 and "first at 45,30 " in broken.stderr, f"corners moved by {steps}/32 pixel: a wrong colour is found", broken.stderr)
        os.remove(os.path.join(folder, "targets-drawn.txt"))
        stated = run("judge", folder, "--unchecked", "1").stdout
        check("bounds            stated by drawn.txt: edges to 0.00391 pixel, values to 0.00391, depth to 1.5 step" in stated,
              "without targets, the bits of drawn.txt are taken", stated)
    check(bounds[0] <= 1 / 512 and 1 / 32 <= bounds[1] <= 1 / 16, "edges are measured to be where they are", bounds)


def taken_over(folder, steps):
    """The numbers of a driver that judge -v prints stand for its targets: the check is the same, and the report says so."""
    words = "judge", folder, "--unchecked", "1"
    numbers = re.search(r"^driver +(\d.*)$", run(*words, "-v").stdout, re.MULTILINE).group(1)
    before = json.loads(run(*words, "--json", "-").stdout)["check"]
    drawn, targets = (os.path.join(folder, name) for name in ("drawn.txt", "targets-drawn.txt"))
    text = open(drawn).read()
    os.rename(targets, targets + ".away")
    with open(drawn, "a") as file:
        file.write(f"driver {numbers}\n")
    result = run(*words)
    after = json.loads(run(*words, "--json", "-").stdout)["check"]
    check(result.returncode == 0 and after == before and "bounds            measured before: edges to " in result.stdout,
          f"corners moved by {steps}/32 pixel: the numbers of the driver stand for its targets", result.stdout, result.stderr)
    with open(drawn, "w") as file:
        file.write(text)
    os.rename(targets + ".away", targets)


# ---- changes ----

def differs(what, pattern):
    result = judge()
    check(result.returncode == 1 and re.search(pattern, result.stderr) and result.stderr.count("\n") == 1, what, result.stderr,
          result.stdout)


@contextlib.contextmanager
def changed(name, kind, channel, new):
    """Changes a number of the pixel 45,30 in a file of pixels, and puts the old one back at the end."""
    pixels = np.memmap(os.path.join(DRAWN, name), kind, "r+").reshape(SIZE[1], SIZE[0], -1)[30, 45]
    old = pixels[channel]
    pixels[channel] = new(old)
    yield
    pixels[channel] = old


def changes(scene):
    draw(scene, "llvmpipe", *SHORT)
    for what, name, kind, channel, new, pattern in (
            ("one colour", "colours-3.bin", "<f4", 1, lambda old: old + 0.01, ".*nm OpenGL"),
            ("one colour that is no number", "colours-0.bin", "<f4", 0, lambda old: np.nan, ""),
            ("one triangle", "numbers.bin", "<f4", 0, lambda old: old + 1, ".*shows triangle"),
            ("one instance", "numbers.bin", "<f4", 2, lambda old: 300, ".*does not exist"),
            ("one depth", "depths.bin", "<u4", 0, lambda old: old + (1 << 14), ".*depth"),
            ("one number of fragments", "depths.bin", "<u4", 0, lambda old: old + 1, ".*fragments")):
        with changed(name, kind, channel, new):
            differs(f"{what} is found where it was changed", "first at 45,30 " + pattern)
    check(judge().returncode == 0, "without these changes it agrees")
    os.rename(colours(0), path_of("kept"))
    shutil.copy(colours(3), colours(0))
    differs("two passes exchanged are found", r"pixels differ at|at pixel|differ")
    os.rename(path_of("kept"), colours(0))


def names_the_band():
    """At a pixel whose radiance changes steeply only the test across bands finds small errors. In each pass of 31 wavelengths,
    in all of its bands or in one, it names the bands that are wrong, also those by which all others are judged."""
    options = ("--wavelengths", "400:700:10")
    draw("spheres", "llvmpipe", *options)
    table = path_of("map.tif")
    judge("--check-map", table)
    floor, classes = pages_of(table)[0], pages_of(table)[3]
    steep = np.flatnonzero((classes == 0) & (floor < 100))
    y, x = divmod(int(steep[np.argmax(floor.ravel()[steep])]), SIZE[0])
    wrong, by_bands = [], 0
    for first in range(0, 31, 3):
        for channels in ([0, 1, 2], [0]) if first < 30 else ([0],):
            pixel = np.memmap(colours(first), "<f4", "r+").reshape(SIZE[1], SIZE[0], 4)[y, x]
            old = pixel.copy()
            pixel[channels] *= np.float32(1.004)
            failure = figures()["first_unexplained"]
            pixel[:] = old
            named = [(bands["first_page"], bands["last_page"]) for bands in failure["wrong_bands"]] or \
                [((failure["wavelength_nm"] - 400) / 10,) * 2]
            by_bands += failure["what"] == "bands"
            if failure["x"] != x or named not in ([(first, first + len(channels) - 1)], [(first, first)]):
                wrong.append((first, channels, failure))
    check(not wrong and by_bands > 3, f"a pixel that is 0.4 % off in a pass, or in a band, at {x},{y}: these bands are named", by_bands, *wrong)


def only_colours(scene):
    draw(scene, "llvmpipe", *SHORT)
    os.remove(os.path.join(DRAWN, "numbers.bin"))
    result = judge()
    check(result.returncode == 0 and "\nnot checked       triangles: there are none\n" in result.stdout and
          "agreed: every colour is what" in result.stdout, "without numbers triangles are not checked, and the report says so",
          result.stdout)
    with changed("depths.bin", "<u4", 0, lambda old: old + (1 << 14)):
        differs("a wrong depth is found without numbers", r"first at 45,30 .*depth")
    os.remove(os.path.join(DRAWN, "depths.bin"))
    result, seen = judge(), figures()
    check(result.returncode == 0 and "\nnot checked       triangles, depths and fragments: there are none\n" in result.stdout and
          not seen["triangles_checked"] and not seen["depths_checked"], "colours alone agree, too", result.stdout)
    with changed("colours-3.bin", "<f4", 1, lambda old: old + 0.01):
        differs("a wrong colour is found in colours alone", r"first at 45,30 .*nm OpenGL")


# ---- a TIFF ----

def tiff(scene):
    """The radiances of a stack become colours by the script of the manual."""
    stack, changed_stack = path_of("stack.tif"), path_of("changed.tif")
    run("render", scene, *COMMON, *SHORT, "--gl", "egl", "--renderer", "llvmpipe", "--depth", "32f", "-o", stack)
    export(scene, *SHORT)
    draw_from(EXPORTED, stack, DRAWN)
    result = judge()
    check(result.returncode == 0 and "agreed: every colour is what" in result.stdout and "\nbounds " in
          result.stdout and "drawn by          an unnamed renderer, unknown version, by another program" in result.stdout,
          "float pages agree", result.stdout, result.stderr)
    pages = tifffile.imread(stack)
    pages[4, 30, 45] += np.float32(0.04)
    tifffile.imwrite(changed_stack, pages, photometric="minisblack")
    draw_from(EXPORTED, changed_stack, DRAWN)
    with open(os.path.join(DRAWN, "drawn.txt"), "a") as drawn:
        drawn.write("\nrenderer llvmpipe\n")
    result = judge()
    check(result.returncode == 1 and re.search(r"first at 45,30 .*nm OpenGL", result.stderr), "a changed page is found", result.stderr)


# ---- refusals ----

def refusals(scene):
    draw(scene, "llvmpipe", *SHORT)
    words, drawn = ("judge", EXPORTED, DRAWN), os.path.join(DRAWN, "drawn.txt")
    text = open(drawn).read()
    for what, other, options in (("another light", scene, ("--light", "1=a")), ("another scene", "spheres", ())):
        export(other, *SHORT, *options)
        refuses(what, r"drawn.txt:1:4: error: .*another scene", *words)
    export(scene, *SHORT)
    write("drawn/drawn.txt", "id 12\n")
    refuses("another id", "another scene: expected id [0-9a-f]{64}, found 12", *words)
    write("drawn/drawn.txt", "renderer llvmpipe\n")
    refuses("no id", 'expected a line "id"', *words)
    write("drawn/drawn.txt", text + "colour 3\n")
    refuses("an unknown line", r"drawn.txt:7:1: error: .*colour", *words)
    for numbers, said in (("0.002 0", "expected a number"), ("0.5 0 5 2 0 1 1 -1", "edges 0.5 is above 0.125"), ("0 0 5 2 0 1 1 -1", "edges 0 is below 0.00195"),
                          ("0.002 0 5 2 0 1 2 -1", "mark of no holes 2 is out of range"), ("0.002 0 5 2 0 1 1 4", "levels of detail 4 is out of range"), ("0.002 0 5 2 0 1 1 nan", "nan"), ("0.002 0 5 2 0 1 1 -1 7", "too much")):
        write("drawn/drawn.txt", text + f"driver {numbers}\n")
        refuses(f"a driver of {numbers}", rf"drawn.txt:7:\d+: error: .*{said}", *words)
    write("drawn/drawn.txt", re.sub("renderer .*", "renderer Foo 9000", re.sub(".*-bits .*\n", "", text)))
    os.remove(os.path.join(DRAWN, "targets-drawn.txt"))
    result = run(*words)
    check(result.returncode == 0 and "bounds            of unknown" in result.stdout and "drawn by          Foo 9000, " in result.stdout,
          "an unknown renderer gets the bounds of any", result.stdout)
    write("drawn/drawn.txt", text)
    for name in ("colours-3.bin", "numbers.bin", "depths.bin"):
        os.truncate(os.path.join(DRAWN, name), 100)
        refuses(f"{name} is too short", rf"{name}: error: expected a file of \d+ bytes, found 100", *words)
        os.remove(os.path.join(DRAWN, name))
        if name[0] == "c":
            refuses(f"{name} is missing", rf"{name}: error: cannot read .*{name}: No such file", *words)
            os.mkfifo(os.path.join(DRAWN, name))
            refuses(f"{name} is a pipe", rf"{name}: error: cannot read .*{name}: it is no regular file", *words)
            os.remove(os.path.join(DRAWN, name))
            shutil.copy(colours(0), colours(3))
    for file in (os.path.join(DRAWN, "numbers.bin"), drawn):
        remove(file)
        os.mkfifo(file)
        refuses(f"{file} is a pipe", f"{file}: it is no regular file", *words)
        os.remove(file)
    write("drawn/drawn.txt", text)
    os.symlink("/dev/zero", os.path.join(DRAWN, "depths.bin"))
    refuses("depths.bin is a device", "depths.bin: it is no regular file", *words)
    os.remove(os.path.join(DRAWN, "depths.bin"))
    refuses("a folder that exists", "exists already", "export", scene, "-o", DRAWN)
    refuses("a folder below none", "cannot make the folder: No such file", "export", scene, "-o", path_of("nosuch/folder"))


def whole_or_not():
    folder = path_of("parent")
    shutil.rmtree(folder, ignore_errors=True)
    os.mkdir(folder)
    own = sorted(("spectral.notes", "spectral.a1b2c3", ".spectral-unfinished.old"))
    for name in own:
        os.mkdir(os.path.join(folder, name))
        open(os.path.join(folder, name, "file"), "w").close()
    result = subprocess.run([SPECTRAL, "export", "room", "-o", os.path.join(folder, "new")], check=False, stderr=subprocess.PIPE,
                            universal_newlines=True, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000)))
    check(result.returncode == 3 and result.stderr.count("\n") == 1 and sorted(os.listdir(folder)) == own,
          "a disk that is full leaves nothing", result.returncode, result.stderr, os.listdir(folder))
    statuses, left = set(), set()
    for allocation in (*range(500, 1000, 20), 10**9):
        result = subprocess.run([SPECTRAL, "export", "patches", "-o", os.path.join(folder, "new")], check=False, stderr=subprocess.PIPE,
                                env={**os.environ, "FAIL": f"own:{allocation}+", "LD_PRELOAD": FAIL})
        statuses.add(result.returncode)
        left |= set(os.listdir(folder)) - {*own, "new"}
        shutil.rmtree(os.path.join(folder, "new"), ignore_errors=True)
    check(statuses == {0, 3} and not left, "without memory, it leaves no folder", statuses, left)
    run("export", "patches", "-o", os.path.join(folder, "new"))
    check(sorted(os.listdir(folder)) == sorted((*own, "new")),
          "a whole export leaves its folder alone",
          os.listdir(folder))


compile_sample()
strictly("patches")
folder_alone("room")
beside_folder()
measured("colorchecker")
own = write("own.scene", EFFECTS.replace("700 10\n", "700 50\nshading flat\n"))
for each in ("llvmpipe", "softpipe"):
    agrees(own, each)
    agrees("room", each, *SHORT)
    agrees("textures", each, *SHORT)
    agrees("spheres", each, *SHORT, "--samples", "2")
if os.environ.get("FULL"):
    for each in ("llvmpipe", "softpipe"):
        for built_in in re.findall("^  (.*)$", run("list", "scenes").stdout, re.MULTILINE):
            agrees(built_in, each)
agrees("fluorescence", "llvmpipe", "--sampling", "xyz")
changes("colorchecker")
names_the_band()
only_colours("colorchecker")
tiff("colorchecker")
refusals("colorchecker")
whole_or_not()
done()
