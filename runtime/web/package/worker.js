// The worker of WorkerSource: reads ranges, decodes the chunks in them, and hands them over without a copy.
import { Instance } from "./instance.js";
import { CachedSource, HttpSource, SetSource } from "./loader.js";
import { isSetUrl } from "./set.js";

let source, decoder;
const reading = new Map();

/** chunks: as ground_next_request() of the module says. Null: they are not what their hashes say. */
function decoded(data, chunks) {
  const { calls } = decoder, all = chunks.reduce((sum, value, i) => (i % 4 === 1 ? sum + value : sum), 0);
  const from = decoder.copy(data), to = calls.web_allocate(Math.max(all, 1)) >>> 0;
  let [read, written, good] = [0, 0, true];
  for (let i = 0; i < chunks.length && good; i += 4) {
    const [stored, raw, high, low] = chunks.slice(i, i + 4);
    good = read + stored <= data.length && calls.chunk_decode(from + read, stored, to + written, raw, high, low) !== 0;
    read += stored;
    written += raw;
  }
  const result = good ? new Uint8Array(decoder.memory.buffer, to, all).slice() : null;
  calls.web_free(from);
  calls.web_free(to);
  return result;
}

async function readDecoded([offset, bytes], chunks, signal) {
  for (let tries = 2;; --tries) { // wrong bytes are asked for once more, and not of the cache
    const data = decoded(await source.read(offset, bytes, signal), chunks);
    if (data) return data;
    await source.forget?.(offset, bytes);
    if (tries === 1) throw new Error("pack: the pack is damaged here; copy or bake it again");
  }
}

onmessage = async ({ data: { open, module, id, size, read, chunks, forget, cancel, ping } }) => {
  if (ping) return postMessage({});
  if (module) return (decoder = new Instance(module));
  if (open) {
    const { cache, ...options } = open.options;
    const one = (url, given) => (cache ? new CachedSource(new HttpSource(url, given), cache) : new HttpSource(url, given));
    const told = { ...options, onProgress: (progress) => postMessage({ progress }), onProblem: (error) => postMessage({ problem: error.message }) };
    source = isSetUrl(open.url) ? new SetSource(open.url, { ...told, open: one }) : one(open.url, told);
    return;
  }
  if (cancel !== undefined) return reading.get(cancel)?.abort();
  const abort = new AbortController();
  reading.set(id, abort);
  try {
    if (forget) {
      await source.forget?.(...forget);
      postMessage({ id });
    } else if (size) {
      postMessage({ id, result: await source.size() });
    } else {
      const result = await (chunks ? readDecoded(read, chunks, abort.signal) : source.read(read[0], read[1], abort.signal));
      postMessage({ id, result }, [result.buffer]);
    }
  } catch (error) {
    postMessage({ id, error: error.message });
  } finally {
    reading.delete(id);
  }
};
