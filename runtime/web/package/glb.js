// The mesh of a frame as binary glTF 2.0: a node for each tile, with the axes, the names and the extras of the
// snapshots that fjell-fly writes (fjell/gltf/snapshot.h), without textures.

const magic = 0x46546c67, json = 0x4e4f534a, binary = 0x004e4942;
const floats = 5126, words = 5125, vertexBuffer = 34962, indexBuffer = 34963;

/** tiles: ranges of indices, several for a tile. at: height(vertex) and normal(x, z). */
export function writeGlb(terrain, tiles, view, at) {
  const byTile = new Map();
  for (const range of tiles) {
    const name = `tile ${range.column} ${range.row}`;
    if (!byTile.has(name)) byTile.set(name, { ...range, ranges: [] });
    byTile.get(name).ranges.push(range);
  }
  const [dx, dz] = terrain.spacing;
  const parts = [], nodes = [], meshes = [], accessors = [], bufferViews = [];
  let bytes = 0, allVertices = 0, allTriangles = 0;
  const add = (array, target, accessor) => {
    accessors.push({ bufferView: bufferViews.length, ...accessor });
    bufferViews.push({ buffer: 0, byteOffset: bytes, byteLength: array.byteLength, target });
    parts.push(array);
    bytes += array.byteLength;
    return accessors.length - 1;
  };
  for (const [name, tile] of byTile) {
    const numberOf = new Map(), indices = [], slots = [];
    for (const { first, count } of tile.ranges)
      for (let i = first; i + 2 < first + count; i += 3) {
        for (const slot of terrain.indexSlots.subarray(i, i + 3)) {
          let number = numberOf.get(slot);
          if (number === undefined) {
            number = slots.length;
            numberOf.set(slot, number);
            slots.push(slot);
          }
          indices.push(number);
        }
      }
    if (indices.length === 0) continue;
    const x0 = tile.column * terrain.tileCells, z0 = tile.row * terrain.tileCells;
    const positions = new Float32Array(3 * slots.length), normals = new Float32Array(3 * slots.length);
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    slots.forEach((slot, i) => {
      const column = terrain.vertexSlots[3 * slot], row = terrain.vertexSlots[3 * slot + 1];
      positions.set([(column - x0) * dx, at.height(slot), (row - z0) * dz], 3 * i);
      normals.set(at.normal(column * dx, row * dz), 3 * i);
      for (let k = 0; k < 3; ++k) {
        low[k] = Math.min(low[k], positions[3 * i + k]);
        high[k] = Math.max(high[k], positions[3 * i + k]);
      }
    });
    const count = slots.length;
    const attributes = {
      POSITION: add(positions, vertexBuffer, { componentType: floats, count, type: "VEC3", min: low, max: high }),
      NORMAL: add(normals, vertexBuffer, { componentType: floats, count, type: "VEC3" }),
    };
    const index = add(Uint32Array.from(indices), indexBuffer, { componentType: words, count: indices.length, type: "SCALAR" });
    meshes.push({ name, primitives: [{ attributes, indices: index, material: 0 }] });
    nodes.push({ name, mesh: meshes.length - 1, translation: [x0 * dx, 0, z0 * dz] });
    allVertices += count;
    allTriangles += indices.length / 3;
  }
  const extras = {
    error_px: terrain.settings.maxError, error_px_effective: terrain.frame.errorBound, converged: terrain.frame.converged,
    morphed: terrain.settings.morph !== "none", quantum_m: terrain.quantum, spacing_m: terrain.spacing,
    size: [terrain.columns, terrain.rows], origin_m: terrain.origin, vertices: allVertices, triangles: allTriangles,
    ...(view && { viewport: [view.width, view.height], fov_y_deg: 2 * Math.atan(view.top) * 180 / Math.PI, eye: Array.from(view.eye) }),
  };
  const document = {
    asset: { version: "2.0", generator: "fjell" },
    scene: 0, scenes: [{ nodes: nodes.map((_, i) => i), extras: { fjell: extras } }],
    nodes, meshes, accessors, bufferViews, buffers: [{ byteLength: bytes }],
    materials: [{ name: "ground", pbrMetallicRoughness: { baseColorFactor: [0.5, 0.5, 0.45, 1], metallicFactor: 0, roughnessFactor: 1 } }],
  };
  if (nodes.length === 0) throw new Error("snapshot: the last update draws nothing; update the terrain for a view that sees it");
  return assemble(document, parts, bytes);
}

function assemble(document, parts, bytes) {
  const text = new TextEncoder().encode(JSON.stringify(document));
  const textBytes = Math.ceil(text.length / 4) * 4;
  const total = 12 + 8 + textBytes + 8 + bytes;
  const file = new Uint8Array(total).fill(0x20, 20 + text.length, 20 + textBytes);
  const view = new DataView(file.buffer);
  [magic, 2, total, textBytes, json].forEach((value, i) => view.setUint32(4 * i, value, true));
  file.set(text, 20);
  view.setUint32(20 + textBytes, bytes, true);
  view.setUint32(24 + textBytes, binary, true);
  let to = 28 + textBytes;
  for (const part of parts) {
    file.set(new Uint8Array(part.buffer, part.byteOffset, part.byteLength), to);
    to += part.byteLength;
  }
  return file;
}
