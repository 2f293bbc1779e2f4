#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: libosmesa6-dev python3-numpy python3-tifffile; makes: test_text faults
"""Plants the faults of test/mutants.list one at a time in copies of the sources, builds what each concerns, and runs the tests that the
list names, up to the first that fails. A fault that none of them notices is a failure; so is one whose text is not, or not once, in its
file, and one that does not build. Prints TAP, and a table of what noticed each.

A block of the list is a file, the text of a line or of a part of it, the text that replaces it, and tests by name; positions:maps is one
case of a test (ONLY=maps). A fault that changes no result has the reason instead, and is not run:

    raster/plan/casters.c
    - old text
    + new text
    > brute                     or: = why no result changes

    test/program/mutants.py                  all; two at a time
    ONLY=casters.c-1 ./build.sh test full mutants     the first of this file
    ONLY=casters.c ./build.sh test full mutants       all of this file"""
import concurrent.futures
import os
import queue
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

import tap
from tap import check, done

LIST = "test/mutants.list"
BUILD = os.environ.get("BUILD", "build")
TMP = os.path.abspath(os.path.join(os.environ.get("TEST_TMP", "build/tmp"), "mutants"))
WORKERS = int(os.environ.get("WORKERS", "2"))
LONGEST = 300  # seconds of a test: one that takes longer has noticed


class Mutant:
    def __init__(self, block, names):
        self.file, *rest = block.strip("\n").split("\n")
        self.old, self.new, self.tests, self.reason = ("\n".join(line[2:] for line in rest if line.startswith(mark + " "))
                                                       for mark in "-+>=")
        self.tests = self.tests.split()
        name = os.path.basename(self.file)
        names[name] = names.get(name, 0) + 1
        self.name = f"{name}-{names[name]}"
        self.whole = self.old and self.new != self.old and bool(self.tests) != bool(self.reason) and \
            all(line[:2] in ("- ", "+ ", "> ", "= ", "+") for line in rest)


def read_list():
    lines = [line for line in Path(LIST).read_text(encoding="utf-8").split("\n") if not line.startswith("#")]
    names = {}
    return [Mutant(block, names) for block in "\n".join(lines).split("\n\n") if block.strip()]


def copy_tree(to):
    """A copy with its objects, whose times stay, so that nothing is made anew."""
    shutil.rmtree(to, ignore_errors=True)
    here = os.path.abspath(".")
    shutil.copytree(here, to, symlinks=True,
                    ignore=lambda folder, names: {".git", os.path.basename(BUILD)} & set(names) if folder == here else set())
    shutil.copytree(BUILD, os.path.join(to, "build"), symlinks=True,
                    ignore=lambda folder, _: {"tmp", "test-sanitized", "sanitized", "wasm"})
    return to


def run(folder, words, **variables):
    """Returns the status and the output; the status of a test that takes too long is 124."""
    environment = {**os.environ, "BUILD": "build", "TEST_TMP": "build/tmp", **variables}
    for name in "FULL", "ONLY", "SPECTRAL", "LIBRARY", "FAULTS", "MUTANT", "REPLAY", "LIVE", "STATIC", "RESULTS":
        if name not in variables:
            environment.pop(name, None)
    process = subprocess.Popen(words, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                               stdin=subprocess.DEVNULL, start_new_session=True)
    try:
        said = process.communicate(timeout=LONGEST)[0]
        return said, process.returncode
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        return process.communicate()[0], 124


def run_test(folder, test):
    """Runs a test, or one case of it. Returns its status and its output."""
    name, _, case = test.partition(":")
    return run(folder, ["./build.sh", "test", name], JOBS="1", STOP="1", **({"ONLY": case} if case else {}))


def noticed_by(folder, mutant):
    """Plants the fault, and takes it out again. Returns the test that notices it, and what else there is to say."""
    path = Path(folder, mutant.file)
    text = path.read_text(encoding="utf-8")
    if text.count(mutant.old) != 1:
        return None, f"the old text is {text.count(mutant.old)} times in {mutant.file}"
    path.write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
    try:
        for test in mutant.tests:
            said, status = run_test(folder, test)
            if status not in (0, 124) and not re.search("^[0-9]+ passed, ", said, re.M):
                return None, "it does not build: " + said[-800:]
            if status != 0:
                return test, "it takes too long" if status == 124 else \
                    next((line.strip()[:110] for line in said.split("\n") if "not ok" in line), said[-110:])
        return None, "no test of these notices it: " + " ".join(mutant.tests)
    finally:
        path.write_text(text, encoding="utf-8")


def main():
    mutants = read_list()
    faulty = [mutant.name for mutant in mutants if not mutant.whole]
    check(not faulty, "each block of the list has a file, an old text, a new one, and tests or a reason", *faulty)
    wanted = [mutant for mutant in mutants if not tap.ONLY or mutant.name == tap.ONLY[0] or mutant.name.startswith(tap.ONLY[0] + "-")]
    tap.found = bool(wanted)
    planted = [mutant for mutant in wanted if mutant.tests and mutant.whole]
    for mutant in wanted:
        n = Path(mutant.file).read_text(encoding="utf-8").count(mutant.old)
        check(n == 1, f"{mutant.name}: its old text is in {mutant.file} once", n, mutant.old)
    rooms = {os.path.dirname(mutant.file) for mutant in mutants}
    check(tap.ONLY or len([mutant for mutant in mutants if mutant.tests]) >= 80, "at least 80 faults are planted", len(mutants))
    folders = queue.Queue()
    for i in range(min(WORKERS, len(planted))):
        folders.put(copy_tree(os.path.join(TMP, str(i))))

    def in_folder(function, of):
        folder, begun = folders.get(), time.monotonic()
        try:
            return function(folder, of), time.monotonic() - begun
        finally:
            folders.put(folder)
    by_test = {}
    with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
        tests = sorted({test for mutant in planted for test in mutant.tests})
        plain = pool.map(lambda test: in_folder(run_test, test), tests)
        failing = [(test, said[-1000:]) for test, ((said, status), _) in zip(tests, plain) if status != 0]
        check(not failing, f"without a fault {len(tests)} tests and cases hold", *failing)
        for mutant, ((test, remark), seconds) in zip(planted, pool.map(lambda mutant: in_folder(noticed_by, mutant), planted)):
            check(test, f"{mutant.name} is noticed by {test}" if test else f"{mutant.name} is noticed", remark,
                  f"{mutant.file}: {mutant.old} -> {mutant.new}", f"again: ONLY={mutant.name} ./build.sh test full mutants")
            print(f"# {seconds:5.1f} s  {mutant.name}: {remark}", flush=True)
            by_test[test] = by_test.get(test, 0) + 1
    print(f"# {len(planted)} faults in {len(rooms)} rooms; noticed by",
          ", ".join(f"{test} {n}" for test, n in sorted(by_test.items(), key=lambda row: -row[1])))
    shutil.rmtree(TMP, ignore_errors=True)
    done()


main()
