import type { CustomLayerInterface, CustomRenderMethodInput, Map } from "maplibre-gl";
import type { DirectionalLight, PerspectiveCamera, Scene } from "three";
import type { Terrain } from "./index.js";
import type { TerrainObject, TerrainObjectOptions } from "./three.js";

export interface TerrainLayerOptions extends TerrainObjectOptions {
  /** "fjell" by default. */
  id?: string;
  terrain: Terrain;
  /** Longitude and latitude of the pack's middle, in degrees. */
  center?: readonly [number, number];
  /** How far the pack's north is turned from north in its middle, in degrees, clockwise. */
  bearing?: number;
  /** Instead of center: the pack was baked in Web Mercator, and has its own place. */
  crs?: "EPSG:3857";
}

/**
 * A custom layer for `map.addLayer()`: a terrain, drawn with the map's camera. It needs a map in Mercator's projection,
 * and draws nothing on a globe. The layer owns the terrain's updates; closing the terrain is up to the caller.
 */
export class TerrainLayer implements CustomLayerInterface {
  constructor(options: TerrainLayerOptions);
  readonly id: string;
  readonly type: "custom";
  readonly renderingMode: "3d";
  readonly terrain: Terrain;
  /** For objects of three.js: metres east, up and south of the pack's middle. */
  readonly scene: Scene;
  readonly sun: DirectionalLight;
  /** The map's camera of the last frame, in the scene. */
  readonly camera: PerspectiveCamera;
  /** From onAdd() on. */
  readonly object: TerrainObject;
  onAdd(map: Map, gl: WebGL2RenderingContext): void;
  render(gl: WebGL2RenderingContext, input: CustomRenderMethodInput): void;
  /** Frees what a layer that was taken off keeps on the GPU, so that it can be put on again with its maps. */
  dispose(): void;
}
