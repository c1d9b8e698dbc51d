// The panel of scrolling curves: the charts with their signals, and the buttons that hide a curve.

import { makeChart } from "./charts.js";
import { make } from "./dom.js";
import { nameLabel } from "./format.js";
import { currentLimits, limitsText } from "./limits.js";
import { seriesOfFace, seriesOfSite } from "./palette.js";
import { observeVisibility } from "./seen.js";
import { settingOf } from "./session.js";

/** @typedef {import("./session.js").Session} Session */
/** @typedef {import("./charts.js").ChartSpec} ChartSpec */

const SMALL = 3e-4; // m; below it, as the largest clearance, displacements are in µm

/**
 * Return the charts of a rig: displacements across and along the shaft, contact forces, currents and forces of the magnets.
 * @param {() => Session} current
 */
export function chartSpecs(current) {
  const session = current(), { geometry } = session.rig, { bearings, sites, faces, thrust } = geometry;
  const axes = (/** @type {(name: string, axis: string) => string} */ signal, whole = false) => bearings.flatMap((bearing, k) => (
    whole || bearing.magnetic ? ["x", "y"] : []).map((axis) => ({
    signal: signal(bearing.name, axis), label: `${nameLabel(bearing.name)} ${axis}`, series: k, dashed: axis === "y" })));
  const along = (/** @type {(name: string, axis: string) => string} */ signal) => (thrust === "" ? [] : [{
    signal: signal(thrust, "z"), label: `${nameLabel(thrust)} z`, series: bearings.length, dashed: false }]);
  const bothOf = (/** @type {(name: string, axis: string) => string} */ signal) => [...axes(signal), ...along(signal)];
  const inPlane = sites.filter((site) => bearings.some((item) => item.name === site.bearing && Math.abs(item.z - site.z) < 1e-6));
  const isSmall = Math.max(...sites.map((site) => site.clearance), 0) < SMALL && sites.length > 0;
  const gaps = () => faces.map((face) => face.stops * length.scale * settingOf(current(), `rotor_contact.${face.name}.clearance`));
  const length = isSmall ? { unit: "µm", scale: 1e6, least: 1 } : { unit: "mm", scale: 1e3, least: 0.01 };
  const clearances = () => inPlane.flatMap((site) => {
    const c = length.scale * settingOf(current(), `rotor_contact.${site.name}.clearance`);
    return [-c, c];
  });
  const currents = () => currentLimits(current());
  /** @type {ChartSpec[]} */
  const specs = [
    { key: "displacement", title: `Displacement (${length.unit})`, limits: limitsText("clearance", clearances()), ...length, curves: axes((name, axis) => `rotor_contact.${name}.${axis}`, true), levels: clearances, positive: false },
    { key: "axial", title: `Displacement along the shaft (${length.unit})`, limits: limitsText("seats at", gaps()), ...length, curves: along((name, axis) => `rotor_contact.${name}.${axis}`), levels: gaps, positive: false },
    { key: "contact", title: "Contact force between impacts, largest in a step (kN)", limits: "", unit: "kN", scale: 1e-3, levels: () => [], least: 0.1, positive: true,
      curves: sites.filter((site) => settingOf(session, `rotor_contact.${site.name}.enabled`) !== 0).map((site) => ({
        signal: `rotor_contact.${site.name}.f_n_peak`, label: nameLabel(site.name), series: seriesOfSite(geometry, site), dashed: false })).concat(
        faces.filter((face) => settingOf(session, `rotor_contact.${face.name}.enabled`) !== 0).map((face) => ({
          signal: `rotor_contact.${face.name}.f_n_peak`, label: nameLabel(face.name), series: seriesOfFace(geometry, face), dashed: true }))) },
    { key: "current", title: "Demanded control current (A)", limits: limitsText("limits", currents()), unit: "A", scale: 1, curves: bothOf((name, axis) => `rolac_controller.${name}.i_${axis}`), levels: currents, least: 0.1, positive: false },
    { key: "force", title: "Magnet force (kN)", limits: "", unit: "kN", scale: 1e-3, curves: bothOf((name, axis) => `amb_actuator.${name}.f_${axis}`), levels: () => [], least: 0.05, positive: false },
  ];
  return specs.map((spec) => ({ ...spec, curves: spec.curves.filter((curve) => session.columns.has(curve.signal)) })).filter((spec) => spec.curves.length > 0);
}

