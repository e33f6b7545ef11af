/** What HeightLoader makes: a mesh as deck.gl's layers take it. */
export interface HeightTileMesh {
  /** trueError: the largest vertical distance of any texel from the triangles over it, measured. */
  loaderData: { header: {}; trueError: number };
  header: { vertexCount: number; boundingBox: [number[], number[]] };
  topology: "triangle-list";
  mode: 4;
  indices: { value: Uint32Array; size: 1 };
  attributes: { POSITION: { value: Float32Array; size: 3 }; TEXCOORD_0: { value: Float32Array; size: 2 } };
}

/** The options of loaders.gl's TerrainLoader, under the same name. */
export type HeightLoaderOptions = {
  terrain?: {
    /** How far the mesh may be from any texel, in metres. 10 by default. */
    meshMaxError?: number;
    /** West, south, east and north of the mesh. By default the texels. */
    bounds?: number[];
    /** Metres that walls go down along the tile's rim. 0 by default: no walls. */
    skirtHeight?: number;
    elevationDecoder?: { rScaler: number; gScaler: number; bScaler: number; offset: number };
  };
};

/** A loader for loaders.gl, and for deck.gl's TerrainLayer: `loaders: [HeightLoader]`. */
export const HeightLoader: {
  readonly dataType: HeightTileMesh;
  readonly batchType: never;
  readonly name: string;
  readonly id: "terrain";
  readonly module: string;
  readonly version: string;
  readonly worker: false;
  readonly extensions: string[];
  readonly mimeTypes: string[];
  readonly tests: ((bytes: ArrayBuffer) => boolean)[];
  readonly options: HeightLoaderOptions;
  parse(bytes: ArrayBuffer, options?: HeightLoaderOptions): Promise<HeightTileMesh>;
};
