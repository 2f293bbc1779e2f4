# SPDX-License-Identifier: MIT
"""CIELAB and CIEDE2000, for scripts that do not take the program's word for colours."""
import numpy as np


def cielab(xyz, white):
    """CIE 15:2018, 8.2.1; of one colour or an array of them, the last axis X, Y, Z"""
    t = np.asarray(xyz) / white
    x, y, z = np.moveaxis(np.where(t > (6 / 29) ** 3, np.cbrt(t), t * (29 / 6) ** 2 / 3 + 4 / 29), -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], -1)


def ciede2000(first, second):
    """of two colours; CIE 142-2001, with kL = kC = kH = 1"""
    (l1, a1, b1), (l2, a2, b2) = first, second
    c7 = ((np.hypot(a1, b1) + np.hypot(a2, b2)) / 2) ** 7
    stretch = 1.5 - 0.5 * np.sqrt(c7 / (c7 + 25.0 ** 7))
    one, two = complex(stretch * a1, b1), complex(stretch * a2, b2)
    c1, c2 = abs(one), abs(two)
    h1, h2 = (np.degrees(np.angle(colour)) % 360 for colour in (one, two))
    turn = (h2 - h1 + 180) % 360 - 180 if c1 * c2 > 0 else 0
    if c1 * c2 == 0:
        h = h1 + h2 # one of them is 0
    else:
        h = (h1 + h2) / 2 if abs(h1 - h2) <= 180 else ((h1 + h2) / 2 + 180) % 360
    l, c = (l1 + l2) / 2, (c1 + c2) / 2

    def cosine(degrees):
        return np.cos(np.radians(degrees))
    t = (1 - 0.17 * cosine(h - 30) + 0.24 * cosine(2 * h) + 0.32 * cosine(3 * h + 6)
         - 0.2 * cosine(4 * h - 63))
    dl = (l2 - l1) / (1 + 0.015 * (l - 50) ** 2 / np.sqrt(20 + (l - 50) ** 2))
    dc = (c2 - c1) / (1 + 0.045 * c)
    dh = 2 * np.sqrt(c1 * c2) * np.sin(np.radians(turn / 2)) / (1 + 0.015 * c * t)
    rotation = (-2 * np.sqrt(c ** 7 / (c ** 7 + 25.0 ** 7))
                * np.sin(np.radians(60 * np.exp(-((h - 275) / 25) ** 2))))
    return np.sqrt(dl ** 2 + dc ** 2 + dh ** 2 + rotation * dc * dh)
