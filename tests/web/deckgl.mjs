// What the pages need of deck.gl, for bundle() of browser.mjs.
export { Deck } from "@deck.gl/core";
export { TerrainLayer } from "@deck.gl/geo-layers";
