// The file's frame: what it says about itself, its tiles and its camera.
import {readAccessor} from './glb.mjs';

// Problems by kind: how many, and the first of each.
export class Problems {
    #kinds = new Map();
    add(kind, text) {
        const known = this.#kinds.get(kind);
        if (known)
            ++known.count;
        else
            this.#kinds.set(kind, {count: 1, first: text});
    }
    require(condition, kind, text) {
        if (!condition) this.add(kind, typeof text === 'function' ? text() : text);
        return condition;
    }
    kinds() { return [...this.#kinds.keys()]; }
    empty() { return this.#kinds.size === 0; }
    lines() {
        return [...this.#kinds].map(
            ([kind, {count, first}]) => `${kind}: ${first}${count > 1 ? ` (and ${count - 1} more)` : ''}`);
    }
}

const isNumber = (v) => typeof v === 'number' && Number.isFinite(v);
const isPositive = (v) => isNumber(v) && v > 0;
const isCount = (v) => Number.isInteger(v) && v > 0;
const list = (length, one) => (v) => Array.isArray(v) && v.length === length && v.every(one);
const isFlag = (v) => typeof v === 'boolean';

const fields = {
    error_px: isPositive,
    error_px_effective: isPositive,
    corner_safe: isFlag,
    quantum_m: isPositive,
    rounding_m: (v) => isNumber(v) && v >= 0,
    viewport: list(2, isCount),
    fov_y_deg: (v) => isPositive(v) && v < 180,
    eye: list(3, isNumber),
    spacing_m: list(2, isPositive),
    origin_m: list(2, isNumber),
    crs_origin: list(2, isNumber),
    crs_step: (v) => v === null || list(2, isPositive)(v),
    crs: (v) => v === null || (typeof v === 'string' && v.length > 0),
    size: list(2, (v) => isCount(v) && v >= 2),
    converged: isFlag,
    morphed: isFlag,
    lagging: isFlag,
    culled: isFlag,
    vertices: isCount,
    triangles: isCount,
    pack_hash: (v) => typeof v === 'string' && /^[0-9a-f]{16}$/.test(v),
};

export function checkExtras({json}, problems) {
    problems.require(
        json.asset?.version === '2.0' && /Fjell/.test(json.asset?.generator ?? ''), 'extras', 'asset is not ours');
    const extras = json.scenes?.[json.scene]?.extras?.fjell ?? {};
    problems.require(json.scene === 0, 'extras', 'the scene is not scenes[0]');
    for (const [name, holds] of Object.entries(fields))
        problems.require(
            name in extras && holds(extras[name]), 'extras', () => `${name} is ${JSON.stringify(extras[name])}`);
    for (const name of Object.keys(extras)) problems.require(name in fields, 'extras', `${name} is unknown`);
    problems.require(!extras.converged || extras.error_px_effective <= extras.error_px, 'extras',
        'converged, but not to what was asked for');
    problems.require(!extras.converged || !extras.lagging, 'extras', 'converged, and lagging');
    problems.require(extras.error_px_effective >= extras.error_px, 'extras', 'more is kept than was asked for');
    return extras;
}

function isLeaf(node) {
    return !node.children && !node.matrix && Array.isArray(node.translation)
        && node.translation.length === 3;
}

// Tiles with their vertices as samples: columns[], rows[], world positions x, y, z in doubles.
export function readTiles(glb, extras, problems) {
    const {json} = glb, tiles = [], materials = new Set(), meshes = new Set();
    for (const index of json.scenes[0].nodes) {
        const node = json.nodes[index];
        problems.require(isLeaf(node), 'place', `node ${index} is not a translated leaf`);
        if (node.camera !== undefined) continue;
        const primitives = json.meshes[node.mesh].primitives;
        problems.require(primitives.length === 1 && (primitives[0].mode ?? 4) === 4, 'place',
            `node ${index}: not one triangle list`);
        problems.require(!node.rotation, 'place', `node ${index} is rotated`);
        const rounded = (json.extensionsRequired ?? []).includes('KHR_mesh_quantization');
        problems.require(rounded === Boolean(node.scale), 'place', `node ${index} scales, or its places are not rounded`);
        materials.add(primitives[0].material);
        meshes.add(node.mesh);
        tiles.push(readTile(glb, node, primitives[0], extras, problems));
    }
    problems.require(materials.size === tiles.length && meshes.size === tiles.length && !materials.has(undefined),
        'place', `${tiles.length} tiles have ${materials.size} materials and ${meshes.size} meshes`);
    setRectangles(tiles, extras, problems);
    const sum = (key) => tiles.reduce((total, tile) => total + tile[key], 0);
    problems.require(
        sum('count') === extras.vertices, 'counts', `${sum('count')} vertices, extras say ${extras.vertices}`);
    problems.require(sum('triangles') === extras.triangles, 'counts',
        `${sum('triangles')} triangles, extras say ${extras.triangles}`);
    return tiles;
}

// The samples that each tile is to cover, from its name and its node's place.
function setRectangles(tiles, {size, spacing_m}, problems) {
    const corners = tiles.map(({name, node}) => {
        const number = /^tile (\d+) (\d+)$/.exec(name)?.slice(1).map(Number);
        problems.require(number, 'place', `${name} is no name of a tile`);
        return {number, at: [0, 2].map((axis) => Math.round(node.translation[axis] / spacing_m[axis / 2]))};
    });
    const apart = corners.flatMap(({number, at}) => [0, 1].filter((k) => number?.[k] > 0).map((k) => at[k] / number[k]));
    const side = apart[0] ?? 2 ** Math.ceil(Math.log2(Math.max(...size) - 1));
    problems.require(apart.every((one) => one === side), 'place', () => `tiles are ${apart} cells wide`);
    tiles.forEach((tile, i) => {
        const [left, top] = corners[i].at;
        tile.rectangle = {
            side, // cells, also where the terrain ends inside it
            left,
            top,
            right: Math.min(left + side, size[0] - 1),
            bottom: Math.min(top + side, size[1] - 1)
        };
    });
}

function readTile(glb, node, primitive, extras, problems) {
    const positions = readAccessor(glb, primitive.attributes.POSITION), {count, values, accessor} = positions;
    const indices = readAccessor(glb, primitive.indices).values;
    const read = (name) =>
        (primitive.attributes[name] === undefined ? null : readAccessor(glb, primitive.attributes[name]).values);
    const tile = {
        name: node.name,
        node,
        primitive,
        count,
        triangles: indices.length / 3,
        indices,
        local: values,
        normals: read('NORMAL'),
        uvs: read('TEXCOORD_0'),
        tangents: read('TANGENT'),
        columns: new Int32Array(count),
        rows: new Int32Array(count),
        x: new Float64Array(count),
        y: new Float64Array(count),
        z: new Float64Array(count)
    };
    unscale(tile);
    problems.require(
        Number.isInteger(tile.triangles) && indices.every((i) => i < count), 'accessor', `${node.name}: indices`);
    checkBounds(node.name, values, accessor, problems);
    const used = new Uint8Array(count);
    indices.forEach((i) => {
        used[i] = 1;
    });
    problems.require(!used.includes(0), 'accessor', `${node.name}: a vertex that no triangle uses`);
    for (let i = 0; i < count; ++i) placeVertex(tile, i, extras, problems);
    return tile;
}

// Directions as they are in the scene. direction_slack: what rounding may have moved a component of one as it is stored.
function unscale(tile) {
    const {scale} = tile.node, rounded = (values) => values?.some((v) => v * 32767 % 1 === 0 && v % 1 !== 0)
        && values.every((v) => Math.abs(v * 32767 - Math.round(v * 32767)) < 1e-6);
    tile.direction_slack = rounded(tile.normals) ? 0.5 / 32767 : 0;
    tile.stored_normals = tile.normals?.slice();
    for (const [values, width, power] of [[tile.normals, 3, -1], [tile.tangents, 4, 1]])
        for (let i = 0; scale && values && i < values.length; i += width) {
            for (let k = 0; k < 3; ++k) values[i + k] *= scale[k] ** power;
            const length = Math.hypot(...values.subarray(i, i + 3));
            for (let k = 0; k < 3; ++k) values[i + k] /= length;
        }
}

function checkBounds(name, values, accessor, problems) {
    for (let axis = 0; axis < 3; ++axis) {
        let low = Infinity, high = -Infinity;
        for (let i = axis; i < values.length; i += 3)
            [low, high] = [Math.min(low, values[i]), Math.max(high, values[i])];
        problems.require(accessor.min[axis] === low && accessor.max[axis] === high, 'accessor',
            () => `${name}: axis ${axis} spans ${low}..${high}, not ${accessor.min[axis]}..${accessor.max[axis]}`);
    }
}

// A position must be that of a sample; floats carry 24 bits, so the further out, the less exact.
function placeVertex(tile, i, {spacing_m, size}, problems) {
    const [tx, ty, tz] = tile.node.translation, [sx, sy, sz] = tile.node.scale ?? [1, 1, 1];
    tile.x[i] = tx + sx * tile.local[3 * i];
    tile.y[i] = ty + sy * tile.local[3 * i + 1];
    tile.z[i] = tz + sz * tile.local[3 * i + 2];
    const column = tile.x[i] / spacing_m[0], row = tile.z[i] / spacing_m[1];
    tile.columns[i] = Math.round(column);
    tile.rows[i] = Math.round(row);
    const slack = 1e-6 + Math.max(...size) * 2 ** -22;
    const inside = tile.columns[i] >= 0 && tile.rows[i] >= 0 && tile.columns[i] < size[0] && tile.rows[i] < size[1];
    problems.require(inside && Math.abs(column - tile.columns[i]) < slack && Math.abs(row - tile.rows[i]) < slack,
        'place', () => `${tile.name}: vertex ${i} at (${tile.x[i]}, ${tile.z[i]}) is not on a sample`);
}

// Rotates v by the unit quaternion (x, y, z, w).
function rotate([x, y, z, w], v) {
    const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
    return [
        v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2],
        v[2] + w * t[2] + x * t[1] - y * t[0]
    ];
}

export function checkCamera({json}, extras, axes, problems) {
    const nodes = json.scenes[0].nodes.map((i) => json.nodes[i]).filter((node) => node.camera !== undefined);
    if (!problems.require(nodes.length === 1 && json.cameras?.length === 1, 'camera', `${nodes.length} camera nodes`))
        return;
    const [node] = nodes, {type, perspective} = json.cameras[node.camera];
    extras.axes = [[1, 0, 0], [0, 1, 0], [0, 0, -1]].map((axis) => rotate(node.rotation, axis));
    problems.require(type === 'perspective', 'camera', `type ${type}`);
    problems.require(node.translation.every((v, i) => v === extras.eye[i]), 'camera', 'the camera is not at the eye');
    problems.require(
        Math.abs(perspective.yfov * 180 / Math.PI - extras.fov_y_deg) < 1e-9, 'camera', `yfov ${perspective.yfov}`);
    const aspect = extras.viewport[0] / extras.viewport[1];
    problems.require(Math.abs(perspective.aspectRatio - aspect) < 1e-9, 'camera', `aspect ${perspective.aspectRatio}`);
    problems.require(perspective.znear > 0 && perspective.znear < perspective.zfar, 'camera', 'near and far');
    problems.require(Math.abs(Math.hypot(...node.rotation) - 1) < 1e-9, 'camera', 'rotation is not unit length');
    const along = (axis, wanted, name) => {
        const scale = wanted ? Math.hypot(...wanted) : 1, is = rotate(node.rotation, axis);
        problems.require(
            !wanted || is.every((v, i) => Math.abs(v - wanted[i] / scale) < 1e-6), 'camera', `${name} is ${is}`);
    };
    along([0, 0, -1], axes.forward, 'forward');
    along([0, 1, 0], axes.up, 'up');
}
