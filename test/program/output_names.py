#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; makes: command_table sanitized
"""All commands, with each option that writes a file, and each kind of name: none of the usual endings, an unknown ending,
capitals, standard output, a folder, a device. The program runs under sanitizers: a value that stands for "none" and is
used as an index is found even where the memory there can be read. A refusal is one line, and leaves no file. Words behind the
script are commands: those alone."""
import os
import shutil
import sys

from sanitized import SLOW, TMP, WORDS, finding, prepare, run, tables
from tap import check, done

NAMES = ["page", "-", "page.xyz", "PAGE.PNG", "PAGE.HTML", "PAGE.TIF", "page.", ".png", ".", "folder", "folder/", "missing/page.tif",
         "", "stack.tif", "builtin:page.png", "/dev/null", "/dev/full", "/dev/stdout", "page.planes", "page.json"]


def files():
    """Returns all files in TMP, with their sizes and times."""
    found = {}
    for folder, _, names in os.walk(TMP):
        for name in names:
            path = os.path.join(folder, name)
            status = os.stat(path)
            found[path] = status.st_size, status.st_mtime_ns
    return found


def check_name(command, words, option, name):
    """Returns a word for a row of the table."""
    shutil.copytree(TMP, TMP + ".before", dirs_exist_ok=True)
    before = files()
    status, _, errors = run([command, *words, option, name])
    same = status in (0, 1) or files() == before  # judge writes what differs
    line = [line for line in errors.splitlines() if "error:" in line]
    said = status in (0, 1) or len(line) == 1
    good = status is not None and not finding(status, errors) and same and said
    if not good:
        check(False, f"spectral {command} {' '.join(words)} {option} '{name}'", f"status {status}", errors[-3000:],
              "" if same else "a file has changed")
    shutil.rmtree(TMP)
    shutil.move(TMP + ".before", TMP)
    return str(status) if good else "FAILS"


prepare()
print("# the exit status for each name:", " ".join(f"'{name}'" for name in NAMES))
COMMANDS = tables()
check(set(COMMANDS) == set(WORDS), "this test has words for each command", set(COMMANDS) ^ set(WORDS))
for command, (_, options) in COMMANDS.items():
    for row in options if command in (sys.argv[1:] or WORDS) else []:
        for words in WORDS[command] if row["writes"] else []:
            answers = [check_name(command, words, row["names"][-1], name) for name in (NAMES[:3] if command in SLOW else NAMES)]
            check("FAILS" not in answers, f"{command} {' '.join(words)} {row['names'][-1]}: {' '.join(answers)}")
done()
