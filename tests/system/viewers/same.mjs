// Whether two .glb files, neither of them compressed, have the same meshes: attributes byte for byte, and triangles that
// may begin with another corner.   same.mjs A.glb B.glb
// Prints one line of JSON: how many triangles there are, and how many things differ.
import { readFileSync } from 'node:fs'

const bytesOf = { 5122: 2, 5123: 2, 5125: 4, 5126: 4 }, numbers = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 }

function read(path) {
  const data = readFileSync(path), size = data.readUInt32LE(12)
  const gltf = JSON.parse(data.subarray(20, 20 + size).toString()), binary = data.subarray(20 + size + 8)
  const elements = index => {
    const { bufferView, count, componentType, type } = gltf.accessors[index], view = gltf.bufferViews[bufferView]
    const width = bytesOf[componentType] * numbers[type], stride = view.byteStride ?? width
    return Array.from({ length: count }, (_, i) =>
      binary.subarray(view.byteOffset + i * stride, view.byteOffset + i * stride + width).toString('hex'))
  }
  return gltf.meshes.map(({ name, primitives: [{ attributes, indices }] }) => ({ name, indices: elements(indices),
    attributes: Object.fromEntries(Object.entries(attributes).map(([kind, index]) => [kind, elements(index)])) }))
}

const turned = ([a, b, c]) => [[a, b, c], [b, c, a], [c, a, b]].map(t => t.join()).sort()[0]
const triangles = list => Array.from({ length: list.length / 3 }, (_, i) => turned(list.slice(3 * i, 3 * i + 3)))

const [one, two] = process.argv.slice(2).map(read)
const found = { triangles: 0, different: Math.abs(one.length - two.length) }
const compare = (a, b) => { found.different += a.length !== b.length || a.some((v, i) => v !== b[i]) }
one.forEach((mesh, i) => {
  const other = two[i], first = triangles(mesh.indices)
  found.triangles += first.length
  compare(first, triangles(other.indices))
  compare(Object.keys(mesh.attributes).sort(), Object.keys(other.attributes).sort())
  for (const kind of Object.keys(mesh.attributes)) compare(mesh.attributes[kind], other.attributes[kind])
})
console.log(JSON.stringify(found))
