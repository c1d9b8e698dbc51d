// The shaft in space, with enlarged deflection, discs, magnets, retainers and unbalances.

import { fitted, projection } from "./camera.js";
import { nameLabel } from "./format.js";
import { mixed } from "./palette.js";
import { disc, face, ring, tube } from "./solids.js";

/** @typedef {import("../protocol.js").Geometry} Geometry */
/** @typedef {import("./solids.js").Face} Face */

/**
 * The content of the shaft view.
 * @typedef {object} ShaftScene
 * @property {Geometry} geometry
 * @property {(signal: string) => number} value newest value of a signal
 * @property {(site: string) => number} clearance m
 * @property {(site: string) => boolean} enabled
 * @property {number} rotation angle of the x axis on the screen (rad)
 * @property {number} angle of the rotor (rad)
 * @property {readonly { name: string, u: number, phi: number }[]} unbalances kg m, rad
 * @property {number} enlargement of displacements
 * @property {number} along displacement along the shaft (m)
 * @property {number} room across the shaft that is displayed (m)
 */

const SLEEVE = 0.009, BESIDE = 0.014, BELOW = 0.022; // of the shaft's length: thickness of a journal as drawn, a magnet beside its gap, a name below it
const LINE = 15; // pixels, height of a name
const MOST_CURRENT = 10; // A, of a magnet in full colour

/**
 * Return the enlargement of displacements, at which the smallest clearance is a visible share of the largest disc.
 * @param {Geometry} geometry
 */
export function enlargementOf(geometry) {
  const clearance = Math.min(...geometry.sites.map((site) => site.clearance), 1e-3);
  const length = geometry.nodes[geometry.nodes.length - 1].z - geometry.nodes[0].z;
  const radius = Math.max(...geometry.discs.map((item) => item.radius), 0.02 * length);
  const exact = (0.5 * radius) / clearance, decade = 10 ** Math.floor(Math.log10(exact));
  return decade * (exact / decade >= 5 ? 5 : exact / decade >= 2 ? 2 : 1);
}

/**
 * Return the room across the shaft that its picture requires: the largest reach of a disc or a node (m).
 * @param {Geometry} geometry
 * @param {(signal: string) => number} value
 * @param {number} enlargement
 */
export function roomOf(geometry, value, enlargement) {
  const bent = deflection(geometry, value), length = geometry.nodes[geometry.nodes.length - 1].z - geometry.nodes[0].z;
  const out = (/** @type {[number, number]} */ [x, y]) => enlargement * Math.hypot(x, y);
  const discs = geometry.discs.map((item) => item.radius + out(bent.at(item.z)));
  return Math.max(...discs, ...geometry.nodes.map((node, k) => node.radius + out(bent.nodes[k])), 0.08 * length) + 0.025 * length;
}

/**
 * Return the displacement of each node, and a function that interpolates it linearly between nodes.
 * @param {Geometry} geometry
 * @param {(signal: string) => number} value
 * @returns {{ nodes: [number, number][], at: (z: number) => [number, number] }} m, in the rotor's axes
 */
export function deflection(geometry, value) {
  const { places, rows } = geometry.shape;
  const displacements = places.map((place) => [value(place.x) || 0, value(place.y) || 0]);
  const nodes = rows.map((row) => /** @type {[number, number]} */ ([0, 1].map((axis) =>
    row.reduce((sum, share, j) => sum + share * displacements[j][axis], 0))));
  const z = geometry.nodes.map((node) => node.z);
  return {
    nodes,
    at: (place) => {
      const k = Math.min(Math.max(z.findIndex((item) => item >= place), 1), z.length - 1);
      const share = Math.min(Math.max((place - z[k - 1]) / (z[k] - z[k - 1]), 0), 1);
      const [[x0, y0], [x1, y1]] = [nodes[k - 1], nodes[k]];
      return [x0 + share * (x1 - x0), y0 + share * (y1 - y0)];
    },
  };
}

/**
 * Return names in rows that do not overlap: each moves by its steps away from the drawing until it is free.
 * @template {{ x: number, y: number, step: number, half: number }} Name
 * @param {readonly Name[]} names with the middle of their lower side, and half their width (pixels)
 */
export function apart(names) {
  /** @type {Name[]} */
  const placed = [];
  for (const name of names) {
    const overlaps = (/** @type {number} */ y) => placed.some((other) => Math.abs(other.x - name.x) < other.half + name.half && Math.abs(other.y - y) < LINE);
    let y = name.y;
    while (overlaps(y)) { y += name.step; }
    placed.push({ ...name, y });
  }
  return placed;
}

