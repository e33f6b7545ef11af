// mesh(): heights to triangles within an error.
import { compile, Instance } from "./instance.js";

const types = new Map([[Int8Array, 0], [Uint8Array, 1], [Uint8ClampedArray, 1], [Int16Array, 2], [Uint16Array, 3],
  [Int32Array, 4], [Uint32Array, 5], [Float32Array, 8], [Float64Array, 9]]);
const mostSamples = 2 ** 26; // 4 GB of memory hold the heights, the bits and the mesh of so many
const keptBytes = 2 ** 27; // a module that has grown beyond it is dropped, for memory never shrinks

let instance;

function checked(heights, { width, height, maxError = 1, spacing = 1 } = {}) {
  if (Array.isArray(heights)) heights = Float64Array.from(heights);
  const type = types.get(heights?.constructor);
  if (type === undefined) throw new TypeError("heights: give a typed array of numbers, row by row from the north-west");
  for (const [name, value] of [["width", width], ["height", height]])
    if (!Number.isInteger(value) || value < 2) throw new RangeError(`${name}: is ${value}; give the samples of a ${name === "width" ? "row" : "column"}, 2 or more`);
  if (width * height > mostSamples) throw new RangeError(`heights: has ${width} x ${height} samples, more than ${mostSamples}; give a part`);
  if (heights.length !== width * height) throw new RangeError(`heights: has ${heights.length} numbers; width x height is ${width * height}`);
  if (!(maxError >= 0) || maxError === Infinity) throw new RangeError(`maxError: is ${maxError}; give 0 or more metres`);
  const [dx, dz] = typeof spacing === "number" ? [spacing, spacing] : spacing ?? [];
  if (!(dx > 0 && dz > 0 && dx < Infinity && dz < Infinity)) throw new RangeError(`spacing: is ${spacing}; give metres from sample to sample, or two of them`);
  return { heights, type, width, height, maxError, dx, dz };
}

function run(module, { heights, type, width, height, maxError, dx, dz }) {
  instance ??= new Instance(module);
  const { calls } = instance;
  try {
    const at = instance.copy(heights);
    instance.numbers.set([dx, dz, maxError]);
    const made = calls.mesh_make(at, type, width, height);
    const [trueError, vertices, verticesAt, triangles, trianglesAt] = instance.refresh();
    const result = {
      positions: new Float32Array(instance.memory.buffer, verticesAt, 3 * vertices).slice(),
      triangles: new Uint32Array(instance.memory.buffer, trianglesAt, 3 * triangles).slice(),
      trueError,
    };
    calls.mesh_free(made);
    calls.web_free(at);
    if (instance.memory.buffer.byteLength > keptBytes) instance = undefined;
    return result;
  } catch (error) {
    instance = undefined; // what it held is gone with it
    throw error instanceof WebAssembly.RuntimeError ? new Error(`heights: ${error.message}; give a part`) : error;
  }
}

export async function mesh(heights, options) {
  const given = checked(heights, options);
  return run(await compile(), given);
}

/** mesh() without waiting, for a module that compile() has given. */
export function meshWith(module) {
  return (heights, options) => run(module, checked(heights, options));
}
