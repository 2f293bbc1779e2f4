#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile
"""Renders lists of scenes: each stack is that of its own command, a batch that is killed leaves nothing but whole stacks, and the
next one draws the missing ones only. A stack is up to date by its record: program, scene, options, files. Failures end as commands
that can be repeated. Prints TAP."""
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time

sys.dont_write_bytecode = True
from rendered import SPECTRAL, TMP, check, done, write

SEED = int(os.environ.get("SEED", time.time()))
HOME = os.path.abspath(TMP)
PROGRAM = os.path.abspath(SPECTRAL)
SMALL = "--size 24x16 --wavelengths 500,600"


def run(*words, **more):
    return subprocess.run([PROGRAM, *words], check=False, cwd=HOME, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, universal_newlines=True, **more)


def batch(text, *words, name="list.txt"):
    write(name, text)
    return run("batch", name, *words)


def read(name):
    with open(os.path.join(HOME, name), "rb") as file:
        return file.read()


def identity(name):
    status = os.stat(os.path.join(HOME, name))
    return status.st_ino, status.st_mtime_ns


def states(result):
    """The state of each output, by the lines that batch prints."""
    return {output: state for state, output in re.findall(r"^\d+/\d+ (up to date|drawn|failed) +[\d.]+ s  ([^:\n]*)", result.stdout, re.MULTILINE)}


# ---- two hundred scenes, killed three times ----

def descendants(pid):
    found = set()
    for entry in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{entry}/stat", encoding="utf-8", errors="replace") as file:
                parent = int(file.read().rsplit(")", 1)[1].split()[1])
        except OSError:
            continue
        if parent == pid:
            found |= {int(entry)} | descendants(int(entry))
    return found


def is_running(pid):
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as file:
            return file.read().rsplit(")", 1)[1].split()[0] not in "ZX"
    except OSError:
        return False


def kill(process):
    """Kills the batch, or the process that it watches. Returns the processes that are left a moment later."""
    family = descendants(process.pid)
    os.kill(process.pid if random.random() < 0.5 or not family else min(family), signal.SIGKILL)
    process.wait()
    for _ in range(100):
        left = [pid for pid in family if is_running(pid)]
        if not left:
            break
        time.sleep(0.02)
    return left


