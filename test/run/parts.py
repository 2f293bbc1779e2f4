#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# level: full; packages: python3-numpy python3-tifffile; makes: spoil fail
"""Draws pictures in parts, and joins them: the stack is that of one process, byte for byte, and the report has the same sums.
That holds where parts are killed and go on, are drawn twice, or by two processes at once. What does not belong together, or
is not whole, is refused in a line. With FULL, 20 kills and more kinds of pictures.
Prints TAP."""
import glob
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time

sys.dont_write_bytecode = True
from attacked import LIBRARY
from rendered import SPECTRAL, TMP, check, done, write

FULL = "FULL" in os.environ
SPOIL = os.path.abspath(os.environ.get("SPOIL_LIBRARY", "build/test/spoil.so"))
SEED = int(os.environ.get("SEED", time.time()))
STACK = os.path.join(TMP, "stack.tif")
WHOLE = os.path.join(TMP, "whole.tif")
SCENE = ("patches", "--size", "3000x1300", "--wavelengths", "450:650:100")
# Sums of all tiles; the seconds of a process, and the work that each process repeats, are none.
REPEATED = "seconds", "peak_bytes", "work", "output", "accuracy", "notes", "part"


def run(*words, **environment):
    return subprocess.run([SPECTRAL, *words], check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, env={**os.environ, **environment})


def files():
    return sorted(glob.glob(STACK + "*"))


def remove():
    for name in files():
        os.remove(name)


def name_of(number, count):
    return f"{STACK}.{number}-of-{count}.part"


def words_of(number, count, scene=SCENE):
    return ["render", *scene, "--part", f"{number}/{count}", "-o", STACK, "-q"]


def draw(count, scene=SCENE, **environment):
    return [run(*words_of(i, count, scene), **environment) for i in range(1, count + 1)]


def read(path):
    with open(path, "rb") as file:
        return file.read()


def draw_whole(scene=SCENE, **environment):
    return run("render", *scene, "-o", WHOLE, "-q", "--json", WHOLE + ".json", **environment)


def is_same(what, *words):
    if os.path.exists(STACK):
        os.remove(STACK)
    result = run("join", STACK, "-q", *words)
    check(result.returncode == 0 and not result.stderr and read(STACK) == read(WHOLE), f"the same bytes: {what}",
          result.returncode, result.stderr)


# ---- the same bytes ----

def counts():
    draw_whole()
    for count in (1, 2, 4, 7) if FULL else (7,):
        remove()
        parts = draw(count)
        check(all(part.returncode == 0 for part in parts), f"{count} parts are drawn", *(part.stderr for part in parts))
        is_same(f"{count} parts", "--json", STACK + ".json")
        whole, joined = json.load(open(WHOLE + ".json")), json.load(open(STACK + ".json"))
        check(all(whole[key] == joined[key] for key in whole if key not in REPEATED) and set(whole) - set(joined) <= set(REPEATED),
              f"the same sums: {count} parts", *((key, whole[key], joined.get(key)) for key in whole if key not in REPEATED))
        check(all(whole["work"][key] == joined["work"][key] for key in ("points_lit", "power_functions")), "the same work of the reference")


def kinds():
    own = write("own.scene", "size 2100 1500\nwavelengths 450 550 50\nshading phong\nlight d65 1 direction 1 1 1\n"
                "material m { diffuse 0.5 specular 0.5 gloss 20 }\nobject sphere 3 30 30 material m\ncamera ortho 8\n")
    some = [("the reference", ("room", "--renderer", "raster", "--size", "1800x1600", "--wavelengths", "500")),
            ("floats of components", ("patches", "--sampling", "rgb", "--depth", "32f", "--size", "2000x1000"))]
    more = [("phong shading", (own, "--renderer", "raster")),
            ("no check", ("room", "--no-check", "--size", "2000x1500", "--wavelengths", "450,550")),
            ("positions", ("patches", "--samples", "4", "--size", "501x403", "--wavelengths", "500")),
            ("steps of 8 bits", ("patches", "--buffer", "8", "--depth", "8", "--size", "2000x1000", "--wavelengths", "450:550:50")),
            ("finer triangles", ("spheres", "--accuracy", "1", "--size", "1500x1500", "--wavelengths", "450,550")),
            ("a wide picture", ("patches", "--size", "20000x200", "--wavelengths", "500")),
            ("shaders", ("textures", "--renderer", "es-shader", "--size", "2000x1500", "--wavelengths", "450:550:20"))]
    for what, scene in some + more * FULL:
        remove()
        result = draw_whole(scene)
        parts = draw(3, scene)
        check(result.returncode == 0 and all(part.returncode == 0 for part in parts), f"parts are drawn: {what}", result.stderr,
              *(part.stderr for part in parts))
        is_same(what)


