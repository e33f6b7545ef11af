// deck.gl: a layer that draws a whole pack, refined for deck's camera. Of its own entry: the loader needs no deck.gl.
import { COORDINATE_SYSTEM, Layer, phongMaterial, project32 } from "@deck.gl/core";
import { Model } from "@luma.gl/engine";

const vs = `#version 300 es
in vec3 positions;
out vec3 cameraPosition;
out vec4 position_commonspace;
void main() {
  geometry.worldPosition = positions;
  cameraPosition = project.cameraPosition;
  gl_Position = project_position_to_clipspace(positions, vec3(0.0), vec3(0.0), position_commonspace);
  geometry.position = position_commonspace;
}`;
const fs = `#version 300 es
precision highp float;
uniform packUniforms { vec4 color; } pack;
in vec3 cameraPosition;
in vec4 position_commonspace;
out vec4 fragColor;
void main() {
  vec3 normal = normalize(cross(dFdx(position_commonspace.xyz), dFdy(position_commonspace.xyz)));
  fragColor = vec4(lighting_getLightColor(pack.color.rgb, cameraPosition, position_commonspace.xyz, normal), pack.color.a * layer.opacity);
}`;
const uniforms = { name: "pack", vs: "", fs: "", uniformTypes: { color: "vec4<f32>" } };

/** The terrain's view of a viewport. x0, y0, and units of a metre: of the terrain's middle, in deck.gl's world of 512 units. */
function viewOf({ viewMatrix: m, projectionMatrix: p, cameraPosition: [x, y, z], width, height }, [x0, y0], [ux, uy, uz], [wide, deep], ratio) {
  const axis = (i, by) => [m[i], m[8 + i], -m[4 + i]].map((value) => value * by / Math.hypot(m[i], m[4 + i], m[8 + i])), metre = Math.hypot(m[2], m[6], m[10]) * uz;
  return { eye: [wide / 2 + (x - x0) / ux, z / uz, deep / 2 - (y - y0) / uy], forward: axis(2, -1), up: axis(1, 1),
    left: (p[8] - 1) / p[0], right: (p[8] + 1) / p[0], bottom: (p[9] - 1) / p[5], top: (p[9] + 1) / p[5],
    width: width * ratio, height: height * ratio, near: p[14] / (p[10] - 1) / metre, far: p[14] / (p[10] + 1) / metre, maxError: 0 };
}

export class PackLayer extends Layer {
  constructor(props) {
    const { terrain, center } = props, [lng, lat] = center ?? [];
    if (typeof terrain?.update !== "function") throw new TypeError("terrain: give what Terrain.open has opened");
    if (!(Math.abs(lng) <= 180 && Math.abs(lat) < 85.06)) throw new RangeError("center: give the longitude and latitude of the pack's middle, in degrees");
    super({ ...props, coordinateSystem: COORDINATE_SYSTEM.METER_OFFSETS, coordinateOrigin: props.center });
  }

  initializeState() {
    const { terrain } = this.props, { device } = this.context, { vertexSlots, indexSlots } = terrain, places = new Float32Array(vertexSlots.length), indices = new Uint32Array(indexSlots.length);
    const buffer = device.createBuffer({ byteLength: places.byteLength }), indexBuffer = device.createBuffer({ usage: 0x10 | 8, indexType: "uint32", byteLength: indices.byteLength }); // INDEX, COPY_DST
    const model = new Model(device, { ...this.getShaders({ vs, fs, modules: [project32, phongMaterial, uniforms] }), id: this.props.id, topology: "triangle-list",
      bufferLayout: [{ name: "positions", format: "float32x3" }], attributes: { positions: buffer }, indexBuffer, vertexCount: 0 });
    this.setState({ model, buffer, indexBuffer, places, indices });
    this.#place(0, places.length / 3); // what another layer has shown is no change
  }

  #place(first, count) {
    const { terrain } = this.props, { places, buffer } = this.state, { vertexSlots: from, heightSlots, spacing: [dx, dz], extent: [wide, deep] } = terrain;
    for (let k = 3 * first; k < 3 * (first + count); k += 3) { // metres east, north and up of the middle
      places[k] = from[k] * dx - wide / 2;
      places[k + 1] = deep / 2 - from[k + 1] * dz;
      places[k + 2] = heightSlots[k + 2];
    }
    buffer.write(places.subarray(3 * first, 3 * (first + count)), 12 * first);
  }

  shouldUpdateState({ changeFlags }) { return changeFlags.somethingChanged; }

  updateState(given) {
    super.updateState(given);
    if (given.oldProps.terrain && given.oldProps.terrain !== given.props.terrain) {
      this.#free();
      this.initializeState();
    }
    const { terrain, center } = this.props, { viewport, device } = this.context, { model, indices, indexBuffer } = this.state;
    const view = viewOf(viewport, viewport.projectFlat(center), viewport.getDistanceScales(center).unitsPerMeter, terrain.extent, device.canvasContext?.cssToDeviceRatio?.() ?? 1);
    const frame = terrain.update([view]), changes = terrain.takeChanges();
    for (let i = 0; i < changes.vertexRunCount; ++i) this.#place(changes.vertexRuns[2 * i], changes.vertexRuns[2 * i + 1]);
    let n = 0;
    for (let i = 0; i < frame.rangeCount; ++i) { // one draw of all that is in sight
      const first = frame.ranges[2 * i], count = frame.ranges[2 * i + 1];
      indices.set(terrain.indexSlots.subarray(first, first + count), n);
      n += count;
    }
    if (n > 0) indexBuffer.write(indices.subarray(0, n));
    model.setVertexCount(n);
    this.setNeedsRedraw();
    if (!frame.settled) setTimeout(() => this.getCurrentLayer()?.internalState && this.getCurrentLayer().setNeedsUpdate(), 4);
  }

  get isLoaded() { return super.isLoaded && this.props.terrain.frame.settled; }

  draw({ renderPass }) {
    const { model } = this.state, [r, g, b, a = 255] = this.props.color;
    if (this.props.terrain.frame.rangeCount === 0) return;
    model.shaderInputs.setProps({ pack: { color: [r / 255, g / 255, b / 255, a / 255] } });
    model.draw(renderPass);
  }

  #free() { for (const of of ["model", "buffer", "indexBuffer"]) this.state[of]?.destroy(); }

  finalizeState(context) {
    super.finalizeState(context);
    this.#free();
  }
}
PackLayer.layerName = "PackLayer";
PackLayer.defaultProps = {
  terrain: { type: "object", value: null, compare: false }, center: { type: "array", value: null, compare: true }, color: { type: "color", value: [154, 154, 134] },
  material: true,
};
