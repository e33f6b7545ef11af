// On maps: fjell/maplibre in MapLibre GL, fjell/deck in deck.gl's TerrainLayer, in headless Chromium.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import test from "node:test";

import { Terrain } from "fjell";
import { texelsOf } from "fjell/tiles";

import { bundle, openBrowser, patience } from "./browser.mjs";
import { tilesOf } from "./tileserver.mjs";

const center = [8.2, 46.5];
const whole = await Terrain.open(await readFile(process.env.FJELL_PACK), { whole: true });
await bundle("deckgl");
const here = openBrowser(".", tilesOf(whole, center));

/** How much of the picture is not of its commonest colour. */
const drawn = (page) => page.evaluate(async () => {
  const { map } = mapPage;
  const rendered = map.once("render");
  map.triggerRepaint();
  await rendered;
  const gl = map.getCanvas().getContext("webgl2"), texels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
  gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, texels);
  const counts = new Map();
  for (const word of new Uint32Array(texels.buffer)) counts.set(word, (counts.get(word) ?? 0) + 1);
  const mean = [0, 0, 0];
  texels.forEach((value, i) => { if (i % 4 < 3) mean[i % 4] += 4 * value / texels.length; });
  return { ground: 1 - Math.max(...counts.values()) * 4 / texels.length, colours: counts.size, mean };
});
const alike = (one, other) => one.mean.every((value, k) => Math.abs(value - other.mean[k]) < 1);
const settled = async (page) => { // after a frame that knows the camera
  await page.evaluate(() => {
    const rendered = mapPage.map.once("render");
    mapPage.map.triggerRepaint();
    return rendered.then(() => {});
  });
  await page.waitForFunction(() => mapPage.layer.terrain.frame.settled && !mapPage.map.isMoving(), null, patience);
};

/** How far the layer's camera puts places from where the map puts them, in pixels; and how high the two eyes are, in metres. */
const apart = (page, center) => page.evaluate(([lng, lat]) => {
  const { map, layer } = mapPage, { clientWidth: wide, clientHeight: high } = map.getCanvas(), radians = Math.PI / 180;
  const w = 1 - 0.00669437999014 * Math.sin(lat * radians) ** 2, east = 6378137 / Math.sqrt(w) * Math.cos(lat * radians), north = 6378137 * (1 - 0.00669437999014) / w ** 1.5; // of a radian
  const point = layer.sun.position.clone();
  let worst = 0;
  for (const [x, z] of [[0, 0], [1000, 0], [0, -1500], [-1200, 800]]) {
    point.set(x, 0, z).project(layer.camera);
    const there = map.project([lng + x / east / radians, lat - z / north / radians]);
    worst = Math.max(worst, Math.hypot((point.x + 1) / 2 * wide - there.x, (1 - point.y) / 2 * high - there.y));
  }
  return { worst, eye: Math.abs(point.setFromMatrixPosition(layer.camera.matrixWorld).y - map._camera.transform.getCameraAltitude()) };
}, center);

