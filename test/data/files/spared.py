#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile; makes: command_table
"""No output replaces an input. Goes through every command, every option of it that takes a value, and every file that the
command reads, with that file as the value of the option; also under other names of the file. Commands and options come from
the program's own table, so that a new one cannot be forgotten. Whatever the program answers, no input may have changed, and
a command that succeeds has written nothing there. Then the command lines that once destroyed an input.
Prints TAP, and the number of combinations."""
import itertools
import os
import re
import shutil
import subprocess
from pathlib import Path

import rendered
from sanitized import TMP, tables
from tap import check, done

SPECTRAL = os.path.abspath(rendered.SPECTRAL)
FULL = "FULL" in os.environ
SCENE = """size 8 6
wavelengths 500 600 50
camera ortho 4
light lamp.csv 1 direction 0 0 1
material cloth { diffuse cloth.csv texture grey.tif linear }
object mesh roof.obj material cloth
include more.scene
"""
FILES = {
    "a.scene": SCENE, "more.scene": "ambient d65 0.1\n", "lamp.csv": "nm,power\n400,1\n700,2\n", "cloth.csv": "nm,r\n400,0.2\n700,0.9\n",
    "roof.obj": "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n",
    "eye.csv": "nm,x,y,z\n400,0.1,0.1,1\n550,0.5,1,0.1\n700,0.2,0.1,0\n", "white.csv": "nm,power\n400,1\n700,1\n",
}
READ = ("a.scene", "more.scene", "lamp.csv", "cloth.csv", "roof.obj", "grey.tif")  # by a command that takes the scene
# Each command has words that make it read as many files as it can, and these files. "drivers", "list" and "show" read none.
COMMANDS = {
    "render": (["a.scene"], READ), "plan": (["a.scene"], READ), "cost": (["a.scene"], READ), "view": (["a.scene"], READ),
    "verify": (["a.scene"], READ), "export": (["a.scene"], READ),
    "judge": (["."], (*READ, "exported.txt", "drawn.txt", "colours-0.bin")),
    "probe": (["stack.tif", "1", "1", "--white", "white.csv", "--detector", "eye.csv"], ("stack.tif", "white.csv", "eye.csv")),
    "develop": (["stack.tif", "--white", "white.csv", "--detector", "eye.csv"], ("stack.tif", "white.csv", "eye.csv")),
    "compare": (["stack.tif", "other.tif", "--white", "white.csv"], ("stack.tif", "other.tif", "white.csv")),
    "info": (["stack.tif"], ("stack.tif",)), "envi": (["stack.tif"], ("stack.tif",)),
    "join": (["part.tif", "-o", "joined.tif"], ("part.tif",)),
    "drivers": ([], ()), "list": ([], ()), "show": (["d65"], ()),
}
MORE = [("render", ["--again", "stack.tif"], ("stack.tif", *READ)),
        ("render", ["a.scene", "--sampling", "rgb", "--detector", "eye.csv"], ("eye.csv", *READ)),
        ("render", ["a.scene", "--sampling", "riemann:50", "--detector", "eye.csv"], ("eye.csv",)),
        ("probe", ["a.scene", "1", "1"], READ), ("view", ["stack.tif"], ("stack.tif",))]
# Once, each of these destroyed an input, with exit status 0.
DESTROYED = ["verify a.scene --json a.scene", "verify a.scene --junit a.scene", "render --again stack.tif --json stack.tif",
             "render a.scene --sampling riemann:50 --detector eye.csv --json eye.csv",
             "develop stack.tif --white white.csv --json white.csv", "probe stack.tif 1 1 --white white.csv -o white.csv",
             "join part.tif -o part.tif", "info stack.tif --json ../in/stack.tif",
             "info stack.tif --json hard"]
# Two outputs of one file. `soft` is another name of this folder, `hard` one of a stack.
ONE_FILE = ["verify a.scene --json both --junit both", "render a.scene -o both.tif --json soft/both.tif", "render a.scene -o both.tif --json ../in/both.tif",
            "view a.scene -o both.html --json both.html", "develop stack.tif -o both.png --json ./both.png",
            "cost a.scene --csv both.csv --svg ./both.csv", "compare stack.tif other.tif --map both.png --json both.png"]
