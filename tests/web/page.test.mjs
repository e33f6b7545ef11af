// The page content/hosts/web and the guide's first terrain, in headless Chromium. FJELL_SITE: the folder that build.sh
// has made; FJELL_SHOTS: where pictures of the page go, to be looked at.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFile, readFile, rm, writeFile } from "node:fs/promises";
import { join } from "node:path";
import test from "node:test";

import { texelsOf } from "fjell/tiles";

import { openBrowser, patience } from "./browser.mjs";
import { png } from "./images.mjs";

const { FJELL_SITE, FJELL_GOLDEN } = process.env;
await copyFile("flight.mjs", join(FJELL_SITE, "flight.mjs"));
let fault = () => false; // of a server of packs
const here = openBrowser(FJELL_SITE, (request, response) => request.url.endsWith(".fjell") && fault(request, response));
const visit = (path, viewport = { width: 640, height: 360 }) => here.visit(path, { viewport });

/** Shares of the picture: how many of its pixels differ from the first, which is sky, and how many colours there are. */
const look = (page, of) => page.evaluate((path) => {
  const { renderer, scene, camera } = path.split(".").reduce((at, name) => at[name], globalThis);
  renderer.render(scene, camera);
  const gl = renderer.getContext(), { width, height } = renderer.domElement;
  const texels = new Uint8Array(4 * width * height);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, texels);
  const words = new Uint32Array(texels.buffer), sky = words[words.length - 1];
  return { ground: words.filter((word) => word !== sky).length / words.length, colours: new Set(words).size };
}, of);

async function still(page) { // converged, without flying
  await page.waitForFunction(() => globalThis.fjellPage?.state.terrain, null, patience);
  await page.evaluate(() => { document.getElementById("fly").checked = false; document.getElementById("time").value = 8; });
  await page.waitForFunction(() => fjellPage.state.terrain?.frame.converged && fjellPage.state.terrain.frame.inFlight === 0, null, patience);
}

for (const [name, viewport] of [["desktop", { width: 1280, height: 720 }], ["phone", { width: 390, height: 844 }]])
  test(`the page draws a complete picture, ${name}`, async () => {
    const page = await visit("", viewport);
    await still(page);
    const seen = await look(page, "fjellPage");
    assert.ok(seen.ground > 0.3 && seen.colours > 500, JSON.stringify(seen));
    const state = await page.evaluate(() => ({ bound: fjellPage.state.terrain.frame.errorBound, read: fjellPage.state.readBytes,
      wide: document.documentElement.scrollWidth, figures: document.getElementById("figures").innerText }));
    assert.ok(state.bound <= 2 && state.read > 100_000);
    assert.ok(state.wide <= viewport.width);
    assert.match(state.figures, /triangles\s+[\d,]{4,}/);
    await here.shoot(page, name);
    assert.deepEqual(page.said, []);
    await page.close();
  });

