// A terrain on a map of MapLibre GL: a custom layer that draws the mesh of a pack, refined for the map's camera, within the
// map's own context and depth. three.js draws it, as an object of fjell/three.
import * as THREE from "three";

import { TerrainObject } from "./three.js";

const turn = 2 * Math.PI, radius = 6378137, flattening = 1 / 298.257223563; // WGS 84
const mapRadius = 6371008.8; // with which MapLibre makes heights of metres

/** Where longitude and latitude are in the map: 0 to 1, from the north-west. */
function mapPlace([lng, lat]) {
  const sin = Math.sin(lat * Math.PI / 180);
  return [lng / 360 + 0.5, 0.5 - Math.log((1 + sin) / (1 - sin)) / (4 * Math.PI)];
}

function checked({ id, terrain, center, bearing, crs }) {
  if (typeof id !== "string" || id === "") throw new TypeError("id: give a name that no other layer has");
  if (typeof terrain?.update !== "function") throw new TypeError("terrain: give what Terrain.open has opened");
  if (!Number.isFinite(bearing)) throw new RangeError(`bearing: is ${bearing}; give degrees`);
  if (crs !== undefined && crs !== "EPSG:3857") throw new RangeError(`crs: is ${crs}; give EPSG:3857, or center for other packs`);
  if (crs !== undefined) return;
  const [lng, lat] = center ?? [];
  if (!(Math.abs(lng) <= 180 && Math.abs(lat) < 85.06)) throw new RangeError("center: give the longitude and latitude of the pack's middle, in degrees");
}

export class TerrainLayer {
  #map; #renderer; #lost = false; #toMap = new THREE.Matrix4(); #all = new THREE.Matrix4(); #options;

  /**
   * terrain: of `Terrain.open()`. center: longitude and latitude of the pack's middle. bearing: how far the pack's north
   * is turned from north there, clockwise. A pack in Web Mercator (crs: "EPSG:3857") has its own place.
   */
  constructor({ id = "fjell", terrain, center, bearing = 0, crs, ...object } = {}) {
    checked({ id, terrain, center, bearing, crs });
    this.id = id;
    this.type = "custom";
    this.renderingMode = "3d";
    this.terrain = terrain;
    this.#options = object;
    /** Metres east, up and south of the pack's middle. */
    this.scene = new THREE.Scene();
    this.sun = new THREE.DirectionalLight(0xfff1dc, 3);
    this.sun.position.set(-2, 2, -1);
    this.scene.add(this.sun, new THREE.HemisphereLight(0xbcd2ea, 0x6b6a58, 1.1));
    this.camera = new THREE.PerspectiveCamera();
    this.camera.matrixAutoUpdate = false;
    this.#place(center, bearing, crs);
  }

  #place(center, bearing, crs) {
    const { origin, extent } = this.terrain, equator = turn * radius;
    const [x, y] = crs ? [0.5 + (origin[0] + extent[0] / 2) / equator, 0.5 - (origin[1] - extent[1] / 2) / equator] : mapPlace(center);
    // Metres of the map's whole width and height, at that latitude: the earth is no ball.
    const cos = 1 / Math.cosh(Math.PI * (1 - 2 * y)), e2 = flattening * (2 - flattening), w = 1 - e2 * (1 - cos * cos);
    const east = crs ? equator : turn * cos * radius / Math.sqrt(w), south = crs ? equator : turn * cos * radius * (1 - e2) / w ** 1.5, up = turn * cos * mapRadius;
    const turned = new THREE.Matrix4().makeRotationY(-bearing * Math.PI / 180);
    this.#toMap.set(1 / east, 0, 0, x, 0, 0, 1 / south, y, 0, 1 / up, 0, 0, 0, 0, 0, 1).multiply(turned); // the map's axes: east, south, up
  }

  onAdd(map, gl) {
    if (this.#map === map && !this.#lost) return; // put on again: maps come once, and are still there
    this.dispose();
    this.#map = map;
    this.#lost = false;
    map.getCanvas().addEventListener("webglcontextlost", () => { this.#lost ||= this.#map === map; }, { once: true });
    this.#renderer = new THREE.WebGLRenderer({ canvas: map.getCanvas(), context: gl });
    this.#renderer.autoClear = false;
    this.object = new TerrainObject(this.terrain, this.#options);
    this.object.position.set(-this.terrain.extent[0] / 2, 0, -this.terrain.extent[1] / 2);
    this.scene.add(this.object);
  }

  render(gl, { defaultProjectionData }) {
    if (defaultProjectionData.projectionTransition > 0) return; // a globe: the ground is no plane there
    this.#look(defaultProjectionData.mainMatrix);
    const renderer = this.#renderer, range = gl.getParameter(gl.DEPTH_RANGE);
    renderer.resetState(); // the map has changed it
    gl.depthRange(range[0], range[1]); // flat layers lie behind what is solid
    renderer.setViewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    const frame = this.object.update(this.camera, renderer);
    renderer.render(this.scene, this.camera);
    if (!frame.settled) this.#map.triggerRepaint();
  }

  /** Frees what a layer that was taken off keeps on the GPU, for being put on again. */
  dispose() {
    this.object?.removeFromParent();
    this.object?.dispose();
    this.#renderer?.dispose();
    this.object = this.#renderer = this.#map = undefined;
  }

  /** The map's camera, out of the matrix that takes the map to the picture: nothing else of the map is asked. */
  #look(mapToPicture) {
    const all = this.#all.fromArray(mapToPicture).multiply(this.#toMap), e = all.elements;
    all.multiplyScalar(1 / Math.hypot(e[3], e[7], e[11])); // the same picture, with w in metres
    const row = (i) => [e[i], e[4 + i], e[8 + i]];
    // The eye is where x, y and w are 0. w grows along the direction of sight.
    const [eye, forward, right] = [vectors.eye, vectors.forward, vectors.right];
    vectors.rows.set(...row(0), ...row(1), ...row(3));
    eye.set(-e[12], -e[13], -e[15]).applyMatrix3(vectors.rows.invert());
    forward.set(...row(3)).normalize();
    right.set(...row(0));
    right.addScaledVector(forward, -right.dot(forward)).normalize();
    const up = vectors.up.crossVectors(right, forward);
    this.camera.matrix.makeBasis(right, up, forward.negate()).setPosition(eye);
    this.camera.matrixWorldNeedsUpdate = true;
    this.camera.updateMatrixWorld();
    this.camera.projectionMatrix.multiplyMatrices(all, this.camera.matrixWorld);
    this.camera.projectionMatrixInverse.copy(this.camera.projectionMatrix).invert();
    const p = this.camera.projectionMatrix.elements;
    this.camera.near = p[14] / (p[10] - 1);
    this.camera.far = p[14] / (p[10] + 1);
  }
}

const vectors = { eye: new THREE.Vector3(), forward: new THREE.Vector3(), right: new THREE.Vector3(), up: new THREE.Vector3(), rows: new THREE.Matrix3() };
