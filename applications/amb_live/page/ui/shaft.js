// The shaft in space: its deflection many times enlarged, with discs, magnets, retainers and moving parts.

import { fitted, projection } from "./camera.js";
import { mixed } from "./palette.js";
import { disc, face, ring, tube } from "./solids.js";

/** @typedef {import("../protocol.js").Geometry} Geometry */
/** @typedef {import("./solids.js").Face} Face */

/**
 * What the shaft view shows besides the rotor itself.
 * @typedef {object} ShaftScene
 * @property {Geometry} geometry
 * @property {(signal: string) => number} value newest value of a signal
 * @property {(site: string) => number} clearance m
 * @property {(site: string) => boolean} enabled
 * @property {number} rotation angle of the x axis on the screen (rad)
 * @property {number} angle of the rotor (rad)
 * @property {readonly { name: string, u: number, phi: number }[]} unbalances kg m, rad
 * @property {number} enlargement of displacements
 * @property {number} room across the shaft that is displayed (m)
 */

const SLEEVE = 0.018; // m, thickness of the journal as drawn on the shaft
const MOST_CURRENT = 10; // A, a magnet of full colour

/**
 * Return by how much displacements are enlarged: the smallest clearance is as wide as a share of the largest disc.
 * @param {Geometry} geometry
 */
export function enlargementOf(geometry) {
  const clearance = Math.min(...geometry.sites.map((site) => site.clearance), 1e-3);
  const radius = Math.max(...geometry.discs.map((item) => item.radius), 0.04);
  const exact = (0.5 * radius) / clearance, decade = 10 ** Math.floor(Math.log10(exact));
  return decade * (exact / decade >= 5 ? 5 : exact / decade >= 2 ? 2 : 1);
}

/**
 * Return how much room across the shaft its picture needs: the farthest that a disc or a node reaches (m).
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
 * Return the displacement of each node, and of a place on the shaft by linear interpolation between nodes.
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
 * Draw the shaft view, and return the camera that fits it.
 * @param {import("./canvas.js").Surface} surface
 * @param {ShaftScene} scene
 * @param {import("./camera.js").Camera} camera
 * @param {import("./palette.js").Palette} palette
 */
export function drawShaft(surface, scene, camera, palette) {
  const { context, width, height } = surface, { geometry } = scene;
  const z = geometry.nodes.map((node) => node.z), length = z[z.length - 1] - z[0], middle = 0.5 * (z[0] + z[z.length - 1]);
  const reach = scene.room;
  const eye = projection(fitted(camera, length, reach, width, height));
  const project = (/** @type {number} */ place, /** @type {number} */ u, /** @type {number} */ v) => eye(middle - place, u, v);
  const [c, s] = [Math.cos(scene.rotation), Math.sin(scene.rotation)];
  const across = (/** @type {readonly number[]} */ [x, y]) => /** @type {[number, number]} */ ([
    scene.enlargement * (c * x - s * y), scene.enlargement * (s * x + c * y)]);
  const bent = deflection(geometry, scene.value);
  const place = (/** @type {number} */ at, radius = 0) => {
    const [u, v] = across(bent.at(at));
    return { z: at, u, v, radius };
  };
  const isDark = palette.ground < "#888888";
  const colours = { metal: palette.metal, dark: isDark ? "#10151b" : "#3a4653", bright: "#ffffff" };
  /** @type {Face[]} */
  const faces = [];

  faces.push(...tube(geometry.nodes.map((node, k) => {
    const [u, v] = across(bent.nodes[k]);
    return { z: node.z, u, v, radius: node.radius };
  }), project, scene.angle + scene.rotation, colours));
  for (const item of geometry.discs.filter((body) => body.radius > 0 && (body.unbalance || !isCore(geometry, body.z)))) {
    faces.push(...disc(place(item.z), item.radius, item.width, project, scene.angle + scene.rotation, colours, 6));
  }
  for (const unbalance of scene.unbalances) { faces.push(...heavySpot(unbalance, scene, place, project, palette)); }
  geometry.bearings.forEach((bearing, k) => {
    const radius = journalRadius(geometry, bearing.z);
    faces.push(...disc(place(bearing.z), radius, 0.035 * length, project, scene.angle + scene.rotation, colours));
    faces.push(...magnets(bearing, scene, radius, project, palette.series[k % palette.series.length], palette));
  });
  for (const site of geometry.sites.filter((item) => scene.enabled(item.name))) { faces.push(...retainer(site, scene, project, palette)); }

  drawFloor(context, z[0], z[z.length - 1], -1.2 * reach, project, palette);
  faces.sort((a, b) => b.depth - a.depth).forEach((item) => item.draw(context));
  drawLabels(context, scene, place, project, palette);
}