test("keys, drags, the wheel and the sliders do what they say", async () => {
  const page = await visit("", { width: 700, height: 400 });
  await still(page);
  const eye = () => page.evaluate(() => [...fjellPage.camera.position.toArray(), fjellPage.state.heading]);
  const frames = (count) => page.evaluate((n) => { fjellPage.until = fjellPage.state.frames + n; }, count)
    .then(() => page.waitForFunction(() => fjellPage.state.frames >= fjellPage.until, null, patience));
  let last = await eye();
  const moved = async (part, what) => {
    const now = await eye();
    assert.ok(Math.abs(now[part] - last[part]) > 1e-3, what);
    last = now;
  };
  await page.keyboard.down("w");
  await frames(3);
  await page.keyboard.up("w");
  await moved(2, "W moves north");
  await page.mouse.move(300, 200);
  await page.mouse.down();
  await page.mouse.move(380, 200, { steps: 4 });
  await page.mouse.up();
  await moved(3, "a drag turns");
  await page.mouse.wheel(0, -300);
  await moved(2, "the wheel moves");
  const triangles = () => page.evaluate(() => fjellPage.state.terrain.frame.triangles);
  await still(page);
  const before = await triangles();
  await page.evaluate(() => { document.getElementById("threshold").value = 4; });
  await page.waitForFunction((most) => fjellPage.state.terrain.frame.converged && fjellPage.state.terrain.frame.triangles < most, before / 2, patience);
  await page.mouse.move(320, 300);
  await page.waitForFunction(() => /m ±/.test(fjellPage.state.probe), null, patience);
  const plain = await look(page, "fjellPage");
  await page.check("#wire");
  await frames(2);
  assert.ok((await look(page, "fjellPage")).colours !== plain.colours, "lines are drawn");
  await page.uncheck("#wire");
  const strong = async () => { // pixels of strong colours
    await frames(2);
    const { rgba } = await pixels(page);
    return Array.from({ length: rgba.length / 4 }, (_, i) => rgba.subarray(4 * i, 4 * i + 3)).filter((rgb) => Math.max(...rgb) - Math.min(...rgb) > 90).length * 4 / rgba.length;
  };
  const grey = await strong();
  await page.check("#levels");
  const levels = await strong();
  assert.ok(levels > 0.1 && grey < levels / 4, `levels are coloured: ${grey} ${levels}`);
  await here.shoot(page, "levels");
  await page.uncheck("#levels");
  assert.ok(await strong() < levels / 4, "and not any more");
  assert.deepEqual(page.said, []);
  await page.close();
});

