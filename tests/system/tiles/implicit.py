"""Spells out the implicit trees of 3D Tiles 1.1 by the specification: nodes with children, as an explicit tileset has
them. Standard library only; nothing of Fjell."""
import json
import math
import os
import struct


def must(true, text):
    if not true:
        raise ValueError(text)


class Subtree:
    """One .subtree file: which tiles, contents and subtrees there are, and what its table says of a tile."""

    def __init__(self, path, levels, schema):
        raw = open(path, "rb").read()
        magic, version, text_n, binary_n = struct.unpack_from("<4sIQQ", raw)
        must((magic, version) == (b"subt", 1) and text_n % 8 == binary_n % 8 == 0, f"{path}: no subtree")
        must(len(raw) == 24 + text_n + binary_n, f"{path}: has another size")
        self.said, binary = json.loads(raw[24:24 + text_n]), raw[24 + text_n:]
        (buffer,) = self.said["buffers"]
        must(buffer["byteLength"] <= binary_n and "uri" not in buffer, f"{path}: its buffer")
        for view in self.said["bufferViews"]:
            must(view["buffer"] == 0 and view["byteOffset"] % 8 == 0, f"{path}: a view that is not aligned")
            must(view["byteOffset"] + view["byteLength"] <= buffer["byteLength"], f"{path}: a view beyond the buffer")

        def bytes_of(i):
            view = self.said["bufferViews"][i]
            return binary[view["byteOffset"]:view["byteOffset"] + view["byteLength"]]

        def bits(available, count):
            if "constant" in available:
                return [available["constant"]] * count
            data = bytes_of(available["bitstream"])
            must(len(data) == (count + 7) // 8, f"{path}: a bit stream of {len(data)} bytes for {count} bits")
            found = [data[i // 8] >> i % 8 & 1 for i in range(count)]
            must(available.get("availableCount", sum(found)) == sum(found), f"{path}: counts its bits wrongly")
            return found

        count = (4 ** levels - 1) // 3
        self.tiles = bits(self.said["tileAvailability"], count)
        (content,) = self.said["contentAvailability"]
        self.contents = bits(content, count)
        self.below = bits(self.said["childSubtreeAvailability"], 4 ** levels)
        must(self.tiles[0] == 1, f"{path}: is of no tile")
        must(all(t >= c for t, c in zip(self.tiles, self.contents)), f"{path}: content without a tile")
        table = self.said["propertyTables"][self.said["tileMetadata"]]
        must(table["count"] == sum(self.tiles), f"{path}: a row for each tile")
        self.rows = [None if not t else sum(self.tiles[:i]) for i, t in enumerate(self.tiles)]
        self.columns = {}
        for name, how in schema["classes"][table["class"]]["properties"].items():
            must((how["type"], how["componentType"]) == ("SCALAR", "FLOAT64"), f"{path}: {name} is no double")
            data = bytes_of(table["properties"][name]["values"])
            self.columns[how["semantic"]] = struct.unpack(f"<{table['count']}d", data)


def spelled_out(folder, root, schema, found):
    """The node of a root with implicitTiling, with all tiles below it. found: subtrees that were read are added."""
    how = root["implicitTiling"]
    must(how["subdivisionScheme"] == "QUADTREE", "another scheme")
    levels, content_uri, subtree_uri = how["subtreeLevels"], root["content"]["uri"], how["subtrees"]["uri"]
    first_z, first_x, first_y = map(int, content_uri.split("/")[0].split("-"))
    deepest = 0

    def uri(template, z, x, y):
        return template.replace("{level}", str(z)).replace("{x}", str(x)).replace("{y}", str(y))

    def morton(x, y):
        return sum((x >> i & 1) << 2 * i | (y >> i & 1) << 2 * i + 1 for i in range(32))

    def subtree_at(z, x, y):
        name = uri(subtree_uri, z, x, y)
        must(name not in found, f"{name}: is read twice")
        found.append(name)
        return Subtree(os.path.join(folder, name), levels, schema)

    def node(z, x, y, tree, box):
        nonlocal deepest
        deepest = max(deepest, z)
        k = z % levels
        at = (4 ** k - 1) // 3 + morton(x % (1 << k), y % (1 << k))
        must(tree.tiles[at], f"level {z}: a tile that is not there")
        value = lambda semantic: tree.columns[semantic][tree.rows[at]]
        error = value("TILE_GEOMETRIC_ERROR")
        must(root["geometricError"] / 2 ** z >= error, f"level {z}: who halves errors is below {error} m")
        west, south, east, north = box
        made = {"boundingVolume": {"region": [*box, value("TILE_MINIMUM_HEIGHT"), value("TILE_MAXIMUM_HEIGHT")]},
                "geometricError": error, "key": (first_z + z, (first_x << z) + x, (first_y << z) + y), "children": []}
        if tree.contents[at]:
            made["content"] = {"uri": uri(content_uri, z, x, y)}
        middle = (west + east) / 2, (south + north) / 2
        for cy, cx in ((0, 0), (0, 1), (1, 0), (1, 1)):
            inner = ((west, middle[0], east)[cx], (south, middle[1], north)[cy],
                     (west, middle[0], east)[cx + 1], (south, middle[1], north)[cy + 1])
            child = z + 1, 2 * x + cx, 2 * y + cy
            if k + 1 < levels:
                number = (4 ** (k + 1) - 1) // 3 + morton(child[1] % (1 << k + 1), child[2] % (1 << k + 1))
                if tree.tiles[number]:
                    made["children"].append(node(*child, tree, inner))
            elif tree.below[morton(child[1] % (1 << levels), child[2] % (1 << levels))]:
                made["children"].append(node(*child, subtree_at(*child), inner))
        return made

    made = node(0, 0, 0, subtree_at(0, 0, 0), tuple(root["boundingVolume"]["region"][:4]))
    must(how["availableLevels"] == deepest + 1, f"{how['availableLevels']} levels, {deepest + 1} have tiles")
    must(not any(math.isnan(v) for v in root["boundingVolume"]["region"]), "a region that is none")
    return made
