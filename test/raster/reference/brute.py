#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first release; packages: python3-numpy python3-tifffile
"""A second implementation of the whole way from a scene to radiances, slow and short: each position of a pixel is a ray, which is asked for
all triangles, and for each light with shadows another one. It shares nothing with the program: neither camera, lights, placed meshes,
shadows and means of positions, which OpenGL and the reference get alike, nor rasterizing. Random scenes must have its radiances, and
OpenGL must agree. Objects may lie out of view and throw shadows into it; lights may reach nothing, and be more than OpenGL has.
Prints TAP.

    test/raster/reference/brute.py        32 random scenes; with FULL=1 100, with SOAK=1 (`test release`) 2000
    ONLY=7 test/raster/reference/brute.py scene 7 alone; its text is in build/tmp/brute/7.scene"""
import random

import numpy as np

import rendered
from rendered import amount, cases, check, done, pages_of, path_of, write
from tap import ONLY

NM = np.array([450.0, 520.0, 610.0, 700.0])
COUNT = amount(32, 100, 2000)


def unit(a):
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def gaussian(centre, width):
    return f"gaussian:{centre},{width}", np.exp(-4 * np.log(2) * ((NM - centre) / width) ** 2)


def some_spectrum(dice):
    if dice.random() < 0.4:
        value = round(dice.uniform(0.1, 0.9), 3)
        return str(value), np.full(len(NM), value)
    return gaussian(dice.choice((470, 530, 600)), dice.choice((60, 150)))


# ---- a random scene, in words and in numbers ----

class Mesh:
    """Triangles with a normal for each corner; a sheet faces +z, so that lights behind it reach nothing."""

    def __init__(self, dice, name, sheet):
        n = 12
        middle = np.array([[dice.uniform(-2, 2) for _ in range(2)] + [dice.uniform(-1, 1)] for _ in range(n)])
        self.corners = np.round(middle[:, None] + np.array([[[dice.uniform(-1.2, 1.2) for _ in range(3)] for _ in range(3)] for _ in range(n)]), 4)
        self.normals = np.round(np.array([[[dice.uniform(-1, 1), dice.uniform(-1, 1), 3 if sheet else dice.uniform(-1, 1)] for _ in range(3)]
                                          for _ in range(n)]), 4)
        if sheet:
            self.corners[..., 2] *= 0.1
            turned = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])[:, 2] < 0
            self.corners[turned] = self.corners[turned][:, ::-1]
        lines = [f"v {x} {y} {z}\n" for x, y, z in self.corners.reshape(-1, 3)]
        lines += [f"vn {x} {y} {z}\n" for x, y, z in self.normals.reshape(-1, 3)]
        lines += [f"f {3 * i + 1}//{3 * i + 1} {3 * i + 2}//{3 * i + 2} {3 * i + 3}//{3 * i + 3}\n" for i in range(n)]
        write(name, "".join(lines))


def rotation(degrees, axis):
    x, y, z = unit(np.array(axis, float))
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.radians(degrees)
    return np.eye(3) + np.sin(turn) * cross + (1 - np.cos(turn)) * cross @ cross


