import { compile } from "./instance.js";
import { meshWith } from "./mesh.js";

/** Loads the WebAssembly, and returns mesh() without a promise. */
export async function ready(options) {
  return { mesh: meshWith(await compile(options)) };
}
