#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; packages: python3-numpy python3-tifffile
"""A stack whose record is damaged is refused, one without a record is read like a stack of another program, and a map of objects that
was cut off or forged is none. test_record.c has more lines that are malformed, images.py cuts stacks anywhere else. Prints TAP."""
import json
import re

from rendered import bytes_of, check, done, path_of, reference, run, write

WHOLE = bytes_of(reference("whole.tif", write("whole.scene", """wavelengths 400 700 100
size 4 4
camera ortho 4
light d65 1 direction 0 0 1
material paint { diffuse 0.5 }
object plane 2 2 material paint
""")))
AT = int(re.search(rb"\nobject_map: (\d+) 1\n", WHOLE)[1])
MAP = b"object_map: %d 1" % AT
# Bytes, others in their place, how many bytes the file is longer, and what it is then.
FORGED = ((MAP, b"object_map: %d 1" % (AT + 1), 0, "own"), (MAP, b"object_map: 99999999999999999999", 0, "damaged"), (b"object: ", b"subject:", 0, "own"),
          (b"program", b"program", 1, "own"), (b"program", b"program", -1, "own"), (b"white: 0.", b"white: -.", 0, "damaged"),
          (b"illumination: 1", b"illumination: 0", 0, "damaged"), (b"program: ", b"programme", 0, "damaged"),
          (b"scene_sha256", b"scene_sha257", 0, "foreign"))


def probed(content, x=1, y=1):
    """The JSON that probe gives of such a file, None if it is refused, and the message."""
    with open(path_of("forged.tif"), "wb") as out:
        out.write(content)
    result = run("probe", path_of("forged.tif"), x, y, "--json", "-")
    return json.loads(result.stdout) if result.returncode == 0 else None, result.stderr


found, _ = probed(WHOLE)
check(found["object"] and len(found["radiance"]) == 4, "a pixel's object is read", found)
for old, new, longer, fate in FORGED:
    start, length = WHOLE.index(old), len(WHOLE) + longer
    found, says = probed((WHOLE[:start] + new + WHOLE[start + len(new):]).ljust(length, b"\0")[:length])
    check(not found and "forged.tif: its record of how it was made is damaged" in says if fate == "damaged" else
          found and not found["object"] and (found["white_XYZ"] is not None) == (fate == "own") and len(found["radiance"]) == 4,
          f"{old.decode()[:13]!r} made {new.decode()[:13]!r}, {longer} bytes more: the stack is {fate}, without objects", found, says)
stray = WHOLE[:-16] + b"\2" + WHOLE[-15:]
check(not probed(stray, 0, 0)[0]["object"] and probed(stray)[0]["object"], "a number without an object names none", probed(stray))
found, says = probed(WHOLE[:AT])
check(found and not found["object"] and found["white_XYZ"], "a stack that is cut before its map lacks nothing else", found, says)
found, says = probed(WHOLE[:AT - 1])
check(not found and "page 4 (700 nm): its pixels end beyond the end of the file" in says, "one that is cut within its pixels is refused", says)
done()