test("fingers look around and move, and keys do as hands expect", async () => {
  const page = await here.visit("", { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  await still(page);
  const eye = () => page.evaluate(() => [...fjellPage.camera.position.toArray(), fjellPage.state.heading, fjellPage.state.pitch]);
  const hand = await page.context().newCDPSession(page);
  const touch = (type, ...points) => hand.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const drawn = () => page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
  let before = await eye();
  await touch("touchStart", [200, 400]);
  await touch("touchMove", [260, 430]);
  await touch("touchEnd");
  let now = await eye();
  assert.ok(now[3] < before[3] && now[4] > before[4], "one finger looks");
  before = now;
  await touch("touchStart", [150, 400], [250, 400]);
  await touch("touchMove", [100, 400], [300, 400]);
  await touch("touchEnd");
  await drawn();
  now = await eye();
  assert.ok(Math.hypot(now[0] - before[0], now[2] - before[2]) > 1 && Math.abs(now[3] - before[3]) < 1e-9, "two fingers move");
  const held = async (key) => {
    const from = await eye();
    await page.keyboard.down(key);
    await page.waitForFunction(([x, y, z, heading]) => { const c = fjellPage.camera.position; return Math.hypot(c.x - x, c.y - y, c.z - z) + Math.abs(fjellPage.state.heading - heading) > 1e-4; }, from, patience);
    await page.keyboard.up(key);
    return (await eye()).map((value, i) => value - from[i]);
  };
  assert.ok((await held("ArrowRight"))[3] > 0);
  assert.ok((await held("e"))[1] > 0);
  const [dx, , dz] = await held("d"), heading = (await eye())[3];
  assert.ok(dx * Math.cos(heading) + dz * Math.sin(heading) > 0, "D goes to the right");
  await page.tap("#fold"); // the panel was folded on a small screen
  assert.ok(await page.isVisible("#threshold"));
  await here.shoot(page, "phone-settings");
  const boxes = await page.evaluate(() => ["panel", "figures"].map((id) => { const { left, right, top, bottom } = document.getElementById(id).getBoundingClientRect(); return { left, right, top, bottom }; }));
  assert.ok(boxes.every(({ left, right, top, bottom }) => left >= 0 && right <= 390 && top >= 0 && bottom <= 844) && boxes[0].bottom < boxes[1].top, "nothing covers anything");
  assert.deepEqual(page.said, []);
  await page.close();
});

// Of MeshStandardMaterial's shader: draws this instead of light.
const drawInstead = (page, glsl) => page.evaluate((text) => {
  const [material] = fjellPage.state.ground.material, taught = material.onBeforeCompile;
  material.onBeforeCompile = (shader) => {
    taught(shader);
    shader.fragmentShader = shader.fragmentShader.replace("#include <dithering_fragment>", text);
  };
  material.customProgramCacheKey = () => text;
  material.needsUpdate = true;
  fjellPage.scene.fog = null;
  fjellPage.scene.background.set(0, 0, 0);
}, glsl);

/** The picture, row by row from the top: of each pixel four bytes. */
const pixels = (page) => page.evaluate(() => {
  const { renderer, scene, camera } = fjellPage;
  renderer.render(scene, camera);
  const gl = renderer.getContext(), { width, height } = renderer.domElement, texels = new Uint8Array(4 * width * height);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, texels);
  let text = "";
  for (let y = height - 1; y >= 0; --y) text += String.fromCharCode(...texels.subarray(4 * width * y, 4 * width * (y + 1)));
  return { width, height, data: btoa(text) };
}).then(({ width, height, data }) => ({ width, height, rgba: Buffer.from(data, "base64") }));

test("the ground has the colours that its pack was baked with", async () => {
  const page = await visit("", { width: 320, height: 180 });
  await page.waitForFunction(() => globalThis.fjellPage, null, patience);
  await page.selectOption("#pack", { label: "Colours" });
  await page.waitForFunction(() => fjellPage.state.terrain?.tileCells === 64, null, patience);
  await still(page);
  await drawInstead(page, "gl_FragColor = vec4(pow(diffuseColor.rgb, vec3(1.0 / 2.2)), 1.0);");
  const shown = await pixels(page);
  const heights = await page.evaluate(() => { // where each pixel's ray meets the ground, as a share of the range; null: it does not
    const { camera, state: { terrain } } = fjellPage, [low, high] = terrain.heightRange, far = camera.position.clone();
    return Array.from({ length: 180 * 320 }, (_, i) => {
      far.set(((i % 320) + 0.5) / 160 - 1, 1 - (Math.floor(i / 320) + 0.5) / 90, 0.5).unproject(camera).sub(camera.position).normalize();
      const hit = terrain.ray(camera.position.toArray(), far.toArray());
      return hit ? (hit.position[1] - low) / (high - low) : null;
    });
  });
  const { stops } = JSON.parse(await readFile("colours.json", "utf8"));
  const colour = (share) => {
    const i = Math.max(1, stops.findIndex(({ height_m }) => height_m >= share)), [a, b] = [stops[i - 1], stops[i]], t = (share - a.height_m) / (b.height_m - a.height_m);
    return a.rgb.map((value, k) => value + t * (b.rgb[k] - value));
  };
  let ground = 0, alike = 0, reds = 0;
  heights.forEach((share, i) => {
    if (share === null) return;
    ++ground;
    const wanted = colour(share), off = Math.max(...wanted.map((value, k) => Math.abs(value - shown.rgba[4 * i + k])));
    reds += wanted[0] > 150 ? 1 : 0;
    if (off <= 24) ++alike; // BC1 has 5 bits a channel, and a texel is seldom the height under a pixel
  });
  console.log(`colours: ${alike} of ${ground} pixels of ground`);
  assert.ok(ground > 10_000 && reds > 500 && reds < ground - 500, `${ground} ${reds}`);
  assert.ok(alike > 0.97 * ground, `${alike} of ${ground}`);
  await page.close();
});

const heapOf = async (session) => {
  for (let i = 0; i < 3; ++i) await session.send("HeapProfiler.collectGarbage");
  const { usedSize, backingStorageSize = 0 } = await session.send("Runtime.getHeapUsage");
  return usedSize + backingStorageSize;
};

/** Frames of a simulated clock, which stands still between calls. step: milliseconds of each. One in eight is drawn. */
const fly = (page, frames, step) => page.evaluate(async ([count, ms]) => {
  const { renderer, state } = fjellPage, most = { work: 0, triangles: 0, bound: 0 };
  const { render } = renderer;
  fjellPage.now ??= performance.now() + 1000;
  for (let i = 0; i < count; ++i) {
    renderer.render = i % 8 === 7 || i === count - 1 ? render : () => {};
    fjellPage.frame(fjellPage.now += ms);
    const { work, triangles } = state.terrain.frame;
    most.work = Math.max(most.work, work);
    most.triangles = Math.max(most.triangles, triangles);
    if (i % 8 === 0) await new Promise((resolve) => { const { port1, port2 } = new MessageChannel(); port1.onmessage = resolve; port2.postMessage(0); }); // the network's turn
  }
  return { ...most, x: fjellPage.camera.position.x, z: fjellPage.camera.position.z, triangleBudget: state.terrain.budget.triangles };
}, [frames, step]);

test("a minute's flight keeps the heap and each frame's budget, and ends with fjell-fly's picture", async () => {
  const page = await visit("", { width: 320, height: 180 });
  await page.waitForFunction(() => globalThis.fjellPage?.state.middle, null, patience);
  await page.evaluate(() => {
    fjellPage.renderer.setAnimationLoop(null);
    fjellPage.state.terrain.settings.maxWork = 4000;
    document.getElementById("time").value = 8;
  });
  const session = await page.context().newCDPSession(page);
  await fly(page, 900, 1000 / 60);
  const before = await heapOf(session), start = await fly(page, 1, 0);
  const flown = await fly(page, 3600, 1000 / 60), after = await heapOf(session);
  console.log(`a minute: ${after - before} bytes more, at most ${flown.work} items and ${flown.triangles} triangles`);
  assert.ok(Math.hypot(flown.x - start.x, flown.z - start.z) > 500, "it flies");
  assert.ok(flown.work <= 4000 + 256, `${flown.work} items`); // a build's last step may take 256 more
  assert.ok(flown.triangles <= flown.triangleBudget);
  assert.ok(after - before < 300_000, `${after - before} bytes`);
  // The end: standing still until the picture is complete.
  await page.evaluate(() => { document.getElementById("fly").checked = false; });
  for (let i = 0; i < 300 && !(await page.evaluate(() => fjellPage.state.terrain.frame.settled)); ++i) await fly(page, 10, 1000 / 60);
  const end = await page.evaluate(() => {
    const { camera, state: { terrain } } = fjellPage, ahead = camera.getWorldDirection(camera.position.clone());
    return { converged: terrain.frame.converged, triangles: terrain.frame.triangles, eye: camera.position.toArray(), look: ahead.multiplyScalar(1000).add(camera.position).toArray(),
      near: 0.05 * Math.min(...terrain.spacing), far: 1.5 * Math.hypot(...terrain.extent), failure: terrain.failure?.message };
  });
  assert.ok(end.converged && end.failure === undefined, "the picture is complete");
  await drawInstead(page, `float away = clamp(1.0 - log2(length(vViewPosition) / ${end.near.toFixed(6)}) / ${Math.log2(end.far / end.near).toFixed(9)}, 0.0, 1.0);
    gl_FragColor = vec4(vec3(away <= 0.0031308 ? 12.92 * away : 1.055 * pow(away, 1.0 / 2.4) - 0.055), 1.0);`); // Mode::distance of runtime/gl
  const shown = await pixels(page), folder = join(process.env.FJELL_SHOTS, "fly");
  await rm(folder, { recursive: true, force: true });
  execFileSync(process.env.FJELL_FLY, [process.env.FJELL_PACK, "--headless", "--frames", "1", "--eye", end.eye.join(), "--look", end.look.join(), "--fov", "50", "--size", "320x180",
    "--error-px", "2", "--mode", "distance", "--render", folder, "--stream", "on", "--wait"], { stdio: "pipe" });
  const native = await texelsOf(await readFile(join(folder, "frame_00000.png")));
  await writeFile(join(process.env.FJELL_SHOTS, "distance.png"), png(shown.rgba, 320, 180));
  const { ground, apart } = compareGreys(shown, native);
  console.log(`beside fjell-fly: ${apart} of ${ground} pixels of ground are not within a pixel and a grey`);
  assert.ok(ground > 20_000, `${ground}`);
  assert.equal(apart, 0);
  await page.close();
});

/** Pixels that show what no pixel within one of the other picture shows, to a grey: render_test.cpp measures so. */
function compareGreys(one, other) {
  const { width, height } = one, grey = (of, x, y) => of.rgba[4 * (y * width + x)];
  const agrees = (a, b, x, y) => {
    let [low, high] = [255, 0];
    for (let v = Math.max(0, y - 1); v <= Math.min(height - 1, y + 1); ++v)
      for (let u = Math.max(0, x - 1); u <= Math.min(width - 1, x + 1); ++u) [low, high] = [Math.min(low, grey(b, u, v)), Math.max(high, grey(b, u, v))];
    return grey(a, x, y) >= low - 1 && grey(a, x, y) <= high + 1;
  };
  let ground = 0, apart = 0;
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x) {
      if (grey(one, x, y) === 0 && grey(other, x, y) === 0) continue;
      ++ground;
      if (!agrees(one, other, x, y) || !agrees(other, one, x, y)) ++apart;
    }
  return { ground, apart };
}

