#!/usr/bin/env python3
"""Decodes a tileset of 3D Tiles 1.1 by the specification and compares it with a height field that was read by another
program. Standard library only; nothing of Fjell but the measuring of check.py.

check3d.py FOLDER POINTS [PLAIN]

POINTS: as of check.py. PLAIN: the same tiles in floats, where those of FOLDER are rounded (KHR_mesh_quantization). An
implicit tree is spelled out first (implicit.py). For every tile: the rules of glTF and of tilesets, that its region holds every vertex of it and of its children and is no
larger than they need, that no sample under it is farther away than its geometricError - read linearly in degrees, and in
space - and that tiles of one level have the same vertices where they meet, with walls below.
Prints one line of JSON; exit code 1 with the first fault on stderr.
"""
import json
import math
import os
import sys
from bisect import bisect_left, bisect_right

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from check import A, B, E2, Tile, fail
from glb import Glb
from implicit import spelled_out


def geodetic(x, y, z):
    """Degrees and metres; Bowring's start, then Newton's steps on the ellipsoid's normal."""
    flat = math.hypot(x, y)
    lat = math.atan2(z, flat * (1 - E2))
    for _ in range(8):
        s = math.sin(lat)
        n = A / math.sqrt(1 - E2 * s * s)
        lat = math.atan2(z + E2 * n * s, flat)
    s, c = math.sin(lat), math.cos(lat)
    n = A / math.sqrt(1 - E2 * s * s)
    height = flat * c + z * s - A * math.sqrt(1 - E2 * s * s)
    return math.degrees(math.atan2(y, x)), math.degrees(lat), height


def read_glb(path):
    try:
        glb = Glb(open(path, "rb").read())
    except ValueError as error:
        fail(f"{path}: {error}")
    if glb.scale and len(set(glb.scale)) > 1:
        fail(f"{path}: steps that differ by axis")
    # How far a vertex may be from where it should be.
    rounding = math.sqrt(3) / 2 * glb.scale[0] if glb.scale else 0
    return glb.places, glb.triangles, glb.normals, rounding


