// All drawings of a session, created when the worker is ready, and drawn once for each frame of the screen.

import { surfaceOf } from "./canvas.js";
import { turned } from "./camera.js";
import { makeControls } from "./controls.js";
import { byId, setText } from "./dom.js";
import { makeGuide } from "./guide.js";
import { makeOrbits, rotationOf } from "./orbits.js";
import { observeVisibility } from "./seen.js";
import { settingOf, valueOf } from "./session.js";
import { enlargementOf, roomOf, ShaftPicture } from "./shaft.js";
import { makeSignals } from "./signals.js";
import { makeContacts, makeEnergies, makeFacts } from "./state.js";
import { makeSynchronous } from "./synchronous.js";

/** @typedef {import("./session.js").Session} Session */
/** @typedef {import("./palette.js").Palette} Palette */

const TEXT_MS = 100; // between updates of texts
const USUAL_WINDOW = 0.5; // s, of the curves
const YAW = { home: -1.15, step: 0.08 };

/** @typedef {ReturnType<typeof makeView>} View */

/**
 * Make the view of a session.
 * @param {() => Session} current
 * @param {import("./changes.js").Changes} changes
 * @param {() => Palette} palette
 * @param {import("./guide.js").Progress} progress
 */
export function makeView(current, changes, palette, progress) {
  const session = current(), colours = palette();
  const orbits = makeOrbits(byId("orbits", HTMLElement), session, changes.push);
  const shaft = makeShaft(current);
  const signals = makeSignals(byId("charts", HTMLElement), current, colours);
  const synchronous = makeSynchronous(byId("polar", HTMLCanvasElement), byId("synchronous", HTMLTableElement), session);
  const windowSelect = byId("window", HTMLSelectElement);
  const texts = [
    makeContacts(byId("contacts", HTMLElement), session), makeFacts(byId("control-state", HTMLElement), session),
    makeEnergies(byId("energies", HTMLElement)), makeGuide(byId("guide", HTMLElement), session, progress, changes.run), makeControls(byId("controls", HTMLElement), session, changes),
  ];
  setText(byId("enlargement", HTMLElement), `displacements enlarged ${enlargementOf(session.rig.geometry)} times${weightAlong(session)}`);
  let lastTexts = -Infinity;
  return {
    draw: (/** @type {number} */ now) => {
      orbits.draw(current(), colours);
      shaft.draw(colours);
      signals.draw(Number(windowSelect.value));
      if (now - lastTexts > TEXT_MS) {
        lastTexts = now;
        texts.forEach((update) => update(current()));
        synchronous(current(), colours);
      }
    },
    end: () => { signals.end(); shaft.end(); },
  };
}

/**
 * Return in words where a weight along the shaft pulls; nothing for a shaft that lies.
 * @param {Session} session
 */
function weightAlong(session) {
  const { geometry: { thrust, nodes } } = session.rig, tilt = settingOf(session, `rotor_contact.${thrust}.tilt`);
  if (!(Math.abs(tilt) > 1e-3)) { return ""; }
  return `, ${Math.abs(tilt) > 1.5 ? "weight" : "a part of the weight"} towards ${(tilt > 0 ? nodes[0] : nodes[nodes.length - 1]).z.toFixed(2)} m`;
}

/**
 * Choose the window of the curves for a scenario: half a second, or less for a shorter scenario.
 * @param {import("../protocol.js").Rig} rig
 */
export function chooseWindow(rig) {
  const windowSelect = byId("window", HTMLSelectElement), spans = [...windowSelect.options].map((option) => Number(option.value));
  windowSelect.value = String(Math.min(USUAL_WINDOW, spans.find((span) => span >= rig.last * rig.stepSize) ?? USUAL_WINDOW));
}

/**
 * Return the shaft view with its camera, which a drag or the arrow keys turn.
 * @param {() => Session} current
 */
function makeShaft(current) {
  const canvas = byId("shaft", HTMLCanvasElement), seen = observeVisibility(canvas), listeners = new AbortController(), { signal } = listeners;
  let room = 0;
  /** @type {import("./camera.js").Camera} */
  let camera = { yaw: YAW.home, pitch: 0.3, scale: 1, distance: 1, centre: [0, 0] };
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId), { signal });
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons === 1) { camera = turned(camera, 0.008 * event.movementX, 0.008 * event.movementY); }
  }, { signal });
  canvas.addEventListener("keydown", (event) => {
    const turns = { ArrowLeft: [-YAW.step, 0], ArrowRight: [YAW.step, 0], ArrowUp: [0, YAW.step], ArrowDown: [0, -YAW.step] }[event.key];
    if (turns !== undefined) {
      event.preventDefault();
      camera = turned(camera, turns[0], turns[1]);
    }
  }, { signal });
  return {
    end: () => { listeners.abort(); seen.end(); },
    draw: (/** @type {Palette} */ palette) => {
      if (!seen.isSeen()) { return; }
      const scene = sceneOf(current());
      const needed = roomOf(scene.geometry, scene.value, scene.enlargement);
      room = Math.max(needed, room + 0.01 * (needed - room)); // wider at once, narrower slowly
      new ShaftPicture(surfaceOf(canvas), { ...scene, room }, camera, palette).draw();
    },
  };
}

/**
 * @param {Session} session
 * @returns {Omit<import("./shaft.js").ShaftScene, "room">}
 */
function sceneOf(session) {
  const { geometry } = session.rig, setting = (/** @type {string} */ name) => settingOf(session, `rotor_contact.${name}`);
  return {
    geometry, rotation: rotationOf(geometry), enlargement: enlargementOf(geometry),
    along: valueOf(session, `rotor_contact.${geometry.thrust}.z`) || 0,
    value: (signal) => valueOf(session, signal),
    clearance: (site) => setting(`${site}.clearance`),
    enabled: (site) => setting(`${site}.enabled`) !== 0,
    angle: valueOf(session, "rotor_contact.theta") || 0,
    unbalances: geometry.discs.filter((item) => item.unbalance).map((item) => ({ name: item.name, u: setting(`${item.name}.u`) || 0, phi: setting(`${item.name}.phi`) || 0 })),
  };
}
