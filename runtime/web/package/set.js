// A pack set over HTTP: set.json and its packs, as one file that exists nowhere (docs/pack-format.md).
import { compile, Instance } from "./instance.js";
import { HttpSource } from "./source.js";

const headerBytes = 512, atATime = 8; // packs that are opened at a time

export const isSetUrl = (given) => (typeof given === "string" || given instanceof URL) && /(^|\/)set\.json([?#]|$)/.test(String(given));

function checked(set, url) {
  const count = (value, most = 2 ** 20) => Number.isInteger(value) && value >= 0 && value <= most;
  const whole = set?.fjell_set === 1 && count(set.columns) && count(set.rows) && count(set.tile_cells) && Array.isArray(set.packs) && set.packs.length > 0 &&
    set.packs.length <= 65536 && set.spacing_m?.length === 2;
  const bad = whole && set.packs.find((pack) => !(typeof pack?.file === "string" && [pack.tile_x, pack.tile_y, pack.tiles_x, pack.tiles_y].every((n) => count(n))));
  if (!whole || bad) throw new Error(`${url}: is no index of a pack set; write it again with fjell-bake`);
  return set;
}

export class SetSource {
  #url; #open; #options; #joined; #parts = [];

  /** url: of set.json. open(url, options): a source for one of its packs, instead of an HttpSource. */
  constructor(url, { open = (part, options) => new HttpSource(part, options), ...options } = {}) {
    this.#url = String(new URL(url, globalThis.location?.href));
    this.#open = open;
    this.#options = options;
  }

  get isSet() { return true; }
  async size() { return (await this.#whole()).bytes; }

  async read(offset, bytes, signal) {
    const { header, tail, tailAt } = await this.#whole();
    if (offset < headerBytes) return header.slice(offset, offset + bytes);
    if (offset >= tailAt) return tail.slice(offset - tailAt, offset - tailAt + bytes);
    const { source, begins } = this.#partAt(offset);
    return source.read(offset - begins, bytes, signal);
  }

  async forget(offset, bytes) {
    if (!(offset >= headerBytes && offset < (await this.#whole()).tailAt)) return; // those are nobody's
    const { source, begins } = this.#partAt(offset);
    await source.forget?.(offset - begins, bytes);
  }

  #partAt(offset) {
    let low = 0, high = this.#parts.length; // the last that does not begin behind it
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.#parts[middle].begins <= offset) low = middle;
      else high = middle;
    }
    return this.#parts[low];
  }

  close() { for (const { source } of this.#parts) source.close?.(); }

  #whole() {
    this.#joined ??= this.#join();
    this.#joined.catch(() => { this.#joined = undefined; }); // the next call tries again
    return this.#joined;
  }

  async #index() {
    const text = await this.#text();
    let set;
    try { set = JSON.parse(text); } catch { /* said below */ }
    return checked(set, this.#url);
  }

  async #text() {
    const response = await (this.#options.fetch ?? fetch)(this.#url, { headers: {} });
    if (!response.ok) throw new Error(`${this.#url}: ${response.status} ${response.statusText}`);
    return response.text();
  }

  /** The packs' sources, of which each says how much it has read. */
  #sources(packs) {
    const { onProgress, ...options } = this.#options, folder = new URL(".", this.#url).href, read = new Float64Array(packs.length);
    return packs.map(({ file }, i) => {
      const url = new URL(file, folder).href;
      if (!url.startsWith(folder)) throw new Error(`${this.#url}: ${file} lies in another folder`);
      const told = onProgress && ((bytes) => {
        read[i] = bytes;
        onProgress(read.reduce((a, b) => a + b, 0));
      });
      return { url, source: this.#open(url, { ...options, ...(told && { onProgress: told }) }) };
    });
  }

  async #join() {
    const [module, set] = await Promise.all([compile(), this.#index()]);
    this.close();
    const parts = (this.#parts = this.#sources(set.packs)), read = new Array(parts.length);
    let next = 0;
    const worker = async () => {
      while (next < parts.length) {
        const i = next++;
        read[i] = await readIndex(module, parts[i]);
      }
    };
    await Promise.all(Array.from({ length: Math.min(atATime, parts.length) }, worker));
    return join(module, set, parts, read);
  }
}

async function readIndex(module, { source, url }) {
  const size = await source.size();
  if (size < headerBytes) throw new Error(`${url}: the pack ends too early; copy or bake it again`);
  const header = await source.read(0, headerBytes), instance = new Instance(module);
  try {
    instance.calls.pack_index(instance.copy(header), size);
  } catch (error) {
    throw new Error(`${url}: ${error.message}`);
  }
  const [at, bytes] = instance.numbers;
  if (at + bytes > size) throw new Error(`${url}: the pack ends too early; copy or bake it again`);
  const index = new Uint8Array(headerBytes + bytes);
  index.set(header);
  index.set(await source.read(at, bytes), headerBytes);
  return { size, index };
}

async function join(module, set, parts, read) {
  const instance = new Instance(module), { calls } = instance, made = calls.set_make();
  const other = (i, what) => new Error(`${parts[i].url}: ${what} than set.json says; copy the pack again, or write the set again`);
  let begins = headerBytes;
  for (let i = 0; i < parts.length; ++i) {
    const { size, index } = read[i], pack = set.packs[i], at = instance.copy(index);
    try {
      calls.set_part(made, at, index.length, size, pack.tile_x, pack.tile_y);
    } catch (error) {
      throw new Error(`${parts[i].url}: ${error.message}`);
    }
    const [cornersAt, cornersBytes, tilesX, tilesY, cells, dx, dz, high, low] = instance.refresh();
    const hash = [high, low].map((half) => half.toString(16).padStart(8, "0")).join("");
    if (pack.pack_hash && pack.pack_hash !== hash) throw other(i, "another pack (pack_hash)");
    if (tilesX !== pack.tiles_x || tilesY !== pack.tiles_y) throw other(i, "other numbers of tiles");
    if (cells !== set.tile_cells) throw other(i, "another tile size");
    if (![dx, dz].every((spacing, axis) => Math.abs(set.spacing_m[axis] / spacing - 1) < 1e-12)) throw other(i, "another spacing");
    calls.web_free(at);
    const corners = instance.copy(await parts[i].source.read(cornersAt, cornersBytes));
    calls.set_corners(made, i, corners, cornersBytes);
    calls.web_free(corners);
    parts[i].begins = begins;
    begins += size;
  }
  const wrong = calls.set_join(made, set.columns, set.rows);
  const [headerAt, tailAt, tailBytes, tailOffset, bytes] = instance.refresh();
  if (wrong !== 0) throw new Error(`${parts[headerAt]?.url ?? "set.json"}: ${instance.text(wrong)}; the packs of a set must be of one bake`);
  return { header: new Uint8Array(instance.memory.buffer, headerAt, headerBytes).slice(),
    tail: new Uint8Array(instance.memory.buffer, tailAt, tailBytes).slice(), tailAt: tailOffset, bytes };
}