class Tile3d(Tile):
    """The ground of a tile, as check.py's Tile has it; its walls apart."""

    def __init__(self, folder, node, middle, plain):
        self.name = node["content"]["uri"]
        self.key = node.get("key") or tuple(map(int, self.name.removesuffix(".glb").split("/")))
        west, south, east, north, self.low, self.high = node["boundingVolume"]["region"]
        self.box = tuple(map(math.degrees, (west, south, east, north)))
        self.error = node["geometricError"]
        places, triangles, normals, self.rounding = read_glb(os.path.join(plain or folder, self.name))
        # glTF's y is up: 3D Tiles turns it to z, and the transform moves it.
        self.places = [(x + middle[0], -z + middle[1], y + middle[2]) for x, y, z in places]
        west, south, east, north = self.box
        self.lon, self.lat, self.height = [], [], []
        for p in self.places:
            lon, lat, height = geodetic(*p)
            if abs(lat) > 89.9999:
                lon = west  # any: a pole has all
            while lon < west - 1e-5 * (east - west):
                lon += 360
            while lon > east + 1e-5 * (east - west):
                lon -= 360
            self.lon.append(lon), self.lat.append(lat), self.height.append(height)
        self.u = [round((q - west) / (east - west) * 32767) for q in self.lon]
        self.v = [round((q - south) / (north - south) * 32767) for q in self.lat]
        if min(self.u + self.v) < 0 or max(self.u + self.v) > 32767:
            fail(f"{self.name}: a vertex lies outside of its region")
        size_m = max(math.dist(self.places[0], p) for p in self.places)
        for lon, lat, u, v in zip(self.lon, self.lat, self.u, self.v):
            off_m = math.hypot(
                ((lon - west) - (east - west) * u / 32767) * math.cos(math.radians(lat)) * (abs(lat) < 89.9999),
                (lat - south) - (north - south) * v / 32767) * 111.4e3
            if off_m > 1.5e-7 * size_m:  # floats
                fail(f"{self.name}: a vertex is {off_m} m off the grid")
        # All of a pole's vertices are one place: which longitude one has cannot be told from it.
        self.pole = {i for i, lat in enumerate(self.lat) if abs(lat) > 89.9999}
        tops, feet = {}, {}
        for i, key in enumerate(zip(self.u, self.v)):
            if i not in self.pole:
                (feet if key in tops else tops)[key] = i
        depth = min((self.height[tops[k]] - self.height[i] for k, i in feet.items()), default=0)
        highest = max((self.height[i] for i in self.pole), default=0)
        for i in self.pole:
            (feet if highest - self.height[i] > depth / 2 else tops)["pole", i] = i
        tops.setdefault(("pole", None), max(self.pole, key=lambda i: self.height[i], default=None))
        for kind, i in list(feet.items()):
            if kind[0] == "pole":
                feet.pop(kind), feet.setdefault(("pole", None), i)
        ground = set(tops.values()) - {None}
        self.triangles = [t for t in triangles if all(i in ground for i in t)]
        self.walls = [t for t in triangles if not all(i in ground for i in t)]
        rim = lambda i: self.u[i] in (0, 32767) or self.v[i] in (0, 32767)
        self.sides = [[i for i in ground if axis[i] == at]
                      for axis, at in ((self.u, 0), (self.v, 0), (self.u, 32767), (self.v, 32767))]
        self.extensions = {}
        self.depth = 0
        if feet:
            depths = [self.height[tops[k]] - self.height[i] for k, i in feet.items()]
            self.depth = min(depths)
            if max(depths) - min(depths) > 0.02 * max(depths) + 0.01:
                fail(f"{self.name}: walls of several depths")
        walls = 2 * sum(len(side) - 1 for side in self.sides)
        if not self.pole and len(self.walls) != walls or not all(map(rim, feet.values())):
            fail(f"{self.name}: {len(self.walls)} triangles of walls")
        if normals is not None:
            for n, p in zip(normals, self.places):
                up = (p[0] / A ** 2, p[1] / A ** 2, p[2] / B ** 2)
                if n[0] * up[0] - n[2] * up[1] + n[1] * up[2] <= 0:
                    fail(f"{self.name}: a normal that does not point up")
        self.normals = normals is not None
        if plain:
            self.round(folder, triangles, middle, 1.5e-7 * size_m)

    def round(self, folder, triangles, middle, slack_m):
        """The same triangles, and each vertex as near as what it was rounded to."""
        places, packed, _, self.rounding = read_glb(os.path.join(folder, self.name))

        def turned(t):  # an encoder may begin a triangle with any corner
            return min(t, t[1:] + t[:1], t[2:] + t[:2])

        if list(map(turned, packed)) != list(map(turned, triangles)):
            fail(f"{self.name}: rounded it has other triangles")
        if not self.rounding:
            fail(f"{self.name}: is not rounded")
        before, self.places = self.places, [(x + middle[0], -z + middle[1], y + middle[2]) for x, y, z in places]
        if max(map(math.dist, before, self.places)) > self.rounding + slack_m:
            fail(f"{self.name}: a vertex is farther from its place than half a step")
        self.height = [geodetic(*p)[2] for p in self.places]


