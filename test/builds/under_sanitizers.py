#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile; makes: command_table sanitized library faults fail
"""The program under sanitizers takes the place of the program in scripts of `test full`, and runs command lines at random for
an hour. What the scripts expect besides does not count here: the sanitized program is slower and needs more memory, so that
some of them fail. A finding is in the words of standard error, which the program writes into files of ASAN_OPTIONS' log_path."""
import glob
import os
import subprocess

from sanitized import ENVIRONMENT, FOUND, PROGRAM, TMP
from tap import check, done

SCRIPTS = ["data/text/names.sh", "program/bad.sh", "program/cli.sh", "program/seldom.sh", "raster/beside/see/seeing.sh"]

os.makedirs(TMP, exist_ok=True)
for old in glob.glob(os.path.join(TMP, "found.*")):
    os.unlink(old)
log = f":log_path={TMP}/found"
environment = dict(ENVIRONMENT, SPECTRAL=PROGRAM, ASAN_OPTIONS=ENVIRONMENT["ASAN_OPTIONS"] + log, UBSAN_OPTIONS=f"exitcode={FOUND}" + log)
for script in SCRIPTS:
    ran = subprocess.run(["test/" + script], env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, text=True)
    found = glob.glob(os.path.join(TMP, "found.*"))
    truths = ran.stdout.count("\nok "), ran.stdout.count("\nnot ok ")
    check(not found and sum(truths) > 0, f"{script}: no finding; {truths[0]} truths hold, {truths[1]} do not",
          *[open(name, encoding="utf-8", errors="replace").read()[:3000] for name in found[:3]], ran.stdout[-500:] if not sum(truths) else "")
    for name in found:
        os.unlink(name)
lines = subprocess.run(["test/program/lines.py"], env=dict(os.environ, SECONDS_OF_LINES="3600"), stdout=subprocess.PIPE, check=False, text=True)
check(lines.returncode == 0, "an hour of command lines at random", lines.stdout[-5000:])
done()
