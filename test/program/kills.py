#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full release; packages: python3-numpy python3-tifffile libosmesa6; makes: fail
"""Ends renders at random moments, by signals, and lets the disk become full and files reach their limit of size. The stack
that was there before stays as it was, or the new one replaces it, byte by byte, and no other file stays behind.

Signals end cost and export, which have folders, too. With SOAK=1 (`test release`): 200 SIGKILLs, 100 of each signal that users send for each
command, and 100,000 objects in a scene.
Prints TAP, and the seconds that the program took to end."""
import collections
import os
import random
import resource
import shutil
import signal
import subprocess
import time
from pathlib import Path

from attacked import TMP, Place, Run, error_lines, faults, form, normal, on_old_file_systems, results
from tap import check, done

FULL = "SOAK" in os.environ
KILLS, SIGNALS, SIGNALS_OF_MANY = (200, 300, 90) if FULL else (20, 6, 6)
SIGNALS_OF_USERS = signal.SIGINT, signal.SIGTERM, signal.SIGHUP
LONGEST_END = 2     # seconds from a signal to the end: the machine may be busy
LONGEST_ORPHAN = 10
OBJECTS = 100_000 if FULL else 20_000
PICTURE = "--size 240x160 --wavelengths 400:700:5 -q -o out/a.tif"
RENDERS = [form("OpenGL", f"render in/plain.scene {PICTURE}", "a.tif"),
           form("the reference", f"render in/mesh.scene --renderer raster --no-check {PICTURE}", "a.tif")]
RENDERS.append(on_old_file_systems(RENDERS[1]))
FOLDERS = [form("cost", "cost in/tiny.scene --gl osmesa -q --csv out/cost.csv", "cost.csv"),
           form("export", "export in/mesh.scene --size 600x400 -o out/folder")]
MANY = form(f"{OBJECTS} objects", f"render in/many.scene --renderer raster {PICTURE}", "a.tif")


def write_many_objects(path):
    """Small things in a plane, each a little out of the way of the others."""
    with open(path, "w") as out:
        out.write("camera perspective 24 near 5 far 40 eye 0 6 13 look 0.1 0.6 0\nambient d65 0.25\nlight d65 0.7 position -5 9 8\n"
                  "material grey { diffuse 0.5 }\n")
        for i in range(OBJECTS):
            out.write(f"object sphere 0.02 4 3 material grey translate {i % 400 * 0.02 - 4:.2f} {i // 400 * 0.01 - 1:.2f} 0\n")


def ends(process, longest):
    """Waits for the first process, and then until no process of its group is left. Returns its messages, and whether all
    processes end in time."""
    process.wait()
    end = time.monotonic() + longest
    try:
        while time.monotonic() < end:
            os.killpg(process.pid, 0)
            time.sleep(0.005)
        os.killpg(process.pid, signal.SIGKILL)
        return process.communicate()[1], False
    except ProcessLookupError:
        return process.communicate()[1], True


class Job:
    """A command over an older stack, if it writes one: its files before and after, and its shortest time."""

    def __init__(self, place, a_form):
        self.place, self.form = place, a_form
        self.old = {"out/a.tif": Path(place.path("in/other.tif")).read_bytes()} if "out/a.tif" in a_form.outputs else {}
        place.run(a_form, counted=False)  # fills the drivers' cache
        self.seconds = LONGEST_ORPHAN
        for _ in range(3):  # other processes may make some of them longer
            start = time.monotonic()
            run = place.run(a_form, counted=False)
            self.seconds = min(self.seconds, time.monotonic() - start)
        self.new = self.files()
        check(run.status == 0 and self.new, f"{a_form.name}: the output is written", run.stderr)

    def start(self, emptied, part, parts):
        """Starts the command, and waits until a random moment in one of so many equal parts of its time."""
        if emptied:
            self.place.prepare(self.form, False)
        for name, data in self.old.items():
            Path(self.place.path(name)).write_bytes(data)
        process = self.place.start(self.form)
        time.sleep(self.seconds * (part + random.random()) / parts)
        return process

    def files(self):
        """The content of all outputs and temporary files."""
        paths = [path for name in ("out", "tmp") for path in Path(self.place.path(name)).rglob("*") if path.is_file()]
        names = [os.path.relpath(path, self.place.folder) for path in paths]
        return {name: normal(self.form, name, path.read_bytes()) for name, path in zip(names, paths)}

    def state(self, files):
        """old, new, or what else the files are."""
        return "old" if files == self.old else "new" if files == self.new else f"broken: {sorted(files)}"


def check_kills(job, count):
    states, left = collections.Counter(), set()
    job.place.prepare(job.form, False)
    for i in range(count):
        process = job.start(False, i, count)
        process.kill()
        _, all_end = ends(process, LONGEST_ORPHAN)
        files = job.files()
        left |= set(files) - set(job.new)
        states[job.state({name: files[name] for name in set(files) & set(job.new)}) if all_end else "a process goes on"] += 1
    name = f"{job.form.name}: {count} SIGKILLs"
    check(set(states) <= {"old", "new"}, f"{name}: the old stack or the new one is there", states)
    check(job.form.nameless or not left, f"{name}: no other file is left", sorted(left)[:5])
    print(f"# {name}: {dict(states)}, {len(left)} other files")