test("a tab that was frozen for a minute goes on where it was, and what it was reading comes", async () => {
  const page = await visit("", { width: 320, height: 180 });
  await page.waitForFunction(() => globalThis.fjellPage?.state.middle, null, patience);
  await page.evaluate(() => { fjellPage.renderer.setAnimationLoop(null); document.getElementById("threshold").value = -1; }); // there is much to read
  await fly(page, 3, 16);
  const session = await page.context().newCDPSession(page), at = () => page.evaluate(() => fjellPage.camera.position.toArray());
  await session.send("Page.setWebLifecycleState", { state: "frozen" });
  await session.send("Page.setWebLifecycleState", { state: "active" });
  const before = await at();
  await fly(page, 1, 60_000); // the clock of a tab that is shown again
  const after = await at(), speed = await page.evaluate(() => fjellPage.state.speed);
  assert.ok(Math.hypot(...after.map((value, i) => value - before[i])) <= speed * 0.1 * 2, "it does not jump");
  await page.evaluate(() => { document.getElementById("fly").checked = false; });
  for (let i = 0; i < 1000 && !(await page.evaluate(() => fjellPage.state.terrain.frame.settled)); ++i) await fly(page, 10, 1000 / 60);
  const done = await page.evaluate(() => ({ ...fjellPage.state.terrain.frame, ranges: null, failure: fjellPage.state.terrain.failure?.message }));
  assert.ok(done.converged && done.failed === 0 && done.failure === undefined, JSON.stringify(done));
  assert.deepEqual(page.said, []);
  await page.close();
});

