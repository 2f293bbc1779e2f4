#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile; makes: command_table
"""Words of scenes and of the files that they name: what an MTL entry loses is noted, values of a PNG file that says so are made
linear, printed names can be typed, files of the thesis's folders are found, and a near name in the folder is proposed. What other
programs call a thing, and write a number, is understood in the message; each option and command names itself. Prints TAP."""
import os
import re
import struct
import subprocess
import zlib

import numpy as np
import tifffile

from rendered import TMP, check, done, remove, run, write

HEAD = "size 2 2\nwavelengths list 450 550 650\ncamera ortho 2\nambient e 1\n"
QUAD = "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"


def png(name, pixels, *chunks):
    """8 bits; 1 channel: grey, 2: with alpha, 3: RGB"""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    height, width, n = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels.astype(np.uint8))
    with open(f"{TMP}/{name}", "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, {1: 0, 2: 4, 3: 2}[n], 0, 0, 0)) +
                   b"".join(chunk(kind, data) for kind, data in chunks) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def rendered(text, folder=None):
    """the pixels of each wavelength, and the printed report"""
    scene = write("case.scene", text)
    result = run("render", scene if not folder else os.path.abspath(scene), "-o", os.path.abspath(f"{TMP}/case.tif"), "--depth", "32f", "--renderer", "raster", "--no-check",
                 **({"cwd": folder} if folder else {}))
    return (tifffile.imread(f"{TMP}/case.tif") if result.returncode == 0 else None), result.stdout + result.stderr


# ---- MTL ----
png("map.png", np.full((2, 2, 3), 128))
png("leaf.png", np.full((2, 2, 2), 128))
LOST = {
    "-mm": ("Kd 1 1 1\nmap_Kd -mm 0 0.5 map.png\n", "map_Kd"), "-clamp on": ("Kd 1 1 1\nmap_Kd -clamp on map.png\n", "map_Kd"),
    "-s": ("Kd 1 1 1\nmap_Kd -s 2 2 2 map.png\n", "map_Kd"), "alpha": ("Kd 1 1 1\nmap_Kd leaf.png\n", "alpha"),
    "illum 0": ("Kd .1 .1 .1\nillum 0\n", "illum"), "illum 1 with a highlight": ("Kd .1 .1 .1\nKs .5 .5 .5\nNs 10\nillum 1\n", "illum"),
    "Ks without Ns": ("Kd .1 .1 .1\nKs .5 .5 .5\nillum 2\n", "Ks without Ns"), "Ns 0": ("Kd .1 .1 .1\nKs .5 .5 .5\nNs 0\n", "Ks without Ns"),
    "Tf": ("Kd .5 .5 .5\nTf .1 .1 .1\n", "transparency"), "d": ("Kd .5 .5 .5\nd 0.5\n", "transparency"), "Tr": ("Kd .5 .5 .5\nTr 0.5\n", "transparency"),
    **{word: (f"Kd .5 .5 .5\n{word} map.png\n", "other maps") for word in ("bump", "disp", "decal", "refl", "map_Ks", "map_bump")}}
KEPT = {"-mm 0 1": "Kd 1 1 1\nmap_Kd -mm 0 1 map.png\n", "-clamp off": "Kd 1 1 1\nmap_Kd -clamp off map.png\n", "-s 1": "Kd 1 1 1\nmap_Kd -s 1 1 1 map.png\n",
        "illum 1 alone": "Kd .1 .1 .1\nillum 1\n", "illum 2": "Kd .1 .1 .1\nKs .5 .5 .5\nNs 10\nillum 2\n", "Tf 1": "Kd .5 .5 .5\nTf 1 1 1\n",
        "d 1": "Kd .5 .5 .5\nd 1\n", "Tr 0": "Kd .5 .5 .5\nTr 0\n"}
write("quad.obj", "mtllib quad.mtl\n" + QUAD + "usemtl a\nf 1/1 2/2 3/3 4/4\n")
MESH = HEAD + "object mesh quad.obj\n"
for case, (entry, why) in {**LOST, **{case: (entry, "") for case, entry in KEPT.items()}}.items():
    write("quad.mtl", "newmtl a\n" + entry)
    _, said = rendered(MESH)
    check(why in said and said.count("not drawn") == (case in LOST), f"{case} is {'noted as not drawn' if why else 'drawn without a note'}", said)

# ---- values that are not linear ----
TEXTURE = HEAD + "material m {{ diffuse 1 texture {} nearest }}\nobject plane 2 2 material m\n"
for stored in (0, 10, 11, 128, 188, 255):
    value = stored / 255
    srgb = value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
    for case, chunks, expected in (("no word", [], value), ("sRGB", [(b"sRGB", b"\0")], srgb), ("gAMA 1", [(b"gAMA", struct.pack(">I", 100000))], value),
                                   ("gAMA 1/2.2", [(b"gAMA", struct.pack(">I", 45455))], value ** (1 / 0.45455)),
                                   ("both", [(b"gAMA", struct.pack(">I", 45455)), (b"sRGB", b"\0")], srgb)):
        png("grey.png", np.full((2, 2, 1), stored), *chunks)
        got, said = rendered(TEXTURE.format("grey.png"))
        check(got is not None and np.allclose(got, expected, rtol=1e-6, atol=1e-9), f"{stored} of a PNG file with {case} is {expected:.6f}", got, said)
png("rgb.png", np.full((2, 2, 3), (188, 128, 10)), (b"sRGB", b"\0"))
got, said = rendered(TEXTURE.format("rgb.png"))
linear = [((c / 255 + 0.055) / 1.055) ** 2.4 if c > 10 else c / 255 / 12.92 for c in (188, 128, 10)]
check(np.allclose(got, 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2], rtol=1e-6), "the luma is one of linear values", got, said)

