import { Terrain } from "fjell";
import { TerrainLayer } from "fjell/maplibre";
import * as maplibre from "maplibre-gl";

const terrain = await Terrain.open("mountains.fjell", { maps: true });
const layer = new TerrainLayer({ terrain, center: [8.2, 46.5] });
const style = { version: 8, sources: {}, layers: [{ id: "land", type: "background", paint: { "background-color": "#9fb6c8" } }] };
const map = new maplibre.Map({ container: "map", style, center: [8.2, 46.5], zoom: 10.6, pitch: 60, bearing: 20, maxPitch: 85 });
map.on("load", () => map.addLayer(layer));

globalThis.mapPage = { map, layer, maplibre }; // for tests
