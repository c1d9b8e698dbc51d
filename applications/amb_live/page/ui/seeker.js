// Going to a time: one request after another, however fast the handle of the time line is dragged.

/** @typedef {import("./session.js").Session} Session */

/**
 * @typedef {object} Seeker
 * @property {(time: number, keep: boolean) => void} go to a time (s); of several during a request, only the last is used
 * @property {() => void} heard call it after each answer of the worker
 * @property {() => void} drop forget the requested time, as when something else is requested
 */

/**
 * Return a seeker.
 * @param {() => Session} current
 * @param {(request: import("../protocol.js").Request) => void} send
 */
export function makeSeeker(current, send) {
  /** @type {number | null} */
  let goal = null;
  /** @type {{ time: number, keep: boolean } | null} */
  let next = null;
  const isAt = (/** @type {number} */ time) => Math.abs(current().time - time) < 0.6 * current().rig.stepSize;
  const go = (/** @type {number} */ time, /** @type {boolean} */ keep) => {
    if (goal !== null) {
      next = { time, keep };
    } else if (!isAt(time)) {
      goal = time;
      send(time < current().time ? { type: "rewind", time, keep } : { type: "run", to: time });
    }
  };
  return {
    go,
    drop: () => { [goal, next] = [null, null]; },
    heard: () => {
      const { status } = current();
      if (goal === null || (status !== "failed" && !(status === "paused" && isAt(goal)))) { return; }
      const following = next;
      [goal, next] = [null, null];
      if (following !== null && status !== "failed") { go(following.time, following.keep); }
    },
  };
}
