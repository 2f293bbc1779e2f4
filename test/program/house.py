#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first
"""Checks the layering of the sources. Prints TAP, and fails on each place that breaks a rule.

A room is a folder with one public header, named like the folder: data/text/text.h. What only its own
files share is in its inside.h. ROOMS lists the rooms from low to high. A file includes spectral.h, both
headers of its own room, and public headers of rooms listed before it: so the core includes nothing of
raster/beside/. The trusted core, raster/reference, includes data/maths and the C library only, and data/maths
the C library only, so that the two can be read and compiled alone. Sizes have budgets.

The last part of the test shows that the test can fail: it plants one fault at a time into the texts of the
sources, and expects one finding that names the place.

    test/program/house.py                   the test
    test/program/house.py --count           lines of code by room
    test/program/house.py --findings        the findings alone, without TAP
    a second argument               another root folder"""
import collections
import functools
import os
import re
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "shared"))  # also for `python3 house.py`
from tap import check, done

ROOMS = """
    data/base data/files data/maths data/text data/spectra data/mesh data/images data/scene
    data/sampling data/stack
    raster/reference raster/visibility raster/renderers raster/plan raster/bounds raster/volumes raster/candidates raster/counts
    raster/check
    raster/gl raster/render
    raster/beside/shader raster/beside/measure raster/beside/colour raster/beside/accuracy raster/beside/see
    raster/beside/cost raster/beside/view raster/beside/verify
    """.split()
BESIDE = "raster/beside"  # the folder of the rooms that the core does not know, and of the tables of programs
MOST_ROOMS = 29  # two of them for shadows
MOST_EDGES = 150  # pairs of rooms whose first includes a header of the second
ORDER = ["spectral.h", *ROOMS, BESIDE, "spectral.c"]
INCLUDE_ONCE = ("data/", BESIDE + "/")  # files here include nothing that another include of theirs brings
CORE = "raster/reference"
CORE_MAY_INCLUDE = {CORE, "data/maths"}
# A system header that matches the pattern belongs in these rooms only.
SYSTEM_HEADERS = (
    (r"(E?GL|GLES\d*|KHR)/|osmesa", {"raster/gl"}, "OpenGL"),
    (r"tiff", {"data/images", "data/stack"}, "libtiff"),
)
C_LIBRARY = {name + ".h" for name in """
    assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdarg
    stdbool stddef stdint stdio stdlib string tgmath time wchar wctype""".split()}
# Functions of <math.h> that C libraries round differently, or that some emulated processors have wrong: see
# data/maths/elementary.c, which has them, or lists what may be called instead.
NOT_ALIKE = {name + width for width in ("", "f", "l") for name in """
    acos asin atan atan2 cos sin sincos tan acosh asinh atanh cosh sinh tanh exp exp2 exp10 expm1 log log10 log1p log2 cbrt hypot pow erf erfc
    lgamma tgamma remquo""".split()}
FORBIDDEN_NAMES = set("""
    finish setting part use products trials truth body tally samples weighing keyword""".split())
# An underscore separates words. A line that cites OpenGL's specification may name OpenGL.
FORBIDDEN_IN_CORE = re.compile(
    r"(?<![A-Za-z0-9])((?i:osmesa|gl|llvmpipe|softpipe|slacks?|opengl|drivers?|tiles?|bounds?)"
    r"(?![A-Za-z0-9])|gl[A-Z]\w*)")
MAY_BE_CITED = {"gl", "opengl"}

# Lines of a function count blanks and comments; lines of code do not.
FILE_CODE = 500
# Rooms that have a budget, in lines of code, with the reason.
TRUSTED = "raster/reference", "raster/visibility", "data/maths"
TOGETHER = {
    "raster/reference": ([CORE], 740),  # it is read first, alone
    "trusted code": (TRUSTED, 1600),  # a user must believe it, and reads it in an hour and a half
    # a small single-purpose tool: who adds to it takes something out, or raises this in a commit of its own that says why
    "own C": (ORDER, 37_000),
    # the core is the minimal program, which renders, checks and stores; the rest stands beside it
    "the core": ([room for room in ORDER if not room.startswith(BESIDE)], 27_800),
}
FUNCTION_LINES = 50
FUNCTION_PARAMETERS = 6

# Functions that only their own file and tests use, each with the reason why a test needs it by itself.
FOR_TESTS = {
    "files_read_forget": "a test writes and reads the same file several times",
    "option_at": "tests make command lines of each command's options",
    "sampling_make": "a test samples spectra that no scene has",
}

