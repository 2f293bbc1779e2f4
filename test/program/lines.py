#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: full release; makes: command_table sanitized
"""Command lines at random, made from the tables of commands and options, run by the program under sanitizers. Whatever a
user types, the program does it or refuses it: no wrong access, no undefined behaviour, no signal. Runs for $SECONDS_OF_LINES, or a
minute (SOAK=1, `test release`: five); begins with the number $SEED. A line that fails is printed as a shell takes it."""
import os
import random
import shlex
import shutil
import time

from sanitized import SMALL, TMP, finding, prepare, run, tables
from tap import amount, check, done

SECONDS = float(os.environ.get("SECONDS_OF_LINES", amount("60", "60", "300")))
SEED = int(os.environ.get("SEED", str(time.time_ns() % 10**9)))
FILES = ["stack.tif", "other.tif", "rgb.tif", "part.tif", "picture.tif", "picture.png", "my.scene", "exported", "folder", "missing"]
SCENES = ["patches", "my.scene", "spheres", "textures", "fluorescence", "metals", "glow", "-", "scenes", "d65", "a", "cie1931"]
OUTPUTS = ["page", "-", "page.tif", "page.png", "page.html", "PAGE.PNG", "page.xyz", "folder", "/dev/null", "/dev/full", "",
           "page.planes", "page.json", "page.", "missing/x.tif", "stack.tif"]
NUMBERS = ["0", "1", "-1", "2", "3", "0.5", "1e-300", "1e300", "-0", "nan", "inf", "0x10", "1e", "", "99999999999", "7", "20", "100%", "1dE00"]
WORDS = ["a", "d65", "cie1931", "dcs200-camera", "xyz", "rgb", "gauss:3", "box:2", "basis:2", "riemann:50", "adaptive:0.1", "gauss:0",
         "gauss:3,xyz", "1=a", "1=a*2", "2=d65", "9=a", "d65*0.1", "daylight:6500", "blackbody:1", "1/1", "2/3", "0/0", "1/999999", "sphere",
         "teapot", "raster", "llvmpipe", "softpipe", "gl-shader", "gl", "smooth", "flat", "phong", "auto", "monitor", "cat16", "srgb",
         "12x9", "1x1", "0x0", "16x", "65536x1", "99999x99999", "400:700:150", "500,600", "500:400:1", "400:700:0", "1:2", ":", ",", "%s"]

SLOW = "cost", "verify", "judge", "drivers"  # seldom, so that there are more lines of the others


def value_of(dice, option):
    """Returns a value, mostly one of the option's own kind."""
    if dice.random() < 0.1:
        return dice.choice(NUMBERS + WORDS + OUTPUTS)
    if option["choices"]:
        return dice.choice(option["choices"])
    if option["writes"]:
        return dice.choice(OUTPUTS)
    if option["kind"] in ("number", "count") and dice.random() < 0.7:
        return f"{dice.choice([option['lowest'], option['lowest'] - 1, option['lowest'] + 1, min(option['highest'], 8)]):.17g}"
    if "|" in option["value"]:
        return dice.choice(option["value"].split("|")).partition("[")[0]
    if option["value"] == "WxH":
        return f"{dice.randint(1, 24)}x{dice.randint(1, 18)}"
    return dice.choice(FILES if "STACK" in option["value"] or "FILE" in option["value"] else NUMBERS + WORDS)


def line_of(dice, commands):
    """Returns the words of a command line. Pictures are small unless an option says otherwise."""
    command = dice.choice([name for name in commands if name not in SLOW or dice.random() < 0.05])
    n_operands, options = commands[command]
    words = [dice.choice(FILES + SCENES if dice.random() < 0.9 else NUMBERS + WORDS) for _ in range(dice.randint(0, min(n_operands, 3)))]
    if command in ("probe",) and words and dice.random() < 0.8:
        words = words[:1] + [str(dice.randint(-1, 17)) for _ in range(dice.choice([0, 1, 2, 2, 2, 4, 4]))]
    if any("--size" in option["names"] for option in options) and (not words or words[0] not in FILES[:6]):
        words += SMALL
    for _ in range(dice.choice([0, 1, 1, 2, 2, 3, 4, 6])):
        option = dice.choice(options)
        name = dice.choice(option["names"])
        if dice.random() < 0.05:
            name = name[: dice.randint(1, len(name))]
        words.append(name)
        if option["value"] and dice.random() < 0.97:
            words.append(value_of(dice, option))
    if dice.random() < 0.2:
        dice.shuffle(words)
    return [command, *words]


prepare()
dice, commands, end = random.Random(SEED), tables(), time.monotonic() + SECONDS
shutil.copytree(TMP, TMP + ".kept", dirs_exist_ok=True)
n = n_late = 0
statuses = {}
failed = []
while time.monotonic() < end and len(failed) < 10:
    words = line_of(dice, commands)
    status, _, errors = run(words, 20)
    n += 1
    statuses[status] = statuses.get(status, 0) + 1
    if finding(status, errors):
        failed.append(shlex.join(["spectral", *words]))
        check(False, failed[-1], f"status {status}", errors[-3000:])
    if n % 100 == 0:  # a line may replace the files
        shutil.rmtree(TMP)
        shutil.copytree(TMP + ".kept", TMP)
check(not failed, f"{n} command lines from the number {SEED} on are run or refused")
check(statuses.get(0, 0) > n / 20, f"statuses: {statuses}")
done()
