import assert from "node:assert/strict";
import { test } from "node:test";
import { apply } from "../../../applications/amb_live/page/ui/changes.js";
import { halfHeightFor } from "../../../applications/amb_live/page/ui/charts.js";
import { absorb, effectOf, lasting, matching, newSession, plainLaw, settingOf, valueOf } from "../../../applications/amb_live/page/ui/session.js";

const variable = (name, causality, variability, start) => ({ name, causality, variability, start, type: "Real", unit: "", min: null, max: null, description: "", reference: 0 });
const rig = {
  stepSize: 0.25, inputs: { "c.u": 3 },
  components: [{ name: "c", parameters: { gain: 7 }, variables: [variable("gain", "parameter", "tunable", 1), variable("mu", "parameter", "fixed", 0.1), variable("u", "input", "continuous", 0)] }],
};

/** A session that has been answered `ready` and some frames. */
function session(...frames) {
  const one = newSession(rig);
  absorb(one, { type: "ready", signals: ["c.u", "c.y"], watched: ["c.y"], userChanges: { settings: {}, changes: [] } });
  for (const frame of frames) { absorb(one, { type: "frame", status: "paused", anew: false, contacts: [], speed: 1, point: 0, ...frame }); }
  return one;
}

const FRAME = { time: 0.5, from: 0, rows: Float64Array.of(0, 10, 0.25, 11, 0.5, 12), values: Float64Array.of(3, 12) };

test("what a variable is set to: by hand, by the scenario, or as the FMU starts", () => {
  const one = session(FRAME);
  assert.deepEqual(["c.u", "c.gain", "c.mu"].map((name) => settingOf(one, name)), [3, 7, 0.1]);
  absorb(one, { type: "userChanges", userChanges: { settings: { values: { "c.mu": 0.3 } }, changes: [{ point: 1, time: 0.25, values: { "c.gain": 9 } }, { point: 9, time: 2.25, values: { "c.gain": 1 } }] } });
  assert.deepEqual(["c.mu", "c.gain"].map((name) => settingOf(one, name)), [0.3, 9]);
});

test("a change that waits for the next step is shown already", () => {
  const one = session(FRAME);
  absorb(one, { type: "userChanges", userChanges: { settings: {}, changes: [{ point: 2, time: 0.5, values: { "c.u": 8 } }] } });
  assert.deepEqual([settingOf(one, "c.u"), valueOf(one, "c.u")], [8, 3]);
});

test("a frame of an earlier time forgets what came after it", () => {
  const contact = { point: 2, time: 0.5, site: "r", mode: 1 };
  const one = session({ ...FRAME, contacts: [contact] }, { time: 0.25, anew: true, from: 1, rows: Float64Array.of(0.25, 21), values: Float64Array.of(3, 21) });
  assert.deepEqual([one.traces.count, one.contacts.length, valueOf(one, "c.y"), one.reached], [2, 0, 21, 0.5]);
});

test("a fixed parameter can only change when the run starts anew", () => {
  assert.deepEqual(["c.u", "c.gain", "c.mu"].map((name) => effectOf(session(), name)), ["live", "live", "anew"]);
});

test("a change waits as a whole if a fixed parameter differs; one that holds already is not sent", () => {
  const said = [];
  const changes = { planned: () => ({}), set: (values) => said.push(["set", values]), plan: (values) => said.push(["plan", values]) };
  apply(session(FRAME), changes, { "c.u": 1, "c.mu": 0.2 });
  apply(session(FRAME), changes, { "c.u": 1, "c.mu": 0.1 });
  assert.deepEqual(said, [["plan", { "c.u": 1, "c.mu": 0.2 }], ["set", { "c.u": 1 }]]);
});

test("a new start keeps what was set last, but no push and no speed", () => {
  const changes = [{ "c.u": 1, Omega: 9 }, { "rotor_contact.d1.f_x": 500 }, { "c.u": 2, "c.gain": 3 }].map((values, point) => ({ point, time: point, values }));
  assert.deepEqual(lasting(changes), { "c.u": 2, "c.gain": 3 });
});

test("patterns match as in scenarios", () => {
  assert.deepEqual(matching(session(), "c.?"), ["c.u"]);
  assert.deepEqual(matching(session(), "*.g*"), ["c.gain"]);
});

test("an axis has room for its curves, and shrinks when half of it is empty", () => {
  assert.equal(halfHeightFor([[0.5, -1.3]], 0.1, 0.1), 1.5);
  assert.equal(halfHeightFor([[0.9]], 0.1, 1.5), 1.5);
  assert.equal(halfHeightFor([[0.3]], 0.1, 1.5), 0.5);
  assert.equal(halfHeightFor([[0]], 0.1, 1.5), 0.1);
});

test("the law that holds the rotor is a PID only if the rig has its gains and no linear controller", () => {
  const session = (names, components) => ({ rig: { components: components.map((name) => ({ name })) }, variables: new Map(names.map((name) => [name, {}])) });
  assert.equal(plainLaw(session(["rolac_controller.mb1.k_b_x"], ["rolac_controller"])), "PID");
  assert.equal(plainLaw(session(["rolac_controller.mb1.i_x.gain"], ["rolac_controller"])), "Linear");
  assert.equal(plainLaw(session(["rolac_controller.mb1.k_b_x"], ["rolac_controller", "linear_controller"])), "Linear");
});
