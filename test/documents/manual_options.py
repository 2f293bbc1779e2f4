# SPDX-License-Identifier: MIT
"""usage: spectral --help | manual_options.py spectral.1

Prints the manual page with the list of options that --help prints. The page's own explanation of an option, from its
.Pp on, is kept."""
import re
import sys

HEADING = re.compile(r"([a-z].*):$")
OPTION = re.compile(r"  (-\S*(?: \S+)*)(?:  +(\S.*))?$")
CONTINUED = re.compile(r" {34}(\S.*)$")


def head(usage):
    """-o, --output FILE: .It Fl o , -output Ar FILE"""
    words = [".It Fl"]
    for word in usage.split():
        name = word.rstrip(",")
        words += [name[1:] if name[0] == "-" else ("Ar " if name[0].isupper() else "Cm ") + name]
        words += [","] * word.endswith(",")
    return " ".join(words)


def explanations(lines):
    """{(heading, head of the option): lines}"""
    found, place, depth, explains = {}, ("", ""), 0, False
    for line in lines:
        depth += line.startswith(".Bl") - line.startswith(".El")
        if line.startswith(".Ss "):
            place = (line, "")
        if depth == 0 or line.startswith(".It Fl"):
            place, explains = (place[0], line), False
        explains = explains or line == ".Pp"
        if explains:
            found.setdefault(place, []).append(line)
    return found


def renewed(help_lines, explained):
    heading = option = ""
    for line in help_lines:
        starts, text = HEADING.match(line), OPTION.match(line) or CONTINUED.match(line)
        if starts or text and text.re is OPTION or not text:
            yield from explained.get((heading, option), [])
            option = ""
        if heading and not text:
            yield ".El"
            heading = ""
        if starts:
            heading = f".Ss {starts[1]}"
            yield from (heading, ".Bl -tag -width Ds")
        elif heading:
            if text.re is OPTION:
                option = head(text[1])
                yield option
            if text.re is CONTINUED or text[2]:
                line = re.sub(r"(?<!\S)-+", lambda dashes: r"\-" * len(dashes[0]), text[text.lastindex])
                yield re.sub(r"^(?=[.'])", r"\\&", line)


with open(sys.argv[1], encoding="utf-8") as file:
    before, options, after = re.split(r"^(\.Ss .*)(?=\.Sh SCENES)", file.read(), flags=re.M | re.S)
listed = renewed(sys.stdin.read().splitlines(), explanations(options.splitlines()))
print(before + "\n".join(listed) + "\n" + after, end="")
