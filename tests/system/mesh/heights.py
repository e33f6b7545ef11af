# Reads the heights of `fjell-bake heights` by their sidecar and compares them with an ASCII grid.
#   heights.py SIDECAR.json GRID.asc
# Prints JSON: rounded (how far a number is from the sample that it stands for), surface (the largest distance of a
# sample from the surface through the numbers, over both diagonals of each cell), shared (numbers that two tiles have
# alike where they meet), beyond (numbers beyond the rim, each its rim's).
import json, os, struct, sys, zlib


def read_png(data):
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8 : at + 8 + size]
        if kind == b"IHDR":
            columns, rows, bits, colour, _, _, interlace = struct.unpack(">IIBBBBB", body)
            assert bits == 16 and colour == 0 and interlace == 0
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
    raw, before, numbers = zlib.decompress(packed), bytes(2 * columns), []
    for y in range(rows):
        line = bytearray(raw[y * (2 * columns + 1) + 1 : (y + 1) * (2 * columns + 1)])
        how = raw[y * (2 * columns + 1)]
        for i in range(len(line)):
            a, b, c = line[i - 2] if i > 1 else 0, before[i], before[i - 2] if i > 1 else 0
            p = a + b - c
            nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            line[i] = line[i] + (0, a, b, (a + b) // 2, nearest)[how] & 255
        numbers += struct.unpack(">%dH" % columns, line)
        before = bytes(line)
    return columns, rows, numbers


def main(sidecar, grid):
    said = json.load(open(sidecar))
    words = open(grid).read().split()
    columns, rows = int(words[1]), int(words[3])
    assert words[8] == "cellsize" and words[10] == "NODATA_value"
    heights = [float(w) for w in words[12:]]
    assert len(heights) == columns * rows
    step, side_x, side_y = 1 << said["level"], said["columns"], said["rows"]
    out = {"rounded": 0.0, "surface": 0.0, "shared": 0, "beyond": 0}
    all_numbers = {}
    for k, name in enumerate(said["files"]):
        i, j = k % said["tiles"][0], k // said["tiles"][0]
        if len(said["files"]) > 1:
            assert "_x%d_y%d." % (i, j) in name
        data = open(os.path.join(os.path.dirname(sidecar), name), "rb").read()
        if name.endswith(".png"):
            wide, high, numbers = read_png(data)
            assert (wide, high) == (side_x, side_y)
        else:
            assert len(data) == 2 * side_x * side_y
            numbers = struct.unpack("<%dH" % (side_x * side_y), data)
        for y in range(side_y):
            for x in range(side_x):
                place = i * (side_x - 1) + x, j * (side_y - 1) + y
                n = numbers[y * side_x + x]
                if place in all_numbers:
                    assert all_numbers[place] == n, "tiles differ where they meet"
                    out["shared"] += 1
                all_numbers[place] = n
    metres = lambda x, y: said["offset_m"] + said["scale_m"] * all_numbers[x, y]
    for x, y in all_numbers:
        sx, sy = min(x * step, columns - 1), min(y * step, rows - 1)
        out["beyond"] += x * step >= columns + step - 1 or y * step >= rows + step - 1
        out["rounded"] = max(out["rounded"], abs(metres(x, y) - heights[sy * columns + sx]))
    for y in range(rows):
        for x in range(columns):
            i, j = min(x // step, (columns - 2) // step), min(y // step, (rows - 2) // step)
            u, v = (x - i * step) / step, (y - j * step) / step
            nw, ne, sw, se = metres(i, j), metres(i + 1, j), metres(i, j + 1), metres(i + 1, j + 1)
            falling = nw + u * (ne - nw) + v * (se - ne) if u >= v else nw + v * (sw - nw) + u * (se - sw)
            rising = nw + u * (ne - nw) + v * (sw - nw) if u + v <= 1 else se + (1 - u) * (sw - se) + (1 - v) * (ne - se)
            h = heights[y * columns + x]
            out["surface"] = max(out["surface"], abs(falling - h), abs(rising - h))
    print(json.dumps(out))


main(*sys.argv[1:])
