// Snapshots of a run, evenly spread from its beginning to now: the way back to any time is short, and memory has an end.

import { discard, snapshot } from "./assembly.js";

/** @typedef {import("./assembly.js").Assembly} Assembly */

/**
 * @typedef {object} Moment
 * @property {import("./assembly.js").Snapshot} snapshot
 * @property {number[]} since when conditions have been met, see `stopping.js`
 */

/**
 * @typedef {object} History
 * @property {Moment[]} moments ascending
 * @property {number} every points between two
 */

const MOST = 64; // moments, each of half a megabyte; then every second goes

/** @param {number} every points between two moments, at first */
export function newHistory(every) {
  return { moments: [], every };
}

/**
 * Keep the present moment if its time has come.
 * @param {History} history
 * @param {Assembly} assembly
 * @param {readonly number[]} since
 */
export function keep(history, assembly, since) {
  const { moments, every } = history, latest = moments.at(-1)?.snapshot.point ?? -Infinity;
  if (assembly.point < 0 || assembly.point <= latest || (assembly.point % every !== 0 && moments.length > 0)) { return; }
  moments.push({ snapshot: snapshot(assembly), since: [...since] });
  if (moments.length >= MOST) {
    history.every = 2 * every;
    history.moments = moments.filter((moment, k) => {
      const stays = k % 2 === 0;
      if (!stays) { discard(assembly, moment.snapshot); }
      return stays;
    });
  }
}

/**
 * Forget the moments after a point, and return the last that is left, if any.
 * @param {History} history
 * @param {Assembly} assembly
 * @param {number} point
 */
export function backTo(history, assembly, point) {
  const { moments } = history;
  while (moments.length > 0 && moments[moments.length - 1].snapshot.point > point) {
    discard(assembly, /** @type {Moment} */ (moments.pop()).snapshot);
  }
  return moments.at(-1);
}
