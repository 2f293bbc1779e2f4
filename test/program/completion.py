#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: zsh fish
"""Completion of command lines, in real bash, zsh and fish. Bash and zsh run in a terminal. The test types the begin of
a line, presses a key that inserts all completions, and a key that writes the line to a file."""
import os
import pty
import re
import subprocess
import time
from pathlib import Path

from tap import check, done

PROGRAM = os.path.realpath(os.environ.get("SPECTRAL", "build/spectral"))
FOLDER = os.path.join(os.environ.get("TEST_TMP", "build/tmp"), "completion")
SOURCES = os.path.realpath("data/completion")
ALL, DUMP, CLEAR = b"\x18a", b"\x18d", b"\x15"  # keys: C-x a, C-x d, C-u

BASH = r"""
source {sources}/spectral.bash
bind 'set disable-completion off' 'set completion-query-items 0'
bind '"\C-xa": insert-completions'
bind -x '"\C-xd": printf "%s." "$READLINE_LINE" >dump.new && mv dump.new dump'
"""
ZSH = r"""
fpath=({sources} $fpath)
autoload -Uz compinit && compinit -u -D
zle -C all complete-word _generic
zstyle ':completion:all:*' completer _all_matches _complete
zstyle ':completion:all:*' insert yes
bindkey -e
bindkey '^Xa' all
write-line() {{ print -rn -- "$BUFFER." >dump.new && mv dump.new dump }}
zle -N write-line
bindkey '^Xd' write-line
"""


class Shell:
    """A shell in a terminal, in FOLDER. ready: a file that it makes when it has read its settings."""

    def __init__(self, command, settings):
        self.pid, self.terminal = pty.fork()
        if self.pid == 0:
            os.chdir(FOLDER)
            path = os.path.dirname(PROGRAM) + ":" + os.environ["PATH"]
            os.environ.update(TERM="dumb", PATH=path, INPUTRC="/dev/null")
            os.execvp(command[0], command)
        Path(FOLDER, "settings").write_text(settings, encoding="utf-8")
        self.answer("source ./settings; echo . >dump\r".encode())

    def answer(self, keys, seconds=20):
        """Types keys, and returns the content of the file `dump` that the shell then makes."""
        dump = Path(FOLDER, "dump")
        dump.unlink(missing_ok=True)
        os.write(self.terminal, keys)
        os.set_blocking(self.terminal, False)
        end = time.monotonic() + seconds
        screen = b""
        while time.monotonic() < end:
            try:
                screen += os.read(self.terminal, 65536)
            except BlockingIOError:
                time.sleep(0.002)
            if dump.exists():
                return dump.read_text(encoding="utf-8").strip().removesuffix(".")
        return "no answer; the screen: " + repr(screen[-300:])

    def completions(self, line):
        """The words that may stand for the last word of the line, and the seconds until they are there."""
        start = time.monotonic()
        answer = self.answer(line.encode() + ALL + DUMP)
        seconds = time.monotonic() - start
        self.answer(CLEAR + DUMP)
        before = line[:len(line) - len(line.split(" ")[-1])]
        return sorted(set(answer.removeprefix(before).split())), seconds

    def end(self):
        os.close(self.terminal)
        os.waitpid(self.pid, 0)


class Fish:
    """fish prints the completions of a line without a terminal."""

    @staticmethod
    def completions(line):
        start = time.monotonic()
        environment = dict(os.environ, PATH=os.path.dirname(PROGRAM) + ":" + os.environ["PATH"])
        command = ["fish", "--no-config", "-c", f"source {SOURCES}/spectral.fish; complete -C '{line}'"]
        text = subprocess.run(command, cwd=FOLDER, env=environment, stdout=subprocess.PIPE, check=True).stdout.decode()
        return sorted({word.rstrip("/") for word in text.split()}), time.monotonic() - start

    def end(self):
        pass


def listed(kind):
    text = subprocess.run([PROGRAM, "list", kind], stdout=subprocess.PIPE, check=True).stdout.decode()
    return sorted(line[2:] for line in text.splitlines()[1:])


def program_words(*words):
    """The commands, or the options of a command, as --help prints them."""
    text = subprocess.run([PROGRAM, *words, "--help"], stdout=subprocess.PIPE, check=True).stdout.decode()
    rows = [line for line in text.splitlines() if line.startswith("  ") and line[2] != " "]
    if not words:
        return sorted(row.split()[0] for row in rows if row[2].isalpha())
    usages = [row[2:].split("  ")[0] for row in rows if row[2] == "-"]
    return sorted(word.rstrip(",") for usage in usages for word in usage.split() if word.startswith("-"))


