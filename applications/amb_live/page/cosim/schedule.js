// Values from outside over time: changes at points, and ramps that are linear between points, as in `cosim/grid/schedules.py`.

/**
 * @typedef {object} Ramp
 * @property {[point: number, value: number][]} points ascending
 * @property {number} valuePosition
 * @property {number} slopePosition of the derivative over the coming step (1/s); -1 without
 */

/**
 * @typedef {object} Schedule
 * @property {Map<number, [position: number, value: number][]>} changes at points; the last of several applies
 * @property {Ramp[]} ramps
 * @property {number} stepSize s
 */

/**
 * Add a change.
 * @param {Schedule} schedule
 * @param {number} point
 * @param {number} position
 * @param {number} value
 */
export function addChange({ changes }, point, position, value) {
  const due = changes.get(point) ?? [];
  due.push([position, value]);
  changes.set(point, due);
}

/**
 * Call `set` with the values that apply from a point on.
 * @param {Schedule} schedule
 * @param {number} point
 * @param {(position: number, value: number) => void} set
 */
export function apply({ changes, ramps, stepSize }, point, set) {
  for (const [position, value] of changes.get(point) ?? []) { set(position, value); }
  for (const ramp of ramps) {
    const { value, slope } = rampAt(ramp.points, point, stepSize);
    set(ramp.valuePosition, value);
    if (ramp.slopePosition >= 0) { set(ramp.slopePosition, slope); }
  }
}

/**
 * Return a ramp's value at a point, and its slope beyond it (1/s).
 * @param {readonly [point: number, value: number][]} points
 * @param {number} point
 * @param {number} stepSize s
 */
export function rampAt(points, point, stepSize) {
  let after = points.length;
  while (after > 0 && points[after - 1][0] > point) { after -= 1; }
  const [begin, first] = points[Math.max(after - 1, 0)], [end, last] = points[Math.min(after, points.length - 1)];
  const steps = end - begin, rise = last - first;
  if (steps === 0) { return { value: first, slope: 0 }; }
  return { value: first + (rise * (point - begin)) / steps, slope: rise / (steps * stepSize) };
}
