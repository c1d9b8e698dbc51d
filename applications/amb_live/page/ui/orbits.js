// The panel of orbits: a view for each retainer and bush that the rotor can touch, in which the user can push it.

import { surfaceOf } from "./canvas.js";
import { make, setText } from "./dom.js";
import { nameLabel, quantityText } from "./format.js";
import { contactArcs, fromCanvas, OrbitPicture, spanOf } from "./orbit.js";
import { seriesOfSite } from "./palette.js";
import { matching, settingOf, valueOf } from "./session.js";

const SECTORS = 120;
const TRAIL_REVOLUTIONS = 3;
const MAX_TRAIL_SECONDS = 0.5;
const USUAL_PUSH = 1000; // N for a drag of a clearance, where the stiffness of the bearings is unknown
const PUSH_FACTOR = 1.3; // push for a drag of a clearance, over the bearing's stiffness times the clearance
/** @type {Record<string, [number, number]>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** @typedef {import("./session.js").Session} Session */
/** @typedef {import("../protocol.js").Site} Site */

/**
 * @typedef {object} OrbitView
 * @property {Site} site
 * @property {string} disc that a push acts on
 * @property {HTMLElement} element
 * @property {HTMLCanvasElement} canvas
 * @property {HTMLElement} force
 * @property {HTMLElement} scale
 * @property {number} span m
 * @property {[number, number]} push N
 */

/** @typedef {ReturnType<typeof makeOrbits>} Orbits */

/**
 * Return the angle of the x axis on the screen, such that gravity pulls down.
 * @param {import("../protocol.js").Geometry} geometry
 * @returns {number} rad
 */
export function rotationOf(geometry) {
  return -0.5 * Math.PI - geometry.gravityAngle;
}

/**
 * Return the sites that have a view: those where the rotor can touch.
 * @param {Session} session
 */
export function shownSites(session) {
  return session.rig.geometry.sites.filter((site) => settingOf(session, `rotor_contact.${site.name}.enabled`) !== 0);
}

/**
 * Return the disc nearest to a position, on which a push there acts; empty without discs.
 * @param {import("../protocol.js").Geometry} geometry
 * @param {number} z m
 */
export function nearestDisc(geometry, z) {
  const discs = geometry.discs.filter((item) => item.unbalance);
  return discs.reduce((best, item) => (best === undefined || Math.abs(item.z - z) < Math.abs(best.z - z) ? item : best), discs[0])?.name ?? "";
}

/**
 * Return the push (N) for a drag of one clearance: a little above the stiffness force of the bearings, in steps of 1, 2 and 5.
 * @param {Session} session
 */
function pushScale(session) {
  const stiffness = matching(session, "rolac_controller.*.k_b_?").map((name) => settingOf(session, name)).filter((item) => item > 0);
  const clearances = session.rig.geometry.sites.map((site) => site.clearance);
  const wanted = PUSH_FACTOR * Math.max(...stiffness) * Math.max(...clearances);
  if (!(wanted > 0 && Number.isFinite(wanted))) { return USUAL_PUSH; }
  const decade = 10 ** Math.floor(Math.log10(wanted));
  return decade * ([10, 5, 2, 1].find((step) => step * decade <= 1.15 * wanted) ?? 1);
}

/**
 * Fill the panel of orbits.
 * @param {HTMLElement} panel
 * @param {Session} session
 * @param {(disc: string, force: [number, number]) => void} onPush
 */
export function makeOrbits(panel, session, onPush) {
  const { geometry } = session.rig, rotation = rotationOf(geometry);
  const views = shownSites(session).map((site) => makeView(site, nearestDisc(geometry, site.z)));
  panel.classList.toggle("many", views.length > 2);
  panel.replaceChildren(...views.map((view) => view.element));
  const apply = (/** @type {OrbitView} */ view, /** @type {[number, number]} */ force) => {
    view.push = force;
    onPush(view.disc, force);
  };
  for (const view of views.filter((item) => item.disc !== "")) { listen(view, session, rotation, apply); }
  return {
    draw: (/** @type {Session} */ now, /** @type {import("./palette.js").Palette} */ palette) => {
      for (const view of views) { drawView(view, now, rotation, palette); }
    },
  };
}

/**
 * @param {Site} site
 * @param {string} disc
 * @returns {OrbitView}
 */
