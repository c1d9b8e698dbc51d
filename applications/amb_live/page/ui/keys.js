// Shortcuts: those of the buttons with a `data-key`, whose titles say what they do, and of the paces.

import { make } from "./dom.js";

/**
 * @typedef {object} Shortcut
 * @property {string} key as the keyboard reports it
 * @property {string} what
 * @property {() => void} act
 */

/**
 * Listen to shortcuts, except during text input and in an open dialog, and list them in the help.
 * @param {HTMLElement} help
 * @param {readonly Shortcut[]} paces
 */
export function listenToKeys(help, paces) {
  const buttons = [...document.querySelectorAll("button")].filter((button) => button.dataset.key !== undefined);
  const shortcuts = [...buttons.map((button) => ({ key: button.dataset.key, what: button.title.replace(/ \(.*\)$/, ""), act: () => button.click() })), ...paces];
  help.replaceChildren(...shortcuts.flatMap((item) => [make("dt", {}, [make("kbd", { text: item.key === " " ? "space" : item.key?.toUpperCase() ?? "" })]), make("dd", { text: item.what })]),
    make("dt", { text: "arrow keys" }), make("dd", { text: "on an orbit: push; on the shaft: turn; on the time line: back and ahead" }));
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented || isTaken(event)) { return; }
    const shortcut = shortcuts.find((item) => item.key === event.key.toLowerCase());
    if (shortcut !== undefined) {
      event.preventDefault();
      shortcut.act();
    }
  });
}

/**
 * Whether a key belongs to the element that has the focus.
 * @param {KeyboardEvent} event
 */
function isTaken(event) {
  const { target } = event;
  if (document.querySelector("dialog[open]") !== null) { return true; }
  if (target instanceof HTMLInputElement && target.type !== "range" && target.type !== "checkbox") { return true; }
  if (target instanceof HTMLSelectElement) { return true; }
  const isPressable = target instanceof HTMLButtonElement || target instanceof HTMLInputElement || (target instanceof HTMLElement && target.tagName === "SUMMARY");
  return isPressable && (event.key === " " || event.key === "Enter");
}