STACKS = ["a.tif", "folder", "two.tif"]
CASES = [
    ("spectral re", ["render"]),
    ("spectral ", program_words()),
    ("spectral help de", ["develop"]),
    ("spectral -", ["--help", "--version"]),
    ("spectral render --ren", ["--renderer"]),
    ("spectral render -", program_words("render")),
    ("spectral info -", program_words("info")),
    ("spectral render --renderer ", ["es-shader", "gl", "gl-shader", "llvmpipe", "raster", "softpipe"]),
    ("spectral render --buffer ", ["10", "16", "8", "float"]),
    ("spectral render --sampling ", ["adaptive:", "basis:", "box:", "gauss:", "rgb", "riemann:", "xyz"]),
    ("spectral render --sampling ga", ["gauss:"]),
    ("spectral render --detector cie2", ["cie2006-10", "cie2006-2"]),
    ("spectral render p", ["pasture", "patches"]),
    ("spectral render -q -j 2 me", ["metals", "metamers"]),
    ("spectral render m", ["metals", "metamers", "my.scene"]),
    ("spectral render patches p", []),
    ("spectral list ", None),
    ("spectral list te", ["textures"]),
    ("spectral show metals/", ["metals/aluminium", "metals/copper", "metals/gold", "metals/silver"]),
    ("spectral show she", ["sheep"]),
    ("spectral develop ", STACKS),
    ("spectral develop tw", ["two.tif"]),
    ("spectral develop --adaptation ", ["bradford", "cat16", "fairchild", "none", "von-kries"]),
    ("spectral develop --exposure ", ["auto"]),
    ("spectral compare a.tif ", STACKS),
    ("spectral compare --tolerance ", []),
    ("spectral probe pat", ["patches"]),
    ("spectral view -o ", ["folder", "page.html", "seen.png"]),
    ("spectral develop -o ", ["a.tif", "folder", "seen.png", "two.tif"]),
]


def same_words(found, expected, line):
    if expected is None:
        lists = subprocess.run([PROGRAM, "list"], stdout=subprocess.PIPE, check=True).stdout.decode().splitlines()
        expected = sorted(name for name in lists if name[0] != " ")
    last = line.split(" ")[-1]
    return found == expected or expected == [] and found == ([last] if last else [])


def describe(expected):
    if expected is None:
        return "the lists"
    return f"{len(expected)} words" if len(expected) > 8 else " ".join(expected) or "nothing"


def test_shell(name, shell):
    times = []
    for line, expected in CASES:
        found, seconds = shell.completions(line)
        times.append(seconds)
        check(same_words(found, expected, line), f"{name}: {line}<TAB> offers {describe(expected)}", found)
    for line, before, kind in (("spectral render --light 1=", "1=", "illuminants"),
                               ("spectral render --light=1=", "--light=1=", "illuminants")):
        found = [word.removeprefix(before) for word in shell.completions(line)[0]]
        check(set(listed(kind)) <= set(found), f"{name}: {line}<TAB> offers the {kind}", found)
    found, _ = shell.completions("spectral render --renderer=r")
    check(found == ["--renderer=raster"], f"{name}: --renderer=r<TAB> completes the value", found)
    times.sort()
    print(f"# {name}: {times[0]:.3f} s, {times[len(times) // 2]:.3f} s (median), {times[-1]:.3f} s")
    check(times[len(times) // 2] < 0.2, f"{name}: half of the answers take less than 0.2 s")
    shell.end()


MORE_WORDS = {"probe": ("1", "1"), "judge": ("1",), "export": ("-o", "1")}  # that a command needs behind the scene


def test_choices():
    """The words of a usage, which the shells offer, are those that the program accepts."""
    for command in program_words():
        text = subprocess.run([PROGRAM, command, "--help"], stdout=subprocess.PIPE, check=True).stdout.decode()
        for option, words in re.findall(r"^  .*?(--[a-z]+) ([a-z0-9-]+(?:\|(?::[A-Z]+|[^\sA-Z])+)+)", text, re.M):
            scene = "patches" if command != "develop" else "a.tif"
            refused = subprocess.run([PROGRAM, command, scene, option, "@", *MORE_WORDS.get(command, ())],
                                     stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, check=False).stderr.decode()
            choices = [word.split("[")[0] for word in words.split("|") if word]  # the last may stand for a file
            expected = re.sub(r" or |:[A-Za-z]+", ", ", refused[re.search("is one of|known are|expected", refused).end():].split(", or a file ")[0])
            known = {word for word in re.split("[, ]+", expected.split(", not")[0].strip()) if word}
            check(set(choices) == known, f"{command} {option} takes {' '.join(choices)}", refused)


def main():
    os.makedirs(os.path.join(FOLDER, "folder"), exist_ok=True)
    for file in ("a.tif", "two.tif", "my.scene", "page.html", "seen.png", "cube.hdr", "other.txt"):
        Path(FOLDER, file).touch()
    test_shell("bash", Shell(["bash", "--norc", "--noprofile", "-i"], BASH.format(sources=SOURCES)))
    test_shell("zsh", Shell(["zsh", "-f", "-i"], ZSH.format(sources=SOURCES)))
    test_shell("fish", Fish())
    test_choices()
    done()


main()
