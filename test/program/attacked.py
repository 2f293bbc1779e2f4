# SPDX-License-Identifier: MIT
"""Runs commands of the program while something fails (test/program/fail.c), and judges what is left: the right result, or
exit status 3 with one line and nothing written. attack.py and kills.py use it."""
import collections
import json
import os
import re
import shutil
import signal
import struct
import subprocess
from pathlib import Path

import numpy as np
import tifffile

import rendered
from foreign import draw_from

SPECTRAL, TMP = map(os.path.abspath, (rendered.SPECTRAL, rendered.TMP))
KINDS, PROCESSES, NAME = 64, 64, 16  # of struct report in fail.c
REPORT_BYTES = KINDS * NAME + 8 + PROCESSES * 8 * (KINDS + 1)
OLDER = b"This file was here before.\n"
ERROR_LINE = re.compile(r"(\S.*: )?error: ")
MEASURED = re.compile(rb'^seconds .*$|^  (read|plan|gl|raster|check|write|total|processor) .*$|'
                      rb'"(seconds|peak_bytes)": (\{[^}]*\}?|[-+.e\d]*)', re.MULTILINE)
NM = 400, 500, 600, 700
WIDTH, HEIGHT = 12, 8
LONGEST_RUN = 300  # seconds; a longer one hangs

# ---- inputs ----

HEAD = """camera perspective 24 near 5 far 40 eye 0 6 13 look 0.1 0.6 0
ambient d65 0.25
light d65 0.7 position -5 9 8
wavelengths 400 700 100
size 12 8
"""
TEXTS = {
    "plain.scene": HEAD + """material gold metals/gold
material floor { diffuse 0.5 texture grey.tif linear }
object plane 40 40 material floor repeat 12 12 rotate -90 1 0 0
object sphere 1 12 12 material gold translate -1.5 1 0
""",
    "mesh.scene": HEAD + """material wall { diffuse 0.7 spectral-texture foreign.tif linear }
material cloth { diffuse cloth.csv specular 0.05 gloss 40 }
material card { diffuse set.ti3:A2 texture card.png linear }
object plane 20 20 material wall rotate -90 1 0 0
object mesh roof.obj materials roof.map crease 30 translate 1.5 1 0
object mesh roof.obj material cloth translate -1.5 1 0
object sphere 0.6 8 6 material card translate 0 2 2
""",
    "glow.scene": HEAD + """include more.scene
material glowing { diffuse 0.2 donaldson dye.csv }
material paper { diffuse 0.8 fluorescence gaussian:370,40 gaussian:440,60*0.4 }
object plane 40 40 material paper rotate -90 1 0 0
object sphere 1 12 12 material glowing translate 0 1 0
""",
    "tiny.scene": """camera ortho 4
ambient d65 0.25
wavelengths 500 501 1
size 1 1
material grey { diffuse 0.5 }
object plane 8 8 material grey
""",
    "more.scene": "light uv 0.5 position 5 9 8\nchecker own.list sphere 1 8 8\n",
    "own.list": "metals/copper\ncolorchecker/15-red\n",
    "cloth.csv": "nm,reflectance\n400,0.1\n550,0.4\n700,0.3\n",
    "dye.csv": "nm,380,420\n480,0.05,0.02\n520,0.10,0.08\n",
    "set.ti3": "CTI3\nBEGIN_DATA_FORMAT\nSAMPLE_ID SPEC_400 SPEC_700\nEND_DATA_FORMAT\nBEGIN_DATA\nA1 0.2 0.3\nA2 0.4 0.5\nEND_DATA\n",
    "camera.csv": "nm,r,g,b\n400,0,0.1,0.9\n700,0.2,0,0\n",
    "roof.obj": "v -1 0 1\nv 1 0 1\nv 1 1 0\nv -1 1 0\nv 1 0 -1\nv -1 0 -1\n"
                "usemtl red\nf 1 2 3 4\nusemtl other\nf 4 3 5 6\n",
    "roof.map": "red mtl roof.mtl\n* material cloth\n",
    "roof.mtl": "newmtl red\nKd 0.6 0.2 0.1\n",
}