/**
 * Return the signals whose samples the page stores, for curves and for CSV files.
 * @param {import("../protocol.js").Rig} rig
 */
export function watchedSignals(rig) {
  const { bearings, sites, faces, thrust, shape } = rig.geometry;
  const outputs = new Set(rig.components.flatMap((item) => item.variables.filter((variable) => variable.causality === "output").map((variable) => `${item.name}.${variable.name}`)));
  const wanted = [
    ...shape.places.flatMap((place) => [place.x, place.y]),
    ...sites.flatMap((site) => ["x", "y", "f_n", "f_n_peak", "f_n_mean", "f_t", "mode"].map((name) => `rotor_contact.${site.name}.${name}`)),
    ...faces.flatMap((face) => ["f_n", "f_n_peak", "f_n_mean", "mode"].map((name) => `rotor_contact.${face.name}.${name}`)),
    ...["rotor_contact.?.z", "rolac_controller.?.i_z", "amb_actuator.?.f_z"].map((name) => name.replace("?", thrust)),
    ...bearings.filter((bearing) => bearing.magnetic).flatMap(({ name }) => ["x", "y"].flatMap((axis) => [`rolac_controller.${name}.i_${axis}`, `amb_actuator.${name}.f_${axis}`])),
    "rotor_contact.theta", "rotor_contact.speed", "rolac_controller.harmonic1.displacement", "rolac_controller.harmonic1.force",
    ...["kinetic", "strain", "friction", "impact", "damping", "balance"].map((name) => `rotor_contact.energy.${name}`),
  ];
  return [...new Set(wanted)].filter((name) => outputs.has(name));
}

/**
 * Fill the panel, and return the functions that draw it and end it.
 * @param {HTMLElement} panel
 * @param {() => Session} current
 * @param {import("./palette.js").Palette} palette
 * @returns {{ draw: (span: number) => void, end: () => void }}
 */
export function makeSignals(panel, current, palette) {
  const specs = chartSpecs(current);
  const places = specs.map((spec) => {
    const keys = spec.curves.map((curve) => make("button", {
      type: "button", class: `key${curve.dashed ? " dashed" : ""}`, "aria-pressed": "true", title: "Show or hide", text: curve.label,
      style: `--key: var(--series-${(curve.series % 6) + 1})` }));
    const plot = make("div", { class: "plot", role: "img", "aria-label": `${spec.title} over time, ${spec.limits}: ${spec.curves.map((curve) => curve.label).join(", ")}` });
    const element = make("div", { class: "chart", "data-chart": spec.key }, [make("header", {}, [make("b", { text: spec.title }), make("span", { class: "limits", text: spec.limits }), ...keys]), plot]);
    return { element, keys, plot };
  });
  panel.replaceChildren(...places.map((place) => place.element));
  const charts = specs.map((spec, k) => makeChart(places[k].plot, spec, palette));
  places.forEach(({ keys }, k) => keys.forEach((key) => key.addEventListener("click", () => {
    key.setAttribute("aria-pressed", String(key.getAttribute("aria-pressed") !== "true"));
    charts[k].show(keys.map((item) => item.getAttribute("aria-pressed") === "true"));
  })));
  const sizes = new ResizeObserver(() => charts.forEach((chart) => chart.resize()));
  sizes.observe(panel);
  const seen = places.map((place) => observeVisibility(place.element));
  let turn = 0;
  return {
    draw: (span) => {
      turn += 1; // half of the charts in each frame
      charts.forEach((chart, k) => {
        if ((k + turn) % 2 === 0 && seen[k].isSeen()) { chart.draw(current().traces, current().time - span, current().time); }
      });
    },
    end: () => { sizes.disconnect(); seen.forEach((item) => item.end()); charts.forEach((chart) => chart.destroy()); },
  };
}
