// Heights of map tiles, for mesh(): Terrarium and Terrain-RGB, from a server of tiles or from one PMTiles file.
import { decodePng } from "./png.js";
import { PmTiles } from "./pmtiles.js";

export { PmTiles };

const decoders = {
  terrarium: (r, g, b) => r * 256 + g + b / 256 - 32768,
  mapbox: (r, g, b) => -10000 + (r * 65536 + g * 256 + b) * 0.1,
};
const equator = 40075016.685578488; // metres around the earth, as web maps have it

/** rgba: of an ImageData. Heights in metres, row by row; NaN where a texel is transparent. */
export function heightsOfTile(rgba, encoding = "terrarium") {
  const decode = typeof encoding === "function" ? encoding : decoders[encoding];
  if (!decode) throw new RangeError(`encoding: is ${encoding}; give terrarium or mapbox`);
  if (!(rgba?.length > 0) || rgba.length % 4 !== 0) throw new RangeError("rgba: give four bytes for each texel");
  return Float32Array.from({ length: rgba.length / 4 }, (_, i) =>
    rgba[4 * i + 3] === 0 ? NaN : decode(rgba[4 * i], rgba[4 * i + 1], rgba[4 * i + 2]));
}

/** { width, height, rgba } of an image file. PNG is decoded here; other images where there are canvases. */
export async function texelsOf(bytes) {
  const made = await decodePng(bytes);
  if (made) return made;
  if (!globalThis.createImageBitmap || !globalThis.OffscreenCanvas) throw new Error("tile: is no PNG of 8 bits in RGB or RGBA, and there is no canvas for other images");
  const image = await createImageBitmap(new Blob([bytes]), { colorSpaceConversion: "none", premultiplyAlpha: "none" })
    .catch(() => { throw new Error("tile: is no image"); });
  const { width, height } = image, canvas = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  canvas.drawImage(image, 0, 0);
  image.close();
  return { width, height, rgba: canvas.getImageData(0, 0, width, height).data };
}

/** Radians north, of a place in the map: 0 at its northern rim, 1 at its southern. */
const latitude = (y) => Math.atan(Math.sinh(Math.PI * (1 - 2 * y)));

/** Tiles of heights. source: a template with {z}, {x} and {y}, or a PmTiles. */
export class TileSource {
  #source; #fetch; #encoding;

  constructor(source, { encoding = "terrarium", fetch: fetched } = {}) {
    heightsOfTile([0, 0, 0, 0], encoding); // or says why not
    if (!(source instanceof PmTiles) && !/\{z\}.*\{x\}.*\{y\}|\{z\}.*\{y\}.*\{x\}/.test(String(source))) throw new TypeError("source: give a URL with {z}, {x} and {y}, or a PmTiles");
    this.#source = source;
    this.#encoding = encoding;
    this.#fetch = fetched ?? ((...given) => fetch(...given));
  }

  async #bytes(z, x, y, signal) {
    if (this.#source instanceof PmTiles) return this.#source.tile(z, x, y, signal);
    const url = String(this.#source).replace("{z}", z).replace("{x}", x).replace("{y}", y);
    const response = await this.#fetch(url, { signal });
    if (response.status === 404 || response.status === 204) return null;
    if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
    return new Uint8Array(await response.arrayBuffer());
  }

  /**
   * { heights, width, height, spacing } of a tile, as mesh() takes it; null: there is no such tile. spacing: metres from
   * texel to texel in the tile's middle.
   */
  async heights(z, x, y, signal) {
    const side = 2 ** z;
    for (const [name, value, most] of [["z", z, 30], ["x", x, side - 1], ["y", y, side - 1]])
      if (!(Number.isInteger(value) && value >= 0 && value <= most)) throw new RangeError(`${name}: is ${value}; give a whole number from 0 to ${most}`);
    const bytes = await this.#bytes(z, x, y, signal);
    if (!bytes) return null;
    const { width, height, rgba } = await texelsOf(bytes);
    return { heights: heightsOfTile(rgba, this.#encoding), width, height, spacing: equator * Math.cos(latitude((y + 0.5) / side)) / side / width };
  }
}
