// Frames of the same flight over the same heights: Fjell in three.js, CesiumJS's terrain, deck.gl's TerrainLayer; each in
// Chromium, one after the other, on whatever draws there.
//   node frames.mjs PACK FRAMES [FOLDER]   in the folder of others.mjs. FOLDER: for pictures.
// Cesium reads heightmaps of 65 x 65 in its own format, deck.gl Terrarium tiles of 256 x 256, both at least as fine as
// the pack. The server has made all of them before anything is timed.
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

import { Terrain } from "fjell";
import { chromium } from "playwright-core";

import { bundle, launch } from "./browser.mjs";
import { serve } from "./serve.mjs";
import { tilesOf } from "./tileserver.mjs";

const center = [8.2, 46.5], equator = 40075016.685578488, mostLevel = 13;
const cos = Math.cos(center[1] * Math.PI / 180), mercator = (lat) => Math.asinh(Math.tan(lat * Math.PI / 180)) / (2 * Math.PI);

/** Answers what the three read. told.bytes: how much of the ground they have read. */
function answering(terrain, pack, told) {
  const { columns, rows, spacing, extent: [wide, deep] } = terrain, tiles = tilesOf(terrain, center, 0), maps = new Map();
  /** Heights by degrees; 0 beyond the terrain. */
  const height = (lng, lat) => terrain.height(wide / 2 + (lng - center[0]) / 360 * equator * cos, deep / 2 - (mercator(lat) - mercator(center[1])) * equator * cos) || 0;
  /** Cesium's heightmap-1.0: fifths of a metre from -1000 m on; which children there are; no water. */
  const heightmap = (z, x, y) => {
    const bytes = Buffer.alloc(65 * 65 * 2 + 2), degrees = 180 / 2 ** z;
    for (let j = 0; j < 65; ++j)
      for (let i = 0; i < 65; ++i)
        bytes.writeUInt16LE(Math.round((height(-180 + (x + i / 64) * degrees, -90 + (y + 1 - j / 64) * degrees) + 1000) * 5), 2 * (65 * j + i));
    bytes[65 * 65 * 2] = z < mostLevel ? 15 : 0;
    return gzipSync(bytes);
  };
  const send = (response, type, body, headers = {}) => response.writeHead(200, { "content-type": type, ...headers }).end(body);
  const counted = (response) => {
    const { end } = response;
    response.end = (data, ...more) => {
      told.bytes += data?.length ?? 0;
      return end.call(response, data, ...more);
    };
  };
  return (request, response) => {
    const at = request.url.split("?")[0], place = /^\/heights\/(\d+)\/(\d+)\/(\d+)\.terrain$/.exec(at);
    const range = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? "");
    if (at === "/heights.json") {
      send(response, "application/json", JSON.stringify({ columns, rows, spacing }));
    } else if (at === "/heights.bin") { // to measure with
      send(response, "application/octet-stream", Buffer.from(Float32Array.from({ length: columns * rows }, (_, i) => terrain.height(i % columns * spacing[0], Math.floor(i / columns) * spacing[1])).buffer));
    } else if (at === "/pack.fjell" && range) {
      counted(response);
      const [first, last] = [Number(range[1]), Math.min(Number(range[2]), pack.length - 1)];
      response.writeHead(206, { "content-range": `bytes ${first}-${last}/${pack.length}`, etag: '"1"' }).end(pack.subarray(first, last + 1));
    } else if (at === "/heights/layer.json") {
      send(response, "application/json", JSON.stringify({ tilejson: "2.1.0", format: "heightmap-1.0", version: "1.0.0", scheme: "tms", tiles: ["{z}/{x}/{y}.terrain"], projection: "EPSG:4326" }));
    } else if (place) {
      counted(response);
      if (!maps.has(at)) maps.set(at, heightmap(...place.slice(1).map(Number)));
      send(response, "application/octet-stream", maps.get(at), { "content-encoding": "gzip" });
    } else {
      if (!at.startsWith("/tiles/")) return false;
      counted(response);
      return tiles(request, response);
    }
    return true;
  };
}

