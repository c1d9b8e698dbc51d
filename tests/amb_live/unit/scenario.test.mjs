import assert from "node:assert/strict";
import { test } from "node:test";
import { scenarioToml } from "../../../applications/amb_live/page/engine/scenario.js";

const variable = (name, type, causality, start = 0) => ({ name, type, causality, start });
const RIG = {
  version: "1", scenario: "base", description: 'a "quoted" one', source: "", system: "levitated", rotor: null, receptances: null,
  gradient: true, stepSize: 0.5, first: -4, events: [{ point: 1, variable: "a.u", value: 1, label: "step" }],
  stops: [{ signal: "a.y", above: false, limit: 2, first: 2, hold: 3, text: "" }],
  inputs: { Omega: Math.PI, "a.u": 0 },
  signals: [{ name: "Omega", targets: ["a.Omega"] }],
  components: [{
    name: "a",
    parameters: { k: 1e21, law: 2, on: 1 },
    variables: [
      variable("k", "Real", "parameter"), variable("law", "Integer", "parameter"), variable("on", "Boolean", "parameter"),
      variable("u", "Real", "input"), variable("Omega", "Real", "input"), variable("off", "Boolean", "input"),
    ],
  }],
};

test("values stand in it as their variables take them", () => {
  const toml = scenarioToml(RIG, { settings: { values: { "a.on": 0, "a.off": 1, "a.u": 3 } }, changes: [] }, [], 8);
  for (const line of ['"k" = 1e+21', '"law" = 2', '"on" = false', '"off" = true', '"u" = 3.0', `Omega = "${Math.PI} rad/s"`, "end_time = 4.0"]) {
    assert.ok(toml.split("\n").includes(line), line);
  }
  assert.ok(toml.includes('description = "a \\"quoted\\" one"'));
  assert.ok(toml.includes('[[stop]]\nvariable = "a.y"\nbelow = 2.0\nhold_time = 1.5\nfrom_time = 1.0'));
});

test("settling begins at the same point", () => {
  const cycles = Number(/settle_cycles = (\S+)/.exec(scenarioToml(RIG, { settings: {}, changes: [] }, [], 8))[1]);
  assert.ok(Math.abs(cycles * 2 / RIG.stepSize + RIG.first) < 1e-9); // a cycle at pi rad/s takes 2 s
});

test("events of scenario and user come in order, each label once, none after the end, and the last one wins", () => {
  const changes = [{ point: 1, time: 0.5, values: { "a.u": 2, "a.off": 1 } }, { point: 9, time: 4.5, values: { "a.u": 5 } }];
  const toml = scenarioToml(RIG, { settings: {}, changes }, [], 8);
  assert.equal(toml.match(/\[\[event\]\]/g).length, 1);
  assert.ok(toml.includes('[[event]]\nlabel = "step"\ntime = 0.5\nset.a."u" = 2.0\nset.a."off" = true'));
});

test("without the scenario's events there are those of the user alone, and speeds have their points", () => {
  const toml = scenarioToml(RIG, { settings: { events: false }, changes: [] }, [[0, 3], [2, 3], [6, 4.5]], 8);
  assert.ok(!toml.includes("[[event]]") && !toml.includes("[[stop]]"));
  assert.ok(toml.endsWith("[[speed]]\ntime = 1.0\nOmega = \"3.0 rad/s\"\n\n[[speed]]\ntime = 3.0\nOmega = \"4.5 rad/s\"\n"));
});
