// A session: requests in, answers out, and work in slices between them. It knows no clock and no worker; see `worker.js`.

import { startLibrary } from "../fmi/library.js";
import { record, runOf, show, userChangesOf, watch, watchedOf } from "./frames.js";
import { goalOf, measure, stepsIn } from "./pace.js";
import { scenarioToml } from "./scenario.js";
import {
  addPiece, arrive, change, componentOf, endRun, FmuError, goBackTo, startRun, stepRun, stopsBy, tryOut, speedsOf, valueAt,
} from "./run.js";

/** @typedef {import("../protocol.js").Request} Request */
/** @typedef {import("../protocol.js").Answer} Answer */
/** @typedef {import("../protocol.js").Rig} Rig */
/** @typedef {import("../protocol.js").UserChanges} UserChanges */
/** @typedef {import("../protocol.js").ContactEvent} ContactEvent */
/** @typedef {import("./run.js").Run} Run */

/**
 * What is being computed: up to a point, at a pace, displayed or not.
 * @typedef {object} Course
 * @property {"settling" | "playing"} status
 * @property {number} to point; may be infinite
 * @property {number} pace simulated seconds in a second
 * @property {boolean} notifyAtEnd whether its end is answered
 */

/**
 * @typedef {object} Session
 * @property {(answer: Answer, transfer?: ArrayBuffer[]) => void} post
 * @property {Map<string, import("../fmi/library.js").Library>} libraries
 * @property {Run | null} run
 * @property {Course | null} course null while it pauses
 * @property {boolean} failed
 * @property {{ point: number, now: number }} start of the course, or later if it fell behind
 * @property {string[] | null} watched null for what the scenario records
 * @property {Int32Array} columns positions of the watched signals
 * @property {Rows} rows
 * @property {ContactEvent[]} contacts
 * @property {boolean} anew
 * @property {boolean} userChangesUpdated
 * @property {{ goal: number, rate: number, until: number } | null} ramp of the speed that the user requested
 * @property {{ speed: number, displayed: number, steps: number, busy: number }} measured
 * `speed` as in frames, after so many steps in so many ms of work; when a frame was displayed (ms)
 */

/** Samples that no frame has displayed yet. @typedef {{ data: Float64Array, length: number, from: number }} Rows */

const SLICE = 8; // ms of work at a time
const FRAME = 15; // ms between frames
const PIECE = 0.1; // s, of a ramp of the speed

/** @param {Session["post"]} post */
export function openSession(post) {
  return {
    post, libraries: new Map(), run: null, course: null, failed: false, start: { point: 0, now: 0 }, watched: null,
    columns: new Int32Array(), rows: { data: new Float64Array(4096), length: 0, from: 0 }, contacts: [], anew: false,
    userChangesUpdated: false, ramp: null, measured: { speed: NaN, displayed: -Infinity, steps: 0, busy: 0 },
  };
}

/**
 * Do what the page asks for.
 * @param {Session} session
 * @param {Request} request
 * @param {number} now ms
 */
export function handle(session, request, now) {
  try {
    if (request.type === "load") { load(session, request, now); } else { answer(session, runOf(session), request, now); }
  } catch (error) {
    session.post({ type: "refused", request: request.type, text: textOf(error) });
  }
}

/**
 * Compute for a slice of time, and show what is new.
 * @param {Session} session
 * @param {number} now ms
 * @param {() => number} clock ms
 * @returns {boolean} whether more is to be computed at once
 */
export function work(session, now, clock) {
  const { run, course } = session;
  if (!run || !course) { return false; }
  const goal = goalOf(session, run, course, now), begin = run.assembly.point;
  let time = now;
  while (session.course === course && run.assembly.point < goal && time - now < SLICE) {
    const batch = Math.min(run.assembly.point + stepsIn(session, run), goal);
    while (session.course === course && run.assembly.point < batch) { advanceRun(session, run, course); }
    time = clock();
  }
  if (session.course === course && run.assembly.point >= course.to) { finish(session, run, course); }
  measure(session, run, begin, time - now);
  if (session.course !== course || time - session.measured.displayed >= FRAME) { show(session, time); }
  return session.course === course && run.assembly.point < goal;
}

