// The WebAssembly module: found, compiled once, and given what it asks for. Works in pages, workers and node.

/** A module whose only function uses SIMD: whoever accepts it has SIMD. */
const simdProbe = Uint8Array.of(
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11);

let compiled;

async function bytesOf(url) {
  if (url.protocol === "file:") {
    const { readFile } = await import(/* @vite-ignore */ /* webpackIgnore: true */ "node:fs/promises");
    return readFile(url);
  }
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
  return response.arrayBuffer();
}

/** Compiles the module that suits this machine. options.wasm: another place of it, or its bytes. */
export function compile(options = {}) {
  compiled ??= (async () => {
    const simd = (options.simd ?? true) && WebAssembly.validate(simdProbe);
    const given = options.wasm ??
      (simd ? new URL("./fjell.wasm", import.meta.url) : new URL("./fjell-scalar.wasm", import.meta.url));
    const bytes = given instanceof URL || typeof given === "string" ? await bytesOf(new URL(given, import.meta.url)) : given;
    return WebAssembly.compile(bytes);
  })();
  compiled.catch(() => { compiled = undefined; }); // the next call tries again
  return compiled;
}

/** A module with memory of its own. After it has thrown it must not be called again. */
export class Instance {
  constructor(module) {
    const given = {
      fail: (at) => { throw new Error(this.text(at)); },
      now_ms: () => performance.now(),
      proc_exit: () => { throw new Error("fjell: stopped"); },
      abort: () => { throw new Error("fjell: stopped"); },
    };
    const imports = {};
    for (const { module: from, name, kind } of WebAssembly.Module.imports(module))
      if (kind === "function") (imports[from] ??= {})[name] = given[name] ?? (() => 52); // WASI's "not supported"
    this.calls = new WebAssembly.Instance(module, imports).exports;
    this.memory = this.calls.memory;
    this.calls._initialize?.();
    this.numbersAt = this.calls.web_numbers();
    this.numbers = new Float64Array(this.memory.buffer, this.numbersAt, 512);
    this.version = this.text(this.calls.web_version());
  }

  /** Of a string that ends with 0. */
  text(at) {
    const bytes = new Uint8Array(this.memory.buffer, at >>> 0);
    return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
  }

  /** The numbers that calls take and return; memory that has grown is elsewhere. */
  refresh() {
    if (this.numbers.length === 0) this.numbers = new Float64Array(this.memory.buffer, this.numbersAt, 512);
    return this.numbers;
  }

  /** Copies bytes into the module's memory; free what it returns. */
  copy(array) {
    const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
    const at = this.calls.web_allocate(Math.max(bytes.length, 1)) >>> 0;
    new Uint8Array(this.memory.buffer, at, bytes.length).set(bytes);
    this.refresh();
    return at;
  }
}
