#!/usr/bin/env python3
"""Decodes a pyramid of Terrain-RGB or Terrarium pictures and measures a height field that was read by another program.
Standard library only; nothing of Fjell.

check_raster.py FOLDER_OR_FILE POINTS

POINTS: as of check.py. For every level: every sample lies in a tile, and no farther from what is between four pixels -
bilinear, or two triangles - than the metadata says, with the neighbours' pixels and without. Prints one line of JSON.
"""
import json
import math
import struct
import subprocess
import sys
import zlib

from archive import must, read


def pixels_of(image):
    """Rows of RGB. GDAL reads WebP, the standard library PNG."""
    if image[:4] == b"RIFF":
        must(image[8:16] == b"WEBPVP8L", "not WebP without loss")
        open("tile.webp", "wb").write(image)
        subprocess.run(["gdal_translate", "-q", "-of", "PNG", "tile.webp", "tile.png"], check=True)
        image = open("tile.png", "rb").read()
    return pixels_of_png(image)


def pixels_of_png(png):
    must(png[:8] == b"\x89PNG\r\n\x1a\n", "no PNG")
    at, packed = 8, b""
    while at < len(png):
        size, kind = struct.unpack_from(">I4s", png, at)
        body = png[at + 8:at + 8 + size]
        must(zlib.crc32(kind + body) == struct.unpack_from(">I", png, at + 8 + size)[0], "a damaged chunk")
        if kind == b"IHDR":
            width, height, *how = struct.unpack(">IIBBBBB", body)
            must(how == [8, 2, 0, 0, 0], "not 8-bit RGB")
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
    raw, stride = zlib.decompress(packed), 3 * width
    rows, above = [], bytearray(stride)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride) if kind else ():
            left, up, corner = (row[i - 3], above[i], above[i - 3]) if i >= 3 else (0, above[i], 0)
            if kind == 4:
                guess = left + up - corner
                near = min((abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner))[2]
            else:
                near = (0, left, up, (left + up) // 2)[kind]
            row[i] = row[i] + near & 255
        rows.append(row)
        above = row
    return width, rows


def error(grid, x, y, h):
    """Of a height from what is between four numbers of a table."""
    i, j = min(int(x), len(grid[0]) - 2), min(int(y), len(grid) - 2)
    s, t = x - i, y - j
    (a, b), (c, d) = grid[j][i:i + 2], grid[j + 1][i:i + 2]
    readings = ((1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * d),
                a + s * (b - a) + t * (d - b) if s > t else a + t * (c - a) + s * (d - c),
                a + s * (b - a) + t * (c - a) if s + t < 1 else d + (1 - s) * (c - d) + (1 - t) * (b - d))
    return max(abs(r - h) for r in readings)


def main():
    tiles, about = read(sys.argv[1])
    side = about["tileSize"]
    metres = (lambda r, g, b: (65536 * r + 256 * g + b) / 10 - 10000) if about["encoding"] == "mapbox" else (
        lambda r, g, b: 256 * r + g + b / 256 - 32768)
    samples = [tuple(map(float, line.split())) for line in open(sys.argv[2])]
    total = {"tiles": len(tiles), "samples": len(samples), "levels": len(about["fjell"]["levels"]), "tightness": []}
    for level in about["fjell"]["levels"]:
        z = level["level"]
        across = side << z
        grids = {}
        for (tz, x, south), png in tiles.items():
            if tz == z:
                width, rows = pixels_of(png)
                must(width == len(rows) == side, "a picture of another size")
                grids[x, (1 << z) - 1 - south] = [[metres(*row[k:k + 3]) for k in range(0, 3 * side, 3)] for row in rows]
        must(len(grids) == level["tiles"], f"level {z}: another number of tiles")
        rings = {}
        for (x, y), grid in grids.items():  # of neighbours, where there are any
            beside = lambda i, j: grids.get(((x + i // side) % (1 << z), y + j // side))
            rings[x, y] = [[(beside(i, j) or grid)[j % side if beside(i, j) else min(max(j, 0), side - 1)]
                            [i % side if beside(i, j) else min(max(i, 0), side - 1)] for i in range(-1, side + 1)]
                           for j in range(-1, side + 1)]
        worst = 0
        for lon, lat, h in samples:
            px = (lon + 180) / 360 * across
            py = (0.5 - math.asinh(math.tan(math.radians(lat))) / (2 * math.pi)) * across
            key = int(px // side) % (1 << z), int(py // side)
            must(key in grids, f"level {z}: a sample lies in no tile")
            u, v = px % side - 0.5, py % side - 0.5
            worst = max(worst, error(rings[key], u + 1, v + 1, h),
                        error(grids[key], min(max(u, 0), side - 1), min(max(v, 0), side - 1), h))
        must(worst <= level["error_m"], f"level {z}: says {level['error_m']} m, and a sample is {worst} m from it")
        total["tightness"].append(worst / level["error_m"])
    total["tightness"] = min(total["tightness"])
    print(json.dumps(total))


main()
