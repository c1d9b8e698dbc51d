import assert from "node:assert/strict";
import { test } from "node:test";
import { History } from "../../../applications/amb_live/page/cosim/history.js";

function filled(last) {
  const assembly = { point: 0, snapshot() { return { point: this.point, values: Float64Array.of(this.point), state: 0 }; }, discard() {} };
  const history = new History(assembly, 2);
  for (let point = -3; point <= last; point++) {
    assembly.point = point;
    history.keep([point]);
  }
  return history;
}

test("moments are evenly spread over the run, from its beginning, and never too many", () => {
  const history = filled(10000), points = history.moments.map(({ snapshot }) => snapshot.point);
  assert.equal(points[0], 0);
  assert.ok(points.length < 64 && points.length >= 32);
  assert.ok(points.every((point, k) => point === k * history.every));
});

test("the way back begins at the last moment before a point, and forgets those after", () => {
  const history = filled(100), moment = history.backTo(51);
  assert.deepEqual([moment.snapshot.point, moment.snapshot.values[0], moment.since[0]], [50, 50, 50]);
  assert.equal(history.moments.at(-1), moment);
  assert.equal(history.backTo(-1), undefined);
});
