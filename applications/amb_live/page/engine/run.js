// A run of a rig: its FMU with the schedule of scenario and user, what it records, and the way back.

import { FmuError } from "../fmi/instance.js";
import { backTo, keep, newHistory } from "../cosim/history.js";
import { advance, close, discard, goBack, set, snapshot, startAssembly } from "../cosim/assembly.js";
import { addChange, apply, at } from "../cosim/schedule.js";
import { conditionMet } from "../cosim/stopping.js";

/** @typedef {import("../protocol.js").Rig} Rig */
/** @typedef {import("../protocol.js").Change} Change */
/** @typedef {import("../protocol.js").Settings} Settings */
/** @typedef {import("../protocol.js").ContactEvent} ContactEvent */

/**
 * @typedef {object} Run
 * @property {Rig} rig
 * @property {import("../cosim/assembly.js").Assembly} assembly
 * @property {Settings} settings
 * @property {Change[]} changes of the user, in order of time
 * @property {import("../cosim/schedule.js").Schedule} schedule
 * @property {import("../cosim/history.js").History} history
 * @property {number} arrived last point whose values have been set, to be recorded; a change there takes that back
 * @property {boolean} completed whether the end of the scenario was reported
 * @property {readonly import("../protocol.js").StopCondition[]} stops
 * @property {number[]} stopPositions
 * @property {number[]} since see `conditionMet`
 * @property {{ site: string, position: number, mode: number }[]} sites last mode of contact of each
 */

const HISTORY_STEP = 0.05; // s
const MODE = ".mode", SPEED = "Omega";
const NEVER = Infinity;

/**
 * Start a run; it is then at its first point.
 * @param {Rig} rig
 * @param {import("../fmi/library.js").Library} library
 * @param {Settings} settings
 * @param {readonly Change[]} changes that take place when their time comes
 */
export function startRun(rig, library, settings, changes) {
  const assembly = startAssembly(rig, library, settings.values), { position, names } = assembly;
  const stops = settings.events === false ? [] : rig.stops;
  const sites = names.filter((name) => name.endsWith(MODE) && position.has(`${name.slice(0, -MODE.length)}.f_n`));
  /** @type {Run} */
  const run = {
    rig,
    assembly,
    settings,
    changes: [...changes],
    schedule: { changes: new Map(), ramps: [], stepSize: rig.stepSize },
    history: newHistory(Math.max(1, Math.round(HISTORY_STEP * rig.rate))),
    arrived: rig.first - 1,
    completed: false,
    stops,
    stopPositions: stops.map(({ signal }) => position.get(signal) ?? -1),
    since: stops.map(({ first }) => first),
    sites: sites.map((name) => ({ site: name.slice(name.indexOf(".") + 1, -MODE.length), position: position.get(name) ?? 0, mode: 0 })),
  };
  try {
    reschedule(run);
  } catch (error) {
    endRun(run);
    throw error;
  }
  return run;
}

/**
 * Free a run.
 * @param {Run} run
 */
export function endRun({ assembly, history }) {
  backTo(history, assembly, -Infinity);
  close(assembly);
}

/**
 * Set what holds from the present point on, unless that was done; return whether it was not.
 * @param {Run} run
 */
export function arrive(run) {
  const { assembly, history, schedule, since } = run;
  if (run.arrived >= assembly.point) { return false; }
  keep(history, assembly, since);
  apply(schedule, assembly.point, (position, value) => {
    if (assembly.values[position] !== value) { set(assembly, position, value); }
  });
  run.arrived = assembly.point;
  return true;
}

/**
 * Return the condition that ends the run at the present point, if any; it then ends it no more.
 * @param {Run} run
 */
export function stopsBy({ stops, stopPositions, since, assembly }) {
  const met = conditionMet(stops, stopPositions, since, assembly.values, assembly.point);
  if (met < 0) { return null; }
  since[met] = NEVER;
  return stops[met].text;
}

/**
 * Do a step, after `arrive`, and return the changes of contact in it.
 * @param {Run} run
 */
export function stepRun({ assembly, sites, rig }) {
  advance(assembly);
  /** @type {ContactEvent[]} */
  const events = [];
  for (const site of sites) {
    const mode = assembly.values[site.position];
    if (mode !== site.mode) {
      site.mode = mode;
      events.push({ point: assembly.point, time: assembly.point * rig.stepSize, site: site.site, mode });
    }
  }
  return events;
}

/**
 * Take values for the coming step and what follows, if the FMU does: they are tried for a step first.
 * @param {Run} run
 * @param {Record<string, number>} values
 * @throws {Error} if any is refused; nothing is changed then
 */
export function change(run, values) {
  const { assembly, rig } = run, point = Math.max(assembly.point, 0);
  for (const name of Object.keys(values)) {
    positionOf(run, name);
    if ([SPEED, `${SPEED}_dot`].includes(name)) { throw new Error(`${name} cannot jump: set a target speed and a rate`); }
  }
  if (assembly.point >= 0) { tryOut(run, values); }
  run.changes.push({ point, time: point * rig.stepSize, values });
  run.changes.sort((a, b) => a.point - b.point);
  Object.entries(values).forEach(([name, value]) => addChange(run.schedule, point, positionOf(run, name), value));
  run.arrived = Math.min(run.arrived, point - 1);
}

/**
 * Add a piece of a ramp of the speed, from now or from the end of the piece that runs, in place of those that were to come.
 * @param {Run} run
 * @param {number} goal rad/s
 * @param {number} rate rad/s2
 * @param {number} longest steps of the piece
 * @returns {number} the point at which it ends
 */
