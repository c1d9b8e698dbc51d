// The orbit of the rotor's centre within the clearance of a retainer, seen from the motor, with vertical up.

import { arrow } from "./canvas.js";
import { faded } from "./palette.js";

/**
 * The content of an orbit view. Lengths in m, forces in N.
 * @typedef {object} OrbitScene
 * @property {number} clearance
 * @property {number} span half the width of the view
 * @property {number} rotation angle of the x axis on the screen, from the right, counter-clockwise (rad)
 * @property {Float32Array} x displacement from the centre of the clearance, oldest first
 * @property {Float32Array} y
 * @property {Float32Array} arcs largest recent normal force in each of equal sectors, from x towards y
 * @property {number} f_n
 * @property {number} f_t
 * @property {boolean} touching
 * @property {readonly [number, number]} push
 * @property {string} colour
 */

const TRAIL_PIECES = 28;
const FULL_FORCE = 4000; // N, an arc or arrow of full size

/**
 * Return the half-width (m) of a view that shows the clearance and the orbit.
 * @param {number} clearance m
 * @param {Float32Array} x m
 * @param {Float32Array} y m
 */
export function spanOf(clearance, x, y) {
  let largest = 0;
  for (let k = 0; k < x.length; k++) { largest = Math.max(largest, x[k] * x[k] + y[k] * y[k]); }
  return Math.max(1.34 * clearance, 1.1 * Math.sqrt(largest));
}

/**
 * Return the largest normal force in each of equal sectors of the clearance circle, including sectors passed between samples.
 * @param {Float32Array} x m
 * @param {Float32Array} y m
 * @param {Float32Array} force N
 * @param {number} sectors
 */
export function contactArcs(x, y, force, sectors) {
  const arcs = new Float32Array(sectors);
  const sectorAt = (/** @type {number} */ k) => Math.floor((0.5 * sectors * Math.atan2(y[k], x[k])) / Math.PI);
  for (let k = 0; k < force.length; k++) {
    if (force[k] > 0) {
      const last = sectorAt(k), first = k > 0 && force[k - 1] > 0 ? sectorAt(k - 1) : last;
      const between = (((last - first) % sectors) + 1.5 * sectors) % sectors - 0.5 * sectors; // sectors from first to last, the shorter way round
      for (let step = 0; step <= Math.abs(between); step++) {
        const sector = (((first + Math.sign(between) * step) % sectors) + sectors) % sectors;
        arcs[sector] = Math.max(arcs[sector], force[k]);
      }
    }
  }
  return arcs;
}

/**
 * Return the displacement in the rotor's axes at a point of the canvas.
 * @param {number} px pixels from the left
 * @param {number} py pixels from the top
 * @param {number} width
 * @param {number} height
 * @param {number} span m
 * @param {number} rotation rad
 * @returns {[number, number]} m
 */
export function fromCanvas(px, py, width, height, span, rotation) {
  const scale = span / (0.5 * Math.min(width, height));
  const [u, v] = [(px - 0.5 * width) * scale, (0.5 * height - py) * scale];
  const [c, s] = [Math.cos(rotation), Math.sin(rotation)];
  return [c * u + s * v, c * v - s * u];
}

/** An orbit view on a surface. */
export class OrbitPicture {
  /**
   * @param {import("./canvas.js").Surface} surface
   * @param {OrbitScene} scene
   * @param {import("./palette.js").Palette} palette
   */
  constructor({ context, width, height }, scene, palette) {
    this.context = context;
    this.scene = scene;
    this.palette = palette;
    this.scale = (0.5 * Math.min(width, height)) / scene.span;
    const [c, s] = [Math.cos(scene.rotation), Math.sin(scene.rotation)];
    this.at = (/** @type {number} */ x, /** @type {number} */ y) =>
      /** @type {[number, number]} */ ([0.5 * width + this.scale * (c * x - s * y), 0.5 * height - this.scale * (s * x + c * y)]);
  }

