// The panels of state: contact at each site, the state of the controller, and the energies.

import { isOff } from "./advice.js";
import { make, setText } from "./dom.js";
import { nameLabel, numberText, quantityText } from "./format.js";
import { shownSites } from "./orbits.js";
import { CONTACT_WINDOW, placesOfContact, plainLaw, settingOf, valueOf } from "./session.js";

/** @typedef {import("./session.js").Session} Session */

const MODES = [["○", "free"], ["◐", "sliding"], ["●", "rolling"]];

/**
 * Fill the list of contact sites and faces, and return the function that updates it.
 * @param {HTMLElement} panel
 * @param {Session} session
 * @returns {(session: Session) => void}
 */
export function makeContacts(panel, session) {
  const faces = session.rig.geometry.faces.filter((face) => settingOf(session, `rotor_contact.${face.name}.enabled`) !== 0);
  const rows = [...shownSites(session), ...faces].map(({ name }) => {
    const mode = make("span", { class: "mode" }), value = make("span", { class: "value" });
    const element = make("div", { class: "contact" }, [make("b", { text: nameLabel(name) }), mode, value]);
    return { site: `rotor_contact.${name}`, element, mode, value };
  });
  panel.replaceChildren(...rows.map((row) => row.element));
  return (now) => {
    for (const row of rows) {
      const k = Math.max(Math.round(valueOf(now, `${row.site}.mode`)) || 0, 0), [sign, text] = MODES[k] ?? MODES[0];
      row.element.dataset.mode = String(k);
      setText(row.mode, `${sign} ${text}`);
      const gap = valueOf(now, `${row.site}.gap`);
      const across = valueOf(now, `${row.site}.f_t`), along = valueOf(now, `${row.site}.torque`); // of a site, of a face
      const friction = Number.isFinite(across) ? `T ${quantityText(across, "N")}` : `torque ${quantityText(along, "N m")}`;
      setText(row.value, k === 0 ? `gap ${quantityText(gap, "m")}` : `N ${quantityText(valueOf(now, `${row.site}.f_n`), "N")}, ${friction}`);
    }
  };
}

/**
 * Fill the list of the machine's state, and return the function that updates it.
 * @param {HTMLElement} panel
 * @param {Session} session
 * @returns {(session: Session) => void}
 */
export function makeFacts(panel, session) {
  const status = session.variables.get("rolac_controller.rolac_status");
  const names = new Map(Object.entries(status?.items ?? {}).map(([name, value]) => [value, name.replaceAll("_", " ")]));
  /** @type {[string, (now: Session) => string, (now: Session) => boolean][]} */
  const facts = [
    ["speed", (now) => speedText(valueOf(now, "rotor_contact.speed")), () => false],
    ["control", (now) => controlText(now, names), (now) => isOff(now)],
    ["synchronous force", (now) => quantityText(valueOf(now, "rolac_controller.harmonic1.force"), "N"), (now) => valueOf(now, "rolac_controller.rolac_limited") === 1],
    ["limits", (now) => limitsText(now), (now) => limitsText(now) !== "none reached"],
    ["recent contact force", (now) => quantityText(largestForce(now), "N"), () => false],
  ];
  const listed = facts.filter(([name]) => session.rig.components.some((item) => item.name === "rolac_controller") || name === "speed" || name === "recent contact force");
  const rows = listed.map(([name, text, isAlarm]) => ({ term: make("dt", { text: name }), value: make("dd"), text, isAlarm }));
  panel.replaceChildren(...rows.flatMap((row) => [row.term, row.value]));
  return (now) => {
    for (const row of rows) {
      setText(row.value, row.text(now));
      row.value.classList.toggle("alarm", row.isAlarm(now));
    }
  };
}

/** @param {number} speed rad/s */
function speedText(speed) {
  return quantityOf(speed * 30 / Math.PI, "rpm");
}

/** @param {number} value @param {string} unit @returns {string} without a line break inside */
function quantityOf(value, unit) {
  return `${numberText(value, 4)}\u00a0${unit}`;
}

/** @param {Session} session @param {Map<number, string>} names */
function controlText(session, names) {
  if (isOff(session)) { return "amplifiers off"; }
  const status = valueOf(session, "rolac_controller.rolac_status");
  const plain = plainLaw(session) === "PID" ? "PID" : "linear controller";
  if (!(status > 0)) { return plain; }
  const mode = session.variables.get("rolac_controller.rolac.mode");
  const law = Object.entries(mode?.items ?? {}).find(([, value]) => value === settingOf(session, "rolac_controller.rolac.mode"))?.[0] ?? "rolac";
  return `${plain} + ${law.replaceAll("_", " ").toUpperCase()}, ${names.get(status) ?? status}`;
}

/** @param {Session} session */
function limitsText(session) {
  const flags = { "rolac_controller.current_limited": "current", "rolac_controller.demand_limited": "current", "linear_controller.demand_limited": "current of the inner loop", "rolac_controller.rolac_limited": "synchronous force", "rolac_controller.h_extrapolated": "table of H", "rolac_controller.adc_limited": "ADC" };
  return Object.entries(flags).filter(([name]) => valueOf(session, name) === 1).map(([, text]) => text).join(", ") || "none reached";
}

/** @param {Session} session */
function largestForce(session) {
  const { traces, rig, time } = session, from = traces.count > 0 ? traces.time[traces.position(Math.max(traces.count - 4000, 0))] : time;
  return Math.max(0, ...placesOfContact(rig.geometry).map((name) => traces.largestMean(`rotor_contact.${name}.f_n_mean`, from, time, CONTACT_WINDOW)));
}

const ENERGIES = /** @type {const} */ ([
  ["kinetic", "energy.kinetic", 0, "of the lateral motion, housings, races and a free spin, now"], ["strain", "energy.strain", 0, "of shaft and mounts, now"],
  ["friction", "energy.friction", 1, "heat so far"], ["impacts", "energy.impact", 1, "lost so far; negative if the nodal impact rule, which does not conserve momentum, has added energy"], ["damping", "energy.damping", 2, "heat so far"],
  ["balance", "energy.balance", 3, "gain beyond the work; ideally zero"],
]);

/**
 * Fill the panel of energies, and return the function that updates it. Bars are logarithmic, from 0.1 mJ to 1 kJ.
 * @param {HTMLElement} panel
 * @returns {(session: Session) => void}
 */
export function makeEnergies(panel) {
  const rows = ENERGIES.map(([name, signal, series, hint]) => {
    const fill = make("i"), value = make("span", { class: "value" });
    const bar = make("span", { class: "bar", style: `--key: var(--series-${series + 1})` }, [fill]);
    const term = make("span", { text: name, title: hint });
    return { signal: `rotor_contact.${signal}`, name, fill, value, term, parts: [term, bar, value] };
  });
  panel.replaceChildren(...rows.flatMap((row) => row.parts), make("span", { class: "hint", style: "grid-column: 1 / -1", text: "Bars: logarithmic, 0.1 mJ to 1 kJ" }));
  return (session) => {
    for (const row of rows) {
      const energy = valueOf(session, row.signal), share = (Math.log10(Math.max(Math.abs(energy), 1e-4)) + 4) / 7;
      row.fill.style.transform = `scaleX(${Math.min(share || 0, 1)})`;
      setText(row.value, quantityText(energy, "J"));
      if (row.name === "kinetic") { setText(row.term, settingOf(session, "rotor_contact.spin.free") === 1 ? "kinetic, with spin" : "kinetic"); }
    }
  };
}
