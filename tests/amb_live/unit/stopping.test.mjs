import assert from "node:assert/strict";
import { test } from "node:test";
import { conditionMet } from "../../../applications/amb_live/page/cosim/stopping.js";

/** Return the point at which a signal with these values ends the run. */
function end(values, condition) {
  const since = [condition.first];
  for (let point = 0; point < values.length; point++) {
    if (conditionMet([condition], [0], since, Float64Array.of(values[point]), point) === 0) { return point; }
  }
  return -1;
}

test("without a hold one point above the limit is enough, from the first point on", () => {
  assert.equal(end([3, 0, 3, 0], { above: true, limit: 2, first: 1, hold: 0 }), 2);
  assert.equal(end([2, 2], { above: true, limit: 2, first: 0, hold: 0 }), -1);
});

test("a hold begins anew where the signal falls back", () => {
  assert.equal(end([0, 0, 5, 0, 0, 0], { above: false, limit: 1, first: 0, hold: 2 }), 5);
});

test("a value that is no number meets nothing", () => {
  assert.equal(end([NaN, NaN], { above: false, limit: 1, first: 0, hold: 0 }), -1);
});