# ---- names ----
write("chart.csv", "nm,paper,\"dark skin\"\n400,0.1,0.5\n700,0.1,0.7\n")
for typed, expected in (("chart.csv:paper", 0.1), ('"chart.csv:dark skin"', [0.5 + 0.2 * (nm - 400) / 300 for nm in (450, 550, 650)]), ("chart.csv:1", 0.1)):
    got, said = rendered(HEAD + f"material m {typed}\nobject plane 9 9 material m\n")
    check(got is not None and np.allclose(got[:, 1, 1], expected, rtol=1e-6), f"material m {typed} is that sample", got, said)
_, said = rendered(HEAD + "material m chart.csv:papr\nobject plane 9 9 material m\n")
check("did you mean paper?" in said, "a name that no sample has is refused", said)

STACK = f"{TMP}/patches.tif"
run("render", "patches", "--size", "60x40", "--wavelengths", "400:700:50", "-q", "-o", STACK, "--renderer", "raster", "--no-check")
at, typed = run("probe", STACK, 30, 20).stdout, run("probe", STACK, "30,20").stdout
check(at == typed and "region            pixel 30,20\n" in at, "a pixel is typed as it is printed", at, typed)
table = run("probe", STACK, "--objects", "--csv").stdout.splitlines()
for row in table[1:]:
    name, _, x, y, z = row.replace('"', "").split(",")[:5]
    typed = run("probe", STACK, name, "--json", "-").stdout
    check(all(f"{float(number):.17g}"[:12] in typed for number in (x, y, z)) and name in typed, f"{name} is the object of that name", row, typed[:300])
for words, why in ((("patches", "13-blue"), "a scene takes X and Y"), ((STACK, "blu"), "no object 'blu'"), ((STACK, "99"), "no object '99'"), ((STACK, "30,"), "no object '30,'")):
    result = run("probe", *words)
    check(result.returncode == 2 and why in result.stderr, f"probe refuses {words[-1]}: {why}", result.stderr)
