"""The error of a mesh as NumPy finds it, which knows nothing of Fjell: from the array, the vertices and the triangles."""

import numpy as np


def places(vertices, spacing, up="y"):
    """Columns and rows of vertices, as whole numbers, and their heights."""
    x, other = vertices[:, 0].astype(float), vertices[:, 2 if up == "y" else 1].astype(float)
    columns, rows = np.rint(x / spacing[0]).astype(int), np.rint((other if up == "y" else -other) / spacing[1]).astype(int)
    return columns, rows, vertices[:, 1 if up == "y" else 2].astype(float)


def measure(heights, vertices, triangles, spacing=(1.0, 1.0), up="y"):
    """The largest vertical distance of a sample from a triangle over it, and which samples lie under one."""
    columns, rows, up_m = places(vertices, spacing, up)
    ground = np.ma.filled(np.ma.asarray(heights).astype(float), np.nan)
    covered = np.zeros(ground.shape, bool)
    worst = 0.0
    if len(triangles) == 0:
        return worst, covered
    x, y, h = columns[triangles], rows[triangles], up_m[triangles]
    west, north = x.min(axis=1), y.min(axis=1)
    shapes = np.stack([x.max(axis=1) - west, y.max(axis=1) - north], axis=1)
    for w, d in np.unique(shapes, axis=0):
        chosen = np.flatnonzero((shapes == (w, d)).all(axis=1))
        offsets = np.stack(np.meshgrid(np.arange(w + 1), np.arange(d + 1)), axis=-1).reshape(-1, 2)
        for part in np.array_split(chosen, max(1, len(chosen) * len(offsets) // 2_000_000)):
            px = west[part, None] + offsets[None, :, 0]
            py = north[part, None] + offsets[None, :, 1]
            weights = []
            for k in range(3):
                i, j = (k + 1) % 3, (k + 2) % 3
                ax, ay, bx, by = (v[part, None] for v in (x[:, i], y[:, i], x[:, j], y[:, j]))
                weights.append((bx - ax) * (py - ay) - (by - ay) * (px - ax))
            area = sum(weights)
            # Rows run to the south, so corners that run counter-clockwise on the map have a negative area.
            assert (area < 0).all(), "a triangle is degenerate, or turned over"
            inside = np.all([wt <= 0 for wt in weights], axis=0)
            surface = sum(wt * h[part, None, k] for k, wt in enumerate(weights)) / area
            off = np.abs(ground[py, px] - surface)[inside]
            assert not np.isnan(off).any(), "a triangle lies over a hole"
            worst = max(worst, off.max())
            covered[py[inside], px[inside]] = True
    return worst, covered


def rims(triangles):
    """Edges that only one triangle has, after a look that none has more than two and neighbours turn alike."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    assert len(np.unique(edges, axis=0)) == len(edges), "an edge runs the same way in two triangles"
    there = {tuple(e) for e in edges.tolist()}
    return [e for e in there if (e[1], e[0]) not in there]


def covered_by_cells(ground):
    """Samples under triangles of the full resolution: those of cells, whose three corners are all ground."""
    hole = np.isnan(ground)
    covered = np.zeros(ground.shape, bool)
    rows, columns = ground.shape
    nw, ne, sw, se = hole[:-1, :-1], hole[:-1, 1:], hole[1:, :-1], hole[1:, 1:]
    y, x = np.mgrid[0 : rows - 1, 0 : columns - 1]
    falling = (x + y) % 2 == 0  # cut from north-west to south-east
    corners = {
        True: ((nw, ne, se), (nw, se, sw)),
        False: ((nw, ne, sw), (ne, se, sw)),
    }
    at = {id(nw): (0, 0), id(ne): (0, 1), id(sw): (1, 0), id(se): (1, 1)}
    for falls, pair in corners.items():
        for triangle in pair:
            whole = (falling == falls) & ~(triangle[0] | triangle[1] | triangle[2])
            for corner in triangle:
                dy, dx = at[id(corner)]
                covered[dy : rows - 1 + dy, dx : columns - 1 + dx] |= whole
    return covered
