import type { HttpOptions, Source } from "./index.js";

/** A pack's bytes in memory. */
export class MemorySource implements Source {
  constructor(bytes: Uint8Array);
  size(): Promise<number>;
  read(offset: number, bytes: number): Promise<Uint8Array>;
}

/** A file on a server, read by HTTP ranges. What fails is tried again, later and later. */
export class HttpSource implements Source {
  constructor(url: string | URL, options?: HttpOptions);
  readonly url: string;
  /** The file's ETag or date, once it is known. */
  readonly tag: string | null | undefined;
  size(): Promise<number>;
  read(offset: number, bytes: number, signal?: AbortSignal): Promise<Uint8Array>;
}

/** A pack set: set.json, and its packs beside it. Terrain.open takes its URL too. */
export class SetSource implements Source {
  /** open: makes the source of one of the packs, an HttpSource by default. */
  constructor(url: string | URL, options?: HttpOptions & { open?: (url: string, options: HttpOptions) => Source });
  size(): Promise<number>;
  read(offset: number, bytes: number, signal?: AbortSignal): Promise<Uint8Array>;
  close(): void;
}

/** Keeps what was read in the browser's Cache API. */
export class CachedSource implements Source {
  constructor(source: HttpSource, name?: string);
  size(): Promise<number>;
  read(offset: number, bytes: number, signal?: AbortSignal): Promise<Uint8Array>;
}

/** An HttpSource in a worker of its own. cache: also a CachedSource of that name. */
export class WorkerSource implements Source {
  constructor(url: string | URL, options?: Omit<HttpOptions, "fetch"> & { cache?: string; pingMs?: number });
  size(): Promise<number>;
  read(offset: number, bytes: number, signal?: AbortSignal): Promise<Uint8Array>;
  close(): void;
}
