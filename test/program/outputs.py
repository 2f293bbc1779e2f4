#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile; makes: command_table
"""Gives each command all its options that write, alone, in pairs and together, and each of them in the forms of a file, standard
output by both names, a folder and a pipe with a name. An output is written, whole and alone, or refused in one line, and then nothing
is written. Standard output by the name "-" needs no folder that takes files, but for a command that keeps pictures in one. The table
of options is the program's own."""
import concurrent.futures
import itertools
import json
import os
import shutil
import subprocess

import sanitized
from rendered import SPECTRAL, check, done, path_of, run
from sanitized import SLOW, WORDS

ENDINGS = {"STACK.tif": ".tif", "PICTURE.png": ".png", "PAGE.html": ".html", "FILE.hdr": ".hdr", "--check-map": ".png", "--map": ".tif",
           "--maps": ".tif", "--bounds": ".tif"}
FORMS = "file", "-", "/dev/stdout", "folder", "fifo"
STANDARD = FORMS[1:3]
# With FULL=1 an output alone has also each of these names, which may be refused: without a usual ending, in capitals, of a place that
# is not there, of a device. A name that decides the kind of an output decides its content.
NAMES = ["page", "page.xyz", "PAGE.PNG", "PAGE.HTML", "PAGE.TIF", "page.", ".png", ".", "folder/", "missing/page.tif", "", "builtin:page.png",
         "/dev/null", "/dev/full", "page.planes", "page.json"] if "FULL" in os.environ else []


def value_of(option, form, folder):
    """The word behind the option, and the path at which its bytes are found."""
    name = os.path.join(folder, option["names"][-1].strip("-"))
    if form in (*STANDARD, *NAMES):
        return form, None
    if form == "folder":
        os.makedirs(name)
    elif form == "fifo":
        os.mkfifo(name)
    else:
        name += ENDINGS.get(option["value"], ENDINGS.get(option["names"][-1], ""))
    return name, name


def is_whole(option, content):
    """Returns whether the bytes are those of one output. A picture or a stack without an ending is a TIFF."""
    if option["names"][-1] == "--json":
        try:
            return isinstance(json.loads(content), dict)
        except ValueError:
            return False
    heads = {".tif": (b"II*\0",), ".png": (b"\x89PNG", b"II*\0"), ".html": (b"<!DOCTYPE html>",), ".hdr": (b"ENVI",)}
    ending = ENDINGS.get(option["value"], ENDINGS.get(option["names"][-1]))
    return len(content) > 0 and content.startswith(heads.get(ending, (b"",))) and not content.startswith(b'{"') and b'\n{"' not in content


def fault_of(command, words, options, forms):
    """Runs the command once; returns what is wrong, or nothing."""
    folder = os.path.abspath(path_of("_".join([command, str(WORDS[command].index(words)), *(o["names"][-1].strip("-") for o in options),
                               *(form.replace("/", "%") for form in forms)])))
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    named = [value_of(option, form, folder) for option, form in zip(options, forms)]
    readers = [subprocess.Popen(["timeout", "60", "cat", path], stdout=open(path + ".read", "wb"))
               for (_, path), form in zip(named, forms) if form == "fifo"]
    line = [command, *(os.path.abspath(path_of(word)) if os.path.exists(path_of(word)) else word for word in words)]
    for option, (value, _) in zip(options, named):
        line += [option["names"][-1], value]
    none = {"TMPDIR": "/dev/null/none"} if "-" in forms and command not in SLOW else {}
    result = run(*line, text=False, cwd=folder, **none)  # where outputs without a name appear
    says = result.stderr.decode(errors="replace")
    for reader in readers:
        if result.returncode not in (0, 1):
            reader.terminate()
        reader.wait()
    if result.returncode not in (0, 1):
        left = [name for name in os.listdir(folder) if name not in [o["names"][-1].strip("-") for o in options]
                and not name.endswith(".read")]
        good = result.returncode in (2, 3 if "/dev/full" in forms else 2) and says.count("error:") == 1 and not left and not result.stdout
        return None if good else f"{line}: status {result.returncode}, {left}, {says}"
    for option, form, (_, path) in zip(options, forms, named):
        if form == "folder" and option["value"] != "FOLDER":
            return f"{line}: took a folder for {option['names'][-1]}"
        if form in NAMES:
            continue
        path = path + ".read" if form == "fifo" else path
        if form not in STANDARD and option["value"] == "FOLDER":
            content = b"yes" if os.path.isdir(path) else b""
        else:
            content = result.stdout if form in STANDARD else open(path, "rb").read() if os.path.exists(path) else b""
        if not is_whole(option, content):
            return f"{line}: {option['names'][-1]} has {len(content)} bytes: {content[:60]!r}, {says}"
    return None


def trials(command, options):
    """Choices of options and forms: all of them with the first words, and files with the others."""
    for words in WORDS[command]:
        few = command in SLOW or words is not WORDS[command][0]
        for n in {1, 2, len(options)} - {0}:
            for some in itertools.combinations(options, n):
                for forms in itertools.product(FORMS if n <= 2 else ("file",), repeat=n):
                    others = [form for form in forms if form != "file"]
                    if len(others) <= (not few) or (not few and set(others) <= set(STANDARD)):
                        yield words, some, forms
        for option, name in itertools.product(() if command in SLOW else options, NAMES):
            yield words, [option], [name]


def main():
    commands = sanitized.tables()
    check(set(commands) == set(WORDS), "this test has words for each command", set(commands) ^ set(WORDS))
    sanitized.PROGRAM = os.path.abspath(SPECTRAL)
    sanitized.prepare()
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for command, (_, options) in commands.items():
            writing = [option for option in options if option["writes"]]
            each = [] if command in SLOW and "FULL" not in os.environ else list(trials(command, writing))
            faults = [fault for fault in pool.map(lambda trial: fault_of(command, *trial), each) if fault]
            check(not faults, f"{command}: {len(each)} choices of outputs and their forms", *faults[:5])
    done()


main()
