// Conditions that end a run, as in `cosim/system/stopping.py`: a signal has been above or below a limit for long enough.

/**
 * Return the number of the first condition that is met at a point, or -1.
 * @param {readonly import("../protocol.js").StopCondition[]} conditions
 * @param {readonly number[]} positions of their signals
 * @param {number[]} since point since which each may have been met; modified
 * @param {Float64Array} values
 * @param {number} point
 */
export function conditionMet(conditions, positions, since, values, point) {
  for (let k = 0; k < conditions.length; k++) {
    const { above, limit, hold } = conditions[k], sign = above ? 1 : -1;
    if (point < since[k]) { continue; }
    if (!(sign * values[positions[k]] > sign * limit)) { since[k] = point + 1; } else if (point - since[k] >= hold) { return k; }
  }
  return -1;
}
