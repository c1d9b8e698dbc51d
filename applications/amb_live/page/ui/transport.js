// Controls of time: run, pause, single step, reset, pace, and the time line.

import { touched } from "./advice.js";
import { byId, setText } from "./dom.js";
import { clockText, factorText, nameLabel, numberText } from "./format.js";
import { valueOf } from "./session.js";
import { endOfLine, Timeline } from "./timeline.js";

/** @typedef {import("./session.js").Session} Session */

/**
 * Functions that the buttons call.
 * @typedef {object} Actions
 * @property {(pace: number) => void} play
 * @property {() => void} pause
 * @property {() => void} step
 * @property {() => void} reset
 * @property {(time: number, keep: boolean) => void} go
 */

/** @typedef {ReturnType<typeof makeTransport>} Transport */

const DETENTS = [-3, -2, -1, 0, Math.log10(5)]; // 1/1000, 1/100, 1/10, 1, 5
const REACHED_SHARE = 0.9; // share of the requested pace that counts as reached
const TIMELINE_MS = 40; // between drawings of the time line
const SEEK_MS = 120; // between two requested times while the handle is dragged

/**
 * Connect the controls of time.
 * @param {Actions} actions
 * @param {() => Session} current
 */
export function makeTransport(actions, current) {
  const play = byId("play", HTMLButtonElement), pace = byId("pace", HTMLInputElement), seek = byId("seek", HTMLInputElement);
  const keep = byId("keep", HTMLInputElement), canvas = byId("line-canvas", HTMLCanvasElement);
  const clock = byId("clock", HTMLElement), cycle = byId("cycle", HTMLElement), achieved = byId("achieved", HTMLElement);
  let isDragging = false, lastSeek = 0, lastLine = -Infinity;
  const paceNow = () => 10 ** snapped(Number(pace.value));
  const isRunning = () => current().status === "playing" || current().status === "settling";
  const toggle = () => (isRunning() ? actions.pause() : actions.play(paceNow()));
  const showPace = () => {
    const text = factorText(paceNow());
    setText(byId("pace-text", HTMLOutputElement), text);
    pace.setAttribute("aria-valuetext", `${text} of real time`);
  };
  const applyPace = () => {
    showPace();
    if (current().status === "playing") { actions.play(paceNow()); }
  };
  play.addEventListener("click", toggle);
  byId("step", HTMLButtonElement).addEventListener("click", actions.step);
  byId("reset", HTMLButtonElement).addEventListener("click", actions.reset);
  pace.addEventListener("input", applyPace);
  seek.addEventListener("input", () => {
    isDragging = true;
    if (performance.now() - lastSeek > SEEK_MS) {
      lastSeek = performance.now();
      actions.go(Number(seek.value), keep.checked);
    }
  });
  seek.addEventListener("change", () => { isDragging = false; actions.go(Number(seek.value), keep.checked); });
  showPace();
  return {
    toggle,
    pace: paceNow,
    setPace: (/** @type {number} */ value) => { pace.value = String(Math.log10(value)); applyPace(); },
    change: (/** @type {number} */ decades) => { pace.value = String(Number(pace.value) + decades); applyPace(); },
    draw: (/** @type {Session} */ session, /** @type {import("./palette.js").Palette} */ palette, /** @type {number} */ now) => {
      play.classList.toggle("running", isRunning());
      play.setAttribute("aria-label", isRunning() ? "Pause" : "Run");
      setText(clock, clockText(session.time));
      setText(cycle, `cycle ${(session.time / session.rig.period).toFixed(2)}`);
      setText(achieved, statusText(session));
      const slow = slowness(session, paceNow());
      achieved.classList.toggle("slow", slow !== "");
      achieved.title = slow;
      setText(byId("slow", HTMLElement), slow);
      seek.max = String(endOfLine(session));
      seek.step = String(session.rig.stepSize);
      if (!isDragging) { seek.value = String(session.time); }
      seek.setAttribute("aria-valuetext", `${numberText(session.time, 4)} s`);
      if (now - lastLine > TIMELINE_MS) {
        lastLine = now;
        new Timeline(canvas, session, palette).draw();
      }
    },
  };
}

/**
 * Return a pace, snapped to a nearby marked one: 1/1000, 1/100, 1/10, real time, 5.
 * @param {number} decades
 */
export function snapped(decades) {
  return DETENTS.find((detent) => Math.abs(decades - detent) < 0.04) ?? decades;
}

/**
 * Return why the run is slower than requested and than real time; empty if it is not.
 * @param {Session} session
 * @param {number} requested simulated seconds in a second
 */
export function slowness(session, requested) {
  const { status, speed } = session;
  if (status !== "playing" || !(speed > 0) || speed >= Math.min(requested, 1) * REACHED_SHARE) { return ""; }
  const methods = session.variables.get("rotor_contact.solver.method")?.items ?? {}, used = valueOf(session, "rotor_contact.solver.method");
  const method = Object.entries(methods).find(([, value]) => value === used)?.[0].replaceAll("_", " ") ?? "";
  const sites = touched(session).map((name) => nameLabel(name)).join(" and ");
  const why = sites !== "" ? `contact at ${sites} takes many small steps` : method !== "" && method !== "exact" ? `its steps are computed by a slower method (${method})` : "this computer is too slow for so many modes";
  return `Slower than requested, ${factorText(speed)} of real time: ${why}.`;
}

/** @param {Session} session */
function statusText(session) {
  if (session.status === "loading" || session.status === "settling") { return "settling"; }
  if (session.status === "failed") { return "failed"; }
  if (session.status === "paused") { return "paused"; }
  return Number.isFinite(session.speed) && session.speed > 0 ? `of ${numberText(session.speed, 2)}× possible` : "running";
}
