#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full
"""Small inputs that ask for much memory: each gives a result, or one line and exit status 2 or 3, and takes at most the memory that
--memory allows beyond the 300 MiB of a tile. Prints TAP, and a table of what each took.

With FULL=1 the inputs are larger, and the limit is the usual one of 1024 MiB."""
import os
import resource
import struct
import subprocess
import time
import zlib

from tap import check, done

FULL = "FULL" in os.environ
SPECTRAL = os.path.abspath(os.environ.get("SPECTRAL", "build/spectral"))
TMP = os.path.join(os.environ.get("TEST_TMP", "build/tmp"), "memory")
TILE_MIB, LIMIT_MIB = 300, 1024 if FULL else 64
TIMES = 16 if FULL else 1
LIGHT = "size 8 8\nwavelengths 500 600 100\ncamera ortho 3\nlight d65 1 direction 0 0 1\nmaterial m { diffuse 0.5 }\n"
SHORT, LONG = 3, 4
os.makedirs(TMP, exist_ok=True)


def path(name):
    return os.path.join(TMP, name)


def scene(name, statements):
    with open(path(name), "w") as out:
        out.write(LIGHT)
        for statement in statements:
            out.write(statement + "\n")
    return path(name)


def tiff(name, width, height, tags, data=b"", size=0):
    """One page of 16-bit grey, with more tags as {number: (type, count, value)}; data begin at byte 8. A file of `size` bytes has a
    hole behind them."""
    ifd = 8 + len(data) + len(data) % 2
    entries = {256: (LONG, 1, width), 257: (LONG, 1, height), 258: (SHORT, 1, 16), 259: (SHORT, 1, 1), 262: (SHORT, 1, 1),
               277: (SHORT, 1, 1), **tags}
    with open(path(name), "wb") as out:
        out.write(b"II*\0" + struct.pack("<I", ifd) + data + b"\0" * (len(data) % 2) + struct.pack("<H", len(entries)))
        out.writelines(struct.pack("<HHII", number, *entries[number]) for number in sorted(entries))
        out.write(struct.pack("<I", 0))
        out.truncate(max(out.tell(), size))
    return path(name)


def deflated(width, height):
    """A strip of zeros: a thousandth of its size."""
    packer = zlib.compressobj(6)
    row = bytes(2 * width)
    return b"".join([packer.compress(row) for _ in range(height)] + [packer.flush()])


def wide_strip(name, width, height):
    data = deflated(width, height)
    return tiff(name, width, height, {259: (SHORT, 1, 8), 273: (LONG, 1, 8), 278: (LONG, 1, height), 279: (LONG, 1, len(data))}, data)


def textured(texture):
    return scene(os.path.basename(texture) + ".scene", [
        f"material t {{ diffuse 0.5 texture {os.path.basename(texture)} }}", "object plane 1 1 material t"])


def mesh(name, corners):
    with open(path(name), "w") as out:
        for i in range(corners):
            out.write(f"v {i % 1000} {i // 1000} {i * i % 7}\n")
        for i in range(corners - 1001):
            out.write(f"f {i + 1} {i + 2} {i + 1002}\n")
    return scene(name + ".scene", [f"object mesh {name} material m"])


def matrix(name, columns):
    with open(path(name), "w") as out:
        out.write("nm," + ",".join(str(300 + i / 100) for i in range(columns)) + "\n")
        for i in range(columns):
            out.write(f"{400 + i / 100}," + ",".join(["0.00001"] * columns) + "\n")
    return scene(name + ".scene", [f"material f {{ diffuse 0.5 donaldson {name} }}", "object plane 1 1 material f"])


def names(name, n):
    with open(path(name), "w") as out:
        for _ in range(n):
            out.write("colorchecker/15-red\n")
    return path(name)


