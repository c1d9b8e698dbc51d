// A session: requests in, answers out, and work in slices between them. It knows no clock and no worker; see `worker.js`.

import { FmuError } from "../fmi/instance.js";
import { startLibrary } from "../fmi/library.js";
import { Run } from "./run.js";
import { scenarioToml } from "./scenario.js";

/** @typedef {import("../protocol.js").Request} Request */
/** @typedef {import("../protocol.js").Answer} Answer */

/**
 * A computation up to a point, at a pace; samples are recorded while it plays, not while the rotor settles.
 * @typedef {object} Course
 * @property {"settling" | "playing"} status
 * @property {number} to point; may be infinite
 * @property {number} pace simulated seconds in a second
 * @property {boolean} notifyAtEnd whether an answer reports its end
 */

const SLICE_MS = 8; // of work at a time
const FRAME_MS = 15; // between frames
const PIECE_SECONDS = 0.1; // of a ramp of the speed
const MAX_BATCH = 16; // steps between two readings of the clock
const MEASURED_MS = 5; // of work between two measurements of the speed; clocks of browsers are coarse
const MAX_DELAY_MS = 250; // of a course; a longer delay is not made up for

/** A run, the course that computes it, and samples and contacts that no frame has sent yet. Times `now` are in ms. */
export class Session {
  /** @param {(answer: Answer, transfer?: ArrayBuffer[]) => void} post */
  constructor(post) {
    this.post = post;
    /** @type {Map<string, import("../fmi/library.js").Library>} */
    this.libraries = new Map();
    /** @type {Run | null} */
    this.present = null;
    /** @type {Course | null} */
    this.course = null; // null: paused
    this.failed = false;
    this.start = { point: 0, now: 0 }; // of the course; later if it fell behind
    /** @type {string[]} */
    this.watched = [];
    this.columns = new Int32Array(); // positions of the watched signals
    this.rows = { data: new Float64Array(4096), length: 0, from: 0 };
    /** @type {import("../protocol.js").ContactEvent[]} */
    this.contacts = [];
    this.anew = false;
    this.userChangesUpdated = false;
    /** @type {{ goal: number, rate: number, until: number } | null} */
    this.ramp = null; // of the speed, as requested by the user
    this.measured = { speed: NaN, displayed: -Infinity, steps: 0, busy: 0 }; // `speed` of frames; steps and ms since its last measurement
  }

  get run() {
    if (!this.present) { throw new Error("no rig is loaded"); }
    return this.present;
  }

  get userChanges() {
    const { settings, changes } = this.run;
    return { settings, changes: [...changes] };
  }

  /**
   * Handle a request of the page.
   * @param {Request} request
   * @param {number} now
   */
  handle(request, now) {
    try {
      if (request.type === "load") { this.load(request, now); } else { this.answer(request, now); }
    } catch (error) {
      this.post({ type: "refused", request: request.type, text: textOf(error) });
    }
  }

  /**
   * Compute for a slice of time, post new samples, and return whether the next slice is due at once.
   * @param {number} now
   * @param {() => number} clock
   */
  work(now, clock) {
    const { course } = this;
    if (!this.present || !course) { return false; }
    const { assembly } = this.run, goal = this.pointDue(course, now), begin = assembly.point;
    const steps = Math.min(Math.max(Math.floor(this.measured.speed * this.run.rig.rate / 1000), 1), MAX_BATCH) || 1; // in about a millisecond
    let time = now;
    while (this.course === course && assembly.point < goal && time - now < SLICE_MS) {
      const batch = Math.min(assembly.point + steps, goal);
      while (this.course === course && assembly.point < batch) { this.advance(course); }
      time = clock();
    }
    if (this.course === course && assembly.point >= course.to) { this.finish(course); }
    this.measure(begin, time - now);
    if (this.course !== course || time - this.measured.displayed >= FRAME_MS) { this.show(time); }
    return this.course === course && assembly.point < goal;
  }

  /**
   * @param {Extract<Request, { type: "load" }>} request
   * @param {number} now
   */
  load({ rig, parts, userChanges, watched }, now) {
    if (!this.libraries.has(rig.module)) {
      this.libraries.set(rig.module, startLibrary(new WebAssembly.Module(bytesOf(parts, rig.module))));
    }
    this.begin({ ...rig, data: base64(bytesOf(parts, rig.data)) }, userChanges ?? { settings: {}, changes: [] }, now);
    const { names, position } = this.run.assembly, unknown = (watched ?? []).find((name) => !position.has(name));
    if (unknown !== undefined) { throw new Error(`there is no signal ${unknown}`); }
    this.watched = [...watched ?? rig.recorded];
    this.columns = Int32Array.from(this.watched, (name) => position.get(name) ?? 0);
    this.post({ type: "ready", signals: [...names], watched: this.watched, userChanges: this.userChanges });
    this.show(now);
  }

