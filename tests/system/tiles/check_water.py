#!/usr/bin/env python3
"""Whether the water masks of quantized-mesh tiles have water where the ground is lower than a height.

check_water.py FOLDER POINTS HEIGHT

POINTS: as of check.py. Looks at the tiles of the finest level. Prints one line of JSON: samples that lie at least 30 m
above or below the height, how many of these are water by the mask, and how many are as they should be.
"""
import json
import os
import sys

from check import Tile, fail


def main():
    folder, points, sea = sys.argv[1], sys.argv[2], float(sys.argv[3])
    layer = json.load(open(os.path.join(folder, "layer.json")))
    if "watermask" not in layer["extensions"]:
        fail("layer.json names no water mask")
    samples = [tuple(map(float, line.split())) for line in open(points)]
    found = {"samples": 0, "water": 0, "right": 0, "uniform": 0}
    for z, runs in enumerate(layer["available"]):
        for x, y in ((x, y) for r in runs for x in range(r["startX"], r["endX"] + 1)
                     for y in range(r["startY"], r["endY"] + 1)):
            tile = Tile(os.path.join(folder, f"{z}/{x}/{y}.terrain"), layer["projection"], z, x, y)
            mask = tile.extensions[2]
            if len(mask) not in (1, 65536):
                fail(f"{tile.name}: a mask of {len(mask)} bytes")
            found["uniform"] += len(mask) == 1
            if z + 1 < len(layer["available"]):
                continue
            west, south, east, north = tile.box
            for lon, lat, height in samples:
                if not (west < lon < east and south < lat < north) or abs(height - sea) < 30:
                    continue
                column, row = int((lon - west) / (east - west) * 256), int((north - lat) / (north - south) * 256)
                water = mask[0 if len(mask) == 1 else 256 * row + column] > 127
                found["samples"] += 1
                found["water"] += water
                found["right"] += water == (height < sea)
    print(json.dumps(found))


main()