Finding = collections.namedtuple("Finding", "path line says")
Function = collections.namedtuple("Function", "name line n_lines n_parameters is_static")
Struct = collections.namedtuple("Struct", "name line inside")


def show(finding):
    return f"{finding.path}:{finding.line}: {finding.says}"


# ---- reading C: enough of it to find includes, functions, prototypes and structs ----

COMMENT_OR_STRING = re.compile(
    r"/\*.*?\*/|//(?:\\\n|[^\n])*|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'", re.DOTALL)
DIRECTIVE = re.compile(r"^[ \t]*#(?:\\\n|[^\n])*", re.MULTILINE)
INCLUDE = re.compile(r"[ \t]*#[ \t]*include[ \t]*([<\"])([^>\"\n]*)[>\"]")
TOKEN = re.compile(r"\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|[A-Za-z_]\w*|\.?\d(?:[eEpP][+-]|[\w.])*|\S")
MACRO = re.compile(r"[A-Z][A-Z0-9_]*$|__attribute__$")  # as PRINTF_LIKE(2, 3) before a prototype
NOT_NAMES = {"void", "bool", "char", "int", "long", "unsigned", "float", "double"}


def blank(match):
    """Spaces for the text, with its line ends kept."""
    return re.sub(r"[^\n]", " ", match.group())


class Source:
    """The parts of one file that the rules need."""

    def __init__(self, text):
        self.lines = text.splitlines()
        plain = COMMENT_OR_STRING.sub(
            lambda match: blank(match) if match.group()[0] == "/" else match.group(), text)
        self.n_code = sum(1 for line in plain.splitlines() if line.strip())
        self.includes = []  # line, quote, path
        self.functions, self.prototypes, self.structs = [], [], []
        self.balanced = True
        for directive in DIRECTIVE.finditer(plain):
            include = INCLUDE.match(directive.group())
            if include:
                self.includes.append((plain.count("\n", 0, directive.start()) + 1, *include.groups()))
        tokens = self.tokens(re.sub(INCLUDE, blank, plain))
        self.words = collections.Counter(word for word, _ in tokens)
        self.calls = [(word, line) for (word, line), (after, _) in zip(tokens, tokens[1:]) if after == "("]
        self.struct_names = self.structs_named(tokens)
        self.read_statements(self.tokens(DIRECTIVE.sub(blank, plain)))

    @staticmethod
    def tokens(text):
        """[(token, line)]; every string is the token \"\"."""
        result, line, at = [], 1, 0
        for match in TOKEN.finditer(text):
            line += text.count("\n", at, match.start())
            at = match.start()
            token = match.group()
            result.append(('""' if token[0] in "\"'" and len(token) > 1 else token, line))
        return result

    @staticmethod
    def structs_named(tokens):
        """Counts how often each name follows the word struct or union."""
        return collections.Counter(name for (word, _), (name, _) in zip(tokens, tokens[1:])
                                   if word in ("struct", "union"))

    def read_statements(self, tokens):
        """A statement at file level ends with ';' or with the body of a function."""
        start = at = 0
        while at < len(tokens):
            token = tokens[at][0]
            if token == "{":
                end = self.closing(tokens, at)
                is_function = tokens[at - 1][0] == ")" and self.function(tokens, start, at, end)
                if not is_function:
                    self.struct(tokens, at, end)
                at = end
                if is_function:
                    start = at + 1
            elif token == ";":
                self.prototype(tokens, start, at)
                start = at + 1
            elif token == "}":
                self.balanced = False
            at += 1

    def closing(self, tokens, opening):
        """The index of the token that closes the brace or parenthesis at this index."""
        pair = {"{": "}", "(": ")"}
        opens, closes, depth = tokens[opening][0], pair[tokens[opening][0]], 0
        for at in range(opening, len(tokens)):
            depth += (tokens[at][0] == opens) - (tokens[at][0] == closes)
            if depth == 0:
                return at
        self.balanced = False
        return len(tokens) - 1

    def head(self, tokens, start, end):
        """The name and parameters of the function that a statement declares, or None."""
        words = [token for token, _ in tokens[start:end]]
        if not words or words[0] == "typedef":
            return None
        for at in range(start + 1, end):
            if tokens[at][0] in ("=", "{"):
                return None
            if tokens[at][0] == "(":
                name, line = tokens[at - 1]
                if MACRO.match(name):
                    continue
                if not re.match(r"[A-Za-z_]", name) or name in NOT_NAMES or tokens[at + 1][0] == "*":
                    return None
                inside = [token for token, _ in tokens[at + 1:self.closing(tokens, at)]]
                return name, line, self.n_parameters(inside), "static" in words
        return None

    @staticmethod
    def n_parameters(inside):
        if inside in ([], ["void"]):
            return 0
        depth, count = 0, 1
        for token in inside:
            depth += (token in "([") - (token in ")]")
            count += token == "," and depth == 0
        return count

    def function(self, tokens, start, opening, end):
        found = self.head(tokens, start, opening)
        if found:
            name, line, n_parameters, is_static = found
            n_lines = tokens[end][1] - line + 1
            self.functions.append(Function(name, line, n_lines, n_parameters, is_static))
        return found is not None

    def prototype(self, tokens, start, end):
        found = self.head(tokens, start, end)
        if found:
            name, line, n_parameters, is_static = found
            self.prototypes.append(Function(name, line, 0, n_parameters, is_static))

    def struct(self, tokens, opening, end):
        """A struct definition; counts also how often the struct names itself inside its braces."""
        if opening >= 2 and tokens[opening - 2][0] in ("struct", "union"):
            name, line = tokens[opening - 1]
            inside = self.structs_named(tokens[opening:end])[name]
            self.structs.append(Struct(name, line, inside))


