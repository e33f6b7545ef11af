// The page content/hosts/web and the guide's first terrain, in headless Chromium. FJELL_SITE: the folder that build.sh
// has made; FJELL_SHOTS: where pictures of the page go, to be looked at.
import assert from "node:assert/strict";
import { access, copyFile, mkdir } from "node:fs/promises";
import { join } from "node:path";
import test, { after, before } from "node:test";

import { chromium } from "playwright-core";

import { serve } from "./serve.mjs";

const { FJELL_SITE, FJELL_GOLDEN, FJELL_SHOTS } = process.env;
const patience = { timeout: 90_000 };
let server, browser, home;

before(async () => {
  await mkdir(FJELL_SHOTS, { recursive: true });
  for (const file of ["flight.mjs"]) await copyFile(file, join(FJELL_SITE, file));
  server = await serve(FJELL_SITE);
  home = `http://127.0.0.1:${server.address().port}/`;
  const executablePath = await access("/usr/bin/chromium").then(() => "/usr/bin/chromium");
  browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"] });
});
after(async () => {
  await browser?.close();
  server?.closeAllConnections();
  server?.close();
});

async function visit(path, viewport = { width: 640, height: 360 }) {
  const page = await browser.newPage({ viewport });
  page.said = [];
  page.on("pageerror", (error) => page.said.push(error.message));
  page.on("console", (message) => { if (message.type() === "error") page.said.push(message.text()); });
  await page.goto(home + path);
  return page;
}

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
    await page.screenshot({ path: join(FJELL_SHOTS, `${name}.png`) });
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
      source.pingMs = 50; // dead sooner
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
  await page.screenshot({ path: join(FJELL_SHOTS, "first.png") });
  assert.deepEqual(page.said, []);
  await page.close();
});