def make_inputs(folder):
    """Scenes with all kinds of files, a grey picture, a foreign stack; stacks of the program itself."""
    os.makedirs(folder)
    pixels = np.random.default_rng(1).random((len(NM), HEIGHT, WIDTH)).astype(np.float32)
    for name, text in TEXTS.items():
        Path(folder, name).write_text(text)
    tifffile.imwrite(os.path.join(folder, "grey.tif"), (pixels[0] * 255).astype(np.uint8), photometric="minisblack")
    with tifffile.TiffWriter(os.path.join(folder, "foreign.tif")) as out:
        for page, nm in zip(pixels, NM):
            out.write(page, metadata=None, contiguous=False, compression="zlib", photometric="minisblack",
                      tile=(16, 16), extratags=[(285, "s", 0, f"{nm} nm", True)])
    for name, words in (("stack.tif", "plain.scene --renderer raster"), ("other.tif", "glow.scene --no-check --renderer raster"),
                        ("basis.tif", "plain.scene --no-check --renderer raster --sampling basis:3"),
                        ("exact.tif", "plain.scene --depth 32f --full-scale 4"), ("part.tif", "plain.scene --part 1/1")):
        # the scene's path stays true when the program makes the stack again
        subprocess.run([SPECTRAL, "render", *("in/" + words).split(), "-q", "-o", "in/" + name],
                       cwd=os.path.dirname(folder), check=True)
    for words in "develop in/stack.tif -q -o in/card.png", "export in/plain.scene --full-scale 4 -o in/room":
        subprocess.run([SPECTRAL, *words.split()], cwd=os.path.dirname(folder), check=True)
    draw_from(*(os.path.join(folder, name) for name in ("room", "exact.tif", "room")))


# ---- commands ----

# nameless: on a file system that cannot keep files without a name. uses_egl: the loader of EGL's drivers gives up where a
# signal interrupts it; the program's handlers do not return, so that none does.
Form = collections.namedtuple("Form", "name words outputs slow uses_egl nameless", defaults=((), *[False] * 3))


def form(name, words, *outputs, slow=False, uses_egl=False):
    return Form(name, words.split(), tuple("out/" + output for output in outputs), slow, uses_egl)


def files_of(a_form):
    """The outputs but for a folder, which is new."""
    return [output for output in a_form.outputs if not output.endswith("/")]


def on_old_file_systems(a_form):
    """The form where each file that is being written has a name."""
    return a_form._replace(name=a_form.name + ", no nameless files", nameless=True)


FORMS = [
    form("render", "render in/plain.scene -o out/a.tif", "a.tif"),
    form("render, all outputs", "render in/plain.scene -o out/a.tif --renderer raster --json out/a.json --check-map out/map.tif "
         "-v", "a.tif", "a.json", "map.tif"),
    form("render, meshes", "render in/mesh.scene -o out/a.tif --check-map out/map.png -q", "a.tif", "map.png"),
    form("render, fluorescence", "render in/glow.scene -o out/a.tif --depth 32f --json -", "a.tif"),
    form("render, raster alone", "render in/mesh.scene --renderer raster --no-check -o out/a.tif", "a.tif"),
    form("render, sampled", "render in/glow.scene --renderer raster --no-check --sampling basis:3 -o out/a.tif -q", "a.tif"),
    form("render to standard output", "render in/glow.scene --renderer raster --no-check -o - -q"),
    form("render, writes nothing", "render in/plain.scene --renderer raster --no-check -o /dev/null --json -"),
    form("render --again", "render --again in/stack.tif -o out/again.tif", "again.tif"),
    form("render, shaders", "render in/plain.scene --renderer gl-shader -o out/a.tif", "a.tif", uses_egl=True),
    form("join", "join in/part.tif -o out/a.tif", "a.tif"),
    form("judge", "judge in/room --json out/a.json --check-map out/map.tif", "a.json",
         "map.tif"),
    form("export", "export in/glow.scene -o out/room", "room/"),
    form("plan", "plan in/mesh.scene"),
    form("plan --json", "plan in/glow.scene --json out/plan.json", "plan.json"),
    form("develop", "develop in/stack.tif -o out/a.png --adaptation cat16 --json out/a.json", "a.png", "a.json"),
    form("develop, TIFF", "develop in/basis.tif -o out/a.tif --exposure auto --bits 16", "a.tif"),
    form("develop, XYZ", "develop in/other.tif --xyz -o out/a.tif -q", "a.tif"),
    form("develop, foreign", "develop in/foreign.tif --white d65 -o out/a.png", "a.png"),
    form("develop to standard output", "develop in/foreign.tif --white d65 -o - -q"),
    form("develop for a camera", "develop in/stack.tif --raw --detector in/camera.csv -o out/a.tif -q", "a.tif"),
    form("probe", "probe in/stack.tif 3 3 4 2"),
    form("probe, objects", "probe in/stack.tif --objects --csv -o out/a.csv", "a.csv"),
    form("probe, CSV", "probe in/other.tif 3 3 --csv -o out/a.csv", "a.csv"),
    form("probe, plot", "probe in/stack.tif 3 3 --svg -o out/a.svg", "a.svg"),
    form("probe, scene", "probe in/glow.scene 3 3"),
    form("probe, foreign", "probe in/foreign.tif 3 3 --white d65 --json -"),
    form("compare", "compare in/stack.tif in/other.tif --map out/map.tif --json out/a.json", "map.tif", "a.json"),
    form("compare, foreign", "compare in/foreign.tif in/stack.tif --white d65 --map out/map.png", "map.png"),
    form("cost", "cost in/tiny.scene --gl osmesa -q -j 1 --json out/cost.json --csv out/cost.csv --svg out/cost.svg",
         "cost.json", "cost.csv", "cost.svg", slow=True),
    form("view", "view in/plain.scene -o out/a.html", "a.html"),
    form("view, picture", "view in/glow.scene -o out/a.png", "a.png"),
    form("view, stack", "view in/stack.tif -o out/a.html", "a.html"),
    form("info", "info in/stack.tif"),
    form("info, texture", "info in/card.png"),
    form("info --json", "info in/basis.tif --json out/a.json", "a.json"),
    form("info, foreign", "info in/foreign.tif"),
    form("envi", "envi in/stack.tif -o out/a.hdr", "a.hdr"),
    form("list", "list"),
    form("list, set", "list in/set.ti3"),
    form("show, spectra", "show in/cloth.csv in/set.ti3:A1 --csv -o out/a.csv", "a.csv"),
    form("show", "show room -o out/room.scene", "room.scene"),
    form("show to standard output", "show d65"),
    form("--help", "--help"),
    form("--version", "--version"),
]
FORMS += [on_old_file_systems(a_form) for a_form in FORMS
          if a_form.name in ("render, all outputs", "compare", "probe, CSV", "envi", "cost")]