@functools.lru_cache(maxsize=None)
def read_source(text):
    return Source(text)


class Tree:
    """The sources, and the tests that use them, from {path: text}."""

    def __init__(self, texts):
        self.sources, self.tests = {}, {}
        for path, text in texts.items():
            (self.tests if path.startswith("test/") else self.sources)[path] = read_source(text)

    def files(self, room):
        return {path: source for path, source in self.sources.items() if room_of(path) == room}

    def rooms(self):
        """Rooms with sources, in the order of ROOMS, then unknown ones."""
        present = {room_of(path) for path in self.sources}
        known = [room for room in ORDER if room in present]
        return known + sorted(present - set(known))

    def code(self, room):
        return sum(source.n_code for source in self.files(room).values())


def texts_below(root):
    """{path: text} of all sources and tests. The sample program is no part of them."""
    paths = ["spectral.h", "spectral.c"]
    for top in "data", "raster", "test":
        for folder, folders, names in os.walk(os.path.join(root, top)):
            folders[:] = sorted(set(folders) - ({"samples", "wasi"} if folder.endswith("/data") else set()))
            paths += [os.path.relpath(os.path.join(folder, name), root) for name in sorted(names) if name.endswith((".c", ".h"))]
    texts = {}
    for path in paths:
        with open(os.path.join(root, path), encoding="utf-8") as file:
            texts[path] = file.read()
    return texts


# ---- the rules; each returns findings ----

def room_of(path):
    """The folder of a file; spectral.h and spectral.c stand for themselves."""
    return os.path.dirname(path) or path


def header_of(room):
    return f"{room}/{os.path.basename(room)}.h"


def inside_of(room):
    return f"{room}/inside.h"


def height(room):
    return ORDER.index(room) if room in ORDER else None


def quoted_fault(tree, path, included):
    """Returns the fault of #include "included" in the file path, or None."""
    room, target = room_of(path), room_of(included)
    if target in ROOMS and included == inside_of(target) and target != room:
        return f"\"{included}\" is for the files of {target} alone; include \"{header_of(target)}\""
    if included != "spectral.h" and (target not in ROOMS or included not in (header_of(target), inside_of(target))):
        right = "a path from the root to a room's header, as \"data/text/text.h\""
        return f"\"{included}\" is not the header of a room; include {right}"
    if included not in tree.sources:
        return f"\"{included}\" does not exist; include a header that does"
    if room in CORE_MAY_INCLUDE and target not in CORE_MAY_INCLUDE:
        return (f"the core includes \"{included}\"; {room} may include only "
                f"{' and '.join(sorted(CORE_MAY_INCLUDE))} and the C library")
    if height(room) is not None and height(target) > height(room):
        return (f"the include of \"{included}\" runs upward; {room} may include only rooms that "
                f"ROOMS (test/program/house.py) lists before it")
    return None


