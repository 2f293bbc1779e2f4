#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full release; packages: python3-numpy python3-tifffile libosmesa6; makes: fail
"""Lets calls fail, one a run, in each command of the program: allocations, system calls, starts of threads and processes.
The result must be the right one, byte by byte, or exit status 3 with one line, where no output has changed and no file is
left; where an allocation fails, the line names memory. Calls that a signal interrupts, and those that move only a half, must
give the right result.

Without SOAK=1 (`test release`) only some calls of each kind are tried. A fault is printed with the words of FAIL that show it again.
Words behind test/program/attack.py are the names of the commands to run. Prints TAP, and what became of all runs."""
import collections
import concurrent.futures
import errno
import os
import queue
import re
import shutil
import sys
import time

from attacked import FORMS, OLDER, TMP, Place, error_lines, faults, results
from tap import check, done

FULL = "SOAK" in os.environ
AT_ONCE = 2
Attack = collections.namedtuple("Attack", "family fail depth")
# family: words of the truth; whether a refusal is right, too
FAMILIES = {
    "own": ("an allocation fails", True),
    "own+": ("all allocations fail from one on", True),
    "gl": ("an allocation of OpenGL's libraries fails", True),
    "start": ("a thread or a process does not start", True),
    "call": ("a system call fails", True),
    "call+": ("all system calls of a kind fail from one on", True),
    "storm": ("system calls are interrupted, or move a half", False),
}
# How many calls of a kind are tried: of allocations, ..., of each system call; first in a quick command.
MOST = {"own": (10 ** 6, 60), "own+": (150, 20), "gl": (200, 12), "start": (100, 10), "call": (10 ** 6, 4),
        "call+": (20, 1)} if FULL else \
       {"own": (24, 2), "own+": (2, 1), "gl": (2, 1), "start": (3, 1), "call": (1, 0), "call+": (0, 0)}
QUOTA = errno.EDQUOT
OTHER_ERRORS = {"open": (5, 12), "write": (5, QUOTA), "pwrite": (5, QUOTA), "fsync": (28,), "ftruncate": (28,), "rename": (28,),
                "link": (5,), "mmap": (11,), "fork": (12,)} if FULL else {}
# Where these fail, an earlier output of the command may have got its name.
NAMING = "rename", "link"
ALLOWED = {"unlink": {"file left"}}  # a file that cannot be removed stays
LACKS = re.compile("memory|MiB|libtiff|thread|shared object")
WITHOUT_TIFF = "plan --json", "list", "show"  # nothing crashes there; elsewhere libtiff does: see trust.md


def spread(count, most, phase):
    """Numbers from 1 to count: all, or `most` of them at equal distances. The phase, from 0 to 1, moves them."""
    if count <= most:
        return range(1, count + 1)
    return [1 + int((i + phase) * count / most) for i in range(most)]


def attacks_of_kind(kind, count, depth, slow, phase):
    def tries(family):
        return spread(count, MOST[family][slow], phase)
    if kind in ("own", "gl"):
        for n in tries(kind):
            yield Attack(kind, f"{kind}:{n}", depth)
        for n in tries("own+") if kind == "own" else ():
            yield Attack("own+", f"own:{n}+", depth)
        return
    if kind in ("thread", "fork"):
        for n in tries("start"):
            yield Attack("start", f"{kind}:{n}", depth)
            yield Attack("start", f"{kind}:{n}+", depth)
        return
    for n in tries("call"):
        yield Attack("call", f"{kind}:{n}", depth)
        for error in OTHER_ERRORS.get(kind, ()):
            yield Attack("call", f"{kind}:{n}:{error}", depth)
    for n in tries("call+"):
        yield Attack("call+", f"{kind}:{n}+", depth)


def attacks(form, counts, phase):
    first = FORMS.index(form) % 2
    for depth, kinds in counts.items():
        for i, (kind, count) in enumerate(sorted(kinds.items())):
            # without SOAK=1, one command tries every second kind of calls, and the next command the others
            if count > 0 and kind and (FULL or i % 2 == first or kind in ("own", "gl", "thread", "fork")):
                yield from attacks_of_kind(kind, count, depth, form.slow, phase)
    storms = ("short:1", "short:2") if form.uses_egl else ("eintr:2", "eintr:3", "short:1", "short:2")
    for fail in storms[:1 if form.slow else 4]:
        yield Attack("storm", fail, None)


