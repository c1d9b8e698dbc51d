// How far a course has to be by now, and how fast it can be.

/** @typedef {import("./run.js").Run} Run */
/** @typedef {import("./session.js").Session} Session */
/** @typedef {import("./session.js").Course} Course */

const BATCH = 16; // most steps between two looks at the clock
const ENOUGH = 5; // ms of work that tell how fast it is; clocks of browsers are coarse
const BEHIND = 250; // ms that it may be late before it gives them up

/**
 * Return the point up to which a course leads now.
 * @param {Session} session
 * @param {Run} run
 * @param {Course} course
 * @param {number} now
 */
export function goalOf({ start }, { assembly, rig }, { pace, to }, now) {
  if (pace === Infinity) { return to; }
  const goal = start.point + Math.floor((now - start.now) / 1000 * pace * rig.rate);
  const late = (goal - assembly.point) / rig.rate / pace * 1000;
  if (late > BEHIND) { start.now += late - BEHIND; }
  return Math.min(goal, to);
}

/**
 * Return how many steps take about a millisecond.
 * @param {Session} session
 * @param {Run} run
 */
export function stepsIn({ measured }, { rig }) {
  return Math.min(Math.max(Math.floor(measured.speed * rig.rate / 1000), 1), BATCH) || 1;
}

/**
 * Note how fast it is.
 * @param {Session} session
 * @param {Run} run
 * @param {number} begin
 * @param {number} taken ms
 */
export function measure({ measured }, { assembly, rig }, begin, taken) {
  measured.steps += assembly.point - begin;
  measured.busy += taken;
  if (measured.busy < ENOUGH) { return; }
  const speed = measured.steps * rig.stepSize / (measured.busy / 1000);
  Object.assign(measured, { steps: 0, busy: 0 });
  measured.speed = Number.isFinite(measured.speed) ? 0.8 * measured.speed + 0.2 * speed : speed;
}
