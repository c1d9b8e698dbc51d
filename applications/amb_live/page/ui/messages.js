// What the page says in words: a failure, a notice that goes by itself, what waits for a new start, and what happened.

import { byId, make, setText } from "./dom.js";

const READ = 8000; // ms that a notice stays
const MOST = 30; // messages that are stored

let noticeEnds = 0;

/**
 * Show what failed or was refused, in plain sight.
 * @param {string} text empty for nothing
 */
export function showFailure(text) {
  const box = byId("failure", HTMLElement);
  box.hidden = text === "";
  setText(box, text);
}

/** @param {string} text */
export function showNotice(text) {
  const box = byId("notice", HTMLElement);
  box.hidden = false;
  setText(box, text);
  noticeEnds = performance.now() + READ;
}

/** Take a notice away after long enough. @param {number} now ms */
export function endNotice(now) {
  if (now > noticeEnds) { byId("notice", HTMLElement).hidden = true; }
}

/**
 * Add what happened, or what an FMU logged, to the list of messages, the newest first; some are known only later.
 * @param {string} source the component, or when
 * @param {string} text
 * @param {number} time s
 */
export function addMessage(source, text, time) {
  const list = byId("log", HTMLOListElement);
  const next = [...list.children].find((item) => item instanceof HTMLElement && Number(item.dataset.time) <= time);
  list.insertBefore(make("li", { "data-time": String(time) }, [make("b", { text: source }), ` ${text}`]), next ?? null);
  while (list.children.length > MOST) { list.lastElementChild?.remove(); }
}

/** Forget what happened, or only what happened after a time. @param {number} [after] s */
export function clearMessages(after = -Infinity) {
  for (const item of [...byId("log", HTMLOListElement).children]) {
    if (item instanceof HTMLElement && Number(item.dataset.time) > after) { item.remove(); }
  }
}

/**
 * Say what waits for a new start; nothing without a name.
 * @param {readonly string[]} names of fixed parameters
 * @param {() => void} reset
 * @param {() => void} forget
 */
export function showPending(names, reset, forget) {
  const box = byId("pending", HTMLElement);
  box.hidden = names.length === 0;
  const listed = names.length > 3 ? `${names.slice(0, 2).join(", ")} and ${names.length - 2} more` : names.join(", ");
  const now = make("button", { type: "button", id: "apply", text: "Reset with it (R)" }), drop = make("button", { type: "button", text: "Forget" });
  now.addEventListener("click", reset);
  drop.addEventListener("click", forget);
  box.replaceChildren(make("span", { text: `${listed} takes effect when the run is reset.` }), now, drop);
}
