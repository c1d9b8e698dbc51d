import assert from "node:assert/strict";
import { test } from "node:test";
import { advice, contactTime } from "../../../applications/amb_live/page/ui/advice.js";
import { narrate, newNarrator } from "../../../applications/amb_live/page/ui/events.js";
import { experimentsOf, follow, newNotes, nextNotes } from "../../../applications/amb_live/page/ui/experiments.js";
import { Traces } from "../../../applications/amb_live/page/ui/traces.js";
import { slowness } from "../../../applications/amb_live/page/ui/transport.js";

// A machine with one retainer and one disc, whose names have no numbers.
const CLEARANCE = 1e-4;
const names = ["rotor_contact.catch.mode", "rotor_contact.catch.x", "rotor_contact.catch.y", "rotor_contact.wheel.f_x", "rotor_contact.catch.f_n_mean", "rolac_controller.current_limited"];
const geometry = { discs: [{ name: "wheel", unbalance: true, z: 0 }], sites: [{ name: "catch", clearance: CLEARANCE, x: names[1], y: names[2], z: 0 }], faces: [], bearings: [] };
const events = [{ point: 100, variable: "rotor_contact.wheel.u", value: 5e-6, label: "step" }];
const OFF = "amb_actuator.north.amplifier_off_x";
const variables = new Map([["rotor_contact.wheel.u", { unit: "kg.m", start: 0 }], ["rotor_contact.catch.clearance", { unit: "m", start: CLEARANCE }], [OFF, { unit: "", start: 0 }]]);
const at = (time, values = {}, more = {}) => ({
  rig: { geometry, events, stepSize: 1e-3, inputs: {}, components: [] }, variables, columns: new Map(names.map((name, k) => [name, k])),
  values: Float64Array.from(names, (name) => values[name.split(".").slice(1).join(".")] ?? 0), contacts: [], traces: new Traces([], 1), userChanges: { settings: {}, changes: [] },
  status: "playing", time, speed: 2, ...more,
});
const contact = (time, mode) => ({ time, mode, site: "catch", point: Math.round(time * 1000) });
/** Samples of the contact force: times (s) and means since the previous sample (N). */
function forces(...rows) {
  const traces = new Traces(["rotor_contact.catch.f_n_mean"], 100);
  traces.append(Float64Array.of(...rows));
  return { traces };
}
const off = (value, time = 0.1) => ({ userChanges: { settings: {}, changes: [{ time, values: { [OFF]: value } }] } });

test("contact is told when it begins, and its end when it is over for good", () => {
  const narrator = newNarrator();
  narrate(narrator, at(0));
  const rattle = [contact(0.02, 1), contact(0.021, 0), contact(0.03, 1), contact(0.031, 0)];
  assert.deepEqual(narrate(narrator, at(0.04, {}, { contacts: rattle })), [{ time: 0.02, text: "the rotor touches catch" }]);
  assert.deepEqual(narrate(narrator, at(0.09, {}, { contacts: rattle })), [{ time: 0.031, text: "the rotor is free of catch" }]);
  assert.deepEqual(narrate(narrator, at(0.095, {}, { contacts: rattle })), []);
});

test("an event of the scenario is told in words when it comes, and again after a way back", () => {
  const narrator = newNarrator(), text = "step: u of wheel becomes 5 g mm";
  narrate(narrator, at(0.05));
  assert.deepEqual(narrate(narrator, at(0.11)).map((one) => one.text), [text]);
  assert.deepEqual(narrate(narrator, at(0.06)), []);
  assert.deepEqual(narrate(narrator, at(0.12)).map((one) => one.text), [text]);
});

test("a limit that lasts is told once", () => {
  const narrator = newNarrator(), limited = { current_limited: 1 };
  const told = [0, 0.1, 0.2, 0.3].map((time) => narrate(narrator, at(time, limited)).filter((one) => one.text.includes("limit")).length);
  assert.deepEqual(told, [1, 0, 0, 0]);
});

test("moments between impacts do not end a contact, a longer time does", () => {
  const contacts = [contact(0.1, 1), contact(0.2, 0), contact(0.21, 1)];
  assert.ok(Math.abs(contactTime(at(0.4, {}, { contacts })) - 0.3) < 1e-12);
  assert.equal(contactTime(at(0.4, {}, { contacts: contacts.slice(0, 2) })), 0);
});

test("in a contact that lasts plain adaptation is answered with what works, in a short one with nothing", () => {
  const options = ["Off", "PID", "ROLAC", "Contact-aware"], contacts = [contact(0.1, 1)];
  assert.equal(advice(at(0.5, {}, { contacts }), "ROLAC", options)?.option, "Contact-aware");
  assert.equal(advice(at(0.15, {}, { contacts }), "ROLAC", options), null);
  assert.equal(advice(at(0.5, {}, { contacts }), "ROLAC", options.slice(0, 3)), null);
  assert.equal(advice(at(0.5, {}, { contacts }), "Contact-aware", options), null);
});

