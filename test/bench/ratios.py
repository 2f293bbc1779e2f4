#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Measures every ratio that the program has a goal for, in one run. The programs of a row run by turns, round after
round, each as a process of its own, from start to exit. A ratio is taken in each round; the table shows the median,
the smallest and the largest of the rounds.
usage: test/bench/ratios.py [quick] [--csv FILE] [--from FOLDER] BUILD
quick: small pictures, to which the goals do not apply. --from: the folder that FILE is relative to."""
import argparse
import collections
import csv
import glob
import itertools
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time

Sizes = collections.namedtuple("Sizes", "large small bands band_side sides triangles triangle_side n_bands rays rounds enough "
                                        "parts_side parts")
# Rounds of the rows (a), (b) and (h); (c) and (f); (d), (g) and (i); (k). Sweeps compare runs with enough samples: of pixels,
# so that the start of the program, some 0.05 s, is at most a few per cent; of bands, so that 0.01 s of noise are.
FULL = Sizes(2000, 512, (3, 33, 93, 186, 461), 1000, (500, 1000, 2000, 4000, 8000), (71, 224, 707), 1000, 93, 0,
             (5, 9, 3, 2), {"pixels": 10e6, "bands": 90e6}, 8000, (1, 2, 4, 8))
QUICK = Sizes(200, 64, (3, 6, 12), 100, (50, 100, 200), (7, 22, 71), 100, 6, 100000, (3, 3, 2, 2),
              {"pixels": 1, "bands": 1}, 100, (1,))  # a small picture has one row of tiles, and so one part
MOST_MIB = 300
REFERENCE = ("--renderer", "raster", "--no-check")  # with the check, OpenGL would draw, too
NO_FILE = ("-o", "/dev/null")
PARTS = "read", "plan", "gl", "raster", "check", "write"
SECONDS = re.compile(rf"^  ({'|'.join(PARTS)}) +([-+0-9.e]+)$", re.MULTILINE)

# wall: seconds from start to exit; processor: user and system seconds of all threads; mib: the largest memory, at least
# the 15 MiB of this script, which the process is for a moment; parts: the program's own seconds.
Run = collections.namedtuple("Run", "wall processor mib parts")
Program = collections.namedtuple("Program", "words one_processor", defaults=(False,))
Group = collections.namedtuple("Group", "letters rounds programs")
# values: one of each round; middle: median, or max where the largest counts.
Figure = collections.namedtuple("Figure", "letter what unit values goal middle", defaults=(None, statistics.median))


def wavelengths(n):
    return ",".join(f"{300 + 460 * i / (n - 1):.6g}" for i in range(n))


class Bench:
    """The programs, the folder of their files, and all runs by group and name."""

    def __init__(self, build, sizes):
        self.spectral, self.tests = os.path.join(build, "spectral"), os.path.join(build, "test")
        self.folder = os.path.join(build, "tmp", "bench")
        self.sizes, self.runs = sizes, {}
        os.makedirs(self.folder, exist_ok=True)
        self.output, self.n_bytes = self.path("output.tif"), 0

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, lines):
        with open(self.path(name), "w") as out:
            out.writelines(line + "\n" for line in lines)
        return self.path(name)

    def render(self, scene, *options, **others):
        output = () if "-o" in options else ("-o", self.output)
        report = () if "-q" in options else ("-v",)  # with the seconds of each part
        return Program((self.spectral, "render", scene, *output, *report, *options), **others)

    def other(self, name, *words, **others):
        return Program((os.path.join(self.tests, name), *words), **others)

    def remove_parts(self):
        for path in glob.glob(self.output + ".*-of-*"):
            os.remove(path)

    def measure(self, program):
        """Runs a program. Its output file is removed afterwards; a later dd writes as many bytes. Parts stay for a join."""
        words = [word.format(bytes=self.n_bytes) for word in program.words]
        if "--part" in words[-1]:
            self.remove_parts()
        processors = os.sched_getaffinity(0)
        if program.one_processor:
            os.sched_setaffinity(0, {max(processors)})
        with tempfile.TemporaryFile("w+") as printed:
            start = time.monotonic()
            child = subprocess.Popen(words, stdout=printed, stderr=printed)
            _, status, used = os.wait4(child.pid, 0)
            wall = time.monotonic() - start
            os.sched_setaffinity(0, processors)
            printed.seek(0)
            text = printed.read()
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            sys.exit(f"{' '.join(words)}\nfails with {child.returncode}: {text}")
        if os.path.exists(self.output):
            self.n_bytes = os.path.getsize(self.output)
            os.remove(self.output)
        parts = {part: float(seconds) for part, seconds in SECONDS.findall(text)}
        return Run(wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, parts)

    def run(self, group):
        print(f"measuring {group.letters}: {len(group.programs)} programs, {group.rounds} rounds", flush=True)
        for _ in range(group.rounds):
            for name, program in group.programs.items():
                self.runs.setdefault((group.letters, name), []).append(self.measure(program))
        self.remove_parts()

    def of(self, letters, name):
        return self.runs[letters, name]

    def ratios(self, letters, above, below, seconds="wall"):
        """The ratios of the seconds of two programs, one a round."""
        return [getattr(a, seconds) / getattr(b, seconds) for a, b in zip(self.of(letters, above), self.of(letters, below))]


# ---- the programs ----

def large_picture(bench):
    """dd comes after the reference, and so writes a file of the same size."""
    size, bands = f"{bench.sizes.large}x{bench.sizes.large}", wavelengths(bench.sizes.n_bands)
    chart = ("colorchecker", "--size", size, "--wavelengths", bands, "--ambient", "d65*0")  # as the thesis has it
    dd = ("dd", "if=/dev/zero", f"of={bench.output}", "bs=1M", "conv=fsync", "iflag=count_bytes", "count={bytes}")
    return Group("abh", bench.sizes.rounds[0], {
        "render, checked": bench.render(*chart),
        "the thesis's loop": bench.other("thesis", size, bands),
        "the fastest loop": bench.other("thesis", size, bands, "at-once"),
        "render, reference": bench.render(*chart, *REFERENCE),
        "dd": Program(dd)})


def small_picture(bench):
    size = bench.sizes.small
    scene = bench.write("spheres.scene", (
        "wavelengths 300 760 5", f"size {size} {size}", "camera ortho 12", "light d65 1 position 0 0 8",
        "checker colorchecker sphere 0.9 40 40"))
    bands = "--wavelengths", wavelengths(bench.sizes.n_bands)
    return Group("c", bench.sizes.rounds[1], {
        "render, checked": bench.render(scene, *bands),
        "render, reference": bench.render(scene, *bands, *REFERENCE),
        "yardstick": bench.other("yardstick", *([str(bench.sizes.rays)] if bench.sizes.rays else []), one_processor=True)})


def sweep(bench, pairs):
    """pairs: (pixels a side, bands)"""
    programs = {}
    for side, n in pairs:
        words = ("colorchecker", "--size", f"{side}x{side}", "--wavelengths", wavelengths(n))
        programs["checked", side, n] = bench.render(*words)
        programs["reference", side, n] = bench.render(*words, *REFERENCE)
    return programs


def linear(bench):
    sizes = bench.sizes
    return [Group("d bands", sizes.rounds[2], sweep(bench, [(sizes.band_side, n) for n in sizes.bands])),
            Group("d pixels", sizes.rounds[2], sweep(bench, [(side, sizes.bands[0]) for side in sizes.sides]))]


def start_up(bench):
    return Group("f", bench.sizes.rounds[1], {
        "patches": bench.render("patches", "--size", "64x64", "--wavelengths", wavelengths(3)),
        "bare OSMesa": bench.other("bare")})


def processors(bench):
    chart = ("colorchecker", "--size", f"{bench.sizes.large}x{bench.sizes.large}", "--wavelengths",
             wavelengths(bench.sizes.n_bands), *NO_FILE)
    return Group("g", bench.sizes.rounds[2], {
        "render, checked, no file": bench.render(*chart),
        "render, not checked, no file": bench.render(*chart, "--no-check"),
        "render, checked, no file, one processor": bench.render(*chart, one_processor=True)})


def parts(bench):
    """Parts one after the other, as if each had a machine of its own. A join reads the parts that the program before it has drawn."""
    chart = ("colorchecker", "--size", f"{bench.sizes.parts_side}x{bench.sizes.parts_side}", "--wavelengths", wavelengths(31))
    programs = {"whole": bench.render(*chart, "-q")}
    for n in bench.sizes.parts:
        words = " ".join(bench.render(*chart, "-q", "-o", f"{bench.output}.$i-of-{n}").words)
        programs[f"{n} parts"] = Program(("sh", "-ec", f"for i in $(seq {n}); do {words} --part $i/{n}; done"))
    programs["join"] = Program(("sh", "-c", f"{bench.spectral} join -q -o {bench.output} {bench.output}.*-of-*"))
    return Group("k", bench.sizes.rounds[3], programs)


def net(bench, n):
    """A wavy net of 2 n^2 triangles. Its lines are never all in memory, which would count as that of programs: see Run."""
    corners = (f"v {10 * c / n - 5:.6f} {10 * r / n - 5:.6f} {0.3 * math.sin(30 * c / n) * math.cos(20 * r / n):.6f}"
               for r in range(n + 1) for c in range(n + 1))
    firsts = (r * (n + 1) + c + 1 for r in range(n) for c in range(n))
    faces = (f"f {i} {i + 1} {i + n + 2}\nf {i} {i + n + 2} {i + n + 1}" for i in firsts)
    bench.write(f"net-{n}.obj", itertools.chain(corners, faces))
    side = bench.sizes.triangle_side
    return bench.write(f"net-{n}.scene", (
        "wavelengths 300 760 5", f"size {side} {side}", "camera ortho 12",
        "light d65 1 position 0 0 8", "material m { diffuse 0.5 }", f"object mesh net-{n}.obj material m"))


def triangles(bench):
    bands = "--wavelengths", wavelengths(bench.sizes.n_bands)
    return Group("i", bench.sizes.rounds[2], {
        f"{2 * n * n} triangles": bench.render(net(bench, n), *bands) for n in bench.sizes.triangles})


# ---- the ratios ----

def spread(rates):
    """The largest by the smallest; infinite where noise makes a difference of seconds negative."""
    return max(rates) / min(rates) if min(rates) > 0 else math.inf


def linear_ratios(bench):
    """More pixels are compared by all seconds and all samples; more bands by seconds and samples beyond those of the run
    with the fewest bands, since finding the pixels of triangles takes the same time for any number of bands."""
    sizes = bench.sizes
    few, side = sizes.bands[0], sizes.band_side
    for kind in "checked", "reference":
        def rounds(letters, a_side, n):
            return [run.wall for run in bench.of(letters, (kind, a_side, n))]
        base = rounds("d bands", side, few)
        by_bands = [[(more - less) / ((n - few) * side * side) for more, less in zip(rounds("d bands", side, n), base)]
                    for n in sizes.bands[1:] if n * side * side >= sizes.enough["bands"]]
        by_pixels = [[seconds / (few * s * s) for seconds in rounds("d pixels", s, few)]
                     for s in sizes.sides if few * s * s >= sizes.enough["pixels"]]
        for name, by_size in ("band", by_bands), ("pixel", by_pixels):
            yield Figure("d", f"seconds per sample, largest / smallest, more {name}s, {kind}", "",
                         [spread(rates) for rates in zip(*by_size)], 1.1)


def peaks(bench):
    for what, chosen in ("rows a to h", lambda letters: letters != "i"), ("row i, triangles", lambda letters: letters == "i"):
        values = [run.mib for (letters, _), runs in bench.runs.items() if chosen(letters) for run in runs if run.parts]
        yield Figure("e", f"peak memory, {what}", "MiB", values, MOST_MIB, max)


def growth(bench, less, more):
    """The growth of the part that grows most, by the growth of the triangles. Parts that last less than 0.05 s in the
    larger scene are left out, unless all do."""
    names = [f"{2 * n * n} triangles" for n in (less, more)]
    for small, large in zip(*(bench.of("i", name) for name in names)):
        last = max(large.parts.values())
        grown = [large.parts[part] / max(small.parts[part], 0.001) for part in PARTS
                 if large.parts[part] >= min(0.05, last)]
        yield max(grown) * less ** 2 / more ** 2


def triangle_ratios(bench):
    n = bench.sizes.triangles
    for less, more in (n[0], n[1]), (n[1], n[2]), (n[0], n[2]):
        yield Figure("i", f"growth of a part / growth of triangles, {2 * less * less} to {2 * more * more}", "",
                     list(growth(bench, less, more)), 1.1)


def processor_ratios(bench):
    n = len(os.sched_getaffinity(0))
    checked, unchecked, one = ([run.processor for run in bench.of("g", f"render, {name}")] for name in (
        "checked, no file", "not checked, no file", "checked, no file, one processor"))
    yield Figure("g", "processor seconds that the check takes / those of the drawing, no file", "",
                 [all_ / gl - 1 for all_, gl in zip(checked, unchecked)], 1)
    yield Figure("h", f"processor seconds / ({n} x seconds), checked, file", "",
                 [run.processor / (n * run.wall) for run in bench.of("abh", "render, checked")], 1.1)
    yield Figure("h", f"processor seconds on {n} processors / on one", "",
                 [all_ / single for all_, single in zip(checked, one)])


def part_ratios(bench):
    for n in bench.sizes.parts:
        yield Figure("k", f"{n} parts, one after the other / one render", "", bench.ratios("k", f"{n} parts", "whole"), 1.1)
    yield Figure("k", "join / one render", "", bench.ratios("k", "join", "whole"))


def ratios(bench):
    yield Figure("a", "render with check and file / the thesis's loop", "",
                 bench.ratios("abh", "render, checked", "the thesis's loop"), 0.5)
    yield Figure("a", "the same, processor seconds", "",
                 bench.ratios("abh", "render, checked", "the thesis's loop", "processor"), 0.6)
    yield Figure("a", "render with check and file / the fastest loop, processor seconds", "",
                 bench.ratios("abh", "render, checked", "the fastest loop", "processor"), 0.75)
    yield Figure("b", "reference with file / dd of as many bytes, fsync in both", "",
                 bench.ratios("abh", "render, reference", "dd"), 1.5)
    yield Figure("c", "24 spheres, check and file / yardstick", "", bench.ratios("c", "render, checked", "yardstick"), 0.42 / 1.7)
    yield Figure("c", "24 spheres, reference and file / yardstick", "",
                 bench.ratios("c", "render, reference", "yardstick"), 0.085 / 1.7)
    yield from linear_ratios(bench)
    yield from peaks(bench)
    yield Figure("f", "patches, 64 x 64 x 3 / bare OSMesa program", "", bench.ratios("f", "patches", "bare OSMesa"), 1.5)
    yield from processor_ratios(bench)
    yield from triangle_ratios(bench)
    yield from part_ratios(bench)


# ---- seconds and memory of each program, without goals ----

def program_name(name):
    return name if isinstance(name, str) else "{0}, {1} x {1} x {2}".format(*name)


def details(letters, name, runs):
    """Seconds, processor seconds, memory and seconds by part of a program, and nanoseconds a sample in a sweep."""
    def figure(what, unit, values):
        return Figure(letters, f"{program_name(name)}: {what}", unit, values)
    yield figure("seconds", "s", [run.wall for run in runs])
    yield figure("processor", "s", [run.processor for run in runs])
    yield figure("peak", "MiB", [run.mib for run in runs])
    for part in PARTS if runs[0].parts else ():
        yield figure(part, "s", [run.parts[part] for run in runs])
    if not isinstance(name, str):
        yield figure("per sample", "ns", [1e9 * run.wall / (name[1] ** 2 * name[2]) for run in runs])


def print_programs(bench):
    print(f"\n{'':8} {'program':38} {'seconds':>7}  {'(least-most)':15}{'proc.':>6} {'MiB':>4}",
          *(f"{part:>6}" for part in PARTS), " ns a sample")
    for (letters, name), runs in bench.runs.items():
        seconds, used, mib, *rest = (statistics.median(figure.values) for figure in details(letters, name, runs))
        least, most = (pick(run.wall for run in runs) for pick in (min, max))
        print(f"{letters:8} {program_name(name):38} {seconds:7.3f}  {f'({least:.3f}-{most:.3f})':15}{used:6.2f} {mib:4.0f}",
              *(f"{value:6.3f}" for value in rest[:len(PARTS)]), *(f"{value:5.1f}" for value in rest[len(PARTS):]))


# ---- the table ----

def verdict(figure):
    if figure.goal is None:
        return ""
    return "met" if figure.middle(figure.values) <= figure.goal else "not met"


def print_ratios(figures):
    print(f"\n    {'ratio':82} {'measured':>8}  {'(least-most)':17} {'goal':>8}")
    for figure in figures:
        between = f"({min(figure.values):.3f}-{max(figure.values):.3f})"
        goal = "-" if figure.goal is None else f"<= {figure.goal:.3g}"
        what = figure.what + (f", {figure.unit}" if figure.unit else "")
        measured = f"{figure.middle(figure.values):8.3f}  {between:17} {goal:>8}  {verdict(figure)}"
        print(f"({figure.letter}) {what:82} {measured}".rstrip())


def write_csv(path, figures):
    with open(path, "w", newline="") as out:
        table = csv.writer(out)
        table.writerow(("row", "what", "unit", "measured", "least", "most", "goal", "verdict", "values"))
        for figure in figures:
            measured, least, most = (pick(figure.values) for pick in (figure.middle, min, max))
            table.writerow((figure.letter, figure.what, figure.unit, *(f"{value:.6g}" for value in (measured, least, most)),
                            "" if figure.goal is None else f"{figure.goal:.6g}", verdict(figure), len(figure.values)))


def print_machine(quick):
    with open("/proc/cpuinfo") as file:
        model = re.search(r"^model name\s*: (.*)$", file.read(), re.MULTILINE)
    print(f"{len(os.sched_getaffinity(0))} processors, {model[1] if model else 'unknown'}; "
          f"load before: {os.getloadavg()[0]:.2f}")
    print("seconds from start to exit of each process, files on disk; medians of rounds")
    if quick:
        print("small pictures, which no goal is for: this shows that the bench works, and nothing about speed")


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--from", dest="folder", default=".")
    options.add_argument("--csv")
    options.add_argument("build")
    options.add_argument("quick", nargs="?", choices=["quick"])
    chosen = options.parse_args()
    bench = Bench(chosen.build, QUICK if chosen.quick else FULL)
    print_machine(chosen.quick)
    for group in (large_picture(bench), small_picture(bench), *linear(bench), start_up(bench), processors(bench), triangles(bench),
                  parts(bench)):
        bench.run(group)
    figures = list(ratios(bench))
    print_programs(bench)
    print_ratios(figures)
    if chosen.csv:
        more = [figure for (letters, name), runs in bench.runs.items() for figure in details(letters, name, runs)]
        write_csv(os.path.join(chosen.folder, chosen.csv), figures + more)


main()
