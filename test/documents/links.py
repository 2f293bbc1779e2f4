#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first
"""Links and tables of contents in README.md and in data/doc lead somewhere, and README links each page. CONTRIBUTING, the maps of
the rooms and test/README.md name files that exist, and the maps list each room. Prints TAP."""
import os
import re
from pathlib import Path

from tap import check, done

LINK = re.compile(r"\[[^]]*\]\(([^)#\s]*)(?:#([^)\s]*))?\)")


def read(path):
    return Path(path).read_text(encoding="utf-8")


def names_of(top):
    """The files and folders below a folder, as paths."""
    return {str(path) for path in Path(top).rglob("*")}


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


def strangers(text, top):
    """The functions that the figure of a map names and that are not where it says: ROOM: FUNCTION, or in some room."""
    figure = re.search(r"^```\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)[1]
    named = re.findall(r"(?:--|\(|^ +)([\w/]+): ([a-z]+_\w+)", figure, re.MULTILINE)
    others = set(re.findall(r"(?<!struct )\b[a-z]+_[a-z_]+", figure)) - {name for _, name in named}
    for room, name in [*named, *(("", name) for name in sorted(others))]:
        folders = [folder for folder in (f"{top}/{room}", f"data/{room}", room) if os.path.isdir(folder)] if room else ["data", "raster"]
        if not any(defines(folder, name) for folder in folders):
            yield f"{room}: {name}"


def defines(top, name):
    return any(re.search(rf"^[A-Za-z][\w *]*\b{name}\(", read(path), re.MULTILINE) for path in Path(top).rglob("*.c"))


def check_names():
    known = set.union(*map(names_of, ("data", "raster", "test", ".ci"))) | set(os.listdir("."))
    for path in "CONTRIBUTING.md", "data/README.md", "raster/README.md", "test/README.md":
        text = read(path)
        found = list(lost(path, text, known))
        check(not found, f"{path}: each file that it names exists", *found)
        planted = f"See `text/planted.c`, `planted.py` or data/planted.\n`text.c`, `STACK.tif` and data/text/text.c exist.\n{text}"
        check(len(list(lost(path, planted, known))) == len(found) + 3, f"{path}: planted names are found, and others are not")
        top = os.path.dirname(path)
        if top in ("data", "raster"):
            rooms = {name for folder in (top, f"{top}/beside") if os.path.isdir(folder) for name in os.listdir(folder)
                     if os.path.exists(f"{folder}/{name}/{name}.h")}
            check(rooms_in(text) == rooms, f"{path} lists each room", sorted(rooms_in(text) ^ rooms))
            lost_functions = list(strangers(text, top))
            check(not lost_functions, f"{path}: the rooms have the functions of the figure", *lost_functions)
            planted = re.sub(r"(?<=: )(scene_read|frame_draw)\b", r"\1_planted", text)
            check(len(list(strangers(planted, top))) == 1, f"{path}: a planted function is found")


def anchors(path):
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in re.findall(r"^#+ (.*)$", read(path), re.MULTILINE)}


def check_links(path):
    bad = []
    for target, anchor in LINK.findall(re.sub(r"^```.*?^```$", "", read(path), flags=re.MULTILINE | re.DOTALL)):
        if target.startswith("http"):
            continue
        file = os.path.normpath(os.path.join(os.path.dirname(path), target)) if target else path
        if not os.path.exists(file) or (anchor and anchor not in anchors(file)):
            bad.append(f"{target}#{anchor}")
    check(not bad, f"{path}: all links lead somewhere", *bad)


check_names()
pages = sorted("data/doc/" + name for name in os.listdir("data/doc"))
for each in ["README.md", *pages]:
    check_links(each)
linked = read("README.md")
for each in pages:
    check(f"({each}" in linked, f"README links {each}")
done()
