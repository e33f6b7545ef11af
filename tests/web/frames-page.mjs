// One of three that draw the same ground, by the page's address: ?with=fjell|deck|cesium; of deck.gl, &error=METRES.
// frames.mjs counts what they do.
import { measure } from "./surface.mjs";

const lng = 8.2, lat = 46.5, equator = 40075016.685578488, fovY = 2 * Math.atan(1 / 3); // as web maps have it
const asked = new URLSearchParams(location.search), cos = Math.cos(lat * Math.PI / 180), view = document.getElementById("view");
const { columns, rows, spacing: [dx, dz] } = await (await fetch("heights.json")).json();
const heights = new Float32Array(await (await fetch("heights.bin")).arrayBuffer());

// What is submitted to WebGL, whoever does it.
const drawn = { triangles: 0 };
const gl = WebGL2RenderingContext.prototype;
const count = (mode, vertices, instances = 1) => { drawn.triangles += (mode === 4 ? vertices / 3 : mode === 5 || mode === 6 ? Math.max(vertices - 2, 0) : 0) * instances; };
for (const [name, of] of [["drawElements", (mode, n) => count(mode, n)], ["drawRangeElements", (mode, a, b, n) => count(mode, n)], ["drawElementsInstanced", (mode, n, t, o, i) => count(mode, n, i)],
  ["drawArrays", (mode, first, n) => count(mode, n)], ["drawArraysInstanced", (mode, first, n, i) => count(mode, n, i)]]) {
  const own = gl[name];
  gl[name] = function (...given) {
    of(...given);
    return own.apply(this, given);
  };
}

/** Where the flight is at a share of it: a map's camera, as far away whatever the size of the picture. */
function place(share) {
  const t = 2 * Math.PI * share;
  return { longitude: lng + 0.06 * Math.sin(t), latitude: lat + 0.04 * Math.sin(2 * t), zoom: 12 + Math.log2(innerHeight / 540) + 0.8 * Math.sin(3 * t), pitch: 60, bearing: 360 * share };
}

/** Metres east and south of the middle. */
const mercator = (degrees) => 0.5 - Math.asinh(Math.tan(degrees * Math.PI / 180)) / (2 * Math.PI);
const eastAndSouth = (longitude, y) => [(longitude - lng) / 360 * equator * cos, (y - mercator(lat)) * equator * cos];

/** The same camera: metres east, up and south of the middle, and the direction of sight. */
function inMetres({ longitude, latitude, zoom, pitch, bearing }) {
  const tilt = pitch * Math.PI / 180, turn = bearing * Math.PI / 180;
  const away = 1.5 * innerHeight / (512 * 2 ** zoom / (equator * Math.cos(latitude * Math.PI / 180)));
  const forward = [Math.sin(tilt) * Math.sin(turn), -Math.cos(tilt), -Math.sin(tilt) * Math.cos(turn)];
  const [east, south] = eastAndSouth(longitude, mercator(latitude));
  return { eye: [east, 0, south].map((value, k) => value - away * forward[k]), forward, right: [Math.cos(turn), 0, Math.sin(turn)], away };
}

/** A mesh in samples, of places in metres: as measure() takes it. */
const inSamples = (east, height, south) => [east / dx + (columns - 1) / 2, height, south / dz + (rows - 1) / 2];

/**
 * The largest vertical distance of meshes from a sample that a camera sees, in pixels as if seen from the side; hills
 * in front are looked through. missing: samples in sight that no triangle covers.
 */
