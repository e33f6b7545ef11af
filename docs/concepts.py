#!/usr/bin/env python3
"""Draws docs/pictures/concept-*.svg, the drawings of concepts.md: docs/concepts.py"""

import math
import os

BLUE, ORANGE, GREEN, GREY, INK = "#00508f", "#d55e00", "#009e73", "#c9ced3", "#222222"
FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "pictures")


class Drawing:
    def __init__(self, name, height):
        self.path, self.height, self.parts = os.path.join(FOLDER, f"concept-{name}.svg"), height, []

    def line(self, points, colour=INK, width=1.5, dash="", fill="none"):
        text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        dash = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(f'<polyline points="{text}" fill="{fill}" stroke="{colour}" stroke-width="{width}"{dash} stroke-linejoin="round"/>')

    def area(self, points, fill):
        text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self.parts.append(f'<polygon points="{text}" fill="{fill}"/>')

    def dot(self, x, y, colour=INK, radius=4):
        self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}" fill="{colour}"/>')

    def box(self, x, y, wide, high, fill="white", colour=INK, width=1.5):
        self.parts.append(f'<rect x="{x}" y="{y}" width="{wide}" height="{high}" rx="3" fill="{fill}" stroke="{colour}" stroke-width="{width}"/>')

    def text(self, x, y, words, colour=INK, anchor="start", bold=False):
        weight = ' font-weight="bold"' if bold else ""
        self.parts.append(f'<text x="{x}" y="{y}" fill="{colour}" text-anchor="{anchor}"{weight}>{words}</text>')

    def arrow(self, a, b, colour=INK, width=1.5, both=False):
        self.line([a, b], colour, width)
        for tip, tail in ((b, a), (a, b)) if both else ((b, a),):
            angle = math.atan2(tip[1] - tail[1], tip[0] - tail[0])
            wings = [(tip[0] - 9 * math.cos(angle + s), tip[1] - 9 * math.sin(angle + s)) for s in (0.4, -0.4)]
            self.area([tip, *wings], colour)

    def eye(self, x, y):
        self.area([(x - 14, y - 8), (x - 14, y + 8), (x, y)], INK)

    def write(self):
        body = "\n".join(self.parts)
        with open(self.path, "w", encoding="utf-8") as file:
            file.write(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 640 {self.height}" font-family="sans-serif" font-size="15">\n'
                       f'<rect width="640" height="{self.height}" fill="white"/>\n{body}\n</svg>\n')


