// Three guided experiments: for each step the instruction, the test whether it is done, and the remark on the result.

import { contactTime, isOff, offSince, touched } from "./advice.js";
import { nameLabel, numberText, quantityText } from "./format.js";
import { shownSites } from "./orbits.js";
import { CONTACT_WINDOW, matching, placesOfContact, plainLaw, settingOf, valueOf } from "./session.js";

/** @typedef {import("./session.js").Session} Session */

/**
 * Observations since the step of an experiment began.
 * @typedef {object} Notes
 * @property {number} began s
 * @property {number} seen time up to which the samples were observed (s)
 * @property {number} before the same before the newest frame (s)
 * @property {number} reach largest displacement over clearance
 * @property {number} force largest contact force: the mean over 1 ms, with impacts (N)
 * @property {boolean} touched
 * @property {number} touchedAt time of the first contact (s); NaN without any
 * @property {number} since time since which the condition holds without a break (s); NaN while it does not
 */

/**
 * A step: its instruction, the condition that completes it, how long this must hold (s), the remark afterwards, and the time
 * from which it counts (s), if that is before the step is shown.
 * @typedef {object} Step
 * @property {(session: Session) => string} instruction
 * @property {(session: Session, notes: Notes) => boolean} isMet
 * @property {number} hold
 * @property {(session: Session, notes: Notes) => string} remark
 * @property {(session: Session) => number} [begins]
 */

/** `suits`: whether the scenario performs it by itself. @typedef {{ title: string, suits: boolean, steps: Step[] }} Experiment */

const places = (/** @type {readonly string[]} */ names) => names.map(nameLabel).join(" and ");
const percent = (/** @type {number} */ share) => `${numberText(100 * share, 2)} %`;

/**
 * Return whether no gravity pulls the rotor down: without power, its unbalance throws it out, and it does not land.
 * @param {Session} session
 */
const isWeightless = (session) => settingOf(session, "rotor_contact.gravity") === 0;

/** @param {Session} session */
function isPushed(session) {
  return session.rig.geometry.discs.some(({ name }) => ["x", "y"].some((axis) => Math.abs(valueOf(session, `rotor_contact.${name}.f_${axis}`)) > 0));
}

const TRAPPED = 10; // turns in contact, as in the verdict on a run

/** @param {Session} session */
function isTrapped(session) {
  const turns = contactTime(session) * Math.abs(valueOf(session, "rotor_contact.speed")) / (2 * Math.PI);
  return turns >= TRAPPED && !isOff(session);
}

/** @param {number} now s @returns {Notes} */
export function newNotes(now) {
  return { began: now, seen: now, before: now, reach: 0, force: 0, touched: false, touchedAt: NaN, since: NaN };
}

/**
 * Return the notes of the step after one that a frame completed: they begin with what happened since the frame before.
 *
 * On a slow computer one frame shows both the loss of power and the impact. Nothing changes before time 0.
 * @param {Notes} notes @returns {Notes}
 */
export function nextNotes(notes) {
  return newNotes(Math.max(notes.before, 0));
}

/**
 * Return the samples of a signal since the last observation, and its newest value.
 * @param {Session} session
 * @param {Notes} notes
 * @param {string} name
 */
function observed(session, notes, name) {
  return [...session.traces.between(name, notes.seen, session.time), valueOf(session, name)];
}

/**
 * Update the observations by every computed sample since the last ones, and return whether a step is done.
 *
 * Frames show one sample of many: how many depends on the computer.
 * @param {Step} step
 * @param {Notes} notes
 * @param {Session} session
 */
export function follow(step, notes, session) {
  if (session.time < notes.began) { Object.assign(notes, newNotes(session.time)); }
  if (session.status === "loading" || session.status === "settling") { return false; }
  const begins = Math.max(step.begins?.(session) ?? NaN, 0); // nothing changes before time 0
  if (begins < notes.began) { Object.assign(notes, newNotes(begins)); }
  for (const site of shownSites(session)) {
    const clearance = settingOf(session, `rotor_contact.${site.name}.clearance`), y = observed(session, notes, site.y);
    observed(session, notes, site.x).forEach((x, k) => { notes.reach = Math.max(notes.reach, Math.hypot(x, y[k]) / clearance || 0); });
  }
  for (const name of placesOfContact(session.rig.geometry)) {
    const before = Math.max(notes.seen - CONTACT_WINDOW, notes.began); // a mean may begin before the last observation
    notes.force = Math.max(notes.force, session.traces.largestMean(`rotor_contact.${name}.f_n_mean`, before, session.time, CONTACT_WINDOW));
  }
  const first = session.contacts.find((item) => item.mode > 0 && item.time >= notes.began && item.time <= session.time);
  if (!notes.touched && (first !== undefined || touched(session).length > 0)) {
    const before = new Map(session.contacts.filter((item) => item.time < notes.began).map((item) => [item.site, item.mode]));
    const already = [...before.values()].some((mode) => mode > 0);
    Object.assign(notes, { touched: true, touchedAt: already ? notes.began : first?.time ?? session.time });
  }
  [notes.before, notes.seen] = [notes.seen, session.time];
  if (!step.isMet(session, notes)) {
    notes.since = NaN;
    return false;
  }
  if (Number.isNaN(notes.since)) { notes.since = session.time; }
  return session.time - notes.since >= step.hold;
}

/**
 * Return the experiments that a rig can do.
 * @param {Session} session
 */
export function experimentsOf(session) {
  const { discs, sites } = session.rig.geometry, canPush = discs.some((item) => item.unbalance) && sites.length > 0;
  const canLand = matching(session, "amb_actuator.*.amplifier_off_?").length > 0 && sites.length > 0;
  const canTrap = discs.some((item) => item.unbalance) && sites.length > 0;
  return [...(canPush ? [push()] : []), ...(canTrap ? [trap(session)] : []), ...(canLand ? [land(session)] : [])];
}