test("a terrain on a map lies where the map says, is refined for its camera, and rests when it is done", async () => {
  const page = await here.visit("map.html", { viewport: { width: 800, height: 500 } });
  await page.waitForFunction(() => globalThis.mapPage?.layer.object, null, patience);
  await settled(page);
  const first = await drawn(page);
  assert.ok(first.ground > 0.3 && first.colours > 500, JSON.stringify(first));
  await here.shoot(page, "map");
  for (const [name, move] of [["map-near", { zoom: 12, pitch: 60, bearing: -40 }], ["map-above", { pitch: 0, bearing: 0, zoom: 10 }], ["map-padded", { padding: { left: 200, bottom: 100 }, pitch: 50 }]]) {
    await page.evaluate((to) => { mapPage.map.jumpTo(to); }, move);
    await settled(page);
    const off = await apart(page, center);
    assert.ok(off.worst < 0.1 && off.eye < 1, `${name}: ${JSON.stringify(off)}`);
    const { converged, errorBound } = await page.evaluate(() => mapPage.layer.terrain.frame);
    assert.ok(converged && errorBound <= 1, name);
    await here.shoot(page, name);
  }
  const frames = await page.evaluate(async () => {
    let rendered = 0;
    mapPage.map.on("render", () => ++rendered);
    for (let i = 0; i < 20; ++i) await new Promise((resolve) => requestAnimationFrame(resolve));
    return rendered;
  });
  assert.ok(frames < 3, `${frames} frames of a map at rest`);
  await page.setViewportSize({ width: 500, height: 700 });
  await page.waitForFunction(() => mapPage.map.getCanvas().width === 500, null, patience);
  await settled(page);
  assert.ok((await apart(page, center)).worst < 0.1, "after a change of size");
  await here.shoot(page, "map-tall");
  const before = await drawn(page);
  await page.evaluate(() => mapPage.map.removeLayer("fjell"));
  assert.ok(!alike(await drawn(page), before), "taken off");
  await page.evaluate(() => { mapPage.map.addLayer(mapPage.layer); });
  await settled(page);
  assert.ok(alike(await drawn(page), before), "put on again, with its maps");
  assert.deepEqual(page.said, []);
  await page.close();
});

test("a map that has lost its context draws the terrain again, once the layer is on it again", async () => {
  const page = await here.visit("map.html", { viewport: { width: 400, height: 250 } });
  await page.waitForFunction(() => globalThis.mapPage?.layer.object, null, patience);
  await settled(page);
  const before = await drawn(page);
  await page.evaluate(async () => {
    const { map, layer } = mapPage, lose = map.getCanvas().getContext("webgl2").getExtension("WEBGL_lose_context");
    const lost = map.once("webglcontextlost"), restored = map.once("webglcontextrestored");
    lose.loseContext();
    await lost;
    await new Promise((resolve) => setTimeout(resolve)); // all who listen have heard of it
    lose.restoreContext();
    await restored;
    if (!map.isStyleLoaded()) await map.once("style.load");
    map.addLayer(layer);
  });
  await settled(page);
  const after = await drawn(page);
  assert.ok(after.ground > 0.8 * before.ground && after.colours > 200, "without maps its triangles are lit: " + JSON.stringify([before, after]));
  await page.close();
});

test("a layer without a place, or with a wrong one, is an error that names the argument", async () => {
  const page = await here.visit("map.html");
  await page.waitForFunction(() => globalThis.mapPage, null, patience);
  const said = await page.evaluate(async () => {
    const { TerrainLayer } = await import("fjell/maplibre"), { terrain } = mapPage.layer;
    return [{}, { terrain }, { terrain, center: [200, 0] }, { terrain, center: [0, 89] }, { terrain, center: [0, 0], bearing: NaN }, { terrain, crs: "EPSG:4326" }, { terrain, id: "", center: [0, 0] }]
      .map((options) => { try { return new TerrainLayer(options).id; } catch (error) { return error.message.split(":")[0]; } });
  });
  assert.deepEqual(said, ["terrain", "center", "center", "center", "bearing", "crs", "id"]);
  await page.close();
});

test("deck.gl's TerrainLayer draws what the loader makes of tiles, each within the error", async () => {
  const page = await here.visit("deck.html", { viewport: { width: 800, height: 500 } });
  await page.waitForFunction(() => globalThis.deckPage?.ground.isLoaded, null, patience);
  const tiles = await page.evaluate(() => deckPage.ground.getSubLayers()[0].state.tileset.tiles.filter((tile) => tile.content)
    .map(({ index, content: [mesh] }) => ({ ...index, error: mesh.loaderData.trueError, triangles: mesh.indices.value.length / 3, top: mesh.header.boundingBox[1][2] })));
  assert.ok(tiles.length >= 4 && tiles.every(({ error, triangles }) => error <= 5 && triangles > 100), JSON.stringify(tiles));
  assert.ok(Math.abs(Math.max(...tiles.map(({ top }) => top)) - whole.heightRange[1]) < 100);
  await here.shoot(page, "deck");
  assert.deepEqual(page.said, []);
  await page.close();
});

