// The synchronous vibration: amplitude and phase at each plane of sensors, as vectors and as numbers.

import { arrow, surfaceOf } from "./canvas.js";
import { make, setText } from "./dom.js";
import { numberText, quantityText } from "./format.js";
import { halfHeightFor } from "./charts.js";
import { valueOf } from "./session.js";

/** @typedef {import("./session.js").Session} Session */

/**
 * Return the amplitude (m) and phase (rad) of the x axis at each plane that the controller transforms.
 * @param {Session} session
 */
function synchronousVectors(session) {
  return session.rig.geometry.planes.map((plane) => {
    const sensor = plane.x.split(".").slice(1).join(".");
    return {
      name: plane.name.replaceAll("_", " "),
      amplitude: valueOf(session, `rolac_controller.amplitude.${sensor}`),
      phase: valueOf(session, `rolac_controller.phase.${sensor}`),
    };
  }).filter((plane) => Number.isFinite(plane.amplitude));
}

/**
 * Fill the panel, and return the function that updates it.
 * @param {HTMLCanvasElement} canvas
 * @param {HTMLTableElement} table
 * @param {Session} session
 * @returns {(session: Session, palette: import("./palette.js").Palette) => void}
 */
export function makeSynchronous(canvas, table, session) {
  const section = table.closest("section");
  if (section !== null) { section.hidden = !session.rig.components.some((item) => item.name === "rolac_controller"); }
  const rows = session.rig.geometry.planes.map((plane, k) => {
    const name = make("td", { text: plane.name.replaceAll("_", " "), style: `--key: var(--series-${seriesOf(session, k) + 1})` });
    const amplitude = make("td"), phase = make("td");
    return { amplitude, phase, element: make("tr", {}, [name, amplitude, phase]) };
  });
  table.tBodies[0].replaceChildren(...rows.map((row) => row.element));
  let span = 1e-5;
  return (now, palette) => {
    const vectors = synchronousVectors(now);
    vectors.forEach((item, k) => {
      setText(rows[k].amplitude, quantityText(item.amplitude, "m"));
      setText(rows[k].phase, item.amplitude > 0 ? `${numberText(Math.round((180 * item.phase) / Math.PI))}°` : "–");
    });
    span = halfHeightFor([vectors.map((item) => item.amplitude)], 1e-6, span);
    drawPolar(canvas, vectors.map((item, k) => ({ ...item, colour: palette.series[seriesOf(now, k)] })), span, palette);
  };
}

/**
 * Return the colour of a plane: that of the bearing at its position.
 * @param {Session} session
 * @param {number} k
 */
function seriesOf(session, k) {
  const { planes, bearings } = session.rig.geometry;
  const bearing = bearings.findIndex((item) => Math.abs(item.z - planes[k].z) < 0.02);
  return bearing >= 0 ? bearing : (bearings.length + planes.slice(0, k).filter((plane) => !bearings.some((item) => Math.abs(item.z - plane.z) < 0.02)).length) % 6;
}

/**
 * @param {HTMLCanvasElement} canvas
 * @param {{ amplitude: number, phase: number, colour: string }[]} vectors
 * @param {number} span m
 * @param {import("./palette.js").Palette} palette
 */
function drawPolar(canvas, vectors, span, palette) {
  const { context, width, height } = surfaceOf(canvas);
  const radius = 0.5 * Math.min(width, height) - 20, [x0, y0] = [0.5 * width, 0.5 * height];
  context.strokeStyle = palette.line;
  context.lineWidth = 1;
  for (const share of [0.5, 1]) {
    context.beginPath();
    context.arc(x0, y0, share * radius, 0, 2 * Math.PI);
    context.stroke();
  }
  context.fillStyle = palette.soft;
  context.font = `11px ${palette.font}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (const degrees of [0, 90, 180, 270]) {
    const [c, s] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
    context.beginPath();
    context.moveTo(x0, y0);
    context.lineTo(x0 + radius * c, y0 - radius * s);
    context.stroke();
    context.fillText(degrees === 180 ? "±180°" : degrees === 270 ? "−90°" : `${degrees}°`, x0 + (radius + 10) * c, y0 - (radius + 8) * s);
  }
  context.textAlign = "left";
  context.fillText(quantityText(span, "m", 2), x0 + 4, y0 - radius + 9);
  for (const { amplitude, phase, colour } of vectors) {
    const length = (radius * amplitude) / span;
    arrow(context, x0, y0, x0 + length * Math.cos(phase), y0 - length * Math.sin(phase), colour, 2.5);
  }
}