test("the push waits until it is let go, and says whether the rotor touched", () => {
  const [push] = experimentsOf(at(0)), [, pushed, letGo] = push.steps;
  const notes = newNotes(0);
  assert.ok(!follow(pushed, notes, at(0.1)));
  assert.ok(follow(pushed, notes, at(0.2, { "wheel.f_x": 30 })));
  const after = newNotes(0.2);
  assert.ok(!follow(letGo, after, at(0.3, { "wheel.f_x": 30, "catch.x": 0.8 * CLEARANCE })));
  assert.ok(!follow(letGo, after, at(0.4)));
  assert.ok(follow(letGo, after, at(0.6)));
  assert.match(letGo.remark(at(0.6), after), /without contact, from 80 %/);
  follow(letGo, after, at(0.7, { "catch.mode": 1 }, forces(0.699, 0, 0.7, 40)));
  assert.match(letGo.remark(at(0.8), after), /touched with a force of up to 40\.0 N, and is free again/);
});

test("a landing counts from the moment at which no magnet pulls", () => {
  const land = experimentsOf(at(0)).find((one) => one.title === "Land"), [drop, watch, lift] = land.steps;
  assert.ok(!follow(drop, newNotes(0), at(0.1)));
  assert.ok(follow(drop, newNotes(0), at(0.1, {}, off(1))));
  const notes = newNotes(0.1);
  follow(watch, notes, at(0.15, { "catch.mode": 1 }, { ...off(1), ...forces(0.149, 0, 0.15, 900) }));
  assert.ok(follow(watch, notes, at(0.3, { "catch.mode": 1 }, off(1))));
  assert.match(watch.remark(at(0.3, { "catch.mode": 1 }, off(1)), notes), /landed 50\.0 ms after the loss of power, and pressed with a force of up to 900 N; it slides/);
  assert.ok(!follow(lift, newNotes(0.3), at(0.7, {}, off(1))));
  const rubbing = { ...off(1), contacts: [contact(0.05, 1)] }, late = newNotes(0.3);
  follow(watch, late, at(0.3, { "catch.mode": 1 }, rubbing));
  assert.match(watch.remark(at(0.5, { "catch.mode": 1 }, rubbing), late), /^It has landed, and pressed/);
});

test("a landing counts from the loss of power, whenever the experiment is chosen", () => {
  const traces = new Traces(["rotor_contact.catch.f_n_mean"], 100);
  traces.append(Float64Array.of(0.19, 0, 0.212, 23100, 0.25, 500, 0.4, 400));
  const falls = (time) => at(time, { "catch.mode": 1, "catch.f_n_mean": 400 }, {
    rig: { ...at(0).rig, events: [{ point: 200, variable: OFF, value: 1, label: "" }] }, traces,
    contacts: [contact(0.212, 1), contact(0.22, 0), contact(0.25, 1)], columns: new Map([...names, OFF].map((name, k) => [name, k])),
    values: Float64Array.from([...names, OFF], (name) => (name === OFF || name.endsWith(".mode") ? 1 : 0)),
  });
  const watch = experimentsOf(falls(0.3)).find((one) => one.title === "Land").steps[1];
  for (const clicked of [0.201, 0.213, 0.3]) {
    const notes = newNotes(clicked);
    follow(watch, notes, falls(Math.max(clicked, 0.22)));
    assert.ok(follow(watch, notes, falls(0.4)));
    assert.match(watch.remark(falls(0.4), notes), /landed 12\.0 ms after the loss of power, and pressed with a force of up to 23\.1 kN/);
  }
});

test("a rotor that its unbalance throws out without gravity has not landed", () => {
  const gravity = (value) => ({ ...off(1), variables: new Map([...variables, ["rotor_contact.gravity", { unit: "m/s2", start: value }]]) });
  const told = [0, 9.81].map((value) => {
    const touching = (time) => at(time, { "catch.mode": 1, "catch.f_n_mean": 900 }, gravity(value)), notes = newNotes(0.1);
    const [push, trap, land] = experimentsOf(touching(0.1)), watch = land.steps[1];
    follow(watch, notes, touching(0.15));
    const now = touching(0.3);
    return [watch.remark(now, notes), watch.remark(now, { ...notes, began: 0.2 }), push.steps[0].instruction(now), push.steps[2].remark(now, notes), trap.steps[0].instruction(now)];
  });
  for (const text of told[0]) { assert.doesNotMatch(text, /landed|lies|falls/); }
  assert.match(told[0][0], /thrown out, and touched 50\.0 ms after the loss of power/);
  for (const text of told[1]) { assert.match(text, /landed|lies/); }
});

test("a machine without amplifiers or discs has no experiment that needs them", () => {
  const bare = at(0, {}, { rig: { ...at(0).rig, geometry: { ...geometry, discs: [] } }, variables: new Map() });
  assert.deepEqual(experimentsOf(bare), []);
});

test("slower than asked is told with its reason, a pace that is kept is not", () => {
  assert.equal(slowness(at(0), 1), "");
  assert.equal(slowness(at(0, {}, { speed: 0.2 }), 0.1), "");
  assert.match(slowness(at(0, { "catch.mode": 1 }, { speed: 0.2 }), 1), /1\/5 of real time: contact at catch takes many small steps/);
  assert.equal(slowness(at(0, {}, { speed: 0.2, status: "paused" }), 1), "");
});

