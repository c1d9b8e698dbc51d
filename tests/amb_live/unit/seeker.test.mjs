import assert from "node:assert/strict";
import { test } from "node:test";
import { makeSeeker } from "../../../applications/amb_live/page/ui/seeker.js";

function seeking() {
  const sent = [], session = { time: 1, status: "paused", rig: { stepSize: 0.01 } };
  const seeker = makeSeeker(() => session, (request) => sent.push(request));
  const arrive = (time, status = "paused") => { Object.assign(session, { time, status }); seeker.heard(); };
  return { sent, seeker, arrive };
}

test("back in time is a rewind, ahead a run, and where it is already nothing", () => {
  const { sent, seeker, arrive } = seeking();
  seeker.go(1, true);
  seeker.go(0.5, true);
  arrive(0.5);
  seeker.go(2, true);
  assert.deepEqual(sent, [{ type: "rewind", time: 0.5, keep: true }, { type: "run", to: 2 }]);
});

test("of those asked for under way the last counts, when it has arrived", () => {
  const { sent, seeker, arrive } = seeking();
  for (const time of [0.5, 0.6, 0.7, 1.5]) { seeker.go(time, false); }
  arrive(0.4, "settling");
  arrive(0.4); // a pause that came before
  assert.equal(sent.length, 1);
  arrive(0.5);
  assert.deepEqual(sent[1], { type: "run", to: 1.5 });
});

test("after a failure, or when something else was asked for, it goes nowhere", () => {
  const { sent, seeker, arrive } = seeking();
  seeker.go(2, true);
  seeker.go(3, true);
  arrive(1.7, "failed");
  seeker.go(0.1, true);
  seeker.drop();
  arrive(0.1);
  assert.deepEqual(sent.map((request) => request.type), ["run", "rewind"]);
});