def system_fault(path, included):
    """Returns the fault of #include <included> in the file path, or None."""
    room = room_of(path)
    if room_of(included) in ROOMS or included == "spectral.h":
        return f"<{included}> is a header of this project; include \"{included}\""
    if room in CORE_MAY_INCLUDE and included not in C_LIBRARY:
        return f"the core includes <{included}>; {room} may include headers of C99 only"
    for pattern, rooms, name in SYSTEM_HEADERS:
        if re.match(pattern, included) and room not in rooms:
            return f"<{included}> belongs to {name}; only {', '.join(sorted(rooms))} may include it"
    return None


def own_headers(tree, path):
    """The headers of its own room that a file gets, the one through the other."""
    room = room_of(path)
    included = {row[2] for row in tree.sources[path].includes} & {header_of(room), inside_of(room)}
    return included | ({header_of(room)} if inside_of(room) in included else set())


def brought(tree, header):
    """All that an include of this header brings: what it includes, what these include, and so on."""
    found, left = set(), [header]
    while left:
        path = left.pop()
        new = {row[2] for row in tree.sources[path].includes} - found if path in tree.sources else set()
        found |= new
        left += new
    return found


def repeated_fault(tree, path, quote, included):
    """Returns the fault of an include that another include of the file brings already, or None. In rooms of the
    core of raster/, only the headers of the file's own room count."""
    for header in sorted(own_headers(tree, path) - {path}):
        if header in tree.sources and (quote, included) in {row[1:] for row in tree.sources[header].includes}:
            return f"\"{included}\" is included twice; {header} includes it already"
    for _, _, header in tree.sources[path].includes if path.startswith(INCLUDE_ONCE) else ():
        if header != included and included in brought(tree, header):
            return f"\"{included}\" is included twice; {header} brings it already"
    return None


def includes(tree):
    for path, source in tree.sources.items():
        for line, quote, included in source.includes:
            fault = (quoted_fault(tree, path, included) if quote == '"'
                     else system_fault(path, included)) or repeated_fault(tree, path, quote, included)
            if fault:
                yield Finding(path, line, fault)


def rooms(tree):
    for path in tree.sources:
        room, name = os.path.split(path)
        if not room or (room == BESIDE and name.endswith(".c")):
            continue
        if room not in ROOMS:
            yield Finding(path, 1, f"{room} is not a room; move the file into one, or add {room} to "
                                   "ROOMS (test/program/house.py) after the rooms that it uses")
        elif name.endswith(".h") and path not in (header_of(room), inside_of(room)):
            yield Finding(path, 1, f"a third header in {room}; what other rooms need belongs in "
                                   f"{header_of(room)}, the rest in {inside_of(room)}")
    for path in tree.tests:
        room = room_of(path)[len("test/"):]
        if room.startswith(("data/", "raster/")) and room not in ROOMS:
            yield Finding(path, 1, f"{room} is not a room; move the file to test/ROOM, for the room that it tests")
    for room in ROOMS:
        if header_of(room) not in tree.sources:
            yield Finding(header_of(room), 1, f"room {room} has no such header; write it, or take "
                                              "the room out of ROOMS (test/program/house.py)")


def edges(tree):
    """The pairs of rooms whose first includes a header of the second."""
    return {(room_of(path), room_of(included)) for path, source in tree.sources.items()
            for _, _, included in source.includes
            if room_of(path) in ROOMS and room_of(included) in ROOMS and room_of(path) != room_of(included)}


def names(tree):
    places = collections.defaultdict(list)
    for path in tree.sources:
        if path.endswith(".c") and os.path.basename(path) != "command.c":
            places[os.path.basename(path)].append(path)
    for paths in places.values():
        for path in paths[1:]:
            yield Finding(path, 1, f"{paths[0]} has the same name; take another, which names its subject")
    for path, source in tree.sources.items():
        words = {os.path.splitext(os.path.basename(path))[0], *os.path.dirname(path).split("/")}
        for word in sorted(words & FORBIDDEN_NAMES):
            yield Finding(path, 1, f"\"{word}\" does not say what is inside; take a standard word")
        for struct in source.structs if path.endswith(".h") else []:
            if struct.name in FORBIDDEN_NAMES:
                yield Finding(path, struct.line, f"struct {struct.name} does not say what it is; take "
                                                 "a standard word")


def core_words(tree):
    for path, source in tree.files(CORE).items():
        for number, line in enumerate(source.lines, 1):
            for match in FORBIDDEN_IN_CORE.finditer(line):
                if match.group().lower() not in MAY_BE_CITED or "specification" not in line:
                    yield Finding(path, number, f"the core names \"{match.group()}\"; it must know "
                                                "geometry and light only")


