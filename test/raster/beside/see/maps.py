#!/usr/bin/env -S PYTHONPATH=test/shared:test/raster/reference /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile libosmesa6
"""The maps of a picture: weights x spectra x texture are the stack, in all built-in scenes; a picture that is lit anew from its maps is
the render under the other light; with the spectra of a white diffuser it is the picture of white objects; places and normals are those of rays
through triangles (brute.py), and of a sphere and a plane. Prints TAP."""
import re
import types
import xml.etree.ElementTree as ET

import numpy as np
import tifffile

import brute
from rendered import SCENES, TMP, built_in, bytes_of, check, done, output_of, run, write

STACK, MAPS = f"{TMP}/stack.tif", f"{TMP}/maps.tif"


def render(scene, *options):
    output_of("render", scene, "-o", STACK, "--maps", MAPS, "--quiet", *options)
    return read(MAPS)


def read(path):
    """The pages by their names, and the spectra that the record holds by theirs."""
    with tifffile.TiffFile(path) as file:
        record = ET.fromstring(file.pages[0].description).find(".//{*}Description").text
        pages = {page.tags["PageName"].value: page.asarray().astype(float) for page in file.pages}
    return pages, {key: np.array(values.split(), float) for key, values in re.findall(r"^([\w ]+):((?: [-+.e\d]+)+)$", record, re.M)}


def counts():
    """The counts of the stack, and the radiance of one."""
    with tifffile.TiffFile(STACK) as file:
        scale = float(re.search('role="scale">([^<]*)', file.gdal_metadata)[1])
        return np.array([page.asarray() for page in file.pages], float), scale


def radiance(pages, spectra, light=lambda key: 1.0):
    """The picture [band, y, x]: the sum over all terms of all materials, times the texture. light: factors of the bands of a term."""
    bands = len(spectra["wavelengths"])
    out = np.zeros((bands, *pages["depth"].shape))
    for key, spectrum in spectra.items():
        term = re.fullmatch(r"material (\d+) (.*)", key)
        if term:
            out += (pages["material"] == int(term[1])) * pages[term[2]] * (spectrum * light(term[2]))[:, None, None]
    textures = [page for name, page in pages.items() if name.startswith("texture")] or [1.0]
    return out * (np.array(textures) if len(textures) == bands else textures[0])


# ---- the identity ----

for scene in SCENES:
    pages, spectra = render(scene, "--size", "96x64", "--renderer", "raster")
    stored, scale = counts()
    off = np.abs(radiance(pages, spectra) / scale - stored).max()
    check(off < 0.51, f"{scene}: weights x spectra x texture are its counts", off)

plain = f"{TMP}/plain.tif"
output_of("render", "textures", "--size", "96x64", "-o", plain, "--quiet")
pages, spectra = render("textures", "--size", "96x64")
check(bytes_of(plain) == bytes_of(STACK), "a stack with maps has the bytes of one without")
with tifffile.TiffFile(STACK) as file:
    objects = output_of("probe", STACK, "--objects", "--edges", "--csv").count("\n")
check(pages["object"].max() <= objects and not pages["depth"][pages["object"] == 0].any(), "objects have numbers, and the background is 0")

# ---- other light ----

SCENE = """wavelengths 400 700 10
size 60 40
camera perspective 40 eye 0 0 6 look 0 0 0
light {} 1 position 3 3 5
light d65 0.5 direction -1 0 1
ambient a 0.1
material m {{ diffuse {} specular 0.3 gloss 20 texture checks }}
material n {{ diffuse {} }}
object sphere 1 material m rotate 40 1 1 0
object plane 9 9 material n translate 0 0 -2
"""
RED, GREEN = "colorchecker/15-red", "colorchecker/14-green"
pages, spectra = render(write("d65.scene", SCENE.format("d65", RED, GREEN)), "--depth", "32f", "--renderer", "raster")
nm = spectra["wavelengths"]
ratio = np.interp(nm, *built_in("a")) / np.interp(nm, *built_in("d65"))
relit = radiance(pages, spectra, lambda term: ratio if term.startswith("light 1") else 1.0)
render(write("a.scene", SCENE.format("a", RED, GREEN)), "--depth", "32f", "--renderer", "raster")
drawn, _ = counts()
check(np.abs(relit - drawn).max() < 2e-6 * drawn.max(), "a picture that its maps light anew is the render under that light",
      np.abs(relit - drawn).max() / drawn.max())
write("white.scene", SCENE.format("d65", 1, 1).replace(" specular 0.3 gloss 20 texture checks", ""))
render(f"{TMP}/white.scene", "--depth", "32f", "--renderer", "raster")
drawn, _ = counts()
seen = sum(pages[key[6:]] * spectrum[:, None, None] for key, spectrum in spectra.items() if key.startswith("white "))
check(np.abs(seen - drawn).max() < 2e-6 * drawn.max(), "weights x the spectra of a white diffuser are the radiance of white objects, without texture or gloss")

# ---- places: rays through triangles ----

