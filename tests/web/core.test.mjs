// The package `fjell` in node, as npm has installed it from its file. FJELL_PACK, FJELL_GOLDEN (what flight.cpp prints),
// FJELL_VERSION and FJELL_FILE say with what.
import assert from "node:assert/strict";
import { readFile, stat } from "node:fs/promises";
import test from "node:test";

import { heightsOfTile, makeView, mesh, ready, Terrain, version } from "fjell";
import validator from "gltf-validator";

import { fly } from "./flight.mjs";
import { hills, measure } from "./surface.mjs";

const { FJELL_PACK, FJELL_GOLDEN, FJELL_VERSION, FJELL_FILE } = process.env;
const pack = await readFile(FJELL_PACK);
const view = (terrain, more) => makeView({ eye: [terrain.extent[0] / 2, terrain.heightRange[1] + 500, terrain.extent[1] * 0.9],
  forward: [0, -0.4, -1], width: 1280, height: 720, ...more });

test("the package has the library's version, and less than 400 KB", async () => {
  assert.equal(version, FJELL_VERSION);
  assert.ok(FJELL_FILE.endsWith(`fjell-${version}.tgz`));
  assert.ok((await stat(FJELL_FILE)).size < 400_000);
});

test("a mesh of any size is nowhere farther from the heights than it says", async () => {
  for (const [width, height] of [[2, 2], [3, 2], [2, 9], [65, 65], [130, 71], [257, 300]])
    for (const maxError of [0, 0.5, 8]) {
      const heights = hills(width, height);
      const made = await mesh(heights, { width, height, maxError });
      const { worst, covered } = measure(heights, width, height, made.positions, made.triangles);
      assert.equal(covered, width * height);
      assert.ok(worst <= made.trueError + 1e-4, `${width} x ${height}: ${worst} and not ${made.trueError}`);
      assert.ok(made.trueError <= Math.max(maxError, 1e-5));
      if (maxError > 0) assert.ok(made.trueError > 0 || width * height < 10);
    }
});

test("holes stay open, and no ground is lost", async () => {
  const width = 100, height = 80, heights = hills(width, height);
  for (let z = 20; z < 30; ++z) heights.fill(NaN, z * width + 40, z * width + 61);
  const { positions, triangles } = await mesh(heights, { width, height, maxError: 5 });
  const { worst, covered } = measure(heights, width, height, positions, triangles);
  assert.ok(worst <= 5, "NaN would be neither");
  assert.equal(covered, width * height - 10 * 21);
});

function same(one, other) { // a difference of arrays would be printed number by number
  for (const part of ["positions", "triangles"]) assert.equal(Buffer.compare(Buffer.from(one[part].buffer), Buffer.from(other[part].buffer)), 0, part);
  assert.equal(one.trueError, other.trueError);
}

test("types, spacing and SIMD do not change what is meshed", async () => {
  const width = 90, height = 60, heights = hills(width, height).map((h) => Math.round(h) + 0);
  const made = await mesh(heights, { width, height, maxError: 2 });
  same(await mesh(Int16Array.from(heights), { width, height, maxError: 2 }), made);
  same(await mesh(Array.from(heights), { width, height, maxError: 2 }), made);
  const wide = await mesh(heights, { width, height, maxError: 2, spacing: [30, 20] });
  same({ ...wide, positions: wide.positions.map((p, i) => p / [30, 1, 20][i % 3]) }, made);
  const scalar = await ready({ wasm: await readFile(new URL(import.meta.resolve("fjell/fjell-scalar.wasm"))) });
  same(scalar.mesh(heights, { width, height, maxError: 2 }), made);
});