/** The shaft view: rig coordinates, turned and enlarged, on a surface. */
export class ShaftPicture {
  /**
   * @param {import("./canvas.js").Surface} surface
   * @param {ShaftScene} scene
   * @param {import("./camera.js").Camera} camera
   * @param {import("./palette.js").Palette} palette
   */
  constructor({ context, width, height }, scene, camera, palette) {
    this.context = context;
    this.scene = scene;
    this.palette = palette;
    this.geometry = scene.geometry;
    const { nodes } = scene.geometry;
    this.z0 = nodes[0].z;
    this.z1 = nodes[nodes.length - 1].z;
    this.length = this.z1 - this.z0;
    const eye = projection(fitted(camera, this.length, scene.room, width, height)), middle = 0.5 * (this.z0 + this.z1);
    this.project = (/** @type {number} */ place, /** @type {number} */ u, /** @type {number} */ v) => eye(middle - place, u, v);
    this.bent = deflection(scene.geometry, scene.value);
    this.along = scene.enlargement * scene.along;
  }

  draw() {
    const { geometry, scene, palette, project, context } = this, turn = scene.angle + scene.rotation;
    const colours = { metal: palette.metal, dark: palette.ground < "#888888" ? "#10151b" : "#3a4653", bright: "#ffffff" };
    /** @type {Face[]} */
    const faces = tube(geometry.nodes.map((node, k) => ({ z: node.z + this.along, ...this.across(this.bent.nodes[k]), radius: node.radius })), project, turn, colours);
    for (const item of geometry.discs.filter((body) => body.radius > 0 && (body.unbalance || !this.isCore(body.z)))) {
      faces.push(...disc(this.place(item.z), item.radius, item.width, project, turn, colours, 6));
    }
    for (const unbalance of scene.unbalances) { faces.push(...this.heavySpot(unbalance)); }
    geometry.bearings.forEach((bearing, k) => {
      faces.push(...disc(this.place(bearing.z), this.journalRadius(bearing.z), 0.035 * this.length, project, turn, colours));
      faces.push(...this.magnets(bearing, palette.series[k % palette.series.length]));
    });
    for (const site of geometry.sites.filter((item) => scene.enabled(item.name))) { faces.push(...this.retainer(site)); }
    for (const item of geometry.faces.filter((one) => scene.enabled(one.name))) { faces.push(...this.seat(item)); }
    this.drawFloor();
    faces.sort((a, b) => b.depth - a.depth).forEach((item) => item.draw(context));
    this.drawLabels();
  }

  /** Return a displacement (m) in the rotor's axes, enlarged on the screen. @param {readonly number[]} xy */
  across([x, y]) {
    const { enlargement, rotation } = this.scene, [c, s] = [Math.cos(rotation), Math.sin(rotation)];
    return { u: enlargement * (c * x - s * y), v: enlargement * (s * x + c * y) };
  }

  /** Return where the part of the shaft at a place is drawn. @param {number} z */
  place(z) {
    return { z: z + this.along, ...this.across(this.bent.at(z)), radius: 0 };
  }

  /** Whether a body is the core of a bearing, which the view leaves out so that its retainer can be seen. @param {number} z */
  isCore(z) {
    return this.geometry.bearings.some((bearing) => Math.abs(bearing.z - z) < 1e-6);
  }

  /** @param {number} z */
  journalRadius(z) {
    const node = this.geometry.nodes.filter((item) => item.z <= z + 1e-9).pop() ?? this.geometry.nodes[0];
    return node.radius + SLEEVE * this.length;
  }

  /**
   * Return the ring of a retainer or bush at the enlarged clearance, beside a disc at its place, coloured during contact.
   * @param {import("../protocol.js").Site} site
   */
  retainer(site) {
    const { geometry, length, scene, palette } = this, isBearing = this.isCore(site.z);
    const beside = geometry.discs.find((body) => Math.abs(body.z - site.z) < 0.02 * length && body.radius > 0);
    const step = isBearing ? 0.03 * length : beside !== undefined ? 0.5 * beside.width + 0.025 * length : 0;
    const z = site.z + (site.z < this.z0 + 0.5 * length ? step : -step), radius = isBearing ? this.journalRadius(site.z) : site.radius;
    const isTouched = scene.value(`rotor_contact.${site.name}.f_n`) > 0;
    return ring(z, radius + scene.enlargement * scene.clearance(site.name), 0, 2 * Math.PI, this.project, isTouched ? palette.touch : palette.ink, isTouched ? 4.5 : 2.2);
  }

  /**
   * Return the ring of a seat at the enlarged clearance from its face, coloured during contact.
   * @param {import("../protocol.js").Face} item
   */
  seat(item) {
    const { scene, palette } = this, z = this.seatAt(item), isTouched = scene.value(`rotor_contact.${item.name}.f_n`) > 0;
    return ring(z, Math.max(item.radius, this.journalRadius(item.z)), 0, 2 * Math.PI, this.project, isTouched ? palette.touch : palette.soft, isTouched ? 4.5 : 2.2);
  }

  /** @param {import("../protocol.js").Face} item */
  seatAt(item) {
    return item.z + item.stops * this.scene.enlargement * this.scene.clearance(item.name);
  }

