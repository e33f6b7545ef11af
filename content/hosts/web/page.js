// A page that flies: the packs of packs.json, streamed by ranges, drawn with three.js. Touch, mouse and keyboard.
import * as THREE from "three";

import { Terrain } from "fjell";
import { WorkerSource } from "fjell/loader";
import { TerrainObject } from "fjell/three";

const $ = (id) => document.getElementById(id);
const say = (text) => { $("message").textContent = text; };
const canvas = $("view");

const renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
const scene = new THREE.Scene();
const sky = new THREE.Color(0.62, 0.72, 0.82);
scene.background = sky;
const camera = new THREE.PerspectiveCamera(50, 1, 1, 1e6);
const sun = new THREE.DirectionalLight(0xfff1dc, 3.2);
scene.add(sun, sun.target, new THREE.HemisphereLight(0xbcd2ea, 0x6b6a58, 1.1));

const state = { terrain: null, ground: null, levels: null, opened: 0, heading: 0, pitch: -0.2, speed: 1, readBytes: 0, firstPictureMs: null,
  longestMs: 0, frames: 0, distance: 0, probe: "" };
const keys = new Set();

// --- levels: the vertex at a triangle's right angle, its first, says how often the tile was halved for it. WebGL takes
// what is flat from a triangle's last vertex, so these triangles are turned.

function levelsOf(ground) {
  const { geometry: from, material: [lit], terrain } = ground, geometry = new THREE.BufferGeometry();
  for (const name of ["position", "fjell_morph"]) geometry.setAttribute(name, from.attributes[name]);
  geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(terrain.indexSlots.length), 1).setUsage(THREE.DynamicDrawUsage));
  const material = new THREE.MeshStandardMaterial({ roughness: 1 }), most = Math.log2(terrain.tileCells).toFixed(1);
  material.onBeforeCompile = (shader) => {
    lit.onBeforeCompile(shader);
    shader.vertexShader = "flat varying float level;\n" + shader.vertexShader.replace("#include <project_vertex>", `#include <project_vertex>
      ivec2 at = ivec2(fjell_sample + 0.5);
      int both = at.x | at.y, cells = both & -both;
      level = cells == 0 ? 0.0 : max(2.0 * (${most} - log2(float(cells))) - ((at.x & at.y & cells) != 0 ? 1.0 : 0.0), 0.0);`);
    shader.fragmentShader = "flat varying float level;\n" + shader.fragmentShader.replace("#include <color_fragment>", `#include <color_fragment>
      vec3 hue = abs(fract(0.75 - 0.375 * level / ${most} + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0; // violet is coarse, red fine
      diffuseColor.rgb = (0.15 + 0.85 * clamp(hue, 0.0, 1.0)) * (mod(floor(level + 0.5), 2.0) > 0.5 ? 0.4 : 0.75);`);
  };
  const mesh = new THREE.Mesh(geometry, material);
  mesh.frustumCulled = false;
  mesh.raycast = () => {};
  ground.add(mesh);
  return mesh;
}

function showLevels(on) {
  const { ground, terrain: { indexSlots, frame: { ranges, rangeCount } } } = state;
  if (on) state.levels ??= levelsOf(ground);
  ground.material[0].visible = !on;
  if (!state.levels) return;
  state.levels.visible = on;
  if (!on) return;
  const { index } = state.levels.geometry, to = index.array;
  let n = 0;
  for (let r = 0; r < rangeCount; ++r)
    for (let i = ranges[2 * r]; i < ranges[2 * r] + ranges[2 * r + 1]; i += 3) {
      to[n++] = indexSlots[i + 1];
      to[n++] = indexSlots[i + 2];
      to[n++] = indexSlots[i];
    }
  state.levels.geometry.setDrawRange(0, n);
  index.clearUpdateRanges();
  index.addUpdateRange(0, n);
  index.needsUpdate = true;
}

// --- opening

async function open({ name, url }, keepCamera = false) {
  const number = ++state.opened, started = performance.now();
  say(`Opening ${name}`);
  state.ground?.removeFromParent();
  state.ground?.dispose();
  state.levels?.geometry.dispose();
  state.levels?.material.dispose();
  state.terrain?.close();
  Object.assign(state, { terrain: null, ground: null, levels: null, readBytes: 0, firstPictureMs: null, longestMs: 0, frames: 0, distance: 0 });
  const most = 2 ** Number($("triangles").value);
  try {
    const source = new WorkerSource(url, { onProgress: (bytes) => { if (number === state.opened) state.readBytes = bytes; },
      onProblem: (error) => { if (number === state.opened) say(`${error.message}; trying again`); } });
    const terrain = await Terrain.open(source, { vertices: most / 2, triangles: most, maps: true, mapBytes: (innerWidth > 640 ? 72 : 24) << 20 });
    if (number !== state.opened) return terrain.close(); // another one was chosen meanwhile
    state.terrain = terrain;
    state.started = started;
    state.ground = new TerrainObject(terrain);
    scene.add(state.ground);
    const [wide, deep] = terrain.extent, high = terrain.heightRange[1];
    camera.far = 3 * Math.hypot(wide, deep);
    scene.fog = new THREE.Fog(sky, 0.06 * wide, 0.8 * wide);
    state.middle = null;
    state.speed = wide / 180;
    if (!keepCamera) {
      camera.position.set(wide * 0.5, high + 0.03 * wide, deep * 0.8);
      state.heading = 0;
      state.pitch = -0.25;
    }
    sun.position.set(-0.6 * wide, 0.5 * wide, -0.35 * wide);
    say("");
  } catch (error) {
    if (number === state.opened) say(error.message);
  }
}