test("a context that is lost and restored draws as before", async () => {
  const page = await visit("");
  await still(page);
  const before = await look(page, "fjellPage");
  await page.evaluate(() => {
    const lose = fjellPage.renderer.getContext().getExtension("WEBGL_lose_context");
    fjellPage.state.terrain.old = true;
    lose.loseContext();
    setTimeout(() => lose.restoreContext(), 100);
  });
  await page.waitForFunction(() => fjellPage.state.terrain && !fjellPage.state.terrain.old, null, patience);
  await still(page);
  const after = await look(page, "fjellPage");
  assert.ok(Math.abs(after.ground - before.ground) < 0.02 && after.colours > before.colours / 2, JSON.stringify([before, after]));
  await page.close();
});

test("of a server that fails, refuses ranges, sends wrong bytes or replaces the pack the page says one sentence, and goes on where it can", async (t) => {
  t.after(() => { fault = () => false; });
  const pack = await readFile(process.env.FJELL_PACK), says = (page, text) => page.waitForFunction((of) => document.getElementById("message").innerText.includes(of), text, patience);
  const visited = async () => {
    const page = await visit("", { width: 320, height: 180 });
    await page.waitForFunction(() => globalThis.fjellPage, null, patience);
    return page;
  };
  const ranged = (send) => (request, response) => {
    const [, first, last] = /bytes=(\d+)-(\d+)/.exec(request.headers.range).map(Number), end = Math.min(last, pack.length - 1);
    send(response, { "content-range": `bytes ${first}-${end}/${pack.length}`, "content-length": end - first + 1, etag: '"a"' }, pack.subarray(first, end + 1));
    return true;
  };
  fault = (request, response) => { response.writeHead(503).end(); return true; };
  const opening = visit("", { width: 320, height: 180 });
  const page = await opening;
  await says(page, "503");
  assert.match(await page.innerText("#message"), /mountains\.fjell: 503 .*; trying again$/);
  let n = 0;
  fault = ranged((response, headers, bytes) => setTimeout(() => (++n % 3 === 0 ? response.destroy() : response.writeHead(206, headers).end(bytes)), 20)); // slow, and dead now and then
  await still(page);
  assert.equal(await page.innerText("#message"), "", "it goes on");
  await page.close();
  const good = (response, headers, bytes) => response.writeHead(206, headers).end(bytes);
  for (const [text, bad] of [["the pack is damaged here", (response, headers, bytes) => good(response, headers, Buffer.alloc(bytes.length))],
    ["was replaced while it was open", (response, headers, bytes) => good(response, { ...headers, etag: '"b"' }, bytes)]]) {
    let asked = 0;
    fault = ranged((...given) => (++asked > 6 ? bad : good)(...given)); // opening asks four times
    const of = await visited();
    await says(of, text);
    await of.evaluate(() => { document.getElementById("fly").checked = false; });
    await of.waitForFunction(() => fjellPage.state.terrain.frame.settled && fjellPage.state.terrain.frame.inFlight === 0, null, patience);
    assert.ok((await look(of, "fjellPage")).ground > 0.2, "what is there stays");
    await of.close();
  }
  fault = (request, response) => { response.writeHead(200, { "content-length": pack.length }).end(pack); return true; };
  const last = await visited();
  await says(last, "the server sends whole files, not ranges");
  await last.close();
});

