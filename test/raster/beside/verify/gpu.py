#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy chromium firefox-esr xvfb; makes: live
"""Opens the page of `verify --page` in browsers whose GPUs are programs: Chromium's SwiftShader, whose corners lie on a grid of 1/16 pixel,
and Mesa's llvmpipe, in Chromium and in Firefox. The verdicts are those of export and judge on the command line. Lies that a script puts
between the page and WebGL are found where they are. Prints TAP."""
import json
import os
import subprocess

import numpy as np

import browser as browsers
from browser import Browser, Firefox
from rendered import LIVE, SPECTRAL, check, done, output_of, path_of, run, write

browsers.PATIENCE_S = 600
SWIFTSHADER = "--use-angle=swiftshader", "--enable-unsafe-swiftshader"
LLVMPIPE = "--use-angle=gl-egl", "--ignore-gpu-blocklist", "--enable-gpu"
SIZE = (150, 100)  # of the built-in scenes
FEW = "patches", "spheres", "hard/shadow-ground", "textures", "hard/tiles-wide"
# SwiftShader runs the planes of a triangle through its corners as they are moved to the grid, also where the near plane cuts the
# triangle, and a corner lies behind the eye: the error of a corner grows there beyond the bounds.
WRONG = {"hard/near-crossing", "hard/shadow-grazing", "hard/shadow-ground", "hard/shadow-near-cut"}


def page(*words):
    path = path_of("gpu.html")
    output_of("verify", "--page", path, *words, program=LIVE)
    return path


def report_of(browser):
    return json.loads(open(browser.download("save-report", "gpu.json"), encoding="utf-8").read())


def scenes_of(report):
    return {scene["scene"]: scene for scene in report["drivers"][0]["scenes"]}


def verdicts(scenes, verdict):
    return {name for name, scene in scenes.items() if scene["verdict"] == verdict}


def not_tried(scenes):
    return {name for name, scene in scenes.items() if (scene["message"] or "").startswith("not tried: ")}


# ---- the command ----

def refusals():
    result = run("verify", "--page", path_of("no.html"), "patches")
    check(result.returncode == 2 and "./build.sh live makes one" in result.stderr and not os.path.exists(path_of("no.html")),
          "the usual program writes no page, and says how to get one that does", result.stderr)
    for words in (["--gl", "osmesa"], ["--renderer", "llvmpipe"], ["--buffer", "8"], ["--junit", "-"], ["--json", "-"], ["--expect", "x.json"]):
        result = run("verify", "--page", path_of("no.html"), "patches", *words, program=LIVE)
        check(result.returncode == 2 and "--page draws nothing here" in result.stderr and not os.path.exists(path_of("no.html")),
              f"--page takes no {words[0]}", result.stderr)
    result = run("verify", "--page", path_of("no.html"), "nowhere.scene", program=LIVE)
    check(result.returncode == 2 and "nowhere.scene" in result.stderr and not os.path.exists(path_of("no.html")),
          "a scene that is missing makes no page", result.stderr)


# ---- the verdicts ----

def figures(scenes):
    agreed = [scene for scene in scenes.values() if scene["verdict"] == "agreed"]
    floors = [scene["floor_median"] for scene in agreed if scene["floor_median"] is not None]
    return f"{len(agreed)} of {len(scenes)} agree, floors up to {max(floors):.3g} counts; {len(not_tried(scenes))} not tried"


def whole(browser, which):
    """Verifies all scenes. Returns the report."""
    path = page()
    check(os.path.getsize(path) <= 3e6, f"the page has {os.path.getsize(path)} bytes, at most 3 MB")
    browser.open(path)
    report = report_of(browser)
    scenes = scenes_of(report)
    listed = set(output_of("verify", "--list").split())
    check(set(scenes) == listed, f"{which}: the built-in scenes and the hard cases are verified", listed ^ set(scenes))
    check(not verdicts(scenes, "failed"), f"{which}: none fails", *(scenes[name] for name in verdicts(scenes, "failed")))
    for name in not_tried(scenes):
        check("pixels a side" in scenes[name]["message"], f"{which}, {name}: a picture that is too large is not tried", scenes[name])
    return report


