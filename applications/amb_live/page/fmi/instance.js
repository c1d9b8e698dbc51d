// An instance of an FMU in FMI 2.0: values by lists of references, steps, saved states. FMI functions are called here alone.

import { newText, textAt } from "./library.js";

const STATUS = ["OK", "Warning", "Discard", "Error", "Fatal", "Pending"];
const WARNING = 1; // the highest status with which a call has done its work
const KINDS = /** @type {const} */ (["Real", "Integer", "Boolean"]);
const CO_SIMULATION = 1;
const MOST_MESSAGES = 100;

/** A call that an FMU refused, in its words. */
export class FmuError extends Error {
  /** @param {string} call @param {number} status @param {string} said */
  constructor(call, status, said) {
    super(said || `${call}: fmi2${STATUS[status]}`);
    this.name = "FmuError";
  }
}

/**
 * Variables that are set or read together, by a call for each type; their values in the memory of the module.
 * @typedef {object} Exchange
 * @property {{ set: import("./library.js").Call, get: import("./library.js").Call, references: number, at: number, count: number,
 * real: boolean, first: number }[]} groups addresses of references and values; `first` variable of the list
 * @property {number} size
 */

/**
 * @typedef {object} Instance
 * @property {import("./library.js").Library} library
 * @property {number} component address
 * @property {number} address of its name
 * @property {Float64Array} reals the memory, as numbers; see `refresh`
 * @property {Int32Array} integers
 * @property {{ status: number, text: string }[]} log
 */

let serial = 0;

/**
 * Make an instance of an FMU.
 * @param {import("./library.js").Library} library
 * @param {string} name
 * @param {string} guid
 * @param {string} data its resources/model.bin, in base64
 */
export function instantiate(library, name, guid, data) {
  const unique = `${name}-${serial++}`, { call } = library;
  /** @type {Instance["log"]} */
  const log = [];
  library.listeners.set(unique, (status, text) => {
    if (log.length < MOST_MESSAGES) { log.push({ status, text: text.trim() }); }
  });
  const [address, identity, location] = [unique, guid, `data:;base64,${data}`].map((text) => newText(library, text));
  const component = call.fmi2Instantiate(address, CO_SIMULATION, identity, location, library.callbacks, 0, 1);
  [identity, location].forEach((text) => call.free(text));
  if (component === 0) {
    library.listeners.delete(unique);
    call.free(address);
    throw new FmuError("fmi2Instantiate", 3, log.map(({ text }) => text).join("; "));
  }
  const views = { reals: new Float64Array(), integers: new Int32Array() };
  return refresh({ library, component, address, log, ...views });
}

/**
 * Free an instance.
 * @param {Instance} instance
 */
export function release({ library, component, address }) {
  library.listeners.delete(textAt(library.memory, address));
  library.call.fmi2FreeInstance(component);
  library.call.free(address);
}

/**
 * Look at the memory anew if it has moved, as it does when it grows; its old views are then empty.
 * @param {Instance} instance
 */
function refresh(instance) {
  if (instance.reals.length === 0) {
    const { buffer } = instance.library.memory;
    instance.reals = new Float64Array(buffer);
    instance.integers = new Int32Array(buffer);
  }
  return instance;
}

/**
 * Return an exchange of variables, in this order; its memory lives as long as the module.
 * @param {Instance} instance
 * @param {readonly import("../protocol.js").Variable[]} variables those of the same type stand together
 */
export function exchange(instance, variables) {
  const { call } = instance.library;
  const groups = KINDS.flatMap((kind) => {
    const members = variables.filter(({ type }) => type === kind);
    if (members.length === 0) { return []; }
    const first = variables.indexOf(members[0]), count = members.length;
    if (members.some((item, k) => item !== variables[first + k])) { throw new Error("variables of one type must stand together"); }
    const [references, at] = [call.malloc(4 * count), call.malloc(8 * count)];
    refresh(instance).integers.set(members.map(({ reference }) => reference), references >> 2);
    return [{ set: call[`fmi2Set${kind}`], get: call[`fmi2Get${kind}`], references, at, count, real: kind === "Real", first }];
  });
  return { groups, size: variables.length };
}

