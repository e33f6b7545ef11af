// Where a pack's bytes come from: memory, or a server that gives ranges.

/** Bytes in memory. */
export class MemorySource {
  constructor(bytes) { this.bytes = bytes; }
  async size() { return this.bytes.length; }
  async read(offset, bytes) { return this.readNow(offset, bytes); }
  readNow(offset, bytes) { return this.bytes.subarray(offset, offset + bytes); }
}

const pause = (ms, signal) => new Promise((resolve, reject) => {
  const stopped = () => { clearTimeout(timer); reject(signal.reason); };
  const timer = setTimeout(() => { signal?.removeEventListener("abort", stopped); resolve(); }, ms);
  signal?.addEventListener("abort", stopped, { once: true });
});

class Final extends Error {} // trying again does not help

/**
 * A file on a server, read by HTTP ranges. What fails is tried again, later and later, until it is not wanted any more
 * or `tries` are spent. onProgress(bytes): how many bytes have come, so far. onProblem(error): what is tried again.
 */
export class HttpSource {
  #url; #options; #etag; #size; #bytes = 0;

  constructor(url, options = {}) {
    this.#url = String(url);
    this.#options = { fetch: (...given) => fetch(...given), tries: 8, firstPauseMs: 250, longestPauseMs: 8000, timeoutMs: 60_000, ...options };
  }

  get url() { return this.#url; }
  get tag() { return this.#etag; }

  async size() {
    await this.read(0, 512).catch((error) => { if (this.#size === undefined) throw error; });
    return this.#size;
  }

  async read(offset, bytes, signal) {
    const { tries, firstPauseMs, longestPauseMs, onProblem } = this.#options;
    for (let i = 1; ; ++i) {
      try {
        return await this.#once(offset, bytes, signal);
      } catch (error) {
        if (error instanceof Final || signal?.aborted || i >= tries) throw error;
        onProblem?.(error);
        await pause(Math.min(longestPauseMs, firstPauseMs * 2 ** (i - 1)), signal);
      }
    }
  }

  /** A server that does not answer in time is one that fails. */
  async #once(offset, bytes, signal) {
    const late = new AbortController(), stop = () => late.abort(signal.reason);
    const timer = setTimeout(() => late.abort(new Error(`${this.#url}: the server has not answered for ${this.#options.timeoutMs / 1e3} s`)), this.#options.timeoutMs);
    if (signal?.aborted) stop();
    signal?.addEventListener("abort", stop, { once: true });
    try {
      return await this.#answer(offset, bytes, late.signal);
    } finally {
      clearTimeout(timer);
      signal?.removeEventListener("abort", stop);
    }
  }

  async #answer(offset, bytes, signal) {
    const url = this.#url;
    const response = await this.#options.fetch(url, { headers: { Range: `bytes=${offset}-${offset + bytes - 1}` }, signal });
    if (response.status === 200) {
      await response.body?.cancel();
      throw new Final(`${url}: the server sends whole files, not ranges; use one that knows Range, or give Terrain.open the file's bytes`);
    }
    if (response.status === 416) throw new Final(`${url}: is shorter than a pack, or was replaced; open it again`);
    if (response.status !== 206) {
      const text = `${url}: ${response.status} ${response.statusText}`;
      throw response.status >= 400 && response.status < 500 && response.status !== 408 && response.status !== 429 ? new Final(text) : new Error(text);
    }
    const [, total] = /\/(\d+)$/.exec(response.headers.get("content-range") ?? "") ?? [];
    const etag = response.headers.get("etag") ?? response.headers.get("last-modified");
    if (this.#size === undefined) {
      if (total === undefined) throw new Final(`${url}: the server does not say how long the file is (Content-Range); across origins it must expose that header`);
      this.#size = Number(total);
      this.#etag = etag;
    } else if (etag !== this.#etag || (total !== undefined && Number(total) !== this.#size)) {
      throw new Final(`${url}: was replaced while it was open; open it again`);
    }
    const data = new Uint8Array(await response.arrayBuffer());
    if (data.length !== Math.min(bytes, this.#size - offset)) throw new Error(`${url}: ${data.length} bytes came instead of ${bytes}`);
    this.#bytes += data.length;
    this.#options.onProgress?.(this.#bytes);
    return data;
  }
}

export function sourceOf(given, options) {
  if (given instanceof ArrayBuffer) return new MemorySource(new Uint8Array(given));
  if (ArrayBuffer.isView(given)) return new MemorySource(new Uint8Array(given.buffer, given.byteOffset, given.byteLength));
  if (typeof given === "string" || given instanceof URL) return new HttpSource(given, options);
  if (typeof given?.read === "function" && typeof given?.size === "function") return given;
  throw new TypeError("source: give a URL, the bytes of a pack, or an object with size() and read()");
}
