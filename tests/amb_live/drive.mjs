// Drives a session: reads a folder with `rig.json` and the parts, and requests as JSON from the standard input; writes the
// answers as JSON. A request {"type": "wait", "ms": 50} lets it play.

import { readFileSync } from "node:fs";
import { Session } from "../../applications/amb_live/page/engine/session.js";

const [folder] = process.argv.slice(2), rig = JSON.parse(readFileSync(`${folder}/rig.json`, "utf8"));
const parts = Object.fromEntries([rig.module, rig.data].map((key) => [key, new Uint8Array(readFileSync(`${folder}/${key}`))]));
const answers = [], clock = () => performance.now();
const session = new Session((answer) => answers.push(answer));

for (const request of JSON.parse(readFileSync(0, "utf8"))) {
  if (request.pace === "Infinity") { request.pace = Infinity; }
  const until = request.type === "wait" ? clock() + request.ms : Infinity;
  if (request.type !== "wait") { session.handle(request.type === "load" ? { rig, parts, ...request } : request, clock()); }
  const isPlayed = request.type === "play";
  while (!isPlayed && session.course && clock() < until) { session.work(clock(), clock); }
}
process.stdout.write(JSON.stringify(answers, (_, value) => value instanceof Float64Array ? [...value] : value));
