// deck.gl and loaders.gl: a loader of height tiles that keeps its error, for TerrainLayer and load().
import { mesh } from "./mesh.js";
import { texelsOf } from "./tiles.js";
import { version } from "./version.js";

/** Walls along the tile's rim, for neighbours of another error: two triangles below each of its edges. */
function withSkirt({ positions, triangles }, width, height, depth) {
  const rim = [], edges = new Set();
  const side = (i) => { // which sides a vertex is on, as bits
    const x = positions[3 * i], z = positions[3 * i + 2];
    return (x === 0 ? 1 : 0) | (x === width - 1 ? 2 : 0) | (z === 0 ? 4 : 0) | (z === height - 1 ? 8 : 0);
  };
  for (let t = 0; t < triangles.length; t += 3)
    for (let k = 0; k < 3; ++k) {
      const a = triangles[t + k], b = triangles[t + (k + 1) % 3];
      if (side(a) & side(b)) edges.add(a * 2 ** 26 + b);
    }
  for (const edge of edges) {
    const a = Math.floor(edge / 2 ** 26), b = edge % 2 ** 26;
    if (!edges.has(b * 2 ** 26 + a)) rim.push(a, b);
  }
  const lower = new Map(), more = [], walls = [];
  const below = (i) => {
    if (!lower.has(i)) {
      lower.set(i, positions.length / 3 + lower.size);
      more.push(positions[3 * i], positions[3 * i + 1] - depth, positions[3 * i + 2]);
    }
    return lower.get(i);
  };
  for (let i = 0; i < rim.length; i += 2) {
    const [a, b] = [rim[i], rim[i + 1]];
    walls.push(b, a, below(a), b, below(a), below(b));
  }
  const joined = (Type, one, other) => { const all = new Type(one.length + other.length); all.set(one); all.set(other, one.length); return all; };
  return { positions: joined(Float32Array, positions, more), triangles: joined(Uint32Array, triangles, walls) };
}

/** A row and a column more, equal to the last ones: a tile ends where its neighbour begins. */
function extended(heights, width, height) {
  const wide = width + 1, all = new Float32Array(wide * (height + 1));
  for (let y = 0; y <= height; ++y) {
    const from = Math.min(y, height - 1) * width;
    all.set(heights.subarray(from, from + width), y * wide);
    all[y * wide + width] = heights[from + width - 1];
  }
  return all;
}

async function parse(bytes, options) {
  const { meshMaxError = 10, bounds, skirtHeight = 0, elevationDecoder = {} } = options?.terrain ?? {};
  const { rScaler = 1, gScaler = 0, bScaler = 0, offset = 0 } = elevationDecoder;
  const { width, height, rgba } = await texelsOf(new Uint8Array(bytes));
  const heights = Float32Array.from({ length: width * height }, (_, i) =>
    rgba[4 * i + 3] === 0 ? NaN : rgba[4 * i] * rScaler + rgba[4 * i + 1] * gScaler + rgba[4 * i + 2] * bScaler + offset);
  const made = await mesh(extended(heights, width, height), { width: width + 1, height: height + 1, maxError: meshMaxError });
  const { positions, triangles } = skirtHeight > 0 ? withSkirt(made, width + 1, height + 1, skirtHeight) : made;
  const [west, south, east, north] = bounds ?? [0, 0, width, height];
  const places = new Float32Array(positions.length), texels = new Float32Array(positions.length / 3 * 2);
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length / 3; ++i) {
    const u = positions[3 * i] / width, v = positions[3 * i + 2] / height;
    places.set([west + u * (east - west), north - v * (north - south), positions[3 * i + 1]], 3 * i);
    texels.set([u, v], 2 * i);
    if (3 * i >= made.positions.length) continue; // the skirt is no part of the box
    for (let k = 0; k < 3; ++k) {
      low[k] = Math.min(low[k], places[3 * i + k]);
      high[k] = Math.max(high[k], places[3 * i + k]);
    }
  }
  return {
    loaderData: { header: {}, trueError: made.trueError },
    header: { vertexCount: positions.length / 3, boundingBox: [low, high] },
    topology: "triangle-list", mode: 4,
    indices: { value: triangles, size: 1 },
    attributes: { POSITION: { value: places, size: 3 }, TEXCOORD_0: { value: texels, size: 2 } },
  };
}

/**
 * In the place of loaders.gl's TerrainLoader, with its options: `new TerrainLayer({ loaders: [HeightLoader], ... })`.
 * meshMaxError is kept at every texel, and tiles of any size are taken.
 */
export const HeightLoader = {
  dataType: null, batchType: null,
  name: "Heights, by Fjell", id: "terrain", module: "fjell", version, worker: false,
  extensions: ["png", "pngraw", "webp"],
  mimeTypes: ["image/png", "image/webp"],
  tests: [(bytes) => new Uint8Array(bytes)[0] === 137],
  options: { terrain: {} },
  parse,
};