RNG = np.random.default_rng(49)
CORNERS = RNG.uniform(-2.5, 2.5, (40, 3, 3))
CORNERS[:, :, 2] *= 1.6  # some reach behind the near plane
NORMALS = RNG.normal(size=(40, 3, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=2, keepdims=True)
UV = RNG.uniform(0, 1, (40, 3, 2))
rows = ([f"v {x!r} {y!r} {z!r}" for x, y, z in CORNERS.reshape(-1, 3).tolist()] + [f"vt {s!r} {t!r}" for s, t in UV.reshape(-1, 2).tolist()] +
        [f"vn {x!r} {y!r} {z!r}" for x, y, z in NORMALS.reshape(-1, 3).tolist()] +
        ["f " + " ".join(f"{i}/{i}/{i}" for i in range(3 * face + 1, 3 * face + 4)) for face in range(40)])
write("t.obj", "\n".join(rows) + "\n")
EYE, LOOK = np.array([0.4, 0.3, 5]), np.array([0.1, -0.2, 0])
write("rays.scene", f"""wavelengths 500 600 50
size 90 60
camera perspective 50 near 2 far 12 eye {brute.words(EYE)} look {brute.words(LOOK)}
light d65 1 direction 0 0 1
material m {{ diffuse 0.5 texture checks }}
object mesh t.obj two-sided material m scale 1 -0.8 1.1 translate 0.2 0.1 -0.3
""")
pages, _ = render(f"{TMP}/rays.scene", "--renderer", "raster", "--shading", "phong")
flat = {name: page.ravel() for name, page in pages.items()}
factor = np.array([1, -0.8, 1.1])
corners = CORNERS * factor + [0.2, 0.1, -0.3]
view = types.SimpleNamespace(size=(90, 60), samples=1, eye=EYE, look=LOOK, perspective=True, extent=50, triangles=[(three,) for three in corners])
start, along, axes = brute.rays(view)
depth, shares = brute.hits(view, start, along)
depth[(depth < 2) | (depth > 12)] = np.inf
ray = np.flatnonzero(np.isfinite(depth).any(1))
nearest = depth[ray].argmin(1)
share = shares[ray, nearest][:, None]
place = EYE + along[ray] * depth[ray, nearest][:, None]
normal = brute.unit((share @ NORMALS[nearest])[:, 0] / factor)
face = np.cross(corners[nearest, 1] - corners[nearest, 0], corners[nearest, 2] - corners[nearest, 0])
seen_side = np.where((face * factor.prod() * along[ray]).sum(1) < 0, 1, -1)  # the mirror turns the corners: outside is where it points away
in_eye = (place - EYE) @ np.transpose(axes)
expected = np.column_stack([in_eye, place, seen_side[:, None] * normal, (share @ UV[nearest])[:, 0], -in_eye[:, 2]])
names = ["eye x", "eye y", "eye z", "world x", "world y", "world z", "normal x", "normal y", "normal z", "s", "t", "depth"]
off = np.abs(np.transpose([flat[name][ray] for name in names]) - expected) / np.maximum(1, np.abs(expected))
wrong = np.count_nonzero(np.delete(flat["object"], ray))
check(len(ray) > 2000 and off.max() < 3e-7 and wrong == 0, f"{len(ray)} pixels of triangles: places, normals, texture coordinates are those of the rays",
      off.max(), wrong)
pairs = set(zip(nearest, flat["triangle"][ray]))
check(len(pairs) == len({a for a, _ in pairs}) == len({b for _, b in pairs}), "each triangle has its number")

# ---- places: a sphere and a plane ----

write("sphere.scene", """wavelengths 500 600 50
size 200 200
camera ortho 2.5 eye 0 0 5
light d65 1 direction 0 0 1
material m { diffuse 0.5 }
object sphere 1 400 200 material m
object plane 4 4 material m rotate 30 0 1 0 translate 0 0 -3
""")
pages, _ = render(f"{TMP}/sphere.scene", "--renderer", "raster")
middle = ((np.arange(200) + 0.5) / 200 - 0.5) * 2.5
x, y = np.meshgrid(middle, -middle)
on = (pages["object"] == 1) & (x ** 2 + y ** 2 < 0.9)
z = np.sqrt(np.where(on, 1 - x ** 2 - y ** 2, 0))
sagitta = 1.3e-4  # of facets of 1.8 degrees: (pi / 200)^2 / 2 of the radius
for name, value in (("world x", x), ("world y", y), ("world z", z), ("depth", 5 - z), ("normal x", x), ("normal y", y), ("normal z", z)):
    check(np.abs(pages[name] - value)[on].max() < 4 * sagitta, f"sphere: {name}", np.abs(pages[name] - value)[on].max())
plane = pages["object"] == 2
expected = -3 - x * np.tan(np.pi / 6)
check(np.abs(pages["world z"] - expected)[plane].max() < 1e-6, "plane: world z", np.abs(pages["world z"] - expected)[plane].max())
check(np.abs(pages["normal x"][plane] - 0.5).max() < 1e-7 and np.abs(pages["normal z"][plane] - np.sqrt(0.75)).max() < 1e-7, "plane: normal")

# ---- refusals ----

for options, words in ((("--samples", "4"), "--samples"), (("--part", "1/2"), "--part takes no --maps")):
    refused = run("render", "spheres", "--maps", MAPS, "-o", f"{TMP}/no.tif", *options)
    check(refused.returncode == 2 and words in refused.stderr, f"refused: {options[0]}", refused.stderr)
done()
