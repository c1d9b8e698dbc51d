// A host of one FMU as WebAssembly: arguments are the module, its model.bin, its guid; the standard input is
// {"set": {reference: value}, "get": reference, "steps": n, "stepSize": s}, the output what was got and what is im- and exported.

import { readFileSync } from "node:fs";
import {
  enterInitialisation, exchange, exitInitialisation, fetch, instantiate, release, send, step,
} from "../../../applications/amb_live/page/fmi/instance.js";
import { startLibrary } from "../../../applications/amb_live/page/fmi/library.js";

const [file, data, guid] = process.argv.slice(2), { set, get, steps, stepSize } = JSON.parse(readFileSync(0, "utf8"));
const module = new WebAssembly.Module(readFileSync(file)), library = startLibrary(module);
const result = {
  imports: WebAssembly.Module.imports(module).map(({ module: from, name }) => `${from}.${name}`),
  exports: WebAssembly.Module.exports(module).map(({ name }) => name),
  values: [],
};
const real = (reference) => ({ reference, type: "Real" });
try {
  const instance = instantiate(library, "one", guid, readFileSync(data).toString("base64"));
  const outputs = exchange(instance, [real(get)]), values = new Float64Array(1);
  enterInitialisation(instance, 0);
  for (const [reference, value] of Object.entries(set)) {
    send(instance, exchange(instance, [real(Number(reference))]), Float64Array.of(value), Int32Array.of(0));
  }
  exitInitialisation(instance);
  for (let n = 0; n < steps; n++) {
    step(instance, n * stepSize, stepSize);
    fetch(instance, outputs, values, 0);
    result.values.push(values[0]);
  }
  release(instance);
} catch (error) {
  result.error = error.message;
}
process.stdout.write(JSON.stringify(result));
