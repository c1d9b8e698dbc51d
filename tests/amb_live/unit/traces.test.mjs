import assert from "node:assert/strict";
import { test } from "node:test";
import { Traces } from "../../../applications/amb_live/page/ui/traces.js";

/** Traces of t and t^2 at 0, 1, 2, ... */
function squares(count, capacity) {
  const traces = new Traces(["t", "square"], capacity);
  traces.append(Float64Array.from({ length: 3 * count }, (_, k) => { const t = Math.floor(k / 3); return k % 3 === 2 ? t * t : t; }));
  return traces;
}

test("a full ring holds the newest samples", () => {
  const traces = squares(10, 4);
  assert.deepEqual([...traces.between("square", 0, 99)], [36, 49, 64, 81]);
});

test("what lies between two times includes both", () => {
  assert.deepEqual([...squares(10, 16).between("t", 3, 5)], [3, 4, 5]);
});

test("the first sample at a time is found by its time", () => {
  const traces = squares(10, 4); // 6 to 9
  assert.deepEqual([0, 6, 7.5, 10].map((time) => traces.firstAt(time)), [0, 0, 2, 4]);
});

test("after going back, samples go on from there", () => {
  const traces = squares(10, 6);
  traces.truncate(7);
  traces.append(Float64Array.of(8, 8, -1));
  assert.deepEqual([...traces.between("square", 0, 99)], [16, 25, 36, 49, -1]);
});

test("a thinned curve keeps the extremes of each of its spans, in their order", () => {
  const traces = new Traces(["v"], 1000);
  traces.append(Float64Array.from({ length: 1600 }, (_, k) => { const t = Math.floor(k / 2); return k % 2 === 0 ? t : Math.sin(t) * (t === 451 ? 100 : 1); }));
  const [times, values] = traces.thinned(["v"], 0, 800, 20, [2]);
  assert.ok(times.length <= 2 * 21 && times.every((time, k) => k === 0 || time > times[k - 1]));
  assert.ok(Math.abs(Math.max(...values.map(Math.abs)) - Math.abs(200 * Math.sin(451))) < 1e-4);
});

test("few samples are not thinned", () => {
  assert.deepEqual(squares(5, 8).thinned(["square"], 0, 9, 50, [0.5]), [[0, 1, 2, 3, 4], [0, 0.5, 2, 4.5, 8]]);
});

test("a signal that is not recorded is a gap", () => {
  assert.ok(squares(2, 8).thinned(["other"], 0, 9, 50, [1])[1].every(Number.isNaN));
});

test("columns for a file begin with time and hold every sample", () => {
  assert.deepEqual(squares(3, 8).columns().map(({ name, values }) => [name, [...values]]), [["time", [0, 1, 2]], ["t", [0, 1, 2]], ["square", [0, 1, 4]]]);
});
