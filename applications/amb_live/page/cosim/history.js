// Snapshots of a run, evenly spaced from its beginning to now: few steps lead to any earlier time, and memory is limited.

/**
 * A snapshot, and the points since which conditions have been met, see `stopping.js`.
 * @typedef {{ snapshot: import("./assembly.js").Snapshot, since: number[] }} Moment
 */

const MAX_MOMENTS = 64; // moments of half a megabyte each; at this number, every second one is discarded

export class History {
  /**
   * @param {Pick<import("./assembly.js").Assembly, "point" | "snapshot" | "discard">} assembly
   * @param {number} every points between two moments, at first
   */
  constructor(assembly, every) {
    this.assembly = assembly;
    this.every = every;
    /** @type {Moment[]} */
    this.moments = []; // ascending
  }

  /** Save the present moment if it is due. @param {readonly number[]} since */
  keep(since) {
    const { moments, every, assembly } = this, latest = moments.at(-1)?.snapshot.point ?? -Infinity;
    if (assembly.point < 0 || assembly.point <= latest || (assembly.point % every !== 0 && moments.length > 0)) { return; }
    moments.push({ snapshot: assembly.snapshot(), since: [...since] });
    if (moments.length >= MAX_MOMENTS) {
      this.every = 2 * every;
      moments.filter((_, k) => k % 2 === 1).forEach(({ snapshot }) => assembly.discard(snapshot));
      this.moments = moments.filter((_, k) => k % 2 === 0);
    }
  }

  /** Discard the moments after a point, and return the last remaining one, if any. @param {number} point */
  backTo(point) {
    const { moments } = this;
    while (moments.length > 0 && moments[moments.length - 1].snapshot.point > point) {
      this.assembly.discard(/** @type {Moment} */ (moments.pop()).snapshot);
    }
    return moments.at(-1);
  }
}
