/** The package's version, which is the library's. */
export const version: string;

export type Vec3 = readonly [number, number, number] | ArrayLike<number>;

export type Heights = Int8Array | Uint8Array | Uint8ClampedArray | Int16Array | Uint16Array | Int32Array | Uint32Array |
  Float32Array | Float64Array | number[];

export interface MeshOptions {
  /** Samples of a row, from west to east. 2 or more; any number. */
  width: number;
  /** Rows, from north to south. */
  height: number;
  /** How far the mesh may be from any sample, in metres. 1 by default. */
  maxError?: number;
  /** Metres from sample to sample, or along rows and along columns. 1 by default. */
  spacing?: number | readonly [number, number];
}

export interface Mesh {
  /** x, y, z of each vertex: east, up and south in metres from the first sample. */
  positions: Float32Array;
  /** Three vertices a triangle, counter-clockwise seen from above. */
  triangles: Uint32Array;
  /** The largest vertical distance of any sample from the triangles over it, measured. */
  trueError: number;
}

/**
 * Triangles over heights, row by row from the north-west, within an error at every sample. NaN is a hole. At most 2^26
 * samples. Rejects with an error that begins with the argument's name.
 */
export function mesh(heights: Heights, options: MeshOptions): Promise<Mesh>;

export { heightsOfTile } from "./tiles.js";

export interface ReadyOptions {
  /** The WebAssembly: its place, or its bytes. By default it lies beside this file. */
  wasm?: string | URL | BufferSource;
  /** false: the file without SIMD, on any machine. */
  simd?: boolean;
}
/** Loads the WebAssembly, once. The result has mesh() without a promise. */
export function ready(options?: ReadyOptions): Promise<{ mesh(heights: Heights, options: MeshOptions): Mesh }>;

/** A camera. Axes: x east, y up, z south, in metres from the first sample. */
export interface View {
  eye: number[];
  /** Unit vectors, orthogonal to each other. */
  forward: number[];
  up: number[];
  /** The sides of the picture: tangents of angles from the direction of sight. */
  left: number;
  right: number;
  bottom: number;
  top: number;
  /** In pixels. */
  width: number;
  height: number;
  near: number;
  far: number;
  /** The threshold of this view in pixels; 0: that of the settings. */
  maxError: number;
}

export interface ViewOptions {
  eye: Vec3;
  /** One of both. */
  forward?: Vec3;
  target?: Vec3;
  up?: Vec3;
  /** Radians. */
  fovY?: number;
  width: number;
  height: number;
  near?: number;
  far?: number;
  maxError?: number;
}
/** A view with square pixels. out: an earlier one, which is changed and returned. */
export function makeView(options: ViewOptions, out?: View): View;

/** Where a pack's bytes come from. */
export interface Source {
  size(): Promise<number>;
  read(offset: number, bytes: number, signal?: AbortSignal): Promise<Uint8Array>;
  /** What was read from there is damaged: if it is kept somewhere, then not any longer. */
  forget?(offset: number, bytes: number): void | Promise<void>;
  close?(): void;
}

/** What the terrain may use. Fixed at opening. */
export interface TerrainOptions {
  /** Pages of geometry in memory, but no more than the pack has. */
  pageSlots?: number;
  vertices?: number;
  triangles?: number;
  /** 1 to 8. */
  views?: number;
  /** Pages and maps that are read at a time. */
  pageRequests?: number;
  mapRequests?: number;
  /** Read colour and normal maps too: takeMaps(). */
  maps?: boolean;
  /** Bytes that the maps of all tiles may take, as RGBA. Chooses their size. */
  mapBytes?: number;
  /** Blocks of 32 x 32 samples that may be edited. 0: edit() is refused. */
  editBlocks?: number;
  /** Load all pages at opening, and stream nothing. */
  whole?: boolean;
  /** How a URL is read. */
  source?: HttpOptions;
  /** A module from WebAssembly.compile(), for those who load it themselves. */
  module?: WebAssembly.Module;
}

export interface HttpOptions {
  /** Instead of the global one. */
  fetch?: (url: string, options: { headers: Record<string, string>; signal?: AbortSignal }) => Promise<Response>;
  /** How often a range is asked for before it counts as failed. 8 by default. */
  tries?: number;
  firstPauseMs?: number;
  longestPauseMs?: number;
  /** After which a range that has not come is asked for again. A minute by default. */
  timeoutMs?: number;
  /** All bytes that have come. */
  onProgress?: (bytes: number) => void;
  /** What failed and is tried again. */
  onProblem?: (error: Error) => void;
}

/** May change from update to update. */
export interface Settings {
  /** The threshold in pixels. */
  maxError: number;
  hysteresis: number;
  /** Work items that an update may do; 0: any number. */
  maxWork: number;
  /** Milliseconds that an update may refine; 0: no limit. */
  maxMs: number;
  /** How a vertex appears: at once, by distance, or in time. */
  morph: "none" | "error" | "time";
  morphS: number;
  /** Ground that no view sees is refined to the threshold times this. */
  offscreenFactor: number;
  pagesPerUpdate: number;
}

