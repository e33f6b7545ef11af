// Can the checker fail? Each way to spoil a good snapshot must be found, and named rightly.
//   node selftest.mjs FILE.glb --heights RAW COLUMNS ROWS
import fs from 'node:fs';

import {check, parseArguments} from './check.mjs';
import {parseGlb, place, writeGlb} from './glb.mjs';

const primitiveOf = (glb, mesh) => glb.json.meshes[mesh].primitives[0];
const fjell = (glb) => glb.json.scenes[0].extras.fjell;

function moveFloat(glb, accessor, i, k, change) {
    const at = place(glb, accessor, i, k);
    glb.bin.writeFloatLE(change(glb.bin.readFloatLE(at)), at);
}

// A vertex of a mesh's tile that is (or is not) on the tile's border.
function findVertex(glb, mesh, border) {
    const index = primitiveOf(glb, mesh).attributes.POSITION, {count, min, max} = glb.json.accessors[index];
    for (let i = 0; i < count; ++i) {
        const [x, z] = [0, 2].map((k) => glb.bin.readFloatLE(place(glb, index, i, k)));
        const inside = x > min[0] && x < max[0] && z > min[2] && z < max[2];
        if (border ? x === max[0] && z > min[2] && z < max[2] : inside) return [index, i];
    }
    throw new Error('the snapshot is too coarse for this test: ask for a smaller error_px');
}

function indexPlaces(glb, mesh, triangle) {
    const index = primitiveOf(glb, mesh).indices, narrow = glb.json.accessors[index].componentType === 5123;
    return [0, 1, 2].map((k) => {
        const at = place(glb, index, 3 * triangle + k, 0);
        return {
            get: () => (narrow ? glb.bin.readUInt16LE(at) : glb.bin.readUInt32LE(at)),
            set: (value) => (narrow ? glb.bin.writeUInt16LE(value, at) : glb.bin.writeUInt32LE(value, at)),
        };
    });
}

const moveBorder = (glb, axis, change) => moveFloat(glb, ...findVertex(glb, 0, true), axis, change);
const dropTriangle = (glb) => { glb.json.accessors[primitiveOf(glb, 0).indices].count -= 3; };
const shiftTile = (glb, cells) => { glb.json.nodes[0].translation[0] += cells * fjell(glb).spacing_m[0]; };

// name: [kind of problem that must be among those reported, how to spoil]
const spoils = {
    'a raised vertex': ['error', (glb) => moveFloat(glb, ...findVertex(glb, 0, false), 1, (y) => y + 500)],
    'a border vertex raised in one tile': ['crack', (glb) => moveBorder(glb, 1, (y) => y + 1)],
    'a border vertex one float away': ['crack', (glb) => moveBorder(glb, 2, (z) => z * (1 + 2 ** -23))],
    'a flipped triangle': ['down', (glb) => {
        const [, b, c] = indexPlaces(glb, 0, 0), was = b.get();
        b.set(c.get());
        c.set(was);
    }],
    'a flipped triangle breaks the manifold': ['manifold', (glb) => spoils['a flipped triangle'][1](glb)],
    'a collapsed triangle': ['degenerate', (glb) => {
        const [a, b] = indexPlaces(glb, 0, 0);
        b.set(a.get());
    }],
    'a missing triangle': ['cover', dropTriangle],
    'a missing triangle leaves a hole': ['manifold', dropTriangle],
    'a missing tile': ['counts', (glb) => { glb.json.scenes[0].nodes.shift(); }],
    'a tile in the wrong place': ['manifold', (glb) => shiftTile(glb, 1)],
    'a tile between samples': ['place', (glb) => shiftTile(glb, 1 / 3)],
    'a shared material': ['place', (glb) => { primitiveOf(glb, 1).material = primitiveOf(glb, 0).material; }],
    'wrong bounds': ['accessor', (glb) => { glb.json.accessors[primitiveOf(glb, 0).attributes.POSITION].max[1] += 1; }],
    'a short normal': ['normal', (glb) => moveFloat(glb, primitiveOf(glb, 0).attributes.NORMAL, 0, 1, () => 0)],
    'a texture coordinate outside':
        ['uv', (glb) => moveFloat(glb, primitiveOf(glb, 0).attributes.TEXCOORD_0, 0, 0, () => 1.5)],
    'another tile\'s texture': ['seam', (glb) => { glb.json.textures[0].source = glb.json.images.length - 1; }],
    'a smaller threshold claimed': ['error', (glb) => { fjell(glb).error_px_effective = fjell(glb).error_px /= 50; }],
    'a convergence claimed': ['extras', (glb) => { fjell(glb).error_px_effective *= 2; }],
    'a short tangent': ['tangent', (glb) => moveFloat(glb, primitiveOf(glb, 0).attributes.TANGENT, 0, 0, () => 0.5)],
    'a normal texture of another kind': ['shading', (glb) => {
        glb.json.materials.forEach((m) => { m.normalTexture.index = m.pbrMetallicRoughness.baseColorTexture.index; });
    }],
    'a field missing': ['extras', (glb) => { delete fjell(glb).crs; }],
    'a field of the wrong type': ['extras', (glb) => { fjell(glb).converged = 'yes'; }],
    'a wrong count': ['counts', (glb) => { fjell(glb).triangles += 1; }],
    'a camera elsewhere': ['camera', (glb) => { fjell(glb).eye[0] += 1; }],
    'a cut file': ['container', null],
};

function main(words) {
    const {paths: [path], options} = parseArguments(words), file = fs.readFileSync(path);
    const clean = check(file, options).problems;
    if (!clean.empty()) console.log(`the snapshot itself is not clean:\n${clean.lines().join('\n')}`);
    let missed = clean.empty() ? 0 : 1;
    for (const [name, [kind, spoil]] of Object.entries(spoils)) {
        let spoiled = file.subarray(0, file.length - 4);
        if (spoil) {
            const glb = parseGlb(Buffer.from(file));
            spoil(glb);
            spoiled = writeGlb(glb);
        }
        const kinds = check(spoiled, options).problems.kinds();
        if (kinds.includes(kind)) continue;
        ++missed;
        console.log(
            `not noticed: ${name} should be reported as ${kind}, but the report has ${kinds.join(', ') || 'nothing'}`);
    }
    console.log(`${Object.keys(spoils).length} ways to spoil a snapshot, ${missed} missed`);
    return missed ? 1 : 0;
}

process.exitCode = main(process.argv.slice(2));
