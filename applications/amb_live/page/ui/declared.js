// The controls of a rig, with their variables and units.

import { halfHeightFor } from "./charts.js";
import { nameLabel } from "./format.js";
import { matching, placesOfContact, plainLaw } from "./session.js";

/** @typedef {import("./session.js").Session} Session */

/**
 * A number on a slider, the same for all variables that its patterns match.
 * @typedef {object} Slider
 * @property {"slider"} kind
 * @property {string} label
 * @property {string[]} patterns
 * @property {string} unit as displayed
 * @property {number} scale from the variable's unit to that
 * @property {number} from
 * @property {number} to
 * @property {number} step
 */

/**
 * Booleans of the same kind, each with a box.
 * @typedef {{ kind: "boxes", label: string, boxes: { label: string, name: string }[] }} Boxes
 */

/**
 * A choice between values of several variables at once.
 * @typedef {{ kind: "choice", label: string, options: { label: string, title: string, values: Record<string, number> }[] }} Choice
 */

/**
 * An amount and its angle, side by side.
 * @typedef {{ kind: "pair", label: string, amount: Slider, angle: Slider }} Pair
 */

/** @typedef {Slider | Pair | Boxes | Choice} Declared */

/**
 * Controls of a subject, with the theory behind them.
 * @typedef {object} Group
 * @property {string} title
 * @property {string} theory
 * @property {boolean} open
 * @property {Declared[]} controls
 * @property {string} [hint]
 */

/**
 * Return the groups of controls of a rig, without controls of variables that its components lack.
 * @param {Session} session
 */
export function declaredGroups(session) {
  const { geometry } = session.rig;
  /** @type {(label: string, patterns: string[], unit: string, scale: number, from: number, to: number, step: number) => Slider} */
  const slider = (label, patterns, unit, scale, from, to, step) => ({ kind: "slider", label, patterns, unit, scale, from, to, step });
  const discs = geometry.discs.filter((item) => item.unbalance).map((item) => item.name), maxUnbalance = 1e3 * largestUnbalance(session);
  /** @type {Group[]} */
  const groups = [
    {
      title: "Unbalance", theory: "rotor", open: true,
      controls: discs.map((name) => ({
        kind: "pair", label: nameLabel(name),
        amount: slider(`unbalance of ${nameLabel(name)}`, [`rotor_contact.${name}.u`], "g m", 1e3, 0, maxUnbalance, maxUnbalance / 240),
        angle: slider(`angle of the unbalance of ${nameLabel(name)}`, [`rotor_contact.${name}.phi`], "°", 180 / Math.PI, -180, 180, 1),
      })),
    },
    {
      title: "Controller", theory: "synchronous", open: true,
      hint: "Switch ROLAC on before contact. In sustained contact plain ROLAC cannot free the rotor; contact-aware ROLAC can. A slower adaptation recovers from more.",
      controls: [controllers(session), slider("adaptation rate", ["rolac_controller.rolac.alpha"], "1/s", 1, 0, 40, 0.5)],
    },
    {
      title: "Gains", theory: "controller", open: false,
      controls: [
        slider("net stiffness K_b", ["rolac_controller.*.k_b_?"], "MN/m", 1e-6, 0, 4, 0.05),
        slider("damping C_b", ["rolac_controller.*.c_b_?"], "kN s/m", 1e-3, 0, 20, 0.25),
        slider("integral K_I", ["rolac_controller.*.k_integral_?"], "MN/(m s)", 1e-6, 0, 50, 0.5),
      ],
    },
    {
      title: "Contact", theory: "contact", open: false,
      controls: [
        slider("friction µ", ["rotor_contact.*.mu"], "", 1, 0, 0.5, 0.01),
        ...placesOfContact(geometry).map((name) => slider(`clearance ${nameLabel(name)}`, [`rotor_contact.${name}.clearance`], "mm", 1e3, 0.05, 2, 0.01)),
        slider("restitution", ["rotor_contact.*.restitution"], "", 1, 0, 1, 0.05),
        { kind: "boxes", label: "can touch at", boxes: placesOfContact(geometry).map((name) => ({ label: nameLabel(name), name: `rotor_contact.${name}.enabled` })) },
      ],
    },
    {
      title: "Faults", theory: "actuator", open: false,
      controls: [
        { kind: "boxes", label: "axis without power", boxes: named(session, "amb_actuator.*.amplifier_off_?", (_, place, axis) => `${nameLabel(place)} ${axis.slice(-1)}`) },
        { kind: "boxes", label: "sensor reads zero", boxes: named(session, "rolac_controller.*.fault_dead", (_, place) => place) },
        slider("sensor noise (rms)", ["rolac_controller.*.fault_noise"], "µm", 1e6, 0, 50, 0.5),
      ],
    },
    {
      title: "Gravity and drop", theory: "rotor", open: false,
      hint: "The static currents carry the weight of the scenario. To drop the rotor, switch the controller off.",
      controls: [slider("gravity", ["rotor_contact.gravity"], "m/s²", 1, 0, 20, 0.01)],
    },
  ];
  return groups.map((group) => ({ ...group, controls: group.controls.filter((control) => isAvailable(session, control)) }))
    .filter((group) => group.controls.length > 0);
}

