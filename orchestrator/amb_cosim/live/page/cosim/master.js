// The master: Gauss-Seidel coupling on an integer time grid, operation by operation as `cosim/master.py` does it.

import {
  enterInitialisation, exchange, exitInitialisation, fetch, FmuError, forget, instantiate, release, releaseExchange, restore, save,
  send, step,
} from "../fmi/instance.js";
import { layOut } from "./wiring.js";

/** @typedef {import("../fmi/instance.js").Instance} Instance */
/** @typedef {import("../fmi/instance.js").Exchange} Exchange */
/** @typedef {import("../fmi/library.js").Library} Library */
/** @typedef {import("../protocol.js").Rig} Rig */

/**
 * @typedef {object} Master
 * @property {Rig} rig
 * @property {import("./wiring.js").Wiring} wiring
 * @property {Float64Array} values of all signals
 * @property {Member[]} members
 * @property {number} point at which it is
 */

/**
 * A component with its exchanges; `single` are those of variables from outside, by position.
 * @typedef {object} Member
 * @property {Instance} instance
 * @property {number} every
 * @property {Exchange} inputs
 * @property {Exchange} outputs
 * @property {Map<number, Exchange>} single
 */

/**
 * State of everything at a point.
 * @typedef {object} Snapshot
 * @property {number} point
 * @property {Float64Array} values
 * @property {number[]} states addresses, one for each component
 */

/**
 * Instantiate the components of a rig and initialise them at its first point.
 * @param {Rig} rig
 * @param {ReadonlyMap<string, Library>} libraries by model
 * @param {Readonly<Record<string, number>>} settings values of parameters, inputs and signals in place of the rig's
 * @returns {Master}
 * @throws {FmuError} if an FMU refuses a value, or to start
 */
export function startMaster(rig, libraries, settings = {}) {
  const wiring = layOut(rig), given = { ...rig.inputs, ...parametersOf(rig), ...settings };
  const values = new Float64Array(wiring.names.length);
  wiring.outside.forEach(({ variable }, i) => { values[i] = given[wiring.names[i]] ?? variable.start ?? 0; });
  /** @type {Master} */
  const master = { rig, wiring, values, members: [], point: rig.first };
  try {
    rig.components.forEach((component, i) => {
      const library = libraries.get(component.model);
      if (library === undefined) { throw new Error(`there is no module of ${component.model}`); }
      const instance = instantiate(library, component.name, component.guid, component.data), slot = wiring.slots[i];
      const [inputs, outputs] = [slot.inputs, slot.outputs].map((variables) => exchange(instance, variables));
      master.members.push({ instance, every: component.every, inputs, outputs, single: new Map() });
      give(instance, component.variables.filter(({ name, causality }) =>
        causality === "parameter" && `${component.name}.${name}` in given), given, component.name);
    });
    checkNames(master, settings);
    initialise(master, given);
  } catch (error) {
    close(master);
    throw error;
  }
  return master;
}

/**
 * Free the components.
 * @param {Master} master
 */
export function close({ members }) {
  for (const { instance, inputs, outputs, single } of members) {
    [inputs, outputs, ...single.values()].forEach((one) => releaseExchange(instance, one));
    release(instance);
  }
}

/**
 * Set a value from outside: from now on it holds.
 * @param {Master} master
 * @param {number} position
 * @param {number} value
 */
export function set(master, position, value) {
  master.values[position] = value;
  const { component, variable } = master.wiring.outside[position];
  if (component < 0) { return; }
  const { instance, single } = master.members[component];
  const variables = single.get(position) ?? exchange(instance, [variable]);
  single.set(position, variables);
  send(instance, variables, master.values, Int32Array.of(position));
}

/**
 * Step from the present point to the next.
 * @param {Master} master
 * @throws {FmuError} if a component does not complete it; those before it then have, and `goBack` leads on
 */
export function advance(master) {
  const { rig, values, members, wiring, point } = master, time = point * rig.stepSize;
  for (let i = 0; i < members.length; i++) {
    const { instance, every, inputs, outputs } = members[i], { sources, first } = wiring.slots[i];
    if (point % every === 0) {
      send(instance, inputs, values, sources);
      step(instance, time, every * rig.stepSize);
      fetch(instance, outputs, values, first);
    }
  }
  master.point = point + 1;
}

