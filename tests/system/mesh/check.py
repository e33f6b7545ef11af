# Reads a mesh file by its format's specification and measures every sample of an ASCII grid against it. Shares nothing
# with the writer.
#   check.py FILE GRID.asc
# Prints JSON: format, vertices, triangles (of the top), facets (of all), worst (the largest vertical distance of a
# sample), measured (samples that a triangle covers), ground (samples in the grid), bare (samples of cells with ground
# that no triangle covers), over_holes, inner (open edges that are neither at the rim nor beside a hole), unpaired
# (of .stl: edges without one opposite), volume, claimed, downward.
import json, math, os, re, struct, sys

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from glb import Glb

EDGE = 1e-5  # of a cell: a sample that lies no farther outside of a triangle counts, as places are floats


def read_grid(path):
    words = open(path).read().split()
    head = {}
    while re.match(r"[A-Za-z]", words[0]):
        head[words[0].lower()] = float(words[1])
        words = words[2:]
    columns, rows = int(head["ncols"]), int(head["nrows"])
    void = head.get("nodata_value")
    f32 = lambda v: struct.unpack("f", struct.pack("f", v))[0]
    heights = [None if float(w) == void else f32(float(w)) for w in words]
    assert len(heights) == columns * rows
    return columns, rows, head["cellsize"], heights


def read_glb(data):
    glb = Glb(data)
    assert all(n[1] > 0 for n in glb.normals)
    return [(x, -z, y) for x, y, z in glb.places], glb.triangles, glb.gltf["asset"]["extras"]["fjell"]["true_error_m"]


def claim_of(text):
    return float(re.search(r"no sample is farther than ([-+.\deE]+) m", text).group(1))


def read_ply(data):
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode()
    assert header.startswith("ply\nformat binary_little_endian 1.0\n")
    count = int(re.search(r"element vertex (\d+)\nproperty float x\nproperty float y\nproperty float z\n", header).group(1))
    faces = int(re.search(r"element face (\d+)\nproperty list uchar uint vertex_indices\n", header).group(1))
    places = list(struct.iter_unpack("<3f", data[end : end + 12 * count]))
    listed = list(struct.iter_unpack("<B3I", data[end + 12 * count :]))
    assert len(listed) == faces and all(f[0] == 3 for f in listed)
    return places, [f[1:] for f in listed], claim_of(header)


def read_obj(data):
    lines = data.decode().splitlines()
    places = [tuple(map(float, l.split()[1:])) for l in lines if l.startswith("v ")]
    triangles = [tuple(int(i) - 1 for i in l.split()[1:]) for l in lines if l.startswith("f ")]
    return [(x, -z, y) for x, y, z in places], triangles, claim_of("\n".join(l for l in lines if l.startswith("#")))


def read_stl(data):
    assert not data.startswith(b"solid")
    (count,) = struct.unpack_from("<I", data, 80)
    assert len(data) == 84 + 50 * count
    numbers, places, facets = {}, [], []
    for f in struct.iter_unpack("<12fH", data[84:]):
        corners = [f[3:6], f[6:9], f[9:12]]
        for c in corners:
            if c not in numbers:
                numbers[c] = len(places)
                places.append(c)
        n = normal(*corners)
        size = math.hypot(*n)
        assert all(abs(n[k] / size - f[k]) < 1e-4 for k in range(3)), "a facet's normal"
        facets.append(tuple(numbers[c] for c in corners))
    return places, facets, claim_of(data[:80].decode())


def normal(a, b, c):
    u, v = [b[k] - a[k] for k in range(3)], [c[k] - a[k] for k in range(3)]
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


def directed(triangles):
    return [(t[k], t[(k + 1) % 3]) for t in triangles for k in range(3)]


def main(path, grid):
    columns, rows, spacing, heights = read_grid(grid)
    ending = path[-4:]
    reader = {".glb": read_glb, ".ply": read_ply, ".obj": read_obj, ".stl": read_stl}[ending]
    places, facets, claimed = reader(open(path, "rb").read())
    out = {"format": ending, "vertices": len(places), "facets": len(facets), "claimed": claimed}
    top = facets
    if ending == ".stl":
        edges = directed(facets)
        count = {}
        for e in edges:
            count[e] = count.get(e, 0) + 1
        out["unpaired"] = sum(1 for (a, b), n in count.items() if n != 1 or count.get((b, a), 0) != 1)
        out["volume"] = sum(
            sum(places[t[0]][k] * normal((0, 0, 0), places[t[1]], places[t[2]])[k] for k in range(3)) for t in facets
        ) / 6
        floor = min(p[2] for p in places)
        out["floor"] = floor
        top = [t for t in facets if normal(*(places[i] for i in t))[2] > 0]
    out["triangles"] = len(top)
    out["downward"] = sum(1 for t in top if normal(*(places[i] for i in t))[2] <= 0)

    hole = lambda x, y: heights[y * columns + x] is None
    covered, worst, over_holes = set(), 0.0, 0
    for t in top:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (
            (places[i][0] / spacing, -places[i][1] / spacing, places[i][2]) for i in t
        )
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        for y in range(math.ceil(min(ay, by, cy) - EDGE), math.floor(max(ay, by, cy) + EDGE) + 1):
            for x in range(math.ceil(min(ax, bx, cx) - EDGE), math.floor(max(ax, bx, cx) + EDGE) + 1):
                q = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area
                r = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area
                if q < -EDGE or r < -EDGE or q + r > 1 + EDGE:
                    continue
                if hole(x, y):
                    over_holes += 1
                    continue
                covered.add((x, y))
                worst = max(worst, abs(az + q * (bz - az) + r * (cz - az) - heights[y * columns + x]))
    out["worst"], out["measured"], out["over_holes"] = worst, len(covered), over_holes
    out["ground"] = sum(1 for h in heights if h is not None)
    cell = lambda x, y: 0 <= x < columns - 1 and 0 <= y < rows - 1 and not any(
        hole(x + i, y + j) for i in (0, 1) for j in (0, 1))
    out["bare"] = sum(
        1 for y in range(rows) for x in range(columns)
        if (x, y) not in covered and any(cell(x - i, y - j) for i in (0, 1) for j in (0, 1)))

    once = set(directed(top))
    inner = 0
    for a, b in once:
        if (b, a) in once:
            continue
        (ax, ay), (bx, by) = ((round(places[i][0] / spacing), round(-places[i][1] / spacing)) for i in (a, b))
        rim = (ax == bx and ax in (0, columns - 1)) or (ay == by and ay in (0, rows - 1))
        near = any(
            hole(x, y)
            for y in range(max(0, min(ay, by) - 1), min(rows, max(ay, by) + 2))
            for x in range(max(0, min(ax, bx) - 1), min(columns, max(ax, bx) + 2)))
        inner += not rim and not near
    out["inner"] = inner
    print(json.dumps(out))


main(*sys.argv[1:])
