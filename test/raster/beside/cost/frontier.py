#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: first; makes: test_frontier
"""The chart of accuracy and cost is well-formed XML for any values; points lie where their values put them; the legend names
those of the frontier; no number of the frontier covers another point. test_frontier.c draws the points given here. Prints TAP."""
import collections
import math
import os
import random
import re
import subprocess
import xml.etree.ElementTree as ElementTree

from tap import check, done

PROGRAM = os.path.join(os.environ.get("BUILD", "build"), "test/test_frontier")
SVG = "{http://www.w3.org/2000/svg}"
Point = collections.namedtuple("Point", "name cost error best uncertain", defaults=(False, False))
Box = collections.namedtuple("Box", "left right top bottom")


def draw(points):
    lines = "".join(f"{point.cost!r} {point.error!r} {point.best:d} {point.uncertain:d} {point.name}\n" for point in points)
    return subprocess.run([PROGRAM, "draw"], input=lines.encode("latin-1"), stdout=subprocess.PIPE, check=True).stdout


def box_of(text):
    """Characters are at most 0.6 of their size wide."""
    x, y, size = (float(text.get(key, 12)) for key in ("x", "y", "font-size"))
    width = 0.6 * size * len(text.text)
    left = x - {"middle": 0.5, "end": 1}.get(text.get("text-anchor"), 0) * width
    return Box(left, left + width, y - 0.85 * size, y + 0.15 * size)


def meet(one, other):
    return one.left < other.right and other.left < one.right and one.top < other.bottom and other.top < one.bottom


class Chart:
    def __init__(self, *points):
        self.svg = draw(points)
        self.root = ElementTree.fromstring(self.svg)
        self.texts = list(self.root.iter(SVG + "text"))
        self.words = [text.text for text in self.texts]
        groups = [group for group in self.root.iter(SVG + "g") if group.find(SVG + "title") is not None]
        self.bars, self.rings, self.others, self.frontier = groups
        names = [[point.name for point in points if kept(point)] for kept in (lambda point: point.uncertain, lambda point: not point.best,
                                                                              lambda point: point.best)]
        self.marks = {name: circle for group, own in zip(groups[2:], names[1:]) for name, circle in zip(own, group.iter(SVG + "circle"))}

    def marker(self, name):
        return float(self.marks[name].get("cx")), float(self.marks[name].get("cy"))

    def check_whole(self, name, points):
        boxes = [box_of(text) for text in self.texts if "rotate" not in text.get("transform", "") and len(text.text) < 100]
        height = float(self.root.get("height"))
        check(len(self.texts) > 5 and all(box.left >= 0 and box.right <= 800.5 and box.top >= 0 and box.bottom <= height
                                          for box in boxes), f"{name}: no text lies outside the chart", *boxes)
        check(self.svg.startswith(b'<?xml version="1.0" encoding="UTF-8"?>\n') and b"nan" not in self.svg and
              b"inf" not in self.svg, f"{name}: an XML parser takes it, and all numbers are finite")
        check(draw(points) == self.svg, f"{name}: a second drawing has the same bytes")


def check_whole(name, *points):
    Chart(*points).check_whole(name, points)


def places():
    """Four corners of two decades: equal factors are equal distances."""
    chart = Chart(Point("one", 0.1, 1, True), Point("two", 1, 0.1, True), Point("three", 10, 0.01, True), Point("beaten", 10, 1))
    x, y = zip(*map(chart.marker, ("one", "two", "three", "beaten")))
    check(abs(x[1] - x[0] - (x[2] - x[1])) <= 0.02, "equal factors of cost are equal distances", x)
    check(abs(y[1] - y[0] - (y[2] - y[1])) <= 0.02, "equal factors of error are equal distances", y)
    check(x[1] > x[0] and y[1] > y[0], "cost grows to the right and error upwards", x, y)
    check(x[3] == x[2] and y[3] == y[0], "points of equal cost lie above, of equal error beside each other", x, y)
    labels = {"0.1", "1", "10", "0.01", "seconds", "CIEDE2000, 95 % of the pixels (0.001: this or less)", "three"}
    check(labels <= set(chart.words) and "beaten" not in chart.words, "axes, units and points of the frontier are named, no others", chart.words)
    steps = f'M{x[0]:.2f},{y[0]:.2f}H{x[1]:.2f}V{y[1]:.2f}H{x[2]:.2f}V{y[2]:.2f}"'
    check(steps.encode() in chart.svg, "steps join the frontier: first along cost, then along error", steps)
    bars = {float(left): float(right) for left, right in re.findall(r"M([-\d.]+),[-\d.]+L([-\d.]+)", chart.bars.find(SVG + "path").get("d"))}
    decade = x[1] - x[0]
    check(all(any(abs(left - each - decade * math.log10(0.95)) < 0.02 and abs(right - each - decade * math.log10(1.1)) < 0.02
                  for left, right in bars.items()) for each in x[:3]), "a bar reaches from the fastest run to the slowest", bars)


