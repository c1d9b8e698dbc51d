// Controls of special kinds: the speed, which is reached at a rate; the push; and any variable by its name.

import { apply, effectBadge } from "./changes.js";
import { make, setText } from "./dom.js";
import { numberText, unitText } from "./format.js";
import { pushScale, rotationOf } from "./orbits.js";
import { settingOf, valueOf } from "./session.js";

/** @typedef {import("./session.js").Session} Session */
/** @typedef {import("./changes.js").Changes} Changes */
/** @typedef {import("./changes.js").Control} Control */

const FASTEST = 400; // rad/s, on the slider

/**
 * Return the control of the speed.
 * @param {Session} session
 * @param {Changes} changes
 * @returns {Control}
 */
export function makeSpeedControl(session, changes) {
  const highest = Math.max(FASTEST, Math.ceil((1.5 * 2 * Math.PI) / session.rig.period / 50) * 50);
  const range = make("input", { type: "range", min: "0", max: String(highest), step: "0.5", "aria-label": "Speed" });
  const field = make("input", { type: "number", step: "any", id: "speed-field", "aria-label": "Speed, rad/s" });
  const rate = make("input", { type: "number", step: "any", value: "50", "aria-label": "Rate of change of the speed, rad/s²" });
  const hertz = make("span", { class: "unit" });
  const send = (/** @type {number} */ speed) => {
    if (Number.isFinite(speed) && rate.valueAsNumber > 0) { changes.speed(speed, rate.valueAsNumber); }
  };
  range.addEventListener("change", () => send(Number(range.value)));
  range.addEventListener("input", () => { field.value = range.value; });
  field.addEventListener("change", () => send(field.valueAsNumber));
  const badge = make("span", { class: "badge live", title: "continuous input", text: "now" });
  const top = make("div", { class: "control" }, [make("span", { text: "Speed" }), make("span", { class: "field" }, [field, make("span", { class: "unit", text: "rad/s" })]), badge, range]);
  const below = make("div", { class: "control" }, [make("span", { text: "rate" }), make("span", { class: "field" }, [rate, make("span", { class: "unit", text: "rad/s²" })]), hertz]);
  return {
    element: make("div", {}, [top, below]),
    update: (now) => {
      const demanded = valueOf(now, "Omega"), speed = Number.isFinite(demanded) ? demanded : valueOf(now, "rotor_contact.speed");
      setText(hertz, `${numberText(speed * 30 / Math.PI, 4)} rpm`);
      if (document.activeElement !== field && !range.matches(":active")) {
        field.value = Number.isFinite(speed) ? String(Number(speed.toPrecision(6))) : "";
        range.value = field.value;
      }
    },
  };
}

/**
 * Return the control of a push: which disc, how strong, in which direction; it lasts while its button is held.
 * @param {Session} session
 * @param {Changes} changes
 */
export function makePushControl(session, changes) {
  const discs = session.rig.geometry.discs.filter((item) => item.unbalance).map((item) => item.name);
  if (discs.length === 0) { return { element: make("span"), update: () => undefined }; }
  const disc = make("select", { "aria-label": "Disc to push" }, discs.map((name) => make("option", { value: name, text: name.toUpperCase() })));
  const force = make("input", { type: "number", step: "any", value: String(pushScale(session)), style: "width: 4.1rem", "aria-label": "Force of the push, N" });
  const angle = make("input", { type: "number", step: "any", value: "-90", style: "width: 3.6rem", "aria-label": "Direction of the push, degrees from the right, upwards positive" });
  const button = make("button", { type: "button", id: "push", "aria-pressed": "false", text: "Push", title: "Pushes while held, by pointer or key" });
  const press = (/** @type {boolean} */ isOn) => {
    const turn = (Math.PI * (angle.valueAsNumber || 0)) / 180 - rotationOf(session.rig.geometry), size = isOn ? force.valueAsNumber || 0 : 0;
    button.setAttribute("aria-pressed", String(isOn));
    changes.push(disc.value, [size * Math.cos(turn), size * Math.sin(turn)]);
  };
  const isHeld = () => button.getAttribute("aria-pressed") === "true";
  button.addEventListener("pointerdown", (event) => { button.setPointerCapture(event.pointerId); press(true); });
  button.addEventListener("keydown", (event) => { if ((event.key === " " || event.key === "Enter") && !event.repeat) { event.preventDefault(); event.stopPropagation(); press(true); } });
  for (const name of ["pointerup", "pointercancel", "keyup", "blur"]) { button.addEventListener(name, () => { if (isHeld()) { press(false); } }); }
  const row = make("div", { class: "row" }, [disc, force, make("span", { class: "unit", text: "N at" }), angle, make("span", { class: "unit", text: "°" }), button]);
  return { element: row, update: () => undefined };
}

/**
 * Return the control of any parameter or input by its name; what the FMU refuses, it says.
 * @param {Session} session
 * @param {Changes} changes
 */
export function makeAnyVariable(session, changes) {
  const names = [...session.variables].filter(([, variable]) => variable.causality !== "output").map(([name]) => name);
  const list = make("datalist", { id: "variables" }, names.map((name) => make("option", { value: name })));
  const field = make("input", { list: "variables", id: "variable-name", placeholder: "component.variable", "aria-label": "Variable", autocomplete: "off", spellcheck: "false" });
  const value = make("input", { type: "number", step: "any", id: "variable-value", "aria-label": "Value in the variable's unit" });
  const button = make("button", { type: "button", id: "variable-set", text: "Set" });
  const about = make("p", { class: "hint" }), badge = make("span");
  const look = () => {
    const variable = session.variables.get(field.value);
    badge.replaceChildren(...(variable === undefined ? [] : [effectBadge(session, field.value)]));
    if (variable === undefined) { return; }
    const range = [variable.min === null ? "" : `≥ ${numberText(variable.min)}`, variable.max === null ? "" : `≤ ${numberText(variable.max)}`];
    const items = Object.entries(variable.items ?? {}).map(([name, item]) => `${item} ${name}`).join(", ");
    about.textContent = `${variable.description}. ${unitText(variable.unit)} ${range.filter(Boolean).join(", ")} ${items}`;
    value.value = String(settingOf(session, field.value));
  };
  field.addEventListener("input", look);
  button.addEventListener("click", () => {
    if (session.variables.has(field.value) && Number.isFinite(value.valueAsNumber)) { apply(session, changes, { [field.value]: value.valueAsNumber }); }
  });
  return { element: make("div", {}, [make("div", { class: "row" }, [field, value, badge, button, list]), about]), update: () => undefined };
}
