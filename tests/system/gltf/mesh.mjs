// The mesh itself: an edge manifold that covers the domain once, faces up, and is shaded and textured as promised.
import {decodePng, viewBytes} from './glb.mjs';

// Twice the area in cells, positive when counter-clockwise seen from above (+z is south, so x-z is mirrored).
function area2(tile, a, b, c) {
    const {columns: x, rows: y} = tile;
    return (x[c] - x[a]) * (y[b] - y[a]) - (x[b] - x[a]) * (y[c] - y[a]);
}

function normalY(tile, a, b, c) {
    const {x, z} = tile;
    return (z[b] - z[a]) * (x[c] - x[a]) - (x[b] - x[a]) * (z[c] - z[a]);
}

function checkTriangles(tile, problems) {
    let covered = 0;
    for (let i = 0; i < tile.indices.length; i += 3) {
        const [a, b, c] = tile.indices.subarray(i, i + 3), area = area2(tile, a, b, c);
        problems.require(area !== 0, 'degenerate', () => `${tile.name}: triangle ${i / 3}`);
        problems.require(
            area >= 0 && normalY(tile, a, b, c) > 0 === area > 0, 'down', () => `${tile.name}: triangle ${i / 3}`);
        covered += area;
    }
    return covered;
}

// One place and height a sample, whichever tile it is read from: bit for bit.
function checkBorders(tiles, {size}, problems) {
    const seen = new Map();
    for (const tile of tiles) {
        const own = new Set();
        for (let i = 0; i < tile.count; ++i) {
            const sample = tile.rows[i] * size[0] + tile.columns[i], known = seen.get(sample);
            problems.require(!own.has(sample), 'accessor', () => `${tile.name}: sample ${sample} twice`);
            own.add(sample);
            if (!known)
                seen.set(sample, {tile, i});
            else
                problems.require(['x', 'y', 'z'].every((axis) => known.tile[axis][known.i] === tile[axis][i]), 'crack',
                    () => `(${tile.columns[i]}, ${tile.rows[i]}) lies apart in ${known.tile.name} and ${tile.name}`);
        }
    }
    return seen.size;
}

// Every edge once in each direction, or once on the rim of the tiles that are there. A T-junction leaves edges without a
// partner inside it; so does a hole.
function checkEdges(tiles, {size}, holes, problems) {
    const samples = size[0] * size[1], edges = new Map();
    for (const tile of tiles) {
        const id = (v) => tile.rows[v] * size[0] + tile.columns[v];
        for (let i = 0; i < tile.indices.length; ++i) {
            const from = id(tile.indices[i]), to = id(tile.indices[i % 3 === 2 ? i - 2 : i + 1]);
            const key = Math.min(from, to) * samples + Math.max(from, to), bit = from < to ? 1 : 2,
                  known = edges.get(key) ?? 0;
            problems.require(
                !(known & bit), 'manifold', () => `${tile.name}: edge ${from}-${to} twice in one direction`);
            edges.set(key, known | bit);
        }
    }
    const onRim = (a, b) => {
        const [ax, ay, bx, by] = [a % size[0], Math.floor(a / size[0]), b % size[0], Math.floor(b / size[0])];
        if (ax !== bx && ay !== by) return false;
        const around = rectangles.filter(({left, top, right, bottom}) => Math.min(ax, bx) >= left
            && Math.max(ax, bx) <= right && Math.min(ay, by) >= top && Math.max(ay, by) <= bottom);
        return around.length === 1
            && ((ax === bx && (ax === around[0].left || ax === around[0].right))
                || (ay === by && (ay === around[0].top || ay === around[0].bottom)));
    };
    const rectangles = tiles.map(({rectangle}) => rectangle);
    let rim = 0;
    for (const [key, bits] of edges) {
        const a = Math.floor(key / samples), b = key % samples, outer = onRim(a, b);
        if (outer) ++rim;
        if (holes && bits !== 3) continue;
        problems.require((bits === 3) !== outer, 'manifold',
            () => `edge ${a}-${b} ${bits === 3 ? 'on the rim has two sides' : 'inside the domain is open'}`);
    }
    return rim;
}

