// A terrain as an object of three.js: uploads what has changed, morphs in its shader, shows the pack's maps, casts and
// receives shadows, and is hit by rays. Its axes are three's: x east, y up, z south, metres from the first sample.
import * as THREE from "three";

const mostViews = 8;

const vertexHead = /* glsl */ `
attribute vec4 fjell_morph; // height where it starts, error, radius, when it came
uniform int fjell_views;
uniform vec3 fjell_eye[${mostViews}];
uniform vec2 fjell_q[${mostViews}];
uniform vec2 fjell_time; // now, how long
uniform vec2 fjell_spacing;
varying vec2 fjell_sample;
float fjell_height(vec3 at) { // morphed_height_m() of fjell/cut.h
  float t = fjell_views == 0 ? 1.0 : 0.0;
  for (int i = 0; i < ${mostViews}; ++i) {
    if (i >= fjell_views) break;
    float start = fjell_morph.z + fjell_morph.y * fjell_q[i].x, end = fjell_morph.z + fjell_morph.y * fjell_q[i].y;
    float far = distance(at, fjell_eye[i]);
    t = max(t, start > end ? (start - far) / (start - end) : far < start ? 1.0 : 0.0);
  }
  if (fjell_views > 0) {
    float age = fjell_time.x - fjell_morph.w;
    t = min(t, (age < 0.0 ? age + 1024.0 : age) / fjell_time.y);
  }
  return mix(fjell_morph.x, at.y, clamp(t, 0.0, 1.0));
}
`;
const vertexBody = /* glsl */ `
vec3 transformed = vec3(position.x, fjell_height(position), position.z);
fjell_sample = position.xz / fjell_spacing;
`;

const fragmentHead = /* glsl */ `
precision highp sampler2DArray;
uniform sampler2DArray fjell_colour, fjell_normals;
uniform vec3 fjell_maps; // texels a side of colour and of normals, 0: none; cells of a tile
uniform vec2 fjell_tiles;
uniform mat3 normalMatrix;
varying vec2 fjell_sample;
vec4 fjell_texel(sampler2DArray map, float side) {
  vec2 at = fjell_sample / fjell_maps.z, tile = clamp(floor(at), vec2(0.0), fjell_tiles - 1.0);
  float scale = (side - 1.0) / side; // the outermost texels' centres are on the tile's border
  vec2 uv = (at - tile) * scale + 0.5 / side;
  return textureGrad(map, vec3(uv, tile.y * fjell_tiles.x + tile.x), dFdx(at) * scale, dFdy(at) * scale);
}
`;
const fragmentColour = /* glsl */ `
if (fjell_maps.x > 0.0) {
  vec4 texel = fjell_texel(fjell_colour, fjell_maps.x);
  diffuseColor.rgb *= mix(vec3(1.0), pow(texel.rgb, vec3(2.2)) / 0.35, texel.a);
}
`;
const fragmentNormal = /* glsl */ `
float faceDirection = 1.0;
vec3 normal = normalize(cross(dFdx(-vViewPosition), dFdy(-vViewPosition))); // of the triangle
if (fjell_maps.y > 0.0) { // of the map, where it has come
  vec4 texel = fjell_texel(fjell_normals, fjell_maps.y);
  vec2 slope = texel.xy * (255.0 / 127.0) - 128.0 / 127.0;
  vec3 up = vec3(slope.x, sqrt(max(1.0 - dot(slope, slope), 0.0)), slope.y);
  normal = normalize(mix(normal, normalMatrix * up, texel.a));
}
vec3 nonPerturbedNormal = normal;
`;