/**
 * Free the memory of an exchange.
 * @param {Instance} instance
 * @param {Exchange} variables
 */
export function releaseExchange({ library }, { groups }) {
  groups.forEach(({ references, at }) => [references, at].forEach((address) => library.call.free(address)));
}

/**
 * Set variables to the elements of `values` that `sources` names, of each variable in turn.
 * @param {Instance} instance
 * @param {Exchange} variables
 * @param {Float64Array} values
 * @param {Int32Array} sources
 */
export function send(instance, variables, values, sources) {
  for (const { set, references, at, count, real, first } of variables.groups) {
    const { reals, integers } = refresh(instance), target = real ? reals : integers, from = real ? at >> 3 : at >> 2;
    for (let k = 0; k < count; k++) { target[from + k] = values[sources[first + k]]; }
    check(instance, "fmi2Set", set(instance.component, references, count, at));
  }
}

/**
 * Read variables into `values` from an index on.
 * @param {Instance} instance
 * @param {Exchange} variables
 * @param {Float64Array} values
 * @param {number} index
 */
export function fetch(instance, variables, values, index) {
  for (const { get, references, at, count, real, first } of variables.groups) {
    check(instance, "fmi2Get", get(instance.component, references, count, at));
    const { reals, integers } = refresh(instance), source = real ? reals : integers, from = real ? at >> 3 : at >> 2;
    for (let k = 0; k < count; k++) { values[index + first + k] = source[from + k]; }
  }
}

/**
 * Begin initialisation at a time (s).
 * @param {Instance} instance
 * @param {number} start
 */
export function enterInitialisation(instance, start) {
  const { call } = instance.library;
  check(instance, "fmi2SetupExperiment", call.fmi2SetupExperiment(instance.component, 0, 0, start, 0, 0));
  check(instance, "fmi2EnterInitializationMode", call.fmi2EnterInitializationMode(instance.component));
}

/**
 * End initialisation.
 * @param {Instance} instance
 */
export function exitInitialisation(instance) {
  const { call } = instance.library;
  check(instance, "fmi2ExitInitializationMode", call.fmi2ExitInitializationMode(instance.component));
}

/**
 * Advance from a time (s) by a step (s).
 * @param {Instance} instance
 * @param {number} time
 * @param {number} stepSize
 */
export function step(instance, time, stepSize) {
  check(instance, "fmi2DoStep", instance.library.call.fmi2DoStep(instance.component, time, stepSize, 0));
}

/**
 * Save the state of an instance and return its address, for `restore` and `forget`.
 * @param {Instance} instance
 */
export function save(instance) {
  const { call } = instance.library, place = call.malloc(4);
  refresh(instance).integers[place >> 2] = 0;
  const status = call.fmi2GetFMUstate(instance.component, place);
  const state = refresh(instance).integers[place >> 2];
  call.free(place);
  check(instance, "fmi2GetFMUstate", status);
  return state;
}

/**
 * Bring back a saved state.
 * @param {Instance} instance
 * @param {number} state
 */
export function restore(instance, state) {
  check(instance, "fmi2SetFMUstate", instance.library.call.fmi2SetFMUstate(instance.component, state));
}

/**
 * Free a saved state.
 * @param {Instance} instance
 * @param {number} state
 */
export function forget(instance, state) {
  const { call } = instance.library, place = call.malloc(4);
  refresh(instance).integers[place >> 2] = state;
  const status = call.fmi2FreeFMUstate(instance.component, place);
  call.free(place);
  check(instance, "fmi2FreeFMUstate", status);
}

/**
 * Throw what an FMU said if it refused a call.
 * @param {Instance} instance
 * @param {string} call
 * @param {number} status
 */
function check(instance, call, status) {
  if (status <= WARNING) { return; }
  const errors = instance.log.filter((message) => message.status !== WARNING);
  const said = (errors.length > 0 ? errors : instance.log).map(({ text }) => text);
  instance.log.length = 0;
  throw new FmuError(call, status, said.join("; "));
}
