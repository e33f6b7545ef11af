// What of the package needs neither WebAssembly nor other packages, from its sources: images, sources of bytes, and who
// replaces a worker.   node --test plain.test.mjs
import assert from "node:assert/strict";
import { createServer } from "node:http";
import test from "node:test";

import { CachedSource, HttpSource, WorkerSource } from "../../runtime/web/package/loader.js";
import { PmTiles, tileNumber } from "../../runtime/web/package/pmtiles.js";
import { texelsOf } from "../../runtime/web/package/tiles.js";
import { pmtiles, png } from "./images.mjs";

const random = (() => { let state = 7; return () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32; })();
const noise = (texels) => Uint8Array.from({ length: 4 * texels }, () => Math.floor(random() * 256));

test("a PNG is read to the bit, with every filter", async () => {
  for (const [width, height] of [[1, 1], [3, 7], [64, 33]])
    for (const channels of [3, 4])
      for (const filter of [0, 1, 2, 3, 4, undefined]) {
        const rgba = noise(width * height);
        if (channels === 3) for (let i = 3; i < rgba.length; i += 4) rgba[i] = 255;
        const made = await texelsOf(png(rgba, width, height, { channels, idat: 100, ...(filter !== undefined && { filter: () => filter }) }));
        assert.deepEqual([made.width, made.height], [width, height]);
        assert.equal(Buffer.compare(Buffer.from(made.rgba), Buffer.from(rgba)), 0, `${width} x ${height}, ${channels} channels, filter ${filter}`);
      }
});

test("a PNG that is cut or damaged anywhere is an error, and no other image is guessed at", async () => {
  const file = png(noise(256), 16, 16);
  for (let bytes = 8; bytes < file.length - 12; ++bytes) await assert.rejects(texelsOf(file.subarray(0, bytes)), /^Error: tile/, `${bytes} bytes`);
  for (let i = 8; i < file.length; i += 3) {
    const damaged = Uint8Array.from(file);
    damaged[i] ^= 0x55;
    await texelsOf(damaged).catch((error) => assert.match(error.message, /^tile/, `byte ${i}`));
  }
  for (const other of [{ kind: 3, channels: 1 }, { depth: 16 }, { interlaced: 1 }]) await assert.rejects(texelsOf(png(noise(256), 16, 16, other)), /tile: is no PNG of 8 bits/);
  await assert.rejects(texelsOf(new Uint8Array(0)), /tile: is no PNG/);
});

test("tiles of PMTiles are numbered along Hilbert's curve, zoom by zoom", async () => {
  assert.deepEqual([[0, 0, 0], [1, 0, 0], [1, 0, 1], [1, 1, 1], [1, 1, 0], [2, 0, 0]].map((at) => tileNumber(...at)), [0, 1, 2, 3, 4, 5]);
  for (let z = 1; z < 6; ++z) { // each is beside the one before, and none is left out
    const places = new Map();
    for (let x = 0; x < 2 ** z; ++x) for (let y = 0; y < 2 ** z; ++y) places.set(tileNumber(z, x, y) - (4 ** z - 1) / 3, [x, y]);
    for (let i = 1; i < 4 ** z; ++i) assert.equal(Math.abs(places.get(i)[0] - places.get(i - 1)[0]) + Math.abs(places.get(i)[1] - places.get(i - 1)[1]), 1, `${z} ${i}`);
  }
  const tiles = Array.from({ length: 50 }, (_, i) => [3 * i, Buffer.from([i])]), file = new PmTiles(pmtiles(tiles));
  for (let z = 0; z < 4; ++z)
    for (let x = 0; x < 2 ** z; ++x)
      for (let y = 0; y < 2 ** z; ++y) {
        const number = tileNumber(z, x, y), tile = await file.tile(z, x, y);
        assert.deepEqual(tile && [...tile], number % 3 === 0 && number < 150 ? [number / 3] : null);
      }
});

