// The code of docs/guides/web.md that node runs; page.test.mjs runs the rest.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import test from "node:test";

import { terrarium } from "./images.mjs";
import { hills } from "./surface.mjs";

test("a mesh from an array", async () => {
  // a file of a program: `import { mesh } from "fjell"` stands at its top
  const { mesh } = await import("fjell");
  const width = 300, height = 200;
  const heights = Float32Array.from({ length: width * height }, (_, i) => 90 * Math.sin((i % width) / 40) * Math.cos(i / width / 30));
  const made = await mesh(heights, { width, height, maxError: 2, spacing: 10 });
  console.log(made.positions.length / 3, "vertices,", made.triangles.length / 3, "triangles, within", made.trueError, "m");
  assert.ok(made.trueError <= 2);
});

test("a mesh from a map's tile", async () => {
  const { mesh } = await import("fjell"), { TileSource } = await import("fjell/tiles");
  const file = terrarium(hills(256, 256), 256, 256), server = createServer((request, response) => response.end(file));
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const template = `http://127.0.0.1:${server.address().port}/{z}/{x}/{y}.png`;
  const tiles = new TileSource(template, { encoding: "terrarium" });
  const tile = await tiles.heights(12, 2137, 1452);
  const surface = await mesh(tile.heights, { ...tile, maxError: 5 });
  server.close();
  server.closeAllConnections();
  assert.ok(surface.trueError <= 5 && surface.triangles.length > 3000);
});

test("a terrain", async () => {
  const { makeView, Terrain } = await import("fjell");
  const file = process.env.FJELL_PACK;
  const terrain = await Terrain.open(await readFile(file), { vertices: 100_000, triangles: 200_000 });
  Object.assign(terrain.settings, { maxError: 2, maxMs: 4, morph: "time" });
  const [wide, deep] = terrain.extent;
  const view = makeView({ eye: [wide / 2, 4000, deep], target: [wide / 2, 500, 0], width: 1280, height: 720 });
  for (let i = 0; i < 100 && !terrain.frame.settled; ++i) {
    const frame = terrain.update([view], i / 60);
    const changes = terrain.takeChanges();
    for (let k = 0; k < changes.vertexRunCount; ++k) {
      const first = changes.vertexRuns[2 * k], count = changes.vertexRuns[2 * k + 1];
      const upload = terrain.vertexSlots.subarray(3 * first, 3 * (first + count));
      assert.equal(upload.length, 3 * count);
    }
    assert.ok(frame.triangles <= 200_000);
  }
  const ground = terrain.height(wide / 2, deep / 2);
  const hit = terrain.ray(view.eye, view.forward);
  assert.ok(ground > 0 && hit.error < 100);
  terrain.close();
});
