import { Deck } from "@deck.gl/core";
import { Terrain } from "fjell";
import { PackLayer } from "fjell/deck-layer";

const terrain = await Terrain.open("mountains.fjell");
const ground = new PackLayer({ id: "ground", terrain, center: [8.2, 46.5] });
const deck = new Deck({ initialViewState: { longitude: 8.2, latitude: 46.44, zoom: 10.8, pitch: 60 }, controller: true, layers: [ground] });

globalThis.deckPage = { deck, ground, terrain }; // for tests
const { update } = terrain;
terrain.update = (views, ...more) => { // what the layer takes deck.gl's camera for
  [deckPage.seen] = views;
  return update.call(terrain, views, ...more);
};
