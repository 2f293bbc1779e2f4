#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""Runs README.md and the pages in data/doc as a reader would. Each page has a folder of its own, in which its blocks are
run in their order:

    ```sh            commands, which must succeed
    ```console       commands behind $, and what they print; "..." stands for any lines
    ```python        a script
    ```scene         lines of a scene, which must be read among some materials
    ```LANGUAGE FILE a file that later blocks use
    ```text          is not run

"full" behind the language: the block takes minutes, and runs with FULL=1.

recipes.py and tools.py run recipes.md and tools.md. Links and tables of contents must lead somewhere. CONTRIBUTING, the maps of
the rooms and test/README.md name files that exist, and the maps list each room. Prints TAP."""
import os
import re
import shutil
import sys

sys.dont_write_bytecode = True
from documents import FOLDER, put_in_path, run
from rendered import TMP, check, done

ROOT = os.getcwd()
FULL = os.environ.get("FULL")
BLOCK = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[[^]]*\]\(([^)#\s]*)(?:#([^)\s]*))?\)")
INSTALLED = "/usr/local/share/spectral/samples"  # here they are in data/samples
OWN = {"recipes.md", "tools.md"}  # other tests run them
# OpenGL and the clock decide these figures, which differ between machines: only the words are compared.
MEASURED = re.compile(r"(OpenGL|exact|within 1 count|largest|mean residual|floor|checked|worst error|pixels|seconds|"
                      r"  in one band|  smooth interior) ")
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
    with open("lines.scene", "w", encoding="utf-8") as out:
        out.write("\n".join(others + lines) + "\n")
    result = run("spectral", "plan", "lines.scene")
    check(result.returncode == 0, f"{page}: a scene can have these lines: {lines[0]} ...", result.stdout)


def check_block(page, language, info, text):
    if language == "text" or (info == "full" and not FULL):
        return
    if language == "console":
        check_console(page, text)
    elif info and info != "full":
        with open(info, "w", encoding="utf-8") as out:
            out.write(text)
    elif language == "scene":
        check_scene(page, text)
    else:
        file = "block." + language
        with open(file, "w", encoding="utf-8") as out:
            out.write(text.replace(INSTALLED, os.path.join(ROOT, "data/samples")))
        result = run(*(["sh", "-e"] if language == "sh" else [sys.executable]), file)
        check(result.returncode == 0, f"{page}: it runs: {text.splitlines()[0]} ...", result.stdout)


def anchors(path):
    with open(path, encoding="utf-8") as file:
        headings = re.findall(r"^#+ (.*)$", file.read(), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


def check_links(path, text):
    bad = []
    for target, anchor in LINK.findall(re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)):
        if target.startswith("http"):
            continue
        file = os.path.normpath(os.path.join(os.path.dirname(path), target)) if target else path
        if not os.path.exists(file) or (anchor and anchor not in anchors(file)):
            bad.append(f"{target}#{anchor}")
    check(not bad, f"{path}: all links lead somewhere", *bad)


def names_of(top):
    """The files and folders below a folder, as paths."""
    return {os.path.normpath(os.path.join(folder, name)) for folder, folders, names in os.walk(top) for name in folders + names}


def lost(path, text, known):
    """The files and folders that a text names, with their line, and that do not exist. A word in capitals stands for a name."""
    places = "", os.path.dirname(path), "test", "test/cases", "data", "data/builtin/viewer"
    for number, line in enumerate(text.splitlines(), 1):
        for name in {*re.findall(r"`([\w./-]+)`", line), *re.findall(r"(?<![\w/.-])(?:data|raster|test)/[\w./-]*\w", line)}:
            is_name = "/" in name or re.search(r"\w[.](c|h|py|sh|md|js|css|html|scene|sha256)$", name)
            if is_name and not re.search(r"[A-Z]{4}|^build/", name) and name.strip("/") not in {os.path.basename(each) for each in known} and \
                    not any(os.path.normpath(os.path.join(place, name)) in known for place in places):
                yield f"{path}:{number}: {name}"


def rooms_in(text):
    table = re.search(r"^\| room \| what it is for \|\n(.*?)\n\n", text, re.MULTILINE | re.DOTALL)[1]
    return set(re.findall(r"`(\w+)`", " ".join(row.split("|")[1] for row in table.splitlines())))


def check_names():
    known = set.union(*map(names_of, ("data", "raster", "test", ".ci"))) | set(os.listdir("."))
    for path in "CONTRIBUTING.md", "data/README.md", "raster/README.md", "test/README.md":
        with open(path, encoding="utf-8") as file:
            text = file.read()
        found = list(lost(path, text, known))
        check(not found, f"{path}: each file that it names exists", *found)
        planted = f"See `text/planted.c`, `planted.py` or data/planted.\n`text.c`, `STACK.tif` and data/text/text.c exist.\n{text}"
        check(len(list(lost(path, planted, known))) == len(found) + 3, f"{path}: planted names are found, and others are not")
        top = os.path.dirname(path)
        if top in ("data", "raster"):
            rooms = {name for name in os.listdir(top) if os.path.exists(f"{top}/{name}/{name}.h")}
            check(rooms_in(text) == rooms, f"{path} lists each room", sorted(rooms_in(text) ^ rooms))


def check_page(path):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    check_links(path, text)
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
    check_names()
    for each in pages:
        check_page(each)
    with open("README.md", encoding="utf-8") as readme:
        linked = readme.read()
    for each in pages[1:]:
        check(f"({each}" in linked, f"README links {each}")
    done()