/** A server of 1,000 bytes that knows ranges; fault(request, response) answers first. */
async function served(fault, use) {
  const bytes = noise(250), server = createServer((request, response) => {
    if (fault(request, response)) return;
    const [, first, last] = /bytes=(\d+)-(\d+)/.exec(request.headers.range).map(Number), end = Math.min(last, 999);
    response.writeHead(206, { "content-range": `bytes ${first}-${end}/1000`, etag: '"a"' }).end(bytes.subarray(first, end + 1));
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  try {
    await use(`http://127.0.0.1:${server.address().port}/pack`, bytes);
  } finally {
    server.close();
    server.closeAllConnections();
  }
}

test("what fails is asked for again, later and later, until tries are spent", async (t) => {
  const pauses = [], wait = setTimeout;
  t.mock.method(globalThis, "setTimeout", (call, ms, ...more) => { // fetch() has timers of its own
    if (![100, 200, 400, 500].includes(ms)) return wait(call, ms, ...more);
    pauses.push(ms);
    return wait(call, 0);
  });
  let failing = 5;
  await served((request, response) => (failing-- > 0 ? (response.writeHead(503).end(), true) : false), async (url, bytes) => {
    const said = [], source = new HttpSource(url, { tries: 8, firstPauseMs: 100, longestPauseMs: 500, onProblem: (error) => said.push(error.message) });
    assert.deepEqual(await source.read(10, 20), bytes.subarray(10, 30));
    assert.deepEqual(pauses, [100, 200, 400, 500, 500]);
    assert.equal(said.length, 5);
    failing = 0;
    let quiet = 2;
    const late = new HttpSource(url, { timeoutMs: 250, tries: 1000, firstPauseMs: 1, fetch: (at, options) => (quiet-- > 0 ? new Promise((_, reject) => options.signal.addEventListener("abort", () => reject(options.signal.reason))) : fetch(at, options)), onProblem: (error) => said.push(error.message) });
    assert.equal((await late.read(0, 10)).length, 10, "a server that does not answer is asked again");
    assert.match(said[5], /has not answered for 0\.25 s/);
    failing = 1000;
    await assert.rejects(new HttpSource(url, { tries: 3, firstPauseMs: 1 }).read(0, 1), /503/);
  });
});

test("a server that refuses, replaces or garbles is one sentence, and is asked once", async () => {
  let asked = 0, answer;
  await served((request, response) => { ++asked; return answer?.(response) ?? false; }, async (url) => {
    const refused = async (by, message, times = 1) => {
      const source = new HttpSource(url, { tries: 2, firstPauseMs: 1 });
      answer = undefined;
      assert.equal(await source.size(), 1000);
      asked = 0;
      answer = (response) => { by(response); return true; };
      await assert.rejects(source.read(0, 100), message);
      assert.equal(asked, times);
    };
    const part = (response, headers, length) => response.writeHead(206, { "content-range": "bytes 0-99/1000", etag: '"a"', ...headers }).end(Buffer.alloc(length));
    await refused((response) => response.writeHead(200).end("x".repeat(1000)), /sends whole files, not ranges/);
    await refused((response) => response.writeHead(403).end(), /403/);
    await refused((response) => response.writeHead(416).end(), /was replaced/);
    await refused((response) => part(response, { etag: '"b"' }, 100), /was replaced while it was open/);
    await refused((response) => part(response, { "content-range": "bytes 0-99/2000" }, 100), /was replaced while it was open/);
    await refused((response) => part(response, {}, 99), /99 bytes came instead of 100/, 2);
    await refused((response) => part(response, {}, 101), /101 bytes came instead of 100/, 2);
    answer = (response) => { response.writeHead(206, { etag: '"a"' }).end(Buffer.alloc(100)); return true; };
    await assert.rejects(new HttpSource(url).size(), /does not say how long the file is/);
  });
});

test("what is kept is not asked for again, and a disk that is full or a cache that lies does no harm", async (t) => {
  const kept = new Map();
  let full = false;
  globalThis.caches = { open: async () => ({ match: async (key) => kept.get(String(key))?.clone(), put: async (key, response) => { if (full) throw new Error("full"); kept.set(String(key), response); } }) };
  t.after(() => { delete globalThis.caches; });
  let asked = 0;
  await served(() => { ++asked; return false; }, async (url, bytes) => {
    const source = new CachedSource(new HttpSource(url));
    assert.equal(await source.size(), 1000);
    for (let i = 0; i < 3; ++i) assert.deepEqual(await source.read(5, 50), bytes.subarray(5, 55));
    assert.equal(asked, 2);
    for (const key of kept.keys()) kept.set(key, new Response(new Uint8Array(3)));
    full = true;
    assert.deepEqual(await source.read(5, 50), bytes.subarray(5, 55));
    assert.equal(asked, 3);
  });
});

/** Workers that live for so many messages each. */
function workersThatLive(lives) {
  const started = [];
  globalThis.Worker = class {
    constructor() {
      this.left = lives[started.length] ?? Infinity;
      started.push(this);
    }
    postMessage({ id, read, size, ping }) {
      if (this.left-- <= 0 || this.ended) return;
      setImmediate(() => this.onmessage({ data: ping ? {} : { id, result: size ? 1000 : read && new Uint8Array(read[1]) } }));
    }
    terminate() { this.ended = true; }
  };
  return started;
}

test("a worker that dies is replaced, and one that cannot be kept alive is one sentence", async (t) => {
  t.after(() => { delete globalThis.Worker; });
  let workers = workersThatLive([2, 1]); // it opens and answers once; the next only opens
  let source = new WorkerSource("http://127.0.0.1/pack", { pingMs: 2 });
  assert.equal(await source.size(), 1000);
  assert.equal((await source.read(0, 10)).length, 10);
  assert.equal(workers.length, 3);
  source.close();
  assert.ok(workers.every((worker) => worker.ended));
  workers = workersThatLive([0, 0, 0, 0, 0, 0]);
  source = new WorkerSource("http://127.0.0.1/pack", { pingMs: 2 });
  await assert.rejects(source.size(), /the worker that reads cannot be kept alive; reload the page/);
  assert.equal(workers.length, 4);
  source.close();
  workers = workersThatLive([]);
  source = new WorkerSource("http://127.0.0.1/pack", { pingMs: 2 });
  const reading = source.read(0, 10);
  source.close();
  await assert.rejects(reading, /closed/);
});
