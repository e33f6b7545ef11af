// Has programs of others read every tile under a folder: .terrain by HERE's decoder of quantized-mesh and loaders.gl,
// .glb by Khronos' validator of glTF; and a tileset from its root on by Cesium's 3d-tiles-tools, implicit or not.
//   read.mjs FOLDER
// Prints one line of JSON: how many files, triangles and tiles of a tileset, and what the readers found wrong.
import { existsSync, readdirSync, readFileSync } from 'node:fs'
import { extname, join } from 'node:path'
import { gunzipSync } from 'node:zlib'
import tools from '3d-tiles-tools'
import decoder from '@here/quantized-mesh-decoder'
import { QuantizedMeshLoader } from '@loaders.gl/terrain'
import { validateBytes } from 'gltf-validator'

const { default: decode, DECODING_STEPS } = decoder

const folder = process.argv[2]
const found = { files: 0, triangles: 0, tiles: 0, faults: [] }

async function readTerrain(name, bytes) {
  const plain = bytes[0] === 0x1f && bytes[1] === 0x8b ? gunzipSync(bytes) : bytes
  const copy = () => new Uint8Array(plain).buffer // they decode in place
  const tile = decode(copy(), { maxDecodingStep: DECODING_STEPS.extensions })
  const other = await QuantizedMeshLoader.parse(copy(), { 'quantized-mesh': { bounds: [0, 0, 1, 1] } })
  if (other.indices.value.length !== tile.triangleIndices.length) found.faults.push(`${name}: the readers differ`)
  const count = tile.vertexData.length / 3
  found.triangles += tile.triangleIndices.length / 3
  if (tile.triangleIndices.some(i => i >= count)) found.faults.push(`${name}: an index names no vertex`)
  if (!(tile.extensions.metadata?.geometricerror > 0)) found.faults.push(`${name}: its metadata tells no error`)
  if (tile.extensions.vertexNormals?.length !== 2 * count) found.faults.push(`${name}: ${count} normals are missing`)
}

async function readGlb(name, bytes) {
  const { issues, info } = await validateBytes(new Uint8Array(bytes), { uri: name })
  found.triangles += info.totalTriangleCount
  for (const { severity, code, message, pointer } of issues.messages)
    if (severity < 2) found.faults.push(`${name}: ${code} ${message} ${pointer}`) // errors and warnings
}

for (const entry of readdirSync(folder, { recursive: true, withFileTypes: true })) {
  const name = join(entry.parentPath ?? entry.path, entry.name), kind = extname(name)
  if (kind !== '.terrain' && kind !== '.glb') continue
  ++found.files
  try {
    await (kind === '.glb' ? readGlb : readTerrain)(name, readFileSync(name))
  } catch (error) {
    found.faults.push(`${name}: ${error}`)
  }
}
// Every tile that the tree has, with its content; errors as the tools derive them, tables included.
async function readTileset(path) {
  const resolver = new tools.FileResourceResolver(folder)
  const traverser = new tools.TilesetTraverser(folder, resolver, { depthFirst: true, traverseExternalTilesets: false })
  await traverser.traverse(JSON.parse(readFileSync(path, 'utf8')), async traversed => {
    const tile = traversed.asFinalTile(), parent = traversed.getParent()?.asFinalTile()
    if (parent && !(tile.geometricError <= parent.geometricError))
      found.faults.push(`${traversed}: ${tile.geometricError} m under ${parent.geometricError} m`)
    if (tile.implicitTiling) return true // its content is a template; the tiles are below it
    for (const content of traversed.getFinalContents()) {
      ++found.tiles
      if (!existsSync(join(folder, content.uri))) found.faults.push(`${content.uri}: is not there`)
    }
    return true
  })
}

const tileset = join(folder, 'tileset.json')
if (existsSync(tileset)) await readTileset(tileset)
found.faults.splice(5)
console.log(JSON.stringify(found))
