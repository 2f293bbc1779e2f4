# SPDX-License-Identifier: MIT
"""Helps scripts that run each command of the program, most under sanitizers: the tables of commands and options, files for
them to read, and runs that separate findings from refusals."""
import os
import re
import resource
import shutil
import subprocess
import sys

from tap import bail_out

BUILD = os.path.abspath(os.environ.get("BUILD", "build"))
PROGRAM = os.path.join(BUILD, "test/spectral-sanitized")
TMP = os.path.join(os.path.abspath(os.environ.get("TEST_TMP", "build/tmp")), os.path.splitext(os.path.basename(sys.argv[0]))[0])
FOUND = 99  # the status of a finding
# Mesa keeps memory until the process ends. The program has a handler of its own for a wrong access, which exits with 3.
ENVIRONMENT = dict(os.environ, TMPDIR=TMP, UBSAN_OPTIONS=f"print_stacktrace=1:exitcode={FOUND}",
                   ASAN_OPTIONS=f"exitcode={FOUND}:detect_leaks=0:allocator_may_return_null=1:handle_segv=2:use_sigaltstack=0")


def tables():
    """Returns {command: (operands, [option])}. An option is a dictionary."""
    found = {}
    for line in subprocess.run([f"{BUILD}/test/command_table"], stdout=subprocess.PIPE, check=True, text=True).stdout.splitlines():
        row, *words = line.split("\t")
        if row == "command":
            options = []
            found[words[0]] = int(words[1]), options
        else:
            usage, kind, lowest, highest, writes, choices = words
            names = re.findall(r"(?:^|, )(--?[\w-]+)", usage)
            options.append({"names": names, "value": usage.partition(names[-1])[2].strip(), "kind": kind, "lowest": float(lowest),
                            "highest": float(highest), "writes": writes == "writes", "choices": choices.split()})
    return found


def limit_files():
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 26, 1 << 26))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run(words, seconds=600):
    """Runs the program in TMP. Returns status (None: it took too long), standard output, and the words of standard error."""
    try:
        done = subprocess.run([PROGRAM, *words], cwd=TMP, env=ENVIRONMENT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, timeout=seconds, check=False, preexec_fn=limit_files)
    except subprocess.TimeoutExpired:
        return None, b"", ""
    return done.returncode, done.stdout, done.stderr.decode(errors="replace")


def finding(status, errors):
    """Returns whether a sanitizer found something, or a signal ended the program."""
    return status is not None and (status not in (0, 1, 2, 3) or "runtime error:" in errors or "Sanitizer" in errors)


SMALL = "--size", "16x12", "--wavelengths", "500:600:50"
# The words that let a command come to its outputs quickly, with the files below. A command may write in several forms.
WORDS = {"render": [["patches", *SMALL, "-q"], ["--again", "stack.tif", "-q"]],
         "develop": [["stack.tif"], ["stack.tif", "--xyz"], ["stack.tif", "--raw", "--detector", "cie1931"]],
         "probe": [["stack.tif", "3", "3"], ["patches", "3", "3", *SMALL], ["stack.tif", "--objects", "--csv"], ["stack.tif", "3", "3", "--svg"],
                   ["stack.tif", "1", "1", "--against", "3", "3"]],
         "compare": [["stack.tif", "other.tif", "--tolerance", "100%"]], "view": [["patches", *SMALL], ["stack.tif"]],
         "plan": [["patches", *SMALL]], "cost": [["my.scene", "--size", "4x3", "--wavelengths", "500", "-q"]], "verify": [["my.scene", "-q"], ["patches", "--list"]],
         "info": [["stack.tif"], ["picture.tif"]], "list": [["scenes"]], "show": [["patches"], ["d65", "--csv"], ["d65", "--svg"]],
         "join": [["part.tif"]], "envi": [["stack.tif"]], "drivers": [[]], "export": [["patches", *SMALL]], "judge": [["exported", "-q"]]}
SLOW = "cost", "verify", "drivers"


def prepare():
    """Makes TMP anew, with files to read."""
    shutil.rmtree(TMP, ignore_errors=True)
    os.makedirs(os.path.join(TMP, "folder"))
    for words in (["render", "patches", *SMALL, "-q", "-o", "stack.tif"],
                  ["render", "patches", *SMALL, "-q", "--renderer", "raster", "-o", "other.tif"],
                  ["render", "patches", "--size", "16x12", "-q", "--sampling", "rgb", "-o", "rgb.tif"],
                  ["develop", "stack.tif", "-q", "-o", "picture.tif"], ["develop", "stack.tif", "-q", "-o", "picture.png"],
                  ["render", "patches", *SMALL, "-q", "--part", "1/1", "-o", "part.tif"],
                  ["show", "patches", "-o", "my.scene"], ["export", "patches", *SMALL, "-o", "exported"]):
        status, _, errors = run(words)
        if status != 0:
            bail_out(" ".join(words), status, errors)
    with open(os.path.join(TMP, "exported/scene.txt")) as exported, open(os.path.join(TMP, "exported/drawn.txt"), "w") as drawn:
        drawn.write(re.search("^id .*\n", exported.read(), re.MULTILINE)[0])
    with open(os.path.join(TMP, "exported/colours-0.bin"), "wb") as colours:
        colours.write(bytes(16 * 12 * 16))  # a black picture, for judge
