#!/usr/bin/env python3
"""Reads tiles out of a folder, MBTiles or PMTiles 3, by their specifications. Standard library only; nothing of Fjell.

archive.py A B: fails unless both hold the same tiles and say the same of them. Prints how many there are.
"""
import gzip
import json
import os
import sqlite3
import struct
import sys


def must(true, text):
    if not true:
        sys.exit(text)


def read_folder(path):
    (index,) = [n for n in os.listdir(path) if n.endswith(".json")]
    tiles = {}
    for root, _, names in os.walk(path):
        for name in names:
            if not name.endswith(".json"):
                z, x = map(int, os.path.relpath(root, path).split(os.sep))
                y, ending = name.split(".")
                south = (1 << z) - 1 - int(y) if ending in ("png", "webp") else int(y)
                tiles[z, x, south] = open(os.path.join(root, name), "rb").read()
    return tiles, json.load(open(os.path.join(path, index)))


def read_mbtiles(path):
    base = sqlite3.connect(path)
    must(base.execute("PRAGMA integrity_check").fetchone() == ("ok",), f"{path}: damaged")
    about = dict(base.execute("SELECT name, value FROM metadata"))
    rows = base.execute("SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles").fetchall()
    tiles = {row[:3]: row[3] for row in rows}
    must(len(tiles) == len(rows), f"{path}: a tile is there twice")
    must((int(about["minzoom"]), int(about["maxzoom"])) == (min(tiles)[0], max(tiles)[0]), f"{path}: its levels")
    return tiles, json.loads(about["json"])


def hilbert_xy(z, place):
    x = y = 0
    for k in range(z):
        s, rx, ry = 1 << k, place >> 1 & 1, (place ^ place >> 1) & 1
        if ry == 0:
            if rx:
                x, y = s - 1 - x, s - 1 - y
            x, y = y, x
        x, y, place = x + s * rx, y + s * ry, place >> 2
    return x, y


def read_pmtiles(path):
    data = open(path, "rb").read()
    must(data[:8] == b"PMTiles\3", f"{path}: is not PMTiles 3")
    (root, root_n, about, about_n, leaves, leaves_n, first, all_n, addressed, entries, contents) = struct.unpack_from(
        "<11Q", data, 8)
    clustered, inner, outer, kind, low, high = struct.unpack_from("<6B", data, 96)
    must(root == 127 and root + root_n <= 16384 and inner == 2 and clustered == 1, f"{path}: its header")
    must(len(data) == first + all_n and (about, leaves, first) == (root + root_n, about + about_n, leaves + leaves_n),
         f"{path}: its parts")
    tiles, seen, places = {}, [0], set()

    def walk(raw, depth):
        raw, at = gzip.decompress(raw), 0

        def number():
            nonlocal at
            value = shift = 0
            while True:
                byte = raw[at]
                at += 1
                value |= (byte & 127) << shift
                shift += 7
                if byte < 128:
                    return value

        n = number()
        ids, total = [], 0
        for _ in range(n):
            total += number()
            ids.append(total)
        must(all(a < b for a, b in zip(ids, ids[1:])), f"{path}: tiles out of order")
        runs = [number() for _ in range(n)]
        lengths = [number() for _ in range(n)]
        offsets = []
        for i in range(n):
            value = number()
            offsets.append(offsets[-1] + lengths[i - 1] if value == 0 else value - 1)
        must(at == len(raw), f"{path}: a directory with more behind it")
        for start, run, length, offset in zip(ids, runs, lengths, offsets):
            if run == 0:
                must(depth == 0, f"{path}: leaves of leaves")
                walk(data[leaves + offset:leaves + offset + length], 1)
                continue
            seen[0] += 1
            places.add(offset)
            must(offset + length <= all_n, f"{path}: a tile outside of the data")
            for tile in range(start, start + run):
                z = 0
                while ((1 << 2 * z + 2) - 1) // 3 <= tile:
                    z += 1
                x, y = hilbert_xy(z, tile - ((1 << 2 * z) - 1) // 3)
                tiles[z, x, (1 << z) - 1 - y] = data[first + offset:first + offset + length]

    walk(data[root:root + root_n], 0)
    must((addressed, entries, contents) == (len(tiles), seen[0], len(places)), f"{path}: its counts")
    must((low, high) == (min(tiles)[0], max(tiles)[0]), f"{path}: its levels")
    starts = {2: b"\x89PNG", 4: b"RIFF"}.get(kind) or (b"\x1f\x8b" if outer == 2 else b"")
    must(all(t.startswith(starts) for t in tiles.values()), f"{path}: tiles of another kind")
    return tiles, json.loads(gzip.decompress(data[about:about + about_n]))


def read(path):
    """Tiles by (level, x, y from the south), and the JSON beside them."""
    return (read_mbtiles if path.endswith(".mbtiles") else read_pmtiles if path.endswith(".pmtiles") else read_folder)(path)


if __name__ == "__main__":
    (tiles, about), (others, says) = map(read, sys.argv[1:3])
    must(tiles == others, f"{sys.argv[1]} and {sys.argv[2]} differ: {len(tiles)} and {len(others)} tiles")
    must(about == says, f"{sys.argv[1]} and {sys.argv[2]} say something else")
    print(len(tiles))
