# SPDX-License-Identifier: MIT
"""Helps scripts that run what the pages in data/doc say."""
import os
import subprocess
import sys

from rendered import SPECTRAL, TMP

FOLDER = "data/doc"


def read(page):
    with open(os.path.join(FOLDER, page), encoding="utf-8") as file:
        return file.read()


def run(*words, **options):
    """Runs a command; its output and its errors are one text."""
    return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **options)


def put_in_path():
    """Lets commands find `spectral`, and as `python3` the Python of the system, which has the modules."""
    folder = os.path.join(os.path.abspath(TMP), "bin")
    os.makedirs(folder, exist_ok=True)
    for name, program in (("spectral", SPECTRAL), ("python3", sys.executable)):
        link = os.path.join(folder, name)
        if os.path.lexists(link):
            os.remove(link)
        os.symlink(os.path.abspath(program), link)
    os.environ["PATH"] = folder + os.pathsep + os.environ["PATH"]