# ---- runs ----

Run = collections.namedtuple("Run", "status stdout stderr files temporary inputs report")  # status None: it hung


class Place:
    """A folder for one run at a time: in/ has inputs, out/ outputs; TMPDIR is tmp/."""

    def __init__(self, number, inputs=None):
        self.folder = os.path.join(TMP, str(number))
        self.report = os.path.join(self.folder, "report")
        shutil.rmtree(self.folder, ignore_errors=True)
        os.makedirs(self.folder)
        if inputs:
            shutil.copytree(inputs, self.path("in"))
        else:
            make_inputs(self.path("in"))
        self.environment = {
            "PATH": os.environ["PATH"], "LC_ALL": "C", "HOME": self.folder,
            "TMPDIR": self.path("tmp"), "MESA_SHADER_CACHE_DIR": os.path.join(TMP, "cache")}

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def stamps(self):
        return {entry.name: (entry.stat().st_mtime_ns, entry.stat().st_size) for entry in os.scandir(self.path("in"))}

    def prepare(self, a_form, older):
        for name in ("out", "tmp"):
            os.makedirs(self.path(name), exist_ok=True)
            for left in os.listdir(self.path(name)):  # out may be the root of a file system
                shutil.rmtree(self.path(name, left), ignore_errors=True)
                if os.path.lexists(self.path(name, left)):
                    os.remove(self.path(name, left))
        for output in files_of(a_form) if older else ():
            Path(self.path(output)).write_bytes(OLDER)

    def environment_of(self, a_form, attack=None, depth=None):
        """The variables that load the library; attack None: it only counts."""
        Path(self.report).write_bytes(bytes(REPORT_BYTES))
        more = {"LD_PRELOAD": rendered.FAIL, "FAIL_REPORT": self.report}
        if attack:
            more["FAIL"] = attack
        if depth is not None:
            more["FAIL_DEPTH"] = str(depth)
        if a_form.nameless:
            more["FAIL_NAMELESS"] = "1"
        return {**self.environment, **more}

    def usual_environment(self, a_form):
        """The variables of a run that nobody counts and in which nothing fails."""
        return self.environment_of(a_form) if a_form.nameless else self.environment

    def start(self, a_form, environment=None, **more):
        """Without an environment: the usual one."""
        return subprocess.Popen([SPECTRAL, *a_form.words], cwd=self.folder,
                                env=environment or self.usual_environment(a_form), stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True, **more)

    def run(self, a_form, attack=None, depth=None, older=False, counted=True, longest=LONGEST_RUN, **more):
        """Runs the command to its end. `counted`: with the library; `more` goes to Popen."""
        self.prepare(a_form, older)
        before = self.stamps()
        process = self.start(a_form, self.environment_of(a_form, attack, depth) if counted else None, **more)
        try:
            stdout, stderr = process.communicate(timeout=longest)
            status = process.returncode
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            stdout, stderr = process.communicate()
            status = None
        return Run(status, stdout, stderr.decode("utf-8", "replace"), self.outputs(), os.listdir(self.path("tmp")),
                   before == self.stamps(), Report(self.report) if counted else None)

    def outputs(self):
        found = {}
        for name in os.listdir(self.path("out")):
            path = Path(self.path("out", name))
            if path.is_dir():
                whole = b"".join(inner.read_bytes() for inner in sorted(path.rglob("*")) if inner.is_file())
                found[f"out/{name}/"] = whole.replace(os.path.realpath(self.folder).encode(), b"")
            else:
                found["out/" + name] = path.read_bytes()
        return found