// holes: the DEM has some, so that not everything is covered.
export function checkTopology(tiles, extras, holes, problems) {
    const covered = tiles.reduce((sum, tile) => sum + checkTriangles(tile, problems), 0);
    const domain = tiles.reduce(
        (sum, {rectangle: r}) => sum + 2 * (r.right - r.left) * (r.bottom - r.top), 0);
    problems.require(
        holes ? covered <= domain : covered === domain, 'cover', `${covered / 2} of ${domain / 2} cells`);
    const samples = checkBorders(tiles, extras, problems);
    const rim = checkEdges(tiles, extras, holes, problems);
    return {
        tiles: tiles.length,
        vertices: extras.vertices,
        triangles: extras.triangles,
        samples_used: samples,
        rim_edges: rim
    };
}

export function checkShading(tiles, extras, problems) {
    for (const tile of tiles) {
        if (!problems.require(tile.normals, 'normal', `${tile.name} has none`)) continue;
        for (let i = 0; tile.tangents && i < tile.count; ++i) {
            const [x, y, z, w] = tile.tangents.subarray(4 * i, 4 * i + 4), n = tile.normals.subarray(3 * i, 3 * i + 3);
            // Rounded, both lean by up to half a degree.
            problems.require(Math.abs(Math.hypot(x, y, z) - 1) < 1e-5 && w === 1 && x > 0
                    && Math.abs(x * n[0] + y * n[1] + z * n[2]) < (tile.direction_slack ? 0.02 : 1e-5),
                'tangent', () => `${tile.name}: vertex ${i} has ${[x, y, z, w]}`);
        }
        for (let i = 0; i < tile.count; ++i) {
            const [x, y, z] = tile.normals.subarray(3 * i, 3 * i + 3);
            problems.require(Math.abs(Math.hypot(x, y, z) - 1) < 1e-5 && y > 0, 'normal',
                () => `${tile.name}: vertex ${i} has ${[x, y, z]}`);
        }
    }
}

// The first and last texel centre lie on the tile's border.
function checkUvs(tile, texels, problems) {
    const {left, top, side} = tile.rectangle;
    for (let i = 0; i < tile.count; ++i) {
        const [u, v] = tile.uvs.subarray(2 * i, 2 * i + 2);
        const expected =
            [tile.columns[i] - left, tile.rows[i] - top].map((cells) => (0.5 + cells / side * (texels - 1)) / texels);
        const slack = 1e-6 + (tile.node.scale ? 0.5 / 65535 : 0);
        problems.require(u >= 0 && u <= 1 && v >= 0 && v <= 1 && Math.abs(u - expected[0]) < slack
                && Math.abs(v - expected[1]) < slack,
            'uv', () => `${tile.name}: vertex ${i} has (${u}, ${v}), not (${expected})`);
    }
    return {column: left, row: top, side};
}

