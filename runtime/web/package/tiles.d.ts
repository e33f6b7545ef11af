import type { HttpOptions, Source } from "./index.js";

/** Of texels to metres. */
export type HeightEncoding = "terrarium" | "mapbox" | ((r: number, g: number, b: number) => number);

/** Heights of a raster tile. rgba: the data of an ImageData. A transparent texel is NaN. */
export function heightsOfTile(rgba: ArrayLike<number>, encoding?: HeightEncoding): Float32Array;

/** The texels of an image file: PNG everywhere, exactly; other images where there are canvases. */
export function texelsOf(bytes: Uint8Array): Promise<{ width: number; height: number; rgba: Uint8ClampedArray }>;

export interface TileHeights {
  /** In metres, row by row from the north-west. */
  heights: Float32Array;
  width: number;
  height: number;
  /** Metres from texel to texel, in the tile's middle. */
  spacing: number;
}

/** Tiles of heights in Web Mercator, from a server or out of one file. */
export class TileSource {
  /** source: a URL with {z}, {x} and {y}, or a PmTiles. */
  constructor(source: string | URL | PmTiles, options?: {
    encoding?: HeightEncoding;
    /** Instead of the global one. */
    fetch?: (url: string, options: { signal?: AbortSignal }) => Promise<Response>;
  });
  /** What mesh() takes; null: there is no such tile. Rejects with an error that begins with the argument's name. */
  heights(z: number, x: number, y: number, signal?: AbortSignal): Promise<TileHeights | null>;
}

export interface PmTilesHeader {
  readonly minZoom: number;
  readonly maxZoom: number;
  /** West, south, east and north in degrees. */
  readonly bounds: readonly [number, number, number, number];
  /** Of the tiles: 1 vector, 2 PNG, 3 JPEG, 4 WebP, 5 AVIF. */
  readonly type: number;
}

/** A PMTiles file, version 3, without compression or with gzip. Read by ranges. */
export class PmTiles {
  constructor(source: string | URL | ArrayBuffer | ArrayBufferView | Source, options?: HttpOptions);
  header(): Promise<PmTilesHeader>;
  /** The bytes of a tile; null: the file has none there. */
  tile(z: number, x: number, y: number, signal?: AbortSignal): Promise<Uint8Array | null>;
}