# ---- killed, twice, at once ----

def killed(kills):
    """Part 2 of 3 is killed at random moments, and goes on."""
    remove()
    since = time.monotonic()
    draw(3)
    pause = (time.monotonic() - since) / 3
    complete = read(name_of(2, 3))
    os.remove(name_of(2, 3))
    ended = 0
    for i in range(kills):
        process = subprocess.Popen([SPECTRAL, *words_of(2, 3)])
        time.sleep(random.uniform(0, pause) if i % 4 else random.uniform(0, 0.3 * pause))
        process.kill()
        ended += process.wait() == 0
        if ended and os.path.exists(name_of(2, 3)):
            os.remove(name_of(2, 3))
    result = run("render", *SCENE, "--part", "2/3", "-o", STACK)
    check(result.returncode == 0 and read(name_of(2, 3)) == complete, f"after {kills} kills the part is the same", result.stderr)
    is_same(f"after {kills} kills")


def beginnings():
    """A part that ends anywhere goes on there: in its head, a mark, samples, sums; in zeros that a crash may leave."""
    remove()
    draw(2)
    name = name_of(2, 2)
    complete = read(name)
    for length in (0, 5, 3000, 4096, 4100, len(complete) // 2, len(complete) - 1) if FULL else (3000, len(complete) // 2):
        for zeros in (0, 6000) if FULL or length == 3000 else (0,):
            with open(name, "wb") as file:
                file.write((complete[:length] + bytes(zeros))[:len(complete)])
            result = run(*words_of(2, 2))
            check(result.returncode == 0 and read(name) == complete, f"a part goes on behind {length} bytes and {zeros} zeros",
                  result.returncode, result.stderr)
    result = run("render", *SCENE, "--part", "2/2", "-o", STACK)
    check("part              2 of 2: 2 tiles, 2 complete already" in result.stdout, "a complete part draws nothing again",
          result.stdout)
    is_same("a part that was drawn twice")


def at_once():
    remove()
    draw(2)
    complete = read(name_of(1, 2))
    os.remove(name_of(1, 2))
    processes = []
    for pause in (0, 0, 0.4):
        time.sleep(pause)
        processes.append(subprocess.Popen([SPECTRAL, *words_of(1, 2)]))
    codes = [process.wait() for process in processes]
    check(codes == [0, 0, 0] and read(name_of(1, 2)) == complete, "three processes draw a part at once", codes)
    is_same("a part that three processes drew at once")


def interrupted():
    remove()
    process = subprocess.Popen([SPECTRAL, *words_of(1, 1)], stderr=subprocess.PIPE, universal_newlines=True,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    process.communicate()
    check(process.returncode == -signal.SIGINT, "SIGINT ends a part", process.returncode)
    result = run(*words_of(1, 1), "--json", STACK + ".json")
    check(result.returncode == 0 and json.load(open(STACK + ".json"))["part"]["tiles"] == 5, "then it goes on", result.stderr)
    is_same("after SIGINT")


def full_disk():
    remove()
    limited = subprocess.run([SPECTRAL, *words_of(1, 1)], check=False, stderr=subprocess.PIPE, universal_newlines=True,
                             preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20_000_000, 20_000_000)))
    check(limited.returncode == 3 and limited.stderr.count("\n") == 1, "a file at its limit is a failure", limited.stderr)
    check(run(*words_of(1, 1)).returncode == 0, "then it goes on")
    is_same("after a file at its limit")


