#!/usr/bin/env python3
"""Decodes a pyramid of quantized-mesh tiles by the format's specification and compares it with a height field that was
read by another program. Standard library only; nothing of Fjell.

check.py FOLDER POINTS

POINTS: lines of "longitude latitude height", the height field's samples in degrees and metres. For every tile: the
format's own rules, that the bounding sphere holds every vertex, that a tile's metadata tells an error which no sample
under it exceeds - read linearly in degrees, and for a share of the samples along the ellipsoid's normal against the
flat triangles - that this error is below what CesiumJS assumes for the level, and that tiles of one level have the same
vertices where they meet. Prints one line of JSON; exit code 1 with the first fault on stderr.
"""
import gzip
import json
import math
import os
import struct
import sys
from bisect import bisect_left, bisect_right

A, B = 6378137.0, 6356752.314245179
E2 = 1 - (B / A) ** 2


def fail(text):
    sys.stderr.write(text + "\n")
    sys.exit(1)


def normal_of(lon, lat):
    lon, lat = math.radians(lon), math.radians(lat)
    return math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat)


def ecef(lon, lat, h):
    x, y, z = normal_of(lon, lat)
    n = A / math.sqrt(1 - E2 * z * z)
    return (n + h) * x, (n + h) * y, (n * (1 - E2) + h) * z


def box_of(tiling, z, x, y):
    down = 1 << z
    across = down * (2 if tiling == "EPSG:4326" else 1)

    def lat(row):
        if tiling == "EPSG:4326":
            return 180 * row / down - 90
        return math.degrees(2 * math.atan(math.exp(math.pi * (2 * row / down - 1))) - math.pi / 2)

    return 360 * x / across - 180, lat(y), 360 * (x + 1) / across - 180, lat(y + 1)


class Reader:
    def __init__(self, raw, name):
        self.raw, self.at, self.name = raw, 0, name

    def take(self, form):
        size = struct.calcsize("<" + form)
        if self.at + size > len(self.raw):
            fail(f"{self.name}: ends too early")
        values = struct.unpack_from("<" + form, self.raw, self.at)
        self.at += size
        return values