/** @param {Session} session @param {Extract<Request, { type: "load" }>} request @param {number} now */
function load(session, { rig, parts, userChanges, watched }, now) {
  const { libraries } = session;
  if (!libraries.has(rig.module)) {
    libraries.set(rig.module, startLibrary(new WebAssembly.Module(bytesOf(parts, rig.module))));
  }
  begin(session, { ...rig, data: base64(bytesOf(parts, rig.data)) }, userChanges ?? { settings: {}, changes: [] }, now);
  watch(session, runOf(session), watched ?? null);
  const run = runOf(session), { names } = run.assembly;
  session.post({ type: "ready", signals: [...names], watched: watchedOf(session, run), userChanges: userChangesOf(run) });
  show(session, now);
}

/**
 * Start a run in place of the present one, and settle.
 * @param {Session} session
 * @param {Rig} rig
 * @param {UserChanges} userChanges
 * @param {number} now
 */
function begin(session, rig, { settings, changes }, now) {
  const library = session.libraries.get(rig.module);
  if (!library) { throw new Error(`there is no module ${rig.module}`); }
  const run = startRun(rig, library, settings, changes);
  if (session.run) { endRun(session.run); }
  session.run = run;
  seek(session, 0, now);
}

/**
 * Compute up to a point without showing it.
 * @param {Session} session
 * @param {number} point
 * @param {number} now
 */
function seek(session, point, now) {
  Object.assign(session, { failed: false, ramp: null, anew: true, contacts: [], userChangesUpdated: true });
  session.rows.length = 0;
  session.rows.from = point;
  startCourse(session, { status: "settling", to: point, pace: Infinity, notifyAtEnd: false }, now);
}

/** @param {Session} session @param {Course} course @param {number} now */
function startCourse(session, course, now) {
  const run = runOf(session);
  if (session.failed) { throw new Error("the run has failed; go back in time, or reset"); }
  session.course = course;
  session.start = { point: run.assembly.point, now };
}

/** @param {Session} session @param {Run} run @param {Exclude<Request, { type: "load" }>} request @param {number} now */
function answer(session, run, request, now) {
  const { rig, assembly } = run, present = Math.max(assembly.point, 0);
  switch (request.type) {
    case "play":
      if (!(request.pace > 0)) { throw new Error(`pace = ${request.pace} is not allowed; it must be > 0`); }
      whenSettled(session);
      return startCourse(session, { status: "playing", to: Infinity, pace: request.pace, notifyAtEnd: false }, now);
    case "pause":
      whenSettled(session);
      session.course = null;
      return show(session, now);
    case "step":
      whenSettled(session);
      return startCourse(session, { status: "playing", to: present + 1, pace: Infinity, notifyAtEnd: false }, now);
    case "run":
      whenSettled(session);
      return startCourse(session, { status: "playing", to: Math.round(request.to / rig.stepSize), pace: Infinity, notifyAtEnd: true }, now);
    case "reset":
      begin(session, rig, { settings: request.settings ?? run.settings, changes: [] }, now);
      return show(session, now);
    case "set":
      changeRun(session, run, request.values);
      break;
    case "push":
      changeRun(session, run, { [`rotor_contact.${request.disc}.f_x`]: request.force[0], [`rotor_contact.${request.disc}.f_y`]: request.force[1] });
      break;
    case "speed":
      speedUp(session, run, request.speed, request.acceleration);
      break;
    case "rewind": {
      const point = Math.min(Math.max(Math.round(request.time / rig.stepSize), 0), present);
      goBackTo(run, point, request.keep ?? false);
      seek(session, point, now);
      return show(session, now);
    }
    case "save":
      session.post({ type: "saved", name: request.name, toml: scenarioToml(rig, userChangesOf(run), speedsOf(run), present, request.description) });
      return;
  }
  session.userChangesUpdated = true;
  if (!session.course) { show(session, now); }
}

