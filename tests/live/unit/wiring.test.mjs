import assert from "node:assert/strict";
import { test } from "node:test";
import { layOut } from "../../../orchestrator/amb_cosim/live/page/cosim/wiring.js";

const variable = (name, type, causality, variability = "continuous") => ({ name, type, causality, variability });
const RIG = {
  signals: [{ name: "Omega", targets: ["a.Omega", "b.Omega"] }],
  connections: [{ source: "b.y", target: "a.u" }, { source: "a.n", target: "b.m" }],
  components: [
    { name: "a", variables: [
      variable("k", "Real", "parameter", "tunable"), variable("fixed", "Real", "parameter", "fixed"), variable("u", "Real", "input"),
      variable("Omega", "Real", "input"), variable("free", "Boolean", "input"), variable("n", "Integer", "output"),
      variable("x", "Real", "output")] },
    { name: "b", variables: [
      variable("m", "Integer", "input"), variable("Omega", "Real", "input"), variable("y", "Real", "output")] },
  ],
};

test("signals come first, then what may be set, then outputs, those of one type together", () => {
  const { names, outside, slots } = layOut(RIG);
  assert.deepEqual(names, ["Omega", "a.k", "a.free", "a.x", "a.n", "b.y"]);
  assert.deepEqual(outside.map(({ component }) => component), [-1, 0, 0]);
  assert.deepEqual(slots.map(({ first }) => first), [3, 5]);
});

test("inputs are fed by outputs and signals", () => {
  const [a, b] = layOut(RIG).slots;
  assert.deepEqual([a.inputs.map(({ name }) => name), [...a.sources]], [["u", "Omega"], [5, 0]]);
  assert.deepEqual([b.inputs.map(({ name }) => name), [...b.sources]], [["Omega", "m"], [0, 4]]);
});
