// The equations behind the drawings, in short, with a link to the page of the documentation.

import { byId, make, typeset } from "./dom.js";

/**
 * A subject: its page of the documentation, its equations with their numbers, and their explanation.
 * @typedef {{ title: string, page: string, equations: [equation: string, number: string][], text: string }} Subject
 */

/** @type {Record<string, Subject>} */
const SUBJECTS = {
  rotor: {
    title: "Rotor", page: "rotor",
    equations: [["M r̈ + (C − iΩ G₁) ṙ + K r = f,  r = x + iy", "3.1 to 3.6"], ["f_u = u e^{i(θ + φ)} (Ω² − iΩ̇)", ""]],
    text: "A shaft of beam elements with rigid discs, reduced to a few planes. Each disc may carry an unbalance u at the angle φ from the rotor's mark. Between the planes whose displacement the FMU outputs, the picture shows the static deflection of the shaft.",
  },
  contact: {
    title: "Contact", page: "contact",
    equations: [["|r|² = c²,  N ≥ 0", "4.14 to 4.17"], ["v_slip = Ω R_s + t·v", "4.11"], ["sliding: T = −µ N sign(v_slip)", "4.27"], ["rolling: ω = −(R_s / c) Ω", "4.30"]],
    text: "A constraint force, not a stiff spring, holds a journal on its clearance circle. N points inward; friction T is positive in the direction of spin. In an impact the velocities change instantaneously.",
  },
  energy: {
    title: "Energy", page: "energy",
    equations: [["balance = Δ(E_kinetic + E_strain) + heat of damping, friction and impacts − work of all inputs", ""]],
    text: "The plant accounts for all energy of the rotor. The residual measures the error of the integration, and is ideally zero.",
  },
  actuator: {
    title: "Magnetic bearing", page: "magnetic_bearing",
    equations: [["F = K_s x + K_i I", "2.7"], ["F = µ₀ N² A cos φ [ (I_s + I_b + I)² / (l − x)² − (I_b − I)² / (l + x)² ]", "2.6"]],
    text: "Two coil pairs on each axis pull in opposite directions. K_s is positive: a displaced rotor is pulled further away, so the bearing needs a controller. The scenario selects the force law.",
  },
  controller: {
    title: "Controller", page: "controller",
    equations: [["K_i I = −[ K_s x + K_b (x − x_set) + C_b ẋ + K_I ∫(x − x_set) ]", "5.1 to 5.4"]],
    text: "A PID on each axis, sampled at 4 kHz: the closed bearing has the net stiffness K_b and the damping C_b. Currents are limited to the range of the amplifiers.",
  },
  synchronous: {
    title: "Synchronous control", page: "synchronous_control",
    equations: [["Q = (1/π) ∫ q e^{−jϑ} dϑ over the last revolution", "5.20, 5.21"], ["U̇ = α H(Ω) Q,  H = −(Rᴴ W R)⁻¹ Rᴴ W", "5.10, 5.22"], ["I = I_pid + Re[U e^{jθ}] / K_i", "5.23"]],
    text: "The part of the vibration that rotates with the rotor, at every sensor. ROLAC adds rotating forces and adapts them until the vibration is smallest; OLAC does so whenever the vibration is steady. Contact-aware adaptation changes the direction of the force on a journal in contact.",
  },
};

/**
 * Show the theory of a subject, or of all.
 * @param {string} documentation address of the documentation, empty without any
 * @param {string} [subject]
 */
export function showTheory(documentation, subject) {
  const subjects = subject !== undefined && subject in SUBJECTS ? [SUBJECTS[subject]] : Object.values(SUBJECTS);
  byId("theory-text", HTMLElement).replaceChildren(...subjects.flatMap((item) => [
    make("h3", { text: item.title }), make("p", {}, typeset(item.text)),
    ...item.equations.map(([equation, number]) => make("span", { class: "math" }, [...typeset(equation), number === "" ? "" : make("small", { text: `  (${number})` })])),
    documentation === "" ? make("p", { class: "hint", text: `In full: docs/theory/${item.page}.md` })
      : make("p", {}, [make("a", { href: `${documentation.replace(/\/$/, "")}/theory/${item.page}.html`, text: `${item.title}: theory page` })]),
  ]));
  byId("theory-dialog", HTMLDialogElement).showModal();
}

/**
 * Let every link to theory open its subject, including links that are created later.
 * @param {string} documentation
 */
export function listenToTheory(documentation) {
  document.addEventListener("click", (event) => {
    const link = event.target instanceof Element ? event.target.closest("a[data-theory]") : null;
    if (link instanceof HTMLElement) {
      event.preventDefault();
      showTheory(documentation, link.dataset.theory);
    }
  });
}
