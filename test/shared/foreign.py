# SPDX-License-Identifier: MIT
"""Pixels of a stack as those of another program, by the script of the page of exchange."""
import re
import subprocess
import sys


def draw_from(exported, stack, drawn):
    with open("data/doc/exchange.md", encoding="utf-8") as page:
        script = re.search(r"^python3 - .*?\n(.*?)^END$", page.read(), re.MULTILINE | re.DOTALL).group(1)
    subprocess.run([sys.executable, "-", exported, stack, drawn], input=script, text=True, check=True)
