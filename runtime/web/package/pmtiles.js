// PMTiles 3: a pyramid of tiles in one file, read by ranges. Offsets and lengths are checked before they are used.
import { sourceOf } from "./source.js";

const headerBytes = 127, firstBytes = 16384, mostDirectory = 1 << 24, keptLeaves = 64;

class Reader {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }
  varint() { // up to 2^53, which JavaScript's numbers hold
    let value = 0;
    for (let scale = 1; scale < 2 ** 53; scale *= 128) {
      const byte = this.bytes[this.at++];
      if (byte === undefined) break;
      value += (byte & 127) * scale;
      if (byte < 128) return value;
    }
    throw new Error("pmtiles: a directory is damaged");
  }
}

async function unpacked(bytes, compression) {
  if (compression === 1) return bytes;
  if (compression !== 2) throw new Error("pmtiles: is compressed by something else than gzip; convert it");
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer().catch(() => { throw new Error("pmtiles: is damaged"); }));
}

function directory(bytes) {
  const reader = new Reader(bytes), count = reader.varint();
  if (count > bytes.length) throw new Error("pmtiles: a directory is damaged");
  const entries = Array.from({ length: count }, () => ({ id: 0, run: 0, length: 0, offset: 0 }));
  let id = 0;
  for (const entry of entries) entry.id = id += reader.varint();
  for (const entry of entries) entry.run = reader.varint();
  for (const entry of entries) entry.length = reader.varint();
  entries.forEach((entry, i) => {
    const offset = reader.varint();
    entry.offset = offset === 0 && i > 0 ? entries[i - 1].offset + entries[i - 1].length : offset - 1;
  });
  return entries;
}

/** The number of a tile: those of coarser zooms first, then along Hilbert's curve. */
export function tileNumber(z, x, y) {
  let number = (4 ** z - 1) / 3;
  for (let side = 2 ** (z - 1); side >= 1; side /= 2) {
    const east = Math.floor(x / side) % 2, south = Math.floor(y / side) % 2;
    number += side * side * ((3 * east) ^ south);
    if (south === 0) { // the quarter's curve is turned
      if (east === 1) [x, y] = [side - 1 - x % side, side - 1 - y % side];
      else [x, y] = [x % side, y % side];
      [x, y] = [y, x];
    } else {
      [x, y] = [x % side, y % side];
    }
  }
  return number;
}

export class PmTiles {
  #source; #opened; #leaves = new Map();

  /** source: a URL, the file's bytes, or an object with size() and read(). options: those of HttpSource. */
  constructor(source, options) { this.#source = sourceOf(source, options); }

  /** What the header says. */
  async header() { return (await this.#open()).header; }

  #open() {
    this.#opened ??= this.#read();
    this.#opened.catch(() => { this.#opened = undefined; }); // the next call tries again
    return this.#opened;
  }

  async #read() {
    const size = await this.#source.size();
    const start = await this.#source.read(0, Math.min(firstBytes, size)), view = new DataView(start.buffer, start.byteOffset, start.length);
    if (start.length < headerBytes || new TextDecoder().decode(start.subarray(0, 7)) !== "PMTiles") throw new Error("pmtiles: this is no PMTiles file");
    if (start[7] !== 3) throw new Error(`pmtiles: has version ${start[7]}; only 3 is read`);
    const number = (at) => Number(view.getBigUint64(at, true)), degrees = (at) => view.getInt32(at, true) / 1e7;
    const header = { size, root: number(8), rootBytes: number(16), leaves: number(40), leavesBytes: number(48), tiles: number(56), tilesBytes: number(64),
      compression: start[97], tileCompression: start[98], type: start[99], minZoom: start[100], maxZoom: start[101],
      bounds: [degrees(102), degrees(106), degrees(110), degrees(114)] };
    if (header.rootBytes > mostDirectory) throw new Error("pmtiles: is damaged");
    const root = header.root + header.rootBytes <= start.length ? start.subarray(header.root, header.root + header.rootBytes)
      : await this.#source.read(header.root, header.rootBytes);
    return { header, root: directory(await unpacked(root, header.compression)) };
  }

  async #leaf(header, { offset, length }) {
    let leaf = this.#leaves.get(offset);
    if (!leaf) {
      if (offset + length > header.leavesBytes || length > mostDirectory) throw new Error("pmtiles: a directory is damaged");
      leaf = this.#source.read(header.leaves + offset, length).then((bytes) => unpacked(bytes, header.compression)).then(directory);
      leaf.catch(() => this.#leaves.delete(offset));
      if (this.#leaves.size >= keptLeaves) this.#leaves.delete(this.#leaves.keys().next().value);
      this.#leaves.set(offset, leaf);
    }
    return leaf;
  }

  /** The bytes of a tile; null: the file has none there. */
  async tile(z, x, y, signal) {
    const { header, root } = await this.#open(), id = tileNumber(z, x, y);
    let entries = root;
    for (let depth = 0; depth < 4; ++depth) {
      let low = 0, high = entries.length; // the last entry that does not begin behind the tile
      while (low < high) {
        const middle = (low + high) >> 1;
        if (entries[middle].id <= id) low = middle + 1;
        else high = middle;
      }
      const entry = entries[low - 1];
      if (!entry) return null;
      if (entry.run > 0) {
        if (id >= entry.id + entry.run) return null;
        if (entry.offset < 0 || entry.offset + entry.length > header.tilesBytes) throw new Error("pmtiles: a directory is damaged");
        return unpacked(await this.#source.read(header.tiles + entry.offset, entry.length, signal), header.tileCompression || 1);
      }
      entries = await this.#leaf(header, entry);
    }
    throw new Error("pmtiles: a directory is damaged");
  }
}
