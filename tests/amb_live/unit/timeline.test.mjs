import assert from "node:assert/strict";
import { test } from "node:test";
import { plannedEvents, contactIntervals } from "../../../applications/amb_live/page/ui/timeline.js";
import { snapped } from "../../../applications/amb_live/page/ui/transport.js";

test("contact lasts from its begin to its end, whether it slides or rolls, and one that lasts until now", () => {
  const contacts = [[0.1, "a", 1], [0.15, "b", 1], [0.2, "a", 2], [0.3, "a", 0], [0.4, "a", 1]].map(([time, site, mode]) => ({ time, site, mode, point: 0 }));
  assert.deepEqual(contactIntervals(contacts, "a", 0.5), [[0.1, 0.3], [0.4, 0.5]]);
  assert.deepEqual(contactIntervals(contacts, "c", 0.5), []);
});

test("events of one point are one mark, by their label or else by what they set", () => {
  const events = [[4, "rotor_contact.d1.u", "step"], [4, "rotor_contact.d2.u", "step"], [8, "amb_actuator.mb1.amplifier_off_x", ""]]
    .map(([point, variable, label]) => ({ point, variable, value: 1, label }));
  assert.deepEqual(plannedEvents({ events, stepSize: 0.25 }), [{ time: 1, text: "step" }, { time: 2, text: "mb1.amplifier_off_x" }]);
});

test("a pace near one that has a name is that one", () => {
  assert.deepEqual([-2.97, -0.02, 0.7, -1.5].map(snapped), [-3, 0, Math.log10(5), -1.5]);
});
