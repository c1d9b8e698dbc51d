// The time line: the scenario's events, what the user did, when the rotor touched, and where the run is.

import { surfaceOf } from "./canvas.js";
import { numberText } from "./format.js";

/** @typedef {import("./session.js").Session} Session */

/**
 * Spans of time in which the rotor touched a site, from its contact events.
 * @param {readonly import("../protocol.js").ContactEvent[]} contacts in order of time
 * @param {string} site
 * @param {number} now s, where a contact that lasts ends
 */
export function touches(contacts, site, now) {
  /** @type {[number, number][]} */
  const spans = [];
  let begin = NaN;
  for (const contact of contacts.filter((item) => item.site === site)) {
    if (contact.mode > 0 && Number.isNaN(begin)) {
      begin = contact.time;
    } else if (contact.mode === 0 && !Number.isNaN(begin)) {
      spans.push([begin, contact.time]);
      begin = NaN;
    }
  }
  return Number.isNaN(begin) ? spans : [...spans, [begin, now]];
}

/**
 * Return what the scenario does at each time, events of a point together.
 * @param {import("../protocol.js").Rig} rig
 */
export function plannedEvents(rig) {
  /** @type {Map<number, string[]>} */
  const moments = new Map();
  for (const event of rig.events) {
    const name = event.variable.split(".").slice(-2).join(".");
    moments.set(event.point, [...(moments.get(event.point) ?? []), event.label || name]);
  }
  return [...moments].map(([point, texts]) => ({ time: point * rig.stepSize, text: [...new Set(texts)].slice(0, 2).join(", ") }));
}

/**
 * Return the end of the time line: of the scenario, or later when the run has gone on.
 * @param {Session} session
 * @returns {number} s
 */
export function endOfLine(session) {
  return Math.max(session.rig.last * session.rig.stepSize, 1.02 * session.reached);
}

/**
 * Draw the time line.
 * @param {HTMLCanvasElement} canvas
 * @param {Session} session
 * @param {import("./palette.js").Palette} palette
 */
export function drawTimeline(canvas, session, palette) {
  const { context, width, height } = surfaceOf(canvas);
  const end = endOfLine(session), inset = 8, base = height - 15;
  const at = (/** @type {number} */ time) => inset + ((width - 2 * inset) * Math.min(Math.max(time, 0), end)) / end;
  context.font = `11px ${palette.font}`;
  context.textBaseline = "alphabetic";
  context.fillStyle = palette.line;
  context.fillRect(inset, base - 3, width - 2 * inset, 3);
  context.fillStyle = palette.series[0];
  context.fillRect(inset, base - 3, at(session.time) - inset, 3);

  const sites = session.rig.geometry.sites;
  context.fillStyle = palette.touch;
  sites.forEach((site) => {
    for (const [begin, stop] of touches(session.contacts, site.name, session.time)) {
      context.fillRect(at(begin), base - 10, Math.max(at(stop) - at(begin), 1.2), 6);
    }
  });
  drawTicks(context, end, at, base, palette);
  drawEvents(context, session, at, base, width, palette);

  const x = at(session.time);
  context.fillStyle = palette.ink;
  context.beginPath();
  context.arc(x, base - 1.5, 6, 0, 2 * Math.PI);
  context.fill();
  context.strokeStyle = palette.ground;
  context.lineWidth = 2;
  context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} end
 * @param {(time: number) => number} at
 * @param {number} base
 * @param {import("./palette.js").Palette} palette
 */
function drawTicks(context, end, at, base, palette) {
  const rough = end / 6, decade = 10 ** Math.floor(Math.log10(rough));
  const step = decade * ([1, 2, 5, 10].find((item) => item * decade >= rough) ?? 10);
  context.fillStyle = palette.soft;
  for (let time = 0; time <= end + 1e-9; time += step) {
    context.textAlign = time === 0 ? "left" : at(time) > at(end) - 14 ? "right" : "center";
    context.fillText(`${numberText(time, 4)} s`, at(time), base + 13);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Session} session
 * @param {(time: number) => number} at
 * @param {number} base
 * @param {number} width
 * @param {import("./palette.js").Palette} palette
 */
function drawEvents(context, session, at, base, width, palette) {
  const mine = session.userChanges.changes.map((change) => ({ time: change.time, text: "", isUser: true }));
  const planned = session.userChanges.settings.events === false ? [] : plannedEvents(session.rig).map((event) => ({ ...event, isUser: false }));
  let free = -Infinity;
  for (const mark of [...planned, ...mine]) {
    const x = at(mark.time), colour = mark.isUser ? palette.push : palette.ink;
    context.strokeStyle = context.fillStyle = colour;
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x, mark.isUser ? base - 13 : base - 16);
    context.lineTo(x, base + 1);
    context.stroke();
    if (mark.text !== "" && x > free) {
      const room = context.measureText(mark.text).width;
      context.textAlign = x + room > width - 8 ? "right" : "left";
      context.fillText(mark.text, x, base - 20);
      free = x + room + 8;
    }
  }
}