def many():
    names = [f"many/{i}.tif" for i in range(200)]
    os.makedirs(os.path.join(HOME, "many"))
    lines = [f"{'spheres' if i % 3 else 'patches'} {SMALL} --light 1=a*{1 + i / 100} {'--renderer raster ' if i % 2 else ''}-o {names[i]}"
             for i in range(200)]
    write("many.txt", "\n".join(lines) + "\n")
    seen, last = {}, None
    for i in range(3):
        process = subprocess.Popen([PROGRAM, "batch", "many.txt", "--jobs", "4"], cwd=HOME, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        before = len(seen)
        while len([name for name in names if os.path.exists(os.path.join(HOME, name))]) < before + 20 and process.poll() is None:
            time.sleep(0.005)
        time.sleep(random.uniform(0, 0.1))
        left = kill(process)
        check(not left, f"kill {i + 1} ends all renders", left)
        there = {name: identity(name) for name in names if os.path.exists(os.path.join(HOME, name))}
        check(all(there[name] == seen[name] for name in seen) and len(there) >= before + 20, f"batch {i + 1} draws no stack twice", len(there))
        seen = there
    last = run("batch", "many.txt", "--json", "many.json")
    report = json.loads(read("many.json"))
    check(last.returncode == 0 and (report["drawn"], report["up_to_date"], report["failed"]) == (200 - len(seen), len(seen), 0) and
          f"200 renders: {200 - len(seen)} drawn, {len(seen)} up to date, 0 failed" in last.stdout, "the last batch draws the others, and says so",
          last.stdout[-300:], last.stderr)
    check(all(identity(name) == seen[name] for name in seen), "it draws no stack twice")
    check([line["output"] for line in report["lines"]] == names and len(states(last)) == 200, "each has a line in the table and in the JSON")
    check(not [name for name in os.listdir(os.path.join(HOME, "many")) if not name.endswith(".tif")], "no other file is left")
    for i in random.sample(range(200), 4):
        run("render", *lines[i].split(" -o ")[0].split(), "-o", "own.tif", "-q")
        check(read("own.tif") == read(names[i]), f"the stack of line {i + 1} is that of its own command")
    again = run("batch", "many.txt")
    check("200 renders: 0 drawn, 200 up to date, 0 failed" in again.stdout, "then all are up to date", again.stdout[-200:])


# ---- up to date ----

def current():
    write("paint.csv", "400,0.5\n700,0.7\n")
    write("more.scene", "light d65 1 direction 0 0 1\n")
    write("own.scene", "size 24 16\nwavelengths 500 600 50\ncamera ortho 3\ninclude more.scene\n"
                       "material m { diffuse paint.csv }\nobject sphere 1 material m\n")
    words = ("own.scene", "-o", "own.tif", "--json", "own.json", "--envi")

    def drawn(what, expected, *words):
        before = identity("own.tif") if os.path.exists(os.path.join(HOME, "own.tif")) else None
        result = run("render", "--update", *words)
        after = identity("own.tif")
        check(result.returncode == 0 and (before != after) == expected and (expected or result.stdout == "stack             own.tif is up to date\n"),
              f"{'drawn' if expected else 'not drawn'}: {what}", result.stdout, result.stderr)

    check("--again takes no --update" in run("render", "--update", "--again", "own.tif").stderr, "refused: --update with --again")
    drawn("no stack yet", True, *words)
    drawn("nothing has changed", False, *words)
    write("paint.csv", "400,0.5\n700,0.8\n")
    drawn("a table has changed", True, *words)
    write("more.scene", "light d65 2 direction 0 0 1\n")
    drawn("an included file has changed", True, *words)
    drawn("another size", True, *words, "--size", "24x18")
    drawn("the first size again", True, *words)
    os.utime(os.path.join(HOME, "paint.csv"))
    drawn("a file with the same bytes and another date", False, *words)
    for name in ("own.json", "own.tif.hdr"):
        os.remove(os.path.join(HOME, name))
        drawn(f"{name} is missing", True, *words)
    drawn("the reference's pixels instead", True, *words, "--renderer", "raster")
    drawn("with another check, which is no part of them", False, *words, "--renderer", "raster", "--strict")
    drawn("OpenGL's pixels again", True, *words)
    stack = read("own.tif")
    for what, changed in (("a stack of another version", stack.replace(b"program: spectral 0.", b"program: spectral 9.")),
                          ("a stack that is cut off", stack[:len(stack) // 8]), ("no stack at all", b"a file of the user's\n"),
                          ("a verdict that is not good", stack.replace(b"agreed; ", b"differs "))):
        check(changed != stack, f"changed: {what}")
        with open(os.path.join(HOME, "own.tif"), "wb") as file:
            file.write(changed)
        drawn(what, True, *words)
    write("lamp.csv", "400,1\n700,2\n")
    drawn("a light of a file", True, *words, "--light", "1=lamp.csv")
    write("lamp.csv", "400,1\n700,3\n")
    drawn("the light's file has changed", True, *words, "--light", "1=lamp.csv")
    drawn("it stays", False, *words, "--light", "1=lamp.csv")
    write("eye.csv", "nm,x,y,z\n" + "".join(f"{nm},1,2,1\n" for nm in range(400, 710, 10)))
    sampled = ("own.scene", "-o", "own.tif", "--sampling", "gauss:2", "--detector", "eye.csv")
    drawn("a detector of a file", True, *sampled)
    write("eye.csv", "nm,x,y,z\n" + "".join(f"{nm},1,3,1\n" for nm in range(400, 710, 10)))
    drawn("the detector's file has changed", True, *sampled)
    drawn("--observer, another name of --detector", False, *(word.replace("--detector", "--observer") for word in sampled))
    check(re.search("^file +[0-9a-f]{64} eye.csv$", run("info", "own.tif").stdout, re.MULTILINE), "the stack records the detector's file")
    drawn("it stays", False, *sampled)


# ---- failures ----

def failures():
    write("bad.scene", "size 8 8\nlamp d65\n")
    result = batch(f"patches {SMALL} -o good.tif   # a comment\n\n  # another\nbad.scene -o 'bad.tif\nmissing.scene -o \"it's missing.tif\"\n"
                   f"room {SMALL} --full-scale 1e-9 --depth 8 --strict --no-check -o /dev/null\n")
    check(result.returncode == 2 and states(result).get("good.tif") == "drawn", "a good line is drawn beside others that fail", result.stdout, result.stderr)
    commands = result.stdout[result.stdout.index("summary"):].splitlines()[1:]
    check(len(commands) == 3 and result.stderr == "error: 3 of 4 renders failed; the commands above repeat them\n", "failures end as commands",
          result.stdout, result.stderr)
    report = json.loads(batch(open(os.path.join(HOME, "list.txt")).read(), "--json", "-", "-q").stdout.splitlines()[-1])
    messages = [line["message"] for line in report["lines"] if line["state"] == "failed"]
    for command, message in zip(commands, messages):
        said = subprocess.run(command, shell=True, check=False, cwd=HOME, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, universal_newlines=True)
        check(said.returncode == 2 and message in said.stderr, f"repeated: {command[len(PROGRAM):]}", said.stderr, message)
    check([line["line"] for line in report["lines"]] == [1, 4, 5, 6], "the JSON has the lines of the list", report)
    result = batch("patches -o good.tif --size 24x16 --wavelengths 500,600\n", "--jobs", "1", "-q")
    check(result.returncode == 0 and result.stdout == result.stderr == "", "--quiet prints nothing where nothing fails", result.stdout, result.stderr)


def refusals():
    for text, expected in (("", "the list is empty"), ("# a comment\n", "the list is empty"),
                           ("patches -o a.tif\nspheres -o a.tif\n", "list.txt:2:1: error: line 1 writes a.tif, too"),
                           ("patches --part 1/2 -o a.tif\npatches --part 1/2 -o a.tif\n", "list.txt:2:1: error: line 1 writes a.tif.1-of-2.part, too"),
                           ("patches\npatches --size 10x10\n", "list.txt:2:1: error: line 1 writes patches.tif, too"),
                           ("patches --sise 10x10 -o a.tif\n", "list.txt:1:1: error: render has no option '--sise'; did you mean --size?"),
                           ("patches -o -\n", "list.txt:1:1: error: a line of a batch takes no -o -"),
                           ("- -o a.tif\n", "a line of a batch takes no -"), ("--again a.tif\n", "a line of a batch takes no --again"),
                           ("\n patches -o \"a.tif\n", "list.txt:2:13: error:"), ("patches spheres -o a.tif\n", "unexpected operand 'spheres'")):
        before = sorted(os.listdir(HOME))
        result = batch(text, name="list.txt")
        check(result.returncode == 2 and expected in result.stderr and result.stderr.count("\n") == 1 and not result.stdout and
              sorted(os.listdir(HOME)) == sorted(set(before) | {"list.txt"}), f"refused: {text!r}", result.stderr)
    check("batch needs LIST" in run("batch").stderr, "refused: no list")
    check(run("batch", "nothing.txt").returncode == 2, "refused: a list that is not there")
    check("list.txt would replace the input" in batch(f"patches {SMALL} -o good.tif\n", "--json", "list.txt").stderr, "refused: JSON in place of the list")


def limits():
    """--memory and --threads hold for each line that gives none."""
    batch("spheres --size 24x16 -o limited.tif\n", "--memory", "1", "--json", "limited.json")
    line = json.loads(read("limited.json"))["lines"][0]
    one = run("render", "spheres", "--size", "24x16", "-o", "limited.tif", "--memory", "1")
    check(line["exit_status"] == one.returncode and (line["message"] or "") in one.stderr, "--memory is that of each render", line, one.stderr)
    result = batch("spheres --size 24x16 -o limited.tif --memory 1024 --threads 2\n", "--memory", "1", "--threads", "1")
    check(result.returncode == 0, "a line may say otherwise", result.stdout)


def parts():
    """A list may draw parts, and go on with them."""
    result = batch("".join(f"patches --size 3000x1300 --wavelengths 500 --part {i}/3 -o parts.tif\n" for i in (1, 2, 3)))
    check(result.returncode == 0 and run("join", "parts.tif", "-q").returncode == 0, "a list of parts", result.stdout, result.stderr)


# ---- signals and pipes ----

def signals():
    write("slow.txt", "".join(f"spheres --size 900x600 --light 1=a*{i} -o slow{i}.tif\n" for i in (1, 2, 3, 4)))
    process = subprocess.Popen([PROGRAM, "batch", "slow.txt"], cwd=HOME, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    while len(descendants(process.pid)) < 3:
        time.sleep(0.01)
    family = descendants(process.pid)
    process.send_signal(signal.SIGINT)
    process.communicate()
    time.sleep(0.3)
    check(process.returncode == -signal.SIGINT and not [pid for pid in family if is_running(pid)], "SIGINT ends the batch and its renders",
          process.returncode)
    check(not [name for name in os.listdir(HOME) if name.startswith(".slow")], "no temporary file is left")
    process = subprocess.Popen([PROGRAM, "batch", "many.txt"], cwd=HOME, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)
    process.stdout.readline()
    process.stdout.close()
    check(process.wait() == 0 and not process.stderr.read(), "a reader that has gone does not stop the batch")


random.seed(SEED)
shutil.rmtree(TMP, ignore_errors=True)
os.makedirs(TMP)
print(f"# SEED={SEED}")
many()
current()
failures()
refusals()
limits()
parts()
signals()
done()
