// Scrolling curves over time, by uPlot: a chart for each kind of quantity, with a common window of time.

import { numberText } from "./format.js";

/**
 * A curve of a chart.
 * @typedef {object} Curve
 * @property {string} signal
 * @property {string} label
 * @property {number} series number of its colour
 * @property {boolean} dashed
 */

/**
 * A chart: curves of the same unit, with levels that do not change.
 * @typedef {object} ChartSpec
 * @property {string} key
 * @property {string} title
 * @property {string} unit as displayed
 * @property {number} scale from the signal's unit to that
 * @property {string} limits what bounds the curves, in words
 * @property {Curve[]} curves
 * @property {() => number[]} levels drawn across, in the displayed unit
 * @property {number} least half-height that is always displayed, in the displayed unit
 * @property {boolean} positive whether no curve is below zero
 */

/** @typedef {ReturnType<typeof makeChart>} Chart */

/**
 * Return a chart in an element.
 * @param {HTMLElement} place
 * @param {ChartSpec} spec
 * @param {import("./palette.js").Palette} palette
 */
export function makeChart(place, spec, palette) {
  /** @type {[number, number]} */
  let timeRange = [0, 1];
  let half = spec.least;
  const axis = { stroke: palette.soft, grid: { stroke: palette.line, width: 1 }, ticks: { stroke: palette.line, width: 1, size: 4 }, font: `12px ${palette.font}`, gap: 3 };
  const plot = new uPlot({
    width: Math.max(place.clientWidth, 120), height: Math.max(place.clientHeight, 60),
    padding: [6, 8, 0, 0],
    cursor: { y: false, points: { size: 6 } }, legend: { show: false },
    scales: { x: { time: false, range: () => timeRange }, y: { range: () => [spec.positive ? 0 : -half, half] } },
    axes: [{ ...axis, size: 24, space: 70, values: (_, ticks) => ticks.map((t) => numberText(t, 6)) },
           { ...axis, size: 46, space: 18, values: (_, ticks) => ticks.map((t) => numberText(t, 3)) }],
    series: [{ label: "t" }, ...spec.curves.map((curve) => ({
      label: curve.label, stroke: palette.series[curve.series % palette.series.length], width: 1.5,
      dash: curve.dashed ? [5, 3] : undefined, points: { show: false }, spanGaps: false,
    }))],
    hooks: { drawAxes: [(item) => drawLevels(item, spec.levels(), palette)] },
  }, [[], ...spec.curves.map(() => [])], place);
  const names = spec.curves.map((curve) => curve.signal), scales = names.map(() => spec.scale);
  return {
    spec,
    draw: (/** @type {import("./traces.js").Traces} */ traces, /** @type {number} */ from, /** @type {number} */ to) => {
      timeRange = [from, to];
      const curves = traces.thinned(names, from, to, Math.max(Math.round(plot.width / 2), 100), scales);
      half = halfHeightFor(curves.slice(1), spec.least, half);
      plot.setData(/** @type {uPlot.AlignedData} */ (curves));
    },
    resize: () => plot.setSize({ width: Math.max(place.clientWidth, 120), height: Math.max(place.clientHeight, 60) }),
    show: (/** @type {readonly boolean[]} */ visible) => visible.forEach((isVisible, k) => { if (plot.series[k + 1].show !== isVisible) { plot.setSeries(k + 1, { show: isVisible }); } }),
    destroy: () => plot.destroy(),
  };
}

/**
 * Return the half-height for curves: steps of 1, 1.5, 2, 3, 5 and 7 in a decade; it shrinks when half of it is empty.
 * @param {readonly (readonly number[])[]} curves
 * @param {number} least
 * @param {number} before
 */
export function halfHeightFor(curves, least, before) {
  let largest = 0;
  for (const curve of curves) { for (const value of curve) { if (Math.abs(value) > largest) { largest = Math.abs(value); } } }
  const wanted = Math.max(1.06 * largest, least);
  if (wanted <= before && wanted > 0.45 * before) { return before; }
  const decade = 10 ** Math.floor(Math.log10(wanted));
  return decade * ([1, 1.5, 2, 3, 5, 7, 10].find((step) => step * decade >= wanted) ?? 10);
}

/** @param {uPlot} plot @param {readonly number[]} levels @param {import("./palette.js").Palette} palette */
function drawLevels(plot, levels, palette) {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.strokeStyle = palette.ink;
  ctx.lineWidth = devicePixelRatio;
  ctx.setLineDash([3 * devicePixelRatio, 3 * devicePixelRatio]);
  for (const level of levels) {
    const y = plot.valToPos(level, "y", true);
    if (y >= bbox.top && y <= bbox.top + bbox.height) {
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
    }
  }
  ctx.restore();
}