def mathematics(tree):
    for path, source in tree.sources.items():
        for word, line in source.calls:
            if word in NOT_ALIKE:
                yield Finding(path, line, f"{word} of the C library differs from system to system; take data/maths/elementary.c's")


def roundings(tree):
    for path, source in tree.sources.items():
        for number, line in enumerate(source.lines, 1):
            if "(double)(float)" in line.replace(" ", "") and path != "data/maths/maths.h":
                yield Finding(path, number, "gcc 12.2 leaves out (double)(float); take round_to_single of data/maths/maths.h")


def figures(tree):
    """Each size that has a budget: what has it, where it begins, the figure and its unit, the budget, and what to do."""
    for path, source in tree.sources.items():
        name = os.path.basename(path)
        yield name, path, 1, source.n_code, "lines of code", FILE_CODE, "split it by subject"
        for function in source.functions:
            yield (function.name, path, function.line, function.n_lines, "lines", FUNCTION_LINES,
                   "name its steps as functions")
            yield (function.name, path, function.line, function.n_parameters, "parameters", FUNCTION_PARAMETERS,
                   "pass what belongs together as a struct")
    yield "the house", "test/program/house.py", 1, len(ROOMS), "rooms", MOST_ROOMS, "put it where its subject is"
    yield ("the house", "test/program/house.py", 1, len(edges(tree)), "edges between rooms", MOST_EDGES,
           "move what two rooms need to where both have it")


def budgets(tree):
    for name, path, line, figure, unit, budget, advice in figures(tree):
        if figure > budget:
            yield Finding(path, line, f"{name} has {figure} {unit}, at most {budget}; {advice}")


def together(tree):
    for name, (rooms_of, budget) in TOGETHER.items():
        figure = sum(map(tree.code, rooms_of))
        if figure > budget:
            yield Finding("test/program/house.py", 1, f"{name} has {figure} lines of code, at most {budget}; take out what its users "
                                                      "can do without")


def users(tree, name, names, without):
    """Files and tests that mention a name, by a counter of the source, except for some files."""
    return [path for path, source in [*tree.sources.items(), *tree.tests.items()]
            if path not in without and getattr(source, names)[name]]


def defined_functions(tree):
    """{name: [path, ...]} of the functions that are not static."""
    result = collections.defaultdict(list)
    for path, source in tree.sources.items():
        for function in source.functions:
            if not function.is_static:
                result[function.name].append(path)
    return result


def function_fault(tree, header, function, definers):
    """Returns the fault of a function that a header declares, or None."""
    elsewhere = [path for path in definers if room_of(path) != room_of(header)]
    if not definers:
        return f"{function.name} is declared and never defined; take the line out"
    if elsewhere and header != "spectral.h":
        return f"{function.name} is defined in {elsewhere[0]}; declare it in the header of that room"
    if tree.sources[header].words[function.name] > 1:
        return None
    others = users(tree, function.name, "words", {header, *definers})
    is_public = header == header_of(room_of(header))
    outside_tests = [path for path in others if path not in tree.tests]
    if is_public and outside_tests and all(room_of(path) == room_of(header) for path in outside_tests):
        return f"only {room_of(header)} uses {function.name}; declare it in {inside_of(room_of(header))}"
    if not others:
        return f"only {definers[0]} uses {function.name}; make it static there"
    if all(path in tree.tests for path in others) and function.name not in FOR_TESTS:
        return (f"only {definers[0]} and tests use {function.name}; make it static there, or list it "
                "in FOR_TESTS (test/program/house.py)")
    return None


def declarations(tree):
    definers = defined_functions(tree)
    for path, source in tree.sources.items():
        for function in source.prototypes:
            fault = None
            if path.endswith(".h"):
                fault = function_fault(tree, path, function, definers[function.name])
            elif not function.is_static:
                fault = f"{function.name} is declared in a .c file; include the header of its room"
            if fault:
                yield Finding(path, function.line, fault)


def tests_reasons(tree):
    declared = {function.name: (path, function) for path, source in tree.sources.items()
                if path.endswith(".h") for function in source.prototypes}
    definers = defined_functions(tree)
    for name in FOR_TESTS:
        path, function = declared.get(name, (None, None))
        others = users(tree, name, "words", {path, *definers[name]}) if function else []
        if not others or not all(other in tree.tests for other in others):
            yield Finding("test/program/house.py", 1, f"{name} is listed in FOR_TESTS without need; take it out")


