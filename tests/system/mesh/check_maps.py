#!/usr/bin/env python3
"""Reads the textures of a .glb of `mesh` and compares them with an ASCII grid. GDAL's gdal_translate reads the pictures.

check_maps.py FILE.glb GRID.asc

For every sample of the grid under a triangle: its normal by the normal texture, in the frame that a viewer interpolates,
beside that of the grid's heights. Prints one line of JSON: samples, angle_deg (the largest between the two),
flat_deg (the largest of the interpolated normal alone: what the texture has to make good), occlusion (its least and
largest byte, or null).
"""
import json
import math
import os
import re
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from glb import Glb


def pixels_of(image):
    open("map.png", "wb").write(image)
    subprocess.run(["gdal_translate", "-q", "-of", "PNM", "map.png", "map.ppm"], check=True)
    data = open("map.ppm", "rb").read()
    head = re.match(rb"P6\s+(\d+)\s+(\d+)\s+255\s", data)
    return int(head[1]), int(head[2]), data[head.end():]


def main(path, grid):
    lines = open(grid).read().split("\n")
    head = {k.lower(): float(v) for k, v in (line.split() for line in lines[:6])}
    columns, rows, cell = int(head["ncols"]), int(head["nrows"]), head["cellsize"]
    heights = [[None if float(v) == head["nodata_value"] else float(v) for v in line.split()] for line in lines[6:6 + rows]]
    glb = Glb(open(path, "rb").read())
    out = {"samples": 0, "angle_deg": 0, "flat_deg": 0, "occlusion": None}
    if "occlusion" in glb.images:
        pixels = pixels_of(glb.images["occlusion"])[2]
        out["occlusion"] = [min(pixels), max(pixels)]
    width, height, pixels = pixels_of(glb.images["normal"])

    def slope(x, y, dx, dy):
        get = lambda i, j: heights[j][i] if 0 <= i < columns and 0 <= j < rows else None
        before, here, after = get(x - dx, y - dy), get(x, y), get(x + dx, y + dy)
        if before is None and after is None:
            return 0
        if before is None or after is None:
            return (after - here if before is None else here - before) / cell
        return (after - before) / (2 * cell)

    cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    unit = lambda v: [q / math.hypot(*v) for q in v]
    angle = lambda a, b: math.degrees(math.acos(max(-1, min(1, sum(p * q for p, q in zip(a, b))))))
    for t in glb.triangles:
        at = [(glb.places[i][0] / cell, glb.places[i][2] / cell) for i in t]
        (ax, ay), (bx, by), (cx, cy) = at
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        for y in range(math.ceil(min(p[1] for p in at) - 1e-4), math.floor(max(p[1] for p in at) + 1e-4) + 1):
            for x in range(math.ceil(min(p[0] for p in at) - 1e-4), math.floor(max(p[0] for p in at) + 1e-4) + 1):
                q = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area
                r = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area
                if min(q, r, 1 - q - r) < -1e-4 or heights[y][x] is None:
                    continue
                mix = lambda values: [sum(w * v[k] for w, v in zip((1 - q - r, q, r), values)) for k in range(len(values[0]))]
                u, v = mix([glb.uv[i] for i in t])
                i, j = min(int(u * width), width - 1), min(int(v * height), height - 1)
                local = [p / 127.5 - 1 for p in pixels[3 * (j * width + i):3 * (j * width + i) + 3]]
                n, tangent = unit(mix([glb.normals[k] for k in t])), unit(mix([glb.tangents[k][:3] for k in t]))
                b = unit(mix([cross(glb.normals[k], glb.tangents[k]) for k in t]))  # as three.js has it, and others
                found = unit([local[0] * tangent[k] + local[1] * b[k] + local[2] * n[k] for k in range(3)])
                wanted = unit([-slope(x, y, 1, 0), 1, -slope(x, y, 0, 1)])
                out["samples"] += 1
                out["angle_deg"] = max(out["angle_deg"], angle(found, wanted))
                out["flat_deg"] = max(out["flat_deg"], angle(n, wanted))
    print(json.dumps(out))


main(*sys.argv[1:])
