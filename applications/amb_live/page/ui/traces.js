// Computed samples in a ring buffer for each signal, and the curves that are drawn or saved of them.

/** Samples of several signals over time, the newest `capacity` of them. */
export class Traces {
  /**
   * @param {readonly string[]} names
   * @param {number} capacity
   */
  constructor(names, capacity) {
    this.capacity = capacity;
    this.count = 0; // stored samples
    this.next = 0; // index of the next sample
    this.time = new Float64Array(capacity); // s
    this.values = new Map(names.map((name) => [name, new Float32Array(capacity)]));
  }

  /** Append samples stored row by row: time, then a column for each signal. @param {Float64Array} rows */
  append(rows) {
    const columns = [...this.values.values()];
    const width = columns.length + 1;
    for (let at = 0; at < rows.length; at += width) {
      this.time[this.next] = rows[at];
      for (let k = 0; k < columns.length; k++) { columns[k][this.next] = rows[at + k + 1]; }
      this.next = (this.next + 1) % this.capacity;
      this.count = Math.min(this.count + 1, this.capacity);
    }
  }

  /** Remove the samples after a time. @param {number} time s */
  truncate(time) {
    while (this.count > 0 && this.time[this.position(this.count - 1)] > time + 1e-9) {
      this.next = (this.next + this.capacity - 1) % this.capacity;
      this.count -= 1;
    }
  }

  /** Return the index of sample `k`, counted from the oldest, in the rings. @param {number} k */
  position(k) {
    return (this.next - this.count + k + 2 * this.capacity) % this.capacity;
  }

  /** Return the number of the first sample at or after a time; `count` without any. @param {number} time s */
  firstAt(time) {
    let low = 0, high = this.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time[this.position(middle)] < time) { low = middle + 1; } else { high = middle; }
    }
    return low;
  }

  /**
   * Return the samples of a signal between two times (s), in order.
   * @param {string} name
   * @param {number} from
   * @param {number} to
   */
  between(name, from, to) {
    const ring = this.values.get(name), first = this.firstAt(from), end = this.firstAt(to + 1e-9);
    const values = new Float32Array(ring === undefined ? 0 : Math.max(end - first, 0));
    for (let k = 0; ring !== undefined && k < values.length; k++) { values[k] = ring[this.position(first + k)]; }
    return values;
  }

  /**
   * Return the largest mean of a signal over a time window, of the samples between two times; 0 without any.
   *
   * A value is the mean over the step that ends at its sample. Steps that end before `from` count as zero.
   * @param {string} name
   * @param {number} from s
   * @param {number} to s
   * @param {number} window s
   */
  largestMean(name, from, to, window) {
    const ring = this.values.get(name), first = Math.max(this.firstAt(from), 1), end = this.firstAt(to + 1e-9);
    let largest = 0;
    for (let k = first; ring !== undefined && k < end; k++) {
      let sum = 0, left = window;
      for (let j = k; j >= first && left > 1e-12; j--) {
        const step = Math.min(this.time[this.position(j)] - this.time[this.position(j - 1)], left);
        sum += step * ring[this.position(j)];
        left -= step;
      }
      largest = Math.max(largest, sum / window);
    }
    return largest;
  }

  /**
   * Return curves of at most two points for each of `buckets` equal intervals, their extremes, which look like all samples:
   * times, then the values of each signal. The buckets lie on a fixed grid of time, so that a scrolling curve does not shimmer.
   * @param {readonly string[]} names
   * @param {number} from s
   * @param {number} to s
   * @param {number} buckets
   * @param {readonly number[]} scales factor of each signal
   */
  thinned(names, from, to, buckets, scales) {
    const first = this.firstAt(from), end = this.firstAt(to + 1e-9);
    const rings = names.map((name) => this.values.get(name));
    /** @type {number[][]} */
    const curves = [[], ...names.map(() => /** @type {number[]} */ ([]))];
    const width = (to - from) / buckets;
    if (end - first <= 2 * buckets) {
      for (let k = first; k < end; k++) {
        const at = this.position(k);
        curves[0].push(this.time[at]);
        rings.forEach((ring, i) => curves[i + 1].push(ring === undefined ? NaN : scales[i] * ring[at]));
      }
      return curves;
    }
    for (let k = first; k < end;) {
      const bucket = Math.floor(this.time[this.position(k)] / width);
      let stop = k;
      while (stop < end && Math.floor(this.time[this.position(stop)] / width) === bucket) { stop += 1; }
      curves[0].push((bucket + 0.25) * width, (bucket + 0.75) * width);
      rings.forEach((ring, i) => curves[i + 1].push(...(ring === undefined ? [NaN, NaN] : this.extremes(ring, k, stop).map((value) => scales[i] * value))));
      k = stop;
    }
    return curves;
  }

  /**
   * Return the smallest and the largest of some samples in the order in which they occur.
   * @param {Float32Array} ring
   * @param {number} first
   * @param {number} end
   */
  extremes(ring, first, end) {
    let low = Infinity, high = -Infinity, lowAt = first, highAt = first;
    for (let k = first; k < end; k++) {
      const value = ring[this.position(k)];
      if (value < low) { low = value; lowAt = k; }
      if (value > high) { high = value; highAt = k; }
    }
    return lowAt <= highAt ? [low, high] : [high, low];
  }

  /**
   * Return all samples as columns, time first.
   * @returns {{ name: string, values: Float64Array | Float32Array }[]}
   */
  columns() {
    const places = Array.from({ length: this.count }, (_, k) => this.position(k));
    const signals = [...this.values].map(([name, ring]) => ({ name, values: Float32Array.from(places, (k) => ring[k]) }));
    return [{ name: "time", values: Float64Array.from(places, (k) => this.time[k]) }, ...signals];
  }
}