test("the golden flight in the page is that of the library, to the bit", async () => {
  const page = await visit("");
  const flown = await page.evaluate(async () => {
    const [{ Terrain }, { fly }] = await Promise.all([import("fjell"), import("./flight.mjs")]);
    return fly(Terrain, await (await fetch("packs/mountains.fjell")).arrayBuffer());
  });
  assert.equal(flown, FJELL_GOLDEN);
  await page.close();
});

test("a worker that dies is replaced, what was read is kept, and two terrains live in one page", async () => {
  const page = await visit("first.html");
  const opened = page.evaluate(async () => {
    const [{ makeView, Terrain }, { WorkerSource }] = await Promise.all([import("fjell"), import("./fjell/loader.js")]);
    const url = new URL("packs/mountains.fjell", location.href);
    const open = async () => {
      const source = new WorkerSource(url, { cache: "packs", onProblem: (error) => console.log(error.message) });
      source.pingMs = 1000; // dead sooner, yet not where one of a busy machine's takes its time
      const terrain = await Terrain.open(source, { maps: true });
      return terrain;
    };
    globalThis.two = await Promise.all([open(), open()]);
    globalThis.settle = (terrain) => terrain.settle([makeView({ eye: [15000, 4000, 30000], target: [15000, 0, 15000], width: 640, height: 360 })]);
  });
  await opened;
  for (const worker of page.workers()) await worker.evaluate(() => globalThis.close()).catch(() => {});
  const [one, other] = await page.evaluate(async () => {
    const frames = await Promise.all(two.map(settle));
    return frames.map((frame, i) => ({ converged: frame.converged, triangles: frame.triangles, failure: two[i].failure?.message }));
  });
  assert.ok(one.converged && one.failure === undefined, JSON.stringify(one));
  assert.deepEqual(one, other);
  const kept = await page.evaluate(async () => (await (await caches.open("packs")).keys()).length);
  assert.ok(kept > 10);
  const third = await page.evaluate(async () => { // a cache whose bytes are wrong is no pack that is damaged
    const [{ Terrain }, { WorkerSource }] = await Promise.all([import("fjell"), import("./fjell/loader.js")]);
    const cache = await caches.open("packs");
    for (const key of await cache.keys()) {
      const bytes = await (await cache.match(key)).arrayBuffer();
      new Uint8Array(bytes).reverse();
      await cache.put(key, new Response(bytes));
    }
    const terrain = await Terrain.open(new WorkerSource(new URL("packs/mountains.fjell", location.href), { cache: "packs" })).catch((error) => error);
    if (terrain instanceof Error) return terrain.message;
    const frame = await settle(terrain);
    return { converged: frame.converged, triangles: frame.triangles, failure: terrain.failure?.message };
  });
  assert.deepEqual(third, one);
  await page.close();
});