/** Whether a body is the core of a bearing, which the view leaves out so that its retainer can be seen.
 * @param {Geometry} geometry @param {number} z */
function isCore(geometry, z) {
  return geometry.bearings.some((bearing) => Math.abs(bearing.z - z) < 1e-6);
}

/** @param {Geometry} geometry @param {number} z */
function journalRadius(geometry, z) {
  const node = geometry.nodes.filter((item) => item.z <= z + 1e-9).pop() ?? geometry.nodes[0];
  return node.radius + SLEEVE;
}

/** Where a ring of a site is drawn: beside what the shaft carries at its place.
 * @param {Geometry} geometry @param {import("../protocol.js").Site} site */
function ringPlace(geometry, site) {
  const length = geometry.nodes[geometry.nodes.length - 1].z - geometry.nodes[0].z;
  const isBearing = isCore(geometry, site.z), middle = geometry.nodes[0].z + 0.5 * length;
  const beside = geometry.discs.find((body) => Math.abs(body.z - site.z) < 0.02 * length && body.radius > 0);
  const step = isBearing ? 0.03 * length : beside !== undefined ? 0.5 * beside.width + 0.025 * length : 0;
  return { z: site.z + (site.z < middle ? step : -step), radius: isBearing ? journalRadius(geometry, site.z) : site.radius };
}

/**
 * A retainer or bush: its ring at the enlarged clearance, coloured while it is touched.
 * @param {import("../protocol.js").Site} site
 * @param {ShaftScene} scene
 * @param {import("./solids.js").Project} project
 * @param {import("./palette.js").Palette} palette
 */
function retainer(site, scene, project, palette) {
  const { z, radius } = ringPlace(scene.geometry, site);
  const isTouched = scene.value(`rotor_contact.${site.name}.f_n`) > 0;
  const colour = isTouched ? palette.touch : palette.ink;
  return ring(z, [0, 0], radius + scene.enlargement * scene.clearance(site.name), 0, 2 * Math.PI, project, colour, isTouched ? 4.5 : 2.2);
}

/**
 * Return the enlarged gap of a bearing (m): the clearance of its retainer or, without a retainer, the least of all.
 * @param {Geometry["bearings"][number]} bearing
 * @param {ShaftScene} scene
 */
function gapOf(bearing, scene) {
  const { sites } = scene.geometry, protecting = sites.filter((item) => item.name === bearing.retainer);
  const clearances = (protecting.length > 0 ? protecting : sites).map((item) => scene.clearance(item.name));
  return scene.enlargement * (clearances.length > 0 ? Math.min(...clearances) : 1e-3);
}

/**
 * The four magnets of a bearing: the more current, the more colour.
 * @param {Geometry["bearings"][number]} bearing
 * @param {ShaftScene} scene
 * @param {number} radius m
 * @param {import("./solids.js").Project} project
 * @param {string} colour
 * @param {import("./palette.js").Palette} palette
 */
function magnets(bearing, scene, radius, project, colour, palette) {
  if (!bearing.magnetic) { return []; }
  const distance = radius + gapOf(bearing, scene) + 0.028;
  return ["upper_x", "upper_y", "lower_x", "lower_y"].flatMap((coil, k) => {
    const current = scene.value(`amb_actuator.${bearing.name}.i_${coil}`);
    if (!Number.isFinite(current)) { return []; }
    const turn = scene.rotation + 0.5 * Math.PI * k, share = Math.min(Math.abs(current) / MOST_CURRENT, 1);
    return ring(bearing.z, [0, 0], distance, turn - 0.42, turn + 0.42, project, mixed(palette.line, colour, share), 7);
  });
}

