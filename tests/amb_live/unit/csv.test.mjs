import assert from "node:assert/strict";
import { test } from "node:test";
import { csvOf } from "../../../applications/amb_live/page/engine/csv.js";

test("a table has names with units, a line for each sample, and every digit", () => {
  const columns = [
    { name: "time", unit: "s", values: Float64Array.of(0, 250e-6) },
    { name: 'a "b", c', unit: "", values: [0.1 + 0.2, -1e-19] },
  ];
  assert.equal(csvOf(columns), 'time (s),"a ""b"", c"\r\n0,0.30000000000000004\r\n0.00025,-1e-19\r\n');
});