def all_agree(browser, which):
    scenes = scenes_of(whole(browser, which))
    rest = set(scenes) - verdicts(scenes, "agreed") - not_tried(scenes)
    check(not rest, f"{which}: {figures(scenes)}", *(scenes[name] for name in rest))


def swiftshader():
    """Most pictures cannot be checked enough on its grid; those are not said to agree."""
    browser = Browser(path_of("chromium"), SWIFTSHADER)
    report = whole(browser, "SwiftShader")
    scenes = scenes_of(report)
    wrong = verdicts(scenes, "differs")
    check(wrong == WRONG, f"SwiftShader: {figures(scenes)}; cut triangles differ", wrong ^ WRONG)
    for name in verdicts(scenes, "not verified") - not_tried(scenes):
        scene = scenes[name]
        check(scene["unexplained_pixels"] == 0 and scene["unchecked_pixels"] > 0.01 * scene["object_pixels"],
              f"SwiftShader, {name}: {scene['unchecked_pixels']} of {scene['object_pixels']} pixels cannot be checked", scene)
    check(len(verdicts(scenes, "agreed")) > 40 and "1/16 pixel" in browser.text("gpu") and "at most 0.0312 pixel" in browser.text("gpu"),
          "SwiftShader: the page names its grid and what was measured", browser.text("gpu"))
    said = browser.text("sentence")
    check(f"wrong pixels in {len(wrong)} of {len(scenes)} scenes" in said and "not verified" in said, "SwiftShader: a sentence says so", said)
    native = json.loads(run("verify", "patches", "--json", "-", "--quiet").stdout)
    check(set(native["drivers"][0]) == set(report["drivers"][0]) and set(native) == set(report), "the report has the keys of verify --json",
          set(native["drivers"][0]) ^ set(report["drivers"][0]))
    own, other = native["drivers"][0]["scenes"][0], scenes["patches"]
    check(set(own) == set(other), "so has each scene", set(own) ^ set(other))
    expected = run("verify", "patches", "--quiet", "--expect", os.path.join(browser.downloads, "gpu.json"))
    check(expected.returncode == 0, "verify --expect reads it", expected.stderr)
    foreign = [one for one in browser.requests if not one.startswith(("file:", "blob:", "data:"))]
    check(not foreign and not browser.complaints, "the page fetches nothing, and complains of nothing", foreign, *browser.complaints)
    by_hand(browser, scenes)
    browser.close()


def case_of(browser, name):
    """Lets the page draw a scene again, and returns the folder of the case."""
    saved = browser.evaluate(f"""(async () => {{
        const of = start.scenes.find(({{name}}) => name === {name!r}), {{program, exported}} = await export_scene(of), check = () => {{}};
        const drawn = [...await draw_in_steps(exported, "targets-", check), ...await draw_in_steps(exported, "", check)];
        program.end();
        element("save-report").onclick = () => save_as(tar([...exported, ...drawn]), "drawn.tar");
    }})()""")
    check(saved is None, f"{name} is drawn again")
    return unpacked(browser.download("save-report", "drawn.tar"), "drawn")


def unpacked(archive, name):
    folder = path_of(name)
    subprocess.run(["rm", "-rf", folder], check=True)
    os.makedirs(folder)
    subprocess.run(["tar", "xf", archive, "-C", folder], check=True)
    return os.path.join(folder, "case")


def judged(folder):
    result = run("judge", folder, "--json", "-")
    return result, json.loads(result.stdout)


