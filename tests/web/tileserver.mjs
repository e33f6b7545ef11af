// Terrarium tiles of a terrain, as a server of map tiles would have them: for those who know no packs.
import { terrarium } from "./images.mjs";

const side = 256, equator = 40075016.685578488;

/**
 * A function that answers /tiles/z/x/y.png: the terrain lies around `center`, as TerrainLayer of fjell/maplibre places it.
 * within: where in its texel a height is; deck.gl takes it for the north-west corner's.
 */
export function tilesOf(terrain, [lng, lat], within = 0.5) {
  const sin = Math.sin(lat * Math.PI / 180), x0 = lng / 360 + 0.5, y0 = 0.5 - Math.log((1 + sin) / (1 - sin)) / (4 * Math.PI);
  const metres = equator * Math.cos(lat * Math.PI / 180), [wide, deep] = terrain.extent, made = new Map();
  const tile = (z, x, y) => {
    const heights = Float32Array.from({ length: side * side }, (_, i) => {
      const u = (x + (i % side + within) / side) / 2 ** z, v = (y + (Math.floor(i / side) + within) / side) / 2 ** z;
      return terrain.height(wide / 2 + (u - x0) * metres, deep / 2 + (v - y0) * metres) || 0;
    });
    return terrarium(heights, side, side, { channels: 3, filter: () => 1 });
  };
  return (request, response) => {
    const place = /^\/tiles\/(\d+)\/(\d+)\/(\d+)\.png/.exec(request.url);
    if (!place) return false;
    const [, z, x, y] = place.map(Number), key = `${z}/${x}/${y}`;
    if (!made.has(key)) made.set(key, tile(z, x, y));
    response.writeHead(200, { "content-type": "image/png", "content-length": made.get(key).length }).end(made.get(key));
    return true;
  };
}