function makeView(site, disc) {
  const canvas = make("canvas", { tabindex: "0", role: "img" });
  canvas.setAttribute("aria-label", `Orbit at ${nameLabel(site.name)}${disc ? `; drag, or hold an arrow key, to push ${nameLabel(disc)}` : ""}`);
  const force = make("span", { class: "force" }), scale = make("span", { class: "scale" });
  const element = make("div", { class: "orbit" }, [canvas, make("span", { class: "tag", text: nameLabel(site.name) }), force, scale]);
  return { site, disc, element, canvas, force, scale, span: 1e-3, push: [0, 0] };
}

/**
 * @param {OrbitView} view
 * @param {Session} session
 * @param {number} rotation
 * @param {(view: OrbitView, force: [number, number]) => void} apply
 */
function listen(view, session, rotation, apply) {
  const { canvas } = view;
  let grabbed = false;
  const pull = (/** @type {PointerEvent} */ event) => {
    const box = canvas.getBoundingClientRect();
    const [x, y] = fromCanvas(event.clientX - box.left, event.clientY - box.top, box.width, box.height, view.span, rotation);
    const scale = pushScale(session) / settingOf(session, `rotor_contact.${view.site.name}.clearance`);
    apply(view, [scale * (x - valueOf(session, view.site.x)), scale * (y - valueOf(session, view.site.y))]);
  };
  const release = () => {
    if (grabbed) { grabbed = false; apply(view, [0, 0]); }
  };
  canvas.addEventListener("pointerdown", (event) => { grabbed = true; canvas.setPointerCapture(event.pointerId); pull(event); });
  canvas.addEventListener("pointermove", (event) => { if (grabbed) { pull(event); } });
  for (const name of /** @type {const} */ (["pointerup", "pointercancel"])) { canvas.addEventListener(name, release); }
  canvas.addEventListener("keydown", (event) => {
    const direction = ARROWS[event.key];
    if (direction === undefined) { return; }
    event.preventDefault();
    if (event.repeat) { return; }
    const [c, s] = [Math.cos(rotation), Math.sin(rotation)], [u, v] = direction, size = 0.5 * pushScale(session);
    apply(view, [size * (c * u + s * v), size * (c * v - s * u)]);
  });
  for (const name of /** @type {const} */ (["keyup", "blur"])) {
    canvas.addEventListener(name, () => { if (!grabbed && (view.push[0] !== 0 || view.push[1] !== 0)) { apply(view, [0, 0]); } });
  }
}

/** @param {OrbitView} view @param {Session} session @param {number} rotation @param {import("./palette.js").Palette} palette */
function drawView(view, session, rotation, palette) {
  const name = `rotor_contact.${view.site.name}`, colour = palette.series[seriesOfSite(session.rig.geometry, view.site)];
  const omega = Math.abs(valueOf(session, "rotor_contact.speed")) || 100;
  const from = session.time - Math.min((TRAIL_REVOLUTIONS * 2 * Math.PI) / omega, MAX_TRAIL_SECONDS);
  const [x, y] = [view.site.x, view.site.y].map((signal) => {
    const path = session.traces.between(signal, from, session.time), now = valueOf(session, signal);
    return path.length === 0 && Number.isFinite(now) ? Float32Array.of(now) : path; // no samples before the first step
  });
  const force = session.traces.between(`${name}.f_n_peak`, from, session.time);
  const clearance = settingOf(session, `${name}.clearance`), f_n = valueOf(session, `${name}.f_n`);
  const wanted = spanOf(clearance, x, y);
  view.span = wanted > view.span || view.span > 1.6 * wanted ? wanted : view.span + 0.05 * (wanted - view.span);
  const touching = valueOf(session, `${name}.mode`) > 0;
  new OrbitPicture(surfaceOf(view.canvas), {
    clearance, span: view.span, rotation, x, y, arcs: contactArcs(x, y, force, SECTORS),
    f_n, f_t: valueOf(session, `${name}.f_t`), touching, push: view.push, colour,
  }, palette).draw();
  const pushing = Math.hypot(...view.push);
  view.element.classList.toggle("touching", touching);
  setText(view.force, pushing > 0 ? `push ${quantityText(pushing, "N")} on ${nameLabel(view.disc)}`
    : touching ? `N = ${quantityText(f_n, "N")}` : `gap ${quantityText(valueOf(session, `${name}.gap`), "m")}`);
  setText(view.scale, `circle ${quantityText(clearance, "m")}`);
}
