// What the pages need of deck.gl, for bundle() of browser.mjs.
export { COORDINATE_SYSTEM, Deck, Layer, phongMaterial, project32 } from "@deck.gl/core";
export { TerrainLayer } from "@deck.gl/geo-layers";
export { Model } from "@luma.gl/engine";
