#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# level: release; packages: debootstrap buildah python3-numpy python3-tifffile; makes: static
"""Runs the program in a container of the recipe among the samples, and in small Debian systems: without any OpenGL, with EGL's library but no driver, and with EGL and Mesa's
drivers, where the program is also built from its sources, without OSMesa. Makes them by debootstrap, as root, from the
mirror that this system uses: FULL only. Prints TAP."""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
from rendered import SPECTRAL, bail_out, check, done

RENDER = ("render", "patches", "--size", "60x40", "-o", "/tmp/stack.tif")


def mirror():
    """Mirror and suite, from the lists of apt."""
    for path in ["/etc/apt/sources.list", *sorted(glob.glob("/etc/apt/sources.list.d/*"))]:
        text = open(path).read() if os.path.isfile(path) else ""
        found = re.search(r"^deb (?:\[.*\] )?(\S+) (\S+)", text, re.MULTILINE) or \
            re.search(r"^URIs: (\S+)\nSuites: (\S+)", text, re.MULTILINE)
        if found:
            return found.groups()
    return bail_out("the lists of apt name no mirror")


def inside(system, *words):
    return subprocess.run(["chroot", system, *words], check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, env={"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "LC_ALL": "C"})


def install(system, *packages):
    result = inside(system, "apt-get", "install", "-y", "-q", "--no-install-recommends", *packages)
    check(result.returncode == 0, f"the system gets {' '.join(packages)}", result.stderr)


def without_opengl(system):
    result = inside(system, "/spectral", *RENDER)
    check(result.returncode == 3 and result.stderr.count("\n") == 1 and "libosmesa6" in result.stderr and
          "libegl1 and libgl1-mesa-dri" in result.stderr and "--renderer raster needs none" in result.stderr,
          "without OpenGL one line names the packages", result.stderr)
    check(not os.path.exists(system + "/tmp/stack.tif"), "no stack appears")
    result = inside(system, "/spectral", *RENDER, "--renderer", "raster", "--no-check")
    check(result.returncode == 0 and os.path.exists(system + "/tmp/stack.tif"), "the reference draws", result.stderr)
    result = inside(system, "/spectral", "drivers")
    check(result.returncode == 3 and result.stdout.count("cannot draw: OpenGL is missing") == 2, "drivers says why", result.stdout)
    result = inside(system, "/spectral", "--version")
    check(result.returncode == 0 and len(result.stdout.splitlines()) == 3, "--version has its three lines", result.stdout)
    result = inside(system, "/spectral", "cost", "patches", "--quick", "--quiet", "--csv", "/tmp/cost.csv")
    check(result.returncode == 0, "cost measures the reference", result.stderr)
    libraries = inside(system, "ldd", "/spectral").stdout
    check("libtiff" in libraries and not re.search("OSMesa|EGL|libGL|not found", libraries), "ldd finds all that is linked", libraries)


def with_egl(system):
    install(system, "libegl1")
    result = inside(system, "/spectral", *RENDER)
    check(result.returncode == 3 and "libgl1-mesa-dri (Debian)" in result.stderr.splitlines()[-1], "without a driver, its package is named",
          result.stderr)
    install(system, "libgl1-mesa-dri")
    result = inside(system, "/spectral", *RENDER)
    check(result.returncode == 0 and re.search("^OpenGL .* by EGL$", result.stdout, re.MULTILINE) and "verdict           agreed" in result.stdout,
          "with EGL and a driver the program draws and agrees", result.stdout, result.stderr)
    result = inside(system, "/spectral", *RENDER, "--gl", "osmesa")
    check(result.returncode == 3 and result.stderr.count("\n") == 1 and "libosmesa6" in result.stderr, "OSMesa is missing still", result.stderr)
    result = inside(system, "/spectral", "drivers")
    check(result.returncode == 0 and "--gl egl --renderer softpipe\n" in result.stdout and
          "--gl osmesa\n  cannot draw: OpenGL is missing" in result.stdout, "drivers lists what there is", result.stdout)


def from_sources(system):
    install(system, "gcc", "libc6-dev", "libtiff-dev", "libgl-dev", "libegl-dev")
    archive = subprocess.run(["git", "archive", "HEAD"], check=True, stdout=subprocess.PIPE).stdout
    os.makedirs(system + "/src")
    subprocess.run(["tar", "x", "-C", system + "/src"], input=archive, check=True)
    result = inside(system, "sh", "-c", "cd /src && ./build.sh")
    check(result.returncode == 0 and not os.path.exists(system + "/usr/include/GL/osmesa.h"), "it is built without OSMesa's headers",
          result.stdout, result.stderr)
    result = inside(system, "/src/build/spectral", *RENDER)
    check(result.returncode == 0 and "verdict           agreed" in result.stdout, "what was built agrees", result.stdout, result.stderr)


def recipe():
    """The recipe that is installed with the samples: a container of the static program, and nothing else."""
    folder = tempfile.mkdtemp(prefix="spectral-image-")
    context = os.path.join(folder, "context")
    buildah = ["buildah", "--root", folder + "/root", "--runroot", folder + "/run", "--storage-driver", "vfs"]

    def run(*words):
        return subprocess.run([*buildah, *words], check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)

    try:
        os.makedirs(context)
        shutil.copy(os.environ.get("STATIC", "build/spectral-static"), os.path.join(context, "spectral-static"))
        made = run("bud", "--isolation", "chroot", "-t", "spectral", "-f", "data/samples/Containerfile", context)
        check(made.returncode == 0, "the recipe makes a container", made.stderr)
        container = run("from", "spectral").stdout.strip()
        inside_it = ("run", "--isolation", "chroot", "-v", context + ":/data", container, "--", "/spectral")
        drawn = run(*inside_it, "render", "patches", "--size", "60x40", "-o", "patches.tif")
        check(drawn.returncode == 0 and "verdict           agreed" in drawn.stdout and os.path.exists(os.path.join(context, "patches.tif")),
              "the container draws into the folder that it is given", drawn.stderr)
        files = run("mount", container).stdout.strip()
        check(set(os.listdir(files)) <= {"spectral", "tmp", "data", "dev", "etc", "proc", "run", "sys"}, "it holds one file", os.listdir(files))
        run("rm", container)
    finally:
        shutil.rmtree(folder)


if "FULL" not in os.environ or os.geteuid() != 0 or not shutil.which("debootstrap"):
    check(True, "skipped: it needs FULL, root and debootstrap # SKIP")
    done()
    sys.exit()
recipe()
SYSTEM = tempfile.mkdtemp(prefix="spectral-container-")
try:
    from_mirror, suite = mirror()
    made = subprocess.run(["debootstrap", "--variant=minbase", "--include=libtiff6", suite, SYSTEM, from_mirror], check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
    check(made.returncode == 0, "debootstrap makes a system", made.stdout[-2000:])
    shutil.copy(SPECTRAL, SYSTEM + "/spectral")
    without_opengl(SYSTEM)
    with_egl(SYSTEM)
    from_sources(SYSTEM)
finally:
    shutil.rmtree(SYSTEM)
done()