  /**
   * Replace the present run, and let the rotor settle.
   * @param {import("../protocol.js").Rig} rig
   * @param {import("../protocol.js").UserChanges} userChanges
   * @param {number} now
   */
  begin(rig, { settings, changes }, now) {
    const library = this.libraries.get(rig.module);
    if (!library) { throw new Error(`there is no module ${rig.module}`); }
    const run = new Run(rig, library, settings, changes);
    this.present?.end();
    this.present = run;
    this.seek(0, now);
  }

  /**
   * Compute up to a point without showing it.
   * @param {number} point
   * @param {number} now
   */
  seek(point, now) {
    Object.assign(this, { failed: false, ramp: null, anew: true, contacts: [], userChangesUpdated: true });
    this.rows.length = 0;
    this.rows.from = point;
    this.startCourse({ status: "settling", to: point, pace: Infinity, notifyAtEnd: false }, now);
  }

  /**
   * @param {Course} course
   * @param {number} now
   */
  startCourse(course, now) {
    if (this.failed) { throw new Error("the run has failed; go back in time, or reset"); }
    this.course = course;
    this.start = { point: this.run.assembly.point, now };
  }

  /**
   * @param {Exclude<Request, { type: "load" }>} request
   * @param {number} now
   */
  answer(request, now) {
    const { run } = this, { rig, assembly } = run, present = Math.max(assembly.point, 0);
    if (["play", "pause", "step", "run"].includes(request.type) && this.course?.status === "settling") { throw new Error("the rotor is still settling"); }
    switch (request.type) {
      case "play":
        if (!(request.pace > 0)) { throw new Error(`pace = ${request.pace} is not allowed; it must be > 0`); }
        return this.startCourse({ status: "playing", to: Infinity, pace: request.pace, notifyAtEnd: false }, now);
      case "pause":
        this.course = null;
        return this.show(now);
      case "step":
        return this.startCourse({ status: "playing", to: present + 1, pace: Infinity, notifyAtEnd: false }, now);
      case "run":
        return this.startCourse({ status: "playing", to: Math.round(request.to / rig.stepSize), pace: Infinity, notifyAtEnd: true }, now);
      case "reset":
        this.begin(rig, { settings: request.settings ?? run.settings, changes: [] }, now);
        return this.show(now);
      case "set":
        this.change(request.values);
        break;
      case "push":
        this.change({ [`rotor_contact.${request.disc}.f_x`]: request.force[0], [`rotor_contact.${request.disc}.f_y`]: request.force[1] });
        break;
      case "speed":
        this.speedUp(request.speed, request.acceleration);
        break;
      case "rewind": {
        const point = Math.min(Math.max(Math.round(request.time / rig.stepSize), 0), present);
        run.goBackTo(point, request.keep ?? false);
        this.seek(point, now);
        return this.show(now);
      }
      case "save":
        return this.post({ type: "saved", name: request.name, toml: scenarioToml(rig, this.userChanges, run.speeds, present, request.description) });
    }
    this.userChangesUpdated = true;
    if (!this.course) { this.show(now); }
  }

  /**
   * Change values from the present point on; a record of that point is removed.
   * @param {Record<string, number>} values
   */
  change(values) {
    const { run, rows, columns } = this, { arrived } = run;
    run.change(values);
    if (run.arrived === arrived || arrived < 0) { return; }
    if (rows.length > 0) { rows.length -= columns.length + 1; } else { this.anew = true; }
    if (rows.length === 0) { rows.from = arrived; }
  }

  /**
   * Go to a speed by short ramps, so that the target can change on the way.
   * @param {number} speed rad/s
   * @param {number} acceleration rad/s2
   */
  speedUp(speed, acceleration) {
    if (!(speed > 0)) { throw new Error(`Omega = ${speed} rad/s is not allowed; it must be > 0 rad/s, because cycles count revolutions`); }
    if (!(acceleration > 0)) { throw new Error(`acceleration = ${acceleration} rad/s2 is not allowed; it must be > 0 rad/s2`); }
    this.run.tryOut({ Omega: speed });
    this.addPiece(speed, acceleration);
  }

  /**
   * @param {number} goal rad/s
   * @param {number} rate rad/s2
   */
  addPiece(goal, rate) {
    this.ramp = { goal, rate, until: this.run.addPiece(goal, rate, Math.round(PIECE_SECONDS * this.run.rig.rate)) };
    this.userChangesUpdated = true;
  }

