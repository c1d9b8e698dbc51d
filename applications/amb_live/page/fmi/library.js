// A compiled FMU, as `amb-cosim build --platform wasm32` writes it: its functions, its memory, and the logger it calls.
//
// It imports only the file functions of WASI, and opens no file: its data arrive as a data URI. A host's logger must be a
// function of WebAssembly; a module of a few bytes makes one from a function of JavaScript.

/** @typedef {(...args: number[]) => number} Call */

/** fmi2CallbackLogger in the C of wasm32: environment, instance, status, category, message, variable arguments.
 * @typedef {(environment: number, instance: number, status: number, category: number, message: number, rest: number) => void} Logger */

/**
 * @typedef {object} Library
 * @property {Record<string, Call>} call exported functions: those of FMI 2.0, malloc, free
 * @property {WebAssembly.Memory} memory
 * @property {number} callbacks address of the structure fmi2CallbackFunctions
 * @property {Map<string, (status: number, text: string) => void>} listeners of instances, by their names
 */

const BAD_FILE = 8; // WASI's errno for a file that does not exist
const HALF_SIGNATURE = [0x60, 6, 0x7f, 0x7f, 0x7f, 0x7f, 0x7f, 0x7f, 0]; // six i32, and no result
const ADAPTER = new Uint8Array([
  ...[0, 0x61, 0x73, 0x6d, 1, 0, 0, 0], // WebAssembly 1
  ...[1, HALF_SIGNATURE.length + 1, 1, ...HALF_SIGNATURE], // types
  ...[2, 7, 1, 1, 0x65, 1, 0x66, 0, 0], // imports: function e.f
  ...[7, 5, 1, 1, 0x66, 0, 0], // exports: the same as f
]);

/**
 * Start a compiled FMU.
 * @param {WebAssembly.Module} module
 */
export function startLibrary(module) {
  /** @type {Record<string, Record<string, () => number>>} */
  const imports = {};
  for (const { module: from, name } of WebAssembly.Module.imports(module)) {
    imports[from] ??= {};
    imports[from][name] = () => BAD_FILE;
  }
  const { exports } = new WebAssembly.Instance(module, imports);
  const call = /** @type {Record<string, Call>} */ (/** @type {unknown} */ (exports));
  const memory = /** @type {WebAssembly.Memory} */ (exports.memory);
  call._initialize?.();
  /** @type {Library} */
  const library = { call, memory, callbacks: call.malloc(20), listeners: new Map() };
  const table = /** @type {WebAssembly.Table} */ (exports.__indirect_function_table);
  const logger = addFunction(table, (_, instance, status, _category, message) => {
    library.listeners.get(textAt(memory, instance))?.(status, textAt(memory, message).replaceAll("%%", "%"));
  });
  // logger, allocateMemory, freeMemory, stepFinished, componentEnvironment
  new Uint32Array(memory.buffer, library.callbacks, 5).set([logger, 0, 0, 0, 0]);
  return library;
}

/**
 * Add a function to the table of a module, and return its number in the table.
 * @param {WebAssembly.Table} table
 * @param {Logger} logger
 */
function addFunction(table, logger) {
  const adapter = new WebAssembly.Instance(new WebAssembly.Module(ADAPTER), { e: { f: logger } });
  const at = table.grow(1);
  table.set(at, adapter.exports.f);
  return at;
}

/**
 * Return the zero-terminated text at an address; empty at address 0.
 * @param {WebAssembly.Memory} memory
 * @param {number} address
 */
export function textAt(memory, address) {
  if (address === 0) { return ""; }
  const bytes = new Uint8Array(memory.buffer, address);
  return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
}

/**
 * Copy a text to new memory of a library, with a final zero, and return its address, to be freed.
 * @param {Library} library
 * @param {string} text
 */
export function newText(library, text) {
  const bytes = new TextEncoder().encode(text), address = library.call.malloc(bytes.length + 1);
  if (address === 0) { throw new Error("there is no memory for a text of an FMU"); }
  const target = new Uint8Array(library.memory.buffer, address, bytes.length + 1);
  target.set(bytes);
  target[bytes.length] = 0;
  return address;
}