test("the guide's first terrain is drawn, casts shadows and is hit by rays", async () => {
  const page = await visit("first.html");
  await page.waitForSelector("canvas", patience);
  const seen = await page.evaluate(async () => {
    const [THREE, { Terrain }, { TerrainObject }] = await Promise.all([import("three"), import("fjell"), import("fjell/three")]);
    const renderer = new THREE.WebGLRenderer();
    renderer.setSize(320, 180);
    const ground = new TerrainObject(await Terrain.open("packs/mountains.fjell", { maps: true }));
    ground.position.set(1000, -200, 500);
    const [wide, deep] = ground.terrain.extent;
    const sun = new THREE.DirectionalLight(0xffffff, 3), scene = new THREE.Scene();
    sun.position.set(0, wide / 14, 0); // low: shadows are long
    sun.target.position.set(wide / 2, 0, deep / 2);
    Object.assign(sun.shadow.camera, { left: -wide, right: wide, top: wide, bottom: -wide, far: 3 * wide });
    sun.shadow.camera.updateProjectionMatrix();
    scene.add(ground, sun, sun.target);
    const camera = new THREE.PerspectiveCamera(50, 16 / 9, 10, 2 * wide);
    camera.position.set(wide / 2, 6000, deep);
    camera.lookAt(wide / 2, 1000, deep / 2);
    ground.terrain.settings.morph = "error";
    for (let i = 0; i < 3000 && !ground.update(camera, renderer, i / 60).settled; ++i) await new Promise((r) => setTimeout(r, 1));
    const brightness = (shadows) => {
      renderer.shadowMap.enabled = sun.castShadow = shadows;
      ground.material[0].needsUpdate = true;
      renderer.render(scene, camera);
      const gl = renderer.getContext(), texels = new Uint8Array(4 * 320 * 180);
      gl.readPixels(0, 0, 320, 180, gl.RGBA, gl.UNSIGNED_BYTE, texels);
      return texels.reduce((sum, value) => sum + value, 0);
    };
    const [lit, shadowed] = [brightness(false), brightness(true)];
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(0, -0.3), camera);
    const [hit] = ray.intersectObject(ground);
    const at = hit.point, off = at.y + 200 - ground.terrain.height(at.x - 1000, at.z - 500);
    return { lit, shadowed, off, calls: renderer.info.programs.length, converged: ground.terrain.frame.converged };
  });
  assert.ok(seen.converged && seen.lit > 1e6);
  assert.ok(seen.shadowed < seen.lit, `shadows take light: ${seen.shadowed} of ${seen.lit}`);
  assert.ok(Math.abs(seen.off) < 1e-3);
  await page.waitForTimeout(500);
  await here.shoot(page, "first");
  assert.deepEqual(page.said, []);
  await page.close();
});