export function addPiece(run, goal, rate, longest) {
  const { rig, assembly, changes: before } = run, present = Math.max(assembly.point, run.arrived + 1, 1);
  if (run.settings.events !== false && rig.events.some(({ variable }) => variable === SPEED)) {
    throw new Error(`${SPEED} is set by the scenario's events and cannot follow a ramp`);
  }
  run.changes = before.filter((item) => item.until === undefined || item.point < present);
  const begin = run.changes.reduce((latest, { until = 0 }) => Math.max(latest, until), present);
  try {
    reschedule(run);
    const from = valueAt(run, SPEED, begin), needed = Math.max(1, Math.round(Math.abs(goal - from) / rate * rig.rate));
    const steps = Math.min(needed, longest), value = steps === needed ? goal : from + (goal - from) * steps / needed;
    run.changes.push({ point: begin, time: begin * rig.stepSize, values: { [SPEED]: value }, until: begin + steps });
    run.changes.sort((a, b) => a.point - b.point);
    reschedule(run);
    return begin + steps;
  } catch (error) {
    run.changes = before;
    reschedule(run);
    throw error;
  }
}

/**
 * Return the value of a signal at a point, of a ramp in the future too.
 * @param {Run} run
 * @param {string} signal
 * @param {number} point
 */
export function valueAt(run, signal, point) {
  const position = positionOf(run, signal), ramp = run.schedule.ramps.find(({ value }) => value === position);
  return ramp ? at(ramp.points, point, run.rig.stepSize).value : run.assembly.values[position];
}

/**
 * Go back to the last snapshot before a point, from where steps lead to it. Changes from it on are forgotten unless `keepChanges`.
 * @param {Run} run
 * @param {number} point
 * @param {boolean} keepChanges
 */
export function goBackTo(run, point, keepChanges) {
  const moment = backTo(run.history, run.assembly, point);
  if (!moment) { throw new Error("cannot go back before the beginning of the run"); }
  goBack(run.assembly, moment.snapshot);
  run.since = [...moment.since];
  run.arrived = run.assembly.point - 1;
  run.completed = run.completed && run.assembly.point > run.rig.last;
  run.sites.forEach((site) => { site.mode = run.assembly.values[site.position]; });
  if (!keepChanges) { run.changes = run.changes.filter((item) => item.point < point); }
  reschedule(run);
}

/**
 * Do a step with values on trial, and undo it.
 * @param {Run} run
 * @param {Record<string, number>} values
 */
export function tryOut(run, values) {
  const { assembly } = run, before = snapshot(assembly);
  try {
    Object.entries(values).forEach(([name, value]) => set(assembly, positionOf(run, name), value));
    advance(assembly);
  } finally {
    goBack(assembly, before);
    discard(assembly, before);
  }
}

/**
 * Return the warnings that were logged since the last call.
 * @param {Run} run
 */
export function takeWarnings({ assembly, rig }) {
  return assembly.instance.log.splice(0).map(({ text }) => ({ component: componentOf(rig, text), text }));
}

/**
 * Return the component that a message names first; empty if it names none.
 * @param {Rig} rig
 * @param {string} text
 */
export function componentOf({ components }, text) {
  const named = components.map(({ name }) => ({ name, at: text.search(new RegExp(`\\b${name}[.:]`)) })).filter(({ at }) => at >= 0);
  return named.sort((a, b) => a.at - b.at)[0]?.name ?? "";
}

/**
 * Return the points that the speed is linear between; none where it is constant.
 * @param {Run} run
 */
export function speedsOf({ assembly, schedule }) {
  const position = assembly.position.get(SPEED);
  return schedule.ramps.find(({ value }) => value === position)?.points ?? [];
}

/**
 * Make the schedule of scenario and user.
 * @param {Run} run
 */
function reschedule(run) {
  const { rig, settings, changes, schedule } = run, planned = settings.events !== false;
  schedule.changes.clear();
  schedule.ramps = planned ? rig.ramps.map(({ variable, points, slope }) =>
    ({ points: [...points], value: positionOf(run, variable), slope: slope === null ? -1 : positionOf(run, slope) })) : [];
  for (const { point, variable, value } of planned ? rig.events : []) {
    addChange(schedule, point, positionOf(run, variable), value);
  }
  for (const { point, values, until } of changes) {
    for (const [name, value] of Object.entries(values)) {
      if (until === undefined) { addChange(schedule, point, positionOf(run, name), value); } else { extend(run, name, point, until, value); }
    }
  }
}

/**
 * Let the ramp of a signal go on to a value; without a ramp, make it.
 * @param {Run} run
 * @param {string} name
 * @param {number} point
 * @param {number} until
 * @param {number} value
 */
function extend(run, name, point, until, value) {
  const position = positionOf(run, name), { names, position: positions } = run.assembly, { ramps } = run.schedule;
  let ramp = ramps.find((item) => item.value === position);
  if (!ramp) {
    const first = run.settings.values?.[name] ?? run.rig.inputs[name] ?? 0;
    ramp = { points: [[0, first]], value: position, slope: positions.get(`${names[position]}_dot`) ?? -1 };
    ramps.push(ramp);
  }
  const [last, held] = /** @type {[number, number]} */ (ramp.points.at(-1));
  if (point < last) { throw new Error(`${name} follows the scenario's points until t = ${last * run.rig.stepSize} s`); }
  if (point > last) { ramp.points.push([point, held]); }
  ramp.points.push([until, value]);
}

/**
 * Return the position of a value from outside.
 * @param {Run} run
 * @param {string} name
 */
function positionOf({ assembly: { position: positions, free } }, name) {
  const position = positions.get(name) ?? -1;
  if (position < 0 || position >= free.length) {
    throw new Error(`${name} cannot be set during a run: it is neither a free input nor a tunable parameter`);
  }
  return position;
}

export { FmuError };
