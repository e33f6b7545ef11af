// Beside Martini and Delatin: what each takes for a mesh that is really within an error, on the same heights, in one run.
//   node others.mjs [PACK...]      in a folder where npm has installed the packages that package.json names, and fjell
// Each is asked for less and less until its true error, measured at every sample, is at most the one wanted. The time is
// the shortest of several runs, from heights to triangles, preparations included.
import { readFile } from "node:fs/promises";
import { basename } from "node:path";

import Martini from "@mapbox/martini";
import Delatin from "delatin";
import { ready, Terrain } from "fjell";

import { hills, measure } from "./surface.mjs";

const side = 513;
const { mesh } = await ready();

/** Heights of a pack, the middle of it. */
async function patch(file) {
  const terrain = await Terrain.open(await readFile(file), { whole: true, pageSlots: 1 << 20 });
  const [dx, dz] = terrain.spacing, x0 = (terrain.columns - side) >> 1, z0 = (terrain.rows - side) >> 1;
  const heights = Float32Array.from({ length: side * side }, (_, i) => terrain.height((x0 + i % side) * dx, (z0 + Math.floor(i / side)) * dz));
  terrain.close();
  return heights;
}

const methods = {
  fjell: (heights) => (error) => {
    const { positions, triangles } = mesh(heights, { width: side, height: side, maxError: error });
    return { positions, triangles };
  },
  Martini: (heights) => (error) => {
    const { vertices, triangles } = new Martini(side).createTile(heights).getMesh(error);
    return { positions: () => raised(vertices, heights), triangles };
  },
  "Martini, grid kept": (heights) => {
    const grid = new Martini(side);
    return (error) => {
      const { vertices, triangles } = grid.createTile(heights).getMesh(error);
      return { positions: () => raised(vertices, heights), triangles };
    };
  },
  Delatin: (heights) => (error) => {
    const made = new Delatin(heights, side, side);
    made.run(error);
    return { positions: () => raised(made.coords, heights), triangles: made.triangles };
  },
};

function raised(places, heights) { // x, y of each vertex: x, height, z
  const positions = new Float32Array(places.length / 2 * 3);
  for (let i = 0; i < places.length / 2; ++i) positions.set([places[2 * i], heights[places[2 * i + 1] * side + places[2 * i]], places[2 * i + 1]], 3 * i);
  return positions;
}

const trueError = (heights, made) =>
  measure(heights, side, side, typeof made.positions === "function" ? made.positions() : made.positions, made.triangles).worst;

/** The largest number asked for that keeps the wanted error, to a percent. */
function askFor(make, heights, wanted) {
  let [low, high] = [0, wanted];
  if (trueError(heights, make(wanted)) <= wanted) return wanted;
  while (high - low > 0.01 * wanted) {
    const middle = (low + high) / 2;
    if (trueError(heights, make(middle)) <= wanted) low = middle;
    else high = middle;
  }
  return low;
}

function shortest(call, runs) {
  let ms = Infinity;
  for (let i = 0; i < runs; ++i) {
    const start = performance.now();
    call();
    ms = Math.min(ms, performance.now() - start);
  }
  return ms;
}

console.log(`${side} x ${side} samples, node ${process.version}`);
console.log("| heights | true error wanted | method | asked | true error | triangles | ms |\n|---|---|---|---|---|---|---|");
const sets = [["hills.mjs", hills(side, side)]];
for (const file of process.argv.slice(2)) sets.push([basename(file), await patch(file)]);
for (const [name, heights] of sets) {
  const range = heights.reduce((a, b) => Math.max(a, b)) - heights.reduce((a, b) => Math.min(a, b));
  for (const share of [0.01, 0.003]) {
    const wanted = Number((range * share).toPrecision(2));
    for (const [method, prepare] of Object.entries(methods)) {
      const make = prepare(heights), asked = askFor(make, heights, wanted), made = make(asked);
      const ms = shortest(() => make(asked), method === "Delatin" ? 3 : 9);
      console.log(`| ${name} | ${wanted} m | ${method} | ${asked.toPrecision(3)} m | ${trueError(heights, made).toPrecision(3)} m | ${(made.triangles.length / 3).toLocaleString("en")} | ${ms.toFixed(1)} |`);
    }
  }
}
