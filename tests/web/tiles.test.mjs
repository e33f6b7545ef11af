// Tiles of maps as heights, in node: servers of tiles, PMTiles beside the package of that name, and the loader for
// deck.gl beside loaders.gl's own.
import assert from "node:assert/strict";
import { createServer } from "node:http";
import test from "node:test";
import { gzipSync } from "node:zlib";

import { parse } from "@loaders.gl/core";
import { mesh } from "fjell";
import { HeightLoader } from "fjell/deck";
import { heightsOfTile, PmTiles, TileSource } from "fjell/tiles";
import { PMTiles as TheirPmTiles, zxyToTileId } from "pmtiles";

import { pmtiles, terrarium } from "./images.mjs";
import { hills, measure } from "./surface.mjs";

const random = (() => { let state = 7; return () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32; })();
const noise = (texels) => Uint8Array.from({ length: 4 * texels }, () => Math.floor(random() * 256));
const decoder = { rScaler: 256, gScaler: 1, bScaler: 1 / 256, offset: -32768 };

test("tiles of a server are heights for mesh(), with metres at their latitude", async () => {
  const side = 256, heights = hills(side, side), file = terrarium(heights, side, side);
  const server = createServer((request, response) => {
    if (request.url === "/12/2137/1452.png") response.writeHead(200).end(file);
    else response.writeHead(request.url.startsWith("/12/") ? 404 : 503).end();
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  try {
    const tiles = new TileSource(`http://127.0.0.1:${server.address().port}/{z}/{x}/{y}.png`);
    const tile = await tiles.heights(12, 2137, 1452);
    assert.ok(tile.heights.every((h, i) => Math.abs(h - heights[i]) <= 1 / 512));
    assert.ok(Math.abs(tile.spacing - 40075016.685578488 / 4096 / 256 * Math.cos(46.34 * Math.PI / 180)) < 0.05, `${tile.spacing}`);
    const made = await mesh(tile.heights, { ...tile, maxError: 2 });
    assert.ok(made.trueError <= 2 && Math.abs(Math.max(...made.positions.filter((_, i) => i % 3 === 0)) - 255 * tile.spacing) < 1e-2);
    assert.equal(await tiles.heights(12, 0, 0), null, "404");
    await assert.rejects(tiles.heights(11, 0, 0), /503/);
    for (const [at, name] of [[[-1, 0, 0], "z"], [[3, 8, 0], "x"], [[3, 0, 1.5], "y"]]) await assert.rejects(tiles.heights(...at), new RegExp(`^RangeError: ${name}:`));
  } finally {
    server.close();
    server.closeAllConnections();
  }
  assert.throws(() => new TileSource("tiles.png"), /^TypeError: source/);
  assert.throws(() => new TileSource("{z}/{x}/{y}", { encoding: "png" }), /^RangeError: encoding/);
  assert.deepEqual([...heightsOfTile([1, 2, 3, 255], (r, g, b) => r + g + b)], [6]);
});

/** 200 tiles of some zooms, some of them equal to the one before. */
function someTiles() {
  const places = new Map();
  for (let i = 0; i < 200; ++i) {
    const z = Math.floor(random() * 13), at = [z, Math.floor(random() * 2 ** z), Math.floor(random() * 2 ** z)];
    places.set(zxyToTileId(...at), at);
    for (const x of [at[1], at[1] ^ 1]) places.set(zxyToTileId(z, Math.min(x, 2 ** z - 1), at[2]), [z, Math.min(x, 2 ** z - 1), at[2]]);
  }
  const numbers = [...places.keys()].sort((a, b) => a - b), tiles = [];
  for (const number of numbers) {
    const again = tiles.length > 0 && tiles[tiles.length - 1][0] === number - 1 && random() < 0.5;
    tiles.push([number, again ? tiles[tiles.length - 1][1] : Buffer.from(noise(1 + Math.floor(random() * 9)))]);
  }
  return { places, tiles };
}

test("PMTiles gives every tile that the package pmtiles gives, and none that it does not", async () => {
  const { places, tiles } = someTiles();
  for (const leaf of [8, 1000]) {
    const file = pmtiles(tiles, { leaf }), ours = new PmTiles(file);
    const theirs = new TheirPmTiles({ getKey: () => `leaf ${leaf}`, getBytes: async (offset, length) => ({ data: new Uint8Array(file.subarray(offset, offset + length)).buffer }) });
    const { minZoom, maxZoom, bounds } = await ours.header();
    assert.deepEqual([minZoom, maxZoom, bounds], [0, 14, [5, 45, 10, 48]]);
    let held = 0;
    const others = Array.from({ length: 100 }, () => [12, Math.floor(random() * 4096), Math.floor(random() * 4096)]);
    for (const at of [...places.values(), ...others]) {
      const [one, other] = [await ours.tile(...at), await theirs.getZxy(...at)];
      assert.deepEqual(one && [...one], other ? [...new Uint8Array(other.data)] : null, `${at}`);
      held += one ? 1 : 0;
    }
    assert.ok(held >= tiles.length);
  }
});

test("tiles out of PMTiles are heights, and a damaged file is an error", async () => {
  const heights = hills(64, 64), tile = terrarium(heights, 64, 64), at = [10, 533, 363];
  const tiles = new TileSource(new PmTiles(pmtiles([[zxyToTileId(...at), gzipSync(tile)]], { compression: 2 })));
  assert.ok((await tiles.heights(...at)).heights.every((h, i) => Math.abs(h - heights[i]) <= 1 / 512));
  assert.equal(await tiles.heights(10, 0, 0), null);
  const whole = pmtiles(someTiles().tiles);
  await assert.rejects(new PmTiles(Buffer.from("no")).tile(0, 0, 0), /no PMTiles file/);
  await assert.rejects(new PmTiles(Buffer.alloc(200)).tile(0, 0, 0), /no PMTiles file/);
  await assert.rejects(new PmTiles(whole.with?.(7, 2) ?? Uint8Array.from(whole, (byte, i) => (i === 7 ? 2 : byte))).tile(0, 0, 0), /version 2/);
  for (let i = 8; i < 1000; i += 5) {
    const damaged = Uint8Array.from(whole);
    damaged[i] ^= 0x81;
    const file = new PmTiles(damaged);
    for (const [z, x] of [[0, 0], [5, 3], [12, 77]]) await file.tile(z, x, x).catch((error) => assert.match(error.message, /^pmtiles/, `byte ${i}`));
  }
});

test("the loader for deck.gl makes what loaders.gl's own makes, and keeps the error that both are asked for", async () => {
  const { TerrainLoader } = await import("@loaders.gl/terrain");
  const side = 256, heights = hills(side, side), file = terrarium(heights, side, side), bounds = [100, 200, 356, 456];
  const data = file.buffer.slice(file.byteOffset, file.byteOffset + file.length);
  const terrain = { meshMaxError: 3, bounds, elevationDecoder: decoder, skirtHeight: 6 };
  const made = await parse(data, HeightLoader, { terrain });
  const { value: p } = made.attributes.POSITION, { value: uv } = made.attributes.TEXCOORD_0;
  const flat = await parse(data, HeightLoader, { terrain: { ...terrain, skirtHeight: 0 } });
  const [[west, south, low], [east, north, high]] = made.header.boundingBox;
  assert.deepEqual([west, south, east, north], bounds);
  assert.ok(low >= Math.min(...heights) - 0.01 && high <= Math.max(...heights) + 0.01, "the skirt is not in the box");
  assert.equal(made.header.vertexCount, p.length / 3);
  const texels = (positions) => Float32Array.from(positions, (_, i) => [positions[i] - 100, positions[i + 1], 456 - positions[i - 1]][i % 3]);
  const all = Float32Array.from({ length: 257 * 257 }, (_, i) => heights[Math.min(Math.floor(i / 257), 255) * side + Math.min(i % 257, 255)]);
  const { worst, covered } = measure(all, 257, 257, texels(flat.attributes.POSITION.value), flat.indices.value);
  assert.ok(worst <= 3 && Math.abs(flat.loaderData.trueError - worst) < 0.01 && covered === 257 * 257, `${worst} ${flat.loaderData.trueError}`);
  for (let i = 0; i < p.length / 3; ++i) assert.ok(Math.abs(uv[2 * i] - (p[3 * i] - 100) / 256) < 1e-6 && Math.abs(uv[2 * i + 1] - (456 - p[3 * i + 1]) / 256) < 1e-6);
  // The skirt: below every edge of the rim, closed.
  const walls = (made.indices.value.length - flat.indices.value.length) / 3, rim = new Set();
  for (let i = 0; i < flat.attributes.POSITION.value.length; i += 3) if ([west, east].includes(p[i]) || [south, north].includes(p[i + 1])) rim.add(i);
  assert.equal(walls, 2 * rim.size);
  const theirs = TerrainLoader.parse && (await parse(data, TerrainLoader, { terrain, core: { worker: false } }).catch(() => null));
  if (theirs) assert.deepEqual(Object.keys(theirs.attributes), Object.keys(made.attributes));
  await assert.rejects(parse(data, HeightLoader, { terrain: { meshMaxError: -1 } }), /maxError/);
});
