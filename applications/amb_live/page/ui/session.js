// The state of the run in the page: the rig, the newest values, recent samples, and the contacts.

import { Traces } from "./traces.js";

/** @typedef {import("../protocol.js").Rig} Rig */
/** @typedef {import("../protocol.js").Variable} Variable */
/** @typedef {import("../protocol.js").Answer} Answer */

/**
 * @typedef {object} Session
 * @property {Rig} rig
 * @property {Map<string, Variable>} variables by `component.variable`
 * @property {Map<string, number>} columns index of a signal in `values`
 * @property {Float64Array} values
 * @property {Traces} traces
 * @property {import("../protocol.js").ContactEvent[]} contacts
 * @property {import("../protocol.js").UserChanges} userChanges
 * @property {import("../protocol.js").Frame["status"] | "loading"} status
 * @property {number} time s
 * @property {number} reached latest time computed since the run began (s)
 * @property {number} speed
 * @property {number} answerCount answers of the worker so far
 */

export const CONTACT_WINDOW = 1e-3; // s, over which a contact force is averaged, as in the verdict on a run
const MAX_SAMPLES = 1 << 18; // samples: a minute at 4 kHz

/**
 * Return the session of a rig before its worker is ready.
 * @param {Rig} rig
 * @returns {Session}
 */
export function newSession(rig) {
  const variables = new Map(rig.components.flatMap((component) =>
    component.variables.map((variable) => /** @type {const} */ ([`${component.name}.${variable.name}`, variable]))));
  return {
    rig, variables, columns: new Map(), values: new Float64Array(0), traces: new Traces([], 1), contacts: [],
    userChanges: { settings: {}, changes: [] }, status: "loading", time: 0, reached: 0, speed: NaN, answerCount: 0,
  };
}

/**
 * Update a session with an answer of the worker.
 * @param {Session} session
 * @param {Answer} answer
 */
export function absorb(session, answer) {
  session.answerCount += 1;
  if (answer.type === "ready") {
    session.columns = new Map(answer.signals.map((name, k) => [name, k]));
    session.traces = new Traces(answer.watched, MAX_SAMPLES);
    session.contacts = [];
    session.userChanges = answer.userChanges;
    session.status = "settling";
  } else if (answer.type === "userChanges") {
    session.userChanges = answer.userChanges;
  } else if (answer.type === "frame") {
    absorbFrame(session, answer);
  }
}

/** @param {Session} session @param {import("../protocol.js").Frame} frame */
function absorbFrame(session, frame) {
  if (frame.anew) {
    const from = frame.from * session.rig.stepSize;
    session.traces.truncate(from - 0.5 * session.rig.stepSize);
    session.contacts = session.contacts.filter((contact) => contact.point <= frame.from); // a contact at `from` is of the step before
    if (from <= 0 || session.traces.count === 0) { session.reached = frame.time; }
  }
  session.traces.append(frame.rows);
  session.contacts.push(...frame.contacts);
  Object.assign(session, { values: frame.values, status: frame.status, time: frame.time, speed: frame.speed });
  session.reached = Math.max(session.reached, frame.time);
}

/**
 * Return the newest value of a signal; NaN before the first frame, and for an unknown signal.
 * @param {Session} session
 * @param {string} name
 */
export function valueOf(session, name) {
  const column = session.columns.get(name);
  return column === undefined || column >= session.values.length ? NaN : session.values[column];
}

/**
 * Return the value of a parameter, input or shared signal as set by the user, by the scenario, or by its start value.
 * @param {Session} session
 * @param {string} name
 */
export function settingOf(session, name) {
  const displayed = valueOf(session, name), half = 0.5 * session.rig.stepSize;
  for (let k = session.userChanges.changes.length - 1; k >= 0; k--) {
    const { time, values } = session.userChanges.changes[k];
    const isDue = time > session.time - half; // set at this point, before its step
    if (time < session.time + half && name in values && (isDue || !Number.isFinite(displayed))) { return values[name]; }
  }
  if (Number.isFinite(displayed)) { return displayed; }
  const setting = session.userChanges.settings.values?.[name] ?? session.rig.inputs[name];
  if (setting !== undefined) { return setting; }
  const [component, variable] = split(name);
  const declared = session.rig.components.find((item) => item.name === component)?.parameters[variable];
  return declared ?? session.variables.get(name)?.start ?? NaN;
}

/**
 * Return the final values of changes, without forces on discs and the speed, which may be on a ramp.
 * @param {readonly import("../protocol.js").Change[]} changes in order of time
 */
export function lasting(changes) {
  const values = Object.assign({}, ...changes.map((change) => change.values));
  return Object.fromEntries(Object.entries(values).filter(([name]) => name !== "Omega" && !/^rotor_contact\.[^.]+\.f_[xy]$/.test(name)));
}

/**
 * Return component and variable of a full name.
 * @param {string} name
 */
export function split(name) {
  const at = name.indexOf(".");
  return [name.slice(0, at), name.slice(at + 1)];
}

/**
 * Return the names of variables that match a pattern with `*` and `?`, as scenarios match them.
 * @param {Session} session
 * @param {string} pattern
 */
export function matching(session, pattern) {
  const text = pattern.replace(/[.+^${}()|[\]\\]/g, "\\$&").replaceAll("*", ".*").replaceAll("?", ".");
  const expression = new RegExp(`^${text}$`);
  return [...session.variables.keys()].filter((name) => expression.test(name));
}

/**
 * Return the names of all places where the rotor can touch, across and along its shaft.
 * @param {Pick<import("../protocol.js").Geometry, "sites" | "faces">} geometry
 */
export function placesOfContact({ sites, faces }) {
  return [...sites, ...faces].map((place) => place.name);
}

/**
 * Return when a change of a variable takes effect: at the next step, or when the run starts anew.
 * @param {Session} session
 * @param {string} name
 */
export function effectOf(session, name) {
  const variable = session.variables.get(name);
  return variable !== undefined && variable.causality === "parameter" && variable.variability === "fixed" ? "anew" : "live";
}

/**
 * Return the name of the law that holds the rotor without adaptive control: a linear controller, inner or alone, or PID.
 * @param {Session} session
 */
export function plainLaw(session) {
  const isInner = session.rig.components.some((component) => component.name === "linear_controller");
  return !isInner && matching(session, "rolac_controller.*.k_b_?").length > 0 ? "PID" : "Linear";
}
