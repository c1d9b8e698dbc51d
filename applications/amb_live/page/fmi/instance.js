// An instance of an FMU in FMI 2.0: values by lists of references, steps, saved states. Only this module calls FMI functions.

import { newText, textAt } from "./library.js";

/** @typedef {import("../protocol.js").Variable} Variable */

const STATUS = ["OK", "Warning", "Discard", "Error", "Fatal", "Pending"];
const WARNING = 1; // highest status of a successful call
const KINDS = /** @type {const} */ (["Real", "Integer", "Boolean"]);
const CO_SIMULATION = 1;
const MAX_MESSAGES = 100;

/** A call that failed, with the FMU's message. */
export class FmuError extends Error {
  /**
   * @param {string} call
   * @param {number} status
   * @param {string} text message of the FMU; may be empty
   */
  constructor(call, status, text) {
    super(text || `${call}: fmi2${STATUS[status]}`);
    this.name = "FmuError";
  }
}

/**
 * Variables that are read together, with one call per type: addresses of their references and values in the memory of the
 * module, and the index of the first of them in the list.
 * @typedef {{ get: import("./library.js").Call, references: number, at: number, count: number, real: boolean, first: number }[]} Exchange
 */

let serial = 0;

export class Instance {
  /**
   * @param {import("./library.js").Library} library
   * @param {string} name
   * @param {string} guid
   * @param {string} data its resources/model.bin, in base64
   */
  constructor(library, name, guid, data) {
    const unique = `${name}-${serial++}`, { call } = library;
    /** @type {{ status: number, text: string }[]} */
    this.log = [];
    this.library = library;
    library.listeners.set(unique, (status, text) => {
      if (this.log.length < MAX_MESSAGES) { this.log.push({ status, text: text.trim() }); }
    });
    const [address, identity, location] = [unique, guid, `data:;base64,${data}`].map((text) => newText(library, text));
    this.address = address; // of its name
    this.component = call.fmi2Instantiate(address, CO_SIMULATION, identity, location, library.callbacks, 0, 1);
    [identity, location].forEach((text) => call.free(text));
    if (this.component === 0) {
      library.listeners.delete(unique);
      call.free(address);
      throw new FmuError("fmi2Instantiate", 3, this.log.map(({ text }) => text).join("; "));
    }
    this.views = { reals: new Float64Array(), integers: new Int32Array() };
  }

  release() {
    const { library: { call, listeners, memory }, component, address } = this;
    listeners.delete(textAt(memory, address));
    call.fmi2FreeInstance(component);
    call.free(address);
  }

  /** The memory as numbers; views become empty when it grows, because it then moves. */
  get memory() {
    if (this.views.reals.length === 0) {
      const { buffer } = this.library.memory;
      this.views = { reals: new Float64Array(buffer), integers: new Int32Array(buffer) };
    }
    return this.views;
  }

  /** Return an exchange of variables, in this order; those of the same type must be adjacent. @param {readonly Variable[]} variables */
  exchange(variables) {
    const { call } = this.library;
    return KINDS.flatMap((kind) => {
      const members = variables.filter(({ type }) => type === kind), count = members.length;
      if (count === 0) { return []; }
      const first = variables.indexOf(members[0]);
      if (members.some((item, k) => item !== variables[first + k])) { throw new Error("variables of the same type must be adjacent"); }
      const [references, at] = [call.malloc(4 * count), call.malloc(8 * count)];
      this.memory.integers.set(members.map(({ reference }) => reference), references >> 2);
      return [{ get: call[`fmi2Get${kind}`], references, at, count, real: kind === "Real", first }];
    });
  }

  /** Free the memory of an exchange. @param {Exchange} groups */
  releaseExchange(groups) {
    groups.forEach(({ references, at }) => [references, at].forEach((address) => this.library.call.free(address)));
  }

  /**
   * Set a variable.
   * @param {Variable} variable
   * @param {number} value
   */
  put({ type, reference }, value) {
    const { call } = this.library, [referenceAt, valueAt] = [call.malloc(4), call.malloc(8)];
    const { reals, integers } = this.memory;
    integers[referenceAt >> 2] = reference;
    if (type === "Real") { reals[valueAt >> 3] = value; } else { integers[valueAt >> 2] = value; }
    try {
      this.check("fmi2Set", call[`fmi2Set${type}`](this.component, referenceAt, 1, valueAt));
    } finally {
      [referenceAt, valueAt].forEach((address) => call.free(address));
    }
  }

  /**
   * Read variables into `values` from an index on.
   * @param {Exchange} groups
   * @param {Float64Array} values
   * @param {number} index
   */
  fetch(groups, values, index) {
    for (const { get, references, at, count, real, first } of groups) {
      this.check("fmi2Get", get(this.component, references, count, at));
      const { reals, integers } = this.memory, source = real ? reals : integers, from = real ? at >> 3 : at >> 2;
      for (let k = 0; k < count; k++) { values[index + first + k] = source[from + k]; }
    }
  }

  /** Initialise at a time. @param {number} start s */
  initialise(start) {
    const { component, library: { call } } = this;
    this.check("fmi2SetupExperiment", call.fmi2SetupExperiment(component, 0, 0, start, 0, 0));
    this.check("fmi2EnterInitializationMode", call.fmi2EnterInitializationMode(component));
    this.check("fmi2ExitInitializationMode", call.fmi2ExitInitializationMode(component));
  }

  /**
   * Advance from a time (s) by a step (s).
   * @param {number} time
   * @param {number} stepSize
   */
  step(time, stepSize) {
    this.check("fmi2DoStep", this.library.call.fmi2DoStep(this.component, time, stepSize, 0));
  }

  /** Save the state, and return its address for `restore` and `forget`. */
  save() {
    return this.callWithState(0, "fmi2GetFMUstate");
  }

  /** @param {number} state */
  restore(state) {
    this.check("fmi2SetFMUstate", this.library.call.fmi2SetFMUstate(this.component, state));
  }

  /** @param {number} state */
  forget(state) {
    this.callWithState(state, "fmi2FreeFMUstate");
  }

  /**
   * Call a function with the address of a state, and return the state at that address afterwards.
   * @param {number} state
   * @param {"fmi2GetFMUstate" | "fmi2FreeFMUstate"} name
   */
  callWithState(state, name) {
    const { call } = this.library, place = call.malloc(4);
    this.memory.integers[place >> 2] = state;
    const status = call[name](this.component, place), after = this.memory.integers[place >> 2];
    call.free(place);
    this.check(name, status);
    return after;
  }

  /**
   * Throw the FMU's message if a call failed.
   * @param {string} call
   * @param {number} status
   */
  check(call, status) {
    if (status <= WARNING) { return; }
    const errors = this.log.filter((message) => message.status !== WARNING);
    const texts = (errors.length > 0 ? errors : this.log).map(({ text }) => text);
    this.log.length = 0;
    throw new FmuError(call, status, texts.join("; "));
  }
}