write("film.csv", "nm,first,second,third\n400,0.1,0.2,0.3\n700,0.3,0.2,0.1\n")
said = run("develop", STACK, "--detector", f"{TMP}/film.csv", "-o", f"{TMP}/film.png").stdout
check("channels          first, second, third as red, green, blue\n" in said, "develop says which channel is which colour", said)
said = run("develop", STACK, "--detector", "dcs200-camera", "-o", f"{TMP}/film.png").stdout
check("channels" not in said, "where their names say so, it does not", said)

# ---- the thesis's folders and words ----
os.makedirs(f"{TMP}/lists", exist_ok=True)
os.makedirs(f"{TMP}/here/bricks", exist_ok=True)
tifffile.imwrite(f"{TMP}/here/bricks/wall.tif", np.full((2, 2), 128, np.uint8))
write("here/red.txt", "gloss 20\n400 0.5\n700 0.5\nSpecular 400 0.5\nspec 700 0.5\ntexture bricks/wall.tif\n")
remove(f"{TMP}/lists/red.txt")
write("lists/all.list", "red.txt\n")
result = run("plan", os.path.abspath(f"{TMP}/lists/all.list"), cwd=f"{TMP}/here")
check(result.returncode == 0 and "wall.tif" in result.stdout, "a list finds its material in the working folder, and that its texture", result.stdout, result.stderr)
write("lists/red.txt", "400 0.25\n700 0.25\n")
result = run("plan", os.path.abspath(f"{TMP}/lists/all.list"), cwd=f"{TMP}/here")
check(result.returncode == 0 and "wall.tif" not in result.stdout, "a file beside the list goes before one in the working folder", result.stdout, result.stderr)
for word in ("x", "m", "mx"):
    write("odd.txt", f"400 0.5\n{word} 1\n")
    _, said = rendered(HEAD + "material m odd.txt\nobject plane 9 9 material m\n")
    check(f"unknown line '{word}'" in said, f"a line {word} is refused", said)

# ---- near names of files in the folder ----
for name in ("block.obj", "oak.csv", "wood.png", "red.txt", "my.list", "a.map", "lamp.scene"):
    write(name, "")
for typed, near in (("material m { diffuse oka.csv }", "oak.csv"), ("material m { diffuse 0.5 texture woood.png }", "wood.png"),
                    ("material m { diffuse 0.5 }\nobject mesh blok.obj material m", "block.obj"), ("material m rde.txt", "red.txt"),
                    ("checker mi.list plane 1 1", "my.list"), ("material m { diffuse 0.5 }\nobject mesh quad.obj materials b.map", "a.map"),
                    ("include lmap.scene", "lamp.scene"), ("material m { diffuse 0.5 }\nobject mesh block.stl material m", "block.obj"),
                    ("material m { diffuse 0.5 }\nobject mesh bloc material m", "block.obj"), ("include spheres.scene", "spheres")):
    _, said = rendered(HEAD + typed + "\nobject plane 9 9 material m\n")
    check(f"did you mean {near}?" in said, f"{typed.splitlines()[-1]}: {near} is proposed", said)
_, said = rendered(HEAD + "material m { diffuse lamp }\nobject plane 9 9 material m\n")
check("did you mean" not in said, "no scene is proposed as a spectrum", said)

# ---- habits: each word of the table, where its known word may stand ----
PLACES = {"wavelengths": "size 4 4\n{} a scene", "diffuse": "material m {{ {} 1 0 0 }}", "d65": "light {} 1 direction 0 0 1", "gloss": "material m {{ diffuse 1 {} 1 }}",
          "eye": "camera ortho 9 {} 0 0 9", "look": "camera ortho 9 {} 0 0 9", "camera": "{} 0 0 9", "object": "{} 1 material m",
          "box": "object {} 1 material m", "plane": "object {} 1 material m", "translate": "object sphere 1 {} 1 0 0", "size": "{} 4 4"}
with open("data/text/words.c") as source:
    rows = re.findall(r'^    \{" (.+) ", "(.+)",\s+"(.+)"\},$', source.read(), re.M)