def by_hand(browser, scenes):
    """The page exports the bytes that export writes, and judge gives the page's verdict, though it measures the targets each time."""
    for name in "patches", "spheres", "hard/shadow-ground":
        folder, own = case_of(browser, name), path_of("own")
        subprocess.run(["rm", "-rf", own], check=True)
        sizes = [] if name.startswith("hard/") else ["--size", "150x100", "--wavelengths", "400:700:50"]
        output_of("export", name, *sizes, "-o", own)
        names = [one for one in os.listdir(own) if one != "bounds.tif"]  # whose record names the output
        same = [open(f"{own}/{one}", "rb").read() == open(f"{folder}/{one}", "rb").read() for one in names]
        check(all(same), f"{name}: the page exports the files of the command line", *(one for one, is_same in zip(names, same) if not is_same))
        result, found = judged(folder)
        page_says = scenes[name]
        check(found["verdict"] == page_says["verdict"] and found["check"]["floor_median_counts"] == page_says["floor_median"]
              and found["check"]["unchecked_pixels"] == page_says["unchecked_pixels"],
              f"{name}: judge finds what the page has found: {found['verdict']}", result.stderr, page_says)


# ---- lies ----

# A lie changes what WebGL gives of a picture of 150 x 100 pixels: reads 0, 1, 2 are the passes, 3 the numbers.
X, Y = 61, 22  # on a patch
LIES = f"""
const lie = location.hash.slice(1), of = WebGL2RenderingContext.prototype, reads = new WeakMap();
const {{readPixels, texParameteri, texStorage2D, getExtension}} = of, at = (x, y, h) => 4 * ((h - 1 - y) * {SIZE[0]} + x);
of.readPixels = function (x, y, w, h, format, type, out) {{
  const n = reads.get(this) ?? 0;
  reads.set(this, n + 1);
  if (lie === "lost" && n === 1 && w === {SIZE[0]}) getExtension.call(this, "WEBGL_lose_context").loseContext();
  readPixels.call(this, x, y, w, h, format, type, out);
  if (w !== {SIZE[0]}) return;
  if (lie === "sample" && n === 1) out[at({X}, {Y}, h) + 1] *= 1.001;
  if (lie === "triangle" && n === 3) out[at({X}, {Y}, h)] += 1 - 2 * (out[at({X}, {Y}, h)] % 2);
  if (lie === "band" && n === 1) for (let i = 1; i < out.length; i += 4) out[i] *= 1.001;
  if (lie === "black" && n < 3) out.fill(0);
}};
of.texStorage2D = function (...sizes) {{
  this.draws_targets = sizes[3] > {SIZE[0]};
  texStorage2D.apply(this, sizes);
}};
of.texParameteri = function (target, name, value) {{
  const lies = lie === "always-nearest" || (lie === "nearest" && !this.draws_targets);
  const filters = value === this.LINEAR || value === this.LINEAR_MIPMAP_LINEAR;
  texParameteri.call(this, target, name, lies && filters ? this.NEAREST : value);
}};
of.getExtension = function (name) {{
  return lie === name ? null : getExtension.call(this, name);
}};
"""


def lied(browser, path, lie):
    browser.open(path, "#" + lie)
    report = report_of(browser)
    return scenes_of(report), browser.text("sentence")


def lies():
    browser = Browser(path_of("lies"), LLVMPIPE, LIES)
    path = page(*FEW)
    scenes, said = lied(browser, path, "")
    check(verdicts(scenes, "agreed") == set(FEW) - {"hard/tiles-wide"} and said.startswith("No wrong pixel was found."),
          "without a lie all agree", said, *scenes.values())
    place = f"first at {X},{Y} "
    for lie, parts in (("sample", (place, "at 600 nm")), ("triangle", (place, "triangle")), ("band", ("at 600 nm",)), ("black", ("at 400 nm",))):
        scenes, said = lied(browser, path, lie)
        found = scenes["patches"]
        check(found["verdict"] == "differs" and all(part in found["message"] for part in parts) and "wrong pixels in" in said
              and "first in patches" in said, f"a lie, {lie}: it is found at its place", found, said)
        if lie == "sample":
            pixels = browser.evaluate("results[0].check.unexplained_pixels")
            check(pixels == 1, "and nowhere else", pixels)
            saved_case(browser, found)
    scenes, said = lied(browser, path, "nearest")
    wrong = scenes["textures"]
    check(verdicts(scenes, "differs") == {"textures"} and "OpenGL" in wrong["message"] and " nm " in wrong["message"],
          "a lie, nearest texels: it is found", wrong)
    scenes, said = lied(browser, path, "always-nearest")
    check(verdicts(scenes, "failed") == set(FEW) - {"hard/tiles-wide"} and "its targets differ" in scenes["patches"]["message"],
          "where the targets have nearest texels, too, no scene is judged by them", *scenes.values())
    lacks(browser, path)
    stops(browser)
    browser.close()


