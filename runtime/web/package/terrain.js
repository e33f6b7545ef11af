// Terrain: a pack that is streamed, refined to a bound within budgets, and asked for heights and rays.
import { writeGlb } from "./glb.js";
import { compile, Instance } from "./instance.js";
import { isSetUrl, SetSource } from "./set.js";
import { sourceOf } from "./source.js";

export const defaults = Object.freeze({
  pageSlots: 4096, vertices: 1 << 17, triangles: 1 << 18, views: 1, pageRequests: 64, mapRequests: 16,
  mapBytes: 64 << 20, editBlocks: 0, whole: false, maps: false,
});

const viewNumbers = 18, viewsAt = 256, morphAt = 64;

function length3(v) { return Math.hypot(v[0], v[1], v[2]); }

/**
 * A view of square pixels that looks along `forward`, or at `target`. out: a view of an earlier call, which is changed
 * instead of making a new one.
 */
export function makeView({ eye, forward, target, up = [0, 1, 0], fovY = 0.8, width, height, near = 1, far = 1e6, maxError = 0 }, out) {
  const view = out ?? { eye: [0, 0, 0], forward: [0, 0, -1], up: [0, 1, 0] };
  const f = view.forward, u = view.up;
  for (let i = 0; i < 3; ++i) {
    view.eye[i] = eye[i];
    f[i] = forward ? forward[i] : target[i] - eye[i];
  }
  const far_ = length3(f);
  for (let i = 0; i < 3; ++i) f[i] /= far_;
  const along = up[0] * f[0] + up[1] * f[1] + up[2] * f[2];
  for (let i = 0; i < 3; ++i) u[i] = up[i] - along * f[i];
  const high = length3(u);
  for (let i = 0; i < 3; ++i) u[i] /= high;
  view.top = Math.tan(fovY / 2);
  view.bottom = -view.top;
  view.right = view.top * width / height;
  view.left = -view.right;
  view.width = width;
  view.height = height;
  view.near = near;
  view.far = far;
  view.maxError = maxError;
  return view;
}

const nothing = new Uint32Array(0);

/** What an update has done. One object for all updates of a terrain. */
class Frame {
  constructor() {
    this.converged = this.settled = this.complete = false;
    this.vertices = this.triangles = this.trianglesDrawn = 0;
    this.errorBound = this.threshold = 0;
    this.waiting = this.inFlight = this.failed = this.bytesRead = this.pagesRead = this.pagesLoaded = 0;
    this.updateMs = 0;
    this.work = this.activations = this.deactivations = 0;
    this.shortOf = 0;
    this.ranges = nothing;
    this.rangeCount = 0;
    this.mapsArrived = 0;
  }
}

export class Terrain {
  #instance; #calls; #numbers; #ground; #source; #index = 0; #staging; #flights = new Map(); #arrived = []; #closed = false;
  #failure = null; #places;

  /** source: the URL of a pack or of the set.json of a pack set, the bytes of a pack, or an object with size() and read(). */
  static async open(source, options = {}) {
    const { module, ...rest } = options;
    const unknown = Object.keys(rest).find((name) => !(name in defaults) && name !== "source");
    if (unknown) throw new TypeError(`${unknown}: is no option of Terrain.open`);
    const budget = { ...defaults, ...rest };
    for (const [name, value] of Object.entries(budget))
      if (typeof defaults[name] === "number" && !(Number.isInteger(value) && value >= 0)) throw new RangeError(`${name}: is ${value}; give a whole number`);
    const from = isSetUrl(source) ? new SetSource(source, options.source) : sourceOf(source, options.source), used = module ?? (await compile());
    const ranges = new Map(), noted = (offset, bytes) => {
      ranges.set(offset, bytes);
      return from.read(offset, bytes);
    };
    for (const forgotten = new Set();;) {
      try {
        return await new Terrain().#open(used, budget, from, noted);
      } catch (error) { // perhaps a cache keeps what is damaged: until nothing is left that it may be
        const suspects = [...ranges].filter(([offset]) => !forgotten.has(offset));
        if (!from.forget || suspects.length === 0) throw error;
        for (const [offset, bytes] of suspects) {
          await from.forget(offset, bytes);
          forgotten.add(offset);
        }
      }
    }
  }