def markers():
    """The marks differ without colours: a disk on the frontier, a small circle off it, a large one around a point within noise."""
    chart = Chart(Point("best", 0.1, 5, True), Point("beaten", 1, 6), Point("either", 2, 7, False, True))
    for group, mark, count, truth in ((chart.frontier, ("4", "#000000"), 1, "a point on the frontier is a disk"),
                                      (chart.others, ("3", "#fff"), 2, "a point off the frontier is a smaller circle"),
                                      (chart.rings, ("7", "#fff"), 1, "a ring surrounds a point within noise")):
        circles = [(circle.get("r"), circle.get("fill")) for circle in group.iter(SVG + "circle")]
        check(circles == [mark] * count, truth, *circles)


def edge():
    points = Point("coarse", 0.1, 5, True), Point("fine", 1, 0.004, True), Point("exact", 2, 0, True), Point("close", 3, 0.006)
    chart = Chart(*points)
    fine, exact, close = (chart.marker(name)[1] for name in ("fine", "exact", "close"))
    check(fine == exact, "no error, and one below 1/1000 of the largest, lie together", fine, exact)
    check(close < exact, "an error above 1/1000 of the largest does not", close, exact)
    check("CIEDE2000, 95 % of the pixels (0.005: this or less)" in chart.words, "the axis names the errors that this stands for", chart.words)


def degenerate():
    one = Point("one", 1, 1, True)
    check_whole("a crowded frontier", Point("first", 0.01, 1, True), *(
        Point(f"configuration {i} of many", 1 + 1e-3 * i, 1 - 1e-3 * i, True) for i in range(1, 60)))
    check_whole("no point")
    check_whole("one point", one)
    check_whole("one point without error", one._replace(error=0))
    check_whole("equal costs, equal errors, names of all kinds", *(Point('a <b> & "c" \x01\xff', 2, 3, i % 2 == 0) for i in range(4)))
    check_whole("long names", *(Point("W" * 127, 1 + i, 4 - i, i != 2) for i in range(4)))
    check_whole("points of any size", Point("fast", 1e-300, 1e-300, True), Point("slow", 1e300, 1e300))


def crowd(n, seed):
    """Points, a third of them crowded in one place."""
    dice, points = random.Random(seed), []
    for i in range(n):
        cost = 0.2 + 0.02 * dice.random() if i % 3 == 0 else 0.02 + dice.random() * i / n
        error = 0.3 + 0.05 * dice.random() if i % 3 == 0 else 0.02 / cost * (0.3 + dice.random())
        points.append(Point(f"gauss:{i} shading phong tessellation {i % 4}", cost, 0 if i == n - 1 else error, False, i % 9 == 0))
    return [point._replace(best=all(other.cost >= point.cost or other.error > point.error for other in points)) for point in points]


def numbers(n, seed):
    points = crowd(n, seed)
    chart = Chart(*points)
    legend = chart.words.index("on the frontier")
    rows = set(zip(chart.words[legend + 1:], chart.words[legend + 2:]))
    numbered = list(chart.frontier.iter(SVG + "text"))
    best, off = ([point for point in points if point.best == kind] for kind in (True, False))
    check(2 < len(best) < n / 2 and len(numbered) == len(best) and not list(chart.others.iter(SVG + "text")),
          f"{len(best)} of {n} points are on the frontier; those off it have no number")
    unnamed = [point.name for point, number in zip(best, numbered) if (number.text, point.name) not in rows]
    check(not unnamed, f"{n} points: the legend has the name of each number", *unnamed)
    covered = [(one.name, other.name) for one, number in zip(best, numbered) for other in off for x, y in [chart.marker(other.name)]
               if meet(box_of(number), Box(x - 3, x + 3, y - 3, y + 3))]
    check(not covered, f"{n} points: no number of the frontier covers a point off it", *covered)
    chart.check_whole("a crowd", points)


places()
edge()
markers()
degenerate()
for each in range(10):
    numbers(50 + each, each)
done()
