// Messages on what happens: contact that begins, rolls and ends, events of the scenario, limits that are reached.

import { nameLabel, quantityText } from "./format.js";
import { valueOf } from "./session.js";

/** @typedef {import("./session.js").Session} Session */

/** Something that happened. @typedef {{ time: number, text: string }} Notice */

/**
 * State of the reports so far.
 * @typedef {object} Narrator
 * @property {number} time time up to which everything is reported (s)
 * @property {number} seen number of contact events processed
 * @property {Map<string, { mode: number, since: number, reported: number }>} sites present mode of each, since when, and the mode reported last
 * @property {number} limited time at which currents were at their limit last (s)
 */

const CALM = 0.05; // s without another change of contact, after which its state is reported
const AGAIN = 0.3; // s without a limit, after which the next one is reported

/** @returns {Narrator} */
export function newNarrator() {
  return { time: -Infinity, seen: 0, sites: new Map(), limited: -Infinity };
}

/**
 * Return notices of what happened since the last call. After going back in time, events are reported again.
 * @param {Narrator} narrator
 * @param {Session} session
 */
export function narrate(narrator, session) {
  if (session.time < narrator.time || session.contacts.length < narrator.seen) { goBack(narrator, session); }
  if (session.status === "loading" || session.status === "settling") { return []; }
  const notices = [...planned(session, narrator.time), ...contacts(narrator, session), ...limits(narrator, session)];
  narrator.time = session.time;
  return notices.sort((a, b) => a.time - b.time);
}

/**
 * Mark the contacts up to the present as reported.
 * @param {Narrator} narrator
 * @param {Session} session
 */
function goBack(narrator, session) {
  Object.assign(narrator, { time: session.time, seen: session.contacts.length, limited: -Infinity });
  narrator.sites.clear();
  for (const { site, mode, time } of session.contacts) { narrator.sites.set(site, { mode, since: time, reported: mode }); }
}

/** @param {Narrator} narrator @param {Session} session */
function contacts(narrator, session) {
  /** @type {Notice[]} */
  const notices = [];
  for (const { site, mode, time } of session.contacts.slice(narrator.seen)) {
    const contact = narrator.sites.get(site) ?? { mode: 0, since: time, reported: 0 };
    if (mode > 0 && contact.reported === 0) {
      notices.push({ time, text: `the rotor touches ${nameLabel(site)}` });
      contact.reported = 1;
    }
    narrator.sites.set(site, { ...contact, mode, since: time });
  }
  narrator.seen = session.contacts.length;
  for (const [site, contact] of narrator.sites) {
    if (session.time - contact.since > CALM && contact.mode !== contact.reported) {
      notices.push({ time: contact.since, text: calmText(nameLabel(site), contact.mode) });
      contact.reported = contact.mode;
    }
  }
  return notices;
}

/** @param {string} site @param {number} mode */
function calmText(site, mode) {
  if (mode === 0) { return `the rotor is free of ${site}`; }
  return mode === 2 ? `the rotor rolls on ${site}` : `the rotor slides in ${site}`;
}

/**
 * Return the events of the scenario after a time and up to the present, each moment once.
 * @param {Session} session
 * @param {number} after s
 */
function planned({ rig, userChanges, time, variables }, after) {
  /** @type {Map<number, string[]>} */
  const moments = new Map();
  for (const { point, variable, value, label } of userChanges.settings.events === false ? [] : rig.events) {
    const at = point * rig.stepSize;
    if (at <= after || at > time || at < 0) { continue; }
    const [, place, name] = /^[^.]*\.(?:(.*)\.)?([^.]*)$/.exec(variable) ?? ["", "", "", variable];
    const what = `${name}${place ? ` of ${nameLabel(place)}` : ""} becomes ${valueText(value, variables.get(variable)?.unit ?? "")}`;
    const words = moments.get(point) ?? [];
    moments.set(point, [...words, words.length === 0 && label !== "" ? `${label}: ${what}` : what]);
  }
  return [...moments].map(([point, words]) => {
    const text = words.length > 2 ? `${words[0]}, and ${words.length - 1} more` : words.join(", ");
    return { time: point * rig.stepSize, text };
  });
}

/**
 * Return a value with its unit: an unbalance in g m or g mm.
 * @param {number} value
 * @param {string} unit
 */
function valueText(value, unit) {
  if (unit !== "kg.m") { return quantityText(value, unit); }
  return Math.abs(value) < 1e-4 ? quantityText(1e6 * value, "g mm") : quantityText(1e3 * value, "g m");
}

/** @param {Narrator} narrator @param {Session} session */
function limits(narrator, session) {
  const flags = ["rolac_controller.current_limited", "rolac_controller.demand_limited", "linear_controller.demand_limited"];
  if (!flags.some((name) => valueOf(session, name) === 1)) { return []; }
  const isNew = session.time - narrator.limited > AGAIN;
  narrator.limited = session.time;
  return isNew ? [{ time: session.time, text: "a control current is at its limit" }] : [];
}
