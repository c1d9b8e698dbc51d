// The page: it starts a worker for a scenario, shows the computed motion, and sends the worker the user's changes.

import { fromHash, toHash } from "../engine/link.js";
import { showAnswer } from "./answers.js";
import { partsOf, readPageData, rigOf } from "./data.js";
import { byId, make, setText } from "./dom.js";
import { startEngine } from "./engine.js";
import { narrate, newNarrator } from "./events.js";
import { clockText, quantityText } from "./format.js";
import { newProgress } from "./guide.js";
import { listenToKeys } from "./keys.js";
import { addMessage, clearMessages, endNotice, showFailure, showNotice, showPending } from "./messages.js";
import { shownSites } from "./orbits.js";
import { readPalette } from "./palette.js";
import { startRedraw } from "./redraw.js";
import { makeSeeker } from "./seeker.js";
import { absorb, lasting, newSession } from "./session.js";
import { makeSharing, remember } from "./sharing.js";
import { watchedSignals } from "./signals.js";
import { listenToTheory, showTheory } from "./theory.js";
import { makeTransport } from "./transport.js";
import { chooseWindow, makeView } from "./view.js";

/** @typedef {import("../protocol.js").UserChanges} UserChanges */
/** @typedef {import("../protocol.js").Answer} Answer */

const UNTOUCHED = { settings: {}, changes: [] };

/**
 * Open the page with its data.
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
  let narrator = newNarrator(), progress = newProgress();
  let sitesOfView = ""; // sites that the view was made for

  const send = (/** @type {import("../protocol.js").Request} */ request) => engine?.send(request);
  const seeker = makeSeeker(() => session, send);
  const sitesShown = () => shownSites(session).map((site) => site.name).join();
  const updatePending = () => showPending(
    Object.keys(planned).filter((name) => session.variables.get(name)?.variability === "fixed"), reset,
    () => { planned = {}; updatePending(); });

  /**
   * Start a scenario, with the changes of a link, if any.
   * @param {string} scenario
   * @param {UserChanges} [userChanges]
   */
  async function load(scenario, userChanges) {
    engine?.end();
    view?.end();
    [engine, view, planned, waits] = [null, null, {}, true];
    [narrator, progress] = [newNarrator(), newProgress()];
    seeker.drop();
    const loaded = session = newSession(rigOf(data, scenario)), { rig } = session;
    chooser.value = rig.scenario;
    chooseWindow(rig);
    document.title = `Live rig: ${rig.scenario}`;
    setText(byId("description", HTMLElement), rig.description);
    setText(byId("origin", HTMLElement), originOf(rig));
    showFailure("");
    updatePending();
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
      if (answer.anew) { clearMessages(answer.time); }
      for (const { time, text } of narrate(narrator, session)) { addMessage(clockText(time), text, time); }
    }
    if (answer.type === "ready") { rebuild(); }
    if (answer.type === "frame" && waits && answer.status === "paused") { begin(); }
    showAnswer(answer);
  }

  /** Make the view again, in the present colours. */
  function rebuild() {
    palette = readPalette();
    wake();
    sitesOfView = sitesShown();
    if (session.status !== "loading") {
      view?.end();
      view = makeView(() => session, changes, () => palette, progress);
    }
  }

  /** Run or stay paused as the user chose, once the rotor has settled. */
  function begin() {
    waits = false;
    if (sitesShown() !== sitesOfView) { rebuild(); }
    if (plays) { send({ type: "play", pace: transport.pace() }); }
  }

  /** Restart with the present settings of the controls. */
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
    updatePending();
  }

  /** @type {import("./changes.js").Changes} */
  const changes = {
    set: (values) => { showFailure(""); send({ type: "set", values }); },
    plan: (values) => { planned = { ...planned, ...values }; updatePending(); },
    speed: (speed, acceleration) => { showFailure(""); send({ type: "speed", speed, acceleration }); },
    push: (disc, force) => {
      if (session.status === "paused" && Math.hypot(...force) > 0) { showNotice("The run is paused: a push moves the rotor while it runs (space)."); }
      send({ type: "push", disc, force });
    },
    run: () => { if (session.status === "paused") { transport.toggle(); } },
    planned: () => planned,
  };

  const transport = makeTransport({
    play: (pace) => { showFailure(""); plays = true; seeker.drop(); if (!waits) { send({ type: "play", pace }); } },
    pause: () => { plays = false; seeker.drop(); send({ type: "pause" }); },
    step: () => { plays = false; seeker.drop(); send({ type: "step" }); },
    reset,
    go: (time, keep) => { showFailure(""); seeker.go(time, keep); },
  }, () => session);

  /** Start the scenario in the address, or the first one. */
  function start() {
    try {
      const { scenario, userChanges } = fromHash(location.hash, session.rig.stepSize);
      void load(scenario || rigs[0].scenario, userChanges);
    } catch (error) {
      void load(rigs[0].scenario).then(() => showFailure(error instanceof Error ? error.message : String(error)));
    }
  }

  const wake = startRedraw(() => session.answerCount, (now) => {
    view?.draw(now);
    transport.draw(session, palette, now);
  }, endNotice);
  const { share, save, saveCsv } = makeSharing(() => session, send);
  matchMedia("(prefers-color-scheme: light)").addEventListener("change", rebuild);
  const help = () => byId("help-dialog", HTMLDialogElement).showModal(), theory = () => showTheory(documentation);
  listenToKeys(byId("keys", HTMLElement), [
    { key: "-", what: "slower", act: () => transport.change(-0.25) },
    { key: "+", what: "faster", act: () => transport.change(0.25) },
    { key: "1", what: "real time", act: () => transport.setPace(1) },
    { key: "0", what: "a tenth of real time", act: () => transport.setPace(0.1) },
  ]);
  listenToTheory(documentation);
  const buttons = { original: () => restart({}), share, save, csv: saveCsv, theory, help };
  for (const [id, act] of Object.entries(buttons)) { byId(id, HTMLButtonElement).addEventListener("click", act); }
  chooser.replaceChildren(...rigs.map((rig) => make("option", { value: rig.scenario, text: rig.scenario, title: rig.description })));
  chooser.addEventListener("change", () => {
    remember(toHash(chooser.value, UNTOUCHED));
    void load(chooser.value);
  });
  addEventListener("hashchange", start);
  start();
}

/**
 * Return version and source of the page as text.
 * @param {import("../protocol.js").Rig} rig
 */
function originOf(rig) {
  const source = rig.source === "" ? "" : ` Source: ${rig.source}.`;
  return `amb-cosim ${rig.version}.${source} The machine code of the FMUs as WebAssembly, coupled every ${quantityText(rig.stepSize, "s")} in this browser; no data leave it.`;
}

readPageData().then(open, (error) => showFailure(`the page is damaged: ${error}`));
