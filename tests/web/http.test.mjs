// Packs over HTTP: ranges, and servers that are slow, dead, wrong or changed. On the loopback.
import assert from "node:assert/strict";
import { copyFile, mkdtemp, readFile, rm, stat, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test, { after, before } from "node:test";

import { makeView, Terrain } from "fjell";
import { HttpSource } from "fjell/loader";

import { serve } from "./serve.mjs";

const pack = await readFile(process.env.FJELL_PACK);
const fast = { firstPauseMs: 1, longestPauseMs: 20, tries: 1000 };
let folder, server, url, fault = () => false, asked = 0, sent = 0;

before(async () => {
  folder = await mkdtemp(join(tmpdir(), "fjell-"));
  await copyFile(process.env.FJELL_PACK, join(folder, "m.fjell"));
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
