// A run of a rig: its FMU with the schedule of scenario and user, the recorded points, and the snapshots to go back to.

import { Assembly } from "../cosim/assembly.js";
import { History } from "../cosim/history.js";
import { addChange, apply, rampAt } from "../cosim/schedule.js";
import { conditionMet } from "../cosim/stopping.js";

/** @typedef {import("../protocol.js").Change} Change */

const HISTORY_STEP = 0.05; // s
const MODE = ".mode", SPEED = "Omega";
const NEVER = Infinity;

export class Run {
  /**
   * Start a run at its first point.
   * @param {import("../protocol.js").Rig} rig
   * @param {import("../fmi/library.js").Library} library
   * @param {import("../protocol.js").Settings} settings
   * @param {readonly Change[]} changes, each made at its point
   */
  constructor(rig, library, settings, changes) {
    this.assembly = new Assembly(rig, library, settings.values);
    const { position, names } = this.assembly;
    const sites = names.filter((name) => name.endsWith(MODE) && position.has(`${name.slice(0, -MODE.length)}.f_n`));
    this.rig = rig;
    this.settings = settings;
    this.planned = settings.events !== false; // whether the scenario's events, ramps and stops take place
    this.changes = [...changes]; // of the user, in order of time
    /** @type {import("../cosim/schedule.js").Schedule} */
    this.schedule = { changes: new Map(), ramps: [], stepSize: rig.stepSize };
    this.history = new History(this.assembly, Math.max(1, Math.round(HISTORY_STEP * rig.rate)));
    this.arrived = rig.first - 1; // last point whose values have been set and can be recorded; a change there resets this
    this.completed = false; // whether the end of the scenario was reported
    this.stops = this.planned ? rig.stops : [];
    this.stopPositions = this.stops.map(({ signal }) => position.get(signal) ?? -1);
    this.since = this.stops.map(({ first }) => first); // see `conditionMet`
    // each with its latest mode of contact
    this.sites = sites.map((name) => ({ site: name.slice(name.indexOf(".") + 1, -MODE.length), position: position.get(name) ?? 0, mode: 0 }));
    try {
      this.reschedule();
    } catch (error) {
      this.end();
      throw error;
    }
  }

  /** Free the FMU and all snapshots. */
  end() {
    this.history.backTo(-Infinity);
    this.assembly.close();
  }

  /** Set the values that apply from the present point on; return false if this was already done. */
  arrive() {
    const { assembly } = this;
    if (this.arrived >= assembly.point) { return false; }
    this.history.keep(this.since);
    apply(this.schedule, assembly.point, (position, value) => {
      if (assembly.values[position] !== value) { assembly.set(position, value); }
    });
    this.arrived = assembly.point;
    return true;
  }

  /** Return the text of the condition that ends the run at the present point, if any; it applies only once. */
  stopReason() {
    const met = conditionMet(this.stops, this.stopPositions, this.since, this.assembly.values, this.assembly.point);
    if (met < 0) { return null; }
    this.since[met] = NEVER;
    return this.stops[met].text;
  }

  /** Do a step, after `arrive`, and return the changes of contact in it. */
  step() {
    const { assembly } = this;
    assembly.advance();
    /** @type {import("../protocol.js").ContactEvent[]} */
    const events = [];
    for (const site of this.sites) {
      const mode = assembly.values[site.position];
      if (mode !== site.mode) {
        site.mode = mode;
        events.push({ point: assembly.point, time: assembly.point * this.rig.stepSize, site: site.site, mode });
      }
    }
    return events;
  }

  /**
   * Set values from the next step on, after a trial step that checks whether the FMU accepts them.
   * @param {Record<string, number>} values
   * @throws {Error} if a value is rejected; nothing is changed then
   */
  change(values) {
    const { assembly, rig } = this, point = Math.max(assembly.point, 0);
    for (const name of Object.keys(values)) {
      this.positionOf(name);
      if ([SPEED, `${SPEED}_dot`].includes(name)) { throw new Error(`${name} cannot jump: set a target speed and a rate`); }
    }
    if (assembly.point >= 0) { this.tryOut(values); }
    this.addUserChange({ point, time: point * rig.stepSize, values });
    Object.entries(values).forEach(([name, value]) => addChange(this.schedule, point, this.positionOf(name), value));
    this.arrived = Math.min(this.arrived, point - 1);
  }

  /** @param {Change} change */
  addUserChange(change) {
    this.changes.push(change);
    this.changes.sort((a, b) => a.point - b.point);
  }

