export { mesh } from "./mesh.js";
export { Terrain, makeView } from "./terrain.js";
export { ready } from "./ready.js";
export { version } from "./version.js";
