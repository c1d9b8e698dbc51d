// The panel of guided experiments: it shows what to do, waits until it is done, and comments on the result.

import { make, setText } from "./dom.js";
import { experimentsOf, follow, newNotes, nextNotes } from "./experiments.js";

/** @typedef {import("./session.js").Session} Session */

/**
 * Fill the panel, and return the function that updates it.
 * @param {HTMLElement} panel
 * @param {Session} session
 * @param {Progress} progress progress of the user, which outlives the view
 * @param {() => void} run function that runs the scenario if it is paused
 * @returns {import("./changes.js").Update}
 */
export function makeGuide(panel, session, progress, run) {
  const experiments = experimentsOf(session);
  panel.hidden = experiments.length === 0;
  if (panel.hidden) { return () => undefined; }
  if (progress.experiment === null) { progress.experiment = Math.max(experiments.findIndex((item) => item.suits), 0); }
  const chosen = () => Math.min(progress.experiment ?? 0, experiments.length - 1);
  const tabs = experiments.map((item, k) => make("button", { type: "button", text: `${k + 1} ${item.title}`, "data-experiment": String(k) }));
  const instruction = make("p", { class: "say", "aria-live": "polite" }), remarks = make("ol", { class: "remarks", "aria-live": "polite" });
  const skip = make("button", { type: "button", id: "skip-step", title: "Continue without this step" });
  const begin = (/** @type {number} */ experiment) => {
    Object.assign(progress, { experiment, step: 0, notes: null, remarks: [] });
    run();
  };
  tabs.forEach((tab, k) => tab.addEventListener("click", () => begin(k)));
  const completeStep = (/** @type {string} */ remark, /** @type {Progress["notes"]} */ notes) => {
    if (remark !== "") { progress.remarks.push(remark); }
    Object.assign(progress, { step: progress.step + 1, notes });
  };
  skip.addEventListener("click", () => {
    if (progress.step < experiments[chosen()].steps.length) { completeStep("", null); } else { begin((chosen() + 1) % experiments.length); }
  });
  panel.replaceChildren(make("div", { class: "choices", role: "group", "aria-label": "Experiment" }, tabs), remarks, instruction, skip);
  return (now) => {
    const { title, steps } = experiments[chosen()], step = steps[progress.step];
    tabs.forEach((tab, k) => tab.setAttribute("aria-pressed", String(k === chosen())));
    if (step !== undefined) {
      progress.notes ??= newNotes(now.time);
      if (follow(step, progress.notes, now)) { completeStep(step.remark(now, progress.notes), nextNotes(progress.notes)); }
    }
    const next = experiments[(chosen() + 1) % experiments.length].title;
    setText(instruction, steps[progress.step]?.instruction(now) ?? `That was “${title}”.`);
    setText(skip, progress.step < steps.length ? "Skip" : `Next: ${next}`);
    if (remarks.children.length !== progress.remarks.length) { remarks.replaceChildren(...progress.remarks.map((text) => make("li", { text }))); }
  };
}

/** `experiment`: null until one is chosen, by the scenario or the user. @typedef {{ experiment: number | null, step: number, notes: import("./experiments.js").Notes | null, remarks: string[] }} Progress */

/** @returns {Progress} */
export function newProgress() {
  return { experiment: null, step: 0, notes: null, remarks: [] };
}
