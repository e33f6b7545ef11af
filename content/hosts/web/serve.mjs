// A server of static files that knows ranges, on the loopback.   node serve.mjs FOLDER [PORT]
import { createReadStream } from "node:fs";
import { stat } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, normalize, resolve, sep } from "node:path";
import { fileURLToPath } from "node:url";

const types = { ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".mjs": "text/javascript", ".css": "text/css",
  ".json": "application/json", ".wasm": "application/wasm" };

async function answer(folder, request, response) {
  const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname));
  const file = join(folder, path.endsWith(sep) ? join(path, "index.html") : path);
  const found = await stat(file).catch(() => null);
  if (!found?.isFile() || !file.startsWith(folder)) return response.writeHead(404).end();
  const headers = { "content-type": types[extname(file)] ?? "application/octet-stream", "accept-ranges": "bytes",
    etag: `"${found.size}-${found.mtimeMs}"`, "cache-control": "no-cache" };
  const range = /^bytes=(\d+)-(\d*)$/.exec(request.headers.range ?? "");
  if (!range) {
    if (request.headers["if-none-match"] === headers.etag) return response.writeHead(304, headers).end();
    response.writeHead(200, { ...headers, "content-length": found.size });
    return createReadStream(file).pipe(response);
  }
  const start = Number(range[1]), end = Math.min(range[2] ? Number(range[2]) : Infinity, found.size - 1);
  if (start > end) return response.writeHead(416, { "content-range": `bytes */${found.size}` }).end();
  response.writeHead(206, { ...headers, "content-length": end - start + 1, "content-range": `bytes ${start}-${end}/${found.size}` });
  return createReadStream(file, { start, end }).pipe(response);
}

/** before(request, response): true if it has answered; for tests. */
export function serve(folder, port = 0, before = () => false) {
  const server = createServer(async (request, response) => {
    try {
      if (!(await before(request, response))) await answer(resolve(folder), request, response);
    } catch {
      response.destroy();
    }
  });
  return new Promise((done, failed) => {
    server.on("error", failed);
    server.listen(port, "127.0.0.1", () => done(server));
  });
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [folder, port = "8080"] = process.argv.slice(2);
  if (!folder) {
    console.error("usage: node serve.mjs FOLDER [PORT]");
    process.exit(2);
  }
  serve(folder, Number(port)).then(
    (server) => console.log(`http://127.0.0.1:${server.address().port}/`),
    (error) => {
      console.error(`serve: ${error.message}; give another port`);
      process.exitCode = 3;
    });
}
