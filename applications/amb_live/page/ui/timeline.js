// The time line: events of the scenario, changes by the user, contacts, and the present time.

import { surfaceOf } from "./canvas.js";
import { numberText } from "./format.js";
import { placesOfContact } from "./session.js";

/** @typedef {import("./session.js").Session} Session */

/**
 * Return the intervals of contact at a site, from its contact events.
 * @param {readonly import("../protocol.js").ContactEvent[]} contacts in order of time
 * @param {string} site
 * @param {number} now s, at which an ongoing contact ends
 */
export function contactIntervals(contacts, site, now) {
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
 * Return the events of the scenario at each time, those of a point together.
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

const INSET = 8; // pixels at both ends

/** The time line on a canvas. */
export class Timeline {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Session} session
   * @param {import("./palette.js").Palette} palette
   */
  constructor(canvas, session, palette) {
    const { context, width, height } = surfaceOf(canvas);
    this.context = context;
    this.width = width;
    this.session = session;
    this.palette = palette;
    this.base = height - 15;
    this.end = endOfLine(session);
    context.font = `11px ${palette.font}`;
    context.textBaseline = "alphabetic";
  }

  /** Return the place of a time (pixels). @param {number} time s */
  at(time) {
    return INSET + ((this.width - 2 * INSET) * Math.min(Math.max(time, 0), this.end)) / this.end;
  }

  draw() {
    const { context, session, palette, base } = this, x = this.at(session.time);
    context.fillStyle = palette.line;
    context.fillRect(INSET, base - 3, this.width - 2 * INSET, 3);
    context.fillStyle = palette.series[0];
    context.fillRect(INSET, base - 3, x - INSET, 3);
    context.fillStyle = palette.touch;
    for (const name of placesOfContact(session.rig.geometry)) {
      for (const [begin, stop] of contactIntervals(session.contacts, name, session.time)) {
        context.fillRect(this.at(begin), base - 10, Math.max(this.at(stop) - this.at(begin), 1.2), 6);
      }
    }
    this.drawTicks();
    this.drawEvents();
    Object.assign(context, { fillStyle: palette.ink, strokeStyle: palette.ground, lineWidth: 2 });
    context.beginPath();
    context.arc(x, base - 1.5, 6, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
  }

  drawTicks() {
    const { context, end } = this, rough = end / 6, decade = 10 ** Math.floor(Math.log10(rough));
    const step = decade * ([1, 2, 5, 10].find((item) => item * decade >= rough) ?? 10);
    context.fillStyle = this.palette.soft;
    for (let time = 0; time <= end + 1e-9; time += step) {
      context.textAlign = time === 0 ? "left" : this.at(time) > this.at(end) - 14 ? "right" : "center";
      context.fillText(`${numberText(time, 4)} s`, this.at(time), this.base + 13);
    }
  }

  drawEvents() {
    const { context, palette, base, session: { userChanges, rig } } = this;
    const mine = userChanges.changes.map((change) => ({ time: change.time, text: "", colour: palette.push, height: 13 }));
    const planned = userChanges.settings.events === false ? [] : plannedEvents(rig).map((event) => ({ ...event, colour: palette.ink, height: 16 }));
    let free = -Infinity;
    for (const { time, text, colour, height } of [...planned, ...mine]) {
      const x = this.at(time);
      Object.assign(context, { strokeStyle: colour, fillStyle: colour, lineWidth: 1.5 });
      context.beginPath();
      context.moveTo(x, base - height);
      context.lineTo(x, base + 1);
      context.stroke();
      if (text !== "" && x > free) {
        const room = context.measureText(text).width;
        context.textAlign = x + room > this.width - 8 ? "right" : "left";
        context.fillText(text, x, base - 20);
        free = x + room + 8;
      }
    }
  }
}
