#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes a scene that OpenGL draws wrong as small as it still fails, for the authors of the driver.

    python3 reduce.py SCENE FOLDER [OPTIONS of spectral render, such as --renderer softpipe]

SCENE is a file or a built-in scene. The new folder gets case.scene with its files, and case.c, a program of its own that
shows the failure. The environment variable SPECTRAL names the program to run (default: spectral). Each try is a
`spectral render`. It succeeds if a pixel fails as at first: by its colour, triangle, depth or number of fragments.

Limits: meshes lose triangles, but built-in shapes only become coarser, and material files stay whole. The script finds a
file by its name if that has a point or a slash. case.c has OpenGL's own lighting, of one pass, by at most eight lights
into a buffer of floats; it has no textures, no shaders, and one position a pixel. Run it before you send it."""
import itertools
import json
import os
import re
import shlex
import struct
import subprocess
import sys
import tempfile
import textwrap

SPECTRAL = os.environ.get("SPECTRAL", "spectral")
WORD = re.compile(r'"[^"]*"|[{}]|[^\s{}"]+')
# built-in shapes: how many sizes stand before the counts, and how many counts
COUNTS = {"sphere": (1, 2), "torus": (2, 2), "box": (3, 1), "plane": (2, 1), "cylinder": (2, 2), "cone": (2, 2),
          "disk": (1, 2), "teapot": (1, 1)}
# words behind which a built-in name stands, or a file
NAMED = {"include": "scenes/%s.scene", "mesh": "models/%s.obj", "materials": "models/%s.map",
         "checker": "materials/%s.list"}
PICTURE = {"--size": 1, "--wavelengths": 1}
NOT_OF_EXPORT = {"--renderer": 1, "--gl": 1, "--buffer": 1, "--unchecked": 1, "--strict": 0}
LONGEST = 200  # lines of case.c


def without(options, names):
    """The options without some, which have so many values."""
    left = list(options)
    for i in reversed(range(len(left))):
        name = left[i].split("=")[0]
        if name in names:
            del left[i:i + 1 + (names[name] if name == left[i] else 0)]
    return left


def spectral(*words):
    return subprocess.run([SPECTRAL, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)


# ---- the scene and its files ----

def read(path):
    """The bytes of a file; None: there is none."""
    if path.startswith("builtin:"):
        shown = spectral("show", path)
        return shown.stdout if shown.returncode == 0 else None
    if os.path.isfile(path):
        with open(path, "rb") as file:
            return file.read()
    return None


def words_of(line):
    return WORD.findall(re.sub(r'("[^"]*")|#.*', lambda match: match.group(1) or "", line))


class Case:
    """A scene on its way down: its picture, its statements, and the lines of the files that they name."""

    def __init__(self, path, report, sampled):
        self.size = [report["width"], report["height"]]
        self.bands = None if sampled else report["wavelengths_nm"]
        self.statements, self.files, self.names = [], {}, {}
        self.take_scene(path, read(path))

    def take_scene(self, path, data):
        words = []
        for line in data.decode("latin-1").splitlines():
            words += words_of(line)
            if not words or words.count("{") > words.count("}"):
                continue
            if words[0] == "include":
                self.take_scene(*self.find(path, words[1].strip('"'), "include"))
            elif words[0] != "size" and (words[0] != "wavelengths" or self.bands is None):
                self.statements.append([self.take_word(path, *pair) for pair in zip(words, [""] + words)])
            words = []

    @staticmethod
    def find(base, name, before):
        """The path and the bytes of the file that a word of another file names; None: it names none."""
        paths = ["builtin:" + NAMED[before] % name] if before in NAMED else []
        if paths or re.search("[./]", name) and not re.fullmatch(r"[-+.\deE]*", name):
            paths.append(os.path.join(os.path.dirname(base), name))
        return next(((path, data) for path in paths for data in [read(path)] if data is not None), None)

    def take_word(self, base, word, before=""):
        """A word, or the name of the copy of the file that it names."""
        name, star, factor = word.strip('"').partition("*")
        found = self.find(base, name, before)
        return self.take_file(*found) + star + factor if found else word

    def take_file(self, path, data):
        if path not in self.names:
            name = self.names[path] = f"{len(self.names) + 1}-" + re.sub(r"[^\w.-]", "_", os.path.basename(path))
            lines = data if b"\0" in data else data.decode("latin-1").splitlines()
            if not name.endswith(".obj") and b"\0" not in data:
                lines = [" ".join(self.take_word(path, word) for word in words_of(line)) for line in lines]
            self.files[name] = lines
        return self.names[path]

    def write(self, folder):
        lines = ["size %d %d" % tuple(self.size)] + [" ".join(words) for words in self.statements]
        if self.bands is not None:
            lines.insert(0, "wavelengths list " + " ".join(format(nm, ".17g") for nm in self.bands))
        texts, kept = {"case.scene": lines}, ["case.scene"]
        texts.update(self.files)
        for name in kept:  # grows
            if isinstance(texts[name], list) and not name.endswith(".obj"):
                named = {word.partition("*")[0] for line in texts[name] for word in line.split()}
                kept += [other for other in self.files if other in named and other not in kept]
            with open(os.path.join(folder, name), "wb") as file:
                file.write(texts[name] if isinstance(texts[name], bytes) else
                           "".join(line + "\n" for line in texts[name]).encode("latin-1"))


# ---- tries ----

class Reduction:
    def __init__(self, scene, folder, options):
        self.folder, self.options, self.report, self.tries, self.kept = folder, options, None, 0, 0
        if not self.fails(scene):
            sys.exit(f"reduce.py: {scene} does not differ: {self.message}")
        path = scene if os.path.isfile(scene) or scene.startswith("builtin:") else f"builtin:scenes/{scene}.scene"
        self.options = without(options, PICTURE)
        self.case = Case(path, self.report, "--sampling" in " ".join(options))
        if not self.fails():
            sys.exit(f"reduce.py: {scene} does not differ as a copy: {self.message}")

    def fails(self, scene=None):
        """Draws the scene, or the case. Returns whether it fails as before, and then keeps the report."""
        if not scene:
            scene = os.path.join(self.folder, "case.scene")
            self.case.write(self.folder)
        self.tries += 1
        done = spectral("render", scene, "-o", "/dev/null", "--json", "-", *self.options)
        lines = done.stderr.decode("utf-8", "replace").strip().split("\n")
        self.message = lines[-1].replace(self.folder + "/", "").replace("; no stack was wanted", "")
        report = json.loads(done.stdout) if done.returncode == 1 else {"verdict": ""}
        first = (report.get("check") or {}).get("first_unexplained") or {"what": None}
        report.update(first=first, message=self.message, kind=first["what"])
        known = (report["kind"], "bands" if report["kind"] == "radiance" else report["kind"])
        if report["verdict"] != "differs" or self.report and self.report["kind"] not in known:
            return False
        self.report = report
        return True

    def attempt(self, holder, key, value):
        """Puts a value in the place of another, if it fails with that."""
        old, holder[key] = holder[key], value
        if value == old or not self.fails():
            holder[key] = old
            return False
        self.kept += 1
        return True

    def thin(self, holder, key, least=0, keep=lambda item: False):
        """Leaves out all of a list, its halves, its quarters, and so on (Zeller and Hildebrandt 2002)."""
        step = len(holder[key])
        while step > 0:
            at = 0
            while at < len(holder[key]):
                items = holder[key]
                left = items[:at] + [item for item in items[at:at + step] if keep(item)] + items[at + step:]
                if len(left) < least or not self.attempt(holder, key, left):
                    at += step
            step //= 2

    def shrink_picture(self):
        case = vars(self.case)
        for across, down in ((2, 2), (2, 1), (1, 2)):
            while self.attempt(case, "size", [-(-case["size"][0] // across), -(-case["size"][1] // down)]):
                pass
        if case["bands"]:
            self.thin(case, "bands", 1)

    def simplify_objects(self):
        """Leaves out textures, and gives built-in shapes as few triangles as they fail with."""
        for index, words in enumerate(self.case.statements):
            if words[0] == "material":
                plain = re.sub(r" (spectral-)?texture \S+( nearest| linear| bilinear)?", "", " ".join(words))
                self.attempt(self.case.statements, index, plain.split(" "))
            at = next((i for i, word in enumerate(words[:3]) if word in COUNTS), None)
            if at is None or words[0] not in ("object", "checker"):
                continue
            sizes, n_counts = COUNTS[words[at]]
            counts = list(itertools.takewhile(lambda word: re.match(r"\d", word), words[at + 1 + sizes:]))
            for n in (1, 2, 3, 4, 6, 8, 12, 16, 24):
                fewer = words[:at + 1 + sizes] + [str(n)] * n_counts + words[at + 1 + sizes + len(counts):]
                if counts and n >= max(map(int, counts)) or self.attempt(self.case.statements, index, fewer):
                    break

    def run(self):
        before = None
        while before != self.kept:
            before = self.kept
            self.thin(vars(self.case), "statements")
            for name in self.case.files:
                if name.endswith((".map", ".list")):
                    self.thin(self.case.files, name)
            self.shrink_picture()
            self.simplify_objects()
            for name in self.case.files:
                if name.endswith(".obj"):
                    self.thin(self.case.files, name, keep=lambda line: not line.startswith("f "))
        if not self.fails():
            sys.exit("reduce.py: the case does not fail again: the driver is not steady")


# ---- the program in C ----

PROGRAM = """/* @message@
 * @driver@; made small from @scene@ by reduce.py.
 * Exit status 1: this OpenGL is wrong.
 *     gcc case.c -lOSMesa -lm && ./a.out               or, without OSMesa:
 *     gcc -DEGL case.c -lEGL -lGL -lm && ./a.out */
