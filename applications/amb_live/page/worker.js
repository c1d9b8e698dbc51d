// The worker: passes requests to a session, which computes in slices between them.

import { Session } from "./engine/session.js";

const PAUSE_MS = 4; // between slices while the run is on time

const scope = /** @type {{ postMessage: (message: unknown, transfer?: ArrayBuffer[]) => void, onmessage: unknown }} */ (
  /** @type {unknown} */ (globalThis));
const session = new Session((answer, transfer = []) => scope.postMessage(answer, transfer));
const channel = new MessageChannel(); // its messages arrive after those of the page that are waiting
let due = false;

function slice() {
  due = false;
  const now = performance.now(), isLate = session.work(now, () => performance.now());
  if (session.course) { schedule(isLate); }
}

/** @param {boolean} atOnce */
function schedule(atOnce) {
  if (due) { return; }
  due = true;
  if (atOnce) { channel.port2.postMessage(0); } else { setTimeout(slice, PAUSE_MS); }
}

channel.port1.onmessage = slice;
scope.onmessage = (/** @type {MessageEvent<import("./protocol.js").Request>} */ { data }) => {
  session.handle(data, performance.now());
  if (session.course) { schedule(true); }
};
