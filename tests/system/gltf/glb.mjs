// Reads a .glb from the specification alone (glTF 2.0, sections 3.6 and 4.4); shares no code with Fjell.
import zlib from 'node:zlib';

const componentBytes = {
    5120: 1,
    5121: 1,
    5122: 2,
    5123: 2,
    5125: 4,
    5126: 4
};
const typeSize = {
    SCALAR: 1,
    VEC2: 2,
    VEC3: 3,
    VEC4: 4
};

// Buffer -> { json, bin }. Throws on a container that is not one.
export function parseGlb(file) {
    if (file.length < 20 || file.toString('latin1', 0, 4) !== 'glTF') throw new Error('not a .glb');
    if (file.readUInt32LE(4) !== 2) throw new Error('not version 2');
    if (file.readUInt32LE(8) !== file.length)
        throw new Error(`length field ${file.readUInt32LE(8)}, file has ${file.length}`);
    const chunks = [];
    for (let at = 12; at < file.length;) {
        const length = file.readUInt32LE(at), type = file.readUInt32LE(at + 4);
        if (length % 4 !== 0 || at + 8 + length > file.length) throw new Error(`chunk at ${at} has length ${length}`);
        chunks.push({type, data: file.subarray(at + 8, at + 8 + length)});
        at += 8 + length;
    }
    if (chunks.length !== 2 || chunks[0].type !== 0x4e4f534a || chunks[1].type !== 0x004e4942)
        throw new Error('chunks are not JSON, BIN');
    const json = JSON.parse(new TextDecoder('utf-8', {fatal: true}).decode(chunks[0].data));
    const spare = chunks[1].data.length - json.buffers[0].byteLength;
    if (json.buffers.length !== 1 || json.buffers[0].uri !== undefined || spare < 0 || spare > 3)
        throw new Error('the one buffer is not the BIN chunk');
    return {json, bin: chunks[1].data};
}

// { json, bin } -> Buffer, for files that were tampered with.
export function writeGlb({json, bin}) {
    const text = Buffer.from(JSON.stringify(json), 'utf-8');
    const padded = Buffer.concat([text, Buffer.alloc((4 - text.length % 4) % 4, ' ')]);
    const head = Buffer.alloc(20), binHead = Buffer.alloc(8);
    head.write('glTF', 0, 'latin1');
    [2, 28 + padded.length + bin.length, padded.length, 0x4e4f534a].forEach(
        (word, i) => head.writeUInt32LE(word, 4 + 4 * i));
    [bin.length, 0x004e4942].forEach((word, i) => binHead.writeUInt32LE(word, 4 * i));
    return Buffer.concat([head, padded, binHead, bin]);
}

export function viewBytes({json, bin}, index) {
    const view = json.bufferViews[index], begin = view.byteOffset ?? 0;
    if (begin + view.byteLength > json.buffers[0].byteLength) throw new Error(`bufferView ${index} leaves the buffer`);
    return bin.subarray(begin, begin + view.byteLength);
}

// Where component k of element i lies in the BIN chunk.
export function place({json}, index, i, k) {
    const accessor = json.accessors[index], view = json.bufferViews[accessor.bufferView];
    const size = componentBytes[accessor.componentType];
    const stride = view.byteStride ?? size * typeSize[accessor.type];
    return (view.byteOffset ?? 0) + (accessor.byteOffset ?? 0) + i * stride + k * size;
}

// All components of an accessor, tightly packed; normalised ones from -1 or 0 to 1.
export function readAccessor(glb, index) {
    const accessor = glb.json.accessors[index], width = typeSize[accessor.type];
    const read = {5122: 'readInt16LE', 5123: 'readUInt16LE', 5125: 'readUInt32LE', 5126: 'readFloatLE'}[accessor.componentType];
    if (!read) throw new Error(`accessor ${index}: component type ${accessor.componentType}`);
    const values = new Float64Array(accessor.count * width);
    const whole = accessor.normalized ? {5122: 32767, 5123: 65535}[accessor.componentType] : 1;
    for (let i = 0; i < accessor.count; ++i)
        for (let k = 0; k < width; ++k) values[i * width + k] = glb.bin[read](place(glb, index, i, k)) / whole;
    return {values, width, count: accessor.count, accessor};
}

function paeth(a, b, c) {
    const p = a + b - c, pa = Math.abs(p - a), pb = Math.abs(p - b), pc = Math.abs(p - c);
    return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}

// PNG bytes -> { size: [width, height], rgb }. 8-bit RGB without interlacing only.
export function decodePng(bytes) {
    const parts = [];
    let width = 0, height = 0;
    for (let at = 8; at < bytes.length;) {
        const length = bytes.readUInt32BE(at), type = bytes.toString('latin1', at + 4, at + 8);
        const data = bytes.subarray(at + 8, at + 8 + length);
        if (type === 'IHDR') {
            [width, height] = [data.readUInt32BE(0), data.readUInt32BE(4)];
            if (data[8] !== 8 || data[9] !== 2 || data[12] !== 0) throw new Error('PNG is not 8-bit RGB');
        }
        if (type === 'IDAT') parts.push(data);
        at += 12 + length;
    }
    const raw = zlib.inflateSync(Buffer.concat(parts)), row = width * 3;
    if (raw.length !== height * (row + 1)) throw new Error('PNG has the wrong amount of data');
    const rgb = new Uint8Array(height * row);
    for (let y = 0; y < height; ++y) {
        const filter = raw[y * (row + 1)];
        for (let x = 0; x < row; ++x) {
            const left = x >= 3 ? rgb[y * row + x - 3] : 0, above = y > 0 ? rgb[(y - 1) * row + x] : 0;
            const corner = x >= 3 && y > 0 ? rgb[(y - 1) * row + x - 3] : 0;
            const guess = [0, left, above, (left + above) >> 1, paeth(left, above, corner)][filter];
            rgb[y * row + x] = raw[y * (row + 1) + 1 + x] + guess;
        }
    }
    return {size: [width, height], rgb};
}