def check_signals(job, count):
    """Returns how many signals the program received before its end."""
    longest, wrong, met = 0, [], 0
    for i in range(count):
        number = SIGNALS_OF_USERS[i % len(SIGNALS_OF_USERS)]
        process = job.start(True, i, count)
        start = time.monotonic()
        process.send_signal(number)
        process.wait()
        longest = max(longest, time.monotonic() - start)
        stderr, all_end = ends(process, LONGEST_END)
        state = job.state(job.files())
        well = process.returncode == 0 and state == "new"
        met += not well
        if not (well or process.returncode == -number and state in ("old", "new")) or not all_end:
            wrong.append((number, process.returncode, state, all_end, stderr))
    name = f"{job.form.name}: {count} signals"
    check(not wrong, f"{name}: the program dies of them, the old files or the new ones are there, and no other", *wrong[:10])
    check(longest < LONGEST_END, f"{name}: it ends within {LONGEST_END} s", longest)
    print(f"# {name}: at most {longest:.3f} s to the end; {met} met it")
    return met


# ---- full disk, limits ----

def check_refusals(name, a_form, expected, runs):
    """Each run has the right result, or exit status 3 and the older file; both happen."""
    wrong, statuses = [], set()
    for label, run in runs:
        found = faults(a_form, run, expected, True)
        statuses.add(run.status)
        if found:
            wrong.append((label, found, run.status, error_lines(run)))
    check(not wrong, f"{name}: the right result, or exit status 3 and the older files", f"{len(wrong)} of {len(runs)}", *wrong[:10])
    check(statuses == {0, 3}, f"{name}: small limits are refused, large ones are enough", statuses)


def limits(largest):
    step = 4096 if FULL else 65536
    return range(0, largest + 2 * step, step)


def check_file_size(place, a_form, expected):
    def limited(limit):
        return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    largest = max(map(len, expected[-1].values()))
    check_refusals(f"{a_form.name}: a limit on the size of files", a_form, expected,
                   [(limit, place.run(a_form, older=True, counted=False, preexec_fn=limited(limit))) for limit in limits(largest)])


def check_full_disk(place, a_form, expected):
    """The outputs lie on a file system in memory. A filler leaves only some of its pages free."""
    sizes = sum(map(len, expected[-1].values()))
    place.prepare(a_form, False)
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={sizes + (1 << 20)}", "tmpfs", place.path("out")],
                             capture_output=True, text=True, check=False)
    if mounted.returncode != 0:
        check(True, f"{a_form.name}: a full disk # SKIP cannot mount a tmpfs: {mounted.stderr.strip()}")
        return
    runs = []
    try:
        for free in limits(sizes + 16384):
            runs.append((free, run_with_free(place, a_form, free)))
    finally:
        subprocess.run(["umount", place.path("out")], check=True)
    check_refusals(f"{a_form.name}: a full disk", a_form, expected, runs)


def run_with_free(place, a_form, free):
    """Runs where so many bytes are free beside the older files."""
    place.prepare(a_form, True)
    space = os.statvfs(place.path("out"))
    filler = place.path("out", "filler")
    with open(filler, "wb") as out:
        os.posix_fallocate(out.fileno(), 0, max(space.f_bavail * space.f_frsize - free, 1))
    process = place.start(a_form)
    stdout, stderr = process.communicate()
    files = place.outputs()
    del files["out/filler"]
    return Run(process.returncode, stdout, stderr.decode(), files, os.listdir(place.path("tmp")), True, None)


def main():
    random.seed(19)
    for number in SIGNALS_OF_USERS:
        signal.signal(number, signal.SIG_DFL)  # a test in the background may have to ignore some of them
    shutil.rmtree(TMP, ignore_errors=True)
    place = Place(0)
    write_many_objects(place.path("in", "many.scene"))
    met = 0
    for a_form in RENDERS:
        job = Job(place, a_form)
        check_kills(job, KILLS // len(RENDERS))
        met += check_signals(job, SIGNALS)
    for a_form in FOLDERS:
        met += check_signals(Job(place, a_form), SIGNALS)
    met += check_signals(Job(place, MANY), SIGNALS_OF_MANY)
    check(met > 0, "some signals meet a program at work", met)
    outputs = form("all outputs", "render in/plain.scene --size 120x80 --wavelengths 400:700:20 -q --renderer raster --check-map "
                   "out/map.tif --json out/a.json -o out/a.tif", "a.tif", "a.json", "map.tif")
    expected = results(outputs, place.run(outputs, counted=False))
    for a_form in (outputs, on_old_file_systems(outputs)):
        check_file_size(place, a_form, expected)
        check_full_disk(place, a_form, expected)
    shutil.rmtree(TMP, ignore_errors=True)
    done()


main()