  async #open(module, budget, source, read) {
    this.#source = source;
    const size = await source.size();
    if (size < 512) throw new Error("pack: the pack ends too early; copy or bake it again");
    const instance = (this.#instance = new Instance(module));
    const calls = (this.#calls = instance.calls);
    const header = await read(0, 512);
    let at = instance.copy(header);
    calls.pack_index(at, size);
    let n = instance.refresh();
    const [directoryAt, directoryBytes] = n;
    if (directoryAt + directoryBytes > size) throw new Error("pack: the pack ends too early; copy or bake it again");
    calls.web_free(at);
    const index = new Uint8Array(512 + directoryBytes);
    index.set(header);
    index.set(await read(directoryAt, directoryBytes), 512);
    at = instance.copy(index);
    this.#ground = calls.ground_index(at, index.length, size, source.isSet === true);
    calls.web_free(at);
    n = instance.refresh();
    const [cornersAt, cornersBytes, columns, rows, dx, dz, low, high, quantum, tilesX, tilesZ, tileCells,
      , , originX, originZ, holes, pages] = n;
    Object.assign(this, { columns, rows, spacing: [dx, dz], extent: [(columns - 1) * dx, (rows - 1) * dz],
      heightRange: [low, high], quantum, tiles: [tilesX, tilesZ], tileCells, origin: [originX, originZ], holes, pages });
    at = instance.copy(await read(cornersAt, cornersBytes));
    n.set([budget.whole ? 0 : budget.pageSlots, budget.vertices, budget.triangles, budget.views, budget.pageRequests,
      budget.mapRequests, budget.maps ? budget.mapBytes : 0, budget.editBlocks]);
    calls.ground_open(this.#ground, at, cornersBytes, budget.whole);
    calls.web_free(at);
    n = instance.refresh();
    this.#places = Array.from(n.subarray(0, 14));
    this.memoryBytes = n[0];
    this.budget = Object.freeze(budget);
    /** log2 of the texels a side that each tile's map has; 0: the pack has none, or they were not asked for. */
    this.mapLog2 = budget.maps ? { colour: n[1], normal: n[2] } : { colour: 0, normal: 0 };
    this.settings = { maxError: 1, hysteresis: 0, maxWork: 0, maxMs: 0, morph: "none", morphS: 0.25, offscreenFactor: 1, pagesPerUpdate: 16 };
    this.frame = new Frame();
    this.changes = { vertexRuns: nothing, vertexRunCount: 0, triangleRuns: nothing, triangleRunCount: 0 };
    this.morph = { nowS: 0, morphS: 1, views: 0, numbers: new Float32Array(8 * 5) };
    this.#see();
    if (budget.whole) await this.#loadAll(read);
    return this;
  }

  /** Arrays of the module's memory. It does not grow after opening. */
  #see() {
    const buffer = this.#instance.memory.buffer;
    const [, , , vertices, vertexCount, indices, indexCount, morph, ranges, rangeMost, vertexRuns, triangleRuns, staging, stagingBytes] = this.#places;
    /** Three numbers a vertex: column, row, and the bits of the height, which `heights` shows as numbers. */
    this.vertexSlots = new Int32Array(buffer, vertices, 3 * vertexCount);
    this.heightSlots = new Float32Array(buffer, vertices, 3 * vertexCount);
    this.morphSlots = new Float32Array(buffer, morph, 4 * vertexCount);
    this.indexSlots = new Uint32Array(buffer, indices, indexCount);
    this.frame.ranges = new Uint32Array(buffer, ranges, rangeMost);
    this.changes.vertexRuns = new Uint32Array(buffer, vertexRuns, 4096);
    this.changes.triangleRuns = new Uint32Array(buffer, triangleRuns, 4096);
    this.#staging = new Uint8Array(buffer, staging, stagingBytes);
    this.#numbers = this.#instance.refresh();
  }

  async #loadAll(read) {
    for (let page = 0; page < this.pages; ++page) {
      this.#calls.ground_page(this.#ground, page);
      const [offset, bytes] = this.#numbers;
      const at = this.#instance.copy(await read(offset, bytes));
      this.#calls.ground_insert(this.#ground, page, at, bytes);
      this.#calls.web_free(at);
      if (this.#numbers.length === 0) this.#see();
    }
  }

  #open_or_throw() {
    if (this.#closed) throw new Error("the terrain is closed");
  }

  /**
   * Refines the mesh for views, within the settings, and reads what they want. nowS: the caller's clock in seconds.
   * Returns `frame`. Makes no garbage while nothing is read.
   */
  update(views, nowS = performance.now() / 1e3) {
    this.#open_or_throw();
    if (views.length < 1 || views.length > this.budget.views) throw new RangeError(`views: has ${views.length}; give 1 to ${this.budget.views}, or open the terrain with more`);
    if (!this.budget.whole) this.#serve();
    const n = this.#numbers, s = this.settings;
    for (let i = 0; i < views.length; ++i) {
      const v = views[i], to = viewsAt + i * viewNumbers;
      for (let k = 0; k < 3; ++k) {
        n[to + k] = v.eye[k];
        n[to + 3 + k] = v.forward[k];
        n[to + 6 + k] = v.up[k];
      }
      n[to + 9] = v.left;
      n[to + 10] = v.right;
      n[to + 11] = v.bottom;
      n[to + 12] = v.top;
      n[to + 13] = v.width;
      n[to + 14] = v.height;
      n[to + 15] = v.near;
      n[to + 16] = v.far;
      n[to + 17] = v.maxError;
    }
    n[0] = s.maxError;
    n[1] = s.hysteresis;
    n[2] = s.maxWork;
    n[3] = s.maxMs * 1e3;
    n[4] = s.morph === "none" ? 0 : s.morph === "error" ? 1 : 2;
    n[5] = s.morphS;
    n[6] = s.offscreenFactor;
    n[7] = s.pagesPerUpdate;
    try {
      this.#calls.ground_update(this.#ground, views.length, nowS);
    } catch (error) {
      this.#drop();
      throw error;
    }
    const f = this.frame, m = this.morph;
    f.rangeCount = n[0];
    f.converged = n[1] === 1;
    f.settled = n[2] === 1;
    f.vertices = n[3];
    f.triangles = n[4];
    f.trianglesDrawn = n[5];
    f.errorBound = n[6];
    f.threshold = n[7];
    f.waiting = n[8];
    f.shortOf = n[9] + 65536 * n[10];
    f.inFlight = n[11];
    f.failed = n[12];
    f.bytesRead = n[13];
    f.pagesRead = n[14];
    f.complete = n[16] === 1;
    f.updateMs = (n[17] + n[18]) / 1e3;
    f.work = n[19];
    f.activations = n[20];
    f.deactivations = n[21];
    f.mapsArrived = n[23];
    m.nowS = n[24];
    m.morphS = n[25];
    m.views = n[26];
    f.pagesLoaded = n[27];
    for (let i = 0; i < 5 * m.views; ++i) m.numbers[i] = n[morphAt + i];
    return f;
  }

  /** Names of the budgets and settings that did not suffice in the last update. */
  get shortOf() {
    const names = ["vertices", "triangles", "maxWork", "maxMs"], reading = ["pageSlots", "", "pagesPerUpdate", "", "", "pageRequests"];
    const cut = this.frame.shortOf % 65536, stream = Math.floor(this.frame.shortOf / 65536);
    return [...names.filter((_, i) => cut >> i & 1), ...reading.filter((name, i) => name && stream >> i & 1)];
  }

  /** Slots that were written since the last call: pairs of first and count, for upload. Triangles have three indices. */
  takeChanges() {
    this.#open_or_throw();
    this.#calls.ground_changes(this.#ground);
    this.changes.vertexRunCount = this.#numbers[0];
    this.changes.triangleRunCount = this.#numbers[1];
    return this.changes;
  }

  /**
   * Calls upload(kind, tile, mip, side, rgba) for each map that has come with the last update. kind: "colour" or
   * "normal", whose first two bytes are the east and south components, 128 + 127 v. rgba: valid during the call.
   */
  takeMaps(upload) {
    for (let i = 0; i < this.frame.mapsArrived; ++i) {
      this.#calls.ground_map(this.#ground, i);
      const [kind, tile, mips, log2] = this.#numbers;
      for (let mip = 0; mip < mips && log2 - mip >= 2; ++mip) {
        const side = 2 ** (log2 - mip);
        const at = this.#calls.ground_map_mip(this.#ground, i, mip) >>> 0;
        upload(kind === 0 ? "colour" : "normal", tile, mip, side, new Uint8Array(this.#instance.memory.buffer, at, 4 * side * side));
      }
    }
    this.frame.mapsArrived = 0;
  }

  // --- reading

  #serve() {
    const n = this.#numbers, calls = this.#calls, ground = this.#ground, source = this.#source;
    while (calls.ground_next_request(ground)) {
      const ticket = n[0], offset = n[1], bytes = n[2], chunks = source.readDecoded && Array.from(n.subarray(4, 4 + 4 * n[3]));
      if (source.readNow) {
        this.#provide(ticket, source.readNow(offset, bytes));
        continue;
      }
      const abort = new AbortController();
      this.#flights.set(ticket, abort);
      (chunks ? source.readDecoded(offset, bytes, chunks, abort.signal) : source.read(offset, bytes, abort.signal)).then(
        (data) => this.#arrived.push([ticket, data, null, offset]), (error) => this.#arrived.push([ticket, null, error]));
    }
    if (this.#flights.size === 0) return;
    for (const [ticket, abort] of this.#flights) if (!calls.ground_still_wanted(ground, ticket)) abort.abort();
    while (this.#arrived.length > 0) {
      const [ticket, data, error, offset] = this.#arrived.shift();
      const unwanted = this.#flights.get(ticket)?.signal.aborted ?? false;
      this.#flights.delete(ticket);
      if (data) {
        if (!this.#provide(ticket, data, source.readDecoded !== undefined)) source.forget?.(offset, data.length);
      } else {
        calls.ground_fail(ground, ticket, unwanted);
        if (!unwanted) this.#failure ??= error;
      }
    }
  }

  #provide(ticket, data, decoded = false) {
    const fits = data.length <= this.#staging.length;
    if (fits) this.#staging.set(data);
    if (this.#calls.ground_provide(this.#ground, ticket, fits ? data.length : 0, decoded)) return true;
    this.#failure ??= new Error("pack: the pack is damaged here; copy or bake it again");
    return false;
  }

  /** The first thing that could not be read; null: everything could. The terrain is coarser there. */
  get failure() { return this.#failure; }
  /** Asks again for what could not be read. */
  retry() {
    this.#failure = null;
    this.#calls.ground_retry(this.#ground);
  }

  /** Updates until nothing is missing any more, or nothing else can be done, and returns the frame. */
  async settle(views, nowS) {
    for (let i = 0; i < 20_000; ++i) {
      if (this.update(views, nowS === undefined ? undefined : nowS + i / 60).settled && this.#flights.size === 0) break;
      // By the real clock what morphs takes its time, however fast updates are.
      if (this.#flights.size > 0 || nowS === undefined) await new Promise((resolve) => setTimeout(resolve, 1));
    }
    return this.frame;
  }

  // --- questions

  /** The ground's height in metres; NaN beyond the terrain and in a hole. */
  height(x, z) {
    this.#open_or_throw();
    this.#calls.ground_height_at(this.#ground, x, z);
    return this.#numbers[0] ? this.#numbers[1] : NaN;
  }

  /** Height, unit normal of the triangle there, and how far the original ground may be; null where there is none. */
  ground(x, z) {
    this.#open_or_throw();
    this.#calls.ground_height_at(this.#ground, x, z);
    const [inside, height, error, nx, ny, nz] = this.#numbers;
    return inside ? { height, error, normal: [nx, ny, nz] } : null;
  }

  /** The first place where a ray meets the ground; null: nowhere. */
  ray(origin, direction, maxDistance = Infinity) {
    this.#open_or_throw();
    const n = this.#numbers;
    for (let k = 0; k < 3; ++k) {
      n[k] = origin[k];
      n[3 + k] = direction[k];
    }
    n[6] = maxDistance;
    this.#calls.ground_ray(this.#ground);
    if (!n[0]) return null;
    return { distance: n[1], position: [n[2], n[3], n[4]], normal: [n[5], n[6], n[7]], error: n[8] };
  }

  /** Changes the ground from the next update on; of a terrain that was opened with editBlocks. Returns its number. */
  edit({ shape, at: [x, z], radius, falloff = 0, amount = 0, height = 0, slope = [0, 0], wavelength = 0, seed = 0 }) {
    this.#open_or_throw();
    const shapes = ["raise", "level", "crater", "path", "noise", "smooth", "heights", "restore", "paint", "unpaint", "hole", "fill", "lock", "unlock"]; // StampShape
    if (this.budget.editBlocks === 0) throw new Error("editBlocks: is 0; open the terrain with more to edit it");
    if (!shapes.includes(shape) || ["path", "heights", "paint", "unpaint"].includes(shape)) throw new RangeError(`shape: is ${shape}; give raise, level, crater, noise, smooth, restore, hole, fill, lock or unlock`);
    this.#numbers.set([shapes.indexOf(shape), x, z, radius, falloff, amount, height, slope[0], slope[1], wavelength, seed]);
    const { numbers } = this.#instance;
    const bad = Array.from(numbers.subarray(0, 11)).some((value) => !Number.isFinite(value));
    if (bad || !(radius > 0)) throw new RangeError("edit: a number is missing or none");
    const why = this.#instance.text(this.#calls.ground_edit(this.#ground));
    if (why) throw new Error(`edit: ${why}`);
    return numbers[0];
  }

  /** What has become of an edit, by its number: the state, and why it is refused. */
  editState(edit) {
    this.#open_or_throw();
    if (this.budget.editBlocks === 0) return { state: "unknown", why: "" };
    const why = this.#instance.text(this.#calls.ground_edit_state(this.#ground, edit));
    return { state: ["unknown", "waiting", "applied", "refused", "moving"][this.#numbers[0]], why };
  }

  /** The mesh of the last update as binary glTF. */
  snapshot(view) {
    this.#open_or_throw();
    const tiles = [];
    for (let i = 0; this.#calls.ground_tile(this.#ground, i); ++i) {
      const [column, row, first, count] = this.#numbers;
      tiles.push({ column, row, first, count });
    }
    return writeGlb(this, tiles, view, {
      height: (vertex) => this.#calls.ground_drawn_height(this.#ground, vertex),
      normal: (x, z) => {
        this.#calls.ground_height_at(this.#ground, x, z);
        return [this.#numbers[3], this.#numbers[4], this.#numbers[5]];
      },
    });
  }

  /** Frees the memory. What is being read is dropped. */
  close() {
    this.#drop();
    this.#source.close?.();
  }

  #drop() {
    this.#closed = true;
    for (const abort of this.#flights.values()) abort.abort();
    this.#flights.clear();
    this.#instance = this.#calls = this.#numbers = undefined;
  }
}