def main():
    folder, points = sys.argv[1:3]
    plain = sys.argv[3] if len(sys.argv) > 3 else None
    tileset = json.load(open(os.path.join(folder, "tileset.json")))
    if tileset["asset"]["version"] != "1.1":
        fail("not 3D Tiles 1.1")
    samples = sorted((float(x), float(y), float(h)) for x, y, h in (line.split() for line in open(points)))
    longitudes = [s[0] for s in samples]
    total = {"tiles": 0, "triangles": 0, "samples": 0, "borders": 0, "border_vertices": 0, "normals": 0}
    levels, shares, subtrees = {}, [], []
    root = tileset["root"]
    try:
        root["children"] = [spelled_out(folder, child, tileset["schema"], subtrees) if "implicitTiling" in child else child
                            for child in root["children"]]
    except (KeyError, ValueError) as error:
        fail(f"implicit tree: {error!r}")

    def walk(node, parent, middle):
        region = node["boundingVolume"]["region"]
        if parent and node["geometricError"] > parent["geometricError"]:
            fail("a child's error is above its parent's")
        move = node.get("transform")
        if move:
            if move[:12] != [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0] or move[15] != 1:
                fail("a transform that does more than move")
            middle = [m + d for m, d in zip(middle, move[12:15])]
        low, high, sag, rounding = math.inf, -math.inf, 0, 0
        if "content" in node:
            tile = Tile3d(folder, node, middle, plain)
            levels.setdefault(tile.key[0], {})[tile.key[1:]] = tile
            low, high, rounding = min(tile.height), max(tile.height), tile.rounding
            sag = max(math.dist(tile.places[t[i - 1]], tile.places[t[i]])
                      for t in tile.triangles + tile.walls for i in range(3)) ** 2 / (8 * B * B / A)
        for child in node.get("children", ()):
            inner = walk(child, node, middle)
            low, high, sag, rounding = min(low, inner[0]), max(high, inner[1]), max(sag, inner[2]), max(rounding, inner[3])
            if any(child["boundingVolume"]["region"][k] * s < region[k] * s - 1e-12
                   for k, s in ((0, 1), (1, 1), (2, -1), (3, -1), (4, 1), (5, -1))):
                fail("a region does not hold its child's")
        slack = 1e-6 * max(1, sag) + 1e-7 * A * (region[2] - region[0] + region[3] - region[1]) + 1e-4 + 2 * rounding  # floats
        if region[4] > low + slack or region[5] < high - slack:
            fail(f"{node.get('content')}: {low} to {high} m are not in its region")
        if region[4] < low - 1.1 * sag - slack or region[5] > high + slack:
            fail(f"{node.get('content')}: its region is larger than {low} to {high} m")
        return low, high, sag, rounding

    walk(root, None, [0, 0, 0])
    files = sum(len(f) for _, _, f in os.walk(folder)) - 1 - len(subtrees)
    for z, tiles in sorted(levels.items()):
        seen = 0
        for (x, y), tile in tiles.items():
            if not tile.pole:
                tile.check_cover()
            west, south, east, north = tile.box
            under = [s for s in samples[bisect_left(longitudes, west):bisect_right(longitudes, east)]
                     if south <= s[1] <= north]
            seen += len(under)
            if tile.pole:
                flat = max((abs(tile.flat_height(lon, lat, tile.triangles) - h) for lon, lat, h in under[::7]), default=0)
                worst = flat
            else:
                worst, flat = tile.errors(under, 7)
            if max(worst, flat) > tile.error:
                fail(f"{tile.name}: says {tile.error} m, and a sample is {worst} m (in space {flat} m) from it")
            if under:
                shares.append(max(worst, flat) / tile.error)
            if tile.depth < 2 * tile.error:
                fail(f"{tile.name}: walls of {tile.depth} m do not reach a coarser neighbour")
            total["tiles"] += 1
            total["triangles"] += len(tile.triangles)
            total["normals"] += tile.normals
            across = round(360 / (east - west))
            for side, other in ((2, ((x + 1) % across, y)), (3, (x, y + 1))):
                if other not in tiles:
                    continue
                mine, theirs = ([tiles_.places[i] for i in sorted(
                    set(tiles_.sides[s]) - tiles_.pole, key=lambda i, t=tiles_: t.v[i] if side == 2 else t.u[i])]
                    for tiles_, s in ((tile, side), (tiles[other], side - 2)))
                close = 1e-6 * (1 if tile.rounding else math.radians(east - west + north - south) * A)
                if len(mine) != len(theirs) or any(math.dist(p, q) > close for p, q in zip(mine, theirs)):
                    fail(f"{tile.name} and {tiles[other].name}: do not meet")
                total["borders"] += 1
                total["border_vertices"] += len(mine)
        if seen < len(samples):
            fail(f"level {z}: {len(samples) - seen} samples lie in no tile")
        total["samples"] += seen
    if files != total["tiles"]:
        fail(f"{files} files, {total['tiles']} tiles in the tree")
    total["levels"] = len(levels)
    total["subtrees"] = len(subtrees)
    total["tightness"] = sum(shares) / max(1, len(shares))
    print(json.dumps(total))


if __name__ == "__main__":
    main()
