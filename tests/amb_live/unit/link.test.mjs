import assert from "node:assert/strict";
import { test } from "node:test";
import { fromHash, toHash } from "../../../applications/amb_live/page/engine/link.js";

const USER_CHANGES = {
  settings: { values: { "rotor_contact.rb1.mu": 0.1 + 0.2, Omega: 1e-300 }, events: false },
  changes: [
    { point: 3, time: 3 * 250e-6, values: { "rotor_contact.d1.u": 0.1 } },
    { point: 400, time: 0.1, values: { Omega: 260 }, until: 800 },
  ],
};

test("a link holds every bit of what was done, and only characters that a link may have", () => {
  const hash = toHash("my drop=1.toml", USER_CHANGES);
  assert.match(hash, /^[\w.%~-]+=[\w-]+$/);
  assert.deepEqual(fromHash(`#${hash}`, 250e-6), { scenario: "my drop=1.toml", userChanges: USER_CHANGES });
});

test("where nothing was done a link is the name alone", () => {
  const hash = toHash("drop", { settings: {}, changes: [] });
  assert.equal(hash, "drop");
  assert.deepEqual(fromHash(hash, 250e-6), { scenario: "drop", userChanges: { settings: {}, changes: [] } });
});

test("a damaged link is refused with its reason", () => {
  const hash = toHash("drop", USER_CHANGES);
  for (const damaged of [hash.slice(0, -9), "drop=!!", "drop=e30", toHash("drop", { settings: {}, changes: [{ point: -1, values: {} }] })]) {
    assert.throws(() => fromHash(damaged, 250e-6), /the link is damaged/);
  }
});