N = 40_000 * TIMES
HOSTILE = [
    ("a forged width of 486,539,283 pixels", "develop", lambda: "test/cases/bad/textures/too-wide.tif"),
    ("a tile of 262,144 x 262,144", "plan", lambda: textured(tiff("tile.tif", 16000, 16000, {
        259: (SHORT, 1, 8), 322: (LONG, 1, 262144), 323: (LONG, 1, 262144), 324: (LONG, 1, 8), 325: (LONG, 1, 100)}, bytes(100)))),
    ("a strip that inflates a thousand times", "plan", lambda: textured(wide_strip("strip.tif", 16000, 500 * TIMES))),
    ("a description of many MB", "info", lambda: tiff("text.tif", 4, 4, {
        270: (2, 80_000_000 * TIMES, 1000), 273: (LONG, 1, 8), 278: (LONG, 1, 4), 279: (LONG, 1, 32)}, bytes(32), 80_002_000 * TIMES)),
    ("a texture of 16,384 x 16,384", "plan", lambda: textured(wide_strip("texture.tif", 16384, 16384))),
    ("a sphere of 4096 x 4096", "render", lambda: scene("sphere.scene", ["object sphere 1 4096 4096 material m"])),
    ("a scene of one line", "plan", lambda: scene("line.scene", ["#" + "x" * 70_000_000 * min(TIMES, 3)])),
    (f"{N} objects", "render", lambda: scene("objects.scene", (f"object box 1 1 1 material m translate {i} 0 0" for i in range(N)))),
    (f"{N} materials", "render", lambda: scene("materials.scene", (
        f"material m{i} {{ diffuse {i / N} gloss 3 specular 0.5 }}\nobject plane 1 1 material m{i}" for i in range(N)))),
    (f"{N} lights", "plan", lambda: scene("lights.scene", (f"light d65 1 position {i} 0 9" for i in range(N)))),
    ("a list of many names", "render", lambda: names("names.list", 200 * TIMES)),
    ("a mesh of many faces", "render", lambda: mesh("mesh.obj", 200_000 * TIMES)),
    ("a Donaldson matrix", "plan", lambda: matrix("matrix.csv", 1000 * min(TIMES, 4))),
    ("a page of 16 megapixels", "view --size 4000x4000", lambda: scene("page.scene", ["object sphere 1 9 9 material m"])),
    ("a picture of 262,144 pixels a side", "render --renderer raster --no-check --size 262144x4 --wavelengths 500", lambda: scene(
        "wide.scene", ["object sphere 1 9 9 material m"])),
]


def made(make):
    """The path of an input, which is made in a process of its own: the memory of this one would count as the program's."""
    to_parent, to_child = os.pipe()
    if os.fork() == 0:
        os.write(to_child, make().encode())
        os._exit(0)
    os.close(to_child)
    os.wait()
    with os.fdopen(to_parent) as answer:
        return answer.read()


def run(words):
    """Returns the exit status, the lines on standard error, the peak in MiB and the seconds."""
    output = [] if words[0] in ("plan", "info") else ["-o", path("out.html" if words[0] == "view" else "out.tif"), "-q"]
    start = time.monotonic()
    with open(path("err"), "w") as err:
        child = subprocess.Popen([SPECTRAL, *words, *output, "--memory", str(LIMIT_MIB)], stdout=subprocess.DEVNULL, stderr=err)
        _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    with open(path("err")) as err:
        return child.returncode, err.read().splitlines(), usage.ru_maxrss / 1024, time.monotonic() - start


resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
print("# | input | exit status | peak MiB | seconds |")
for name, command, make in HOSTILE:
    words = command.split()
    status, lines, peak, seconds = run([words[0], made(make), *words[1:]])
    print(f"# | {name} | {status} | {peak:.0f} | {seconds:.1f} | {''.join(lines)[:150]}")
    check(peak <= TILE_MIB + LIMIT_MIB, f"{name}: at most {TILE_MIB} + {LIMIT_MIB} MiB", f"{peak:.0f} MiB", *lines)
    check(status == 0 or (status in (2, 3) and len(lines) == 1), f"{name}: a result, or one line and exit status 2 or 3",
          f"status {status}", *lines)
# The GNU C library gives each of many threads a heap, as on a machine with as many processors; what it takes in advance counts.
os.environ.update(LP_NUM_THREADS="16", MALLOC_ARENA_MAX="1000")
status, lines, peak, _ = run(["render", "spheres", "--size", "600x400", "--threads", "16"])
check(status == 0 and peak <= TILE_MIB + LIMIT_MIB, "32 threads with a heap each suffice", f"status {status}, {peak:.0f} MiB", *lines)
done()
