// Where the signals of a rig are: one flat array, first what comes from outside, then the outputs of each component.

/** @typedef {import("../protocol.js").Rig} Rig */
/** @typedef {import("../protocol.js").Variable} Variable */

/**
 * What a component exchanges at every step.
 * @typedef {object} Slot
 * @property {Variable[]} inputs that signals and outputs feed, by type
 * @property {Int32Array} sources position of what feeds each of them
 * @property {Variable[]} outputs by type
 * @property {number} first position of the outputs
 */

/**
 * A place for a value from outside: a shared signal, an input that nothing is connected to, or a parameter that may change.
 * @typedef {object} Place
 * @property {number} component its number; -1 for a shared signal, which `Slot` sends
 * @property {Variable} variable
 */

/**
 * @typedef {object} Wiring
 * @property {string[]} names of all positions
 * @property {Map<string, number>} position by name
 * @property {Place[]} outside what the first positions hold
 * @property {Slot[]} slots of the components
 */

const KINDS = ["Real", "Integer", "Boolean"];

/**
 * Lay out the signals of a rig.
 * @param {Rig} rig
 * @returns {Wiring}
 */
export function layOut(rig) {
  const feeds = new Map(rig.connections.map(({ source, target }) => [target, source]));
  for (const { name, targets } of rig.signals) { targets.forEach((target) => feeds.set(target, name)); }
  /** @type {Map<string, Variable>} */
  const known = new Map();
  for (const { name, variables } of rig.components) {
    for (const variable of variables) { known.set(`${name}.${variable.name}`, variable); }
  }
  /** @type {Place[]} */
  const outside = [];
  /** @type {string[]} */
  const names = [];
  for (const { name, targets } of rig.signals) {
    names.push(name);
    outside.push({ component: -1, variable: /** @type {Variable} */ (known.get(targets[0])) });
  }
  rig.components.forEach(({ name, variables }, component) => {
    for (const variable of variables.filter(isHeld)) {
      if (!feeds.has(`${name}.${variable.name}`)) {
        names.push(`${name}.${variable.name}`);
        outside.push({ component, variable });
      }
    }
  });
  const outputs = rig.components.map(({ variables }) => byType(variables.filter(({ causality }) => causality === "output")));
  const firsts = outputs.map((members, i) => {
    const first = names.length;
    names.push(...members.map((variable) => `${rig.components[i].name}.${variable.name}`));
    return first;
  });
  const position = new Map(names.map((name, i) => [name, i]));
  const slots = rig.components.map(({ name, variables }, i) => {
    const inputs = byType(variables.filter((variable) => feeds.has(`${name}.${variable.name}`)));
    const sources = inputs.map((variable) => position.get(/** @type {string} */ (feeds.get(`${name}.${variable.name}`))) ?? -1);
    if (sources.includes(-1)) { throw new Error(`${name} is connected with a signal that there is not`); }
    return { inputs, sources: Int32Array.from(sources), outputs: outputs[i], first: firsts[i] };
  });
  return { names, position, outside, slots };
}

/**
 * @param {Variable} variable
 * @returns {boolean}
 */
function isHeld({ causality, variability }) {
  return causality === "input" || (causality === "parameter" && variability === "tunable");
}

/**
 * @param {Variable[]} variables
 * @returns {Variable[]}
 */
function byType(variables) {
  return KINDS.flatMap((kind) => variables.filter(({ type }) => type === kind));
}
