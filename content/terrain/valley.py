#!/usr/bin/env python3
"""Puts a lake, a road and terraced fields into the valley of valley.json.

fjell-bake synth content/terrain/valley.json -o valley.tif
content/terrain/valley.py valley.tif -o valley
writes valley.r32, heights in decimetres, 2049 x 1537 floats; valley.png, what lies where; valley.json, rules for
materials that name it. Needs gdal_translate of Debian's package gdal-bin.
"""

import array
import heapq
import json
import math
import os
import struct
import subprocess
import sys
import zlib

WIDE, HIGH = 2049, 1537  # samples a metre apart
ROAD, SOIL, STUBBLE, SHORE, WATER, MEADOW = 1, 2, 3, 4, 5, 6
RULES = [
    {"layer": "grass"},
    {"layer": "dry_grass", "noise": [0.55, 1], "noise_soft": 0.4, "noise_m": 60, "opacity": 0.7},
    {"layer": "dry_grass", "curvature_per_km": [8, None], "curvature_soft_per_km": 8, "opacity": 0.6},
    {"layer": "forest_floor", "slope_deg": [14, None], "slope_soft_deg": 8, "noise": [0.45, 1], "noise_soft": 0.2, "noise_m": 140},
    {"layer": "soil", "wetness": [10, None], "wetness_soft": 3, "slope_deg": [3, None], "slope_soft_deg": 3, "opacity": 0.5},
    {"layer": "scree", "slope_deg": [33, None], "slope_soft_deg": 8},
    {"layer": "rock", "slope_deg": [40, None], "slope_soft_deg": 8},
    {"classes": None, "layers": {str(ROAD): "gravel", str(SOIL): "soil", str(STUBBLE): "dry_grass",
                                         str(SHORE): "sand", str(WATER): "water", str(MEADOW): "grass"}},
]

LAKE = (1395, 1110, 190, 100, -0.55)  # centre, half axes, turn
TERRACES = (800, 1010, 120, 70, -0.6)
STEP_M = 2.2
ROAD_THROUGH = ((2044, 1010), (1560, 900), (1130, 1020), (640, 1056), (342, 800), (4, 830))


def read(path, raw):
    subprocess.run(["gdal_translate", "-q", "-of", "ENVI", "-ot", "Float32", "-unscale", path, raw], check=True)
    heights = array.array("f")
    with open(raw, "rb") as file:
        heights.fromfile(file, WIDE * HIGH)
    return heights


def smooth(t):
    t = min(1.0, max(0.0, t))
    return t * t * (3 - 2 * t)


def ellipse(place):
    """Samples around an ellipse with a wavy rim: their indices and how far out they are, 1 on the rim."""
    cx, cy, a, b, turn = place
    reach = int(1.6 * max(a, b))
    c, s = math.cos(turn), math.sin(turn)
    for y in range(max(0, cy - reach), min(HIGH, cy + reach + 1)):
        for x in range(max(0, cx - reach), min(WIDE, cx + reach + 1)):
            u, v = ((x - cx) * c + (y - cy) * s) / a, ((y - cy) * c - (x - cx) * s) / b
            if u * u + v * v < 2.6:
                angle = math.atan2(v, u)
                wave = 1 + 0.13 * math.sin(2 * angle + 1) + 0.09 * math.sin(3 * angle + 4) + 0.05 * math.sin(7 * angle) + 0.02 * math.sin(17 * angle)
                yield y * WIDE + x, math.hypot(u, v) / wave


def lake(heights, kinds):
    """A bed below the lowest point of the shore, level water over it, and a shore that rises to the ground around."""
    places = list(ellipse(LAKE))
    level = min(heights[i] for i, out in places if 0.95 < out < 1.05)
    for i, out in places:
        if out < 1:
            heights[i] = level
            kinds[i] = WATER
        elif out < 1.25:
            if heights[i] > level:
                heights[i] = level + (heights[i] - level) * smooth((out - 1) / 0.25)
            if out < 1.03:
                kinds[i] = SHORE


def terraces(heights, kinds):
    """Level steps with walls between them, each sown with something else."""
    for i, out in ellipse(TERRACES):
        if out < 1:
            step = 10 * STEP_M
            t = heights[i] / step
            field = math.floor(t)
            t = field + smooth((t - field - 0.72) / 0.28)
            weight = smooth((1 - out) / 0.12)
            heights[i] += weight * (t * step - heights[i])
            if out < 0.95 and t - field < 0.2:
                kinds[i] = (SOIL, MEADOW, STUBBLE)[field % 3]


