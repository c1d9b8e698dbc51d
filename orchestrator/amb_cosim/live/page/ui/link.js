// A link that holds the scenario and what was done, in the part of the address that no server sees.

/** @typedef {import("../protocol.js").Deed} Deed */

/**
 * Return the part after `#` for a scenario and what was done.
 * @param {string} scenario
 * @param {Deed} deed
 * @returns {string}
 */
export function toFragment(scenario, deed) {
  const isPlain = Object.keys(deed.settings).length === 0 && deed.changes.length === 0;
  return `rig=${encodeURIComponent(scenario)}${isPlain ? "" : `&deed=${encodeURIComponent(JSON.stringify(deed))}`}`;
}

/**
 * Return what a link holds; null if it holds no rig.
 * @param {string} fragment with or without `#`
 * @returns {{ scenario: string, deed: Deed | undefined } | null}
 * @throws {Error} if what it says was done cannot be read
 */
export function fromFragment(fragment) {
  const parts = new URLSearchParams(fragment.replace(/^#/, ""));
  const scenario = parts.get("rig"), text = parts.get("deed");
  if (scenario === null) { return null; }
  if (text === null) { return { scenario, deed: undefined }; }
  /** @type {unknown} */
  const deed = JSON.parse(text);
  if (!isDeed(deed)) { throw new Error("the link is damaged: it does not say what was done"); }
  return { scenario, deed };
}

/**
 * @param {unknown} value
 * @returns {value is Deed}
 */
function isDeed(value) {
  if (typeof value !== "object" || value === null || !("settings" in value) || !("changes" in value)) { return false; }
  return typeof value.settings === "object" && value.settings !== null && Array.isArray(value.changes)
    && value.changes.every((change) => Number.isInteger(change?.point) && typeof change.values === "object");
}
