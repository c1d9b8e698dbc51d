// Real-time factors in node; the arguments are the folder of the rigs and that of the page.

import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, page] = process.argv.slice(2), { Session } = await import(pathToFileURL(`${page}/engine/session.js`));
const { scenarios, rounds } = JSON.parse(readFileSync(`${folder}/request.json`, "utf8")), factors = {};
const clock = () => performance.now();

for (const { name, until } of scenarios) {
  const read = (key) => readFileSync(`${folder}/${name}/${key}`), rig = JSON.parse(read("rig.json"));
  const parts = Object.fromEntries([rig.module, rig.data].map((key) => [key, new Uint8Array(read(key))]));
  const to = until ?? rig.last * rig.stepSize, session = new Session(() => {});
  factors[name] = [];
  for (let round = 0; round <= rounds; round++) {
    for (const request of [{ type: "load", rig, parts }, { type: "run", to }]) {
      const begin = clock();
      session.handle(request, begin);
      while (session.course) { session.work(clock(), clock); }
      if (request.type === "run") { factors[name].push(to / (clock() - begin) * 1000); }
    }
  }
}
process.stdout.write(JSON.stringify(factors));