def structs(tree):
    for path, source in tree.sources.items():
        for struct in source.structs if path.endswith(".h") else []:
            if source.struct_names[struct.name] > 1 + struct.inside:
                continue  # the header needs it for another declaration
            others = users(tree, struct.name, "struct_names", {path})
            if len(others) < 2:
                where = f"only {others[0]} mentions" if others else "no other file mentions"
                right = f"define it in {others[0]}" if others else "take it out"
                yield Finding(path, struct.line, f"{where} struct {struct.name}; {right}")


def readable(tree):
    for path, source in tree.sources.items():
        if not source.balanced:
            yield Finding(path, len(source.lines), "braces or parentheses do not match for this test; "
                                                   "write both ways of an #if with whole functions")


RULES = (
    (readable, "every source can be read by this test"),
    (rooms, "every source is in a room, and every room has one public header"),
    (includes, "includes run downward, and none is repeated"),
    (names, "no two files share a name, and no name must be looked up"),
    (core_words, f"{CORE} knows geometry and light only"),
    (mathematics, "no function of the C library is called that differs from system to system"),
    (roundings, "no number is rounded by a pair of casts"),
    (budgets, "every size is within its budget"),
    (together, "rooms that have a budget together are within it"),
    (declarations, "every function that a header declares has a user in another file"),
    (tests_reasons, "every function in FOR_TESTS has no user but tests"),
    (structs, "every struct that a header defines has users in several files, or in the header"),
)


def findings(texts, rules=RULES):
    tree = Tree(texts)
    return [finding for rule, _ in rules for finding in rule(tree)]


# ---- the test of the test: planted faults ----

def rooms_for_faults(tree):
    """Returns the room with the shortest header, among rooms without rights of their own, and the highest room."""
    special = {CORE, *CORE_MAY_INCLUDE}.union(*(rights for _, rights, _ in SYSTEM_HEADERS))
    present = [room for room in ROOMS if header_of(room) in tree.sources]
    low = [room for room in present[:-1] if room not in special]
    return min(low, key=lambda room: len(tree.sources[header_of(room)].lines)), present[-1]