def failing_calls():
    """Where a call of the system or an allocation fails, a part ends with one line, or is right; then it goes on to the same bytes. The
    same holds for a whole render that resumes."""
    if not os.path.exists(LIBRARY):
        return
    scene = ("patches", "--size", "3000x1300", "--wavelengths", "500", "--renderer", "raster", "--no-check")
    whole = draw_whole(scene)
    calls = [(kind, n) for kind in ("pwrite", "fsync", "ftruncate", "fallocate", "open", "rename", "link", "unlink", "stat", "pread", "own", "thread")
             for n in ((1, 2, 3, 5, 8, 13, 21, 34) if FULL else (random.choice((1, 2, 3, 5, 8, 13)),))]
    wrong = []
    for kind, n in calls:
        for words in (words_of(1, 1, scene), words_of(1, 1, scene) + ["--shared"], ["render", *scene, "--resume", "-o", STACK, "-q"]):
            remove()
            failed = run(*words, FAIL=f"{kind}:{n}", FAIL_DEPTH="1", LD_PRELOAD=LIBRARY)
            again = run(*words)
            joined = again if "--resume" in words else run("join", STACK, "-q")
            if failed.returncode not in (0, 3) or (failed.returncode == 3) != (failed.stderr.count("\n") == 1) or again.returncode != 0 or \
                    joined.returncode != 0 or read(STACK) != read(WHOLE) or os.path.exists(UNFINISHED):
                wrong.append((kind, n, words[-3:], failed.returncode, failed.stderr, again.stderr, joined.stderr, files()))
    check(whole.returncode == 0 and not wrong, f"{len(calls)} calls fail in parts: one line each, and then the same bytes", *wrong)


def lost_samples():
    """A system may report lost samples once: where the sync before the first marks fails, no tile counts as complete."""
    if not os.path.exists(LIBRARY):
        return
    remove()
    failed = run(*words_of(1, 1), FAIL="fsync:2", FAIL_DEPTH="1", LD_PRELOAD=LIBRARY)  # the first one is of the head
    check(failed.returncode == 3 and os.path.exists(name_of(1, 1)) and not has_tile(name_of(1, 1)), "after a failed sync no tile has a mark",
          failed.returncode, failed.stderr)
    check(run(*words_of(1, 1)).returncode == 0, "then it begins again")


# ---- one file ----

RESUME = ["render", *SCENE, "--resume", "-o", STACK, "-q"]
UNFINISHED = STACK + ".unfinished"


def resumed(kills):
    remove()
    for i in range(kills):
        process = subprocess.Popen([SPECTRAL, *RESUME])
        time.sleep(random.uniform(0.1, 0.6))
        process.kill()
        process.wait()
        if os.path.exists(STACK):
            check(read(STACK) == read(WHOLE), f"kill {i + 1} leaves a whole stack")
            remove()
    result = run(*RESUME)
    check(result.returncode == 0 and files() == [STACK] and read(STACK) == read(WHOLE), f"a render goes on after {kills} kills",
          result.stderr, files())
    run(*RESUME, "--json", STACK + ".json")
    check(json.load(open(STACK + ".json"))["part"]["tiles_before"] == 0 and read(STACK) == read(WHOLE), "it draws all of it anew then")


def has_tile(name):
    """Returns whether a part has a complete tile: its mark stands behind the text and its zeros, in whole blocks of 4096 bytes."""
    if not os.path.exists(name):
        return False
    kept = read(name)
    mark = kept.find(b"\0") // 4096 * 4096 + 4096
    return kept[mark:mark + 32].strip(b"\0") != b""


def stop_resumed():
    """Leaves an unfinished stack with a complete tile: its render is killed as soon as the part has one."""
    remove()
    process = subprocess.Popen([SPECTRAL, *RESUME])
    while process.poll() is None and not has_tile(name_of(1, 1)):
        time.sleep(0.001)
    process.kill()
    check(process.wait() == -signal.SIGKILL and os.path.exists(UNFINISHED), "a render leaves an unfinished stack when it is killed")


