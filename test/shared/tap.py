# SPDX-License-Identifier: MIT
"""Prints TAP: a line for each truth. A script ends with done(), which exits with 1 if a truth failed."""
import sys

count = failures = 0


def check(holds, name, *remarks):
    """Prints the truth. Remarks are values that explain a failure; they are printed only if the truth fails."""
    global count, failures
    count += 1
    print("ok" if holds else "not ok", count, "-", name, flush=True)
    if not holds:
        failures += 1
        for remark in remarks:
            print("#", str(remark).replace("\n", "\n# "))


def done():
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