class Scene:
    def __init__(self, seed):
        dice = random.Random(seed)
        self.kind = dice.choice(("smooth", "smooth", "flat", "phong"))
        self.samples = dice.choice((1, 1, 2, 4))
        self.size = dice.randint(19, 27), dice.randint(13, 17)
        self.perspective = dice.random() < 0.6
        self.extent = dice.choice((30, 55 - 25 * (seed % 4 == 0))) if self.perspective else dice.uniform(4, 6)
        self.local = dice.random() < 0.4
        self.eye, self.look = np.array([round(dice.uniform(-2, 2), 3), round(dice.uniform(-1, 2), 3), 9.0]), np.array([0.2, -0.1, 0])
        self.near, self.far = dice.choice(((0.5, 90), (0.5, 90), (8.3, 90), (0.5, 9.9)))  # some cut objects
        self.lines = [f"wavelengths list {' '.join(map(str, NM))}", f"size {self.size[0]} {self.size[1]}",
                      f"camera {'perspective' if self.perspective else 'ortho'} {self.extent} near {self.near} far {self.far} "
                      f"eye {words(self.eye)} look {words(self.look)}", f"viewer {'local' if self.local else 'infinite'}", f"shading {self.kind}"]
        self.sheet = dice.random() < 0.35
        name, self.ambient = some_spectrum(dice)
        self.lines.append(f"ambient {name} 0.2")
        self.ambient = 0.2 * self.ambient
        self.away = seed % 4 == 0  # the second object lies out of view, before the first light
        self.right = seed % 8 == 0
        self.lights = [self.light(dice, i) for i in range(dice.choice((1, 2, 3, 11)))]
        self.triangles = []  # corners, normals, material, two_sided, mirrored, casts
        self.objects(dice, seed)
        self.path = write(f"{seed}.scene", "\n".join(self.lines) + "\n")

    def light(self, dice, i):
        name, spectrum = some_spectrum(dice)
        intensity = round(dice.uniform(0.2, 1), 3)
        light = {"colour": intensity * spectrum, "directional": dice.random() < 0.5, "attenuation": (1, 0, 0), "spot": None}
        at = np.array([round(dice.uniform(-4, 4), 3), round(dice.uniform(0, 5), 3), round(dice.uniform(-6 if self.sheet else 1, 6), 3)])
        if self.away and i == 0:
            at = np.array([14 if self.right else -14, round(dice.uniform(-1, 2), 3), round(dice.uniform(1, 3), 3)])
        light["at"] = at
        line = f"light {name} {intensity} {'direction' if light['directional'] else 'position'} {words(at)}"
        options = []
        if not light["directional"]:
            if dice.random() < 0.4:
                light["attenuation"] = dice.choice(((0.5, 0.1, 0), (1, 0, 0.03), (0, 0.2, 0.01)))
                options.append("attenuation {} {} {}".format(*light["attenuation"]))
            if dice.random() < 0.4:
                light["spot"] = unit(-at), np.cos(np.radians(40)), dice.choice((0, 2, 7.5))
                options.append(f"spot {words(-at)} 40 {light['spot'][2]}")
        light["shadows"] = dice.random() < 0.5 and i < 4 or self.away and i == 0
        options += ["shadows"] * light["shadows"]
        self.lines.append(" ".join([line, *dice.sample(options, len(options))]))
        return light

    def objects(self, dice, seed):
        meshes = [(f"{seed}-{i}.obj", Mesh(dice, f"{seed}-{i}.obj", self.sheet)) for i in range(2)]
        for i in range(dice.choice((2, 3, 4))):
            (name, diffuse), (shine, specular) = some_spectrum(dice), some_spectrum(dice)
            gloss = dice.choice((0, 3, 20.5))
            self.lines.append(f"material m{i} {{ diffuse {name} specular {shine} gloss {gloss} }}")
            file, mesh = dice.choice(meshes)
            away = self.away and i == 1
            two_sided, casts = dice.random() < 0.4 and not self.sheet, dice.random() < 0.8 or away
            scale = np.array([dice.choice((1, 1, -1.1)), dice.choice((1, 0.7)), 1])
            angle, axis = (0, (0, 0, 1)) if self.sheet else (dice.choice((0, 35, 140)), (1, 2, 0.5))
            offset = np.array([dice.uniform(-1, 1), dice.uniform(-1, 1), -0.7 * i])
            move = np.round(unit(self.lights[0]["at"]) * 9 if away else offset, 3)
            self.lines.append(f"object mesh {file} {'' if casts else 'casts no '}{'two-sided ' if two_sided else ''}material m{i} "
                              f"scale {words(scale)} rotate {angle} {words(axis)} translate {words(move)}")
            matrix = rotation(angle, axis) @ np.diag(scale)
            corners = mesh.corners @ matrix.T + move
            normals = unit(mesh.normals) @ np.linalg.inv(matrix)  # phong shading interpolates these
            for triangle in zip(corners, normals):
                self.triangles.append((*triangle, (diffuse, specular, gloss), two_sided, np.linalg.det(matrix) < 0, casts))


def words(numbers):
    return " ".join(f"{number:.12g}" for number in numbers)


# ---- rays ----

def hits(scene, start, along, which=None):
    """For each ray the triangles that it meets: distance [ray, triangle] (infinity: none), and barycentric coordinates."""
    corners = np.array([triangle[0] for triangle in scene.triangles])
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(along[:, None], v[None])
    with np.errstate(divide="ignore", invalid="ignore"):
        over = 1 / (p * u).sum(-1)
        s = start[:, None] - a[None]
        q = np.cross(s, u[None])
        b, c = (s * p).sum(-1) * over, (along[:, None] * q).sum(-1) * over
        distance = (q * v).sum(-1) * over
    inside = (b >= 0) & (c >= 0) & (b + c <= 1) & (distance > 1e-7)
    if which is not None:
        inside &= which
    return np.where(inside, distance, np.inf), np.stack([1 - b - c, b, c], -1)


def rays(scene):
    """The camera's rays through all positions, in rows from the top, and its axes."""
    width, height = (scene.samples * side for side in scene.size)
    back = unit(scene.eye - scene.look)
    right = unit(np.cross([0, 1, 0], back))
    up = np.cross(back, right)
    x, y = np.meshgrid((np.arange(width) + 0.5) / width * 2 - 1, 1 - (np.arange(height) + 0.5) / height * 2)
    x, y = x.ravel()[:, None], y.ravel()[:, None]
    if scene.perspective:
        half = np.tan(np.radians(scene.extent / 2))
        along = x * half * width / height * right + y * half * up - back
        return np.broadcast_to(scene.eye, along.shape), along, (right, up, back)
    start = scene.eye + x * scene.extent / 2 * right + y * scene.extent / 2 * height / width * up
    return start, np.broadcast_to(-back, start.shape), (right, up, back)