test("what is no mesh is an error that begins with the argument's name", async () => {
  const ten = new Float32Array(100);
  const refused = async (name, heights, options) => {
    await assert.rejects(mesh(heights, options), (error) => error.message.startsWith(name + ":"), `${name}`);
  };
  await refused("heights", new Float32Array(0), { width: 2, height: 2 });
  await refused("heights", ten.map(() => NaN), { width: 10, height: 10 });
  await refused("heights", ten.map((_, i) => (i === 50 ? Infinity : 0)), { width: 10, height: 10 });
  await refused("heights", ten, { width: 10, height: 11 });
  await refused("heights", new Int8Array(1e8), { width: 1e4, height: 1e4 });
  await refused("heights", "hills", { width: 10, height: 10 });
  await refused("heights", null, { width: 10, height: 10 });
  await refused("width", ten, { width: 1, height: 100 });
  await refused("height", ten, { width: 100, height: 1 });
  await refused("width", ten, { width: 0.5, height: 200 });
  await refused("width", ten, undefined);
  for (const maxError of [-1, NaN, Infinity, "1 m"]) await refused("maxError", ten, { width: 10, height: 10, maxError });
  for (const spacing of [0, [1, -1], NaN, "wide", [1]]) await refused("spacing", ten, { width: 10, height: 10, spacing });
  assert.equal((await mesh(ten, { width: 10, height: 10 })).triangles.length, 6, "a refusal leaves nothing behind");
});

test("tiles of maps are heights", () => {
  assert.deepEqual([...heightsOfTile([128, 0, 0, 255, 128, 1, 128, 255, 0, 0, 0, 0])], [0, 1.5, NaN]);
  const [low, high] = heightsOfTile(Uint8ClampedArray.of(0, 0, 0, 255, 1, 134, 160, 255), "mapbox");
  assert.ok(low === -10000 && Math.abs(high) < 1e-3);
  assert.throws(() => heightsOfTile([1, 2, 3]), /^RangeError: rgba/);
  assert.throws(() => heightsOfTile([1, 2, 3, 4], "png"), /^RangeError: encoding/);
});

test("a refusal frees what the call has taken", async () => {
  const held = async () => {
    for (let i = 0; i < 5; ++i) { // what a promise holds goes one turn later
      globalThis.gc();
      await new Promise((resolve) => setTimeout(resolve, 1));
    }
    return process.memoryUsage().external;
  };
  await mesh(new Float32Array(4), { width: 2, height: 2 });
  const before = await held();
  await assert.rejects(mesh(new Float32Array(2048 * 2048).fill(NaN), { width: 2048, height: 2048 }), /^Error: heights/);
  const after = await held();
  assert.ok(after - before < 8e6, `${after - before} bytes are held`);
});

test("the golden flight is that of the library, to the bit, with SIMD and without", async () => {
  assert.match(FJELL_GOLDEN, /^[0-9a-f]{8} [0-9a-f]{8}$/);
  assert.equal(await fly(Terrain, pack), FJELL_GOLDEN);
  const scalar = await WebAssembly.compile(await readFile(new URL(import.meta.resolve("fjell/fjell-scalar.wasm"))));
  assert.equal(await fly(Terrain, pack, scalar), FJELL_GOLDEN);
});

test("a streamed terrain comes to rest within its threshold, and says what it draws", async () => {
  const terrain = await Terrain.open(pack);
  const frame = await terrain.settle([view(terrain)]);
  assert.ok(frame.converged && frame.settled && frame.complete);
  assert.ok(frame.errorBound <= 1 && frame.threshold === 1);
  let drawn = 0;
  for (let i = 0; i < frame.rangeCount; ++i) drawn += frame.ranges[2 * i + 1] / 3;
  assert.equal(drawn, frame.trianglesDrawn);
  assert.equal(terrain.failure, null);
  assert.deepEqual(terrain.shortOf, []);
  terrain.settings.maxError = 4;
  assert.ok((await terrain.settle([view(terrain)])).triangles < drawn / 2);
  terrain.close();
  assert.throws(() => terrain.update([view(terrain)]), /closed/);
});