def remark(attack, run, found):
    return f"{attack.fail} of generation {attack.depth}: {', '.join(sorted(found))}; status {run.status}" \
        f"{''.join(' ' + line[:160] for line in error_lines(run)[:2])} {' '.join(run.temporary)}"


def prepare(form, places):
    """The results of a form when nothing fails, its counts of calls, and the seconds after which another run hangs. The
    second run is in the other folder."""
    start = time.monotonic()
    places[0].run(form, counted=False)  # fills the drivers' cache
    expected = results(form, places[0].run(form, counted=False))
    counted = places[1].run(form, older=True)
    check(results(form, counted) == expected and not faults(form, counted, expected, True) and expected[0] in (0, 1, 2),
          f"{form.name}: nothing fails: the same result in another folder, over older files", counted.stderr,
          f"status {expected[0]}, then {counted.status}")
    return (expected, {depth: counted.report.counts[depth] for depth in sorted(counted.report.counts)},
            20 + 8 * (time.monotonic() - start))  # a driver that lacks threads is given ten seconds


def is_seen(form, run):
    """OpenGL may lack memory and report no error. --version says so, and the check finds what was drawn: then no file but the
    map has changed."""
    unchanged = all(data == OLDER for name, data in run.files.items() if not name.startswith("out/map."))
    return form.name == "--version" and b"OpenGL cannot draw: " in run.stdout or \
        run.status == 1 and "error: the pictures differ at" in run.stderr and unchanged


def attempt(place_queue, form, attack, older, expected, longest):
    place = place_queue.get()
    try:
        run = place.run(form, attack.fail, attack.depth, older, longest=longest)
        kind = attack.fail.split(":")[0]
        found = faults(form, run, expected, older, kind in NAMING) - ALLOWED.get(kind, set())
        if (kind == "gl" or form.name == "--version") and is_seen(form, run):
            found = set()
        if kind == "own" and run.status == 3 and not (LACKS.search(run.stderr) and not (
                form.name.startswith(WITHOUT_TIFF) and "crashed" in run.stderr)):
            found = found | {"wrong words"}
        if not FAMILIES[attack.family][1] and run.status == 3 and expected[0] != 3:
            found = found | {"wrong status"}
        # pictures would fill the memory
        return run._replace(stdout=None, files=None), found
    finally:
        place_queue.put(place)


def main():
    forms = [form for form in FORMS if not sys.argv[1:] or form.name in sys.argv[1:]]
    shutil.rmtree(TMP, ignore_errors=True)
    places = [Place(0)]
    places += [Place(i, places[0].path("in")) for i in range(1, AT_ONCE)]
    place_queue = queue.Queue()
    for place in places:
        place_queue.put(place)
    became = collections.defaultdict(collections.Counter)
    with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
        for i, form in enumerate(forms):
            expected, counts, longest = prepare(form, places)
            # older files lie there in every second run
            jobs = [(attack, pool.submit(attempt, place_queue, form, attack, j % 2 == 1, expected, longest))
                    for j, attack in enumerate(attacks(form, counts, (i * 0.381966 + 0.2) % 1))]
            for family, (words, may_refuse) in FAMILIES.items():
                tried = [(attack, *job.result()) for attack, job in jobs if attack.family == family]
                for _, run, found in tried:
                    became[family].update(found or ["right result" if run.status == expected[0] else "exit 3"])
                wrong = [remark(*row) for row in tried if row[2]]
                if tried:
                    check(not wrong, f"{form.name}: {words}: the right result{' or none' if may_refuse else ''}",
                          f"{len(wrong)} of {len(tried)}", *wrong[:None if FULL else 20])
    for family, sums in became.items():
        print(f"# {family}:", ", ".join(f"{what} {n}" for what, n in sums.items()))
    shutil.rmtree(TMP, ignore_errors=True)
    done()


main()
