// Changes by hand: what holds at once, what waits for a new start, and how a control says which.

import { make } from "./dom.js";
import { effectOf, settingOf } from "./session.js";

/** @typedef {import("./session.js").Session} Session */

/**
 * What the controls ask for.
 * @typedef {object} Changes
 * @property {(values: Record<string, number>) => void} set at once
 * @property {(values: Record<string, number>) => void} plan for the next start
 * @property {(speed: number, acceleration: number) => void} speed
 * @property {(disc: string, force: [number, number]) => void} push
 * @property {() => void} run unless it runs
 * @property {() => Readonly<Record<string, number>>} planned
 */

/** Updates a control from what holds. @typedef {(session: Session) => void} Update */

/** A control: what is in the panel, and what updates it. @typedef {{ element: HTMLElement, update: Update }} Control */

/**
 * Send values: those of fixed parameters wait for a new start, with all that belongs to them; others hold at once.
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