check({known for _, known, _ in rows} == set(PLACES) and len(rows) > 12, "each row of the table of habits is tried", rows)
for words, known, meant in rows:
    bad = [said for word in words.split() for said in [rendered(PLACES[known].format(word))[1]] if f"did you mean {meant}?" not in said]
    check(bad == [], f"{words}: {meant} is proposed", bad)

# ---- numbers, orders and colours as other programs write them: the place, and what to type ----
BALL = "material m { diffuse 0.5 }\nobject sphere 1 material m "
for typed, place, words in (
        ("size 60x40", "1:6", "'60x40' is written as behind --size; write size 60 40"),
        ("wavelengths 400 10 700", "1:17", "END 10 is below START 400; write START END STEP"),
        ("wavelengths 400:700:10", "1:13", "START must be a number such as 400, not '400:700:10'"),
        ("wavelengths 400nm 700nm 10nm", "1:13", "START must be a number such as 400, not '400nm'"),
        ("wavelengths 0.4 0.7 0.01", "1:1", "multiply micrometres by 1000"), ("wavelengths 4e-7 7e-7 1e-8", "1:1", "multiply metres by 1e9"),
        ("material m { diffuse 1 0 0 }", "1:24", "'0' is too much: diffuse takes one spectrum, and no RGB"),
        ("material m { diffuse 50% }", "1:22", "spectrum must be a number such as 0.5, not '50%'"),
        ("material m { diffuse 0,5 }", "1:22", "spectrum must be a number such as 0.5, not '0,5'"),
        ("light 6500K 1 direction 0 0 1", "1:7", "for a temperature write daylight:6500 or blackbody:6500"),
        ("light daylight:6500K 1 direction 0 0 1", "1:16", "temperature must be a number such as 6500, not '6500K'"),
        ("light d65,0.5 1 direction 0 0 1", "1:7", "a factor stands behind a *: d65*0.5"),
        ("light d65 position 0 0 8", "1:11", "intensity must be a number such as 2.5 or 1e-3, not 'position'"),
        ("background 0 0 0", "1:16", "'0' is too much: background SPECTRUM INTENSITY takes no more"),
        (BALL + "rotate 0 90 0", "2:41", "expected a number: z of axis (ANGLE X Y Z)"),
        (BALL + "translate <1, 0, 0>", "2:38", "x of translation must be a number such as 1, not '<1,'"),
        (BALL + "translate 1,0,0", "2:38", "x of translation must be a number such as 1, not '1,0,0'"),
        ("material m { diffuse 1 }\nobject mesh none.stl material m", "2:13", "meshes are OBJ; see spectral list models")):
    _, said = rendered(typed)
    check(f"case.scene:{place}: error: " in said and words in said, f"{typed.splitlines()[-1]}: {words}", said)
with open(write("scan:0.5", "400 0.5\n700 0.5\n")):
    check(rendered("material m { diffuse scan:0.5 }\nobject plane 9 9 material m\n")[0] is not None, "a file goes before a part of its name")

# ---- options and operands: all of them ----
table = subprocess.run([f"{os.environ.get('BUILD', 'build')}/test/command_table"], stdout=subprocess.PIPE, check=True, text=True).stdout
for row in table.splitlines():
    kind, *columns = row.split("\t")
    if kind == "command":
        command, most, operands = columns
        for words in [[]] * operands[0].isupper() + [["1"] * (int(most) + 1)] * (int(most) < 99):
            said = run(command, *words).stderr
            check(said.endswith(f"usage: spectral {command} {operands} [OPTIONS]\n"), f"{command} {' '.join(words)}: its usage", said)
        continue
    usage, kind, _, _, _, choices = columns
    name = re.search(r"--[\w-]+", usage)[0]
    if kind in ("number", "count") or choices or (kind == "change" and " " in usage and command == "plan"):
        said = run(command, f"{name}=@", *(["patches"] if command == "plan" else [])).stderr
        check(said.startswith(f"{name}:1:1: error: "), f"{command} {name}=@: the place", said)
done()
