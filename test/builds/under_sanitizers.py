#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile python3-pil python3-gdal python3-scipy python3-junitparser gdal-bin pngcheck mandoc bsdextrautils parallel make liblcms2-utils glmark2-data colord-data psychtoolbox-3-common libosmesa6-dev; makes: command_table sanitized library faults fail spoil calls mutant mutants
"""The program under sanitizers takes the place of the program in the scripts of the first level and of `test full`, and runs
command lines at random for an hour. What the scripts expect besides does not count here: the sanitized program is slower and
needs more memory, so that some of them fail. A finding is in the words of standard error, which the program writes into files
of log_path; that the sanitizer itself lacks memory, or cannot start, is none. Words behind the script are scripts: those
alone, and no lines."""
import glob
import os
import re
import subprocess
import sys

from sanitized import ENVIRONMENT, FOUND, PROGRAM, TMP
from tap import check, done

USES = re.compile(r"SPECTRAL\b|^from rendered import", re.MULTILINE)
LEFT_OUT = {"builds": "they build other programs", "program/memory.py": "it measures memory",
            "raster/beside/cost/cost.py": "it measures time", "program/mutants.py": "it builds other programs"}


def scripts():
    """The scripts of the first level and of `full` that run the program."""
    for path in sorted(glob.glob("test/**/*.sh", recursive=True) + glob.glob("test/**/*.py", recursive=True)):
        text = open(path, encoding="utf-8").read()
        left_out = any(path.startswith("test/" + left) for left in LEFT_OUT)
        if re.search("^# level: (first|full)", text, re.MULTILINE) and USES.search(text) and not left_out:
            yield path


def findings():
    """Returns the findings that the program has written, and removes their files."""
    written = []
    for name in glob.glob(os.path.join(TMP, "found.*")):
        written.append(open(name, encoding="utf-8", errors="replace").read())
        os.unlink(name)
    return [words for words in written if re.search("runtime error: |ERROR: AddressSanitizer: ", words)]


linked = subprocess.run(["ldd", PROGRAM], stdout=subprocess.PIPE, check=True, text=True).stdout
check("libtiff" in linked and "san.so" not in linked, "both sanitizers are in the program, and write into log_path", linked)
os.makedirs(TMP, exist_ok=True)
findings()
log = f":log_path={TMP}/found:verify_asan_link_order=0"  # scripts preload libraries of their own
environment = dict(ENVIRONMENT, SPECTRAL=PROGRAM, ASAN_OPTIONS=ENVIRONMENT["ASAN_OPTIONS"] + log, UBSAN_OPTIONS=f"exitcode={FOUND}" + log)
for script in sys.argv[1:] or scripts():
    ran = subprocess.run([script], env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, text=True)
    found = findings()
    truths = ran.stdout.count("\nok "), ran.stdout.count("\nnot ok ")
    check(not found and sum(truths) > 0, f"{script}: no finding; {truths[0]} truths hold, {truths[1]} do not",
          *[words[:3000] for words in found[:3]], ran.stdout[-500:] if not sum(truths) else "")
if sys.argv[1:]:
    sys.exit(done())
lines = subprocess.run(["test/program/lines.py"], env=dict({"SECONDS_OF_LINES": "3600"}, **os.environ), stdout=subprocess.PIPE, check=False, text=True)
check(lines.returncode == 0, "an hour of command lines at random", lines.stdout[-5000:])
done()
