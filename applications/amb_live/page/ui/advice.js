// Advice on a choice of control that will not work, and which choice will.

import { matching, placesOfContact, plainLaw, settingOf, valueOf } from "./session.js";

/** @typedef {import("./session.js").Session} Session */

const AWARE = "Contact-aware";
const LASTING = 0.2; // s in contact, after which contact is sustained

/**
 * Return whether all amplifiers are off; false for a machine without amplifiers.
 * @param {Session} session
 */
export function isOff(session) {
  const names = matching(session, "amb_actuator.*.amplifier_off_?");
  return names.length > 0 && names.every((name) => settingOf(session, name) === 1);
}

/**
 * Return the time (s) since which no magnet has power; NaN if one has. It is -Infinity if none had any from the beginning.
 * @param {Session} session
 */
export function offSince(session) {
  if (!isOff(session)) { return NaN; }
  const { rig, userChanges } = session, half = 0.5 * rig.stepSize;
  const planned = userChanges.settings.events === false ? [] : rig.events;
  const set = [...planned.map(({ point, variable, value }) => ({ time: point * rig.stepSize, values: { [variable]: value } })), ...userChanges.changes];
  return Math.max(...matching(session, "amb_actuator.*.amplifier_off_?").map((name) => {
    let since = -Infinity, off = (userChanges.settings.values?.[name] ?? rig.inputs[name] ?? session.variables.get(name)?.start) === 1;
    for (const { time, values } of set.filter((one) => name in one.values && one.time < session.time + half).sort((a, b) => a.time - b.time)) {
      if (values[name] === 1 && !off) { since = time; }
      off = values[name] === 1;
    }
    return since;
  }));
}

/**
 * Return the sites and faces where the rotor is in contact now.
 * @param {Session} session
 */
export function touched(session) {
  return placesOfContact(session.rig.geometry).filter((name) => valueOf(session, `rotor_contact.${name}.mode`) > 0);
}

/**
 * Return how long (s) the rotor has been in contact at any site, regardless of gaps between impacts; 0 if it is free.
 * @param {Session} session
 * @param {number} [between] s, the longest gap between impacts
 */
export function contactTime({ contacts, time }, between = 0.05) {
  /** @type {Set<string>} */
  const closed = new Set();
  let began = NaN, ended = -Infinity;
  for (const item of contacts) {
    if (item.mode > 0) {
      if (closed.size === 0 && !(item.time - ended < between)) { began = item.time; }
      closed.add(item.site);
    } else if (closed.delete(item.site) && closed.size === 0) { ended = item.time; }
  }
  return closed.size > 0 || time - ended < between ? time - began || 0 : 0;
}

/**
 * Return advice on a choice of control that will not work, with a choice that will; null if it works.
 * @param {Session} session
 * @param {string} chosen label of the choice
 * @param {readonly string[]} options labels of all choices
 */
export function advice(session, chosen, options) {
  const lasts = contactTime(session) > LASTING, offers = (/** @type {string} */ label) => options.includes(label) && label !== chosen;
  if (lasts && (chosen === "ROLAC" || chosen === "OLAC") && offers(AWARE)) {
    return { option: AWARE, text: `During sustained contact ${chosen} relies on a table of the free rotor, and its force grows to its limit. ${AWARE} ROLAC allows for contact.` };
  }
  const plain = plainLaw(session), law = plain === "PID" ? plain : "linear controller";
  if (lasts && chosen === plain && offers(AWARE) && !isOff(session)) {
    return { option: AWARE, text: `The ${law} does not compensate unbalance, so a rub continues. ${AWARE} ROLAC removes the vibration.` };
  }
  if (chosen === "Off" && session.rig.geometry.sites.length === 0 && offers(plain)) {
    return { option: plain, text: `This rotor has no retainers: without magnets it leaves its bearings. The ${law} holds it.` };
  }
  return null;
}
