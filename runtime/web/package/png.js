// PNG, as tiles of heights have it, to texels: exactly, in node and workers too. A canvas changes colours by profiles, and
// where browsers guard against fingerprints it adds noise.

const signature = [137, 80, 78, 71, 13, 10, 26, 10];
const channelsOf = new Map([[2, 3], [6, 4]]); // RGB, RGBA

/** As many bytes as are expected, and never more in memory. */
async function inflated(parts, bytes) {
  const reader = new Blob(parts).stream().pipeThrough(new DecompressionStream("deflate")).getReader();
  const data = new Uint8Array(bytes);
  for (let at = 0;;) {
    const { done, value } = await reader.read();
    if (done && at === bytes) return data;
    if (done || at + value.length > bytes) throw new Error("too few or too many");
    data.set(value, at);
    at += value.length;
  }
}

function unfiltered(data, width, height, channels) {
  const row = width * channels, rgba = new Uint8ClampedArray(4 * width * height).fill(255);
  for (let y = 0; y < height; ++y) {
    const at = y * (row + 1) + 1, above = at - row - 1, filter = data[at - 1];
    if (filter > 4) throw new Error("tile: the PNG is damaged");
    for (let i = 0; i < row; ++i) {
      const left = i < channels ? 0 : data[at + i - channels];
      const up = y === 0 ? 0 : data[above + i], corner = i < channels || y === 0 ? 0 : data[above + i - channels];
      data[at + i] += filter === 0 ? 0 : filter === 1 ? left : filter === 2 ? up : filter === 3 ? (left + up) >> 1 : paeth(left, up, corner);
    }
    for (let x = 0; x < width; ++x) for (let k = 0; k < channels; ++k) rgba[4 * (y * width + x) + k] = data[at + x * channels + k];
  }
  return rgba;
}

function paeth(left, up, corner) { // whichever is nearest to left + up - corner
  const l = Math.abs(up - corner), u = Math.abs(left - corner), c = Math.abs(left + up - 2 * corner);
  return l <= u && l <= c ? left : u <= c ? up : corner;
}

/** { width, height, rgba }, or null for what is no PNG of 8 bits in RGB or RGBA. */
export async function decodePng(bytes) {
  if (!signature.every((byte, i) => bytes[i] === byte)) return null;
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength), parts = [];
  let width = 0, height = 0, channels = 0;
  for (let at = 8; at + 12 <= bytes.length;) {
    const length = view.getUint32(at), name = String.fromCharCode(...bytes.subarray(at + 4, at + 8)), body = at + 8;
    if (body + length + 4 > bytes.length) break;
    if (name === "IHDR") {
      width = view.getUint32(body);
      height = view.getUint32(body + 4);
      const [depth, kind, , , interlaced] = bytes.subarray(body + 8, body + 13);
      channels = channelsOf.get(kind);
      if (depth !== 8 || interlaced || !channels) return null;
      if (!(width > 0 && height > 0 && width * height <= 2 ** 26)) throw new Error(`tile: has ${width} x ${height} texels`);
    } else if (name === "tRNS") {
      return null;
    } else if (name === "IDAT") {
      parts.push(bytes.subarray(body, body + length));
    } else if (name === "IEND") {
      const data = await inflated(parts, height * (width * channels + 1)).catch(() => { throw new Error("tile: the PNG is damaged"); });
      return { width, height, rgba: unfiltered(data, width, height, channels) };
    }
    at = body + length + 4;
  }
  throw new Error("tile: the PNG ends too early");
}