#define GL_GLEXT_PROTOTYPES
#ifdef EGL
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#define READ_COLOURS() glReadPixels(0, 0, WIDTH, HEIGHT, GL_RGBA, GL_FLOAT, pixels)
#define ROW Y
#else
#include <GL/osmesa.h>
#define READ_COLOURS() glFinish() /* OSMesa draws into them */
#define ROW (HEIGHT - 1 - Y)
#endif
#include <GL/glext.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = @width@, HEIGHT = @height@, X = @x@, Y = @y@ }; /* the pixel, from the top left */
static GLfloat pixels[HEIGHT][WIDTH][4];
static GLuint depths[HEIGHT][WIDTH]; /* 24 bits of depth, 8 that count fragments */
@tables@

static void open_context(void)
{
#ifdef EGL
    GLuint frame, buffers[2];
    EGLDisplay display = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    eglInitialize(display, NULL, NULL);
    eglBindAPI(EGL_OPENGL_API);
    EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, NULL);
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
        exit(3);
    glGenFramebuffers(1, &frame);
    glBindFramebuffer(GL_FRAMEBUFFER, frame);
    glGenRenderbuffers(2, buffers);
    for (int i = 0; i < 2; i++) {
        const GLenum to = i ? GL_DEPTH_STENCIL_ATTACHMENT : GL_COLOR_ATTACHMENT0;
        glBindRenderbuffer(GL_RENDERBUFFER, buffers[i]);
        glRenderbufferStorage(GL_RENDERBUFFER, i ? GL_DEPTH24_STENCIL8 : GL_RGBA32F, WIDTH, HEIGHT);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, to, GL_RENDERBUFFER, buffers[i]);
    }
    glViewport(0, 0, WIDTH, HEIGHT);
    glClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE); /* the first row is the top one */
