// A page in headless Chromium over a pyramid of tiles: how far heights that the viewer tells are from the height
// field, what requests failed, and whether the sky is seen where ground must be.
//
//   show.mjs cesium|three|maplibre TILES POINTS ERROR_M PICTURE CHROMIUM
//
// TILES: a folder. POINTS: lines of "longitude latitude height", the samples of the height field. ERROR_M: what tiles
// of the finest level claim. PICTURE: the last frame, as PNG. Prints one line of JSON. The page is PROGRAM.html beside
// this file; the packages lie in node_modules beside it.
import { createServer } from 'node:http'
import { existsSync, readFileSync, writeFileSync } from 'node:fs'
import { dirname, extname, join, normalize } from 'node:path'
import { fileURLToPath } from 'node:url'
import { chromium } from 'playwright-core'

const [program, tiles, pointsFile, error_m, picture, executablePath] = process.argv.slice(2)
const here = dirname(fileURLToPath(import.meta.url))
const types = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.json': 'application/json',
  '.css': 'text/css', '.png': 'image/png', '.webp': 'image/webp', '.wasm': 'application/wasm', '.glb': 'model/gltf-binary',
  '.terrain': 'application/vnd.quantized-mesh' }

// Every 2,000th or so: 1,000 places all over the ground.
const lines = readFileSync(pointsFile, 'utf8').trim().split('\n')
const wanted = 1000
const points = Array.from({ length: wanted }, (_, i) =>
  lines[Math.floor(i * lines.length / wanted)].split(' ').map(Number))

const failures = []
let requests = 0
const server = createServer((request, response) => {
  const path = normalize(decodeURIComponent(new URL(request.url, 'http://localhost').pathname))
  const file = path.startsWith('/tiles/') ? join(tiles, path.slice(7)) : join(here, path)
  if (path === '/favicon.ico') return response.writeHead(204).end()
  if (path === '/points') return response.end(JSON.stringify(points))
  if (!existsSync(file)) {
    failures.push(`404 ${path}`)
    return response.writeHead(404).end()
  }
  if (path.startsWith('/tiles/')) ++requests
  const body = readFileSync(file)
  const headers = { 'Content-Type': types[extname(file)] ?? 'application/octet-stream' }
  if (body[0] === 0x1f && body[1] === 0x8b) headers['Content-Encoding'] = 'gzip'
  response.writeHead(200, headers).end(body)
})
await new Promise(done => server.listen(0, '127.0.0.1', done))
const at = `http://127.0.0.1:${server.address().port}`

const browser = await chromium.launch({ executablePath,
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'] })
try {
  const page = await browser.newPage({ viewport: { width: 640, height: 480 } })
  page.on('pageerror', error => failures.push(`page: ${error}`))
  page.on('requestfailed', request => failures.push(`${request.failure()?.errorText} ${request.url()}`))
  page.on('console', message => { if (message.type() === 'error') failures.push(`console: ${message.text()}`) })
  page.setDefaultTimeout(60_000)
  await page.goto(`${at}/${program}.html`)
  await page.waitForFunction(() => window.ready || window.failed)
  const failed = await page.evaluate(() => window.failed)
  if (failed) throw new Error(failed)
  const heights = await page.evaluate(() => window.heights())
  let worst_m = 0, known = 0
  points.forEach(([, , height], i) => {
    if (heights[i] === null || heights[i] === undefined) return
    ++known
    worst_m = Math.max(worst_m, Math.abs(heights[i] - height))
  })
  const flight = await page.evaluate(() => window.fly())
  await page.screenshot({ path: picture })
  console.log(JSON.stringify({ places: known, worst_m, claimed_m: Number(error_m), requests, failures, ...flight }))
} catch (error) {
  throw new Error([error, ...failures].join('\n'))
} finally {
  await browser.close()
  server.close()
}