def unfinished():
    stop_resumed()
    for words in (("info", UNFINISHED), ("develop", UNFINISHED, "-o", os.path.join(TMP, "a.png")), ("compare", UNFINISHED, WHOLE),
                  ("probe", UNFINISHED, "1", "1"), ("envi", UNFINISHED)):
        refused(f"{words[0]} of an unfinished stack", "it is not finished", *words)
    texture = write("texture.scene", f"ambient d65 1\nmaterial m {{ diffuse 1 spectral-texture {os.path.basename(UNFINISHED)} }}\nobject sphere 1 material m\n")
    refused("a texture that is not finished", "it is not finished", "render", texture, "-o", os.path.join(TMP, "a.tif"))
    refused("to go on in parts of their own", "'shared: yes'", *words_of(1, 1))
    refused("to go on with another scene", "was begun with", *RESUME, "--light", "1=a")
    kept = read(UNFINISHED)
    change(UNFINISHED, len(kept) - 3000 * 1300 * (3 * 2 + 1) + 1001)  # in the first tile
    refused("to go on with samples that have changed", "differ from their checksum", *RESUME)
    os.remove(UNFINISHED)
    refused("to go on without samples", "is missing, and parts say that it has samples", *RESUME)
    with open(UNFINISHED, "wb") as file:
        file.write(kept)
    is_whole = run(*RESUME).returncode == 0 and read(STACK) == read(WHOLE)
    check(is_whole and files() == [STACK], "a refusal changes nothing", files())