// --- moving

/** The highest of some places, away from the rim: what the flight goes around. */
function findMiddle(place) {
  const { terrain } = state, [wide, deep] = terrain.extent, cells = 32;
  let best = -Infinity;
  state.middle = [wide / 2, deep / 2];
  for (let i = 0; i < cells * cells; ++i) {
    const at = [wide * (0.2 + 0.6 * (i % cells) / cells), deep * (0.25 + 0.5 * Math.floor(i / cells) / cells)];
    const height = terrain.height(...at);
    if (height > best) [best, state.middle] = [height, at];
  }
  if (!place) return;
  camera.position.set(state.middle[0], best + 0.02 * wide, state.middle[1] + 0.08 * wide);
}

function move(seconds) {
  const { terrain } = state, [wide, deep] = terrain.extent;
  const forward = Number(keys.has("KeyW") || keys.has("ArrowUp")) - Number(keys.has("KeyS") || keys.has("ArrowDown"));
  const aside = Number(keys.has("KeyD")) - Number(keys.has("KeyA"));
  const turn = Number(keys.has("ArrowRight")) - Number(keys.has("ArrowLeft"));
  const rise = Number(keys.has("KeyE") || keys.has("Space")) - Number(keys.has("KeyQ"));
  const p = camera.position;
  const below = terrain.height(p.x, p.z);
  const clearance = Math.max(p.y - (Number.isNaN(below) ? terrain.heightRange[0] : below), 2);
  const speed = Math.max(clearance * 0.8, state.speed * 0.05) * (keys.has("ShiftLeft") ? 4 : 1) * seconds;
  state.heading += turn * 0.9 * seconds;
  if ($("fly").checked) {
    state.distance += state.speed * seconds;
    const [x0, z0] = state.middle ?? [wide / 2, deep / 2], reach = 0.15 * Math.min(wide, deep);
    const eight = (t) => [x0 + reach * Math.sin(t), z0 + reach * 0.6 * Math.sin(2 * t)];
    const t = state.distance / reach, [x, z] = eight(t), ahead = eight(t + 0.04);
    const ground = Math.max(terrain.height(x, z) || -Infinity, terrain.height(...ahead) || -Infinity, terrain.heightRange[0]);
    const wanted = ground + 0.012 * wide;
    p.set(x, p.y + (wanted - p.y) * Math.min(1, seconds * 0.8), z);
    const heading = Math.atan2(ahead[0] - x, -(ahead[1] - z));
    state.heading += Math.atan2(Math.sin(heading - state.heading), Math.cos(heading - state.heading)) * Math.min(1, seconds);
    state.pitch += (-0.2 - state.pitch) * Math.min(1, seconds);
  } else {
    walk(forward * speed, aside * speed);
    p.y += rise * speed;
  }
  p.y = Math.max(p.y, (Number.isNaN(below) ? -Infinity : below) + 2);
  camera.rotation.set(state.pitch, -state.heading, 0, "YXZ");
  camera.near = Math.max(0.3, clearance * 0.2);
  camera.updateProjectionMatrix();
}

function walk(forward, aside) {
  const [sin, cos] = [Math.sin(state.heading), Math.cos(state.heading)];
  camera.position.x += forward * sin * Math.cos(state.pitch) + aside * cos;
  camera.position.z += -forward * cos * Math.cos(state.pitch) + aside * sin;
  camera.position.y += forward * Math.sin(state.pitch);
}

addEventListener("keydown", ({ code, target }) => {
  if (target instanceof HTMLSelectElement || target instanceof HTMLInputElement) return;
  keys.add(code);
  if (/^(Key[WASDQE]|Arrow|Space)/.test(code)) $("fly").checked = false;
});
addEventListener("keyup", ({ code }) => keys.delete(code));
addEventListener("blur", () => keys.clear());