test("a pack in deck.gl lies where deck.gl says, is refined for its camera, and is an error without a place", async () => {
  const page = await here.visit("pack.html", { viewport: { width: 800, height: 500 } });
  const done = () => page.waitForFunction(() => globalThis.deckPage?.ground.getCurrentLayer()?.isLoaded && deckPage.deck.needsRedraw() === false, null, patience);
  await done();
  const seen = () => page.evaluate(([lng, lat]) => {
    const { terrain, seen: { eye, forward, up, left, right, bottom, top, width, height } } = deckPage, [viewport] = deckPage.deck.getViewports();
    const across = [forward[1] * up[2] - forward[2] * up[1], forward[2] * up[0] - forward[0] * up[2], forward[0] * up[1] - forward[1] * up[0]];
    const east = viewport.getDistanceScales([lng, lat]).unitsPerMeter[0] * 360 / 512; // degrees
    let worst = 0;
    for (const [x, z] of [[0, 0], [1000, 0], [0, -1500], [-1200, 800]]) {
      const height_m = terrain.height(terrain.extent[0] / 2 + x, terrain.extent[1] / 2 + z);
      const at = [terrain.extent[0] / 2 + x, height_m, terrain.extent[1] / 2 + z].map((value, k) => value - eye[k]);
      const [u, v, w] = [across, up, forward].map((axis) => axis[0] * at[0] + axis[1] * at[1] + axis[2] * at[2]);
      const there = viewport.project([lng + x * east, lat - z * east * Math.cos(lat * Math.PI / 180), height_m]);
      worst = Math.max(worst, Math.hypot((u / w - left) / (right - left) * width - there[0], (top - v / w) / (top - bottom) * height - there[1]));
    }
    const { converged, errorBound, trianglesDrawn } = terrain.frame;
    return { worst, converged, errorBound, trianglesDrawn, drawn: deckPage.ground.getCurrentLayer().state.model.vertexCount / 3 };
  }, center);
  const whatItShows = async (name) => {
    const off = await seen();
    assert.ok(off.worst < 0.5 && off.converged && off.errorBound <= 1 && off.trianglesDrawn > 1000 && off.drawn === off.trianglesDrawn, `${name}: ${JSON.stringify(off)}`);
    await here.shoot(page, name);
    const { width, rgba } = await texelsOf(await readFile(`${process.env.FJELL_SHOTS}/${name}.png`)), words = new Uint32Array(rgba.buffer, rgba.byteOffset, rgba.length / 4);
    const sky = words[0];
    assert.ok(words.filter((word) => word !== sky).length > 0.3 * words.length && new Set(words).size > 100 && width === 800, name);
  };
  await whatItShows("pack");
  await page.evaluate(() => deckPage.deck.setProps({ initialViewState: { longitude: 8.22, latitude: 46.5, zoom: 12, pitch: 40, bearing: 130 } }));
  await page.waitForFunction(() => deckPage.deck.getViewports()[0].bearing === 130, null, patience);
  await done();
  const near = await seen();
  assert.ok(near.worst < 0.5 && near.converged, JSON.stringify(near));
  await here.shoot(page, "pack-near");
  assert.deepEqual(page.said, []);
  const said = await page.evaluate(async () => {
    const { PackLayer } = await import("fjell/deck-layer"), { terrain } = deckPage;
    return [{}, { terrain }, { terrain, center: [200, 0] }].map((options) => { try { return new PackLayer({ id: "a", ...options }).id; } catch (error) { return error.message.split(":")[0]; } });
  });
  assert.deepEqual(said, ["terrain", "center", "center"]);
  await page.close();
});