/**
 * Save the state of everything.
 * @param {Master} master
 * @returns {Snapshot}
 */
export function snapshot({ point, values, members }) {
  return { point, values: values.slice(), states: members.map(({ instance }) => save(instance)) };
}

/**
 * Go back to where a snapshot was taken.
 * @param {Master} master
 * @param {Snapshot} snapshot
 */
export function goBack(master, { point, values, states }) {
  master.members.forEach(({ instance }, i) => restore(instance, states[i]));
  master.values.set(values);
  master.point = point;
}

/**
 * Free a snapshot.
 * @param {Master} master
 * @param {Snapshot} snapshot
 */
export function discard({ members }, { states }) {
  members.forEach(({ instance }, i) => forget(instance, states[i]));
}

/**
 * Initialise all components, carrying outputs along the connections until none changes.
 * @param {Master} master
 * @param {Readonly<Record<string, number>>} given
 */
function initialise(master, given) {
  const { rig, wiring, values, members } = master;
  members.forEach(({ instance }) => enterInitialisation(instance, rig.first * rig.stepSize));
  wiring.outside.forEach(({ variable, component }, i) => {
    if (component >= 0 && variable.causality === "input" && wiring.names[i] in given) { set(master, i, values[i]); }
  });
  const most = 2 + wiring.slots.reduce((sum, { sources }) => sum + sources.length, 0);
  for (let sweep = 0, before = new Float64Array(); !same(before, values); sweep++) {
    if (sweep === most) { throw new Error("outputs do not settle during initialisation: there is an algebraic loop"); }
    before = values.slice();
    members.forEach(({ instance, inputs, outputs }, i) => {
      send(instance, inputs, values, wiring.slots[i].sources);
      fetch(instance, outputs, values, wiring.slots[i].first);
    });
  }
  members.forEach(({ instance, outputs }, i) => {
    const { log } = instance;
    exitInitialisation(instance);
    fetch(instance, outputs, values, wiring.slots[i].first);
    const fault = wiring.position.get(`${instance.name}.fault_code`);
    if (fault !== undefined && values[fault] !== 0) {
      throw new FmuError(instance.name, "initialisation", 3, log.at(-1)?.text ?? `fault ${values[fault]}`);
    }
    log.length = 0; // what initialisation said on the way
  });
}

/**
 * @param {Rig} rig
 * @returns {Record<string, number>}
 */
function parametersOf({ components }) {
  return Object.fromEntries(components.flatMap(({ name, parameters }) =>
    Object.entries(parameters).map(([variable, value]) => [`${name}.${variable}`, value])));
}

/**
 * @param {Instance} instance
 * @param {import("../protocol.js").Variable[]} variables
 * @param {Readonly<Record<string, number>>} given
 * @param {string} component
 */
function give(instance, variables, given, component) {
  for (const variable of variables) {
    const one = exchange(instance, [variable]);
    send(instance, one, Float64Array.of(given[`${component}.${variable.name}`]), Int32Array.of(0));
    releaseExchange(instance, one);
  }
}

/**
 * Throw if a setting names nothing that can be set.
 * @param {Master} master
 * @param {Readonly<Record<string, number>>} settings
 */
function checkNames({ rig, wiring }, settings) {
  const parameters = rig.components.flatMap(({ name, variables }) =>
    variables.filter(({ causality }) => causality === "parameter").map((variable) => `${name}.${variable.name}`));
  const known = new Set([...wiring.names.slice(0, wiring.outside.length), ...parameters]);
  for (const name of Object.keys(settings)) {
    if (!known.has(name)) { throw new Error(`there is no parameter and no free input ${name}`); }
  }
}

/**
 * @param {Float64Array} a
 * @param {Float64Array} b
 * @returns {boolean}
 */
function same(a, b) {
  return a.length === b.length && a.every((value, i) => value === b[i] || (Number.isNaN(value) && Number.isNaN(b[i])));
}
