// The page: it starts a worker for a scenario, shows what it computes, and passes on what the user does.

import { csvOf } from "../engine/csv.js";
import { fromHash, toHash } from "../engine/link.js";
import { partsOf, readPageData, rigOf } from "./data.js";
import { byId, download, make, setText } from "./dom.js";
import { startEngine } from "./engine.js";
import { narrate, newNarrator } from "./events.js";
import { clockText, quantityText } from "./format.js";
import { newProgress } from "./guide.js";
import { listenToKeys } from "./keys.js";
import { addMessage, clearMessages, endNotice, showFailure, showNotice, showPending } from "./messages.js";
import { shownSites } from "./orbits.js";
import { readPalette } from "./palette.js";
import { makeSeeker } from "./seeker.js";
import { absorb, lasting, newSession } from "./session.js";
import { watchedSignals } from "./signals.js";
import { startTheme } from "./theme.js";
import { listenToTheory, showTheory } from "./theory.js";
import { columnsOf } from "./traces.js";
import { makeTransport } from "./transport.js";
import { chooseWindow, makeView } from "./view.js";

/** @typedef {import("../protocol.js").UserChanges} UserChanges */
/** @typedef {import("../protocol.js").Answer} Answer */

const REDRAW_MS = 1000; // ms that the page is drawn after anything happened
const UNTOUCHED = { settings: {}, changes: [] };

/**
 * Open the page with what is in it.
 * @param {import("./data.js").PageData} data
 */
