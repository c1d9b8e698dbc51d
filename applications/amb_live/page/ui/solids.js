// Solids of the shaft view as faces: a tube along the deflected shaft, discs, rings. Faces are sorted from back to front.

import { mixed } from "./palette.js";

/** @typedef {ReturnType<typeof import("./camera.js").projection>} Project */

/**
 * Something to draw, as far away as `depth`.
 * @typedef {object} Face
 * @property {number} depth m
 * @property {(context: CanvasRenderingContext2D) => void} draw
 */

/** A point of the deflected shaft: position, displacement as drawn, radius (m).
 * @typedef {{ z: number, u: number, v: number, radius: number }} Point */

const SIDES = 18;
const BEHIND = 0.004; // m, an end of a section behind the thinner section beside it

/**
 * Return the face through projected corners, if it faces the viewer.
 * @param {import("./camera.js").Projected[]} corners counter-clockwise as seen from outside
 * @param {string} fill
 * @param {string} [edge]
 * @param {number} [offset] added to the depth (m)
 * @returns {Face[]}
 */
export function face(corners, fill, edge = fill, offset = 0) {
  let area = 0, depth = 0;
  corners.forEach(([x, y, d], k) => {
    const [nextX, nextY] = corners[(k + 1) % corners.length];
    area += x * nextY - nextX * y;
    depth += d / corners.length;
  });
  if (area >= 0) { return []; } // y is down on the screen
  return [{
    depth: depth + offset,
    draw: (context) => {
      context.beginPath();
      corners.forEach(([x, y], k) => (k === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
      context.closePath();
      context.fillStyle = fill;
      context.fill();
      context.strokeStyle = edge;
      context.lineWidth = 0.7;
      context.stroke();
    },
  }];
}

/**
 * Return the shade of a surface whose normal points to (u, v) across the shaft: light comes from above and the left.
 * @param {string} colour
 * @param {string} dark
 * @param {string} bright
 * @param {number} u
 * @param {number} v
 */
function shade(colour, dark, bright, u, v) {
  const light = -0.45 * u + 0.89 * v;
  return light > 0 ? mixed(colour, bright, 0.55 * light * light) : mixed(colour, dark, -0.6 * light);
}

/**
 * Return the faces of a tube along points, with the ends of its sections.
 * @param {readonly Point[]} points
 * @param {Project} project
 * @param {number} angle of the rotor (rad)
 * @param {{ metal: string, dark: string, bright: string }} colours
 */
export function tube(points, project, angle, colours) {
  const corner = (/** @type {Point} */ p, /** @type {number} */ k) => {
    const turn = angle + (2 * Math.PI * k) / SIDES;
    return project(p.z, p.u + p.radius * Math.cos(turn), p.v + p.radius * Math.sin(turn));
  };
  /** @type {Face[]} */
  const faces = [];
  for (let i = 0; i + 1 < points.length; i++) {
    const [a, b] = [points[i], { ...points[i + 1], radius: points[i].radius }];
    for (let k = 0; k < SIDES; k++) {
      const turn = angle + (2 * Math.PI * (k + 0.5)) / SIDES;
      const stripe = k === 0 ? mixed(colours.metal, colours.dark, 0.55) : colours.metal; // the rotor's mark
      const fill = shade(stripe, colours.dark, colours.bright, Math.cos(turn), Math.sin(turn));
      faces.push(...face([corner(a, k), corner(b, k), corner(b, k + 1), corner(a, k + 1)], fill));
    }
    const turns = Array.from({ length: SIDES }, (_, k) => k), flat = mixed(colours.metal, colours.dark, 0.3);
    if (i === 0 || points[i - 1].radius < a.radius) { faces.push(...face(turns.map((k) => corner(a, -k)), flat, flat, BEHIND)); }
    if (i + 2 === points.length || points[i + 1].radius < a.radius) { faces.push(...face(turns.map((k) => corner(b, k)), flat, flat, BEHIND)); }
  }
  return faces;
}

/**
 * Return the faces of a disc on the shaft, with holes that make its rotation visible.
 * @param {Point} place
 * @param {number} radius m
 * @param {number} width m
 * @param {Project} project
 * @param {number} angle rad
 * @param {{ metal: string, dark: string, bright: string }} colours
 * @param {number} [holes]
 */
export function disc(place, radius, width, project, angle, colours, holes = 0) {
  const sides = 2 * SIDES, [near, far] = [place.z - 0.5 * width, place.z + 0.5 * width];
  const at = (/** @type {number} */ z, /** @type {number} */ r, /** @type {number} */ turn) =>
    project(z, place.u + r * Math.cos(turn), place.v + r * Math.sin(turn));
  const rim = Array.from({ length: sides }, (_, k) => angle + (2 * Math.PI * k) / sides);
  const faces = rim.flatMap((turn, k) => {
    const next = turn + (2 * Math.PI) / sides, middle = 0.5 * (turn + next);
    const fill = shade(colours.metal, colours.dark, colours.bright, Math.cos(middle), Math.sin(middle));
    return face([at(near, radius, turn), at(far, radius, turn), at(far, radius, next), at(near, radius, next)], fill, fill, k * 1e-9);
  });
  for (const [z, outwards] of /** @type {const} */ ([[near, -1], [far, 1]])) {
    const turns = outwards > 0 ? rim : [...rim].reverse();
    const flat = mixed(colours.metal, colours.dark, outwards > 0 ? 0.22 : 0.1);
    const [whole] = face(turns.map((turn) => at(z, radius, turn)), flat, mixed(flat, colours.dark, 0.35), -0.001);
    if (whole !== undefined) {
      const bores = Array.from({ length: holes }, (_, k) => angle + (2 * Math.PI * (k + 0.5)) / holes)
        .map((turn) => Array.from({ length: 14 }, (_, j) => {
          const around = (2 * Math.PI * j) / 14;
          return project(z, place.u + radius * (0.66 * Math.cos(turn) + 0.13 * Math.cos(around)),
                         place.v + radius * (0.66 * Math.sin(turn) + 0.13 * Math.sin(around)));
        }));
      faces.push({ depth: whole.depth, draw: (context) => { whole.draw(context); bores.forEach((bore) => fillPath(context, bore, mixed(flat, colours.dark, 0.6))); } });
    }
  }
  return faces;
}

/** @param {CanvasRenderingContext2D} context @param {import("./camera.js").Projected[]} path @param {string} fill */
function fillPath(context, path, fill) {
  context.beginPath();
  path.forEach(([x, y], k) => (k === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.closePath();
  context.fillStyle = fill;
  context.fill();
}

/**
 * Return part of a ring about the axis as strokes, each at its depth.
 * @param {number} z m
 * @param {number} radius m
 * @param {number} from rad
 * @param {number} to rad
 * @param {Project} project
 * @param {string} colour
 * @param {number} width pixels
 */
export function ring(z, radius, from, to, project, colour, width) {
  const pieces = Math.max(Math.ceil((24 * Math.abs(to - from)) / (2 * Math.PI)), 2);
  const at = (/** @type {number} */ k) => {
    const turn = from + ((to - from) * k) / pieces;
    return project(z, radius * Math.cos(turn), radius * Math.sin(turn));
  };
  return Array.from({ length: pieces }, (_, k) => {
    const [a, m, b] = [at(k), at(k + 0.5), at(k + 1)];
    return {
      depth: m[2],
      draw: (/** @type {CanvasRenderingContext2D} */ context) => {
        context.beginPath();
        context.moveTo(a[0], a[1]);
        context.lineTo(m[0], m[1]);
        context.lineTo(b[0], b[1]);
        context.strokeStyle = colour;
        context.lineWidth = width;
        context.lineCap = "round";
        context.stroke();
      },
    };
  });
}
