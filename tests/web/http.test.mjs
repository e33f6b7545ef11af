// Packs over HTTP: ranges, and servers that are slow, dead, wrong or changed. On the loopback.
import assert from "node:assert/strict";
import { copyFile, cp, mkdtemp, readFile, rm, stat, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test, { after, before } from "node:test";

import { makeView, Terrain } from "fjell";
import { HttpSource, SetSource } from "fjell/loader";

import { serve } from "./serve.mjs";

const pack = await readFile(process.env.FJELL_PACK);
const fast = { firstPauseMs: 1, longestPauseMs: 20, tries: 1000 };
let folder, server, url, fault = () => false, asked = 0, sent = 0;

before(async () => {
  folder = await mkdtemp(join(tmpdir(), "fjell-"));
  await copyFile(process.env.FJELL_PACK, join(folder, "m.fjell"));
  await cp(process.env.FJELL_SET, join(folder, "set"), { recursive: true }); // the pack, split into four
  server = await serve(folder, 0, (request, response) => {
    ++asked;
    const range = /bytes=(\d+)-(\d+)/.exec(request.headers.range ?? "");
    if (range) sent += range[2] - range[1] + 1;
    return fault(request, response);
  });
  url = `http://127.0.0.1:${server.address().port}/m.fjell`;
});
after(async () => {
  server.close();
  server.closeAllConnections();
  await rm(folder, { recursive: true });
});

const view = (terrain, more) => makeView({ eye: [terrain.extent[0] / 2, terrain.heightRange[1] + 500, terrain.extent[1] * 0.9],
  forward: [0, -0.4, -1], width: 1280, height: 720, ...more });

async function shown(terrain, maxError = 1) {
  terrain.settings.maxError = maxError;
  const { triangles, converged } = await terrain.settle([view(terrain)]);
  return { triangles, converged };
}
const wanted = await shown(await Terrain.open(pack));

test("ranges give the mesh that the whole file gives, and read less", async () => {
  asked = sent = 0;
  let told = 0;
  const terrain = await Terrain.open(url, { source: { onProgress: (bytes) => { told = bytes; } } });
  assert.ok((await shown(terrain, 8)).converged);
  assert.ok(sent < pack.length / 3, `${sent} of ${pack.length} bytes`);
  assert.deepEqual(await shown(terrain), wanted);
  assert.ok(asked > 10 && told > terrain.frame.bytesRead && told <= sent);
  terrain.close();
});

test("a server that fails now and then, is slow, or cuts answers short is asked again", async () => {
  let n = 0, problems = 0;
  fault = async (request, response) => {
    switch (++n % 5) {
      case 0: response.writeHead(503).end(); return true;
      case 1: response.destroy(); return true;
      case 2: await new Promise((resolve) => setTimeout(resolve, 5)); return false;
      case 3: response.writeHead(206, { "content-range": `bytes 0-9/${pack.length}`, "content-length": 10, etag: (await tag()) }).end(pack.subarray(0, 10)); return true;
      default: return false;
    }
  };
  const terrain = await Terrain.open(url, { source: { ...fast, onProblem: () => ++problems } });
  assert.deepEqual(await shown(terrain), wanted);
  assert.ok(problems > 5);
  assert.equal(terrain.failure, null);
  terrain.close();
  fault = () => false;
});
async function tag() {
  const found = await stat(join(folder, "m.fjell"));
  return `"${found.size}-${found.mtimeMs}"`;
}

test("a server that is killed and restarted goes on where it was", async () => {
  const terrain = await Terrain.open(url, { source: fast });
  await shown(terrain, 16);
  const port = server.address().port;
  await new Promise((resolve) => { server.close(resolve); server.closeAllConnections(); });
  terrain.settings.maxError = 1;
  let problems = 0;
  for (; problems < 200 && terrain.frame.inFlight === 0; ++problems) terrain.update([view(terrain)], problems / 60);
  assert.ok(terrain.frame.inFlight > 0 && !terrain.frame.converged, "it asks a server that is not there");
  server = await serve(folder, port, (request, response) => fault(request, response));
  assert.deepEqual(await shown(terrain), wanted);
  terrain.close();
});

test("a server without ranges, a file that is not there, and a server that never answers are one sentence", async () => {
  fault = (request, response) => {
    response.writeHead(200, { "content-length": pack.length }).end(pack);
    return true;
  };
  await assert.rejects(Terrain.open(url), /sends whole files, not ranges/);
  fault = () => false;
  await assert.rejects(Terrain.open(url.replace("m.fjell", "n.fjell")), /404/);
  await assert.rejects(Terrain.open("http://127.0.0.1:9/m.fjell", { source: { ...fast, tries: 3 } }), /./);
});

test("wrong bytes leave coarser ground, which retry() asks for again", async () => {
  const terrain = await Terrain.open(url, { source: fast });
  fault = (request, response) => {
    const [, start, end] = /bytes=(\d+)-(\d+)/.exec(request.headers.range).map(Number);
    tag().then((etag) => response.writeHead(206, { "content-range": `bytes ${start}-${end}/${pack.length}`, etag }).end(Buffer.alloc(end - start + 1)));
    return true;
  };
  const { converged } = await shown(terrain);
  assert.ok(!converged && terrain.frame.failed > 0);
  assert.match(terrain.failure.message, /damaged/);
  fault = () => false;
  terrain.retry();
  assert.deepEqual(await shown(terrain), wanted);
  terrain.close();
});

test("a file that is replaced while it is open is an error, and what is there stays", async () => {
  const terrain = await Terrain.open(url, { source: fast });
  const { triangles } = await shown(terrain, 16);
  await writeFile(join(folder, "m.fjell"), pack.subarray(0, pack.length - 1));
  await shown(terrain);
  assert.match(terrain.failure.message, /was replaced/);
  assert.ok(terrain.frame.triangles >= triangles / 2 && terrain.frame.settled);
  await copyFile(process.env.FJELL_PACK, join(folder, "m.fjell"));
  terrain.close();
});

test("what is not wanted any more is not waited for", async () => {
  const source = new HttpSource(url, fast);
  const size = await source.size();
  assert.equal(size, pack.length);
  fault = () => true; // never answers
  const abort = new AbortController();
  const reading = source.read(0, 100, abort.signal);
  abort.abort();
  await assert.rejects(reading);
  fault = () => false;
});

test("a view that turns up elsewhere cancels what it had asked for, and is served at once", async () => {
  let stuck = 0, dropped = 0;
  const terrain = await Terrain.open(url, { source: { ...fast, timeoutMs: 400 } }); // for what both views want
  await shown(terrain, 64);
  fault = (request, response) => { // never answers
    ++stuck;
    response.on("close", () => ++dropped);
    return true;
  };
  const [wide, deep] = terrain.extent, over = (x, z) => [makeView({ eye: [x * wide, 2600, z * deep], target: [x * wide, 0, z * deep - 1], width: 200, height: 200 })];
  const soon = () => new Promise((resolve) => setImmediate(resolve));
  terrain.settings.maxError = 0.5;
  while (stuck < 6) {
    terrain.update(over(0.1, 0.1));
    await soon();
  }
  fault = () => false;
  const frame = await terrain.settle(over(0.9, 0.9));
  assert.ok(frame.converged && frame.inFlight === 0, "the new view does not wait for the old one's pages");
  while (dropped < stuck) await soon();
  assert.equal(terrain.failure, null, "what is not wanted is no failure");
  terrain.close();
});

test("a pack set is one terrain: over HTTP its mesh and its heights are the pack's", async () => {
  const set = url.replace("m.fjell", "set/set.json"), whole = await Terrain.open(pack);
  let told = 0;
  const terrain = await Terrain.open(set, { source: { onProgress: (bytes) => { told = bytes; } } });
  assert.deepEqual([terrain.columns, terrain.rows, terrain.pages, terrain.heightRange], [whole.columns, whole.rows, whole.pages, whole.heightRange]);
  assert.deepEqual(await shown(terrain), wanted);
  await shown(whole);
  for (let i = 1; i < 20; ++i) {
    const at = [terrain.extent[0] * i / 20, terrain.extent[1] * ((7 * i) % 20) / 20];
    assert.equal(terrain.height(...at), whole.height(...at));
  }
  assert.ok(told > terrain.frame.bytesRead, "bytes of all packs");
  terrain.close();
});

test("a set that lacks a pack has no ground there, and the other tiles' maps are where they belong", async () => {
  const file = join(folder, "set", "set.json"), text = await readFile(file, "utf8"), json = JSON.parse(text);
  const gone = json.packs.shift();
  await writeFile(file, JSON.stringify(json));
  const terrain = await Terrain.open(url.replace("m.fjell", "set/set.json"), { maps: true }), whole = await Terrain.open(pack, { maps: true });
  const mapsOf = async (of) => {
    const sums = new Map();
    for (let i = 0; i < 2000; ++i) {
      const { settled } = of.update([view(of)], i / 60);
      of.takeMaps((kind, tile, mip, side, rgba) => { if (kind === "colour" && mip === 0) sums.set(tile, rgba.reduce((a, b) => a + b, 0)); });
      if (settled && of.frame.inFlight === 0 && of.frame.converged) break;
      await new Promise((resolve) => setTimeout(resolve, 1));
    }
    return sums;
  };
  const [sparse, full] = [await mapsOf(terrain), await mapsOf(whole)], [across] = whole.tiles;
  assert.ok(terrain.frame.converged && sparse.size > 0 && sparse.size < full.size);
  for (const [tile, sum] of sparse) {
    assert.equal(sum, full.get(tile), `tile ${tile}`);
    assert.ok(tile % across < gone.tile_x || tile % across >= gone.tile_x + gone.tiles_x || Math.floor(tile / across) >= gone.tile_y + gone.tiles_y || Math.floor(tile / across) < gone.tile_y);
  }
  const cell = whole.tileCells * whole.spacing[0], middle = [(gone.tile_x + 0.5) * cell, (gone.tile_y + 0.5) * cell];
  assert.ok(Number.isNaN(terrain.height(...middle)) && whole.height(...middle) > 0);
  await writeFile(file, text);
  terrain.close();
});

test("a set with a wrong index, or with a pack that is missing, cut short or another one, is one sentence that names it", async () => {
  const set = url.replace("m.fjell", "set/set.json"), file = join(folder, "set", "set.json"), text = await readFile(file, "utf8");
  const refused = async (change, message) => {
    const json = JSON.parse(text);
    await writeFile(file, typeof change === "string" ? change : JSON.stringify(change(json) ?? json));
    await assert.rejects(Terrain.open(set, { source: fast }), message);
  };
  const index = /set\.json: is no index of a pack set/;
  await refused("{", index);
  await refused("[]", index);
  await refused((json) => { json.packs[0].tile_x = -1; }, index);
  await refused((json) => { json.packs = []; }, index);
  await refused((json) => { json.packs[1].file = "../m.fjell"; }, /lies in another folder/);
  await refused((json) => { json.packs[1].file = "gone.fjell"; }, /gone\.fjell: 404/);
  await refused((json) => { json.packs[1].pack_hash = "0123456789abcdef"; }, /another pack \(pack_hash\)/);
  await refused((json) => { json.packs[1].tiles_x += 1; }, /other numbers of tiles/);
  await refused((json) => { json.packs[1].tile_x = json.packs[0].tile_x; json.packs[1].tile_y = json.packs[0].tile_y; }, /\.fjell: .*one bake/);
  await refused((json) => { json.spacing_m = [61, 60]; }, /another spacing/);
  const last = join(folder, "set", JSON.parse(text).packs[2].file), bytes = await readFile(last);
  await writeFile(last, bytes.subarray(0, bytes.length / 2));
  await refused(() => {}, /\.fjell: .*(ends too early|damaged)/);
  await writeFile(last, bytes);
  await writeFile(file, text);
  await assert.rejects(new SetSource(url.replace("m.fjell", "none/set.json"), fast).size(), /none\/set\.json: 404/);
  assert.deepEqual(await shown(await Terrain.open(set)), wanted);
});