function open(data) {
  const { documentation, rigs } = data.described;
  const script = byId("worker", HTMLScriptElement).text, chooser = byId("scenario", HTMLSelectElement);
  let session = newSession(rigOf(data, rigs[0].scenario));
  /** @type {import("./engine.js").Engine | null} */
  let engine = null;
  /** @type {import("./view.js").View | null} */
  let view = null;
  /** @type {Record<string, number>} */
  let planned = {};
  let palette = readPalette();
  let plays = !matchMedia("(prefers-reduced-motion: reduce)").matches; // once the rotor has settled
  let waits = true; // for it to settle
  let drawn = -1, rests = 0; // what was heard when it was drawn last, and when drawing may rest (ms)
  let narrator = newNarrator(), progress = newProgress();
  let shown = ""; // sites that the view was made for

  const send = (/** @type {import("../protocol.js").Request} */ request) => engine?.send(request);
  const seeker = makeSeeker(() => session, send);
  const sitesShown = () => shownSites(session).map((site) => site.name).join();
  const tellPending = () => showPending(
    Object.keys(planned).filter((name) => session.variables.get(name)?.variability === "fixed"), reset,
    () => { planned = {}; tellPending(); });

  /**
   * Start a scenario, with what was done if a link says so.
   * @param {string} scenario
   * @param {UserChanges} [userChanges]
   */
  async function load(scenario, userChanges) {
    engine?.end();
    view?.end();
    [engine, view, planned, waits] = [null, null, {}, true];
    [narrator, progress] = [newNarrator(), { ...newProgress(), experiment: progress.experiment }];
    seeker.drop();
    const loaded = session = newSession(rigOf(data, scenario)), { rig } = session;
    chooser.value = rig.scenario;
    chooseWindow(rig);
    document.title = `Live rig: ${rig.scenario}`;
    setText(byId("description", HTMLElement), rig.description);
    setText(byId("origin", HTMLElement), originOf(rig));
    showFailure("");
    tellPending();
    clearMessages();
    const parts = await partsOf(data, rig);
    if (session === loaded) {
      engine = startEngine(script, hear, showFailure);
      engine.send({ type: "load", rig, parts, userChanges, watched: watchedSignals(rig) });
    }
  }

  /** @param {Answer} answer */
  function hear(answer) {
    absorb(session, answer);
    if (answer.type === "refused" || answer.type === "failed") { seeker.drop(); }
    if (answer.type === "frame") {
      seeker.heard();
      for (const { time, text } of narrate(narrator, session)) { addMessage(clockText(time), text); }
    }
    if (answer.type === "ready") { rebuild(); }
    if (answer.type === "frame" && waits && answer.status === "paused") { begin(); }
    if (answer.type === "refused") { showFailure(answer.text); }
    if (answer.type === "failed") { showFailure(`${answer.component} at ${answer.time.toFixed(4)} s: ${answer.text}. Go back in time, or reset.`); }
    if (answer.type === "warning") { addMessage(answer.component, answer.text); }
    if (answer.type === "ended" && answer.reason !== "reached") { showNotice(answer.reason === "completed" ? "The scenario has ended here. Run goes on." : answer.text); }
    if (answer.type === "saved") {
      download(`${answer.name}.toml`, answer.toml, "application/toml");
      showNotice(`Saved ${answer.name}.toml: amb-cosim run ${answer.name}.toml repeats what was done.`);
    }
  }

  /** Make the view anew, in the colours that are in force. */
  function rebuild() {
    palette = readPalette();
    rests = performance.now() + REDRAW_MS;
    shown = sitesShown();
    if (session.status !== "loading") {
      view?.end();
      view = makeView(() => session, changes, () => palette, progress);
    }
  }

  /** Go on as the user wants, now that the rotor has settled. */
  function begin() {
    waits = false;
    if (sitesShown() !== shown) { rebuild(); }
    if (plays) { send({ type: "play", pace: transport.pace() }); }
  }

  /** Start anew as the controls stand. */
  function reset() {
    const { settings, changes: done } = session.userChanges;
    restart({ ...settings, values: { ...settings.values, ...lasting(done), ...planned } });
  }

  /** @param {import("../protocol.js").Settings} settings */
  function restart(settings) {
    showFailure("");
    clearMessages();
    [planned, waits, narrator] = [{}, true, newNarrator()];
    seeker.drop();
    send({ type: "reset", settings });
    tellPending();
  }

  /** @type {import("./changes.js").Changes} */
  const changes = {
    set: (values) => { showFailure(""); send({ type: "set", values }); },
    plan: (values) => { planned = { ...planned, ...values }; tellPending(); },
    speed: (speed, acceleration) => { showFailure(""); send({ type: "speed", speed, acceleration }); },
    push: (disc, force) => send({ type: "push", disc, force }),
    planned: () => planned,
  };

  const transport = makeTransport({
    play: (pace) => { showFailure(""); plays = true; seeker.drop(); if (!waits) { send({ type: "play", pace }); } },
    pause: () => { plays = false; seeker.drop(); send({ type: "pause" }); },
    step: () => { plays = false; seeker.drop(); send({ type: "step" }); },
    reset,
    go: (time, keep) => { showFailure(""); seeker.go(time, keep); },
  }, () => session);

  function share() {
    if (!hasAddress()) { showNotice("In this frame the page has no address of its own; Scenario saves what you did."); return; }
    remember(toHash(session.rig.scenario, session.userChanges));
    const refused = () => showNotice("The address now holds the settings: copy it from the bar.");
    const done = () => showNotice("The address now holds the settings, and is in the clipboard.");
    if (navigator.clipboard === undefined) { refused(); } else { navigator.clipboard.writeText(location.href).then(done, refused); }
  }

  function save() {
    send({ type: "save", name: `${session.rig.scenario}_live`, description: `${session.rig.description}; changed by hand` });
  }

  function saveCsv() {
    const unit = (/** @type {string} */ name) => (name === "time" ? "s" : session.variables.get(name)?.unit ?? "");
    download(`${session.rig.scenario}.csv`, csvOf(columnsOf(session.traces).map((column) => ({ ...column, unit: unit(column.name) }))), "text/csv");
  }

  /** Start what the address holds, or the first scenario. */
  function start() {
    try {
      const { scenario, userChanges } = fromHash(location.hash, session.rig.stepSize);
      void load(scenario || rigs[0].scenario, userChanges);
    } catch (error) {
      void load(rigs[0].scenario).then(() => showFailure(error instanceof Error ? error.message : String(error)));
    }
  }

  const switchTheme = startTheme(rebuild);
  const help = () => byId("help-dialog", HTMLDialogElement).showModal(), theory = () => showTheory(documentation);
  listenToKeys(byId("keys", HTMLElement), [
    { key: " ", shown: "space", what: "run or pause", act: transport.toggle },
    { key: "s", shown: "S", what: "single step of communication", act: () => byId("step", HTMLButtonElement).click() },
    { key: "r", shown: "R", what: "reset: start anew as the controls stand", act: reset },
    { key: "o", shown: "O", what: "the scenario without your changes", act: () => restart({}) },
    { key: "-", shown: "−", what: "slower", act: () => transport.change(-0.25) },
    { key: "+", shown: "+", what: "faster", act: () => transport.change(0.25) },
    { key: "1", shown: "1", what: "real time", act: () => transport.setPace(1) },
    { key: "0", shown: "0", what: "a tenth of real time", act: () => transport.setPace(0.1) },
    { key: "l", shown: "L", what: "copy a link that holds the settings", act: share },
    { key: "f", shown: "F", what: "save as a scenario", act: save },
    { key: "c", shown: "C", what: "save the curves as CSV", act: saveCsv },
    { key: "t", shown: "T", what: "theory", act: theory },
    { key: "d", shown: "D", what: "dark or light", act: switchTheme },
    { key: "?", shown: "?", what: "this help", act: help },
  ]);
  listenToTheory(documentation);
  const buttons = { original: () => restart({}), share, save, csv: saveCsv, theme: switchTheme, theory, help };
  for (const [id, act] of Object.entries(buttons)) { byId(id, HTMLButtonElement).addEventListener("click", act); }
  chooser.replaceChildren(...rigs.map((rig) => make("option", { value: rig.scenario, text: rig.scenario, title: rig.description })));
  chooser.addEventListener("change", () => {
    remember(toHash(chooser.value, UNTOUCHED));
    void load(chooser.value);
  });
  addEventListener("hashchange", start);
  start();

  /** @param {number} now ms */
  function picture(now) {
    if (session.heard !== drawn) { [drawn, rests] = [session.heard, now + REDRAW_MS]; }
    if (now < rests) {
      view?.draw(now);
      transport.draw(session, palette, now);
    }
    endNotice(now);
    requestAnimationFrame(picture);
  }
  const wake = () => { rests = performance.now() + REDRAW_MS; };
  for (const name of ["pointerdown", "pointermove", "keydown", "input", "click", "resize", "scroll"]) { addEventListener(name, wake, { passive: true, capture: true }); }
  requestAnimationFrame(picture);
}

/** Whether the page has an address of its own: not in a frame of a notebook. */
function hasAddress() {
  return location.protocol !== "about:";
}

/**
 * Put the settings into the address, where there is one.
 * @param {string} hash
 */
function remember(hash) {
  if (hasAddress()) { history.replaceState(null, "", `#${hash}`); }
}

/**
 * Return what the page says of itself.
 * @param {import("../protocol.js").Rig} rig
 */
function originOf(rig) {
  const source = rig.source === "" ? "" : ` Source: ${rig.source}.`;
  return `amb-cosim ${rig.version}.${source} The machine code of the FMUs as WebAssembly, coupled every ${quantityText(rig.stepSize, "s")} in this browser; nothing leaves it.`;
}

readPageData().then(open, (error) => showFailure(`the page is damaged: ${error}`));