test("a flight keeps the heap and the budget of each frame, and comes to rest as if it had begun there", async () => {
  assert.ok(globalThis.gc, "run node with --expose-gc");
  const terrain = await Terrain.open(pack);
  const moving = view(terrain), views = [moving], arrays = [terrain.indexSlots, terrain.vertexSlots];
  Object.assign(terrain.settings, { maxError: 2, maxWork: 4000, morph: "time" });
  let now = 0;
  const fly = (frames) => {
    for (let i = 0; i < frames; ++i) {
      now += 1 / 60;
      moving.eye[0] = terrain.extent[0] * (0.5 + 0.4 * Math.sin(now / 9));
      moving.eye[2] = terrain.extent[1] * (0.5 + 0.4 * Math.cos(now / 7));
      const { work, triangles } = terrain.update(views, now);
      assert.ok(work <= 4000 + 256, `${work} items`); // a build's last step may take 256 more
      assert.ok(triangles <= terrain.budget.triangles);
      terrain.takeChanges();
    }
  };
  const minute = () => {
    fly(3600);
    globalThis.gc();
    return process.memoryUsage();
  };
  const before = minute(); // when all is compiled that will be, or nearly: so the least of several
  const more = [minute(), minute(), minute()].map((after) => after.heapUsed - before.heapUsed);
  assert.ok(terrain.frame.activations + terrain.frame.deactivations > 0, "it flies");
  assert.ok(Math.min(...more) < 50_000, `${more} bytes more after one minute, two and three`);
  assert.ok(process.memoryUsage().arrayBuffers <= before.arrayBuffers);
  assert.ok(arrays.every((array) => array.length > 0), "the memory has not grown");
  assert.equal(terrain.indexSlots.buffer, arrays[0].buffer);
  const rested = await terrain.settle(views, now), there = await Terrain.open(pack);
  Object.assign(there.settings, terrain.settings);
  assert.ok(rested.converged);
  assert.equal(rested.triangles, (await there.settle(views, now)).triangles);
  there.settings.maxError = 1;
  assert.ok((await there.settle(views)).converged, "by the real clock too");
  terrain.close();
});

test("budgets hold: what does not fit is named, and the threshold rises", async () => {
  const terrain = await Terrain.open(pack, { vertices: 3000, triangles: 6000 });
  terrain.settings.maxError = 0.5;
  const frame = await terrain.settle([view(terrain)]);
  assert.ok(frame.vertices <= 3000 && frame.triangles <= 6000);
  assert.ok(frame.threshold > 0.5 && !frame.converged);
  assert.ok(terrain.shortOf.some((name) => name === "vertices" || name === "triangles"));
  const refused = (options, message) => assert.rejects(Terrain.open(pack, options), message);
  await refused({ vertices: 1.5 }, /^RangeError: vertices/);
  await refused({ vertex: 15 }, /^TypeError: vertex/);
  await refused({ triangles: 2 }, /CutBudget::triangles|budget/);
});

test("heights, rays and the mesh agree", async () => {
  const terrain = await Terrain.open(pack, { whole: true });
  const [wide, deep] = terrain.extent;
  for (let i = 1; i < 50; ++i) {
    const x = wide * i / 51, z = deep * ((i * 37) % 50) / 51, height = terrain.height(x, z);
    assert.ok(height >= terrain.heightRange[0] && height <= terrain.heightRange[1]);
    const hit = terrain.ray([x, 9000, z], [0, -1, 0]);
    assert.ok(Math.abs(hit.position[1] - height) < 1e-6 && Math.abs(hit.distance - (9000 - height)) < 1e-6);
    const { normal, error } = terrain.ground(x, z);
    assert.ok(Math.abs(Math.hypot(...normal) - 1) < 1e-9 && error >= 0);
  }
  assert.ok(Number.isNaN(terrain.height(-1, 0)));
  assert.equal(terrain.ground(0, deep + 1), null);
  assert.equal(terrain.ray([0, 9000, 0], [0, 1, 0]), null);
  assert.equal(terrain.ray([wide / 2, 9000, deep / 2], [0, -1, 0], 100), null);
});