// deck.gl twice: with the error that it has where none is given, and with one that is about 2 pixels here, as the others'.
const hosts = { fjell: "fjell", cesium: "cesium", "deck, 4 m": "deck&error=4", "deck, 20 m": "deck&error=20" };

/**
 * The first picture of each host, the one in the middle of `runs` by its time, and one flight of `count` frames. warm:
 * one of each before, which is not timed. pictures: a folder for the first picture and the last.
 */
export async function measureFrames({ pack, names = Object.keys(hosts), count, runs = 1, warm = false, size = { width: 960, height: 540 }, pictures }) {
  const bytes = await readFile(pack), terrain = await Terrain.open(bytes, { whole: true, pageSlots: 1 << 20 }), told = { bytes: 0 };
  const server = await serve(".", 0, answering(terrain, bytes, told)), browser = await chromium.launch(launch);
  const run = async (name, flies) => {
    const context = await browser.newContext({ viewport: size }), page = await context.newPage(), errors = [];
    const shoot = (when) => pictures && page.screenshot({ path: join(pictures, `frames-${name.replace(/\W+/g, "-")}${when}.png`) });
    page.on("crash", () => errors.push("crashed"));
    page.on("pageerror", (error) => errors.push(error.message));
    await page.goto(`http://127.0.0.1:${server.address().port}/frames.html?with=${hosts[name]}`);
    await page.waitForFunction(() => globalThis.frames?.first, null, { timeout: 180_000, polling: 100 });
    told.bytes = 0;
    const made = { first: { ...await page.evaluate(() => frames.first()), bytes: told.bytes }, errors };
    if (flies) {
      made.error = await page.evaluate(() => frames.error());
      await shoot("");
      made.flown = { ...await page.evaluate((n) => frames.fly(n), count), bytes: told.bytes };
      await shoot("-end");
    }
    await context.close();
    return made;
  };
  try {
    await bundle("deckgl");
    const results = {};
    for (const name of names) {
      if (warm) await run(name, true); // all tiles are made then
      const all = [];
      for (let i = 0; i < runs; ++i) all.push(await run(name, i === runs - 1));
      const { error, flown } = all.at(-1), errors = all.flatMap((of) => of.errors);
      results[name] = { first: all.sort((a, b) => a.first.ms - b.first.ms)[runs >> 1].first, error, flown, errors };
    }
    return results;
  } finally {
    await browser.close();
    server.close();
    server.closeAllConnections();
    terrain.close();
  }
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [pack, frames, pictures] = process.argv.slice(2), count = Number(frames);
  const measured = await measureFrames({ pack, pictures, count, runs: 3, warm: true }), results = Object.values(measured);
  const text = (value, digits = 0) => value.toLocaleString("en", { minimumFractionDigits: digits, maximumFractionDigits: digits });
  const row = (what, value) => console.log(`| ${what} | ${results.map(value).join(" | ")} |`);
  for (const { errors } of results) for (const error of errors) console.error(error);
  console.log(`960 x 540; first pictures: the middle one of three by its time; one flight of ${count} frames`);
  console.log(`| | ${Object.keys(measured).join(" | ")} |\n|---|${"---|".repeat(results.length)}`);
  row("first complete picture, ms", ({ first }) => text(first.ms));
  row("heights read until then, KB", ({ first }) => text(first.bytes / 1e3));
  row("triangles of that picture", ({ first }) => text(first.triangles));
  row("largest error in it, px", ({ error }) => text(error.worst, 1));
  row("longest frame until then, ms", ({ first }) => text(first.longest));
  row("heights read with the flight, KB", ({ flown }) => text(flown.bytes / 1e3));
  row("triangles of a frame, median", ({ flown }) => text(flown.triangles));
  row("frames that lacked something", ({ flown }) => text(flown.incomplete));
  row("frame to frame, median, ms", ({ flown }) => text(flown.median, 1));
  row("frame to frame, longest, ms", ({ flown }) => text(flown.longest));
  row("calls of a frame, median, ms", ({ flown }) => text(flown.ownMedian, 1));
  row("calls of a frame, longest, ms", ({ flown }) => text(flown.ownLongest, 1));
}