/** The maps of all tiles, a layer each. They go with their context: open the terrain again for another one. */
class TileMaps {
  constructor(log2, tiles) {
    this.side = log2 > 0 ? 2 ** log2 : 0;
    this.mips = log2 > 0 ? log2 - 1 : 1;
    this.tiles = tiles;
    this.texture = new THREE.DataArrayTexture(null, 1, 1, 1); // never uploaded by three: its version stays 0
    this.waiting = [];
  }
  add(tile, mip, side, rgba) {
    this.waiting.push([tile, mip, side, rgba.slice()]);
  }
  upload(renderer) {
    const gl = renderer.getContext(), properties = renderer.properties.get(this.texture);
    if (!properties.__webglTexture) {
      const most = gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS);
      if (this.side > 0 && this.tiles > most) throw new Error(`maps: the terrain has ${this.tiles} tiles, and this machine ${most} layers of textures; open it without maps`);
      properties.__webglTexture = gl.createTexture();
      properties.__webglInit = true;
      renderer.state.bindTexture(gl.TEXTURE_2D_ARRAY, properties.__webglTexture);
      const side = Math.max(this.side, 4);
      gl.texStorage3D(gl.TEXTURE_2D_ARRAY, this.mips, gl.RGBA8, side, side, this.side > 0 ? this.tiles : 1);
      const set = (name, value) => gl.texParameteri(gl.TEXTURE_2D_ARRAY, name, value);
      set(gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
      set(gl.TEXTURE_MAG_FILTER, gl.LINEAR);
      set(gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
      set(gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    }
    if (this.waiting.length === 0) return;
    renderer.state.bindTexture(gl.TEXTURE_2D_ARRAY, properties.__webglTexture);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    for (const [tile, mip, side, texels] of this.waiting)
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, mip, 0, 0, tile, side, side, 1, gl.RGBA, gl.UNSIGNED_BYTE, texels);
    this.waiting = [];
  }
}

/** Uploads slots `first` to `first + count` of an attribute, whose items have `size` numbers. */
function mark(attribute, runs, count, size) {
  for (let i = 0; i < count; ++i) attribute.addUpdateRange(runs[2 * i] * size, runs[2 * i + 1] * size);
  if (count > 0) attribute.needsUpdate = true;
}

function clearOnUpload(attribute) {
  attribute.setUsage(THREE.DynamicDrawUsage);
  attribute.onUpload(function () { this.clearUpdateRanges(); });
  return attribute;
}

export class TerrainObject extends THREE.Mesh {
  #views; #maps; #wire; #wireIndices; #ranges = [];