/** What an update has done. One object, which the next update changes. */
export interface Frame {
  /** Everything that the views want is loaded, and the mesh keeps the threshold. */
  readonly converged: boolean;
  /** Another update with the same views would change nothing. */
  readonly settled: boolean;
  /** The coarsest level is there everywhere. */
  readonly complete: boolean;
  readonly vertices: number;
  readonly triangles: number;
  /** Of the tiles that a view may see. */
  readonly trianglesDrawn: number;
  /** No sample that a view shows is farther from the mesh, in pixels. */
  readonly errorBound: number;
  /** What the mesh is refined to: more than asked for while a budget is spent. */
  readonly threshold: number;
  readonly waiting: number;
  readonly inFlight: number;
  readonly failed: number;
  readonly bytesRead: number;
  readonly pagesRead: number;
  readonly pagesLoaded: number;
  readonly updateMs: number;
  readonly work: number;
  readonly activations: number;
  readonly deactivations: number;
  /** What to draw: pairs of first index and count, of which `rangeCount` are valid. */
  readonly ranges: Uint32Array;
  readonly rangeCount: number;
  readonly mapsArrived: number;
}

/** Slots that were written: pairs of first slot and count. */
export interface Changes {
  readonly vertexRuns: Uint32Array;
  readonly vertexRunCount: number;
  readonly triangleRuns: Uint32Array;
  readonly triangleRunCount: number;
}

export interface Hit {
  distance: number;
  position: [number, number, number];
  normal: [number, number, number];
  /** How far the original ground may be from there, vertically. */
  error: number;
}

export interface Stamp {
  shape: "raise" | "level" | "crater" | "noise" | "smooth" | "restore" | "hole" | "fill" | "lock" | "unlock";
  /** x and z of the centre. */
  at: readonly [number, number];
  /** The shape applies wholly within it, and fades out over `falloff`. */
  radius: number;
  falloff?: number;
  amount?: number;
  height?: number;
  slope?: readonly [number, number];
  wavelength?: number;
  seed?: number;
}

/**
 * A pack in use. All memory is taken at opening. The arrays show the memory itself: they are valid until close(), and
 * what they hold until the next update.
 */
export class Terrain {
  static open(source: string | URL | ArrayBuffer | ArrayBufferView | Source, options?: TerrainOptions): Promise<Terrain>;
  readonly columns: number;
  readonly rows: number;
  /** Metres from column to column, and from row to row. */
  readonly spacing: readonly [number, number];
  /** Where the last column and the last row are. */
  readonly extent: readonly [number, number];
  readonly heightRange: readonly [number, number];
  readonly quantum: number;
  readonly tiles: readonly [number, number];
  readonly tileCells: number;
  /** Of the first sample, in the pack's CRS. */
  readonly origin: readonly [number, number];
  readonly holes: number;
  readonly pages: number;
  readonly memoryBytes: number;
  readonly budget: Readonly<Required<Omit<TerrainOptions, "source" | "module">>>;
  readonly mapLog2: { readonly colour: number; readonly normal: number };
  readonly settings: Settings;
  readonly frame: Frame;
  /** Column, row and height of each slot; the height's bits are a float's. */
  readonly vertexSlots: Int32Array;
  /** The same memory: every third number is a height. */
  readonly heightSlots: Float32Array;
  /** Four numbers a slot: the height where it starts, its error, its radius, and when it came. */
  readonly morphSlots: Float32Array;
  readonly indexSlots: Uint32Array;
  /** What a vertex shader needs to morph (MorphFrame in fjell/cut.h): eye, start and full per error of each view. */
  readonly morph: { readonly nowS: number; readonly morphS: number; readonly views: number; readonly numbers: Float32Array };
  update(views: readonly View[], nowS?: number): Frame;
  /** Updates until all that the views want is there. */
  settle(views: readonly View[], nowS?: number): Promise<Frame>;
  takeChanges(): Changes;
  takeMaps(upload: (kind: "colour" | "normal", tile: number, mip: number, side: number, rgba: Uint8Array) => void): void;
  readonly shortOf: string[];
  readonly failure: Error | null;
  retry(): void;
  height(x: number, z: number): number;
  ground(x: number, z: number): { height: number; error: number; normal: [number, number, number] } | null;
  ray(origin: Vec3, direction: Vec3, maxDistance?: number): Hit | null;
  /** Returns the edit's number, for editState(). Throws what can be said at once. */
  edit(stamp: Stamp): number;
  editState(edit: number): { state: "unknown" | "waiting" | "applied" | "refused" | "moving"; why: string };
  /** The mesh of the last update as binary glTF, with normals and without textures. */
  snapshot(view?: View): Uint8Array;
  close(): void;
}
