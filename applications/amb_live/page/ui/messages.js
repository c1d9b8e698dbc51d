// Messages of the page: a failure, a notice that disappears, changes that wait for a reset, and events.

import { byId, make, setText } from "./dom.js";

const NOTICE_MS = 8000; // for which a notice stays
const MAX_MESSAGES = 30; // messages that are stored

let noticeEnds = 0;

/**
 * Show why something failed or was refused.
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
  noticeEnds = performance.now() + NOTICE_MS;
}

/** Hide a notice after its time. @param {number} now ms */
export function endNotice(now) {
  if (now > noticeEnds) { byId("notice", HTMLElement).hidden = true; }
}

/**
 * Add an event, or a message of an FMU, to the list, the latest first; some arrive late.
 * @param {string} source the component, or the time
 * @param {string} text
 * @param {number} time s
 */
export function addMessage(source, text, time) {
  const list = byId("log", HTMLOListElement);
  const next = [...list.children].find((item) => item instanceof HTMLElement && Number(item.dataset.time) <= time);
  list.insertBefore(make("li", { "data-time": String(time) }, [make("b", { text: source }), ` ${text}`]), next ?? null);
  while (list.children.length > MAX_MESSAGES) { list.lastElementChild?.remove(); }
}

/** Remove all messages, or only those after a time. @param {number} [after] s */
export function clearMessages(after = -Infinity) {
  for (const item of [...byId("log", HTMLOListElement).children]) {
    if (item instanceof HTMLElement && Number(item.dataset.time) > after) { item.remove(); }
  }
}

/**
 * Show which changes wait for a reset; hidden without names.
 * @param {readonly string[]} names of fixed parameters
 * @param {() => void} reset
 * @param {() => void} forget
 */
export function showPending(names, reset, forget) {
  const box = byId("pending", HTMLElement);
  box.hidden = names.length === 0;
  const listed = names.length > 3 ? `${names.slice(0, 2).join(", ")} and ${names.length - 2} more` : names.join(", ");
  const isOne = names.length === 1;
  const apply = make("button", { type: "button", id: "apply", text: `Reset with ${isOne ? "it" : "them"} (R)` }), drop = make("button", { type: "button", text: "Forget" });
  apply.addEventListener("click", reset);
  drop.addEventListener("click", forget);
  box.replaceChildren(make("span", { text: `${listed} ${isOne ? "takes" : "take"} effect when the run is reset.` }), apply, drop);
}