  draw() {
    this.drawAxes();
    this.drawClearance();
    this.drawTrail();
    this.drawRotor();
  }

  drawAxes() {
    const { context, scene, palette, at } = this, reach = 1.16 * scene.clearance;
    Object.assign(context, { lineWidth: 1, strokeStyle: palette.line, fillStyle: palette.soft, font: `italic 13px ${palette.font}`, textAlign: "center", textBaseline: "middle" });
    for (const [name, ux, uy] of /** @type {const} */ ([["x", 1, 0], ["y", 0, 1]])) {
      context.beginPath();
      context.moveTo(...at(-reach * ux, -reach * uy));
      context.lineTo(...at(reach * ux, reach * uy));
      context.stroke();
      context.fillText(name, ...at(1.25 * scene.clearance * ux, 1.25 * scene.clearance * uy));
      for (const share of [-0.5, 0.5]) {
        context.beginPath();
        context.arc(...at(share * scene.clearance * ux, share * scene.clearance * uy), 1.5, 0, 2 * Math.PI);
        context.fill();
      }
    }
  }

  drawClearance() {
    const { context, scene, palette } = this, [px, py] = this.at(0, 0), radius = this.scale * scene.clearance;
    Object.assign(context, { lineWidth: 1.75, strokeStyle: palette.ink });
    context.beginPath();
    context.arc(px, py, radius, 0, 2 * Math.PI);
    context.stroke();
    const sector = (2 * Math.PI) / scene.arcs.length;
    scene.arcs.forEach((force, k) => {
      if (force > 0) {
        const thickness = 2.5 + 9 * Math.min(Math.sqrt(force / FULL_FORCE), 1);
        const from = -(k * sector + scene.rotation);
        Object.assign(context, { lineWidth: thickness, strokeStyle: palette.touch });
        context.beginPath();
        context.arc(px, py, radius + 0.5 * thickness + 1, from - sector - 0.01, from + 0.01);
        context.stroke();
      }
    });
  }

  drawTrail() {
    const { context, scene, at } = this, count = scene.x.length, piece = Math.max(Math.ceil(count / TRAIL_PIECES), 1);
    Object.assign(context, { lineWidth: 1.8, lineJoin: "round" });
    for (let first = 0; first < count - 1; first += piece) {
      context.strokeStyle = faded(scene.colour, 0.1 + 0.9 * ((first + piece) / count) ** 1.6);
      context.beginPath();
      context.moveTo(...at(scene.x[first], scene.y[first]));
      for (let k = first + 1; k <= Math.min(first + piece, count - 1); k++) { context.lineTo(...at(scene.x[k], scene.y[k])); }
      context.stroke();
    }
  }

  drawRotor() {
    const { context, scene, palette, at } = this, last = scene.x.length - 1;
    if (last < 0) { return; }
    const [x, y] = [scene.x[last], scene.y[last]], [px, py] = at(x, y);
    const r = Math.hypot(x, y);
    if (scene.touching && r > 0) { // inward N, forward T
      const size = (0.6 * scene.clearance * Math.min(Math.sqrt(scene.f_n / FULL_FORCE), 1)) / r;
      arrow(context, px, py, ...at(x - size * x, y - size * y), palette.touch);
      const share = scene.f_n > 0 ? (size * scene.f_t) / scene.f_n : 0;
      arrow(context, px, py, ...at(x - share * y, y + share * x), palette.touch, 1.6);
    }
    const force = Math.hypot(...scene.push);
    if (force > 0) {
      const size = (scene.clearance * Math.min(force / 1000, 1.2)) / force;
      arrow(context, px, py, ...at(x + size * scene.push[0], y + size * scene.push[1]), palette.push, 3.5);
    }
    context.beginPath();
    context.arc(px, py, 6, 0, 2 * Math.PI);
    Object.assign(context, { fillStyle: scene.touching ? palette.touch : scene.colour, lineWidth: 2, strokeStyle: palette.ground });
    context.fill();
    context.stroke();
  }
}