class Tile:
    def __init__(self, path, tiling, z, x, y):
        raw = open(path, "rb").read()
        if raw[:2] == b"\x1f\x8b":
            raw = gzip.decompress(raw)
        self.name, self.key, self.box = path, (z, x, y), box_of(tiling, z, x, y)
        r = Reader(raw, path)
        self.centre = r.take("3d")
        self.low, self.high = r.take("2f")
        self.sphere, (self.radius,), self.horizon = r.take("3d"), r.take("d"), r.take("3d")
        (n,) = r.take("I")
        self.u, self.v, self.h = (self.deltas(r.take(f"{n}H")) for _ in range(3))
        wide = n > 65536
        if wide:
            r.at += -r.at % 4
        word = "I" if wide else "H"
        (m,) = r.take("I")
        codes, highest, index = r.take(f"{3 * m}{word}"), 0, []
        for code in codes:
            index.append(highest - code)
            highest += code == 0
        if highest != n or min(index) < 0 or max(index) >= n:
            fail(f"{path}: indices do not name every vertex once")
        self.triangles = list(zip(index[0::3], index[1::3], index[2::3]))
        self.sides = []
        for _ in range(4):  # west, south, east, north
            (count,) = r.take("I")
            self.sides.append(r.take(f"{count}{word}"))
        self.extensions = {}
        while r.at < len(raw):
            kind, length = r.take("BI")
            self.extensions[kind] = raw[r.at:r.at + length]
            r.at += length
        if r.at != len(raw):
            fail(f"{path}: {r.at - len(raw)} bytes are missing at its end")
        text = self.extensions[4]
        (length,) = struct.unpack_from("<I", text)
        self.metadata = json.loads(text[4:4 + length])
        self.error = self.metadata["geometricerror"]
        if min(self.u + self.v + self.h) < 0 or max(self.u + self.v + self.h) > 32767:
            fail(f"{path}: a vertex lies outside of 15 bits")
        west, south, east, north = self.box
        self.lon = [west + (east - west) * q / 32767 for q in self.u]
        self.lat = [south + (north - south) * q / 32767 for q in self.v]
        self.height = [self.low + (self.high - self.low) * q / 32767 for q in self.h]
        self.places = [ecef(*p) for p in zip(self.lon, self.lat, self.height)]

    @staticmethod
    def deltas(codes):
        value, values = 0, []
        for code in codes:
            value += (code >> 1) ^ -(code & 1)
            values.append(value)
        return values

    def check_shape(self):
        """Sides, the sphere; that triangles cover the square."""
        for side, (axis, at) in enumerate(((self.u, 0), (self.v, 0), (self.u, 32767), (self.v, 32767))):
            if sorted(self.sides[side]) != [i for i, q in enumerate(axis) if q == at]:
                fail(f"{self.name}: side {side} does not list its vertices")
        for p in self.places:
            if math.dist(p, self.sphere) > self.radius * (1 + 1e-9):
                fail(f"{self.name}: a vertex lies outside of the bounding sphere")
        self.check_cover()
        if 1 in self.extensions and len(self.extensions[1]) != 2 * len(self.u):
            fail(f"{self.name}: as many normals as vertices are missing")

    def check_cover(self):
        """That triangles cover the square once, without a gap."""
        edges, area = {}, 0
        for t in self.triangles:
            a, b, c = ((self.u[i], self.v[i]) for i in t)
            doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            if doubled <= 0:
                fail(f"{self.name}: a triangle is not counter-clockwise")
            area += doubled
            for i in range(3):
                edge = t[i], t[(i + 1) % 3]
                if edge in edges:
                    fail(f"{self.name}: two triangles share a side in the same direction")
                edges[edge] = True
        if area != 2 * 32767 ** 2:
            fail(f"{self.name}: triangles do not cover the tile once: {area}")
        for a, b in edges:
            on_rim = any((axis[a] == at and axis[b] == at)
                         for axis, at in ((self.u, 0), (self.v, 0), (self.u, 32767), (self.v, 32767)))
            if (b, a) not in edges and not on_rim:
                fail(f"{self.name}: a side inside of the tile has one triangle: a crack")

    def check_horizon(self):
        """Where the point is hidden behind the ellipsoid, so is every vertex: tried from places around."""
        if self.box[2] - self.box[0] > 180:  # no point does that for a whole globe
            if not any(map(math.isnan, self.horizon)):
                fail(f"{self.name}: its horizon point may be hidden")
            return
        scaled = [(p[0] / A, p[1] / A, p[2] / B) for p in self.places[:: max(1, len(self.places) // 20)]]

        def hidden(eye, p):
            along = [q - e for q, e in zip(p, eye)]
            to_middle = -sum(a * e for a, e in zip(along, eye))
            beyond = sum(e * e for e in eye) - 1
            return to_middle > beyond and to_middle ** 2 > beyond * sum(a * a for a in along)

        for i in range(60):
            z, turn = 1 - (i + 0.5) / 30, i * 2.399963
            flat = math.sqrt(1 - z * z)
            for far in (1.001, 1.1, 3):
                eye = far * flat * math.cos(turn), far * flat * math.sin(turn), far * z
                if hidden(eye, self.horizon) and not all(hidden(eye, [0.9999999 * q for q in p]) for p in scaled):
                    fail(f"{self.name}: its horizon point is hidden where a vertex is seen")

    def side(self, which):
        axis = self.lat if which in (0, 2) else self.lon
        return sorted((axis[i], self.height[i]) for i in self.sides[which])

    def errors(self, samples, flat_every):
        """The largest error of samples (lon, lat, h): linear in degrees, and flat in space."""
        west, south, east, north = self.box
        spots = [(min(max((lon - west) / (east - west) * 32767, 0), 32767),
                  min(max((lat - south) / (north - south) * 32767, 0), 32767)) for lon, lat, h in samples]
        if not spots:
            return 0, 0
        # Triangles by cells of the samples' own rectangle: of a coarse tile that is a small part. Each is in the cells
        # around as well, as in space it lies a little beside its place in degrees.
        cells = max(1, int(math.sqrt(len(self.triangles))))
        low = [min(spot[axis] for spot in spots) for axis in (0, 1)]
        size = [max(1, max(spot[axis] for spot in spots) - low[axis]) / cells for axis in (0, 1)]

        def around(values, axis):
            first, last = ((at - low[axis]) / size[axis] for at in (min(values), max(values)))
            return range(max(0, math.floor(first) - 1), min(cells, math.floor(last) + 1) + 1)

        buckets = {}
        for t in self.triangles:
            rows = around([self.v[i] for i in t], 1)
            for i in around([self.u[i] for i in t], 0):
                for j in rows:
                    buckets.setdefault((i, j), []).append(t)
        worst = flat_worst = 0
        for number, ((lon, lat, h), (u, v)) in enumerate(zip(samples, spots)):
            near = buckets[int((u - low[0]) / size[0]), int((v - low[1]) / size[1])]
            best = None
            for t in near:
                (ax, ay), (bx, by), (cx, cy) = ((self.u[i], self.v[i]) for i in t)
                area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
                p = ((bx - u) * (cy - v) - (by - v) * (cx - u)) / area
                q = ((cx - u) * (ay - v) - (cy - v) * (ax - u)) / area
                inside = min(p, q, 1 - p - q)
                if best is None or inside > best[0]:
                    best = inside, p, q, t
                if inside > 1e-6:  # they cover the tile once
                    break
            inside, p, q, (a, b, c) = best
            if inside < -1e-9:
                fail(f"{self.name}: no triangle over {lon} {lat}")
            height = p * self.height[a] + q * self.height[b] + (1 - p - q) * self.height[c]
            worst = max(worst, abs(height - h))
            if number % flat_every == 0:
                flat_worst = max(flat_worst, abs(self.flat_height(lon, lat, near) - h))
        return worst, flat_worst

    def flat_height(self, lon, lat, near):
        """Along the ellipsoid's normal, where it meets a triangle in space."""
        n, foot = normal_of(lon, lat), ecef(lon, lat, 0)
        best = None
        for t in near:
            a, b, c = (self.places[i] for i in t)
            e1, e2, s = ([q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)],
                         [q - p for p, q in zip(a, foot)])
            h = (n[1] * e2[2] - n[2] * e2[1], n[2] * e2[0] - n[0] * e2[2], n[0] * e2[1] - n[1] * e2[0])
            d = sum(x * y for x, y in zip(e1, h))
            if abs(d) < 1e-9:
                continue
            p = sum(x * y for x, y in zip(s, h)) / d
            g = (s[1] * e1[2] - s[2] * e1[1], s[2] * e1[0] - s[0] * e1[2], s[0] * e1[1] - s[1] * e1[0])
            q = sum(x * y for x, y in zip(n, g)) / d
            inside = min(p, q, 1 - p - q)
            height = sum(x * y for x, y in zip(e2, g)) / d
            if best is None or inside > best[0]:
                best = inside, height
        return best[1]


def main():
    folder, points = sys.argv[1:3]
    layer = json.load(open(os.path.join(folder, "layer.json")))
    tiling = layer["projection"]
    samples = sorted((float(x), float(y), float(h)) for x, y, h in (line.split() for line in open(points)))
    longitudes = [s[0] for s in samples]
    assumed = 2 * math.pi * A * 0.25 / 65 / (2 if tiling == "EPSG:4326" else 1)
    total = {"tiles": 0, "triangles": 0, "samples": 0, "borders": 0, "border_vertices": 0, "normals": 0}
    shares = []
    for z, runs in enumerate(layer["available"]):
        tiles = {}
        for run in runs:
            for x in range(run["startX"], run["endX"] + 1):
                for y in range(run["startY"], run["endY"] + 1):
                    tiles[x, y] = Tile(os.path.join(folder, f"{z}/{x}/{y}.terrain"), tiling, z, x, y)
        found = sum(len(files) for _, _, files in os.walk(os.path.join(folder, str(z))))
        if found != len(tiles):
            fail(f"level {z}: {found} files, {len(tiles)} tiles are available")
        seen = 0
        for (x, y), tile in tiles.items():
            tile.check_shape()
            if total["tiles"] % 5 == 0:
                tile.check_horizon()
            west, south, east, north = tile.box
            under = [s for s in samples[bisect_left(longitudes, west):bisect_right(longitudes, east)]
                     if south <= s[1] <= north]
            seen += len(under)
            worst, flat = tile.errors(under, 7)
            if max(worst, flat) > tile.error:
                fail(f"{tile.name}: says {tile.error} m, and a sample is {worst} m (in space {flat} m) from it")
            if tile.error > assumed / 2 ** z:
                fail(f"{tile.name}: its error of {tile.error} m is above the {assumed / 2 ** z} m of its level")
            if under and z:
                shares.append(max(worst, flat) / tile.error)
            total["tiles"] += 1
            total["triangles"] += len(tile.triangles)
            total["normals"] += 1 in tile.extensions
            across = (2 if tiling == "EPSG:4326" else 1) << z
            for side, other in ((2, ((x + 1) % across, y)), (3, (x, y + 1))):
                if other not in tiles:
                    continue
                mine, theirs = tile.side(side), tiles[other].side(side - 2)
                if len(mine) != len(theirs) or any(
                        abs(p[0] - q[0]) > 1e-9 or abs(p[1] - q[1]) > 1e-6 for p, q in zip(mine, theirs)):
                    fail(f"{tile.name} and {tiles[other].name}: do not meet")
                total["borders"] += 1
                total["border_vertices"] += len(mine)
        if seen < len(samples):
            fail(f"level {z}: {len(samples) - seen} samples lie in no tile")
        total["samples"] += seen
    total["levels"] = len(layer["available"])
    total["tightness"] = sum(shares) / max(1, len(shares))  # measured against said, on the mean
    print(json.dumps(total))


if __name__ == "__main__":
    main()
