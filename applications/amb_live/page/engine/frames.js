// What the page shows of a session: the watched signals of every point, and frames with all that is new.

import { takeWarnings } from "./run.js";

/** @typedef {import("../protocol.js").UserChanges} UserChanges */
/** @typedef {import("./run.js").Run} Run */
/** @typedef {import("./session.js").Session} Session */

/** @param {Session} session @param {Run} run */
export function record({ rows, columns }, { assembly, rig }) {
  const width = columns.length + 1, needed = rows.length + width, { values, point } = assembly;
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

/**
 * Post a frame.
 * @param {Session} session
 * @param {number} now
 */
export function show(session, now) {
  const run = runOf(session), { rows, measured, contacts, course, anew } = session, { point } = run.assembly;
  for (const warning of takeWarnings(run)) {
    session.post({ type: "warning", ...warning, time: point * run.rig.stepSize });
  }
  if (session.userChangesUpdated) { session.post({ type: "userChanges", userChanges: userChangesOf(run) }); }
  measured.displayed = now;
  const data = rows.data.slice(0, rows.length), values = run.assembly.values.slice();
  session.post({
    type: "frame", point, time: point * run.rig.stepSize, status: session.failed ? "failed" : course?.status ?? "paused", anew,
    from: rows.length > 0 ? rows.from : anew ? rows.from : point, rows: data, values, contacts, speed: measured.speed,
  }, [data.buffer, values.buffer]);
  Object.assign(session, { anew: false, contacts: [], userChangesUpdated: false });
  rows.length = 0;
}

/** @param {Session} session @param {Run} run @param {string[] | null} signals */
export function watch(session, run, signals) {
  const { position } = run.assembly, unknown = (signals ?? []).find((name) => !position.has(name));
  if (unknown !== undefined) { throw new Error(`there is no signal ${unknown}`); }
  session.watched = signals;
  session.columns = Int32Array.from(watchedOf(session, run), (name) => position.get(name) ?? 0);
}

/** @param {Session} session @param {Run} run */
export function watchedOf({ watched }, { rig }) {
  return [...watched ?? rig.recorded];
}

/** @param {Run} run */
export function userChangesOf({ settings, changes }) {
  return { settings, changes: [...changes] };
}

/** @param {Session} session */
export function runOf({ run }) {
  if (!run) { throw new Error("no rig is loaded"); }
  return run;
}
