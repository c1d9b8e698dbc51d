// What bounds the curves: the clearances, and the currents of the controller.

import { numberText } from "./format.js";
import { settingOf } from "./session.js";

/** @typedef {import("./session.js").Session} Session */

/**
 * Return the limits of the control currents (A), from the least.
 * @param {Session} session
 */
export function currentLimits(session) {
  return distinct(axesOf(session).flatMap(([bearing, axis]) => ["i_min", "i_max"].map((name) => settingOf(session, `rolac_controller.${bearing}.${name}_${axis}`))));
}

/**
 * Return limits as text: each once, with ± where both signs occur.
 * @param {string} name of all
 * @param {readonly number[]} limits in the displayed unit
 */
export function limitsText(name, limits) {
  const texts = distinct(limits).map((item) => numberText(item, 3)), isBoth = (/** @type {string} */ text) => texts.includes(`\u2212${text}`);
  const parts = texts.filter((text) => !(text.startsWith("\u2212") && texts.includes(text.slice(1)))).map((text) => `${isBoth(text) ? "±" : ""}${text}`);
  return parts.length > 0 ? `${name} ${parts.join(", ")}` : "";
}

/** @param {Session} session @returns {[string, string][]} */
function axesOf(session) {
  return session.rig.geometry.bearings.filter((item) => item.magnetic).flatMap(({ name }) => /** @type {[string, string][]} */ ([[name, "x"], [name, "y"]]));
}

/** @param {readonly number[]} limits @returns {number[]} */
function distinct(limits) {
  return [...new Set(limits.filter(Number.isFinite).map((item) => Number(item.toPrecision(4))))].sort((a, b) => a - b);
}