  /** terrain: of `Terrain.open()`, with maps: true for the pack's colours and normals. The object owns its updates. */
  constructor(terrain, { color = 0xffffff, roughness = 1 } = {}) {
    const geometry = new THREE.BufferGeometry();
    const slots = terrain.vertexSlots.length / 3;
    geometry.setAttribute("position", clearOnUpload(new THREE.BufferAttribute(new Float32Array(3 * slots), 3)));
    geometry.setAttribute("fjell_morph", clearOnUpload(new THREE.BufferAttribute(terrain.morphSlots, 4)));
    geometry.setIndex(clearOnUpload(new THREE.BufferAttribute(terrain.indexSlots, 1)));
    const [x, z] = terrain.extent, [low, high] = terrain.heightRange;
    geometry.boundingBox = new THREE.Box3(new THREE.Vector3(0, low, 0), new THREE.Vector3(x, high, z));
    geometry.boundingSphere = geometry.boundingBox.getBoundingSphere(new THREE.Sphere());
    const mapped = terrain.mapLog2.colour > 0;
    const material = new THREE.MeshStandardMaterial({ color: mapped ? new THREE.Color(0.35, 0.35, 0.35).multiply(new THREE.Color(color)) : color === 0xffffff ? 0x9a9a86 : color, roughness });
    super(geometry, [material]);
    this.terrain = terrain;
    this.frustumCulled = false; // the terrain lists the tiles that its views see
    this.castShadow = this.receiveShadow = true;
    const tiles = terrain.tiles[0] * terrain.tiles[1];
    this.#maps = { colour: new TileMaps(terrain.mapLog2.colour, tiles), normal: new TileMaps(terrain.mapLog2.normal, tiles) };
    this.uniforms = {
      fjell_views: { value: 0 },
      fjell_eye: { value: Array.from({ length: mostViews }, () => new THREE.Vector3()) },
      fjell_q: { value: Array.from({ length: mostViews }, () => new THREE.Vector2()) },
      fjell_time: { value: new THREE.Vector2(0, 1) },
      fjell_spacing: { value: new THREE.Vector2(...terrain.spacing) },
      fjell_colour: { value: this.#maps.colour.texture },
      fjell_normals: { value: this.#maps.normal.texture },
      fjell_maps: { value: new THREE.Vector3(this.#maps.colour.side, this.#maps.normal.side, terrain.tileCells) },
      fjell_tiles: { value: new THREE.Vector2(...terrain.tiles) },
    };
    this.#teach(material, true);
    this.customDepthMaterial = new THREE.MeshDepthMaterial({ depthPacking: THREE.RGBADepthPacking });
    this.#teach(this.customDepthMaterial, false);
    this.#views = [{ eye: [0, 0, 0], forward: [0, 0, -1], up: [0, 1, 0], maxError: 0 }];
    this.#wireIndices = null;
    this.#place(0, slots); // a terrain that another object has shown has no changes to tell of these
  }

  #teach(material, lit) {
    material.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, this.uniforms);
      shader.vertexShader = vertexHead + shader.vertexShader.replace("#include <begin_vertex>", vertexBody)
        .replace("#include <beginnormal_vertex>", "vec3 objectNormal = vec3(0.0, 1.0, 0.0);"); // there is no attribute
      if (!lit) return;
      shader.fragmentShader = fragmentHead + shader.fragmentShader
        .replace("#include <map_fragment>", fragmentColour).replace("#include <normal_fragment_begin>", fragmentNormal);
    };
    material.customProgramCacheKey = () => `fjell ${lit}`;
  }

  /**
   * Once a frame, before it is drawn: refines for a camera with perspective, and makes ready what changed. Returns the
   * terrain's frame.
   */
  update(camera, renderer, nowS) {
    const { terrain } = this, gl = renderer.getContext();
    if (gl.isContextLost()) return terrain.frame; // there is no picture to refine for
    this.updateWorldMatrix(true, false);
    camera.updateMatrixWorld();
    const inverse = scratch.matrix.copy(this.matrixWorld).invert();
    const eye = scratch.eye.setFromMatrixPosition(camera.matrixWorld).applyMatrix4(inverse);
    const forward = camera.getWorldDirection(scratch.forward).transformDirection(inverse);
    const up = scratch.up.set(0, 1, 0).transformDirection(camera.matrixWorld).transformDirection(inverse);
    const p = camera.projectionMatrix.elements, view = this.#views[0];
    if (p[11] === 0) throw new TypeError("camera: has no perspective");
    eye.toArray(view.eye);
    forward.toArray(view.forward);
    up.toArray(view.up);
    view.left = (p[8] - 1) / p[0]; // of any perspective, with its middle where it may be
    view.right = (p[8] + 1) / p[0];
    view.bottom = (p[9] - 1) / p[5];
    view.top = (p[9] + 1) / p[5];
    view.width = gl.drawingBufferWidth;
    view.height = gl.drawingBufferHeight;
    view.near = camera.near;
    view.far = camera.far;
    const frame = terrain.update(this.#views, nowS);
    if (frame.mapsArrived > 0) terrain.takeMaps((kind, tile, mip, side, rgba) => this.#maps[kind].add(tile, mip, side, rgba));
    this.#maps.colour.upload(renderer);
    this.#maps.normal.upload(renderer);
    this.#takeChanges();
    this.#takeMorph();
    this.#takeRanges(frame);
    if (this.#wire?.visible) this.#drawWire(frame);
    return frame;
  }

  /** The view of the last update. */
  get view() { return this.#views[0]; }

  #place(first, count) {
    const { terrain } = this, to = this.geometry.attributes.position.array, from = terrain.vertexSlots, heights = terrain.heightSlots;
    const dx = terrain.spacing[0], dz = terrain.spacing[1];
    for (let k = 3 * first; k < 3 * (first + count); k += 3) {
      to[k] = from[k] * dx;
      to[k + 1] = heights[k + 2];
      to[k + 2] = from[k + 1] * dz;
    }
  }

  #takeChanges() {
    const { terrain, geometry } = this, changes = terrain.takeChanges();
    for (let i = 0; i < changes.vertexRunCount; ++i) this.#place(changes.vertexRuns[2 * i], changes.vertexRuns[2 * i + 1]);
    mark(geometry.attributes.position, changes.vertexRuns, changes.vertexRunCount, 3);
    mark(geometry.attributes.fjell_morph, changes.vertexRuns, changes.vertexRunCount, 4);
    mark(geometry.index, changes.triangleRuns, changes.triangleRunCount, 3);
  }

  #takeMorph() {
    const { morph } = this.terrain, u = this.uniforms;
    u.fjell_views.value = this.terrain.settings.morph === "none" ? 0 : morph.views;
    u.fjell_time.value.set(morph.nowS, morph.morphS);
    for (let i = 0; i < morph.views; ++i) {
      u.fjell_eye.value[i].fromArray(morph.numbers, 5 * i);
      u.fjell_q.value[i].fromArray(morph.numbers, 5 * i + 3);
    }
  }

  #takeRanges(frame) {
    const { groups } = this.geometry;
    groups.length = 0;
    for (let i = 0; i < frame.rangeCount; ++i) {
      const group = (this.#ranges[i] ??= { start: 0, count: 0, materialIndex: 0 });
      group.start = frame.ranges[2 * i];
      group.count = frame.ranges[2 * i + 1];
      groups.push(group);
    }
  }

  /** Whether the mesh is drawn as lines, over the ground. */
  get wireframe() { return this.#wire?.visible ?? false; }
  set wireframe(on) {
    if (on && !this.#wire) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", this.geometry.attributes.position);
      geometry.setAttribute("fjell_morph", this.geometry.attributes.fjell_morph);
      geometry.boundingSphere = this.geometry.boundingSphere;
      this.#wireIndices = new Uint32Array(this.terrain.indexSlots.length);
      geometry.setIndex(clearOnUpload(new THREE.BufferAttribute(this.#wireIndices, 1)));
      const material = new THREE.LineBasicMaterial({ color: 0x10161c, transparent: true, opacity: 0.55, depthWrite: false });
      this.#teach(material, false);
      material.customProgramCacheKey = () => "fjell wire";
      this.#wire = new THREE.LineSegments(geometry, material);
      this.#wire.frustumCulled = false;
      this.#wire.raycast = () => {};
      this.add(this.#wire);
      this.material[0].polygonOffset = true; // so that lines win over what they lie on
      this.material[0].polygonOffsetFactor = this.material[0].polygonOffsetUnits = 1;
    }
    if (this.#wire) this.#wire.visible = on;
  }

  #drawWire(frame) { // an edge of two triangles once: the one where it runs upwards
    const { indexSlots } = this.terrain, lines = this.#wireIndices;
    let n = 0;
    for (let r = 0; r < frame.rangeCount; ++r) {
      const end = frame.ranges[2 * r] + frame.ranges[2 * r + 1];
      for (let i = frame.ranges[2 * r]; i < end && n + 6 <= lines.length; i += 3) {
        const a = indexSlots[i], b = indexSlots[i + 1], c = indexSlots[i + 2];
        if (a < b) { lines[n++] = a; lines[n++] = b; }
        if (b < c) { lines[n++] = b; lines[n++] = c; }
        if (c < a) { lines[n++] = c; lines[n++] = a; }
      }
    }
    const { geometry } = this.#wire;
    geometry.setDrawRange(0, n);
    geometry.index.clearUpdateRanges();
    geometry.index.addUpdateRange(0, n);
    geometry.index.needsUpdate = true;
  }

  /** For THREE.Raycaster: the full-resolution ground, not the mesh of the frame. */
  raycast(raycaster, intersects) {
    const inverse = scratch.matrix.copy(this.matrixWorld).invert();
    const origin = scratch.eye.copy(raycaster.ray.origin).applyMatrix4(inverse);
    const direction = scratch.forward.copy(raycaster.ray.direction).transformDirection(inverse);
    const hit = this.terrain.ray(origin.toArray(), direction.toArray());
    if (!hit) return;
    const point = new THREE.Vector3(...hit.position).applyMatrix4(this.matrixWorld);
    const distance = raycaster.ray.origin.distanceTo(point);
    if (distance < raycaster.near || distance > raycaster.far) return;
    intersects.push({ distance, point, object: this, normal: new THREE.Vector3(...hit.normal).transformDirection(this.matrixWorld) });
  }

  dispose() {
    this.geometry.dispose();
    for (const material of [...this.material, this.customDepthMaterial]) material.dispose();
    this.#wire?.geometry.dispose();
    this.#wire?.material.dispose();
    for (const maps of Object.values(this.#maps)) maps.texture.dispose();
  }
}

const scratch = { matrix: new THREE.Matrix4(), eye: new THREE.Vector3(), forward: new THREE.Vector3(), up: new THREE.Vector3() };