def route(heights, kinds):
    """The easiest way for wheels through the places of ROAD_THROUGH, as points 8 m apart."""
    grid = 8
    columns, rows = WIDE // grid, HIGH // grid
    height = [[heights[(r * grid + 4) * WIDE + c * grid + 4] / 10 for c in range(columns)] for r in range(rows)]
    wet = [[any(kinds[(r * grid + y) * WIDE + c * grid + x] == WATER for y in (-8, 4, 16) for x in (-8, 4, 16)
                if 0 <= r * grid + y < HIGH and 0 <= c * grid + x < WIDE) for c in range(columns)] for r in range(rows)]
    moves = [(c, r, math.hypot(c, r)) for c in range(-2, 3) for r in range(-2, 3) if math.gcd(c, r) == 1]
    points = []
    for (ax, ay), (bx, by) in zip(ROAD_THROUGH, ROAD_THROUGH[1:]):
        start, end = (ax // grid, ay // grid), (bx // grid, by // grid)
        cost, before, queue = {start: 0}, {}, [(0, start)]
        while queue:
            spent, at = heapq.heappop(queue)
            if at == end:
                break
            if spent > cost[at]:
                continue
            for c, r, cells in moves:
                to = (at[0] + c, at[1] + r)
                if not (0 <= to[0] < columns and 0 <= to[1] < rows) or wet[to[1]][to[0]]:
                    continue
                slope = abs(height[to[1]][to[0]] - height[at[1]][at[0]]) / (cells * grid)
                total = spent + cells * (1 + (slope / 0.08) ** 2)
                if total < cost.get(to, 1e30):
                    cost[to], before[to] = total, at
                    heapq.heappush(queue, (total, to))
        way = [end]
        while way[-1] != start:
            way.append(before[way[-1]])
        points += [(c * grid + 4.0, r * grid + 4.0) for c, r in reversed(way)]
    return points


def evened(values, reach):
    """Running means of a list of numbers, twice."""
    for _ in range(2):
        sums = [0.0]
        for value in values:
            sums.append(sums[-1] + value)
        spans = [(max(0, i - reach), min(len(values), i + reach + 1)) for i in range(len(values))]
        values = [(sums[b] - sums[a]) / (b - a) for a, b in spans]
    return values


def road(heights, kinds):
    points = route(heights, kinds)
    xs, ys = [], []
    for (ax, ay), (bx, by) in zip(points, points[1:]):
        parts = max(1, round(math.hypot(bx - ax, by - ay)))
        xs += [ax + (bx - ax) * k / parts for k in range(parts)]
        ys += [ay + (by - ay) * k / parts for k in range(parts)]
    xs, ys = evened(xs, 12), evened(ys, 12)
    level = evened([heights[round(y) * WIDE + round(x)] for x, y in zip(xs, ys)], 15)
    nearest = {}
    for x, y, z in zip(xs, ys, level):
        for r in range(max(0, round(y) - 9), min(HIGH, round(y) + 10)):
            for c in range(max(0, round(x) - 9), min(WIDE, round(x) + 10)):
                far = (c - x) ** 2 + (r - y) ** 2
                i = r * WIDE + c
                if far < nearest.get(i, (81.0,))[0]:
                    nearest[i] = (far, z)
    for i, (far, z) in nearest.items():
        out = math.sqrt(far)
        if kinds[i] == WATER:
            continue
        heights[i] += (z - heights[i]) * smooth((9 - out) / 6.5)
        if out < 1.9:
            kinds[i] = ROAD


def write_png(path, values):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    rows = b"".join(b"\0" + bytes(values[y * WIDE:(y + 1) * WIDE]) for y in range(HIGH))
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", WIDE, HIGH, 8, 0, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def main():
    if len(sys.argv) != 4 or sys.argv[2] != "-o":
        sys.exit(__doc__)
    out = sys.argv[3]
    heights, kinds = read(sys.argv[1], out + ".r32"), bytearray(WIDE * HIGH)
    lake(heights, kinds)
    terraces(heights, kinds)
    road(heights, kinds)
    with open(out + ".r32", "wb") as file:
        heights.tofile(file)
    write_png(out + ".png", kinds)
    RULES[-1]["classes"] = os.path.basename(out) + ".png"
    with open(out + ".json", "w", encoding="utf-8") as file:
        json.dump({"rules": RULES}, file, indent=1)


main()