def shared():
    remove()
    processes = [subprocess.Popen([SPECTRAL, *words_of(i, 3), "--shared"]) for i in (1, 2)]
    time.sleep(0.4)
    processes[0].kill()
    codes = [process.wait() for process in processes]
    refused("parts that are not there yet", "part 3 of 3 is missing" if os.path.exists(name_of(1, 3)) else "is missing", "join", STACK)
    codes += [run(*words_of(i, 3), "--shared").returncode for i in (1, 3, 2)]
    check(codes[1:] == [0, 0, 0, 0], "parts in one file are drawn", codes)
    refused("another option of one part", "was begun with", *words_of(2, 3))
    kept = read(UNFINISHED)
    change(UNFINISHED, len(kept) // 2)
    refused("shared samples that have changed", "differ from their checksum", "join", STACK)
    with open(UNFINISHED, "wb") as file:
        file.write(kept)
    is_same("parts in one file")
    check(files() == [STACK], "then the parts are gone", files())
    refused("--shared without --part", "--shared needs --part", "render", "patches", "--shared", "-o", STACK)


# ---- refusals ----

def refused(what, pattern, *words, status=2, **environment):
    before = {name: read(name) for name in files()}
    result = run(*words, **environment)
    check(result.returncode == status and pattern in result.stderr and result.stderr.count("\n") == 1 and
          {name: read(name) for name in files()} == before, f"refused: {what}", result.returncode, result.stderr)


def change(path, offset):
    with open(path, "r+b") as file:
        file.seek(offset)
        byte = file.read(1)
        file.seek(offset)
        file.write(bytes([byte[0] ^ 1]))


def refusals():
    remove()
    refused("no parts", "there are no parts of it", "join", STACK)
    refused("no stack", "join needs STACK", "join")
    draw(3)
    kept = {i: read(name_of(i, 3)) for i in (1, 2, 3)}

    def restore(number):
        with open(name_of(number, 3), "wb") as file:
            file.write(kept[number])

    os.remove(name_of(2, 3))
    refused("a missing part", f"part 2 of 3 is missing; expected {name_of(2, 3)}", "join", STACK)
    with open(name_of(2, 3), "wb") as file:
        file.write(kept[2][:-1000])
    refused("a truncated part", "part 2 of 3 is not complete: it has 1 of 2 tiles", "join", STACK)
    restore(2)
    change(name_of(2, 3), 200_000)
    refused("changed samples", "differ from their checksum", "join", STACK)
    restore(2)
    with open(name_of(2, 3), "wb") as file:
        file.write(kept[1])
    refused("a part twice", "part 2 of 3 is not complete", "join", STACK)
    with open(name_of(2, 3), "wb") as file:
        file.write(kept[2].replace(b"program: spectral 0.", b"program: spectral 9.", 1))
    refused("another program", "part 1 has 'program: spectral 0.", "join", STACK)
    for i in (1, 2, 3):
        with open(name_of(i, 3), "wb") as file:
            file.write(kept[i].replace(b"program: spectral 0.", b"program: spectral 9.", 1))
    refused("parts of another program", "the parts record 'program: spectral 9.", "join", STACK)
    restore(1)
    restore(3)
    with open(name_of(2, 3), "wb") as file:
        file.write(b"a file of the user's\n")
    refused("a file that is no part", "is no part of a picture", "join", STACK)
    refused("a file that would be lost", "is no part of a picture, and would be lost", *words_of(2, 3))
    os.remove(name_of(2, 3))
    run(*words_of(2, 3, ("patches", "--size", "3000x1300", "--wavelengths", "450:650:50")))
    refused("other options", "part 1 has 'size: 3000 x 1300", "join", STACK)
    refused("to go on with other options", "was begun with 'size: 3000 x 1300", *words_of(2, 3))
    restore(2)
    run(*words_of(1, 2))
    refused("parts of two counts", "there are parts of 2 and of 3", "join", STACK)
    for words, pattern in ((("--part", "4/3"), "expected a part"), (("--part", "0/3"), "expected a part"), (("--part", "1"), "expected a part"),
                           (("--part", "1/2x"), "expected a part"), (("--part", "1/2", "--keep"), "takes no --keep; join does"),
                           (("--part", "1/2", "--check-map", "a.tif"), "takes no --check-map"),
                           (("--part", "1/2", "-o", "-"), "needs the name of a stack"),
                           (("--part", "1/2", "-o", "/dev/null"), "needs the name of a stack")):
        refused(" ".join(words), pattern, "render", "patches", "-o", STACK, *words)


def changed_scene():
    remove()
    own = write("changed.scene", "size 100 100\nambient d65 1\nmaterial m { diffuse 0.5 }\nobject sphere 1 material m\n")
    scene = (own, "--renderer", "raster")
    draw(2, scene)
    write("changed.scene", open(own).read() + "# a remark\n")
    refused("a scene that has changed", "the parts record 'scene_sha256: ", "join", STACK)
    refused("to go on with a scene that has changed", "was begun with 'scene_sha256: ", *words_of(1, 2, scene))


def different():
    """A fault of OpenGL is found in its part, and in the stack."""
    if not os.path.exists(SPOIL):
        return
    remove()
    fault = {"SPOIL": "diffuse", "LD_PRELOAD": SPOIL}
    scene = ("room", "--gl", "egl", "--size", "1500x1200", "--wavelengths", "500:560:20")
    whole = run("render", *scene, "-o", WHOLE, "-q", "--keep", **fault)
    parts = draw(2, scene, **fault)
    check(whole.returncode == 1 and 1 in [part.returncode for part in parts] and
          any("the part is kept, and join refuses it" in part.stderr for part in parts), "a part differs", *(part.stderr for part in parts))
    refused("a part that differs", whole.stderr.split("; ")[0], "join", STACK, status=1)
    result = run("join", STACK, "--keep", "-q")
    check(result.returncode == 1 and read(STACK) == read(WHOLE), "--keep stores the same bytes and verdict", result.stderr)
    remove()
    words = ("render", *scene, "--resume", "-o", STACK, "-q")
    result = run(*words, **fault)
    check(result.returncode == 1 and "--keep stores it, and draws nothing again" in result.stderr and not os.path.exists(STACK),
          "a resumed render that differs stores nothing", result.stderr)
    result = run(*words, "--keep", "--json", WHOLE + ".json", **fault)
    check(result.returncode == 1 and read(STACK) == read(WHOLE) and files() == [STACK] and
          json.load(open(WHOLE + ".json"))["work"]["gl_passes"] == 0, "with --keep it stores the same bytes, and draws nothing again",
          result.stderr, files())


random.seed(SEED)
shutil.rmtree(TMP, ignore_errors=True)
os.makedirs(TMP)
print(f"# SEED={SEED}")
counts()
killed(20 if FULL else 3)
kinds()
draw_whole()
beginnings()
at_once()
interrupted()
full_disk()
failing_calls()
lost_samples()
draw_whole()
resumed(20 if FULL else 2)
unfinished()
shared()
refusals()
changed_scene()
different()
done()