#else
    OSMesaContext context = OSMesaCreateContextExt(OSMESA_RGBA, 24, 8, 0, NULL);
    if (!context || !OSMesaMakeCurrent(context, pixels, GL_FLOAT, WIDTH, HEIGHT))
        exit(3);
    OSMesaPixelStore(OSMESA_Y_UP, 0); /* the first row is the top one */
#endif
}

int main(void)
{
@calls@
    READ_COLOURS();
    glReadPixels(0, 0, WIDTH, HEIGHT, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, depths);
    const double found = @found@, expected = @expected@, bound = @bound@;
    printf("pixel %d,%d: expected @not@%.9g, found %.9g, bound %.3g @unit@\\n", X, Y, expected, found, bound);
    return @wrong@;
}
"""
STATE = """setenv("GALLIUM_DRIVER", "@driver@", 1)
open_context()
glClampColor(GL_CLAMP_VERTEX_COLOR, GL_FALSE)
glClampColor(GL_CLAMP_FRAGMENT_COLOR, GL_FALSE)
glClampColor(GL_CLAMP_READ_COLOR, GL_FALSE)
glDisable(GL_DITHER)
glEnable(GL_DEPTH_TEST)
glDepthFunc(GL_LESS)
glEnableClientState(GL_VERTEX_ARRAY)
glVertexPointer(3, GL_FLOAT, sizeof *vertices, vertices[0])
glMatrixMode(GL_PROJECTION)
glLoadMatrixd(@projection@)
glMatrixMode(GL_MODELVIEW)
glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT)
"""
LIT = """glShadeModel(@shading@)
glEnable(GL_NORMALIZE)
glEnable(GL_LIGHTING)
glLightModelfv(GL_LIGHT_MODEL_AMBIENT, (GLfloat[]){1, 1, 1, 1})
glLightModeli(GL_LIGHT_MODEL_LOCAL_VIEWER, @local@)
glMaterialfv(GL_FRONT_AND_BACK, GL_DIFFUSE, (GLfloat[]){1, 1, 1, 1})
glEnableClientState(GL_NORMAL_ARRAY)
glNormalPointer(GL_FLOAT, sizeof *vertices, vertices[0] + 3)
"""
NUMBERED = """glShadeModel(GL_FLAT)
glEnable(GL_STENCIL_TEST)
glStencilOp(GL_INCR_WRAP, GL_INCR_WRAP, GL_INCR_WRAP)
glEnableClientState(GL_COLOR_ARRAY)
glColorPointer(3, GL_FLOAT, sizeof *vertices, vertices[0] + 3)
"""
# how the program finds the value, whether this is wrong, and its unit
FOUND = {"radiance": ("65535.0 * pixels[Y][X][@channel@]", "!(fabs(found - expected) <= bound)", "counts of 65535"),
         "bands": ("65535.0 * pixels[Y][X][@channel@]", "!(fabs(found - expected) <= bound)", "counts of 65535"),
         "depth": ("(depths[ROW][X] >> 8) / 16777215.0", "!(fabs(found - expected) <= bound)", "of near to far"),
         "fragments": ("depths[ROW][X] & 255", "found == @seen@", "fragments"),
         "triangle": ("1e6 * pixels[Y][X][2] + 65536 * pixels[Y][X][1] + pixels[Y][X][0]", "found == expected",
                      "(1e6 x instance + triangle; 0 is the background)")}


def array(values, sort="GLfloat"):
    return "(%s[]){%s}" % (sort, ", ".join(format(float(v), ".9g" if sort == "GLfloat" else ".17g") for v in values))


def matrix(rows):
    return array([rows[4 * j + i] for i in range(4) for j in range(4)], "GLdouble")


def place_light(line):
    """Yields the calls for a light in eye coordinates, a line `source` of scene.txt."""
    _, index, kind, *words = line
    name = f"GL_LIGHT{index}"
    yield f"glEnable({name})"
    yield f"glLightfv({name}, GL_AMBIENT, {array([0, 0, 0, 1])})"
    yield f"glLightfv({name}, GL_POSITION, {array(words[:3] + [kind == 'positional'])})"
    for which, value in zip(("CONSTANT", "LINEAR", "QUADRATIC"), words[4:7]):
        yield f"glLightf({name}, GL_{which}_ATTENUATION, {value})"
    if words[7:]:
        yield f"glLightfv({name}, GL_SPOT_DIRECTION, {array(words[8:11])})"
        yield f"glLightf({name}, GL_SPOT_CUTOFF, {words[11]})"
        yield f"glLightf({name}, GL_SPOT_EXPONENT, {words[12]})"


def set_colours(line):
    """Yields the calls for a line of passes.txt."""
    values = line[4:]
    if line[0] == "light":
        name = f"GL_LIGHT{values[0]}"
        yield f"glLightfv({name}, GL_DIFFUSE, {array(values[1:4] + [1])})"
        yield f"glLightfv({name}, GL_SPECULAR, {array(values[4:7] + [1])})"
    else:
        shines = float(values[3]) >= 0
        yield f"glMaterialfv(GL_FRONT_AND_BACK, GL_AMBIENT, {array(values[:3] + [1])})"
        yield f"glMaterialfv(GL_FRONT_AND_BACK, GL_SPECULAR, {array([shines] * 3 + [1])})"
        if shines:
            yield f"glMaterialf(GL_FRONT_AND_BACK, GL_SHININESS, {values[3]})"


class Export:
    """The files that spectral export writes, as tables and calls."""

    def __init__(self, folder, numbered):
        self.folder, self.numbered, self.vertices, self.triangles, self.first = folder, numbered, [], [], {}
        self.scene, self.passes = ([line.split() for line in read(os.path.join(folder, name)).decode().splitlines()]
                                   for name in ("scene.txt", "passes.txt"))
        self.one = {line[0]: line[1:] for line in self.scene}
        self.instances = [line for line in self.scene if line[0] == "instance"]
        for line in self.instances:
            self.add(int(line[1]), line[3])

    def add(self, number, mesh):
        """Adds the triangles of an instance. Where they are numbered, they share no corners."""
        rows, corners = (list(struct.iter_unpack(form, read(os.path.join(self.folder, f"{name}-{mesh}.bin"))))
                         for name, form in (("vertices", "=8f"), ("triangles", "=3i")))
        start, self.first[number] = len(self.vertices), (len(self.triangles), len(corners))
        if self.numbered:
            rows = [rows[c][:3] + (i & 0xffff, i >> 16, number) for i, triangle in enumerate(corners) for c in triangle]
            corners = [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(len(corners))]
        used = {c: start + i for i, c in enumerate(sorted({c for triangle in corners for c in triangle}))}
        self.vertices += [rows[c][:6] for c in used]
        self.triangles += [[used[c] for c in triangle] for triangle in corners]

    def draw(self, band):
        """Yields the calls that draw the numbers of triangles, or the pass that begins with a band."""
        for line in self.scene:
            if line[0] == "source" and not self.numbered:
                yield from place_light(line)
        for _, number, _, _, _, material, _, _, sides, front, _, *rows in self.instances:
            for line in self.passes:
                if line[1:4] == [str(band), "0", material] and not self.numbered:
                    yield from set_colours(line)
            first, n = self.first[int(number)]
            yield f"glLightModeli(GL_LIGHT_MODEL_TWO_SIDE, {int(sides == 'two-sided')})"
            yield f"glFrontFace({'GL_CW' if front == 'clockwise' else 'GL_CCW'})"
            yield f"glLoadMatrixd({matrix(rows)})"
            yield (f"glDrawArrays(GL_TRIANGLES, {3 * first}, {3 * n})" if self.numbered else
                   f"glDrawElements(GL_TRIANGLES, {3 * n}, GL_UNSIGNED_INT, triangles[{first}])")


def table(head, rows, form):
    """A table of C, several rows a line."""
    words = " ".join("{" + ", ".join(format(value, form) for value in row) + "}," for row in rows)
    return "static const " + head + " = {\n" + textwrap.fill(words, 110, break_on_hyphens=False) + "\n};\n"


def program_of(reduction, scene):
    """The text of case.c; without one, why there is none."""
    report, first, kind = reduction.report, reduction.report["first"], reduction.report["kind"]
    if kind is None:
        return None, "no single pixel is wrong"
    folder = os.path.join(reduction.folder, "export")
    case = os.path.join(reduction.folder, "case.scene")
    options = without(reduction.options, NOT_OF_EXPORT)
    exported = spectral("export", case, "-o", folder, *options)
    if exported.returncode:
        return None, "spectral export says " + exported.stderr.decode("utf-8", "replace").strip()
    export = Export(folder, kind not in ("radiance", "bands"))
    if export.one["size"] != [str(report["width"]), str(report["height"])]:
        return None, "it has several positions a pixel"
    if not export.numbered and ("texture" in export.one or any(line[2:3] == ["1"] for line in export.passes)):
        return None, "it needs a texture, or more than eight lights"
    band = next((int(line[1]) for line in export.scene if line[0] == "band" and " ".join(line[2:]) == first["page"]), 0)
    expected = repr(first.get("expected", 1e6 * first.get("shown_instance", 0) + (first.get("shown_triangle") or 0)))
    if kind == "bands":  # its bound holds for what the other band calls for
        if reduction.case.bands is None or len(reduction.case.bands) != 2:
            return None, "more than two wavelengths show it"
        probed = spectral("probe", case, str(first["x"]), str(first["y"]), "--json", "-", *options)
        radiance = json.loads(probed.stdout)["radiance"]
        expected = f"65535.0 * pixels[Y][X][{1 - band}] * {radiance[band]!r} / {radiance[1 - band]!r}"
    driver = report["gl_renderer"].split()[0]
    calls = (STATE + (NUMBERED if export.numbered else LIT)).splitlines() + list(export.draw(band - band % 3))
    calls = calls[0 if driver in ("llvmpipe", "softpipe") else 1:]
    found, wrong, unit = FOUND[kind]
    values = {"message": report["message"], "driver": driver, "scene": scene, "x": first["x"], "y": first["y"],
              "width": report["width"], "height": report["height"], "projection": matrix(export.one["projection"]),
              "found": found.replace("@channel@", str(band % 3)), "wrong": wrong, "unit": unit,
              "expected": expected, "bound": repr(first.get("bound", 0)),
              "seen": repr(first.get("found")), "not": "not " if kind == "triangle" else "",
              "tables": table("GLfloat vertices[][6]", export.vertices, ".9g") +
                        ("" if export.numbered else table("GLuint triangles[][3]", export.triangles, "d")),
              "shading": "GL_" + export.one["shading"][0].upper(), "local": int(export.one["viewer"] == ["local"])}
    text = PROGRAM.replace("@calls@", "\n".join(f"    {call};" for call in calls)).replace("@wrong@", wrong)
    text = re.sub("@([a-z]+)@", lambda match: str(values[match.group(1)]).replace("*/", "* /"), text)
    return (text, "") if text.count("\n") <= LONGEST else (None, f"it would have more than {LONGEST} lines")


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    scene, folder, *options = sys.argv[1:]
    if os.path.lexists(folder):
        sys.exit(f"reduce.py: {folder} exists already")
    with tempfile.TemporaryDirectory() as tries:
        reduction = Reduction(scene, tries, options)
        reduction.run()
        text, reason = program_of(reduction, scene)
    os.mkdir(folder)
    reduction.case.write(folder)
    if text:
        with open(os.path.join(folder, "case.c"), "w", encoding="utf-8") as file:
            file.write(text)
    print(f"{reduction.report['message']}\n{reduction.tries} tries; to repeat:")
    words = [SPECTRAL, "render", os.path.join(folder, "case.scene"), "-o", "/dev/null"] + reduction.options
    print("   ", *map(shlex.quote, words))
    source = shlex.quote(os.path.join(folder, "case.c"))
    print(f"    gcc {source} -lOSMesa -lm && ./a.out" if text else f"there is no case.c: {reason}")


main()
