import assert from "node:assert/strict";
import { test } from "node:test";
import { factorText, quantityText, nameLabel } from "../../../applications/amb_live/page/ui/format.js";

test("a quantity has the prefix that leaves one to three digits before the point", () => {
  const said = [[7.5e-4, "m", "750 µm"], [1234.5, "N", "1.23 kN"], [999.7, "N", "1.00 kN"], [-0.0325, "J", "−32.5 mJ"], [100e-6, "m", "100 µm"]];
  for (const [value, unit, text] of said) { assert.equal(quantityText(value, unit), text); }
});

test("nothing is zero without a prefix, and what is no number is a dash", () => {
  assert.equal(quantityText(0, "N"), "0 N");
  assert.equal(quantityText(NaN, "N"), "–");
});

test("a pace is a multiple or a fraction of real time", () => {
  assert.deepEqual([5, 1, 0.1, 0.001].map(factorText), ["5×", "1×", "1/10", "1/1000"]);
});

test("a code has capitals, another name is that of its file", () => {
  assert.deepEqual(["rb1", "d3", "ret_A", "wheel"].map(nameLabel), ["RB1", "D3", "ret_A", "wheel"]);
});
