// Controls of special kinds: the speed, which is reached at a rate; and any variable by its name.

import { apply, effectBadge } from "./changes.js";
import { make, setText } from "./dom.js";
import { numberText, unitText } from "./format.js";
import { settingOf, valueOf } from "./session.js";

/** @typedef {import("./session.js").Session} Session */
/** @typedef {import("./changes.js").Changes} Changes */
/** @typedef {import("./changes.js").Control} Control */

const USUAL_MAX_SPEED = 4000; // rpm, on the slider
const RPM = 30 / Math.PI; // rpm per rad/s

/**
 * Return the control of the speed.
 * @param {Session} session
 * @param {Changes} changes
 * @returns {Control}
 */
export function makeSpeedControl(session, changes) {
  const highest = Math.max(USUAL_MAX_SPEED, Math.ceil((1.5 * 60) / session.rig.period / 500) * 500);
  const range = make("input", { type: "range", min: "0", max: String(highest), step: "5", "aria-label": "Speed" });
  const field = make("input", { type: "number", step: "any", id: "speed-field", "aria-label": "Speed, rpm" });
  const rate = make("input", { type: "number", step: "any", value: "500", "aria-label": "Rate of change of the speed, rpm/s" });
  const hertz = make("span", { class: "unit" });
  const send = (/** @type {number} */ speed) => {
    if (Number.isFinite(speed) && rate.valueAsNumber > 0) { changes.speed(speed / RPM, rate.valueAsNumber / RPM); }
  };
  range.addEventListener("change", () => send(Number(range.value)));
  range.addEventListener("input", () => { field.value = range.value; });
  field.addEventListener("change", () => send(field.valueAsNumber));
  const badge = make("span", { class: "badge live", title: "continuous input", text: "now" });
  const top = make("div", { class: "control" }, [make("span", { text: "Speed" }), make("span", { class: "field" }, [field, make("span", { class: "unit", text: "rpm" })]), badge, range]);
  const below = make("div", { class: "control" }, [make("span", { text: "rate" }), make("span", { class: "field" }, [rate, make("span", { class: "unit", text: "rpm/s" })]), hertz]);
  return {
    element: make("div", {}, [top, below]),
    update: (now) => {
      const demanded = valueOf(now, "Omega"), speed = Number.isFinite(demanded) ? demanded : valueOf(now, "rotor_contact.speed");
      setText(hertz, `${numberText(speed / (2 * Math.PI), 4)} Hz`);
      if (document.activeElement !== field && !range.matches(":active")) {
        field.value = Number.isFinite(speed) ? String(Number((speed * RPM).toPrecision(6))) : "";
        range.value = field.value;
      }
    },
  };
}

/**
 * Return the control of any parameter or input by its name; it shows why the FMU rejects a value.
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
  const describe = () => {
    const variable = session.variables.get(field.value);
    badge.replaceChildren(...(variable === undefined ? [] : [effectBadge(session, field.value)]));
    if (variable === undefined) { return; }
    const range = [variable.min === null ? "" : `≥ ${numberText(variable.min)}`, variable.max === null ? "" : `≤ ${numberText(variable.max)}`];
    const items = Object.entries(variable.items ?? {}).map(([name, item]) => `${item} ${name}`).join(", ");
    about.textContent = `${variable.description}. ${unitText(variable.unit)} ${range.filter(Boolean).join(", ")} ${items}`;
    value.value = String(settingOf(session, field.value));
  };
  field.addEventListener("input", describe);
  button.addEventListener("click", () => {
    if (session.variables.has(field.value) && Number.isFinite(value.valueAsNumber)) { apply(session, changes, { [field.value]: value.valueAsNumber }); }
  });
  return { element: make("div", {}, [make("div", { class: "row" }, [field, value, badge, button, list]), about]), update: () => undefined };
}