const pointers = new Map();
canvas.addEventListener("pointerdown", (event) => {
  canvas.focus();
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
});
for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, ({ pointerId }) => pointers.delete(pointerId));
canvas.addEventListener("pointermove", (event) => {
  const last = pointers.get(event.pointerId);
  if (!last) return probe(event);
  const dx = event.clientX - last.x, dy = event.clientY - last.y;
  if (Math.abs(dx) + Math.abs(dy) === 0) return;
  $("fly").checked = false;
  if (pointers.size === 1) { // one finger looks
    state.heading -= dx * 0.003;
    state.pitch = Math.max(-1.5, Math.min(1.5, state.pitch + dy * 0.003));
  } else { // two move: apart is forward, aside is aside
    const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    const apart = Math.hypot(event.clientX - other.x, event.clientY - other.y) - Math.hypot(last.x - other.x, last.y - other.y);
    const clearance = camera.near * 5;
    walk(apart * clearance * 0.01, -dx * clearance * 0.005);
  }
  last.x = event.clientX;
  last.y = event.clientY;
});
canvas.addEventListener("wheel", (event) => {
  $("fly").checked = false;
  walk(-event.deltaY * camera.near * 0.005, 0);
  event.preventDefault();
}, { passive: false });

// What is under the mouse: where the ground is, and how far the pack may be from the original heights there.
const raycaster = new THREE.Raycaster();
function probe({ clientX, clientY }) {
  if (!state.terrain) return;
  raycaster.setFromCamera(new THREE.Vector2(2 * clientX / innerWidth - 1, 1 - 2 * clientY / innerHeight), camera);
  const { origin, direction } = raycaster.ray;
  const hit = state.terrain.ray(origin.toArray(), direction.toArray());
  state.probe = hit ? `${hit.position[1].toFixed(1)} m ± ${hit.error.toFixed(hit.error < 1 ? 2 : 0)}` : "";
}

// --- controls

const text = (value, digits = 0) => value.toLocaleString("en", { maximumFractionDigits: digits, minimumFractionDigits: digits });
function settle() {
  $("threshold-out").value = `${2 ** Number($("threshold").value) >= 1 ? text(2 ** Number($("threshold").value), 1) : text(2 ** Number($("threshold").value), 2)} px`;
  $("time-out").value = `${text(Number($("time").value), 1)} ms`;
  $("triangles-out").value = text(2 ** Number($("triangles").value));
}
for (const id of ["threshold", "time", "triangles"]) $(id).addEventListener("input", settle);
$("triangles").addEventListener("change", () => open(packs[$("pack").value], true)); // memory is fixed at opening
canvas.addEventListener("webglcontextrestored", () => open(packs[$("pack").value], true)); // maps are lost with it
$("fold").addEventListener("click", () => {
  const open_ = $("rest").hidden;
  $("rest").hidden = !open_;
  $("fold").setAttribute("aria-expanded", String(open_));
});
if (innerWidth <= 640) $("fold").click();

const figures = ["frame", "update", "triangles", "error bound", "read", "in flight", "spent", "under mouse"];
$("figures").innerHTML = figures.map((name) => `<dt>${name}</dt><dd></dd>`).join("");
const cells = [...$("figures").querySelectorAll("dd")];
let shown = 0;
function show(now, frameMs, frame) {
  if (now - shown < 200) return; // numbers that can be read
  shown = now;
  const { terrain } = state, mb = (bytes) => `${text(bytes / 1e6, 1)} MB`;
  const values = [`${text(frameMs, 1)} ms`, `${text(frame.updateMs, 2)} ms`, text(frame.trianglesDrawn),
    frame.errorBound > 1e3 ? "not yet" : `${text(frame.errorBound, 2)} px`, mb(state.readBytes), text(frame.inFlight),
    terrain.shortOf.join(", ") || "none", state.probe || "-"];
  values.forEach((value, i) => { cells[i].textContent = value; });
}

function resize() {
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  renderer.setSize(innerWidth, innerHeight, false);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
}
addEventListener("resize", resize);
resize();

let last = 0;
function frame(now) {
  const frameMs = now - last;
  last = now;
  if (!state.terrain) return renderer.render(scene, camera);
  const seconds = Math.min(frameMs / 1e3, 0.1); // a tab that was hidden does not jump
  Object.assign(state.terrain.settings, { maxError: 2 ** Number($("threshold").value), maxMs: Number($("time").value), morph: "time" });
  const [across, down] = state.terrain.tiles;
  if (!state.middle && state.terrain.frame.pagesLoaded >= across * down) findMiddle(state.frames < 100 && $("fly").checked);
  move(seconds);
  state.ground.wireframe = $("wire").checked;
  if (!$("hold").checked || state.frames === 0) state.ground.update(camera, renderer, now / 1e3);
  else camera.updateMatrixWorld();
  showLevels($("levels").checked);
  renderer.render(scene, camera);
  const done = state.terrain.frame;
  ++state.frames;
  if (state.frames > 10) state.longestMs = Math.max(state.longestMs, frameMs);
  if (state.firstPictureMs === null && done.converged) state.firstPictureMs = performance.now() - state.started;
  if (state.terrain.failure) say(state.terrain.failure.message);
  else if (done.inFlight === 0) say("");
  show(now, frameMs, done);
}
renderer.setAnimationLoop(frame);

const packs = await (await fetch("packs.json")).json();
packs.forEach(({ name }, i) => $("pack").add(new Option(name, String(i))));
$("pack").addEventListener("change", () => open(packs[$("pack").value]));
settle();
await open(packs[0]);
globalThis.fjellPage = { state, camera, renderer, scene, frame }; // for tests
