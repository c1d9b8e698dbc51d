// What bounds the curves: the clearances, the currents of the controller, the forces that the magnets can pull with.

import { numberText } from "./format.js";
import { settingOf } from "./session.js";

/** @typedef {import("./session.js").Session} Session */

const MU_0 = 4e-7 * Math.PI; // H/m

/**
 * Return the limits of the control currents (A), from the least.
 * @param {Session} session
 */
export function currentLimits(session) {
  return distinct(axesOf(session).flatMap(([bearing, axis]) => ["i_min", "i_max"].map((name) => settingOf(session, `rolac_controller.${bearing}.${name}_${axis}`))));
}

/**
 * Return the least and the largest forces (N) of the magnets at their centres, from the least.
 *
 *     P = B^2 A_e cos(phi)/mu_0,   B = min(B_sat, mu_0 N I_max/l);   -P - F_0 <= F <= P - F_0             (2.6)
 *
 * F_0 is the static load, which a force without its static part leaves out.
 * @param {Session} session
 */
export function forceLimits(session) {
  return distinct(axesOf(session).flatMap(([bearing, axis]) => {
    const of = (/** @type {string} */ name) => settingOf(session, `amb_actuator.${bearing}.${name}_${axis}`);
    const perAmpere = MU_0 * of("turns") / of("gap"), square = of("pole_area") * Math.cos(of("half_angle")) / MU_0;
    const most = square * Math.min(of("b_sat") || Infinity, perAmpere * of("current_limit")) ** 2;
    const bias = of("bias_current"), isWhole = settingOf(session, "amb_actuator.total_force") === 1;
    const load = isWhole ? 0 : square * perAmpere ** 2 * ((of("static_current") + bias) ** 2 - bias ** 2);
    return [-most - load, most - load];
  }));
}

/**
 * Return limits in words: each once, and ± where both signs have the same.
 * @param {string} name of them
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
