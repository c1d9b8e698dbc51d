// What was computed, sample by sample: rings of equal length, a ring for each signal, and what is drawn or saved of them.

/**
 * Samples of several signals over time, the newest `capacity` of them.
 * @typedef {object} Traces
 * @property {number} capacity
 * @property {number} count samples held
 * @property {number} next where the next sample goes
 * @property {Float64Array} time s
 * @property {Map<string, Float32Array>} values by signal
 */

/**
 * Return empty traces.
 * @param {readonly string[]} names
 * @param {number} capacity
 */
export function emptyTraces(names, capacity) {
  const values = new Map(names.map((name) => [name, new Float32Array(capacity)]));
  return { capacity, count: 0, next: 0, time: new Float64Array(capacity), values };
}

/**
 * Append samples that lie row by row: time, then a column for each signal.
 * @param {Traces} traces
 * @param {Float64Array} rows
 */
export function append(traces, rows) {
  const columns = [...traces.values.values()];
  const width = columns.length + 1;
  for (let at = 0; at < rows.length; at += width) {
    traces.time[traces.next] = rows[at];
    for (let k = 0; k < columns.length; k++) { columns[k][traces.next] = rows[at + k + 1]; }
    traces.next = (traces.next + 1) % traces.capacity;
    traces.count = Math.min(traces.count + 1, traces.capacity);
  }
}

/**
 * Forget the samples after a time.
 * @param {Traces} traces
 * @param {number} time s
 */
export function truncate(traces, time) {
  while (traces.count > 0 && traces.time[position(traces, traces.count - 1)] > time + 1e-9) {
    traces.next = (traces.next + traces.capacity - 1) % traces.capacity;
    traces.count -= 1;
  }
}

/**
 * Return where sample `k`, counted from the oldest, lies in the rings.
 * @param {Traces} traces
 * @param {number} k
 */
export function position(traces, k) {
  return (traces.next - traces.count + k + 2 * traces.capacity) % traces.capacity;
}

/**
 * Return the number of the first sample at or after a time; `count` without any.
 * @param {Traces} traces
 * @param {number} time s
 */
export function firstAt(traces, time) {
  let low = 0, high = traces.count;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (traces.time[position(traces, middle)] < time) { low = middle + 1; } else { high = middle; }
  }
  return low;
}

/**
 * Return the samples of a signal between two times, in order.
 * @param {Traces} traces
 * @param {string} name
 * @param {number} from s
 * @param {number} to s
 */
export function between(traces, name, from, to) {
  const ring = traces.values.get(name), first = firstAt(traces, from), end = firstAt(traces, to + 1e-9);
  const values = new Float32Array(ring === undefined ? 0 : Math.max(end - first, 0));
  if (ring !== undefined) {
    for (let k = 0; k < values.length; k++) { values[k] = ring[position(traces, first + k)]; }
  }
  return values;
}

/**
 * Return curves of at most two points for each of `buckets` equal spans of time, their extremes, which look as all would.
 * The buckets lie on a fixed grid of time, so that a scrolling curve does not shimmer.
 * @param {Traces} traces
 * @param {readonly string[]} names
 * @param {number} from s
 * @param {number} to s
 * @param {number} buckets
 * @param {readonly number[]} scales factor of each signal
 * @returns {number[][]} times, then the values of each signal
 */
export function thinned(traces, names, from, to, buckets, scales) {
  const first = firstAt(traces, from), end = firstAt(traces, to + 1e-9);
  const rings = names.map((name) => traces.values.get(name));
  /** @type {number[][]} */
  const curves = [[], ...names.map(() => /** @type {number[]} */ ([]))];
  const width = (to - from) / buckets;
  if (end - first <= 2 * buckets) {
    for (let k = first; k < end; k++) {
      const at = position(traces, k);
      curves[0].push(traces.time[at]);
      rings.forEach((ring, i) => curves[i + 1].push(ring === undefined ? NaN : scales[i] * ring[at]));
    }
    return curves;
  }
  for (let k = first; k < end;) {
    const bucket = Math.floor(traces.time[position(traces, k)] / width);
    let stop = k;
    while (stop < end && Math.floor(traces.time[position(traces, stop)] / width) === bucket) { stop += 1; }
    curves[0].push((bucket + 0.25) * width, (bucket + 0.75) * width);
    rings.forEach((ring, i) => curves[i + 1].push(...(ring === undefined ? [NaN, NaN] : extremes(traces, ring, k, stop, scales[i]))));
    k = stop;
  }
  return curves;
}

/**
 * Return the smallest and the largest of some samples in the order in which they occur.
 * @param {Traces} traces
 * @param {Float32Array} ring
 * @param {number} first
 * @param {number} end
 * @param {number} scale
 */
function extremes(traces, ring, first, end, scale) {
  let low = Infinity, high = -Infinity, lowAt = first, highAt = first;
  for (let k = first; k < end; k++) {
    const value = ring[position(traces, k)];
    if (value < low) { low = value; lowAt = k; }
    if (value > high) { high = value; highAt = k; }
  }
  return lowAt <= highAt ? [scale * low, scale * high] : [scale * high, scale * low];
}

/**
 * Return everything held as columns, time first.
 * @param {Traces} traces
 */
export function columnsOf(traces) {
  const ends = traces.count === 0 ? [0, 0] : [traces.time[position(traces, 0)], traces.time[position(traces, traces.count - 1)]];
  const time = Float64Array.from({ length: traces.count }, (_, k) => traces.time[position(traces, k)]);
  return [{ name: "time", values: time }, ...[...traces.values.keys()].map((name) => ({ name, values: between(traces, name, ends[0], ends[1]) }))];
}
