import assert from "node:assert/strict";
import { test } from "node:test";
import { backTo, keep, newHistory } from "../../../applications/amb_live/page/cosim/history.js";

const call = { malloc: () => 8, free() {}, fmi2GetFMUstate: () => 0, fmi2FreeFMUstate: () => 0 };
const instance = { library: { call }, integers: new Int32Array(4), reals: new Float64Array(2) }; // an FMU that keeps nothing

function filled(last) {
  const history = newHistory(2), assembly = { point: 0, values: Float64Array.of(0), instance };
  for (let point = -3; point <= last; point++) {
    assembly.point = point;
    assembly.values[0] = point;
    keep(history, assembly, [point]);
  }
  return { history, assembly };
}

test("moments are evenly spread over the run, from its beginning, and never too many", () => {
  const { history } = filled(10000), points = history.moments.map(({ snapshot }) => snapshot.point);
  assert.equal(points[0], 0);
  assert.ok(points.length < 64 && points.length >= 32);
  assert.ok(points.every((point, k) => point === k * history.every));
});

test("the way back begins at the last moment before a point, and forgets those after", () => {
  const { history, assembly } = filled(100), moment = backTo(history, assembly, 51);
  assert.deepEqual([moment.snapshot.point, moment.snapshot.values[0], moment.since[0]], [50, 50, 50]);
  assert.equal(history.moments.at(-1), moment);
  assert.equal(backTo(history, assembly, -1), undefined);
});
