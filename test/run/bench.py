#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# level: full; packages: libosmesa6-dev; makes: bench
"""Runs the bench of ratios with small pictures (test/bench/ratios.py): its table and its CSV must be complete, and their
figures must agree with each other. Nothing here depends on speed. Prints TAP."""
import csv
import math
import os
import subprocess
import sys

sys.dont_write_bytecode = True
from tap import bail_out, check, done

BUILD = os.environ.get("BUILD", "build")
TMP = os.path.join(os.environ.get("TEST_TMP", "build/tmp"), "bench")
TABLE = os.path.join(TMP, "bench.csv")
COLUMNS = "row what unit measured least most goal verdict values".split()
# The goals of each row, in order; "": a figure without one.
GOALS = {"a": ["0.5"], "b": ["1.5"], "c": ["0.247059", "0.05"], "d": ["1.1", "1.1", "", ""] * 2, "e": ["300"] * 2, "f": ["1.5"],
         "g": ["1", ""], "h": ["1.1", ""], "i": ["1.1"] * 3, "j": [""] * 10,
         "k": ["1.1"] * 4 + [""]}
# Programs of each group, and those among them that are `spectral`.
PROGRAMS = {"abh": (4, 2), "c": (3, 2), "d bands": (6, 6), "d pixels": (6, 6), "f": (2, 1), "g": (3, 3), "i": (3, 3), "j": (8, 8), "k": (6, 0)}
SECONDS, PARTS = ("seconds", "processor", "peak"), ("read", "plan", "gl", "raster", "check", "write")


def bench(build, *options):
    return subprocess.run([sys.executable, "test/bench/ratios.py", *options, build, "quick"], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False)


def is_well_formed(row):
    """All figures are numbers above 0 (a part's may be 0), in order, and the verdict follows from the goal. A difference of
    seconds that noise makes negative gives an infinite ratio."""
    measured, least, most = (float(row[name]) for name in ("measured", "least", "most"))
    verdict = "" if row["goal"] == "" else "met" if measured <= float(row["goal"]) else "not met"
    return (None not in row.values() and not math.isnan(measured) and 0 <= least <= measured <= most
            and int(row["values"]) >= 2 and row["verdict"] == verdict)


def is_printed(row, lines):
    """The table rounds to 3 decimals, the CSV to 6 digits."""
    head = f"({row['row']}) {row['what']}" + (f", {row['unit']}" if row["unit"] else "") + "  "
    rests = [line[len(head):].split(maxsplit=1) for line in lines if line.startswith(head)]
    return (len(rests) == 1 and rests[0][1].endswith(row["verdict"] or "-")
            and math.isclose(float(rests[0][0]), float(row["measured"]), rel_tol=1e-5, abs_tol=0.0006))


def check_ratios(rows, printed):
    ratios = [row for row in rows if ": " not in row["what"]]
    goals = {letter: [row["goal"] for row in ratios if row["row"] == letter] for letter in GOALS}
    check(goals == GOALS, "the CSV has all ratios, with their goals", goals)
    missing = [row["what"] for row in ratios if not is_printed(row, printed.splitlines())]
    check(not missing, "the table has them, too", *missing, printed)
    names = {(row["row"], row["what"]) for row in rows}
    check(len(names) == len(rows), "no figure has two lines")


def check_programs(rows):
    for letters, (n, n_ours) in PROGRAMS.items():
        own = [row["what"].rpartition(": ")[2] for row in rows if row["row"] == letters and ": " in row["what"]]
        wanted = {name: n for name in SECONDS} | ({name: n_ours for name in PARTS} if n_ours else {})
        if letters.startswith("d "):
            wanted["per sample"] = n
        found = {name: own.count(name) for name in set(own)}
        check(found == wanted, f"seconds and memory of {n} programs in {letters}", found)


def check_table():
    result = bench(BUILD, "--csv", TABLE)
    if result.returncode != 0:
        bail_out(result.stdout)
    with open(TABLE, newline="") as file:
        table = csv.DictReader(file)
        rows = list(table)
    check(table.fieldnames == COLUMNS, "the CSV has its columns", table.fieldnames)
    wrong = [row for row in rows if not is_well_formed(row)]
    check(not wrong, "all figures are numbers, in order, and verdicts follow from goals", *wrong)
    check_ratios(rows, result.stdout)
    check_programs(rows)


def check_failure():
    broken = os.path.join(TMP, "broken")
    os.makedirs(broken, exist_ok=True)
    program, table = os.path.join(broken, "spectral"), os.path.join(broken, "bench.csv")
    if not os.path.lexists(program):
        os.symlink("/bin/false", program)
    result = bench(broken, "--csv", table)
    check(result.returncode == 1 and f"{program} render" in result.stdout and not os.path.exists(table),
          "a program that fails ends the bench without a CSV", result.returncode, result.stdout)


os.makedirs(TMP, exist_ok=True)
check_table()
check_failure()
done()