/** @returns {Experiment} */
function push() {
  return {
    title: "Levitate and push", suits: false,
    steps: [
      {
        instruction: (now) => `Run it (space). ${isOff(now) ? `No magnet has power: the rotor ${isWeightless(now) ? "drifts or rubs on" : "falls or lies on"} its retainers` : "Nothing touches the rotor: magnets hold it, and its unbalance moves it around its orbit"}. The circle is the clearance of a retainer.`,
        isMet: (session) => session.status === "playing" || session.time > 0.01, hold: 0.05,
        remark: (session, notes) => (notes.touched ? `It rotates, and touches ${places(touched(session)) || "now and then"}.` : `It rotates freely, within ${percent(notes.reach)} of the clearance.`),
      },
      {
        instruction: () => "Push it: drag within an orbit, or focus an orbit and hold an arrow key. A slow pace shows more.",
        isMet: isPushed, hold: 0, remark: (now) => (isOff(now) ? `No magnet has power: only retainers and inertia resist. Choose Controller, ${plainLaw(now)} to levitate it.` : "The magnets answer with more current; look at Signals."),
      },
      {
        instruction: () => "Let go, and watch it come back.",
        isMet: (session) => !isPushed(session), hold: 0.15,
        remark: (session, notes) => {
          const sites = touched(session);
          if (isOff(session)) {
            const [lies, falls] = isWeightless(session) ? ["is in contact with", "touches"] : ["lies on", "falls"];
            return sites.length > 0 ? `It ${lies} ${places(sites)}: without power nothing lifts it.` : `It moves freely until it ${falls}: without power nothing holds it.`;
          }
          if (sites.length > 0) { return `It stays in contact at ${places(sites)}: that is the next experiment.`; }
          return notes.touched ? `It touched with a force of up to ${quantityText(notes.force, "N")}, and is free again.` : `It came back without contact, from ${percent(notes.reach)} of the clearance. Push harder?`;
        },
      },
    ],
  };
}

/** @param {Session} session @returns {Experiment} */
function trap({ rig, variables }) {
  const coming = rig.events.find(({ variable, value }) => /^rotor_contact\.[^.]+\.u$/.test(variable) && value > 0);
  const has = variables.has("rolac_controller.rolac_enable");
  const byItself = coming === undefined ? "" : ` The scenario does so itself at ${quantityText(coming.point * rig.stepSize, "s")}.`;
  return {
    title: "Trap and free", suits: false,
    steps: [
      {
        instruction: (now) => (isOff(now) ? `No magnet has power: ${isWeightless(now) ? "nothing centres the rotor, so contact that lasts is not a trap" : "a rotor on its retainers is landed, not trapped"}. Choose Controller, ${plainLaw(now)} first. ` : "") + `With a plain controller, increase an unbalance (Controls, Unbalance) until the rotor touches and stays in contact.${byItself}`,
        isMet: isTrapped, hold: 0,
        remark: (session, notes) => `It is trapped in contact at ${places(touched(session)) || "its retainers"}, with a force of up to ${quantityText(notes.force, "N")}: the rub sustains itself.`,
      },
      {
        instruction: () => `Free it: ${has ? "choose another controller, or " : ""}reduce the unbalance, or change a gain.`,
        isMet: (session) => contactTime(session) === 0, hold: 0.1,
        remark: (session, notes) => `Free after ${quantityText(session.time - notes.began, "s")}. Go back on the time line and try another way.`,
      },
    ],
  };
}

/** @param {Session} session @returns {Experiment} */
function land(session) {
  const { rig } = session, fall = isWeightless(session) ? "This scenario has no gravity; add it (Gravity and drop), and switch" : "Switch";
  const coming = rig.events.find(({ variable, value }) => /\.amplifier_off_[xy]$/.test(variable) && value > 0);
  const byItself = coming === undefined ? "" : ` The scenario does so itself at ${quantityText(coming.point * rig.stepSize, "s")}.`;
  return {
    title: "Land", suits: coming !== undefined || isOff(session),
    steps: [
      {
        instruction: () => `${fall} the magnets off: Controller, Off. A pace of 1/100 shows the fall.${byItself}`,
        isMet: isOff, hold: 0, remark: () => "No magnet pulls the rotor any more.",
      },
      {
        instruction: (now) => (isWeightless(now) ? "Watch it: without gravity its unbalance throws it out, and it does not land." : "Watch it land."),
        isMet: (_, notes) => notes.touched, hold: 0.1, begins: offSince,
        remark: (now, notes) => {
          const [came, has] = isWeightless(now) ? ["was thrown out, and touched", "has been thrown out"] : ["landed", "has landed"];
          return `It ${notes.touchedAt > notes.began ? `${came} ${quantityText(notes.touchedAt - notes.began, "s")} after the loss of power` : has}, and pressed with a force of up to ${quantityText(notes.force, "N")}; ${landed(now)}.`;
        },
      },
      {
        instruction: (now) => `Lift it again: Controller, ${plainLaw(now)}.`,
        isMet: (now) => !isOff(now), hold: 0.3,
        remark: (now) => (touched(now).length === 0 ? "It levitates again." : `It is still in contact at ${places(touched(now))}: a plain controller cannot lift a whirling rotor. Wait, slow it down, or choose another controller.`),
      },
    ],
  };
}

/** @param {Session} session */
function landed(session) {
  const modes = placesOfContact(session.rig.geometry).map((name) => valueOf(session, `rotor_contact.${name}.mode`));
  if (modes.some((mode) => mode === 2)) { return "it rolls"; }
  return modes.some((mode) => mode === 1) ? "it slides" : "it bounces";
}
