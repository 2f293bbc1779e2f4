# SPDX-License-Identifier: MIT
"""CIELAB, colour differences and displays, for scripts that compute colours independently of the program."""
import numpy as np

# The thesis's monitor (equations 13 and 14): from XYZ of Y = 100 to linear values; linear = (gain x value)^gamma
MONITOR = np.array([[0.03426, -0.01633, -0.005365], [-0.01026, 0.01911, 0.0002522], [0.000529, -0.001811, 0.00867]])
MONITOR_GAIN, MONITOR_GAMMA = np.array([1.035, 1.053, 1.047]), np.array([1.534, 1.393, 1.435])


class Display:
    """A display by its numbers: XYZ of red, green and blue at full drive; gain, offset and gamma of the three. The last axis of
    all values has three channels."""

    def __init__(self, *rows):
        self.rows = np.array(rows, float)
        self.primaries, (self.gain, self.offset, self.gamma) = self.rows[:3], self.rows[3:]
        self.largest = (self.gain + self.offset) ** self.gamma

    def shown(self, values):
        """XYZ of values from 0 to 1"""
        return (self.gain * values + self.offset).clip(0) ** self.gamma / self.largest @ self.primaries

    def linear(self, xyz):
        return xyz @ np.linalg.inv(self.primaries) * self.largest

    def values(self, linear):
        """The least values that show linear ones: black is 0, also below a negative offset"""
        return np.where(linear > 0, (linear.clip(0) ** (1 / self.gamma) - self.offset) / self.gain, 0).clip(0, 1)

    def text(self):
        """The file of the display"""
        names = "red", "green", "blue", "gain", "offset", "gamma"
        return "".join(",".join((name, *map(repr, row))) + "\n" for name, row in zip(names, self.rows.tolist()))


OWN_DISPLAYS = {
    "crt": Display((40.1, 20.9, 1.9), (35.2, 70.8, 11.6), (18.3, 7.4, 95.6), (0.96, 1.02, 1.1), (0.04, -0.03, 0), (2.35, 2.2, 1.8)),
    "dim": Display((12.5, 6.1, 0.2), (11, 22.3, 3.5), (6.2, 2.4, 33.3), (1.2, 0.8, 1), (-0.2, 0.15, 0.05), (3, 1, 0.7))}


def cielab(xyz, white):
    """CIE 15:2018, 8.2.1; the first axis is X, Y, Z, then L*, a*, b*"""
    ratio = np.asarray(xyz) / white
    x, y, z = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio * (29 / 6) ** 2 / 3 + 4 / 29)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def srgb(linear):
    """IEC 61966-2-1, from 0 to 1"""
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def cie94(standard, sample):
    """CIE 116-1995, graphic arts; hue and chroma as complex numbers"""
    one, two = (lab[1] + 1j * lab[2] for lab in (standard, sample))
    chroma = abs(one)
    dc, hue = chroma - abs(two), abs(one - two) ** 2 - (chroma - abs(two)) ** 2
    return np.sqrt((standard[0] - sample[0]) ** 2 + (dc / (1 + 0.045 * chroma)) ** 2
                   + np.maximum(hue, 0) / (1 + 0.015 * chroma) ** 2)


def ciede2000(one, two):
    """CIEDE2000 after Sharma, Wu and Dalal (Color Res. Appl. 30, 21-30, 2005)."""
    (l1, a1, b1), (l2, a2, b2) = one, two
    mean_c7 = ((np.hypot(a1, b1) + np.hypot(a2, b2)) / 2) ** 7
    g = 0.5 * (1 - np.sqrt(mean_c7 / (mean_c7 + 25.0 ** 7)))
    a1, a2 = (1 + g) * a1, (1 + g) * a2
    c1, c2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.degrees(np.arctan2(b1, a1)) % 360, np.degrees(np.arctan2(b2, a2)) % 360
    turn = h2 - h1
    turn = np.where(turn > 180, turn - 360, np.where(turn < -180, turn + 360, turn))
    turn = np.where(c1 * c2 == 0, 0, turn)
    hue = np.where(c1 * c2 == 0, h1 + h2, np.where(
        abs(h1 - h2) <= 180, (h1 + h2) / 2, np.where(h1 + h2 < 360, (h1 + h2 + 360) / 2, (h1 + h2 - 360) / 2)))
    dl, dc, dh = l2 - l1, c2 - c1, 2 * np.sqrt(c1 * c2) * np.sin(np.radians(turn / 2))
    l, c = (l1 + l2) / 2, (c1 + c2) / 2
    t = (1 - 0.17 * np.cos(np.radians(hue - 30)) + 0.24 * np.cos(np.radians(2 * hue))
         + 0.32 * np.cos(np.radians(3 * hue + 6)) - 0.20 * np.cos(np.radians(4 * hue - 63)))
    sl = 1 + 0.015 * (l - 50) ** 2 / np.sqrt(20 + (l - 50) ** 2)
    sc, sh = 1 + 0.045 * c, 1 + 0.015 * c * t
    rt = (-2 * np.sqrt(c ** 7 / (c ** 7 + 25.0 ** 7))
          * np.sin(np.radians(60 * np.exp(-((hue - 275) / 25) ** 2))))
    return np.sqrt((dl / sl) ** 2 + (dc / sc) ** 2 + (dh / sh) ** 2 + rt * dc / sc * dh / sh)