class Report:
    """The report of the library: calls by generation and kind."""

    def __init__(self, path):
        data = Path(path).read_bytes()
        names = [data[i * NAME:(i + 1) * NAME].split(b"\0")[0].decode() for i in range(KINDS)]
        at = KINDS * NAME
        n_processes, = struct.unpack_from("Q", data, at)
        self.counts = {}
        for i in range(min(n_processes, PROCESSES - 1)):  # the last place counts for all further processes
            depth, *counts = struct.unpack_from(f"{KINDS + 1}Q", data, at + 8 + i * 8 * (KINDS + 1))
            kinds = self.counts.setdefault(depth, collections.Counter())
            for name, count in zip(names, counts):
                kinds[name] = max(kinds[name], count)


# ---- judgement ----

def normal(a_form, name, data):
    """The content without seconds and bytes of memory. The order of cost's samplings and its chart follow from seconds."""
    if not name.startswith("out/cost."):
        return MEASURED.sub(b"measured", data)
    if name.endswith(".json") and data.endswith(b"}\n"):
        return sorted((row["options"], row["dE00_mean"], row["dE00_largest"]) for row in json.loads(data)["samplings"])
    if name.endswith(".csv"):
        rows = [line.rsplit(b",", 8) for line in data.splitlines()]
        return sorted((row[0], *row[4:7]) for row in rows)
    return data.startswith(b"<?xml") and data.endswith(b"</svg>\n") or data


def error_lines(run):
    """The program's messages, without those of OpenGL."""
    return [line for line in run.stderr.splitlines() if ERROR_LINE.match(line) and not line.startswith("Mesa ")]


def results(a_form, run):
    """All that is equal in each run that has the same status."""
    return (run.status, normal(a_form, "", run.stdout), error_lines(run),
            {name: normal(a_form, name, data) for name, data in run.files.items()})


def faults(a_form, run, expected, older, naming=False):
    """The set of what is wrong with a run; empty: it has the right result, or none. `expected` are its results when
    nothing fails. naming: an output could not get its name; an earlier one may have got its own, and is whole."""
    found = set()
    if run.temporary or not set(run.files) <= set(a_form.outputs):
        found.add("file left")
    if not run.inputs:
        found.add("input changed")
    if run.status is None:
        found.add("hangs")
    elif run.status < 0:
        found.add("crash")
    elif run.status == expected[0]:
        if results(a_form, run) != expected and "file left" not in found:
            found.add("wrong bytes")
    elif run.status == 3:
        found |= faults_of_refusal(a_form, run, expected, older, naming)
    else:
        found.add("wrong status")
    return found


def faults_of_refusal(a_form, run, expected, older, naming):
    found = set()
    before = dict.fromkeys(files_of(a_form), OLDER) if older else {}
    for output in a_form.outputs:
        data = run.files.get(output)
        whole = naming and data is not None and normal(a_form, output, data) == expected[3].get(output)
        if data != before.get(output) and not whole:
            found.add("output changed")
    if not expected[1].startswith(normal(a_form, "", run.stdout)):
        found.add("wrong bytes")
    if len(error_lines(run)) != 1:
        found.add("not one line")
    return found
