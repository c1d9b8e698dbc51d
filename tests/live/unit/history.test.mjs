import assert from "node:assert/strict";
import { test } from "node:test";
import { backTo, keep, newHistory } from "../../../orchestrator/amb_cosim/live/page/cosim/history.js";

function filled(last) {
  const history = newHistory(2), master = { point: 0, values: Float64Array.of(0), members: [] };
  for (let point = -3; point <= last; point++) {
    master.point = point;
    master.values[0] = point;
    keep(history, master, [point]);
  }
  return { history, master };
}

test("moments are evenly spread over the run, from its beginning, and never too many", () => {
  const { history } = filled(10000), points = history.moments.map(({ snapshot }) => snapshot.point);
  assert.equal(points[0], 0);
  assert.ok(points.length < 64 && points.length >= 32);
  assert.ok(points.every((point, k) => point === k * history.every));
});

test("the way back begins at the last moment before a point, and forgets those after", () => {
  const { history, master } = filled(100), moment = backTo(history, master, 51);
  assert.deepEqual([moment.snapshot.point, moment.snapshot.values[0], moment.since[0]], [50, 50, 50]);
  assert.equal(history.moments.at(-1), moment);
  assert.equal(backTo(history, master, -1), undefined);
});