def saved_case(browser, found):
    """The case of a difference, saved by its button, differs on the command line, too."""
    browser.evaluate("(() => { document.querySelector('.why button').id = 'save-case'; })()")
    result, again = judged(unpacked(browser.download("save-case", "patches.tar"), "saved"))
    check(result.returncode == 1 and found["message"] in result.stderr and again["verdict"] == "differs",
          "judge finds the same in the folder that the page saves", result.stderr)


def lacks(browser, path):
    """The page says what a browser lacks; nothing agrees that was not drawn."""
    scenes, said = lied(browser, path, "lost")
    lost = scenes["patches"]
    check(lost["verdict"] == "failed" and "lost the GPU" in lost["message"] and "1 failed" not in said.split("failed")[0],
          "a context that is lost is said", lost, said)
    scenes, said = lied(browser, path, "EXT_depth_clamp")
    check(not_tried(scenes) == {"spheres", "hard/shadow-ground", "hard/tiles-wide"} and "EXT_depth_clamp" in scenes["spheres"]["message"],
          "without clamped depths scenes with shadows are not tried", *scenes.values())
    scenes, said = lied(browser, path, "EXT_color_buffer_float")
    check(not_tried(scenes) == set(FEW) and not verdicts(scenes, "agreed") and said.startswith("Nothing could be verified."),
          "without floats nothing is tried, and the page says so", said)


def stops(browser):
    """Stop ends a run at once; another one begins by the keyboard. A page in the background says that its seconds are too many."""
    path = page("metals", "patches", write("own.scene", "wavelengths 400 700 100\nsize 60 40\nlight d65 1 direction 0 0 1\n"
                                           "camera ortho 3\nmaterial m { diffuse spectrum.csv }\nobject sphere 1 20 10 material m\n"))
    browser.open(path, until="document.getElementById('progress')?.textContent.includes('metals')")
    browser.evaluate("(() => { Object.defineProperty(document, 'hidden', {value: true}); document.dispatchEvent(new Event('visibilitychange')); })()")
    check("in the background" in browser.message(), "a page in the background says what that changes", browser.message())
    browser.press("stop")
    browser.wait("document.body.dataset.ready === 'true'")
    check(browser.text("progress").startswith("Stopped after 0 of 3 scenes."), "Stop ends a run in the middle of a scene", browser.text("progress"))
    browser.evaluate("element('again').focus()")
    browser.enter()
    browser.wait("document.body.dataset.ready !== 'true'")
    browser.wait("document.body.dataset.ready === 'true'")
    scenes = scenes_of(report_of(browser))
    check(verdicts(scenes, "agreed") == {"metals", "patches", path_of("own.scene")}, "it begins again by the keyboard; a scene of one's own is verified", *scenes.values())
    for width, scheme in ((390, "dark"), (1100, "light")):
        browser.size(width, 844)
        browser.scheme(scheme)
        wide, colour = browser.evaluate("[document.documentElement.scrollWidth, getComputedStyle(document.body).backgroundColor]")
        check(wide <= width and (int(colour[4:].split(",")[0]) < 128) == (scheme == "dark"), f"{width} pixels hold the page, {scheme}", wide, colour)


def main():
    write("spectrum.csv", "nm,reflectance\n400,0.2\n700,0.7\n")
    refusals()
    swiftshader()
    lies()
    browser = Browser(path_of("angle"), LLVMPIPE)
    all_agree(browser, "Chromium on llvmpipe")
    browser.close()
    screen = subprocess.Popen(["Xvfb", "-displayfd", "1", "-screen", "0", "1280x1000x24"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    browser = Firefox(path_of("firefox"), ":" + screen.stdout.readline().decode().strip())
    all_agree(browser, "Firefox on llvmpipe")
    browser.close()
    screen.kill()
    done()


main()
