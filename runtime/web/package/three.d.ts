import type { Mesh, PerspectiveCamera, WebGLRenderer } from "three";
import type { Frame, Terrain, View } from "./index.js";

export interface TerrainObjectOptions {
  /** Tints the ground. */
  color?: number;
  roughness?: number;
}

/** A terrain in a scene. x east, y up, z south, in metres from the first sample; move and turn it as any object. */
export class TerrainObject extends Mesh {
  constructor(terrain: Terrain, options?: TerrainObjectOptions);
  readonly terrain: Terrain;
  /** Once a frame, before the scene is drawn. nowS: the clock in seconds. */
  update(camera: PerspectiveCamera, renderer: WebGLRenderer, nowS?: number): Frame;
  /** The view of the last update, as the terrain sees it. */
  readonly view: View;
  /** Draws the edges of the triangles over the ground. */
  wireframe: boolean;
  dispose(): void;
}