  /** Record the present point, and do a step unless the run ends there. @param {Course} course */
  advance(course) {
    const { run, ramp } = this;
    if (ramp && ramp.until <= run.assembly.point) {
      if (run.valueAt("Omega", run.assembly.point) === ramp.goal) { this.ramp = null; } else { this.addPiece(ramp.goal, ramp.rate); }
    }
    if (this.recordPoint(course)) { return; }
    try {
      const events = run.step();
      if (course.status === "playing") { this.contacts.push(...events); }
    } catch (error) {
      Object.assign(this, { course: null, failed: true });
      const time = run.assembly.point * run.rig.stepSize, text = textOf(error);
      this.post({ type: "failed", component: error instanceof FmuError ? run.componentOf(text) : "", time, text });
    }
  }

  /** Record the present point, and return whether the run ends at it. @param {Course} course */
  recordPoint(course) {
    const { run } = this;
    if (!run.arrive()) { return false; }
    if (course.status === "playing") { this.record(); }
    const text = run.stopReason(), { point } = run.assembly, time = point * run.rig.stepSize;
    if (text !== null && course.status === "playing") {
      this.post({ type: "ended", reason: "stopped", time, text });
      this.course = null;
    } else if (point === run.rig.last && course.status === "playing" && run.planned && !run.completed) {
      run.completed = true;
      this.post({ type: "ended", reason: "completed", time, text: `completed at t = ${time} s` });
      this.course = null;
    }
    return this.course !== course;
  }

  /** @param {Course} course */
  finish(course) {
    if (course.notifyAtEnd && !this.recordPoint(course)) {
      this.post({ type: "ended", reason: "reached", time: this.run.assembly.point * this.run.rig.stepSize, text: "" });
    }
    this.course = null;
  }

  record() {
    const { rows, columns, run: { assembly: { values, point }, rig } } = this, needed = rows.length + columns.length + 1;
    if (needed > rows.data.length) {
      const larger = new Float64Array(2 * needed);
      larger.set(rows.data);
      rows.data = larger;
    }
    if (rows.length === 0) { rows.from = point; }
    rows.data[rows.length] = point * rig.stepSize;
    for (let k = 0; k < columns.length; k++) { rows.data[rows.length + 1 + k] = values[columns[k]]; }
    rows.length = needed;
  }

  /** Post a frame. @param {number} now */
  show(now) {
    const { run, rows, measured, contacts, course, anew } = this, { point } = run.assembly, time = point * run.rig.stepSize;
    run.takeWarnings().forEach((warning) => this.post({ type: "warning", ...warning, time }));
    if (this.userChangesUpdated) { this.post({ type: "userChanges", userChanges: this.userChanges }); }
    measured.displayed = now;
    const data = rows.data.slice(0, rows.length), values = run.assembly.values.slice();
    this.post({
      type: "frame", point, time, status: this.failed ? "failed" : course?.status ?? "paused", anew,
      from: rows.length > 0 || anew ? rows.from : point, rows: data, values, contacts, speed: measured.speed,
    }, [data.buffer, values.buffer]);
    Object.assign(this, { anew: false, contacts: [], userChangesUpdated: false });
    rows.length = 0;
  }

  /**
   * Return the point up to which a course leads now.
   * @param {Course} course
   * @param {number} now
   */
  pointDue({ pace, to }, now) {
    if (pace === Infinity) { return to; }
    const { start, run: { assembly, rig } } = this;
    const goal = start.point + Math.floor((now - start.now) / 1000 * pace * rig.rate);
    const late = (goal - assembly.point) / rig.rate / pace * 1000;
    if (late > MAX_DELAY_MS) { start.now += late - MAX_DELAY_MS; }
    return Math.min(goal, to);
  }

  /**
   * Update the measured speed of the simulation.
   * @param {number} begin point
   * @param {number} taken ms
   */
  measure(begin, taken) {
    const { measured, run } = this;
    measured.steps += run.assembly.point - begin;
    measured.busy += taken;
    if (measured.busy < MEASURED_MS) { return; }
    const speed = measured.steps * run.rig.stepSize / (measured.busy / 1000);
    Object.assign(measured, { steps: 0, busy: 0 });
    measured.speed = Number.isFinite(measured.speed) ? 0.8 * measured.speed + 0.2 * speed : speed;
  }
}

/**
 * @param {import("../protocol.js").Parts} parts
 * @param {string} key
 */
function bytesOf(parts, key) {
  if (!(key in parts)) { throw new Error(`the rig has no part ${key}`); }
  return /** @type {Uint8Array<ArrayBuffer>} */ (parts[key]);
}

/** @param {Uint8Array} bytes */
function base64(bytes) {
  let text = "";
  for (let k = 0; k < bytes.length; k += 8192) { text += String.fromCharCode(...bytes.subarray(k, k + 8192)); }
  return btoa(text);
}

/** @param {unknown} error */
function textOf(error) {
  return error instanceof Error ? error.message : String(error);
}
