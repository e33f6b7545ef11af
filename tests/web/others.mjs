// Beside Martini and Delatin: what each takes for a mesh that is really within an error, on the same heights, in one run.
//   node others.mjs [PACK[@COLUMN,ROW]...]   in a folder where npm has installed the packages that package.json names, and fjell
// The tile has 257 x 257 samples from COLUMN and ROW on, of the pack's middle without them. The error wanted is 1% of the
// tile's relief. Each is asked for less and less until its true error, measured at every sample, is at most that. Times
// are the shortest of several runs, from heights to triangles, preparations included.
import { readFile } from "node:fs/promises";
import { basename } from "node:path";

import Martini from "@mapbox/martini";
import Delatin from "delatin";
import { ready, Terrain } from "fjell";

import { hills, measure } from "./surface.mjs";

const side = 257;
const { mesh } = await ready();

/** Heights of a pack, from a sample on, and what the file is called. */
async function tile(given) {
  const [file, corner] = given.split("@"), terrain = await Terrain.open(await readFile(file), { whole: true, pageSlots: 1 << 20 });
  const [x0, z0] = corner ? corner.split(",").map(Number) : [(terrain.columns - side) >> 1, (terrain.rows - side) >> 1];
  const [dx, dz] = terrain.spacing, heights = Float32Array.from({ length: side * side }, (_, i) => terrain.height((x0 + i % side) * dx, (z0 + Math.floor(i / side)) * dz));
  terrain.close();
  if (heights.some(Number.isNaN)) throw new Error(`${given}: has holes, or ends too early`);
  return [basename(given).replace(".fjell", ""), heights];
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

const tiles = [["hills.mjs", hills(side, side)]];
for (const given of process.argv.slice(2)) tiles.push(await tile(given));
const names = Object.keys(methods), digits = (value, count) => Number(value.toPrecision(count));
console.log(`${side} x ${side} samples, node ${process.version}`);
console.log(`| tile | error, m | Martini is asked for, m | ${names.filter((name) => !name.includes("kept")).map((name) => `triangles: ${name}`).join(" | ")} | ${names.map((name) => `ms: ${name}`).join(" | ")} |`);
for (const [name, heights] of tiles) {
  const wanted = digits((heights.reduce((a, b) => Math.max(a, b)) - heights.reduce((a, b) => Math.min(a, b))) * 0.01, 3);
  const row = Object.fromEntries(Object.entries(methods).map(([method, prepare]) => {
    const make = prepare(heights), asked = askFor(make, heights, wanted);
    return [method, { asked, triangles: make(asked).triangles.length / 3, ms: shortest(() => make(asked), method === "Delatin" ? 5 : 60) }];
  }));
  const triangles = ["fjell", "Martini", "Delatin"].map((method) => row[method].triangles.toLocaleString("en"));
  console.log(`| ${[name, wanted, digits(row.Martini.asked, 3), ...triangles, ...names.map((method) => row[method].ms.toFixed(1))].join(" | ")} |`);
}
