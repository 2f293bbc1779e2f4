#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: debootstrap buildah python3-numpy python3-tifffile; makes: static
"""Runs the first command of README, ./build.sh run, in fresh Debian systems, and prints its seconds and what it installs:
versions 11, 12 and 13, unstable, which has no OSMesa, and 12 for x86 of 32 bits. There the program draws the golden bytes,
and agrees with OpenGL in all scenes of `verify`; ./build.sh test passes on three. Debian 11 stands for systems with libtiff
4.2 or later and gcc 10, such as Ubuntu 22.04 (4.3, gcc 11) and RHEL 9 (4.4, gcc 11). Runs the program in a container of the recipe among
the samples, and in a system without any OpenGL, with EGL's library but no driver, and with EGL and Mesa's drivers. Makes the
systems by debootstrap, as root, from the mirror that this system uses. Words behind the script are suites: those systems
alone, such as bullseye or bookworm:i386. Prints TAP."""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

from rendered import SPECTRAL, bail_out, check, done
from tap import skip_all

RENDER = ("render", "patches", "--size", "60x40", "-o", "/tmp/stack.tif")
SUITES = "bullseye", "bookworm", "bookworm:i386", "trixie", "unstable"
TESTED = "bookworm", "trixie", "unstable"  # by the first level, whose packages older systems lack


def mirror():
    """The mirror, from the lists of apt."""
    for path in ["/etc/apt/sources.list", *sorted(glob.glob("/etc/apt/sources.list.d/*"))]:
        text = open(path).read() if os.path.isfile(path) else ""
        found = re.search(r"^deb (?:\[.*\] )?(\S+) (\S+)", text, re.MULTILINE) or \
            re.search(r"^URIs: (\S+)\nSuites: (\S+)", text, re.MULTILINE)
        if found:
            return found[1]
    return bail_out("the lists of apt name no mirror")


def inside(system, *words):
    return subprocess.run(["chroot", system, *words], check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, env={"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "LC_ALL": "C"})


def install(system, *packages):
    result = inside(system, "apt-get", "install", "-y", "-q", "--no-install-recommends", *packages)
    check(result.returncode == 0, f"the system gets {' '.join(packages)}", result.stderr)


def without_opengl(system):
    """contexts.py has what else the program says where libraries are missing."""
    result = inside(system, "/spectral", *RENDER)
    check(result.returncode == 3 and result.stderr.count("\n") == 1 and "libosmesa6" in result.stderr and
          "libegl1 and libgl1-mesa-dri" in result.stderr and "--renderer raster needs none" in result.stderr,
          "without OpenGL one line names the packages", result.stderr)
    check(not os.path.exists(system + "/tmp/stack.tif"), "no stack appears")
    result = inside(system, "/spectral", *RENDER, "--renderer", "raster", "--no-check")
    check(result.returncode == 0 and os.path.exists(system + "/tmp/stack.tif"), "the reference draws", result.stderr)


def with_egl(system):
    install(system, "libegl1")
    result = inside(system, "/spectral", *RENDER)
    check(result.returncode == 3 and "libgl1-mesa-dri (Debian)" in result.stderr.splitlines()[-1], "without a driver, its package is named",
          result.stderr)
    install(system, "libgl1-mesa-dri")
    result = inside(system, "/spectral", *RENDER)
    check(result.returncode == 0 and re.search("^drawn by .* by EGL$", result.stdout, re.MULTILINE) and "verdict           agreed" in result.stdout,
          "with EGL and a driver the program draws and agrees", result.stdout, result.stderr)


def system_of(suite, folder, *options):
    made = subprocess.run(["debootstrap", "--variant=minbase", *options, suite, folder, mirror()], check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
    check(made.returncode == 0, f"debootstrap makes {suite}", made.stdout[-2000:])
    with open(folder + "/etc/apt/apt.conf.d/99mirror", "w", encoding="ascii") as out:
        out.write('Acquire::Check-Valid-Until "false";\n')  # a mirror may keep old lists


def fresh(suite):
    """The first commands of a new user, and of a new contributor."""
    name, _, machine = suite.partition(":")
    folder = tempfile.mkdtemp(prefix=f"spectral-{name}-")
    try:
        system_of(name, folder, *[f"--arch={machine}"] if machine else [])
        archive = subprocess.run(["git", "archive", "HEAD"], check=True, stdout=subprocess.PIPE).stdout
        os.makedirs(folder + "/src")
        subprocess.run(["tar", "x", "-C", folder + "/src"], input=archive, check=True)
        subprocess.run(["mount", "-t", "proc", "proc", folder + "/proc"], check=True)
        verify = "build/spectral verify"
        golden = "SPECTRAL=build/spectral test/builds/golden.sh"
        for words in ["./build.sh run", verify, golden] + ["./build.sh test"] * (suite in TESTED):
            begun = time.monotonic()
            result = inside(folder, "sh", "-c", f"cd /src && {words} </dev/null")
            check(result.returncode == 0, f"{suite}: {words}", result.stdout[-3000:], result.stderr[-3000:])
            print(f"# {suite}: {words}: {time.monotonic() - begun:.0f} s;",
                  *re.findall("^installing ([^:]*)|^([0-9]+ passed.*)", result.stdout, re.MULTILINE), flush=True)
            if words == verify:
                print("# by each way:", *re.findall("agreed .*", result.stdout))
            if words == "./build.sh run":
                check("warning:" not in result.stderr and "verdict           agreed" in result.stdout,
                      f"{suite}: the compiler warns of nothing, and the picture agrees", result.stderr)
    finally:
        subprocess.run(["umount", folder + "/proc"], check=False, stderr=subprocess.DEVNULL)
        if not os.path.ismount(folder + "/proc"):
            shutil.rmtree(folder)


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


def small():
    folder = tempfile.mkdtemp(prefix="spectral-small-")
    try:
        version = re.search("^VERSION_CODENAME=(.*)", open("/etc/os-release", encoding="utf-8").read(), re.MULTILINE)[1]
        system_of(version, folder, "--include=libtiff6")
        shutil.copy(SPECTRAL, folder + "/spectral")
        without_opengl(folder)
        with_egl(folder)
    finally:
        shutil.rmtree(folder)


if os.geteuid() != 0:
    skip_all("it makes systems, as root")
for each in sys.argv[1:] or SUITES:
    fresh(each)
if not sys.argv[1:]:
    recipe()
    small()
done()
