// The components of a rig in a single FMU, on an integer time grid: values of all signals in an array, and snapshots.

import { Instance } from "../fmi/instance.js";

/** @typedef {import("../protocol.js").Rig} Rig */
/** @typedef {import("../protocol.js").Variable} Variable */

/**
 * State of the rig at a point: its signals, and the address of the FMU's saved state.
 * @typedef {{ point: number, values: Float64Array, state: number }} Snapshot
 */

const KINDS = ["Real", "Integer", "Boolean"];

export class Assembly {
  /**
   * Instantiate the FMU of a rig and initialise it at its first point.
   * @param {Rig} rig
   * @param {import("../fmi/library.js").Library} library
   * @param {Readonly<Record<string, number>>} settings values of parameters, inputs and signals in place of the rig's
   * @throws {import("../fmi/instance.js").FmuError} if the FMU rejects a value or fails to start
   */
  constructor(rig, library, settings = {}) {
    const variables = variablesOf(rig), all = [...variables.keys()];
    const values = { ...rig.inputs, ...parametersOf(rig), ...settings };
    const unknown = Object.keys(settings).find((name) => (variables.get(name)?.causality ?? "output") === "output");
    if (unknown !== undefined) { throw new Error(`there is no parameter and no free input ${unknown}`); }
    const free = all.filter((name) => isFree(variableOf(variables, name)));
    const outputs = KINDS.flatMap((kind) => all.filter((name) => isOutput(variableOf(variables, name), kind)));
    this.rig = rig;
    this.point = rig.first; // present communication point
    this.names = [...free, ...outputs]; // of all signals: free inputs and tunable parameters, then outputs
    this.position = new Map(this.names.map((name, i) => [name, i]));
    this.free = free.map((name) => variableOf(variables, name)); // variables at the first positions
    this.values = new Float64Array(this.names.length);
    this.instance = new Instance(library, rig.scenario, rig.guid, rig.data);
    this.outputs = this.instance.exchange(outputs.map((name) => variableOf(variables, name)));
    try {
      Object.entries(values).forEach(([name, value]) => this.instance.put(variableOf(variables, name), value));
      free.forEach((name, i) => { this.values[i] = values[name] ?? variableOf(variables, name).start ?? 0; });
      this.instance.initialise(rig.first * rig.stepSize);
      this.instance.log.length = 0; // without the messages of initialisation
      this.instance.fetch(this.outputs, this.values, free.length);
    } catch (error) {
      this.close();
      throw error;
    }
  }

  /** Free the FMU. */
  close() {
    this.instance.releaseExchange(this.outputs);
    this.instance.release();
  }

  /**
   * Set a free input or tunable parameter from the present point on.
   * @param {number} position
   * @param {number} value
   */
  set(position, value) {
    this.values[position] = value;
    this.instance.put(this.free[position], value);
  }

  /**
   * Step from the present point to the next.
   * @throws {import("../fmi/instance.js").FmuError} if the step fails; `goBack` then restores an earlier state
   */
  advance() {
    this.instance.step(this.point * this.rig.stepSize, this.rig.stepSize);
    this.instance.fetch(this.outputs, this.values, this.free.length);
    this.point += 1;
  }

  /** Save the state of the rig. */
  snapshot() {
    return { point: this.point, values: this.values.slice(), state: this.instance.save() };
  }

  /** Restore a snapshot. @param {Snapshot} snapshot */
  goBack({ point, values, state }) {
    this.instance.restore(state);
    this.values.set(values);
    this.point = point;
  }

  /** Free a snapshot. @param {Snapshot} snapshot */
  discard({ state }) {
    this.instance.forget(state);
  }
}

/**
 * Return the variables of the FMU by name: those of the components, with the value references of that FMU.
 * @param {Rig} rig
 */
function variablesOf({ components, signals, variables }) {
  const byName = new Map(components.flatMap(({ name, variables: declared }) =>
    declared.map((variable) => /** @type {[string, Variable]} */ ([`${name}.${variable.name}`, variable]))));
  signals.forEach(({ name, targets }) => byName.set(name, variableOf(byName, targets[0])));
  return new Map(variables.map((name, reference) => [name, { ...variableOf(byName, name), reference }]));
}

/** @param {ReadonlyMap<string, Variable>} variables @param {string} name */
function variableOf(variables, name) {
  const variable = variables.get(name);
  if (variable === undefined) { throw new Error(`there is no variable ${name}`); }
  return variable;
}

/** @param {Rig} rig */
function parametersOf({ components }) {
  return Object.fromEntries(components.flatMap(({ name, parameters }) =>
    Object.entries(parameters).map(([variable, value]) => [`${name}.${variable}`, value])));
}

/** @param {Variable} variable */
function isFree({ causality, variability }) {
  return causality === "input" || (causality === "parameter" && variability === "tunable");
}

/** @param {Variable} variable @param {string} kind */
function isOutput({ causality, type }, kind) {
  return causality === "output" && type === kind;
}