  /**
   * Add a piece of a ramp of the speed, from now or from the end of the present piece, in place of planned ones.
   * @param {number} goal rad/s
   * @param {number} rate rad/s2
   * @param {number} longest steps of the piece
   * @returns {number} the point at which it ends
   */
  addPiece(goal, rate, longest) {
    const { rig, assembly, changes: before } = this, present = Math.max(assembly.point, this.arrived + 1, 1);
    if (this.planned && rig.events.some(({ variable }) => variable === SPEED)) {
      throw new Error(`${SPEED} is set by the scenario's events and cannot follow a ramp`);
    }
    this.changes = before.filter((item) => item.until === undefined || item.point < present);
    const begin = this.changes.reduce((latest, { until = 0 }) => Math.max(latest, until), present);
    try {
      this.reschedule();
      const from = this.valueAt(SPEED, begin), needed = Math.max(1, Math.round(Math.abs(goal - from) / rate * rig.rate));
      const steps = Math.min(needed, longest), value = steps === needed ? goal : from + (goal - from) * steps / needed;
      this.addUserChange({ point: begin, time: begin * rig.stepSize, values: { [SPEED]: value }, until: begin + steps });
      this.reschedule();
      return begin + steps;
    } catch (error) {
      this.changes = before;
      this.reschedule();
      throw error;
    }
  }

  /**
   * Return the value of a signal at a point, which may be in the future for a ramp.
   * @param {string} signal
   * @param {number} point
   */
  valueAt(signal, point) {
    const position = this.positionOf(signal), ramp = this.schedule.ramps.find(({ valuePosition }) => valuePosition === position);
    return ramp ? rampAt(ramp.points, point, this.rig.stepSize).value : this.assembly.values[position];
  }

  /**
   * Go back to the last snapshot at or before a point, from where steps lead to it. Changes from the point on are dropped unless `keepChanges`.
   * @param {number} point
   * @param {boolean} keepChanges
   */
  goBackTo(point, keepChanges) {
    const { assembly } = this, moment = this.history.backTo(point);
    if (!moment) { throw new Error("cannot go back before the beginning of the run"); }
    assembly.goBack(moment.snapshot);
    this.since = [...moment.since];
    this.arrived = assembly.point - 1;
    this.completed = this.completed && assembly.point > this.rig.last;
    this.sites.forEach((site) => { site.mode = assembly.values[site.position]; });
    if (!keepChanges) { this.changes = this.changes.filter((item) => item.point < point); }
    this.reschedule();
  }

  /** Do a trial step with values, and undo it. @param {Record<string, number>} values */
  tryOut(values) {
    const { assembly } = this, before = assembly.snapshot();
    try {
      Object.entries(values).forEach(([name, value]) => assembly.set(this.positionOf(name), value));
      assembly.advance();
    } finally {
      assembly.goBack(before);
      assembly.discard(before);
    }
  }

  /** Return the warnings that were logged since the last call. */
  takeWarnings() {
    return this.assembly.instance.log.splice(0).map(({ text }) => ({ component: this.componentOf(text), text }));
  }

  /** Return the first component in a message; empty without any. @param {string} text */
  componentOf(text) {
    const named = this.rig.components.map(({ name }) => ({ name, at: text.search(new RegExp(`\\b${name}[.:]`)) })).filter((item) => item.at >= 0);
    return named.sort((a, b) => a.at - b.at)[0]?.name ?? "";
  }

  /** The points between which the speed is linear; none for a constant speed. */
  get speeds() {
    const position = this.assembly.position.get(SPEED);
    return this.schedule.ramps.find(({ valuePosition }) => valuePosition === position)?.points ?? [];
  }

  /** Make the schedule of scenario and user. */
  reschedule() {
    const { rig, changes, schedule, planned } = this;
    schedule.changes.clear();
    schedule.ramps = planned ? rig.ramps.map(({ variable, points, slope }) =>
      ({ points: [...points], valuePosition: this.positionOf(variable), slopePosition: slope === null ? -1 : this.positionOf(slope) })) : [];
    for (const { point, variable, value } of planned ? rig.events : []) {
      addChange(schedule, point, this.positionOf(variable), value);
    }
    for (const { point, values, until } of changes) {
      for (const [name, value] of Object.entries(values)) {
        if (until === undefined) { addChange(schedule, point, this.positionOf(name), value); } else { this.extend(name, point, until, value); }
      }
    }
  }

  /**
   * Extend the ramp of a signal to a value; create the ramp if there is none.
   * @param {string} name
   * @param {number} point
   * @param {number} until
   * @param {number} value
   */
  extend(name, point, until, value) {
    const position = this.positionOf(name), { names, position: positions } = this.assembly, { ramps } = this.schedule;
    let ramp = ramps.find((item) => item.valuePosition === position);
    if (!ramp) {
      const first = this.settings.values?.[name] ?? this.rig.inputs[name] ?? 0;
      ramp = { points: [[0, first]], valuePosition: position, slopePosition: positions.get(`${names[position]}_dot`) ?? -1 };
      ramps.push(ramp);
    }
    const [last, held] = /** @type {[number, number]} */ (ramp.points.at(-1));
    if (point < last) { throw new Error(`${name} follows the scenario's points until t = ${last * this.rig.stepSize} s`); }
    if (point > last) { ramp.points.push([point, held]); }
    ramp.points.push([until, value]);
  }

  /** Return the position of a free input or tunable parameter. @param {string} name */
  positionOf(name) {
    const position = this.assembly.position.get(name) ?? -1;
    if (position < 0 || position >= this.assembly.free.length) {
      throw new Error(`${name} cannot be set during a run: it is neither a free input nor a tunable parameter`);
    }
    return position;
  }
}
