// The panel of controls: each shows the present value, sends changes, and says when they take effect.

import { advice, contactTime } from "./advice.js";
import { apply, effectBadge } from "./changes.js";
import { declaredGroups } from "./declared.js";
import { make, setText, typeset } from "./dom.js";
import { makeAnyVariable, makeSpeedControl } from "./special_controls.js";
import { effectOf, matching, settingOf } from "./session.js";

/** @typedef {import("./session.js").Session} Session */
/** @typedef {import("./changes.js").Changes} Changes */
/** @typedef {import("./changes.js").Control} Control */
/** @typedef {import("./changes.js").Update} Update */

/**
 * Fill the panel, and return the function that updates it.
 * @param {HTMLElement} panel
 * @param {Session} session
 * @param {Changes} changes
 * @returns {Update}
 */
export function makeControls(panel, session, changes) {
  /** @type {{ title: string, theory: string, open: boolean, hint?: string, controls: Control[] }[]} */
  const groups = [
    { title: "Speed", theory: "rotor", open: true, controls: [makeSpeedControl(session, changes)] },
    ...declaredGroups(session).map((group) => ({ ...group, controls: group.controls.map((control) => makeControl(session, control, changes)) })),
    { title: "Any variable", theory: "", open: false, controls: [makeAnyVariable(session, changes)] },
  ];
  const wasOpen = new Map([...panel.querySelectorAll("details")].map((item) => [item.dataset.title, item.open]));
  panel.replaceChildren(...groups.map((group) => {
    const link = group.theory === "" ? [] : [make("a", { class: "theory", href: `#theory-${group.theory}`, "data-theory": group.theory, text: "theory" })];
    return make("details", { open: wasOpen.get(group.title) ?? group.open, "data-title": group.title }, [
      make("summary", {}, [group.title, ...link]),
      ...(group.hint === undefined ? [] : [make("p", { class: "hint", text: group.hint })]),
      ...group.controls.map((control) => control.element),
    ]);
  }));
  const updates = groups.flatMap((group) => group.controls.map((control) => control.update));
  return (now) => updates.forEach((update) => update(now));
}

/** @param {Session} session @param {import("./declared.js").Declared} control @param {Changes} changes */
function makeControl(session, control, changes) {
  if (control.kind === "slider") { return makeSlider(session, control, changes); }
  if (control.kind === "pair") { return makePair(session, control, changes); }
  return control.kind === "boxes" ? makeBoxes(session, control, changes) : makeChoice(session, control, changes);
}

/**
 * Return the value of a variable: planned for the next reset, or else the present one.
 * @param {Session} session
 * @param {Changes} changes
 * @param {string} name
 */
function shownSetting(session, changes, name) {
  return changes.planned()[name] ?? settingOf(session, name);
}

/** @param {Session} session @param {import("./declared.js").Slider} control @param {Changes} changes */
function makeSlider(session, control, changes) {
  const { names, range, field, unit, update } = makeNumber(session, control, changes);
  const label = make("span", { title: session.variables.get(names[0])?.description ?? "" }, typeset(control.label));
  return { element: make("div", { class: "control" }, [label, make("span", { class: "field" }, [field, unit]), effectBadge(session, names[0]), range]), update };
}

/**
 * @param {Session} session
 * @param {import("./declared.js").Pair} control
 * @param {Changes} changes
 * @returns {Control}
 */
function makePair(session, control, changes) {
  const [amount, angle] = [makeNumber(session, control.amount, changes), makeNumber(session, control.angle, changes)];
  const fields = [make("b", { text: control.label, class: control.label.length > 3 ? "long" : "" }), amount.field, amount.unit, angle.field, angle.unit, effectBadge(session, amount.names[0])];
  const ranges = make("div", { class: "ranges" }, [amount.range, angle.range]);
  return {
    element: make("div", { class: "pair-control" }, [make("div", { class: "fields" }, fields), ranges]),
    update: (now) => { amount.update(now); angle.update(now); },
  };
}

/**
 * Return the slider and the field of a number, and the function that updates them.
 * @param {Session} session
 * @param {import("./declared.js").Slider} control
 * @param {Changes} changes
 */
