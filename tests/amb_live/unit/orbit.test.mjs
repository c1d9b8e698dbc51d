import assert from "node:assert/strict";
import { test } from "node:test";
import { contactArcs, fromCanvas, spanOf } from "../../../applications/amb_live/page/ui/orbit.js";
import { nearestDisc, rotationOf } from "../../../applications/amb_live/page/ui/orbits.js";

const F = (...values) => Float32Array.from(values);
const near = (found, wanted) => found.forEach((value, k) => assert.ok(Math.abs(value - wanted[k]) < 1e-9, `${found} is not ${wanted}`));

test("gravity pulls down on the screen", () => {
  const gravityAngle = 1.25 * Math.PI, onScreen = rotationOf({ gravityAngle }) + gravityAngle;
  near([Math.cos(onScreen), Math.sin(onScreen)], [0, -1]);
});

test("a point of the canvas has its place in the rotor's axes", () => {
  near(fromCanvas(200, 100, 200, 200, 1e-3, 0), [1e-3, 0]);
  near(fromCanvas(100, 0, 200, 200, 1e-3, 0), [0, 1e-3]);
  near(fromCanvas(100, 0, 200, 200, 1e-3, 0.5 * Math.PI), [1e-3, 0]); // x points up
});

test("a force on the circle marks its sector, and those that it slid over, the short way", () => {
  const angle = (degrees) => (degrees * Math.PI) / 180, turns = [350, 15], x = F(...turns.map((d) => Math.cos(angle(d)))), y = F(...turns.map((d) => Math.sin(angle(d))));
  assert.deepEqual([...contactArcs(x, y, F(5, 9), 12)], [9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9]);
  assert.deepEqual([...contactArcs(x, y, F(5, 0), 12)], [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 5]);
});

test("the view shows the clearance, and what lies beyond it", () => {
  assert.equal(spanOf(1, F(0.1), F(0)), 1.34);
  assert.ok(Math.abs(spanOf(1, F(0, 3), F(0, 4)) - 5.5) < 1e-6);
});

test("a push acts on the nearest plane of unbalance", () => {
  const discs = [{ name: "a", z: 0, unbalance: true }, { name: "core", z: 0.6, unbalance: false }, { name: "b", z: 1, unbalance: true }];
  assert.deepEqual([0.1, 0.6].map((z) => nearestDisc({ discs }, z)), ["a", "b"]);
  assert.equal(nearestDisc({ discs: [] }, 0), "");
});
