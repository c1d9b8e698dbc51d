import assert from "node:assert/strict";
import { test } from "node:test";
import { addChange, apply, rampAt } from "../../../applications/amb_live/page/cosim/schedule.js";

const POINTS = [[0, 10], [4, 18], [6, 18], [8, 12]];

test("a ramp is linear between its points and constant outside", () => {
  const values = [-5, 0, 1, 4, 5, 7, 8, 99].map((point) => rampAt(POINTS, point, 0.5).value);
  assert.deepEqual(values, [10, 10, 12, 18, 18, 15, 12, 12]);
});

test("the slope of a ramp is that over the coming step, in a second", () => {
  const slopes = [-1, 0, 3, 4, 6, 7, 8].map((point) => rampAt(POINTS, point, 0.5).slope);
  assert.deepEqual(slopes, [0, 4, 4, 0, -6, -6, 0]);
});

test("of several changes at a point the last one counts, and a ramp after them", () => {
  const schedule = { changes: new Map(), ramps: [{ points: POINTS, valuePosition: 2, slopePosition: 3 }], stepSize: 0.5 };
  [[0, 1], [0, 2], [2, 99]].forEach(([position, value]) => addChange(schedule, 1, position, value));
  const set = new Map();
  apply(schedule, 1, (position, value) => set.set(position, value));
  assert.deepEqual([...set], [[0, 2], [2, 12], [3, 4]]);
});
