#!/usr/bin/env python3
"""Whether the ground of a .glb, or of the tiles of a tileset, has the colour that its height has: red from 0 to 255
between two heights, and grey beyond the field. GDAL's gdal_translate reads the pictures.

check_colours.py FILE.glb|FOLDER LOW HIGH

Prints one line of JSON: vertices that are coloured, and how many of these are as red as they should be.
"""
import json
import os
import re
import subprocess
import sys

from check3d import geodetic
from glb import Glb


def pixels_of(jpeg):
    open("picture.jpg", "wb").write(jpeg)
    subprocess.run(["gdal_translate", "-q", "-of", "PNM", "picture.jpg", "picture.ppm"], check=True)
    data = open("picture.ppm", "rb").read()
    head = re.match(rb"P6\s+(\d+)\s+(\d+)\s+255\s", data)
    return int(head[1]), int(head[2]), data[head.end():]


def main():
    path, low, high = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
    found = {"coloured": 0, "right": 0}

    def look(glb, height_of):
        width, height, pixels = pixels_of(glb.images["colour"])
        for place, (u, v) in zip(glb.places, glb.uv):
            at = 3 * (min(int(v * height), height - 1) * width + min(int(u * width), width - 1))
            red, green, blue = pixels[at:at + 3]
            wanted = 255 * (height_of(place) - low) / (high - low)
            if green > 90:  # beyond the field
                continue
            found["coloured"] += 1
            found["right"] += abs(red - wanted) < 40

    def walk(node, middle):
        middle = [m + d for m, d in zip(middle, node.get("transform", [0] * 16)[12:15])]
        for child in node.get("children", ()):
            walk(child, middle)
        if "children" not in node:  # the finest
            glb = Glb(open(os.path.join(path, node["content"]["uri"]), "rb").read())
            look(glb, lambda p: geodetic(p[0] + middle[0], -p[2] + middle[1], p[1] + middle[2])[2])

    if path.endswith(".glb"):
        look(Glb(open(path, "rb").read()), lambda p: p[1])
    else:
        walk(json.load(open(os.path.join(path, "tileset.json")))["root"], [0, 0, 0])
    print(json.dumps(found))


main()
