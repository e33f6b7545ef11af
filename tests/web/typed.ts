// Compiled by tsc against the package's declarations, and not run.
import { load } from "@loaders.gl/core";
import { HeightLoader } from "fjell/deck";
import { PackLayer } from "fjell/deck-layer";
import { HttpSource, SetSource, WorkerSource } from "fjell/loader";
import { TerrainLayer } from "fjell/maplibre";
import { heightsOfTile, PmTiles, TileSource } from "fjell/tiles";
import type { CustomLayerInterface } from "maplibre-gl";
import { TerrainObject } from "fjell/three";
import * as THREE from "three";
import { makeView, mesh, ready, Terrain, version, type Frame, type Mesh, type View } from "fjell";

export async function use(): Promise<void> {
  const made: Mesh = await mesh(new Int16Array(6), { width: 3, height: 2, maxError: 0.5, spacing: [30, 30] });
  const again = (await ready()).mesh([0, 1, 2, 3], { width: 2, height: 2 });
  const view: View = makeView({ eye: [0, 1, 2], target: new Float32Array(3), width: 100, height: 100 });
  const terrain = await Terrain.open("a.fjell", { pageSlots: 100, maps: true, source: { tries: 3, onProblem: (e) => console.log(e.message) } });
  terrain.settings.morph = "time";
  const frame: Frame = terrain.update([view], 1);
  terrain.takeMaps((kind, tile, mip, side, rgba) => console.log(kind === "colour", tile + mip + side, rgba.length));
  const hit = terrain.ray([0, 0, 0], [0, -1, 0]);
  const numbers: number[] = [made.trueError, again.triangles.length, frame.errorBound, hit?.distance ?? 0, terrain.height(1, 2)];
  terrain.edit({ shape: "crater", at: [1, 2], radius: 3 });
  console.log(version, numbers, terrain.snapshot().length);
  const remote = await Terrain.open(new WorkerSource("a.fjell", { cache: "packs", pingMs: 1000 }));
  const ground = new TerrainObject(await Terrain.open(new HttpSource("b.fjell")), { color: 0xffffff });
  new THREE.Scene().add(ground);
  ground.wireframe = ground.update(new THREE.PerspectiveCamera(), new THREE.WebGLRenderer(), 1).converged;
  remote.close();
  const layer: CustomLayerInterface = new TerrainLayer({ id: "ground", terrain, center: [8, 46], roughness: 0.9 });
  const loaded = await load("tile.png", HeightLoader, { terrain: { meshMaxError: 5, bounds: [0, 0, 1, 1] } });
  const tiles = new TileSource(new PmTiles("dem.pmtiles", { tries: 2 }), { encoding: "mapbox" });
  const tile = await tiles.heights(12, 2137, 1452);
  if (tile) await mesh(tile.heights, { ...tile, maxError: 2 });
  const set = new SetSource("set/set.json", { open: (url, options) => new HttpSource(url, options) });
  console.log(layer.id, loaded.attributes.POSITION.value.length, heightsOfTile([1, 2, 3, 4], (r, g, b) => r + g + b), await set.size());
  new TerrainLayer({ terrain, crs: "EPSG:3857" }).dispose();
  const pack = new PackLayer({ id: "pack", terrain, center: [8, 46], color: [100, 110, 90], opacity: 0.5 });
  console.log(pack.isLoaded, pack.props.terrain.frame.converged);
  // @ts-expect-error: the place is missing
  new PackLayer({ id: "pack", terrain });
  // @ts-expect-error: the terrain is missing
  new TerrainLayer({ center: [8, 46] });
  // @ts-expect-error: it is a number
  terrain.settings.maxError = "1 px";
  // @ts-expect-error: it is not to be written
  frame.triangles = 1;
}