def plants(tree):
    """Faults, all but those of size: a name, texts by file to append, and a pattern of the only finding
    that they must lead to; None where they are allowed."""
    low, last_room = rooms_for_faults(tree)
    header, last = header_of(low), header_of(last_room)
    source, core = f"{low}/planted.c", f"{CORE}/planted.c"
    at_header = f"{header}:{len(tree.sources[header].lines) + 1}: "
    at_source, at_core = f"{source}:1: ", f"{core}:1: "
    define = "void planted(void)\n{\n}\n"
    return (
        ("an include that runs upward", {source: f'#include "{last}"'},
         at_source + f'the include of "{last}" runs upward; {low} may include only rooms'),
        ("an include without the path from the root", {source: f'#include "{os.path.basename(header)}"'},
         at_source + '".*" is not the header of a room; include a path from the root'),
        ("an include of a .c file", {source: f'#include "{source}"'},
         at_source + '".*" is not the header of a room; include a path from the root'),
        ("an own header in angle brackets", {source: f"#include <{header}>"},
         at_source + f'<{header}> is a header of this project; include "{header}"'),
        ("an include after a comment and blanks", {source: f'/**/ # /* */ include  "{last}"'},
         at_source + "the include of .* runs upward"),
        ("an include that the room's header has", {header: "#include <tgmath.h>", source: f'#include "{header}"\n#include <tgmath.h>'},
         f"{source}:2: " + f'"tgmath.h" is included twice; {header} includes it already'),
        ("an include that another room's header brings",
         {f"{last_room}/planted.c": '#include "data/scene/scene.h"\n#include "data/maths/maths.h"'},
         f'{last_room}/planted.c:2: "data/maths/maths.h" is included twice; data/scene/scene.h brings it already'),
        ("an include in a comment", {source: f'/*\n#include "{last}"\n*/'}, None),
        ("a header of OpenGL", {source: "#include <GL/gl.h>"},
         at_source + "<GL/gl.h> belongs to OpenGL; only raster/gl may include it"),
        ("a header of libtiff", {source: "#include <tiffio.h>"},
         at_source + "<tiffio.h> belongs to libtiff; only data/images, data/stack may include it"),
        ("another room's header in the core", {core: f'#include "{header}"'},
         at_core + f'the core includes "{header}"; {CORE} may include only data/maths and '),
        ("spectral.h in the core", {core: '#include "spectral.h"'},
         at_core + f'the core includes "spectral.h"; {CORE} may include only data/maths and '),
        ("spectral.h in the vectors of the core", {"data/maths/planted.c": '#include "spectral.h"'},
         'data/maths/planted.c:1: the core includes "spectral.h"; data/maths may include only data/maths and '),
        ("a system header in the core", {core: "#include <unistd.h>"},
         at_core + f"the core includes <unistd.h>; {CORE} may include headers of C99 only"),
        ("a third header", {f"{low}/planted.h": ""},
         f"{low}/planted.h:1: a third header in {low}; .* belongs in {header}"),
        ("a header that is for the files of another room", {f"{last_room}/planted.c": f'#include "{inside_of(CORE)}"'},
         f'{last_room}/planted.c:1: "{inside_of(CORE)}" is for the files of {CORE} alone'),
        ("the core that includes a room beside it", {"raster/render/planted.c": f'#include "{last}"'},
         f'raster/render/planted.c:1: the include of "{last}" runs upward'),
        ("two files of one name", {f"{low}/thing.c": "", f"{last_room}/thing.c": ""},
         f"{last_room}/thing.c:1: {low}/thing.c has the same name"),
        ("a function in a public header that one room uses",
         {header: "void planted(void);", source: define, f"{low}/planted2.c": "int (*f)() = planted;"},
         at_header + f"only {low} uses planted; declare it in {inside_of(low)}"),
        ("a function in a public header that one room and tests use",
         {header: "void planted(void);", source: define, f"{low}/planted2.c": "int (*f)() = planted;", "test/planted.c": "planted();"},
         at_header + f"only {low} uses planted; declare it in {inside_of(low)}"),
        ("a source outside of any room", {"data/planted.c": ""},
         "data/planted.c:1: data is not a room; move the file into one"),
        ("an unknown room", {"raster/planted/planted.h": ""},
         "raster/planted/planted.h:1: raster/planted is not a room; .* or add raster/planted to ROOMS"),
        ("a test of an unknown room", {"test/raster/planted/planted.c": ""},
         "test/raster/planted/planted.c:1: raster/planted is not a room; move the file to test/ROOM"),
        ("a forbidden word in a comment of the core", {core: "/* within the slack */"},
         at_core + 'the core names "slack"; it must know geometry and light only'),
        ("a forbidden word in a name of the core", {core: "int n_tiles;"},
         at_core + 'the core names "tiles"; it must know geometry and light only'),
        ("a sine of the C library", {source: "static double planted(double x) { return sin(x); } /* cos(x) */"},
         at_source + "sin of the C library differs from system to system"),
        ("a number that a pair of casts rounds", {source: "static double planted(double x) { return (double)(float)x; }"},
         at_source + r"gcc 12.2 leaves out \(double\)\(float\); take round_to_single of data/maths/maths.h"),
        ("a function of OpenGL in the core", {core: "/* as glBegin does */"},
         at_core + 'the core names "glBegin"; it must know geometry and light only'),
        ("a citation of OpenGL's specification in the core",
         {core: "/* OpenGL 2.1 specification, 3.5.1; globally, a boundary, tiled */"}, None),
        ("a file name that must be looked up", {f"{low}/finish.c": ""},
         f'{low}/finish.c:1: "finish" does not say what is inside; take a standard word'),
        ("a struct with such a name", {header: "struct tally { int x; }; extern struct tally planted;"},
         at_header + "struct tally does not say what it is; take a standard word"),
        ("a function in a header that only its own file uses",
         {header: "void planted(void);", source: define},
         at_header + f"only {source} uses planted; make it static there"),
        ("a function in a header that only its own file and a test use",
         {header: "void planted(void);", source: define, "test/planted.c": "planted();"},
         at_header + f"only {source} and tests use planted; make it static there, or list it in "),
        ("a function in a header that a second file uses",
         {header: "void planted(void);", source: define, f"{last_room}/planted2.c": "int (*f)() = planted;"},
         None),
        ("a function in a header that is defined in another room",
         {header: "void planted(void);", core: define},
         at_header + f"planted is defined in {core}; declare it in the header of that room"),
        ("a function in a header that does not exist", {header: "void planted(void);"},
         at_header + "planted is declared and never defined; take the line out"),
        ("a prototype in a .c file", {source: "void planted(void);"},
         at_source + "planted is declared in a .c file; include the header of its room"),
        ("a struct in a header that no other file mentions",
         {header: "struct planted { struct planted *next; };"},
         at_header + "no other file mentions struct planted; take it out"),
        ("a struct in a header that one file mentions",
         {header: "struct planted { int x; };", source: "static struct planted planted;"},
         at_header + f"only {source} mentions struct planted; define it in {source}"),
        ("a brace that nothing closes", {source: "static void planted(void) {"},
         at_source + "braces or parentheses do not match"))