test("an edit changes the ground, and is refused without room for it", async () => {
  const terrain = await Terrain.open(pack, { editBlocks: 256 });
  const middle = terrain.extent.map((side) => side / 2), views = [view(terrain, { maxError: 0.1 })];
  await terrain.settle(views);
  const before = terrain.height(...middle);
  terrain.edit({ shape: "raise", at: middle, radius: 300, falloff: 600, amount: 100 });
  await terrain.settle(views);
  assert.ok(Math.abs(terrain.height(...middle) - before - 100) <= terrain.quantum);
  assert.throws(() => terrain.edit({ shape: "raise", at: middle, amount: 100 }), /edit: a number/);
  assert.throws(() => terrain.edit({ shape: "path", at: middle, radius: 1 }), /shape/);
  const hole = terrain.edit({ shape: "hole", at: middle, radius: 200 });
  assert.equal(terrain.editState(hole).state, "waiting");
  await terrain.settle(views);
  assert.deepEqual(terrain.editState(hole), { state: "applied", why: "" });
  assert.ok(Number.isNaN(terrain.height(...middle)));
  assert.equal(terrain.ray([middle[0], 9000, middle[1]], [0, -1, 0]), null);
  terrain.edit({ shape: "fill", at: middle, radius: 400 });
  await terrain.settle(views);
  assert.ok(Number.isFinite(terrain.height(...middle)));
  const wall = terrain.edit({ shape: "raise", at: middle, radius: 200, amount: 60_000 });
  await terrain.settle(views);
  const { state, why } = terrain.editState(wall);
  assert.equal(state, "refused");
  assert.match(why, /^Stamp /);
  assert.equal(terrain.editState(wall + 1).state, "unknown");
  const fixed = await Terrain.open(pack);
  assert.equal(fixed.editState(1).state, "unknown");
  assert.throws(() => fixed.edit({ shape: "raise", at: middle, radius: 1 }), /editBlocks/);
});

test("a snapshot is valid glTF, with the triangles of the frame", async () => {
  const terrain = await Terrain.open(pack), seen = view(terrain);
  terrain.settings.maxError = 3;
  await terrain.settle([seen]);
  const file = terrain.snapshot(seen);
  const report = await validator.validateBytes(file);
  assert.deepEqual(report.issues.messages.filter(({ severity }) => severity < 2), []);
  const text = new TextDecoder().decode(file.subarray(20, 20 + new DataView(file.buffer).getUint32(12, true)));
  const { scenes: [{ extras: { fjell } }], nodes, meshes, accessors, bufferViews } = JSON.parse(text);
  assert.deepEqual(nodes.map(({ name }) => name).sort().slice(0, 2), ["tile 0 0", "tile 0 1"]);
  const start = 28 + new DataView(file.buffer).getUint32(12, true), body = file.slice(start).buffer;
  for (const { primitives: [{ attributes: { POSITION }, indices }] } of meshes) {
    const part = (i, Type, width) => new Type(body, bufferViews[accessors[i].bufferView].byteOffset, width * accessors[i].count);
    const p = part(POSITION, Float32Array, 3), t = part(indices, Uint32Array, 1);
    for (let i = 0; i < t.length; i += 3) {
      const [a, b, c] = [t[i], t[i + 1], t[i + 2]].map((v) => [p[3 * v], p[3 * v + 2]]);
      assert.ok((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]) < 0, "counter-clockwise from above, and no line");
    }
  }
  assert.equal(fjell.triangles, terrain.frame.trianglesDrawn);
  assert.ok(fjell.converged && fjell.error_px_effective <= 3);
});

test("what is no pack is refused, and a damaged page leaves coarser ground", async () => {
  await assert.rejects(Terrain.open(new Uint8Array(100)), /ends too early/);
  await assert.rejects(Terrain.open(new Uint8Array(4096)), /not a Fjell pack/);
  await assert.rejects(Terrain.open(pack.subarray(0, pack.length / 2)), /ends too early|damaged/);
  await assert.rejects(Terrain.open(7), /^TypeError: source/);
  const damaged = Uint8Array.from(pack);
  damaged.fill(0, 100_000, 140_000);
  const terrain = await Terrain.open(damaged);
  terrain.settings.maxError = 0.2;
  const frame = await terrain.settle([view(terrain)]);
  assert.ok(frame.failed > 0 && !frame.converged && frame.settled);
  assert.match(terrain.failure.message, /damaged/);
});
