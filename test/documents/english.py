#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first
"""Plain English: no idiom of IDIOMS stands in a document, in the manual, in a comment, or in a message of
the program, and no comment opens with a word of OPENINGS. The last part plants each of them, and finds it.
Prints TAP.

    test/documents/english.py             the test
    test/documents/english.py FILE...     the findings in these files"""
import glob
import os
import re
import sys

from tap import check, done

# A reader must parse these twice; CONTRIBUTING.md shows how to say it.
IDIOMS = re.compile(r"\b((?i:tells?|telling|told|whom|gives? off|given off|has of|have of|of which|that which|"
                    r"knows? of|known of|nothing that there is)|[Ww]hat is (?:no|not|a|an|the|of|\w+(?:ed|wn|en)))\b")
OPENINGS = re.compile(r"(What|Whether|Which|Whose|Whom|Of|The same|Those|That of)\b")
# In sources, only comments and strings are English.
C_PROSE = re.compile(r'/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.DOTALL)
SCRIPT_PROSE = re.compile(r'"""(.*?)"""|(?:^|[ \t])(#[^\n]*)', re.DOTALL | re.MULTILINE)
# Rows of these tables are examples of what not to write.
EXAMPLES = re.compile(r"\| before \| after \|\n(?:\|.*\n)*")


def blank(match):
    return re.sub(r"[^\n]", " ", match.group())


def prose(path, text):
    """[(offset, text, whether a comment begins here)]"""
    if path.endswith((".c", ".h")):
        return [(found.start(), found.group(), found.group()[0] == "/") for found in C_PROSE.finditer(text)]
    if path.endswith((".py", ".sh")) and os.path.basename(path) != "english.py":
        found = [(match.start(), match.group().strip()) for match in SCRIPT_PROSE.finditer(text)]
        return [(at, words, begins_comment(text, at, words)) for at, words in found]
    return [] if path.endswith((".py", ".sh")) else [(0, EXAMPLES.sub(blank, text), False)]


def begins_comment(text, at, words):
    """A line of a comment in a script continues the one above it."""
    above = text[:at].rstrip("\n").rpartition("\n")[2] if words[0] == "#" else ""
    return not above.lstrip().startswith("#")


def findings(path, text):
    """FILE:LINE: words, for each idiom and opening."""
    for at, words, opens in prose(path, text):
        line = text.count("\n", 0, at) + 1
        flat = re.sub(r"\n[ \t]*[*#]?", "\n", words)
        for found in IDIOMS.finditer(re.sub(r"\s", " ", flat)):
            yield f"{path}:{line + flat.count(chr(10), 0, found.start())}: \"{found.group()}\""
        opening = OPENINGS.match(words.lstrip('/*#" -\n\t')) if opens else None
        if opening:
            yield f"{path}:{line}: opens with \"{opening.group()}\""


def sources(top):
    for folder, folders, names in os.walk(top):
        folders.sort()
        if not folder.startswith(("data/builtin", "test/cases")):
            yield from (os.path.join(folder, name) for name in sorted(names)
                        if name.endswith((".c", ".h", ".md", ".py", ".sh")))


GROUPS = {
    "the documents": ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"),
    "the manual": ("spectral.1", "spectral.5"),
    "the viewer's page": tuple(sorted(glob.glob("data/builtin/viewer/*"))),
    "the program": ("spectral.c", "spectral.h", "build.sh", *sources("data"), *sources("raster")),
    "the tests": sources("test"),
}


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def check_planted():
    for path, text in (("a.c", "int x; /* The page tells its wavelength. */"), ("a.c", 'say("what is no\\n")'),
                       ("a.c", 'say("for whom")'), ("a.h", "/* Whether it\n * holds. */"), ("a.md", "The lamp gives\noff light."),
                       ("a.py", '"""What it is."""'), ("a.py", "x = 1  # it is told"), ("a.sh", "# Of all.\nrun")):
        found = list(findings(path, text))
        check(len(found) == 1, f"planted, and found: {text!r}", *found)
    for path, text in (("a.c", "int told = tell(whom);"), ("a.py", "told = 1\n# a line\n# of which what is left"),
                       ("a.md", "| before | after |\n|---|---|\n| Of which it tells. | Its sum. |\n")):
        found = [each for each in findings(path, text) if "of which" not in each]
        check(not found, f"planted, and allowed: {text!r}", *found)


def main():
    if len(sys.argv) > 1:
        print(*(found for path in sys.argv[1:] for found in findings(path, read(path))), sep="\n")
        return
    for name, paths in GROUPS.items():
        found = [each for path in paths for each in findings(path, read(path))]
        check(not found, f"plain English: {name}", *found)
    check_planted()
    done()


main()