function makeNumber(session, control, changes) {
  const names = control.patterns.flatMap((pattern) => matching(session, pattern));
  const limits = { min: String(control.from), max: String(control.to), step: String(control.step) };
  const range = make("input", { type: "range", ...limits, "aria-label": control.label });
  const field = make("input", { type: "number", step: "any", "aria-label": `${control.label}, ${control.unit}`, "data-variable": names[0] });
  const send = (/** @type {number} */ displayed) => {
    if (Number.isFinite(displayed)) { apply(session, changes, Object.fromEntries(names.map((name) => [name, displayed / control.scale]))); }
  };
  range.addEventListener("input", () => { field.value = range.value; send(Number(range.value)); });
  field.addEventListener("change", () => send(field.valueAsNumber));
  const unit = make("span", { class: "unit", text: control.unit });
  return {
    names, range, field, unit,
    /** @type {Update} */
    update: (now) => {
      const values = names.map((name) => control.scale * shownSetting(now, changes, name));
      const isMixed = values.some((value) => Math.abs(value - values[0]) > 1e-9 * Math.abs(values[0]));
      setText(unit, isMixed ? "several" : control.unit);
      if (document.activeElement !== field) { field.value = String(Number(values[0].toPrecision(6))); }
      if (!range.matches(":active")) { range.value = String(values[0]); }
    },
  };
}

/**
 * @param {Session} session
 * @param {import("./declared.js").Boxes} control
 * @param {Changes} changes
 * @returns {Control}
 */
function makeBoxes(session, control, changes) {
  const boxes = control.boxes.map(({ label, name }) => {
    const input = make("input", { type: "checkbox", "data-variable": name });
    input.addEventListener("change", () => apply(session, changes, { [name]: Number(input.checked) }));
    return { name, input, element: make("label", { title: session.variables.get(name)?.description ?? "" }, [input, label]) };
  });
  const title = make("div", { class: "control" }, [make("span", { text: control.label }), make("span"), effectBadge(session, control.boxes[0].name)]);
  const grid = make("div", { class: "grid", role: "group", "aria-label": control.label }, boxes.map((box) => box.element));
  return {
    element: make("div", {}, [title, grid]),
    update: (now) => boxes.forEach((box) => { box.input.checked = shownSetting(now, changes, box.name) === 1; }),
  };
}

/** @param {Session} session @param {import("./declared.js").Choice} control @param {Changes} changes */
function makeChoice(session, control, changes) {
  const hint = make("p", { class: "advice", role: "status", hidden: true });
  let present = session;
  const options = control.options.map((option) => {
    const badge = make("span", { class: "badge" });
    const button = make("button", { type: "button", title: option.title, "aria-pressed": "false", "data-option": option.label }, [option.label, badge]);
    button.addEventListener("click", () => {
      apply(session, changes, option.values);
      advise(option.label);
    });
    return { ...option, badge, button };
  });
  const advise = (/** @type {string} */ chosen) => {
    const advised = advice(present, chosen, control.options.map((item) => item.label)), better = options.find((item) => item.label === advised?.option);
    hint.hidden = advised === null || better === undefined;
    if (advised === null || better === undefined) { return; }
    const choose = make("button", { type: "button", text: `Choose ${advised.option}` });
    choose.addEventListener("click", () => better.button.click());
    hint.replaceChildren(`${advised.text} `, choose);
  };
  const update = (/** @type {Session} */ now) => {
    present = now;
    if (contactTime(now) === 0) { hint.hidden = true; }
    options.forEach((option) => {
      const entries = Object.entries(option.values);
      const waits = entries.some(([name, value]) => effectOf(now, name) === "anew" && settingOf(now, name) !== value);
      option.button.setAttribute("aria-pressed", String(entries.every(([name, value]) => shownSetting(now, changes, name) === value)));
      option.badge.className = `badge ${waits ? "anew" : "live"}`;
      setText(option.badge, waits ? "reset" : "now");
    });
  };
  const group = make("div", { class: "choices", role: "group", "aria-label": control.label }, options.map((option) => option.button));
  return { element: make("div", {}, [group, hint]), update };
}
