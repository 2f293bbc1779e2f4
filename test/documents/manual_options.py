# SPDX-License-Identifier: MIT
"""usage: manual_options.py spectral spectral.1

Prints the manual page with the list of options that spectral COMMAND --help prints for all commands: options that the
same commands have stand together. The page's own explanation of an option, from its .Pp on, is kept."""
import collections
import re
import subprocess
import sys

COMMAND = re.compile(r"^  ([a-z]+) ", re.MULTILINE)
OPTION = re.compile(r"^  (-\S*(?: \S+)*)((?:  +\S.*)?(?:\n {34}\S.*)*)$", re.MULTILINE)


def help_of(*words):
    return subprocess.run([sys.argv[1], *words, "--help"], capture_output=True, text=True, check=True).stdout


def head(usage):
    """-o, --output FILE: .It Fl o , -output Ar FILE"""
    words = [".It Fl"]
    for word in usage.split():
        name = word.rstrip(",")
        words += [name[1:] if name[0] == "-" else ("Ar " if name[0].isupper() else "Cm ") + name]
        words += [","] * word.endswith(",")
    return " ".join(words)


def explanations(lines):
    """{head of an option: [(heading, lines), ...]}"""
    found, heading, option, depth = collections.defaultdict(list), "", "", 0
    for line in lines:
        depth += line.startswith(".Bl") - line.startswith(".El")
        if line.startswith(".Ss "):
            heading = line
        elif line.startswith(".It Fl") and depth == 1:
            option, explains = line, False
        elif depth > 0 and option:
            explains = explains or line == ".Pp"
            if explains and not found[option] or explains and found[option][-1][0] != heading:
                found[option].append((heading, []))
            if explains:
                found[option][-1][1].append(line)
    return found


def listed():
    """{commands: [(usage, lines of help), ...]}, by the first command that has an option"""
    commands, users = COMMAND.findall(help_of()), collections.defaultdict(list)
    for command in commands:
        for usage, text in OPTION.findall(help_of(command)):
            users[usage, tuple(text.split("\n"))].append(command)
    groups = collections.defaultdict(list)
    for (usage, lines), group in users.items():
        groups["all" if group == commands else ", ".join(group)].append((usage, [line.strip() for line in lines if line.strip()]))
    return groups


def shared(heading, group):
    """how many commands an option's old heading shares with its new one"""
    return len(set(re.findall(r"[a-z]+", heading)) & set(re.findall(r"[a-z]+", group)))


def renewed(explained):
    for group, options in listed().items():
        heading = f".Ss {group}"
        yield from (heading, ".Bl -tag -width Ds")
        for usage, lines in options:
            yield head(usage)
            for line in lines:
                yield re.sub(r"^(?=[.'])", r"\\&", re.sub(r"(?<!\S)-+", lambda dashes: r"\-" * len(dashes[0]), line))
            yield from max(explained[head(usage)], key=lambda own: shared(own[0], group), default=("", []))[1]
        yield ".El"


with open(sys.argv[2], encoding="utf-8") as file:
    before, options, after = re.split(r"^(\.Ss .*)(?=\.Sh ENVIRONMENT)", file.read(), flags=re.M | re.S)
print(before + "\n".join(renewed(explanations(options.splitlines()))) + "\n" + after, end="")