  /**
   * Return the enlarged gap of a bearing (m): the clearance of its retainer or, without a retainer, the smallest one.
   * @param {Geometry["bearings"][number]} bearing
   */
  gapOf(bearing) {
    const { sites } = this.geometry, protecting = sites.filter((item) => item.name === bearing.retainer);
    const clearances = (protecting.length > 0 ? protecting : sites).map((item) => this.scene.clearance(item.name));
    return this.scene.enlargement * (clearances.length > 0 ? Math.min(...clearances) : 1e-3);
  }

  /**
   * Return the four magnets of a bearing, with more colour at more current.
   * @param {Geometry["bearings"][number]} bearing
   * @param {string} colour
   */
  magnets(bearing, colour) {
    if (!bearing.magnetic) { return []; }
    const { scene, palette } = this, distance = this.journalRadius(bearing.z) + this.gapOf(bearing) + BESIDE * this.length;
    return ["upper_x", "upper_y", "lower_x", "lower_y"].flatMap((coil, k) => {
      const current = scene.value(`amb_actuator.${bearing.name}.i_${coil}`);
      if (!Number.isFinite(current)) { return []; }
      const turn = scene.rotation + 0.5 * Math.PI * k, share = Math.min(Math.abs(current) / MOST_CURRENT, 1);
      return ring(bearing.z, distance, turn - 0.42, turn + 0.42, this.project, mixed(palette.line, colour, share), 7);
    });
  }

  /** Return the mark of a disc's unbalance, which grows with it. @param {ShaftScene["unbalances"][number]} unbalance */
  heavySpot({ name, u, phi }) {
    const { scene, palette } = this, body = scene.geometry.discs.find((item) => item.name === name);
    if (body === undefined || u <= 0 || body.radius <= 0) { return []; }
    const size = body.radius * Math.min(0.08 + 0.9 * Math.sqrt(u), 0.34);
    const turn = scene.rotation + scene.angle + phi, at = this.place(body.z), out = 0.72 * body.radius;
    return [-1, 1].flatMap((side) => {
      const corners = Array.from({ length: 16 }, (_, k) => {
        const around = (-side * 2 * Math.PI * k) / 16;
        return this.project(at.z + 0.52 * side * body.width, at.u + out * Math.cos(turn) + size * Math.cos(around),
                            at.v + out * Math.sin(turn) + size * Math.sin(around));
      });
      return face(corners.reverse(), palette.push, palette.push, -0.02);
    });
  }

  drawFloor() {
    const { context, palette, project, z0, z1, length } = this, level = -1.2 * this.scene.room;
    const step = length > 1 ? 0.5 : length > 0.4 ? 0.2 : 0.1, half = 0.12 * length;
    const line = (/** @type {readonly number[]} */ a, /** @type {readonly number[]} */ b) => {
      context.beginPath();
      context.moveTo(a[0], a[1]);
      context.lineTo(b[0], b[1]);
      context.stroke();
    };
    context.strokeStyle = palette.line;
    context.lineWidth = 1;
    for (const u of [-half, 0, half]) { line(project(z0, u, level), project(z1, u, level)); }
    Object.assign(context, { fillStyle: palette.soft, font: `12px ${palette.font}`, textAlign: "center", textBaseline: "top" });
    for (let z = Math.ceil(z0 / step - 1e-9) * step; z <= z1 + 1e-9; z += step) {
      line(project(z, -half, level), project(z, half, level));
      const [x, y] = project(z, half, level);
      context.fillText(`${Number(z.toFixed(2))} m`, x, y + 14);
    }
  }

  drawLabels() {
    const { context, geometry, palette } = this;
    Object.assign(context, { textAlign: "center", textBaseline: "bottom", font: `600 12px ${palette.font}` });
    const above = geometry.discs.filter((body) => body.unbalance && body.radius > 0).map((item) => {
      const { z, u, v } = this.place(item.z), [x, y] = this.project(z, u, v + item.radius);
      return { text: nameLabel(item.name), x, y: y - 4, step: -LINE, colour: palette.soft };
    });
    const below = geometry.bearings.map((bearing, k) => {
      const [x, y] = this.project(bearing.z, 0, -this.journalRadius(bearing.z) - this.gapOf(bearing) - BELOW * this.length);
      return { text: nameLabel(bearing.name), x, y: y + 16, step: LINE, colour: palette.series[k % palette.series.length] };
    });
    const names = [...above, ...below].map((name) => ({ ...name, half: 0.5 * context.measureText(name.text).width + 3 }));
    for (const { text, x, y, colour } of apart(names)) {
      context.fillStyle = colour;
      this.write(text, x, y);
    }
  }

  /**
   * Write a name with a border in the colour of the background, so that it is legible over the drawing.
   * @param {string} text
   * @param {number} x
   * @param {number} y
   */
  write(text, x, y) {
    const { context, palette } = this;
    Object.assign(context, { lineJoin: "round", lineWidth: 4, strokeStyle: palette.panel });
    context.strokeText(text, x, y);
    context.fillText(text, x, y);
  }
}
