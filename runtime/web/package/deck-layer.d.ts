import type { Layer, LayerProps } from "@deck.gl/core";
import type { Terrain } from "./index.js";

export type PackLayerProps = LayerProps & {
  terrain: Terrain;
  /** Longitude and latitude of the pack's middle, in degrees. */
  center: [number, number];
  /** Bytes of red, green, blue and, if you like, alpha. */
  color?: [number, number, number] | [number, number, number, number];
};

/**
 * A terrain in deck.gl: the mesh of a pack, refined for the view's camera, in one colour and deck's light. The layer owns
 * the terrain's updates, of one view; closing the terrain is up to the caller. `isLoaded` says that nothing is missing.
 */
export class PackLayer extends Layer<PackLayerProps> {
  static layerName: string;
  constructor(props: PackLayerProps);
  initializeState(): void;
  get isLoaded(): boolean;
}