def mesh(side, wanted):
    """Right isosceles triangles over a square of `side` cells, refined where wanted(x, y, step), without cracks."""
    active = set()

    def activate(x, y, step, on_side):
        if (x, y) in active or not (0 <= x <= side and 0 <= y <= side):
            return
        active.add((x, y))
        if on_side:  # its parents are the centres on both sides
            along_x = (x // step) % 2 == 1
            for s in (-step, step):
                px, py = (x, y + s) if along_x else (x + s, y)
                if 0 < px < side and 0 < py < side:
                    activate(px, py, step, False)
        elif step * 2 < side:  # a centre's: two sides of the coarser square
            for px, py in ((x - step, y - step), (x + step, y - step), (x - step, y + step), (x + step, y + step)):
                if px % (4 * step) == 2 * step or py % (4 * step) == 2 * step:
                    if (px // (2 * step) + py // (2 * step)) % 2 == 1:
                        activate(px, py, 2 * step, True)
    step = side // 2
    while step >= 1:
        for y in range(0, side + 1, step):
            for x in range(0, side + 1, step):
                odd = (x // step) % 2 + (y // step) % 2
                if odd and wanted(x, y, step):
                    activate(x, y, step, odd == 1)
        step //= 2
    triangles = []

    def split(a, b, apex, depth):  # a, b: the ends of the hypotenuse
        middle = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
        if depth > 0 and middle in active:
            split(apex, a, middle, depth - 1)
            split(b, apex, middle, depth - 1)
        else:
            triangles.append((a, b, apex))
    depth = 2 * int(math.log2(side))
    split((0, 0), (side, side), (side, 0), depth)
    split((side, side), (0, 0), (0, side), depth)
    return triangles, active


def draw_mesh(d, triangles, x, y, cell, colour=BLUE):
    for triangle in triangles:
        points = [(x + cell * px, y + cell * py) for px, py in triangle]
        d.line([*points, points[0]], colour, 1)


def near(eye, share):
    return lambda x, y, step: math.hypot(x - eye[0], y - eye[1]) < share * step


def error():
    d = Drawing("error", 250)
    ground = [(180 + 4.3 * i, 190 - 45 * math.sin(i / 16) - 12 * math.sin(i / 3.7) - 0.25 * i) for i in range(105)]
    d.line(ground, GREY, 5)
    ends = (ground[0], ground[52], ground[104])
    d.line(ends, BLUE, 2.5)
    for end in ends:
        d.dot(*end, BLUE)
    at = max(range(53, 104), key=lambda i: abs(ground[i][1] - (ends[1][1] + (ends[2][1] - ends[1][1]) * (i - 52) / 52)))
    true = ground[at]
    drawn = (true[0], ends[1][1] + (ends[2][1] - ends[1][1]) * (at - 52) / 52)
    eye = (50, 40)
    plane = 120
    hits = []
    for end in (true, drawn):
        d.line([eye, end], INK, 1, "4 4")
        hits.append((plane, eye[1] + (end[1] - eye[1]) * (plane - eye[0]) / (end[0] - eye[0])))
    d.line([(plane, 12), (plane, 130)], INK, 1.5)
    d.line(hits, ORANGE, 6)
    d.line([true, drawn], ORANGE, 4)
    d.eye(*eye)
    d.text(14, 24, "the eye")
    d.text(plane + 8, 24, "the picture")
    d.text(plane - 8, 100, "error in pixels", ORANGE, "end")
    d.text(true[0], true[1] + 24, "error in metres", ORANGE, "middle")
    d.text(190, 232, "the full resolution", "#777777")
    d.text(430, 95, "the mesh that is drawn", BLUE)
    d.write()


def pages():
    d = Drawing("pages", 250)
    for i in range(5):
        d.line([(20 + 40 * i, 40), (20 + 40 * i, 200)])
        d.line([(20, 40 + 40 * i), (180, 40 + 40 * i)])
    d.box(100, 80, 40, 40, "#fbe3d2", ORANGE, 2.5)
    d.text(100, 26, "terrain: tiles", anchor="middle", bold=True)
    d.text(100, 226, "a tile is drawn at once", anchor="middle")
    for n, (x, name) in enumerate(((240, "step 4"), (375, "step 2"), (510, "step 1"))):
        cells = 4 * 2 ** n
        for i in range(cells + 1):
            d.line([(x, 70 + 110 * i / cells), (x + 110, 70 + 110 * i / cells)], GREY, 1)
            d.line([(x + 110 * i / cells, 70), (x + 110 * i / cells, 180)], GREY, 1)
        side = 110 / 2 ** n
        for j in range(2 ** n):
            for i in range(2 ** n):
                shown = (i, j) == (1, 1) or n == 0
                d.box(x + side * i, 70 + side * j, side, side, "#d7e6f2" if shown else "none", BLUE, 2 if shown else 1)
        d.text(x + 55, 200, name, anchor="middle")
    d.line([(140, 80), (240, 70)], ORANGE, 1, "4 4")
    d.line([(140, 120), (240, 180)], ORANGE, 1, "4 4")
    d.text(430, 26, "one tile: its steps, cut into pages", anchor="middle", bold=True)
    d.text(430, 226, "a page (blue) is loaded at once", anchor="middle")
    d.write()


def cut():
    d = Drawing("cut", 310)
    eyes = ((7, 16), (11, 16))
    results = [mesh(32, near(eye, 3.2)) for eye in eyes]
    for n, (triangles, active) in enumerate(results):
        x = 40 + 310 * n
        draw_mesh(d, triangles, x, 40, 7.8)
        changed = active - results[1 - n][1]
        for px, py in changed:
            d.dot(x + 7.8 * px, 40 + 7.8 * py, ORANGE if n == 0 else GREEN, 4)
        d.eye(x + 7.8 * eyes[n][0], 40 + 7.8 * eyes[n][1])
    d.text(165, 26, "one frame: these will go", ORANGE, "middle", True)
    d.text(475, 26, "a later one: these have come", GREEN, "middle", True)
    d.write()


def morph():
    d = Drawing("morph", 190)
    for n, (rise, words) in enumerate(((0, "it appears on the edge"), (0.5, "it rises as the eye comes nearer"), (1, "it has its own height"))):
        x = 20 + 210 * n
        d.line([(x, 130), (x + 180, 110)], GREY, 1.5, "4 4")
        middle = (x + 90, 120 - 55 * rise)
        d.line([(x, 130), middle, (x + 180, 110)], BLUE, 2.5)
        for end in ((x, 130), (x + 180, 110)):
            d.dot(*end, BLUE)
        d.dot(*middle, ORANGE, 5)
        if rise:
            d.arrow((x + 90, 118), (x + 90, middle[1] + 8), ORANGE)
        d.text(x + 90, 165, words.split(" as ")[0], anchor="middle")
        if " as " in words:
            d.text(x + 90, 183, "as " + words.split(" as ")[1], anchor="middle")
    d.text(320, 30, "one vertex, three frames", anchor="middle", bold=True)
    d.write()


def offscreen():
    d = Drawing("offscreen", 310)
    eye = (10, 16)

    def inside(x, y):
        return x - eye[0] > -1.5 and abs(y - eye[1]) < 0.6 * (x - eye[0]) + 2
    factors = (("factor 1: turning changes nothing", lambda x, y, step: near(eye, 3.2)(x, y, step)),
               ("factor 8: fewer vertices, less work", lambda x, y, step: near(eye, 3.2 if inside(x, y) else 0.8)(x, y, step)))
    for n, (words, wanted) in enumerate(factors):
        x = 40 + 310 * n
        triangles, _ = mesh(32, wanted)
        far = 32 - eye[0]
        at = lambda px, py: (x + 7.8 * px, 40 + 7.8 * py)
        d.area([at(*eye), at(32, max(0, eye[1] - 0.6 * far)), at(32, min(32, eye[1] + 0.6 * far))], "#fdf0d5")
        draw_mesh(d, triangles, x, 40, 7.8)
        d.eye(*at(*eye))
        d.text(x + 125, 26, words, anchor="middle", bold=True)
    d.write()


def budget():
    d = Drawing("budget", 300)
    for n, (words, most) in enumerate((("60 vertices", 60), ("150 vertices", 150), ("400 vertices", 400))):
        share = 8.0
        while len(mesh(32, near((16, 30), share))[1]) > most:
            share *= 0.97
        triangles, _ = mesh(32, near((16, 30), share))
        x = 20 + 210 * n
        draw_mesh(d, triangles, x, 50, 5.8)
        d.eye(x + 5.8 * 16, 50 + 5.8 * 30)
        d.text(x + 93, 34, words, anchor="middle", bold=True)
        d.text(x + 93, 262, f"threshold {8 / share:.1f} times", anchor="middle")
    d.text(320, 288, "a smaller budget raises the threshold; there are no cracks", anchor="middle")
    d.write()


def shards():
    d = Drawing("shards", 240)
    d.box(20, 90, 90, 60, "#eef1f4")
    d.text(65, 125, "heights", anchor="middle")
    d.arrow((112, 120), (148, 120))
    d.box(150, 90, 80, 60, "#fbe3d2", ORANGE)
    d.text(190, 125, "plan", anchor="middle")
    for n in range(4):
        y = 18 + 54 * n
        d.arrow((232, 120), (288, y + 22))
        d.box(290, y, 120, 44, "#d7e6f2", BLUE)
        d.text(350, y + 27, f"shard {n + 1}", anchor="middle")
        d.arrow((412, y + 22), (468, 120))
    d.box(470, 90, 70, 60, "#fbe3d2", ORANGE)
    d.text(505, 125, "merge", anchor="middle")
    d.arrow((542, 120), (568, 120))
    d.box(570, 90, 60, 60, "#eef1f4")
    d.text(600, 125, "pack", anchor="middle")
    d.write()


for make in (error, pages, cut, morph, offscreen, budget, shards):
    make()
