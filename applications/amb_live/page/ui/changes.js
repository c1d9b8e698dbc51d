// Changes by the user: which take effect at once, which at the next reset, and the badge that says so.

import { make } from "./dom.js";
import { effectOf, settingOf } from "./session.js";

/** @typedef {import("./session.js").Session} Session */

/**
 * Functions that the controls call.
 * @typedef {object} Changes
 * @property {(values: Record<string, number>) => void} set at once
 * @property {(values: Record<string, number>) => void} plan for the next start
 * @property {(speed: number, acceleration: number) => void} speed
 * @property {(disc: string, force: [number, number]) => void} push
 * @property {() => void} run unless it runs
 * @property {() => Readonly<Record<string, number>>} planned
 */

/** Updates a control from the present values. @typedef {(session: Session) => void} Update */

/** A control: its element in the panel, and the function that updates it. @typedef {{ element: HTMLElement, update: Update }} Control */

/**
 * Send values. If any is a fixed parameter that changes, all wait for the next reset; otherwise they apply at once.
 * @param {Session} session
 * @param {Changes} changes
 * @param {Record<string, number>} values
 */
export function apply(session, changes, values) {
  const isLive = (/** @type {string} */ name) => effectOf(session, name) === "live";
  const differs = (/** @type {string} */ name) => settingOf(session, name) !== values[name] || name in changes.planned();
  if (Object.keys(values).some((name) => !isLive(name) && differs(name))) {
    changes.plan(values);
  } else {
    changes.set(Object.fromEntries(Object.entries(values).filter(([name]) => isLive(name))));
  }
}

/**
 * Return the badge that says when a change of a variable takes effect.
 * @param {Session} session
 * @param {string} name
 */
export function effectBadge(session, name) {
  const effect = effectOf(session, name), variable = session.variables.get(name);
  const kind = variable === undefined ? "" : `${variable.variability} ${variable.causality}`;
  return make("span", { class: `badge ${effect}`, title: kind, text: effect === "live" ? "now" : "reset" });
}
