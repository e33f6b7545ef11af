#!/usr/bin/env python3
"""A pyramid of 100,000 tiles: what it takes, and whether it survives a kill. By hand, as it takes many minutes.

    python3 tests/bench/many_tiles.py BIN OUT [SAMPLES]

BIN: folder of fjell-bake. OUT: a new folder. SAMPLES: a side of the terrain; the default makes over 100,000
tiles. A folder, which is killed when half of its finest tiles are there and gone on with, an MBTiles and a
PMTiles file are written. tests/system/tiles/archive.py reads all three and compares them byte for byte; each tile of
the folder is then decoded by tests/system/tiles/check.py. Prints a table: seconds, those of all cores, and the most
memory resident. Needs GDAL's and NumPy's Python.
"""

import os
import signal
import subprocess
import sys
import time

import numpy as np
from osgeo import gdal, osr

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "system", "tiles"))
import archive  # noqa: E402
import check  # noqa: E402

LEVEL, SPACING_M = 16, 76  # the finest that this spacing may have


def make_terrain(path, side):
    """Hills at the equator, where the finest tiles have eight samples a side."""
    gdal.UseExceptions()
    y, x = np.mgrid[0:side, 0:side]
    heights = 400 + 150 * np.sin(x * 0.02) * np.cos(y * 0.017) + 40 * np.sin(x * 0.11 + y * 0.07)
    made = gdal.GetDriverByName("GTiff").Create(path, side, side, 1, gdal.GDT_Float32)
    crs = osr.SpatialReference()
    crs.ImportFromEPSG(32632)
    made.SetProjection(crs.ExportToWkt())
    made.SetGeoTransform([400_000, SPACING_M, 0, 10_000 + SPACING_M * side, 0, -SPACING_M])
    made.GetRasterBand(1).WriteArray(heights.astype("f4"))


def finest_of(folder):
    finest = os.path.join(folder, str(LEVEL))
    columns = os.listdir(finest) if os.path.isdir(finest) else ()
    return sum(len(os.listdir(os.path.join(finest, c))) for c in columns)


def run(what, command, rows, stop_at=None, folder=None):
    """Adds a row; with stop_at, kills it once the folder has so many of its finest tiles."""
    start, most_kb = time.monotonic(), 0
    child = subprocess.Popen(command)
    while child.poll() is None and not (stop_at and finest_of(folder) >= stop_at):
        with open(f"/proc/{child.pid}/status", encoding="ascii") as status:  # rusage would have this program's memory, too
            most_kb = max([most_kb, *(int(line.split()[1]) for line in status if line.startswith("VmHWM"))])
        time.sleep(0.2)
    if stop_at:
        child.kill()
    if child.wait() != (-signal.SIGKILL if stop_at else 0):
        sys.exit(f"{what}: exit code {child.returncode}")
    now = os.times()
    rows.append((what, time.monotonic() - start, now.children_user + now.children_system - sum(r[2] for r in rows), most_kb / 1000))
    print("| {} | {:.0f} | {:.0f} | {:.0f} |".format(*rows[-1]), flush=True)


def main():
    fjell_bake, out = os.path.join(sys.argv[1], "fjell-bake"), sys.argv[2]
    side = int(sys.argv[3]) if len(sys.argv) > 3 else 2270
    os.makedirs(out)
    dem, pack, folder = (os.path.join(out, name) for name in ("dem.tif", "pack.fjell", "tiles"))
    make_terrain(dem, side)
    rows = []
    print("| what | s | s of all cores | MB |\n|---|---|---|---|")
    run("bake", [fjell_bake, dem, "-o", pack, "--quiet"], rows)
    tiles = [fjell_bake, "tiles", pack, "--tiling", "mercator", "--max-level", str(LEVEL), "--no-normals", "--quiet", "-o"]
    half = (side * SPACING_M / (2 * np.pi * check.A / (1 << LEVEL))) ** 2 / 2
    run("a folder, killed half-way", [*tiles, folder], rows, half, folder)
    before = finest_of(folder)
    run("the folder, gone on with", [*tiles, folder], rows)
    names = [os.path.join(out, "tiles" + ending) for ending in (".mbtiles", ".pmtiles")]
    for name in names:
        run(name[name.rindex(".") :], [*tiles, name], rows)
    found, about = archive.read(folder)
    for name in names:
        archive.must(archive.read(name) == (found, about), f"{name}: is not what the folder has")
    triangles = 0
    for z, x, y in sorted(found):
        tile = check.Tile(os.path.join(folder, str(z), str(x), f"{y}.terrain"), "EPSG:3857", z, x, y)
        tile.check_shape()
        triangles += len(tile.triangles)
    archive.must(triangles == sum(level["triangles"] for level in about["fjell"]["levels"]), "triangles are missing")
    print(f"{len(found)} tiles, {before} of the finest before the kill, {triangles} triangles, alike in folder, MBTiles and PMTiles")


main()
