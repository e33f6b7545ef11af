// The worker of WorkerSource: reads ranges and hands them over without a copy.
import { CachedSource, HttpSource } from "./loader.js";

let source;
const reading = new Map();

onmessage = async ({ data: { open, id, size, read, cancel, ping } }) => {
  if (ping) return postMessage({});
  if (open) {
    const { cache, ...options } = open.options;
    source = new HttpSource(open.url, { ...options, onProgress: (progress) => postMessage({ progress }), onProblem: (error) => postMessage({ problem: error.message }) });
    if (cache) source = new CachedSource(source, cache);
    return;
  }
  if (cancel !== undefined) return reading.get(cancel)?.abort();
  const abort = new AbortController();
  reading.set(id, abort);
  try {
    if (size) {
      postMessage({ id, result: await source.size() });
    } else {
      const result = await source.read(read[0], read[1], abort.signal);
      postMessage({ id, result }, [result.buffer]);
    }
  } catch (error) {
    postMessage({ id, error: error.message });
  } finally {
    reading.delete(id);
  }
};
