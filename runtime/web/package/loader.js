// Sources for Terrain.open: HTTP ranges here, or in a worker, with a cache.
import { compile } from "./instance.js";
import { isSetUrl, SetSource } from "./set.js";
import { HttpSource, MemorySource } from "./source.js";

export { HttpSource, MemorySource, SetSource };

/**
 * Keeps ranges of a file in the browser's Cache API under `name`. source: an HttpSource, whose tag is a part of the keys:
 * a file that is replaced is read anew.
 */
export class CachedSource {
  #source; #name; #cache;
  constructor(source, name = "fjell") {
    this.#source = source;
    this.#name = name;
  }
  async size() {
    this.#cache ??= globalThis.caches ? await caches.open(this.#name).catch(() => null) : null;
    return this.#source.size();
  }
  async read(offset, bytes, signal) {
    if (this.#source.tag === undefined) await this.size();
    const tag = this.#source.tag;
    if (!this.#cache || !tag) return this.#source.read(offset, bytes, signal);
    const key = this.#key(offset, bytes), kept = await this.#cache.match(key).catch(() => undefined);
    if (kept) {
      const data = new Uint8Array(await kept.arrayBuffer());
      if (data.length === bytes) return data;
    }
    const data = await this.#source.read(offset, bytes, signal);
    this.#cache.put(key, new Response(data)).catch(() => {}); // a full disk is no reason to stop
    return data;
  }
  #key(offset, bytes) {
    const key = new URL(this.#source.url, globalThis.location?.href);
    key.searchParams.set("fjell", `${this.#source.tag} ${offset} ${bytes}`);
    return key;
  }
  /** Of what turned out to be damaged: the next read asks the server. */
  async forget(offset, bytes) { await this.#cache?.delete(this.#key(offset, bytes)).catch(() => {}); }
}

/**
 * Reads and decodes in a worker of its own, so that a busy page does not hold up the network, nor the other way round.
 * A worker that does not answer is replaced by a new one, which reads what the old one was to read. url: of a pack or of
 * a set.json. options: those of HttpSource but `fetch`; cache: the name of a CachedSource; pingMs: how often the worker
 * is asked whether it lives.
 */
export class WorkerSource {
  #url; #options; #worker; #timer; #silent = 0; #deaths = 0; #next = 1; #calls = new Map(); #size; #module;

  constructor(url, { pingMs = 5000, ...options } = {}) {
    this.#url = String(new URL(url, globalThis.location?.href));
    this.#options = options;
    this.pingMs = pingMs;
  }

  #start() {
    const { onProgress, onProblem, ...plain } = this.#options;
    const worker = (this.#worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" }));
    worker.onmessage = ({ data: { id, progress, problem, error, result } }) => {
      this.#silent = 0;
      if (progress !== undefined) onProgress?.(progress);
      if (problem !== undefined) onProblem?.(new Error(problem));
      const call = this.#calls.get(id);
      if (!call) return;
      this.#calls.delete(id);
      this.#deaths = 0;
      if (error !== undefined) call.reject(new Error(error));
      else call.resolve(result);
    };
    worker.onerror = () => this.#died();
    worker.postMessage({ open: { url: this.#url, options: plain } });
    if (this.#module) worker.postMessage({ module: this.#module });
    this.#silent = 0;
    this.#timer = setInterval(() => {
      if (this.#calls.size === 0) this.#silent = 0;
      else if (++this.#silent > 3) this.#died();
      else worker.postMessage({ ping: true });
    }, this.pingMs);
    for (const [id, { message }] of this.#calls) worker.postMessage({ id, ...message });
  }

  #stop() {
    clearInterval(this.#timer);
    this.#worker?.terminate();
    this.#worker = undefined;
  }

  #died() {
    this.#stop();
    if (++this.#deaths < 4) return this.#start();
    this.#giveUp("the worker that reads cannot be kept alive; reload the page");
  }

  #giveUp(text) {
    const calls = [...this.#calls.values()];
    this.#calls.clear();
    for (const call of calls) call.reject(new Error(`${this.#url}: ${text}`));
  }

  #ask(message, signal) {
    if (!this.#worker) this.#start();
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#calls.set(id, { message, resolve, reject });
      signal?.addEventListener("abort", () => {
        if (this.#calls.delete(id)) this.#worker?.postMessage({ cancel: id });
        reject(signal.reason);
      }, { once: true });
      this.#worker.postMessage({ id, ...message });
    });
  }

  get isSet() { return isSetUrl(this.#url); }
  async size() { return (this.#size ??= await this.#ask({ size: true })); }
  read(offset, bytes, signal) { return this.#ask({ read: [offset, bytes] }, signal); }
  /** Chunks, decoded in the worker. chunks: four numbers each, stored and decoded bytes and the halves of the hash. */
  async readDecoded(offset, bytes, chunks, signal) {
    if (!this.#module) {
      this.#module = await compile();
      this.#worker?.postMessage({ module: this.#module });
    }
    return this.#ask({ read: [offset, bytes], chunks }, signal);
  }
  async forget(offset, bytes) { await this.#ask({ forget: [offset, bytes] }); }
  close() {
    this.#stop();
    this.#giveUp("closed");
  }
}