def weights_at(scene, point, normal, gloss, axes):
    """Finds what a point reflects of each light: diffuse and specular [light, 2]."""
    out = []
    for light in scene.lights:
        path = light["at"] - (0 if light["directional"] else point)
        towards = unit(path)
        left = 1.0
        if not light["directional"]:
            distance = np.linalg.norm(path)
            k = light["attenuation"]
            left = 1 / (k[0] + k[1] * distance + k[2] * distance ** 2)
        if light["spot"]:
            cosine = -towards @ light["spot"][0]
            left *= cosine ** light["spot"][2] if cosine > light["spot"][1] else 0
        cosine = normal @ towards
        viewer = unit(scene.eye - point) if scene.local else axes[2]
        shine = max(0, normal @ unit(towards + viewer)) ** gloss if gloss > 0 and cosine > 0 else 0
        out.append((max(0, cosine) * left, shine * left))
    return np.array(out)


def reaches(scene, light, point, own, seen_from):
    """Returns whether a light with shadows reaches a point of a triangle that is seen from a place."""
    corners, casts = scene.triangles[own][0], scene.triangles[own][5]
    path = light["at"] - (0 if light["directional"] else point)
    across = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    if casts and (across @ path) * (across @ seen_from) < 0:
        return False
    which = np.array([triangle[5] for triangle in scene.triangles])
    which[own] = False
    distance, _ = hits(scene, point[None], path[None], which)
    return distance.min() > (np.inf if light["directional"] else 1) or np.isinf(distance.min())


def radiance_at(scene, point, share, own, seen_from, axes):
    corners, normals, (diffuse, specular, gloss), two_sided, mirrored, _ = scene.triangles[own]
    outward = np.cross(corners[1] - corners[0], corners[2] - corners[0]) * (-1 if mirrored else 1)
    side = -1 if two_sided and outward @ seen_from < 0 else 1
    if scene.kind == "phong":
        weights = weights_at(scene, point, side * unit(share @ normals), gloss, axes)
    else:
        lit = np.array([weights_at(scene, corner, side * unit(normal), gloss, axes) for corner, normal in zip(corners, normals)])
        weights = lit[2] if scene.kind == "flat" else np.tensordot(share, lit, 1)
    sum_of = scene.ambient * diffuse
    for light, (matt, shiny) in zip(scene.lights, weights):
        if light["shadows"] and not reaches(scene, light, point, own, seen_from):
            continue
        sum_of = sum_of + light["colour"] * (matt * diffuse + shiny * specular)
    return sum_of


def picture(scene):
    """The radiances [band, y, x], each the mean of a pixel's positions."""
    start, along, axes = rays(scene)
    distance, shares = hits(scene, start, along)
    distance[(distance < scene.near) | (distance > scene.far)] = np.inf  # along has a length of 1 in depth
    nearest = distance.argmin(1)
    out = np.zeros((len(start), len(NM)))
    for ray in np.flatnonzero(np.isfinite(distance.min(1))):
        own = nearest[ray]
        point = start[ray] + distance[ray, own] * along[ray]
        out[ray] = radiance_at(scene, point, shares[ray, own], own, -along[ray], axes)
    k, (width, height) = scene.samples, scene.size
    return np.moveaxis(out.reshape(height, k, width, k, len(NM)).mean((1, 3)), -1, 0)


def main():
    seen = {}
    for seed in cases(range(COUNT)):
        scene = Scene(seed)
        expected = picture(scene)
        largest = expected.max()
        for renderer in ("raster",) if scene.kind == "phong" else ("raster", "gl"):  # OpenGL lights vertices only
            stack = f"{seed}-{renderer}.tif"
            report = rendered.render(scene.path, "--renderer", renderer, "--depth", "32f", "--samples", scene.samples,
                                     *(["--no-check"] if renderer == "raster" else ["--unchecked", "1"]), stack=stack)
            off = np.abs(pages_of(path_of(stack)) - expected).max(0) / max(largest, 1e-9)
            wrong = (off > (3e-6 if renderer == "raster" else 1e-3)).mean()
            check(wrong <= (0 if renderer == "raster" else 0.03) and largest > 0,
                  f"scene {seed}: {renderer} has the radiances of rays", f"{wrong:.2%} of the pixels are wrong, by up to {off.max():.3g}")
        for name in "specular", "shadows", "attenuation", "spot", "two_sided", "flat", "phong", "local_viewer":
            seen[name] = seen.get(name, 0) + bool(report["effects"][name])
        seen["idle lights"] = seen.get("idle lights", 0) + (report["work"].get("idle_lights", 0) > 0)
        seen["unseen instances"] = seen.get("unseen instances", 0) + (report["work"].get("unseen_instances", 0) > 0)
    print("#", ", ".join(f"{name} in {n} scenes" for name, n in seen.items()))
    check(ONLY or all(seen.values()), "each effect is in some scenes", seen)
    done()


if __name__ == "__main__":
    main()