function decodeTexture({json, bin}, tile, problems) {
    const material = json.materials[tile.primitive.material], normal = material.normalTexture,
          colour = material.pbrMetallicRoughness.baseColorTexture;
    problems.require(material.name === tile.name, 'texture', `${tile.name}: its material is called ${material.name}`);
    problems.require(Boolean(colour || normal || material.occlusionTexture) === Boolean(tile.uvs), 'texture',
        `${tile.name}: coordinates and texture do not go together`);
    problems.require(Boolean(normal) === Boolean(tile.tangents), 'texture',
        `${tile.name}: tangents and normal texture do not go together`);
    if (normal) {
        tile.normal_map = decodePng(viewBytes({json, bin}, json.images[json.textures[normal.index].source].bufferView));
        problems.require(normal.scale === undefined && normal.texCoord === undefined, 'texture',
            `${tile.name}: its normal texture is scaled or of another set of coordinates`);
    }
    const occlusion = material.occlusionTexture;
    if (occlusion) {
        const sky = decodePng(viewBytes({json, bin}, json.images[json.textures[occlusion.index].source].bufferView));
        let grey = true;
        for (let i = 0; i < sky.rgb.length; i += 3) grey &&= sky.rgb[i] === sky.rgb[i + 1] && sky.rgb[i] === sky.rgb[i + 2];
        problems.require(grey && sky.size[0] === sky.size[1] && occlusion.texCoord === undefined && Boolean(tile.uvs),
            'texture', `${tile.name}: its occlusion is coloured, not square or of another set of coordinates`);
    }
    if (!colour || !tile.uvs) return null;
    const texture = json.textures[colour.index], sampler = json.samplers[texture.sampler],
          image = json.images[texture.source];
    problems.require(
        sampler.wrapS === 33071 && sampler.wrapT === 33071, 'texture', `${tile.name}: not clamped to edge`);
    if (image.mimeType === 'image/jpeg') return null; // of which this checker has no decoder
    problems.require(
        image.mimeType === 'image/png' && image.uri === undefined, 'texture', `${tile.name}: not an embedded PNG`);
    const png = decodePng(viewBytes({json, bin}, image.bufferView));
    problems.require(png.size[0] === png.size[1], 'texture', `${tile.name}: ${png.size}`);
    return png;
}

// How far a texel may be from what was compressed to its block of 4 x 4: end points of 5 bits, and at most the block's
// own range (colour_tolerance of baker/verify_maps.h).
function blockTolerance(png, x, y) {
    const n = png.size[0], low = [255, 255, 255], high = [0, 0, 0];
    for (let i = 0; i < 16; ++i)
        for (let c = 0; c < 3; ++c) {
            const value = png.rgb[3 * (((y & ~3) + (i >> 2)) * n + (x & ~3) + (i & 3)) + c];
            low[c] = Math.min(low[c], value);
            high[c] = Math.max(high[c], value);
        }
    return 6 + Math.max(...high.map((value, c) => value - low[c]));
}

// Neighbours compress the same texels along their common border: no seam under clamp-to-edge.
function checkSeam(png, other, along, name, problems) {
    const n = png.size[0], texel = (image, x, y) => image.rgb.subarray(3 * (y * n + x), 3 * (y * n + x) + 3);
    for (let i = 0; i < n; ++i) {
        const [mine, theirs] = along === 'column' ? [texel(png, n - 1, i), texel(other, 0, i)] :
                                                    [texel(png, i, n - 1), texel(other, i, 0)];
        const allowed = along === 'column' ? blockTolerance(png, n - 1, i) + blockTolerance(other, 0, i) :
                                             blockTolerance(png, i, n - 1) + blockTolerance(other, i, 0);
        problems.require(mine.every((value, k) => Math.abs(value - theirs[k]) <= allowed), 'seam',
            () => `${name}: texel ${i} is ${mine} here, ${theirs} there`);
    }
}

export function checkTextures(glb, tiles, problems) {
    const placed = new Map();
    for (const tile of tiles) {
        const png = decodeTexture(glb, tile, problems);
        if (!png) continue;
        const corner = checkUvs(tile, png.size[0], problems);
        placed.set(`${corner.column / corner.side} ${corner.row / corner.side}`, {...corner, png, name: tile.name});
    }
    for (const {column, row, side, png, name} of placed.values()) {
        const east = placed.get(`${column / side + 1} ${row / side}`),
              south = placed.get(`${column / side} ${row / side + 1}`);
        if (east) checkSeam(png, east.png, 'column', name, problems);
        if (south) checkSeam(png, south.png, 'row', name, problems);
    }
    return {textures: placed.size, texture_px: placed.size ? placed.values().next().value.png.size[0] : 0};
}