/**
 * Where a disc's unbalance sits, larger the more it is.
 * @param {{ name: string, u: number, phi: number }} unbalance
 * @param {ShaftScene} scene
 * @param {(z: number) => { z: number, u: number, v: number }} place
 * @param {import("./solids.js").Project} project
 * @param {import("./palette.js").Palette} palette
 */
function heavySpot(unbalance, scene, place, project, palette) {
  const body = scene.geometry.discs.find((item) => item.name === unbalance.name);
  if (body === undefined || unbalance.u <= 0 || body.radius <= 0) { return []; }
  const size = body.radius * Math.min(0.08 + 0.9 * Math.sqrt(unbalance.u), 0.34);
  const turn = scene.rotation + scene.angle + unbalance.phi, at = place(body.z), out = 0.72 * body.radius;
  return [-1, 1].flatMap((side) => {
    const corners = Array.from({ length: 16 }, (_, k) => {
      const around = (-side * 2 * Math.PI * k) / 16;
      return project(body.z + 0.52 * side * body.width, at.u + out * Math.cos(turn) + size * Math.cos(around),
                     at.v + out * Math.sin(turn) + size * Math.sin(around));
    });
    return face(corners.reverse(), palette.push, palette.push, -0.02);
  });
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} z0
 * @param {number} z1
 * @param {number} level
 * @param {import("./solids.js").Project} project
 * @param {import("./palette.js").Palette} palette
 */
function drawFloor(context, z0, z1, level, project, palette) {
  const step = z1 - z0 > 1 ? 0.5 : z1 - z0 > 0.4 ? 0.2 : 0.1, half = 0.12 * (z1 - z0);
  const line = (/** @type {readonly number[]} */ a, /** @type {readonly number[]} */ b) => {
    context.beginPath();
    context.moveTo(a[0], a[1]);
    context.lineTo(b[0], b[1]);
    context.stroke();
  };
  context.strokeStyle = palette.line;
  context.lineWidth = 1;
  for (const u of [-half, 0, half]) { line(project(z0, u, level), project(z1, u, level)); }
  context.fillStyle = palette.soft;
  context.font = `12px ${palette.font}`;
  context.textAlign = "center";
  context.textBaseline = "top";
  for (let z = Math.ceil(z0 / step - 1e-9) * step; z <= z1 + 1e-9; z += step) {
    line(project(z, -half, level), project(z, half, level));
    const [x, y] = project(z, half, level);
    context.fillText(`${Number(z.toFixed(2))} m`, x, y + 14);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {ShaftScene} scene
 * @param {(z: number) => { z: number, u: number, v: number }} place
 * @param {import("./solids.js").Project} project
 * @param {import("./palette.js").Palette} palette
 */
function drawLabels(context, scene, place, project, palette) {
  const { geometry } = scene;
  context.textAlign = "center";
  context.textBaseline = "bottom";
  context.font = `600 12px ${palette.font}`;
  context.fillStyle = palette.soft;
  let free = -Infinity; // of other labels, from the left
  for (const item of geometry.discs.filter((body) => body.unbalance && body.radius > 0)) {
    const { u, v } = place(item.z), [x, y] = project(item.z, u, v + item.radius), text = item.name.toUpperCase();
    const half = 0.5 * context.measureText(text).width;
    if (x - half < free && x > free - 2 * half) { continue; }
    write(context, text, x, y - 4, palette);
    free = x + half + 4;
  }
  geometry.bearings.forEach((bearing, k) => {
    const [x, y] = project(bearing.z, 0, -journalRadius(geometry, bearing.z) - gapOf(bearing, scene) - 0.045);
    context.fillStyle = palette.series[k % palette.series.length];
    write(context, bearing.name.toUpperCase(), x, y + 16, palette);
  });
}

/**
 * Write a name with a border in the colour of the ground, so that it can be read over what lies behind.
 * @param {CanvasRenderingContext2D} context
 * @param {string} text
 * @param {number} x
 * @param {number} y
 * @param {import("./palette.js").Palette} palette
 */
function write(context, text, x, y, palette) {
  context.lineJoin = "round";
  context.lineWidth = 4;
  context.strokeStyle = palette.panel;
  context.strokeText(text, x, y);
  context.fillText(text, x, y);
}
