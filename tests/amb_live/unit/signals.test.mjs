import assert from "node:assert/strict";
import { test } from "node:test";
import { seriesOfSite } from "../../../applications/amb_live/page/ui/palette.js";
import { limitsText } from "../../../applications/amb_live/page/ui/limits.js";
import { chartSpecs, watchedSignals } from "../../../applications/amb_live/page/ui/signals.js";

// Two magnetic bearings and a passive one between them; a retainer in the plane of its bearing, one beside it, two seals.
const bearings = ["left", "ring", "right"].map((name, k) => ({ name, z: k, magnetic: name !== "ring" }));
const sites = [["catch", "left", 0], ["stop", "right", 1.8], ["seal", "", 0.5], ["casing", "", 0.7]].map(([name, bearing, z]) => ({ name, bearing, z }));
const geometry = { bearings, sites, faces: [], thrust: "", shape: { places: [] } };
const outputs = bearings.flatMap(({ name }) => ["x", "y"].flatMap((axis) => [
  ["rotor_contact", `${name}.${axis}`], ["rolac_controller", `${name}.i_${axis}`], ["amb_actuator", `${name}.f_${axis}`]]));
outputs.push(...sites.map(({ name }) => ["rotor_contact", `${name}.f_n_peak`]));
const components = ["rotor_contact", "rolac_controller", "amb_actuator"].map((component) => ({
  name: component, parameters: Object.fromEntries(sites.map(({ name }, k) => [`${name}.clearance`, (k + 1) * 1e-4])),
  variables: outputs.filter(([one]) => one === component).map(([, name]) => ({ name, causality: "output" })) }));
const session = { rig: { geometry, components, inputs: {}, stepSize: 1e-4 }, columns: new Map(outputs.map((name, k) => [name.join("."), k])),
  values: [], variables: new Map(), userChanges: { changes: [], settings: {} }, time: 0 };
const specs = Object.fromEntries(chartSpecs(() => session).map((spec) => [spec.key, spec]));

test("a bearing without magnets has displacements, and no current or force", () => {
  const of = (key) => [...new Set(specs[key].curves.map((curve) => curve.label.slice(0, -2)))];
  assert.deepEqual(of("displacement"), ["left", "ring", "right"]);
  assert.deepEqual([of("current"), of("force")], [["left", "right"], ["left", "right"]]);
  assert.ok(!watchedSignals(session.rig).some((name) => name.includes("ring.i_") || name.includes("ring.f_")));
});

test("each site has a colour of its own, a retainer that of its bearing", () => {
  assert.deepEqual(sites.map((site) => seriesOfSite(geometry, site)), [0, 2, 3, 4]);
  assert.deepEqual(specs.contact.curves.map((curve) => curve.series), [0, 2, 3, 4]);
});

test("clearances are drawn over displacements of their own plane alone", () => {
  const levels = specs.displacement.levels();
  assert.equal(levels.length, 2);
  assert.ok(Math.abs(levels[1] - 0.1) < 1e-12 && levels[0] === -levels[1]);
});

test("limits are named once, with both signs where they have them", () => {
  assert.equal(limitsText("limits", []), "");
  assert.equal(limitsText("limits", [-1.5, 2]), "limits −1.5, 2");
  assert.equal(limitsText("clearance", [-0.3, 0.3, -0.2, 0.2]), "clearance ±0.2, ±0.3");
});

test("a machine with an axial bearing has the axis along its shaft in every chart, and its seats as limits", () => {
  const faces = [{ name: "seat", z: 0, radius: 0.01, clearance: 2e-4, stops: -1, retainer: "catch" }, { name: "top", z: 0, radius: 0.01, clearance: 3e-4, stops: 1, retainer: "" }];
  const axial = ["rotor_contact.thrust.z", "rolac_controller.thrust.i_z", "amb_actuator.thrust.f_z", "rotor_contact.seat.f_n_peak", "rotor_contact.top.f_n_peak"];
  const inputs = { "rotor_contact.seat.clearance": 2e-4, "rotor_contact.top.clearance": 3e-4 };
  const five = { ...session, rig: { ...session.rig, inputs, geometry: { ...geometry, faces, thrust: "thrust" } }, columns: new Map([...session.columns.keys(), ...axial].map((name, k) => [name, k])) };
  const charts = Object.fromEntries(chartSpecs(() => five).map((spec) => [spec.key, spec]));
  assert.deepEqual(charts.axial.curves.map((curve) => curve.signal), axial.slice(0, 1));
  assert.deepEqual(charts.axial.levels().map((level) => Math.round(level * 100) / 100), [-0.2, 0.3]);
  assert.deepEqual(["current", "force"].map((key) => charts[key].curves.at(-1).signal), axial.slice(1, 3));
  assert.deepEqual(charts.contact.curves.slice(-2).map((curve) => [curve.label, curve.series]), [["seat", 0], ["top", 2]]);
  assert.ok(!("axial" in specs));
});
