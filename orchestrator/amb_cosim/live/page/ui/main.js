// The page: it starts a worker for a scenario, shows what it computes, and passes on what the user does.

import { csvOf } from "../engine/csv.js";
import { byId, download, make, setText } from "./dom.js";
import { bytesOf, startEngine } from "./engine.js";
import { listenToKeys } from "./keys.js";
import { readPalette } from "./palette.js";
import { absorb, newSession } from "./session.js";
import { watchedSignals } from "./signals.js";
import { startTheme } from "./theme.js";
import { listenToTheory, showTheory } from "./theory.js";
import { columnsOf } from "./traces.js";
import { makeTransport } from "./transport.js";
import { makeView } from "./view.js";
import { fromHash, toHash } from "../engine/link.js";

/** @typedef {import("../protocol.js").Rig} Rig */
/** @typedef {import("../protocol.js").Deed} Deed */
/** @typedef {import("../protocol.js").Answer} Answer */

/**
 * What Python put into the page: rigs whose components name their variables by a key.
 * @typedef {object} PageData
 * @property {string} documentation
 * @property {(Omit<Rig, "components"> & { components: (Omit<Rig["components"][number], "variables"> & { variables: string })[] })[]} rigs
 * @property {Record<string, Rig["components"][number]["variables"]>} variables
 * @property {Record<string, string>} parts base64
 */

const READ = 8000; // ms that a notice stays

/** @type {PageData} */
const data = JSON.parse(byId("data", HTMLScriptElement).text);
const script = byId("worker", HTMLScriptElement).text;
const failure = byId("failure", HTMLElement), notice = byId("notice", HTMLElement), pendingBox = byId("pending", HTMLElement);
const chooser = byId("scenario", HTMLSelectElement);

let session = newSession(rigOf(data.rigs[0].scenario));
/** @type {import("./engine.js").Engine | null} */
let engine = null;
/** @type {import("./view.js").View | null} */
let view = null;
/** @type {Record<string, number>} */
let planned = {};
let palette = readPalette();
let noticeEnds = 0;
let plays = !matchMedia("(prefers-reduced-motion: reduce)").matches; // once the rotor has settled
let waits = true; // for it to settle

/**
 * Return a rig of the page whole.
 * @param {string} scenario
 * @returns {Rig}
 */
function rigOf(scenario) {
  const found = data.rigs.find((rig) => rig.scenario === scenario) ?? data.rigs[0];
  return { ...found, components: found.components.map((one) => ({ ...one, variables: data.variables[one.variables] })) };
}

/**
 * Start a scenario, with what was done if a link says so.
 * @param {string} scenario
 * @param {Deed} [deed]
 */
function load(scenario, deed) {
  engine?.end();
  view?.end();
  view = null;
  planned = {};
  waits = true;
  session = newSession(rigOf(scenario));
  chooser.value = session.rig.scenario;
  document.title = `Live rig: ${session.rig.scenario}`;
  setText(byId("description", HTMLElement), session.rig.description);
  setText(byId("origin", HTMLElement), `amb-cosim ${session.rig.version}. ${session.rig.source ? `${session.rig.source}. ` : ""}The FMUs' own machine code, as WebAssembly, coupled every ${1e6 * session.rig.stepSize} µs in this browser; nothing leaves it.`);
  showFailure("");
  showPending();
  engine = startEngine(script, hear, showFailure);
  const names = session.rig.components.flatMap((one) => [one.model, one.data]);
  const parts = Object.fromEntries(names.map((name) => [name, bytesOf(data.parts[name])]));
  engine.send({ type: "load", rig: session.rig, parts, deed, watched: watchedSignals(session.rig) });
}

/** @param {Answer} answer */
function hear(answer) {
  absorb(session, answer);
  if (answer.type === "ready") {
    rebuild();
  } else if (answer.type === "frame") {
    if (waits && answer.status === "paused") { begin(); }
  } else if (answer.type === "refused") {
    showFailure(answer.text);
  } else if (answer.type === "failed") {
    showFailure(`${answer.component} at ${answer.time.toFixed(4)} s: ${answer.text}. Go back in time, or reset.`);
  } else if (answer.type === "warning") {
    showNotice(`${answer.component} at ${answer.time.toFixed(3)} s: ${answer.text}`);
  } else if (answer.type === "ended") {
    showNotice(answer.reason === "completed" ? "The scenario has ended; run goes on." : answer.text);
  } else if (answer.type === "saved") {
    download(`${answer.name}.toml`, answer.toml, "application/toml");
    showNotice(`Saved ${answer.name}.toml: amb-cosim run ${answer.name}.toml repeats what was done.`);
  } else if (answer.type === "deed") {
    showPending();
  }
}

/** Make the view anew, in the colours that are in force. */
function rebuild() {
  palette = readPalette();
  if (session.status !== "loading") {
    view?.end();
    view = makeView(() => session, changes, () => palette);
  }
}

/** @param {string} text empty for none */
function showFailure(text) {
  failure.hidden = text === "";
  setText(failure, text);
}

/** @param {string} text */
function showNotice(text) {
  notice.hidden = false;
  setText(notice, text);
  noticeEnds = performance.now() + READ;
}

/** Say what waits for a new start. */
function showPending() {
  const count = Object.keys(planned).length;
  pendingBox.hidden = count === 0;
  if (count > 0) {
    const now = make("button", { type: "button", id: "apply", text: "Reset with it (R)" });
    const drop = make("button", { type: "button", text: "Forget" });
    now.addEventListener("click", reset);
    drop.addEventListener("click", () => { planned = {}; showPending(); });
    pendingBox.replaceChildren(`${names(planned)} can only change when the run starts anew.`, now, drop);
  }
}