/**
 * Change values from the present point on; if it was recorded, that is taken back.
 * @param {Session} session
 * @param {Run} run
 * @param {Record<string, number>} values
 */
function changeRun(session, run, values) {
  const { arrived } = run, { rows, columns } = session;
  change(run, values);
  if (run.arrived === arrived || arrived < 0) { return; }
  if (rows.length > 0) { rows.length -= columns.length + 1; } else { Object.assign(session, { anew: true }); }
  if (rows.length === 0) { rows.from = arrived; }
}

/**
 * Throw while it settles, which nothing else may end.
 * @param {Session} session
 */
function whenSettled({ course }) {
  if (course?.status === "settling") { throw new Error("the rotor is still settling"); }
}

/**
 * Go to a speed in pieces, so that the way can change.
 * @param {Session} session
 * @param {Run} run
 * @param {number} speed rad/s
 * @param {number} acceleration rad/s2
 */
function speedUp(session, run, speed, acceleration) {
  if (!(speed > 0)) { throw new Error(`Omega = ${speed} rad/s is not allowed; it must be > 0 rad/s, since cycles count its turns`); }
  if (!(acceleration > 0)) { throw new Error(`acceleration = ${acceleration} rad/s2 is not allowed; it must be > 0 rad/s2`); }
  tryOut(run, { Omega: speed });
  session.ramp = nextPiece(session, run, { goal: speed, rate: acceleration });
}

/** @param {Session} session @param {Run} run @param {{ goal: number, rate: number }} ramp */
function nextPiece(session, run, { goal, rate }) {
  const until = addPiece(run, goal, rate, Math.round(PIECE * run.rig.rate));
  session.userChangesUpdated = true;
  return { goal, rate, until };
}

/**
 * Do a step, and what comes before it.
 * @param {Session} session
 * @param {Run} run
 * @param {Course} course
 */
function advanceRun(session, run, course) {
  if (session.ramp && session.ramp.until <= run.assembly.point) {
    const arrived = valueAt(run, "Omega", run.assembly.point) === session.ramp.goal;
    session.ramp = arrived ? null : nextPiece(session, run, session.ramp);
  }
  if (look(session, run, course)) { return; }
  try {
    const events = stepRun(run);
    if (course.status === "playing") { session.contacts.push(...events); }
  } catch (error) {
    session.course = null;
    session.failed = true;
    const time = run.assembly.point * run.rig.stepSize, text = textOf(error);
    session.post({ type: "failed", component: error instanceof FmuError ? componentOf(run.rig, text) : "", time, text });
  }
}

/**
 * Record the present point, and judge whether the run ends at it.
 * @param {Session} session
 * @param {Run} run
 * @param {Course} course
 */
function look(session, run, course) {
  if (!arrive(run)) { return false; }
  if (course.status === "playing") { record(session, run); }
  const text = stopsBy(run), { point } = run.assembly, time = point * run.rig.stepSize;
  if (text !== null && course.status === "playing") {
    session.post({ type: "ended", reason: "stopped", time, text });
    session.course = null;
  } else if (point === run.rig.last && course.status === "playing" && run.settings.events !== false && !run.completed) {
    run.completed = true;
    session.post({ type: "ended", reason: "completed", time, text: `completed at t = ${time} s` });
    session.course = null;
  }
  return session.course !== course;
}

/** @param {Session} session @param {Run} run @param {Course} course */
function finish(session, run, course) {
  session.course = null;
  if (!course.notifyAtEnd) { return; }
  session.course = course;
  look(session, run, course);
  const time = run.assembly.point * run.rig.stepSize;
  if (session.course === course) { session.post({ type: "ended", reason: "reached", time, text: "" }); }
  session.course = null;
}

/** @param {import("../protocol.js").Parts} parts @param {string} key */
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
