#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile libosmesa6 parallel
"""Runs README.md and the pages in data/doc as a reader would. Each page has a folder of its own, in which its blocks are
run in their order:

    ```sh            commands, which must succeed
    ```console       commands behind $, and what they print; "..." stands for any lines
    ```python        a script
    ```scene         lines of a scene, which must be read among some materials
    ```LANGUAGE FILE a file that later blocks use
    ```text          is not run

"full" behind the language: the block takes minutes, and runs with FULL=1.

recipes.py and tools.py run recipes.md and tools.md; links.py follows links. Prints TAP."""
import os
import re
import shutil
import sys
from pathlib import Path

from documents import FOLDER, put_in_path, run
from rendered import TMP, check, done

ROOT = os.getcwd()
FULL = os.environ.get("FULL")
BLOCK = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
INSTALLED = "/usr/local/share/spectral/samples"  # here they are in data/samples
OWN = {"recipes.md", "tools.md"}  # other tests run them
# OpenGL and the clock decide these figures, which differ between machines: only the words are compared.
MEASURED = re.compile(r"(drawn by|shading|full scale|seconds|OpenGL|pixels|  [a-z]) ?")
MATERIALS = """
material brick colorchecker/15-red
material paper { diffuse 0.8 }
material grass colorchecker/14-green
material wood { diffuse 0.4 }
material other { diffuse 0.3 }
material halves { diffuse 0.3 }
material cloth { diffuse 0.3 }
material walnut { diffuse 0.3 }
"""


def comparable(line):
    return re.sub(r"\d[\d.]*(e[+-]?\d+)?", "#", line) if MEASURED.match(line) else line.rstrip()


def matches(expected, seen):
    """whether the lines are the same; "..." stands for any number of lines"""
    if not expected:
        return not seen
    if expected[0] == "...":
        return any(matches(expected[1:], seen[start:]) for start in range(len(seen) + 1))
    return bool(seen) and comparable(expected[0]) == comparable(seen[0]) and matches(expected[1:], seen[1:])


def check_console(page, text):
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        command, *expected = part.rstrip("\n").split("\n")
        result = run("sh", "-c", command)
        check(result.returncode == 0 and matches(expected, result.stdout.splitlines()),
              f"{page}: it prints what the page says: {command}", result.stdout)


def check_scene(page, text):
    lines = [line for line in text.splitlines() if line.strip()]
    defined = set(re.findall(r"^material (\S+)", text, re.MULTILINE))
    others = [line for line in MATERIALS.splitlines() if not line or line.split()[1] not in defined]
    Path("lines.scene").write_text("\n".join(others + lines) + "\n", encoding="utf-8")
    result = run("spectral", "plan", "lines.scene")
    check(result.returncode == 0, f"{page}: a scene can have these lines: {lines[0]} ...", result.stdout)


def check_block(page, language, info, text):
    if language == "text" or (info == "full" and not FULL):
        return
    if language == "console":
        check_console(page, text)
    elif info and info != "full":
        Path(info).write_text(text, encoding="utf-8")
    elif language == "scene":
        check_scene(page, text)
    else:
        file = "block." + language
        Path(file).write_text(text.replace(INSTALLED, os.path.join(ROOT, "data/samples")), encoding="utf-8")
        result = run(*(["sh", "-e"] if language == "sh" else [sys.executable]), file)
        check(result.returncode == 0, f"{page}: it runs: {text.splitlines()[0]} ...", result.stdout)


def check_page(path):
    text = Path(path).read_text(encoding="utf-8")
    page = os.path.basename(path)
    if page in OWN:
        return
    folder = os.path.join(TMP, page)
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    os.chdir(folder)
    for block in BLOCK.findall(text):
        check_block(page, *block)
    os.chdir(ROOT)


if __name__ == "__main__":
    put_in_path()
    pages = ["README.md"] + sorted(os.path.join(FOLDER, name) for name in os.listdir(FOLDER))
    for each in pages:
        check_page(each)
    done()
