"""Meshes of one array by Fjell, Martini, Delatin (npm's @mapbox/martini and delatin) and SciPy, within one true error.

    PYTHONPATH=build/release/python python3 tests/bench/array_meshes.py HEIGHTS... NODE_MODULES

HEIGHTS: .npy or what GDAL's Python reads; its largest square of 2^n + 1 samples. FILE@X,Y: 257 x 257 samples from there
on. FOLDER: the twelve tiles of docs/measured.md, of the real heights that lie in it and of content/terrain, which
build/release/bin/fjell-bake makes. Of one the errors are 5 and 20 m; of several 1% of each tile's relief, and the table
has a line for each. Each of the others is asked for smaller errors until its true one, as NumPy measures it, is no
larger than Fjell's. Times are the least of five calls, of that last one alone; Node's after it has compiled. Of several,
the vertices that cesium-terrain-builder would choose are counted as well (by_chunks). Prints a table, and JSON with
--json. --plot FILE: instead, the triangles of all tiles for several errors, as one of the plots of docs/plots.json,
which `fjell-lab --draw` draws.
"""

import json
import os
import subprocess
import sys
import tempfile
import time

import numpy as np

import fjell

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
sys.path.insert(0, os.path.join(ROOT, "tests", "python"))
from measured import measure  # noqa: E402

NODE = """
import fs from 'fs';
const [, , module, file, side, error, out, calls] = process.argv;
const n = Number(side);
const heights = new Float32Array(fs.readFileSync(file).buffer.slice(0, n * n * 4));
let best = Infinity, mesh;
const martini = module.includes('martini') ? new (await import(module)).default(n) : null;
const Delatin = martini ? null : (await import(module)).default;
for (let i = 0; i < Number(calls); ++i) {
  const start = performance.now();
  if (martini) mesh = martini.createTile(heights).getMesh(Number(error));
  else { mesh = new Delatin(heights, n, n); mesh.run(Number(error)); }
  const took = performance.now() - start;
  if (i > 0 || calls === "1") best = Math.min(best, took);
}
const vertices = Uint32Array.from(martini ? mesh.vertices : mesh.coords), triangles = Uint32Array.from(mesh.triangles);
fs.writeFileSync(out + '.v', Buffer.from(vertices.buffer));
fs.writeFileSync(out + '.t', Buffer.from(triangles.buffer));
console.log(best);
"""


calls = 6  # the first is not timed


def by_node(module, heights, error, folder):
    script, file, out = (os.path.join(folder, name) for name in ("mesh.mjs", "heights", "mesh"))
    with open(script, "w") as to:
        to.write(NODE)
    heights.astype("<f4").tofile(file)
    done = subprocess.run(["node", script, module, file, str(len(heights)), str(error), out, str(calls)], capture_output=True, text=True, check=True)
    places = np.fromfile(out + ".v", "<u4").reshape(-1, 2)
    triangles = np.fromfile(out + ".t", "<u4").reshape(-1, 3)
    vertices = np.stack([places[:, 0], heights[places[:, 1], places[:, 0]], places[:, 1]], axis=1).astype(np.float32)
    x, y = places[triangles, 0].astype(int), places[triangles, 1].astype(int)
    turned = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (y[:, 1] - y[:, 0]) * (x[:, 2] - x[:, 0]) > 0
    triangles[turned] = triangles[turned][:, ::-1]
    return vertices, triangles, float(done.stdout) / 1000


def by_fjell(heights, error):
    times = []
    for _ in range(calls):
        start = time.perf_counter()
        made = fjell.mesh(heights, 1, error, threads=1)
        times.append(time.perf_counter() - start)
    return made, min(times[1:] or times)


def by_scipy(heights, worst):
    """SciPy's Delaunay triangulation of every n-th sample, as many as it takes. Without SciPy: nothing."""
    try:
        from scipy.spatial import Delaunay
    except ImportError:
        print("SciPy is not installed: Debian's package is python3-scipy", file=sys.stderr)
        return None
    step = len(heights) - 1
    while True:
        at = np.arange(0, len(heights), step)
        x, y = np.meshgrid(at, at)
        places = np.stack([x.ravel(), y.ravel()], axis=1)
        start = time.perf_counter()
        triangles = Delaunay(places).simplices.astype(np.uint32)
        seconds = time.perf_counter() - start
        a, b, c = (places[triangles[:, i]] for i in range(3))
        turned = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0] > 0
        triangles[turned] = triangles[turned][:, ::-1]
        vertices = np.stack([places[:, 0], heights[places[:, 1], places[:, 0]], places[:, 1]], axis=1).astype(np.float32)
        true, _ = measure(heights, vertices, triangles)
        if true <= worst or step == 1:
            return {"method": "SciPy", "asked_m": worst, "true_m": true, "triangles": len(triangles), "ms": seconds * 1000}
        step //= 2


