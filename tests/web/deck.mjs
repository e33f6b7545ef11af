import { Deck } from "@deck.gl/core";
import { TerrainLayer } from "@deck.gl/geo-layers";
import { HeightLoader } from "fjell/deck";

const ground = new TerrainLayer({
  id: "ground", loaders: [HeightLoader], meshMaxError: 5,
  elevationData: "tiles/{z}/{x}/{y}.png", minZoom: 9, maxZoom: 11, extent: [8.03, 46.38, 8.37, 46.62],
  elevationDecoder: { rScaler: 256, gScaler: 1, bScaler: 1 / 256, offset: -32768 }, // Terrarium
  color: [150, 160, 130],
});
const deck = new Deck({ initialViewState: { longitude: 8.2, latitude: 46.44, zoom: 10.8, pitch: 60 }, controller: true, layers: [ground] });

globalThis.deckPage = { deck, ground }; // for tests
