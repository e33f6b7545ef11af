export { mesh } from "./mesh.js";
export { Terrain, makeView } from "./terrain.js";
export { heightsOfTile } from "./tiles.js";
export { ready } from "./ready.js";
export { version } from "./version.js";