def by_chunks(heights, error):
    """Triangles by the rule of cesium-terrain-builder's meshes, after Ulrich's chunked levels of detail (2002): a vertex
    is active where the middle of its hypotenuse is off by `error` or more, and so is each that an active one needs."""
    last, heights = len(heights) - 1, heights.astype(float)
    active = np.zeros(heights.shape, bool)

    def activate(ys, xs, dy, dx_of):  # dy, dx: from the middle of the hypotenuse to an end, and turned, to an apex
        y, x = np.meshgrid(ys, xs, indexing="ij")
        dx = dx_of(y, x)
        active[y, x] |= np.abs(heights[y, x] - (heights[y - dy, x - dx] + heights[y + dy, x + dx]) / 2) >= error
        for to_y, to_x in ((y + dx, x - dy), (y - dx, x + dy)):
            there = active[y, x] & (to_y >= 0) & (to_y <= last) & (to_x >= 0) & (to_x <= last)
            active[to_y[there], to_x[there]] = True

    half = 1
    while half < last:  # from the finest generation up: sides of squares, then their centres
        even, odd = np.arange(0, last + 1, 2 * half), np.arange(half, last, 2 * half)
        activate(even, odd, 0, lambda y, x: half)
        activate(odd, even, half, lambda y, x: 0)
        activate(odd, odd, half, lambda y, x: np.where((y // (2 * half) + x // (2 * half)) % 2 == 0, half, -half))
        half *= 2
    active[::last, ::last] = False  # the corners, which split nothing
    inner = int(active[1:-1, 1:-1].sum())
    return 2 + inner + int(active.sum())


def rows(heights, modules, errors):
    folder = tempfile.mkdtemp()
    for error in errors:
        made, seconds = by_fjell(heights, error)
        worst, _ = measure(heights, made.vertices, made.triangles)
        yield {"method": "Fjell", "asked_m": error, "true_m": worst, "triangles": len(made.triangles), "ms": seconds * 1000}
        for method, module in (("Martini", "@mapbox/martini/index.js"), ("Delatin", "delatin/index.js")):
            path = os.path.join(os.path.abspath(modules), module)
            asked, first = error, True
            while True:
                vertices, triangles, seconds = by_node(path, heights, asked, folder)
                true, _ = measure(heights, vertices, triangles)
                row = {"method": method, "asked_m": asked, "true_m": true, "triangles": len(triangles), "ms": seconds * 1000}
                if first:
                    yield row
                if true <= worst or asked < error / 50:
                    break
                asked, first = asked * min(0.95, 0.99 * worst / true), False
            if not first:
                yield row
        row = by_scipy(heights, worst)
        if row:
            yield row


# Those of docs/measured.md: name, file, west and north. The last two files are made.
TWELVE = (
    ("Jotunheimen, 117 m", "norway_jotunheimen_117m_512_f32.tif", 0, 0),
    ("Jotunheimen, south-east", "norway_jotunheimen_117m_512_f32.tif", 255, 255),
    ("Puget Sound, 160 m, peninsula", "puget_sound_160m_1025_u16.png", 0, 0),
    ("Puget Sound, middle", "puget_sound_160m_1025_u16.png", 350, 350),
    ("Puget Sound, south-east", "puget_sound_160m_1025_u16.png", 700, 700),
    ("Sierra Nevada, 90 m, west", "spain_sierra_nevada_srtm3_3601x2401_i16.tif", 1000, 800),
    ("Sierra Nevada, east", "spain_sierra_nevada_srtm3_3601x2401_i16.tif", 2400, 1200),
    ("Grand Canyon, 60 m, heights in 8 bits", "grand_canyon_60m_4097x2049_u8.png", 1000, 600),
    ("Grand Canyon, east", "grand_canyon_60m_4097x2049_u8.png", 2500, 1000),
    ("Mount St. Helens, 30 m", "SainteHelens_usgs.dem", 30, 100),
    ("mountains made up, 60 m", "mountains-small.tif", 100, 100),
    ("hills made up, 1 m", "hills.tif", 500, 300),
)


def twelve_of(folder):
    """Names and files, as load() takes them, of the twelve tiles."""
    made = tempfile.mkdtemp()
    for name in ("mountains-small", "hills"):
        subprocess.run([os.path.join(ROOT, "build/release/bin/fjell-bake"), "synth", os.path.join(ROOT, f"content/terrain/{name}.json"),
                        "-o", os.path.join(made, name + ".tif"), "--quiet"], check=True)  # fmt: skip
    places = [os.path.join(f, name) for _, name, _, _ in TWELVE for f in (folder, made) if os.path.exists(os.path.join(f, name))]
    return [(of[0], f"{place}@{of[2]},{of[3]}") for of, place in zip(TWELVE, places, strict=True)]


def tiles_of(files):
    if len(files) == 1 and os.path.isdir(files[0]):
        return twelve_of(files[0])
    return [(os.path.basename(f).split(".")[0].split("@")[0] + f[f.find("@") :] * ("@" in f), f) for f in files]


def load(given):
    path, _, corner = given.partition("@")
    if path.endswith(".npy"):
        heights = np.load(path)
    else:
        from osgeo import gdal

        gdal.UseExceptions()
        heights = gdal.Open(path).ReadAsArray()
    if corner:
        x, y = map(int, corner.split(","))
        heights = heights[y : y + 257, x : x + 257]
    side = 1 << (min(heights.shape) - 1).bit_length() - 1
    return np.ascontiguousarray(heights[: side + 1, : side + 1].astype(np.float32))


def of_one(heights, modules):
    found = list(rows(heights, modules, (5.0, 20.0)))
    if "--json" in sys.argv:
        return json.dumps(found, indent=2)
    side = len(heights)
    lines = [f"{side} x {side} samples, heights {heights.min():.0f} to {heights.max():.0f} m"]
    for r in found:
        lines.append(
            f"{r['method']:8} asked {r['asked_m']:6.2f} m: true {r['true_m']:6.2f} m, {r['triangles']:7} triangles, {r['ms']:8.1f} ms"
        )
    return "\n".join(lines)


def of_several(given, modules):
    """Each method's last row: where its true error is no larger than Fjell's. Martini's first: what it makes of a wish."""
    tiles = []
    for name, file in given:
        heights = load(file)
        found = list(rows(heights, modules, (float(heights.max() - heights.min()) / 100,)))
        of = {r["method"]: r for r in found}
        first = next(r for r in found if r["method"] == "Martini")
        # Martini leaves out what is off by exactly the error.
        chunks = by_chunks(heights, np.nextafter(first["asked_m"], np.inf)) - first["triangles"]
        tiles.append({"tile": name, "over": first["true_m"] / first["asked_m"], "chunks_more": chunks, **of})
        print(name, file=sys.stderr)
    if "--json" in sys.argv:
        return json.dumps(tiles, indent=2)
    lines = [
        "| tile | Martini's error, of what was asked | Fjell: triangles | Martini: triangles | Delatin: triangles "
        "| Martini: time, of Fjell's | Delatin: time, of Fjell's |",
        "|---|---|---|---|---|---|---|",
    ]
    for t in tiles:
        ours = t["Fjell"]
        lines.append(
            f"| {t['tile']} | {t['over']:.2f} | {ours['triangles']:,} | {t['Martini']['triangles']:,} "
            f"| {t['Delatin']['triangles']:,} | {t['Martini']['ms'] / ours['ms']:.1f} | {t['Delatin']['ms'] / ours['ms']:.1f} |"
        )
    for method in ("Martini", "Delatin"):
        fewer = np.median([t["Fjell"]["triangles"] / t[method]["triangles"] for t in tiles])
        times = [t[method]["ms"] / t["Fjell"]["ms"] for t in tiles]
        lines.append(
            f"{method}: median of Fjell's triangles over its {fewer:.2f}, of its time over Fjell's {np.median(times):.1f}, "
            f"{min(times):.1f} to {max(times):.1f}"
        )
    apart = [t["chunks_more"] for t in tiles]
    lines.append(f"cesium-terrain-builder's rule, asked as Martini is: {min(apart)} to {max(apart)} triangles more than Martini's")
    return "\n".join(lines)


def plot_of(given, modules, path):
    """Triangles of all tiles, by the share of each one's relief that the error may be."""
    global calls
    calls = 1
    methods, shares = ("Fjell", "Martini", "Delatin"), (0.5, 1, 2, 5)
    totals = {method: [[share, 0] for share in shares] for method in methods}
    for name, file in given:
        heights = load(file)
        for i, share in enumerate(shares):
            of = {r["method"]: r for r in rows(heights, modules, (float(heights.max() - heights.min()) * share / 100,))}
            for method in methods:
                totals[method][i][1] += of[method]["triangles"]
        print(name, file=sys.stderr)
    made = {
        "name": "plot-meshes",
        "title": f"Triangles of {len(given)} tiles at the same true error",
        "x_label": "error, percent of a tile's relief",
        "y_label": "triangles of all tiles",
        "lines": [{"label": method, "points": totals[method]} for method in methods],
    }
    with open(path, encoding="utf-8") as file:
        all_plots = json.load(file)
    all_plots["plots"] = [p for p in all_plots["plots"] if p["name"] != made["name"]] + [made]
    with open(path, "w", encoding="utf-8") as file:
        file.write(json.dumps(all_plots, indent=1) + "\n")
    return path


def main():
    if "--plot" in sys.argv:
        at = sys.argv.index("--plot")
        *files, modules = sys.argv[1:at] + sys.argv[at + 2 :]
        print(plot_of(tiles_of(files), modules, sys.argv[at + 1]))
        return
    *files, modules = [a for a in sys.argv[1:] if a != "--json"]
    tiles = tiles_of(files)
    print(of_one(load(tiles[0][1]), modules) if len(tiles) == 1 else of_several(tiles, modules))


if __name__ == "__main__":
    main()
