// Shortcuts: one list for what they do and for the help that tells them.

/**
 * @typedef {object} Shortcut
 * @property {string} key as the keyboard reports it
 * @property {string} shown
 * @property {string} what
 * @property {() => void} act
 */

/**
 * Listen to shortcuts, except while something is typed or held.
 * @param {readonly Shortcut[]} shortcuts
 */
export function listenToKeys(shortcuts) {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented || isTaken(event)) { return; }
    const found = shortcuts.find((one) => one.key === event.key.toLowerCase());
    if (found !== undefined) {
      event.preventDefault();
      found.act();
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
