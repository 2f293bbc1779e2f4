#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: binutils; makes: walk
"""How long the way of the simplest checked picture is for a reader: `render patches` passes at most so many functions of our own, in so
many rooms. The program is compiled by -finstrument-functions (test/program/walk.c). Prints TAP, and the functions by room."""
import collections
import os
import subprocess

from tap import bail_out, check, done

BUILD = os.environ.get("BUILD", "build")
PROGRAM = f"{BUILD}/test/spectral-walk"
STACK, FILE = (os.path.join(os.environ.get("TEST_TMP", f"{BUILD}/tmp"), name) for name in ("walk.tif", "walk.txt"))
# A reader who follows one picture from the words to the file should need a day; a budget is raised with a reason.
MOST_FUNCTIONS, MOST_ROOMS = 1000, 26


def passed(*words):
    """The functions that a command passes, by room."""
    ran = subprocess.run([PROGRAM, *words], env=dict(os.environ, WALK=FILE), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                         check=False)
    if ran.returncode:
        bail_out(ran.returncode, ran.stderr)
    with open(FILE, encoding="utf-8") as file:
        addresses = file.read().split()
    said = subprocess.run(["addr2line", "-f", "-e", PROGRAM, *addresses], stdout=subprocess.PIPE, text=True, check=True).stdout.split("\n")
    rooms = collections.defaultdict(set)
    for name, place in zip(said[::2], said[1::2]):
        if place.startswith("?"):  # of the C compiler's own start and end
            continue
        path = os.path.relpath(place.split(":")[0], os.getcwd())
        rooms[os.path.dirname(path) or path].add(f"{path}:{name}")
    return rooms


rooms = passed("render", "patches", "-o", STACK)
n = sum(map(len, rooms.values()))
print(f"# render patches: {n} functions, in {len({path.split(':')[0] for names in rooms.values() for path in names})} files of {len(rooms)} rooms:",
      ", ".join(f"{room} {len(names)}" for room, names in sorted(rooms.items(), key=lambda row: -len(row[1]))))
check(n > 100 and "raster/reference" in rooms, "functions are counted", n)
check(n <= MOST_FUNCTIONS, f"render patches passes at most {MOST_FUNCTIONS} functions", n)
check(len(rooms) <= MOST_ROOMS, f"they are in at most {MOST_ROOMS} rooms", len(rooms))
more = passed("render", "room", "--size", "30x20", "--wavelengths", "500", "-o", STACK)
check(sum(map(len, more.values())) > n, "a scene of more effects passes more", sum(map(len, more.values())))
done()
