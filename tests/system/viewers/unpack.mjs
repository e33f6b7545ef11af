// Writes .glb files that are compressed with EXT_meshopt_compression without it, decoded by meshoptimizer's decoder as
// three.js brings it.   unpack.mjs FOLDER: every .glb under it is replaced.
import { readdirSync, readFileSync, writeFileSync } from 'node:fs'
import { extname, join } from 'node:path'
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js'

const extension = 'EXT_meshopt_compression'
await MeshoptDecoder.ready

function unpacked(data) {
  const size = data.readUInt32LE(12)
  const gltf = JSON.parse(data.subarray(20, 20 + size).toString())
  const binary = data.subarray(20 + size + 8)
  const pieces = []
  let at = 0
  for (const view of gltf.bufferViews) {
    const packed = view.extensions?.[extension]
    const { byteOffset, byteLength, count, byteStride, mode, filter } = packed ?? view
    const from = binary.subarray(byteOffset, byteOffset + byteLength)
    const size = packed ? count * byteStride : byteLength
    const bytes = new Uint8Array(Math.ceil(size / 4) * 4)
    if (packed) MeshoptDecoder.decodeGltfBuffer(bytes.subarray(0, size), count, byteStride, from, mode, filter)
    else bytes.set(from) // a picture
    Object.assign(view, { buffer: 0, byteOffset: at })
    delete view.extensions
    pieces.push(bytes)
    at += bytes.length
  }
  for (const list of ['extensionsUsed', 'extensionsRequired']) gltf[list] = gltf[list].filter(name => name !== extension)
  gltf.buffers = [{ byteLength: at }]
  let text = JSON.stringify(gltf)
  text = text.padEnd(Math.ceil(Buffer.byteLength(text) / 4) * 4)
  const words = (...list) => Buffer.from(Uint32Array.from(list).buffer)
  return Buffer.concat([words(0x46546c67, 2, 28 + text.length + at, text.length, 0x4e4f534a), Buffer.from(text),
    words(at, 0x004e4942), ...pieces])
}

let files = 0
for (const entry of readdirSync(process.argv[2], { recursive: true, withFileTypes: true })) {
  const name = join(entry.parentPath ?? entry.path, entry.name)
  if (extname(name) !== '.glb') continue
  writeFileSync(name, unpacked(readFileSync(name)))
  ++files
}
console.log(JSON.stringify({ files }))
