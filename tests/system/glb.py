"""Reads the bytes of a .glb of one mesh by the specification of glTF 2.0 and KHR_mesh_quantization. Standard library
only; nothing of Fjell. What is wrong is a ValueError."""
import json
import math
import struct


def must(true, text):
    if not true:
        raise ValueError(text)


class Glb:
    """gltf: the JSON. places, normals (or None), triangles: of the scene. tangents: as stored. scale: of the lattice, where
    there is one. uv, images: of the textures and their bytes, by what they are: colour, normal, occlusion."""

    def __init__(self, data):
        magic, version, length = struct.unpack_from("<4sII", data)
        size, kind = struct.unpack_from("<I4s", data, 12)
        must((magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON") and size % 4 == 0, "no binary glTF")
        self.gltf = json.loads(data[20:20 + size])
        at = 20 + size
        size, kind = struct.unpack_from("<I4s", data, at)
        self.binary = data[at + 8:]
        must(kind == b"BIN\0" and size == len(self.binary), "its binary chunk has another size")
        must([b["byteLength"] for b in self.gltf["buffers"]] == [size], "its buffer has another size")
        (node,), (primitive,) = self.gltf["nodes"], self.gltf["meshes"][0]["primitives"]
        at = primitive["attributes"]["POSITION"]
        rounded = self.accessor(at)
        for name, choose in (("min", min), ("max", max)):
            must(self.gltf["accessors"][at][name] == [choose(p[k] for p in rounded) for k in range(3)], f"a wrong {name}")
        quantised = "KHR_mesh_quantization" in self.gltf.get("extensionsRequired", ())
        must(("scale" in node) == quantised, "a node that scales needs an extension")
        self.scale = node["scale"] if quantised else None
        scale, move = node.get("scale", [1, 1, 1]), node.get("translation", [0, 0, 0])
        self.places = [tuple(q * s + m for q, s, m in zip(p, scale, move)) for p in rounded]
        index = [i for i, in self.accessor(primitive["indices"])]
        self.triangles = list(zip(index[0::3], index[1::3], index[2::3]))
        self.normals = None
        if "NORMAL" in primitive["attributes"]:
            self.normals = self.accessor(primitive["attributes"]["NORMAL"])
            must(len(self.normals) == len(self.places), "a vertex without a normal")
            must(all(abs(math.hypot(*n) - 1) < 1e-4 for n in self.normals), "a normal that is no unit vector")
            turned = [[q / s for q, s in zip(n, scale)] for n in self.normals]
            self.normals = [tuple(q / math.hypot(*n) for q in n) for n in turned]
        self.tangents, self.images = None, {}
        if "TANGENT" in primitive["attributes"]:
            self.tangents = self.accessor(primitive["attributes"]["TANGENT"])
            must(all(abs(math.hypot(*t[:3]) - 1) < 1e-4 and abs(t[3]) == 1 for t in self.tangents), "a wrong tangent")
            turned = [[q * s for q, s in zip(t, scale)] for t in self.tangents]
            self.tangents = [(*(q / math.hypot(*t) for q in t), own[3]) for t, own in zip(turned, self.tangents)]
        if "TEXCOORD_0" in primitive["attributes"]:
            self.uv = self.accessor(primitive["attributes"]["TEXCOORD_0"])
            must(all(0 <= q <= 1 for uv in self.uv for q in uv), "a place beside the texture")
            material = self.gltf["materials"][primitive["material"]]
            for kind, texture in (("colour", material["pbrMetallicRoughness"].get("baseColorTexture")),
                                  ("normal", material.get("normalTexture")),
                                  ("occlusion", material.get("occlusionTexture"))):
                if texture:
                    image = self.gltf["images"][self.gltf["textures"][texture["index"]]["source"]]
                    view = self.gltf["bufferViews"][image["bufferView"]]
                    data = self.binary[view["byteOffset"]:view["byteOffset"] + view["byteLength"]]
                    start = {"image/jpeg": b"\xff\xd8", "image/png": b"\x89PNG"}[image["mimeType"]]
                    must(data.startswith(start), "a picture of another kind")
                    self.images[kind] = data
            must(self.images, "texture coordinates without a texture")

    def accessor(self, i):
        a = self.gltf["accessors"][i]
        v = self.gltf["bufferViews"][a["bufferView"]]
        must(a.get("byteOffset", 0) == 0, "an accessor inside of a view")
        form = f"<{ {'SCALAR': 1, 'VEC2': 2, 'VEC3': 3, 'VEC4': 4}[a['type']] }" + {5126: "f", 5125: "I", 5123: "H", 5122: "h"}[
            a["componentType"]]
        stride = v.get("byteStride", struct.calcsize(form))
        must(stride * a["count"] == v["byteLength"], "an accessor does not fit its view")
        values = [struct.unpack_from(form, self.binary, v["byteOffset"] + k * stride) for k in range(a["count"])]
        whole = {5122: 32767, 5123: 65535}.get(a["componentType"])
        return [tuple(q / whole for q in value) for value in values] if a.get("normalized") else values