REFUSED = "(would replace an input.*|name the same file; expected two files|would be written twice; expected two files)"


def make(folder):
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    for name, text in FILES.items():
        Path(folder, name).write_text(text)
    shutil.copyfile("data/builtin/textures/dots.tif", os.path.join(folder, "grey.tif"))
    for words in ("-o stack.tif", "-o other.tif --light 1=a", "-o part.tif --part 1/1"):
        subprocess.run([SPECTRAL, "render", "a.scene", "--no-check", "-q", *words.split()], cwd=folder, check=True)
    subprocess.run([SPECTRAL, "export", "a.scene", "-o", "exported"], cwd=folder, check=True)
    Path(folder, "drawn.txt").write_text(re.search("^id .*\n", Path(folder, "exported/scene.txt").read_text(), re.MULTILINE).group())
    shutil.rmtree(os.path.join(folder, "exported"))
    for name, contents in (("exported.txt", b"a.scene\n"), ("colours-0.bin", bytes(8 * 6 * 16))):  # a black picture
        Path(folder, name).write_bytes(contents)


def contents(folder):
    return {path.name: path.read_bytes() for path in Path(folder).iterdir() if path.is_file()}


class Place:
    """Inputs under their own names; and `hard` and `soft`, other names of one of them."""

    def __init__(self):
        self.folder = os.path.join(TMP, "in")
        self.kept = os.path.join(TMP, "kept")
        make(self.kept)
        self.inputs = contents(self.kept)
        self.tries, self.harmed = 0, []

    def run(self, line, links=()):
        """Runs the words among fresh inputs, which may have more names. Returns the exit status and the message; notes whether an
        input has changed."""
        shutil.rmtree(self.folder, ignore_errors=True)
        shutil.copytree(self.kept, self.folder)
        for name, other in links:
            if name == "soft":
                os.symlink(other, os.path.join(self.folder, name))
            else:
                os.link(os.path.join(self.folder, other), os.path.join(self.folder, name))
        result = subprocess.run([SPECTRAL, *line], cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True, timeout=300, check=False)
        after = contents(self.folder)
        changed = [name for name, data in self.inputs.items() if after.get(name) != data]
        self.tries += 1
        if changed:
            self.harmed.append((result.returncode, " ".join(line), changed))
        return result.returncode, result.stderr


def quick(command):
    """Words that make a command quick where it is long."""
    return {"cost": ["-q", "--wavelengths", "500,600"], "verify": ["--renderer", "llvmpipe", "-q"]}.get(command, [])


def main():
    place = Place()
    options = {command: [row["names"][-1] for row in rows if row["value"]] for command, (_, rows) in tables().items()}
    check(set(options) == set(COMMANDS), "the test knows all commands", set(options) ^ set(COMMANDS))
    for command, words, read in [(name, *row) for name, row in sorted(COMMANDS.items())] + MORE:
        if command == "cost" and not FULL:
            read = read[:1]
        before = len(place.harmed), place.tries
        for option, name in itertools.product(options[command], read):
            if command == "cost" and option not in ("--json", "--csv", "--svg"):
                continue  # minutes: they are those of render
            place.run([command, *words, *quick(command), option, name])
        for option, name, other in itertools.product(("-o", "--json"), read if FULL else read[:1], ("./", "hard", "soft")):
            value = other + name if other == "./" else other
            place.run([command, *words, *quick(command), option, value], [] if other == "./" else [(other, name)])
        check(len(place.harmed) == before[0], f"{command} {' '.join(words)}: {place.tries - before[1]} combinations leave all inputs",
              *place.harmed[before[0]:][:5])
    for line in DESTROYED + ONE_FILE:
        status, said = place.run(line.split(), [("hard", "stack.tif"), ("soft", ".")])
        check(status == 2 and re.fullmatch(f"error: .* {REFUSED}\n", said) and
              not any(name.startswith("both") for name in os.listdir(place.folder)), f"{line}: is refused, and writes nothing", status, said)
    check(not place.harmed, "no input has changed", len(place.harmed))
    check(place.run("render --again stack.tif -o stack.tif".split())[0] == 0, "the same bytes may be written again")
    print(f"# {place.tries} combinations")
    shutil.rmtree(TMP, ignore_errors=True)
    done()


main()