/** @param {Record<string, number>} values */
function names(values) {
  const all = Object.keys(values), fixed = all.filter((name) => session.variables.get(name)?.variability === "fixed");
  const shown = fixed.length > 0 ? fixed : all;
  return shown.length > 3 ? `${shown.slice(0, 2).join(", ")} and ${shown.length - 2} more` : shown.join(", ");
}

function reset() {
  showFailure("");
  const values = { ...session.deed.settings.values, ...planned };
  const settings = Object.keys(planned).length > 0 ? { ...session.deed.settings, values } : undefined;
  planned = {};
  waits = true;
  engine?.send({ type: "reset", settings });
  showPending();
}

/** Go on as the user wants, when the rotor has settled. */
function begin() {
  waits = false;
  if (plays) { engine?.send({ type: "play", pace: transport.pace() }); }
}

/** @type {import("./changes.js").Changes} */
const changes = {
  set: (values) => { showFailure(""); engine?.send({ type: "set", values }); },
  plan: (values) => { planned = { ...planned, ...values }; showPending(); },
  speed: (speed, acceleration) => { showFailure(""); engine?.send({ type: "speed", speed, acceleration }); },
  push: (disc, force) => engine?.send({ type: "push", disc, force }),
  planned: () => planned,
};

const transport = makeTransport({
  play: (pace) => { showFailure(""); plays = true; if (!waits) { engine?.send({ type: "play", pace }); } },
  pause: () => { plays = false; engine?.send({ type: "pause" }); },
  step: () => { plays = false; engine?.send({ type: "step" }); },
  reset,
  go: (time, keep) => {
    showFailure("");
    engine?.send(time <= session.time ? { type: "rewind", time, keep } : { type: "run", to: time });
  },
}, () => session);

function share() {
  history.replaceState(null, "", `#${toHash(session.rig.scenario, session.deed)}`);
  const done = () => showNotice("The address now holds the settings, and is in the clipboard.");
  const refused = () => showNotice("The address now holds the settings: copy it from the bar.");
  if (navigator.clipboard === undefined) { refused(); } else { navigator.clipboard.writeText(location.href).then(done, refused); }
}

function save() {
  engine?.send({ type: "save", name: `${session.rig.scenario}_live`, description: `${session.rig.description}; changed by hand` });
}

function saveCsv() {
  const columns = columnsOf(session.traces).map(({ name, values }) => ({ name, unit: name === "time" ? "s" : session.variables.get(name)?.unit ?? "", values }));
  download(`${session.rig.scenario}.csv`, csvOf(columns), "text/csv");
}

/** @type {import("./keys.js").Shortcut[]} */
const shortcuts = [
  { key: " ", shown: "space", what: "run or pause", act: () => transport.toggle() },
  { key: "s", shown: "S", what: "single step of communication", act: () => byId("step", HTMLButtonElement).click() },
  { key: "r", shown: "R", what: "reset, with what waits for it", act: reset },
  { key: "-", shown: "−", what: "slower", act: () => transport.change(-0.25) },
  { key: "+", shown: "+", what: "faster", act: () => transport.change(0.25) },
  { key: "1", shown: "1", what: "real time", act: () => transport.setPace(1) },
  { key: "0", shown: "0", what: "a tenth of real time", act: () => transport.setPace(0.1) },
  { key: "l", shown: "L", what: "copy a link that holds the settings", act: share },
  { key: "f", shown: "F", what: "save as a scenario", act: save },
  { key: "c", shown: "C", what: "save the curves as CSV", act: saveCsv },
  { key: "t", shown: "T", what: "theory", act: () => showTheory(data.documentation) },
  { key: "d", shown: "D", what: "dark or light", act: () => switchTheme() },
  { key: "?", shown: "?", what: "this help", act: () => byId("help-dialog", HTMLDialogElement).showModal() },
];

const switchTheme = startTheme(rebuild);
listenToKeys(shortcuts);
listenToTheory(data.documentation);
byId("keys", HTMLElement).replaceChildren(...shortcuts.flatMap((one) => [make("dt", {}, [make("kbd", { text: one.shown })]), make("dd", { text: one.what })]),
  make("dt", { text: "arrow keys" }), make("dd", { text: "on an orbit: push; on the shaft: turn; on the time line: back and ahead" }));
for (const [id, act] of /** @type {[string, () => void][]} */ ([["share", share], ["save", save], ["csv", saveCsv], ["theme", switchTheme],
  ["theory", () => showTheory(data.documentation)], ["help", () => byId("help-dialog", HTMLDialogElement).showModal()]])) {
  byId(id, HTMLButtonElement).addEventListener("click", act);
}
chooser.replaceChildren(...data.rigs.map((rig) => make("option", { value: rig.scenario, text: rig.scenario, title: rig.description })));
chooser.addEventListener("change", () => { history.replaceState(null, "", `#${toHash(chooser.value, { settings: {}, changes: [] })}`); load(chooser.value); });
addEventListener("hashchange", start);

/** Start what the address holds, or the first scenario. */
function start() {
  try {
    const { scenario, deed } = fromHash(location.hash, session.rig.stepSize);
    load(scenario || data.rigs[0].scenario, deed);
  } catch (error) {
    load(data.rigs[0].scenario);
    showFailure(error instanceof Error ? error.message : String(error));
  }
}

/** @param {number} now */
function picture(now) {
  transport.draw(session, palette);
  view?.draw(now);
  if (!notice.hidden && now > noticeEnds) { notice.hidden = true; }
  requestAnimationFrame(picture);
}

start();
requestAnimationFrame(picture);