function errorOf(meshes, at) {
  const { eye, forward, right } = inMetres(at), pixels = innerHeight / 2 / Math.tan(fovY / 2), wide = innerWidth / innerHeight * Math.tan(fovY / 2);
  const up = [right[1] * forward[2] - right[2] * forward[1], right[2] * forward[0] - right[0] * forward[2], right[0] * forward[1] - right[1] * forward[0]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const scale = new Float32Array(heights.length), missing = new Uint8Array(heights.length);
  heights.forEach((height, i) => {
    const to = [(i % columns - (columns - 1) / 2) * dx - eye[0], height - eye[1], (Math.floor(i / columns) - (rows - 1) / 2) * dz - eye[2]], deep = dot(to, forward);
    if (deep < 50 || Math.abs(dot(to, right)) > wide * deep || Math.abs(dot(to, up)) > Math.tan(fovY / 2) * deep) return;
    scale[i] = pixels / Math.hypot(...to);
    missing[i] = i % columns > 1 && i % columns < columns - 2 && i / columns > 2 && i / columns < rows - 2 ? 1 : 0; // a rim may be a sample off
  });
  const samples = scale.reduce((sum, one) => sum + (one > 0 ? 1 : 0), 0);
  let worst = 0;
  for (const { positions, triangles } of meshes)
    worst = Math.max(worst, measure(heights, columns, rows, positions, triangles, (i, metres) => { missing[i] = 0; return metres * scale[i]; }).worst);
  return { worst, samples, missing: missing.reduce((sum, one) => sum + one, 0) };
}

const hosts = {
  async fjell() {
    const [THREE, { Terrain }, { WorkerSource }, { TerrainObject }] = await Promise.all([import("three"), import("fjell"), import("fjell/loader"), import("fjell/three")]);
    return { start: async () => {
      const terrain = await Terrain.open(new WorkerSource("pack.fjell")), renderer = new THREE.WebGLRenderer({ antialias: false }), ground = new TerrainObject(terrain);
      Object.assign(terrain.settings, { maxError: 2, maxMs: 4 });
      renderer.setSize(innerWidth, innerHeight);
      view.append(renderer.domElement);
      const sun = new THREE.DirectionalLight(0xffffff, 3), scene = new THREE.Scene().add(ground, sun, new THREE.HemisphereLight());
      scene.background = new THREE.Color(0x9fb6c8);
      sun.position.set(-2, 2, -1);
      ground.position.set(-terrain.extent[0] / 2, 0, -terrain.extent[1] / 2);
      const camera = new THREE.PerspectiveCamera(fovY * 180 / Math.PI, innerWidth / innerHeight, 50, 2e5);
      return {
        draw(at) {
          const { eye, forward } = inMetres(at);
          camera.position.set(...eye);
          camera.lookAt(...eye.map((value, k) => value + forward[k]));
          ground.update(camera, renderer);
          renderer.render(scene, camera);
        },
        complete: () => terrain.frame.converged && terrain.frame.inFlight === 0,
        meshes() {
          const { ranges, rangeCount } = terrain.frame, { vertexSlots, heightSlots, indexSlots } = terrain;
          const positions = Float32Array.from(vertexSlots, (value, i) => (i % 3 === 0 ? value : i % 3 === 1 ? heightSlots[i + 1] : vertexSlots[i - 1]));
          return Array.from({ length: rangeCount }, (_, i) => ({ positions, triangles: indexSlots.slice(ranges[2 * i], ranges[2 * i] + ranges[2 * i + 1]) }));
        },
      };
    } };
  },
  async deck() {
    const deck = await import("./deckgl.bundle.mjs");
    return { start: async () => {
      const ground = new deck.TerrainLayer({ id: "ground", elevationData: "tiles/{z}/{x}/{y}.png", minZoom: 0, maxZoom: 11, meshMaxError: Number(asked.get("error")), color: [150, 160, 130],
        extent: [8.03, 46.38, 8.37, 46.62], elevationDecoder: { rScaler: 256, gScaler: 1, bScaler: 1 / 256, offset: -32768 },
        loadOptions: { terrain: { workerUrl: new URL("node_modules/@loaders.gl/terrain/dist/terrain-worker.js", location.href).href } } });
      const made = new deck.Deck({ parent: view, width: innerWidth, height: innerHeight, useDevicePixels: false, viewState: place(0), controller: false, layers: [ground] });
      return {
        draw(at) {
          made.setProps({ viewState: at });
          if (made.isInitialized) made.redraw("frame");
        },
        complete: () => made.isInitialized && ground.isLoaded,
        meshes() {
          const { tiles } = ground.getSubLayers()[0].state.tileset;
          return tiles.filter((tile) => tile.isVisible && tile.content).map(({ content: [mesh] }) => { // x, y and height, of 512 for the world
            const from = mesh.attributes.POSITION.value, positions = new Float32Array(from.length);
            for (let i = 0; i < from.length; i += 3) {
              const [east, south] = eastAndSouth((from[i] / 512 - 0.5) * 360, 1 - from[i + 1] / 512);
              positions.set(inSamples(east, from[i + 2], south), i);
            }
            return { positions, triangles: mesh.indices.value };
          });
        },
      };
    } };
  },
  async cesium() {
    globalThis.CESIUM_BASE_URL = new URL("node_modules/cesium/Build/Cesium/", location.href).href;
    const Cesium = await import("cesium");
    return { start: async () => {
      const nothing = document.createElement("div");
      const widget = new Cesium.CesiumWidget(view, { baseLayer: false, creditContainer: nothing, creditViewport: nothing, useDefaultRenderLoop: false, msaaSamples: 1, skyBox: false, skyAtmosphere: false,
        terrainProvider: await Cesium.CesiumTerrainProvider.fromUrl("heights") });
      const { scene, camera } = widget, globe = scene.globe;
      Object.assign(globe, { showGroundAtmosphere: false, showWaterEffect: false, baseColor: Cesium.Color.fromBytes(150, 160, 130), enableLighting: true, maximumScreenSpaceError: 2 });
      Object.assign(scene, { sun: undefined, moon: undefined, backgroundColor: Cesium.Color.fromBytes(0x9f, 0xb6, 0xc8) });
      scene.fog.enabled = false;
      camera.frustum.fov = innerWidth > innerHeight ? 2 * Math.atan(Math.tan(fovY / 2) * innerWidth / innerHeight) : fovY;
      let drawnOnce = false;
      return {
        draw(at) {
          const { away } = inMetres(at), target = Cesium.Cartesian3.fromDegrees(at.longitude, at.latitude, 0);
          camera.lookAt(target, new Cesium.HeadingPitchRange(at.bearing * Math.PI / 180, (at.pitch - 90) * Math.PI / 180, away));
          widget.resize();
          widget.render();
          drawnOnce = true;
        },
        complete: () => drawnOnce && globe.tilesLoaded,
        meshes: () => globe._surface._tilesToRender.map(({ rectangle, data: { renderedMesh: mesh } }) => {
          const { encoding, vertices } = mesh, n = vertices.length / encoding.stride, positions = new Float32Array(3 * n), degrees = 180 / Math.PI;
          for (let i = 0; i < n; ++i) {
            const { x, y } = encoding.decodeTextureCoordinates(vertices, i, new Cesium.Cartesian2()), { west, south, east, north } = rectangle;
            const [right, down] = eastAndSouth((west + x * (east - west)) * degrees, mercator((south + y * (north - south)) * degrees));
            positions.set(inSamples(right, encoding.decodeHeight(vertices, i), down), 3 * i);
          }
          return { positions, triangles: mesh.indices.subarray(0, mesh.indexCountWithoutSkirts) };
        }),
      };
    } };
  },
};

const host = await hosts[asked.get("with")]();
const turn = () => new Promise((resolve) => requestAnimationFrame(resolve));

globalThis.frames = {
  /** From opening to the first picture that lacks nothing: milliseconds, and the triangles of a frame then. */
  async first() {
    const started = performance.now();
    host.made = await host.start();
    let longest = 0, ms = 0;
    for (let last = performance.now(), still = 0; still < 3;) {
      await turn();
      drawn.triangles = 0;
      host.made.draw(place(0));
      const now = performance.now();
      longest = Math.max(longest, now - last);
      last = now;
      if (!host.made.complete()) still = 0;
      else if (++still === 1) ms = now - started;
      if (now - started > 120_000) throw new Error("no complete picture in two minutes");
    }
    return { ms, triangles: drawn.triangles, longest };
  },
  error: () => errorOf(host.made.meshes(), place(0)),
  /** A flight of so many frames: milliseconds from frame to frame, and of each one's calls. */
  async fly(count) {
    const apart = [], own = [], triangles = [];
    let incomplete = 0;
    for (let i = 0, last = await turn(); i < count; ++i) {
      drawn.triangles = 0;
      const before = performance.now();
      host.made.draw(place(i / count));
      own.push(performance.now() - before);
      triangles.push(drawn.triangles);
      incomplete += host.made.complete() ? 0 : 1;
      const now = await turn();
      apart.push(now - last);
      last = now;
    }
    const sorted = (of) => [...of].sort((a, b) => a - b), middle = (of) => sorted(of)[count >> 1];
    return { median: middle(apart), longest: Math.max(...apart), ownMedian: middle(own), ownLongest: Math.max(...own), triangles: middle(triangles), incomplete };
  },
};
