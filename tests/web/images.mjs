// PNG and PMTiles files for tests, written by node's zlib: with all filters of PNG, and with directories of leaves.
import { crc32, deflateSync, gzipSync } from "node:zlib";

const word = (value) => { const bytes = Buffer.alloc(4); bytes.writeUInt32BE(value >>> 0); return bytes; };

function chunk(name, data) {
  const named = Buffer.concat([Buffer.from(name), data]);
  return Buffer.concat([word(data.length), named, word(crc(named))]);
}
const table = Array.from({ length: 256 }, (_, n) => { for (let k = 0; k < 8; ++k) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1; return n >>> 0; });
const crc = crc32 ?? ((bytes) => ~bytes.reduce((c, byte) => table[(c ^ byte) & 255] ^ (c >>> 8), ~0) >>> 0); // node 20 has none

/** rgba: texels. channels: 3 leaves alpha out. Row y is filtered by filter(y). */
export function png(rgba, width, height, { channels = 4, filter = (y) => y % 5, idat = 1 << 14, kind, depth = 8, interlaced = 0 } = {}) {
  const row = width * channels, raw = new Uint8Array(row * height), lines = Buffer.alloc((row + 1) * height);
  for (let i = 0; i < width * height; ++i) for (let k = 0; k < channels; ++k) raw[i * channels + k] = rgba[4 * i + k];
  const at = (x, y) => (x < 0 || y < 0 ? 0 : raw[y * row + x]);
  for (let y = 0; y < height; ++y) {
    const f = (lines[y * (row + 1)] = filter(y));
    for (let x = 0; x < row; ++x) {
      const left = at(x - channels, y), up = at(x, y - 1), corner = x < channels ? 0 : at(x - channels, y - 1);
      const [l, u, c] = [Math.abs(up - corner), Math.abs(left - corner), Math.abs(left + up - 2 * corner)];
      const guess = [0, left, up, Math.floor((left + up) / 2), l <= u && l <= c ? left : u <= c ? up : corner][f];
      lines[y * (row + 1) + 1 + x] = at(x, y) - guess;
    }
  }
  const data = deflateSync(lines), parts = [];
  for (let i = 0; i < data.length; i += idat) parts.push(chunk("IDAT", data.subarray(i, i + idat)));
  const header = Buffer.concat([word(width), word(height), Buffer.from([depth, kind ?? (channels === 3 ? 2 : 6), 0, 0, interlaced])]);
  return Buffer.concat([Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]), chunk("IHDR", header), chunk("tEXt", Buffer.from("by\0tests")), ...parts, chunk("IEND", Buffer.alloc(0))]);
}

/** Heights as Terrarium has them, to 1/256 m; NaN is transparent. */
export function terrarium(heights, width, height, options) {
  const rgba = new Uint8Array(4 * width * height);
  heights.forEach((h, i) => {
    const code = Number.isNaN(h) ? 0 : Math.round((h + 32768) * 256);
    rgba.set([code >> 16, (code >> 8) & 255, code & 255, Number.isNaN(h) ? 0 : 255], 4 * i);
  });
  return png(rgba, width, height, options);
}

const varint = (value) => { const bytes = []; for (; value >= 128; value = Math.floor(value / 128)) bytes.push(value % 128 + 128); return [...bytes, value]; };

function directory(entries) {
  const columns = [entries.map(({ id }, i) => id - (i > 0 ? entries[i - 1].id : 0)), entries.map(({ run }) => run), entries.map(({ length }) => length),
    entries.map(({ offset, length }, i) => (i > 0 && offset === entries[i - 1].offset + entries[i - 1].length ? 0 : offset + 1))];
  return gzipSync(Buffer.from([varint(entries.length), ...columns.map((column) => column.flatMap(varint))].flat()));
}

/** tiles: of [number, bytes], by number. leaf: entries of a leaf; the root points to leaves if there are more. */
export function pmtiles(tiles, { leaf = 8, maxZoom = 14, compression = 1 } = {}) {
  const data = [], entries = [];
  let offset = 0;
  for (const [id, bytes] of tiles) {
    const last = entries[entries.length - 1];
    if (last && last.bytes === bytes && last.id + last.run === id) { // the same again
      ++last.run;
      continue;
    }
    entries.push({ id, run: 1, length: bytes.length, offset, bytes });
    data.push(bytes);
    offset += bytes.length;
  }
  const leaves = [];
  let root = entries, leavesBytes = 0;
  if (entries.length > leaf) {
    root = [];
    for (let i = 0; i < entries.length; i += leaf) {
      const bytes = directory(entries.slice(i, i + leaf));
      root.push({ id: entries[i].id, run: 0, length: bytes.length, offset: leavesBytes });
      leaves.push(bytes);
      leavesBytes += bytes.length;
    }
  }
  const rootBytes = directory(root), header = Buffer.alloc(127);
  header.write("PMTiles");
  header[7] = 3;
  const places = [127, rootBytes.length, 127 + rootBytes.length, 0, 127 + rootBytes.length, leavesBytes, 127 + rootBytes.length + leavesBytes, offset, tiles.length, entries.length, entries.length];
  places.forEach((value, i) => header.writeBigUInt64LE(BigInt(value), 8 + 8 * i));
  Buffer.from([1, 2, compression, 2, 0, maxZoom]).copy(header, 96);
  [5e7, 45e7, 10e7, 48e7].forEach((value, i) => header.writeInt32LE(value, 102 + 4 * i));
  return Buffer.concat([header, rootBytes, ...leaves, ...data]);
}