def function_of(n_lines, parameters="void"):
    return f"static void planted({parameters})\n{{\n" + "\n" * (n_lines - 3) + "}"


def plants_of_size(tree):
    """Faults of size, planted as those above."""
    low, _ = rooms_for_faults(tree)
    source = f"{low}/planted.c"
    seven = ", ".join(f"int p{i}" for i in range(7))
    return (
        ("a file of too many lines of code", {source: "int planted;\n" * FILE_CODE + "int x;"},
         f"{source}:1: planted.c has 501 lines of code, at most 500; split it"),
        ("a file of many comments and blanks", {source: "// int planted;\n/* int\nplanted; */\n\n" * 500},
         None),
        ("a function of 60 lines", {source: function_of(60)},
         f"{source}:1: planted has 60 lines, at most 50; name its steps as functions"),
        ("a function of 50 lines", {source: function_of(50)}, None),
        ("a function of 7 parameters", {source: function_of(4, seven)},
         f"{source}:1: planted has 7 parameters, at most 6; pass what belongs together as a struct"),
        ("a function of 6 parameters, and one is a function",
         {source: function_of(4, "int a, int b, int c, int d, int e, int (*f)(int, int)")}, None))


# ---- output ----

def check_plant(texts, plant, rules, before):
    """Appends a text to each file that the fault is planted into; what that adds to the findings is shown."""
    name, added, finds = plant
    planted = {path: texts.get(path, "") + text + "\n" for path, text in added.items()}
    shown = [show(finding) for finding in findings({**texts, **planted}, rules) if finding not in before]
    if finds is None:
        check(not shown, f"a planted text is allowed: {name}", *shown)
    else:
        check(len(shown) == 1 and re.match(finds, shown[0]), f"a planted fault is found: {name}", f"expected: {finds}", *shown)


def check_together(texts, before):
    """Plants lines into the last room of each budget, one more than it allows, or one more than there are."""
    for name, (rooms_of, budget) in TOGETHER.items():
        tree = Tree(texts)
        missing = max(1, budget + 1 - sum(map(tree.code, rooms_of)))
        room = [room for room in rooms_of if room in ROOMS][-1]
        planted = {f"{room}/planted{i}.c": "int planted;\n" * min(400, missing - i) for i in range(0, missing, 400)}
        shown = [show(finding) for finding in findings({**texts, **planted}, [rule for rule in RULES if rule[0] == together])
                 if finding not in before]
        check(any(re.match(f"test/program/house.py:1: {name} has [0-9]+ lines of code, at most {budget}; ", line) for line in shown),
              f"a planted fault is found: too many lines of {name}", *shown)


def test(texts):
    for rule in RULES:
        found = findings(texts, rules=(rule,))
        check(not found, rule[1], *map(show, found))
    tree, before = Tree(texts), set(findings(texts))
    for plant in plants(tree):
        check_plant(texts, plant, [rule for rule in RULES if rule[0] not in (budgets, together)], before)
    for plant in plants_of_size(tree):
        check_plant(texts, plant, [rule for rule in RULES if rule[0] == budgets], before)
    check_together(texts, before)
    done()


def print_count(tree):
    for room in tree.rooms():
        print(f"{room:24} {tree.code(room):6}")
    print(f"{'all':24} {sum(map(tree.code, tree.rooms())):6}")


def main():
    own = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    texts = texts_below(os.path.abspath(sys.argv[2]) if len(sys.argv) > 2 else own)
    what = sys.argv[1] if len(sys.argv) > 1 else "--test"
    if what == "--count":
        print_count(Tree(texts))
    elif what == "--findings":
        print(*map(show, findings(texts)), sep="\n")
    elif what == "--test":
        test(texts)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
