// The components of a rig in a single FMU, on an integer time grid: values of all signals in an array, and snapshots.

import {
  enterInitialisation, exchange, exitInitialisation, fetch, forget, instantiate, release, releaseExchange, restore, save, send, step,
} from "../fmi/instance.js";

/** @typedef {import("../fmi/instance.js").Exchange} Exchange */
/** @typedef {import("../protocol.js").Rig} Rig */
/** @typedef {import("../protocol.js").Variable} Variable */

/**
 * @typedef {object} Assembly
 * @property {Rig} rig
 * @property {import("../fmi/instance.js").Instance} instance
 * @property {string[]} names of all signals: what may be set while it runs, then outputs
 * @property {Map<string, number>} position by name
 * @property {Variable[]} free variables of the first positions
 * @property {Float64Array} values of all signals
 * @property {Exchange} outputs
 * @property {number} point at which it is
 */

/**
 * State of everything at a point; `state` is an address.
 * @typedef {{ point: number, values: Float64Array, state: number }} Snapshot
 */

const KINDS = ["Real", "Integer", "Boolean"];

/**
 * Instantiate the FMU of a rig and initialise it at its first point.
 * @param {Rig} rig
 * @param {import("../fmi/library.js").Library} library
 * @param {Readonly<Record<string, number>>} settings values of parameters, inputs and signals in place of the rig's
 * @throws {import("../fmi/instance.js").FmuError} if it refuses a value, or to start
 */
export function startAssembly(rig, library, settings = {}) {
  const variables = variablesOf(rig), all = [...variables.keys()];
  const values = { ...rig.inputs, ...parametersOf(rig), ...settings };
  const unknown = Object.keys(settings).find((name) => (variables.get(name)?.causality ?? "output") === "output");
  if (unknown !== undefined) { throw new Error(`there is no parameter and no free input ${unknown}`); }
  const free = all.filter((name) => isFree(variableOf(variables, name)));
  const outputs = KINDS.flatMap((kind) => all.filter((name) => isOutput(variableOf(variables, name), kind)));
  const names = [...free, ...outputs], instance = instantiate(library, rig.scenario, rig.guid, rig.data);
  /** @type {Assembly} */
  const assembly = {
    rig, instance, names, position: new Map(names.map((name, i) => [name, i])), free: free.map((name) => variableOf(variables, name)),
    values: new Float64Array(names.length), outputs: exchange(instance, outputs.map((name) => variableOf(variables, name))),
    point: rig.first,
  };
  try {
    Object.entries(values).forEach(([name, value]) => put(instance, variableOf(variables, name), value));
    free.forEach((name, i) => { assembly.values[i] = values[name] ?? variableOf(variables, name).start ?? 0; });
    enterInitialisation(instance, rig.first * rig.stepSize);
    exitInitialisation(instance);
    instance.log.length = 0; // what initialisation said on the way
    fetch(instance, assembly.outputs, assembly.values, free.length);
  } catch (error) {
    close(assembly);
    throw error;
  }
  return assembly;
}

/**
 * Free the FMU.
 * @param {Assembly} assembly
 */
export function close({ instance, outputs }) {
  releaseExchange(instance, outputs);
  release(instance);
}

/**
 * Set a value from outside: from now on it holds.
 * @param {Assembly} assembly
 * @param {number} position
 * @param {number} value
 */
export function set({ instance, values, free }, position, value) {
  values[position] = value;
  put(instance, free[position], value);
}

/**
 * Step from the present point to the next.
 * @param {Assembly} assembly
 * @throws {import("../fmi/instance.js").FmuError} if it does not complete it; `goBack` leads on
 */
export function advance(assembly) {
  const { rig, instance, values, outputs, free, point } = assembly;
  step(instance, point * rig.stepSize, rig.stepSize);
  fetch(instance, outputs, values, free.length);
  assembly.point = point + 1;
}

/**
 * Save the state of everything.
 * @param {Assembly} assembly
 */
export function snapshot({ point, values, instance }) {
  return { point, values: values.slice(), state: save(instance) };
}

/**
 * Go back to where a snapshot was taken.
 * @param {Assembly} assembly
 * @param {Snapshot} snapshot
 */
export function goBack(assembly, { point, values, state }) {
  restore(assembly.instance, state);
  assembly.values.set(values);
  assembly.point = point;
}

/**
 * Free a snapshot.
 * @param {Assembly} assembly
 * @param {Snapshot} snapshot
 */
export function discard({ instance }, { state }) {
  forget(instance, state);
}

/** @param {import("../fmi/instance.js").Instance} instance @param {Variable} variable @param {number} value */
function put(instance, variable, value) {
  const single = exchange(instance, [variable]);
  try {
    send(instance, single, Float64Array.of(value), Int32Array.of(0));
  } finally {
    releaseExchange(instance, single);
  }
}

/**
 * Return the variables of the FMU by name; they are those of the components, with references of that FMU.
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