test("a scenario that switches magnets off suits the landing, and is announced", () => {
  const falls = at(0, {}, { rig: { ...at(0).rig, events: [{ point: 200, variable: OFF, value: 1, label: "" }] } });
  const suiting = (session) => experimentsOf(session).filter((item) => item.suits).map((item) => item.title);
  assert.deepEqual(suiting(falls), ["Land"]);
  assert.match(experimentsOf(falls).find((item) => item.suits).steps[0].instruction(falls), /does so itself at 200 ms/);
  assert.deepEqual(suiting(at(0, {}, off(1, 0))), ["Land"]);
  assert.deepEqual(suiting(at(0)), []);
});

test("a rotor is trapped after ten turns in contact, whatever they take", () => {
  const trap = experimentsOf(at(0)).find((one) => one.title === "Trap and free"), columns = new Map([["rotor_contact.speed", 0]]);
  const after = (time, speed) => follow(trap.steps[0], newNotes(0), at(time, {}, { contacts: [contact(0, 1)], columns, values: Float64Array.of(speed) }));
  assert.ok(!after(0.99, 20 * Math.PI));
  assert.ok(after(1.01, 20 * Math.PI));
  assert.ok(!after(1.01, 2 * Math.PI));
});

test("a remark has the largest of all samples, however many of them a frame shows", () => {
  const watch = experimentsOf(at(0)).find((one) => one.title === "Land").steps[1];
  const samples = [[0.101, 0, 0], [0.102, 1, 23100], [0.103, 1, 700], [0.104, 0, 0], [0.105, 1, 1100]];
  const told = [1, 2, 5].map((inFrame) => {
    const traces = new Traces(["rotor_contact.catch.f_n_mean"], 100), notes = newNotes(0.1);
    const contacts = [contact(0.102, 1), contact(0.104, 0), contact(0.105, 1)];
    samples.forEach(([time, mode, force], k) => {
      traces.append(Float64Array.of(time, force));
      if ((k + 1) % inFrame === 0 || k === samples.length - 1) {
        follow(watch, notes, at(time, { "catch.mode": mode, "catch.f_n_mean": force }, { ...off(1), traces, contacts: contacts.filter((one) => one.time <= time) }));
      }
    });
    return watch.remark(at(0.105, { "catch.mode": 1 }, off(1)), notes);
  });
  assert.match(told[0], /landed 2\.00 ms after the loss of power, and pressed with a force of up to 23\.1 kN; it slides/);
  assert.deepEqual(told, [told[0], told[0], told[0]]);
});

test("an impact in the frame that shows the loss of power belongs to the landing", () => {
  const [off_, watch] = experimentsOf(at(0)).find((one) => one.title === "Land").steps;
  const traces = new Traces(["rotor_contact.catch.f_n_mean"], 100), notes = newNotes(-0.5);
  follow(off_, notes, at(0, {}, { ...off(0), traces }));
  traces.append(Float64Array.of(0.001, 0, 0.012, 23100, 0.02, 400));
  const contacts = [contact(0.012, 1)], late = at(0.02, { "catch.mode": 1, "catch.f_n_mean": 400 }, { ...off(1, 0), traces, contacts });
  assert.ok(follow(off_, notes, late));
  const after = nextNotes(notes);
  follow(watch, after, late);
  assert.match(watch.remark(late, after), /landed 12\.0 ms after the loss of power, and pressed with a force of up to 23\.1 kN; it slides/);
});

test("remarks name a site as the rotor file does", () => {
  const trap = experimentsOf(at(0)).find((one) => one.title === "Trap and free");
  assert.match(trap.steps[0].remark(at(1, { "catch.mode": 1 }), newNotes(0)), /at catch,/);
});

test("samples before an experiment begins are not part of it", () => {
  const [push] = experimentsOf(at(0)), traces = new Traces(["rotor_contact.catch.f_n_mean"], 10), notes = newNotes(0.2);
  traces.append(Float64Array.of(0.1, 5000, 0.25, 40));
  follow(push.steps[2], notes, at(0.3, {}, { traces, contacts: [contact(0.1, 1), contact(0.11, 0), contact(0.25, 1), contact(0.26, 0)] }));
  assert.deepEqual([notes.force, notes.touched, notes.touchedAt], [40, true, 0.25]);
});

test("the force is the largest mean over 1 ms with impacts, as in the verdict on a run, not the largest step", () => {
  const { traces } = forces(0.24, 0, 0.24025, 800, 0.2405, 3200, 0.24075, 0, 0.241, 0, 0.25, 40);
  assert.ok(Math.abs(traces.largestMean("rotor_contact.catch.f_n_mean", 0.2, 0.3, 1e-3) - 1000) < 1e-3);
  const [push] = experimentsOf(at(0)), notes = newNotes(0.2);
  for (const time of [0.2404, 0.24065, 0.26]) { follow(push.steps[2], notes, at(time, {}, { traces, contacts: [contact(0.24, 1)] })); }
  assert.ok(Math.abs(notes.force - 1000) < 1e-3); // however the frames divide the impact
});
