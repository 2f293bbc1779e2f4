# SPDX-License-Identifier: MIT
"""Prints TAP: a line for each truth. A script ends with done(), which exits with 1 if a truth failed.

ONLY=CASE in the environment runs one case of cases(), such as ONLY=faults, or one inside another, such as ONLY=edges/17. STOP=1 ends a
script at the first truth that fails."""
import os
import shlex
import sys

ONLY = os.environ["ONLY"].split("/") if os.environ.get("ONLY") else []
count = failures = 0
found = not ONLY  # the case that ONLY names
path = []  # of the case that is running, and those around it


def check(holds, name, *remarks):
    """Prints the truth, and returns it. Remarks are values that explain a failure; they are printed only if the truth fails."""
    global count, failures
    count += 1
    print("ok" if holds else "not ok", count, "-", name, flush=True)
    if not holds:
        failures += 1
        for remark in remarks:
            print("#", str(remark).replace("\n", "\n# "))
        if path:
            level = "full " if os.environ.get("FULL") else ""
            name = os.path.splitext(os.path.basename(sys.argv[0]))[0]
            print(f"# again: ONLY={shlex.quote('/'.join(path))} ./build.sh test {level}{name}")
        if os.environ.get("STOP"):
            done()
    return holds


def amount(plain, full, soak):
    """The amount that the level asks for: plain, with FULL=1 (`test full`), or with SOAK=1 (`test release`), which takes hours."""
    return soak if os.environ.get("SOAK") else full if os.environ.get("FULL") else plain


def cases(values, name=str):
    """Yields the values of a loop, all, or the one that ONLY names."""
    global found
    for value in values:
        path.append(name(value).replace("/", "-"))
        try:
            if all(wanted == own for wanted, own in zip(ONLY, path)):
                found = found or len(path) >= len(ONLY)
                yield value
        finally:
            path.pop()


def parts(*functions):
    """Calls these functions, each as a case of its name."""
    for function in cases(functions, lambda function: function.__name__):
        function()


def done():
    if not (found or failures):
        check(False, f"a case has the name {'/'.join(ONLY)}")
    print(f"1..{count}")
    sys.exit(failures > 0)


def skip_all(reason):
    """Ends a test that cannot run here."""
    print(f"1..0 # SKIP {reason}")
    sys.exit()


def bail_out(*reason):
    """Ends a test that cannot go on."""
    check(False, "the test can go on", *reason)
    done()