/**
 * Return the end of the sliders of unbalance: twice the largest of the scenario, rounded up; 60 g m if it has none.
 * @param {Session} session
 * @returns {number} kg m
 */
function largestUnbalance({ rig }) {
  const set = [...Object.entries(rig.inputs), ...rig.events.map((event) => /** @type {const} */ ([event.variable, event.value]))];
  const values = set.filter(([name]) => /^rotor_contact\.[^.]+\.u$/.test(name)).map(([, value]) => value);
  return values.some((value) => value > 0) ? halfHeightFor([values], 0, 0) * 2 : 0.06;
}

/**
 * Return the choice of a controller.
 * @param {Session} session
 * @returns {Choice}
 */
function controllers(session) {
  const mode = session.variables.get("rolac_controller.rolac.mode")?.items ?? {};
  const source = session.variables.get("rolac_controller.contact.source")?.items ?? {};
  const off = matching(session, "amb_actuator.*.amplifier_off_?");
  const power = (/** @type {number} */ value) => Object.fromEntries(off.map((name) => [name, value]));
  const adaptive = (/** @type {string} */ law, /** @type {number} */ aware) => ({
    ...power(0), "rolac_controller.rolac_enable": 1, "rolac_controller.rolac.mode": mode[law], "rolac_controller.contact.aware": aware,
    ...(aware ? { "rolac_controller.contact.source": source.sensors } : {}),
  });
  const plain = plainLaw(session), law = plain === "PID" ? plain : "linear controller", sentence = law[0].toUpperCase() + law.slice(1);
  const options = [
    { label: "Off", title: "Amplifiers off: the rotor is not held", values: power(1) },
    { label: plain, title: `${sentence} alone`, values: { ...power(0), "rolac_controller.rolac_enable": 0 } },
    { label: "OLAC", title: `${sentence} with open-loop adaptive control, updated whenever the vibration is steady`, values: adaptive("olac", 0) },
    { label: "ROLAC", title: `${sentence} with recursive open-loop adaptive control`, values: adaptive("rolac", 0) },
    { label: "Contact-aware", title: `${sentence} with ROLAC that allows for contact`, values: adaptive("rolac", 1) },
  ];
  return { kind: "choice", label: "Controller", options: session.variables.has("rolac_controller.rolac_enable") ? options : [] };
}

/**
 * @param {Session} session
 * @param {string} pattern
 * @param {(...parts: string[]) => string} label of component, place and variable
 */
function named(session, pattern, label) {
  return matching(session, pattern).map((name) => ({ name, label: label(...name.split(".")) }));
}

/** Return whether the rig has a variable of a control; boxes without one are removed. @param {Session} session @param {Declared} control */
function isAvailable(session, control) {
  if (control.kind === "choice") { return control.options.length > 0; }
  if (control.kind === "boxes") {
    control.boxes = control.boxes.filter((box) => session.variables.has(box.name));
    return control.boxes.length > 0;
  }
  const { patterns } = control.kind === "pair" ? control.amount : control;
  return patterns.some((pattern) => matching(session, pattern).length > 0);
}
