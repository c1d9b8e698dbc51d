// The worker that computes: started from the script in the page, so that it needs no other file.

/** @typedef {import("../protocol.js").Request} Request */
/** @typedef {import("../protocol.js").Answer} Answer */

/** @typedef {ReturnType<typeof startEngine>} Engine */

/**
 * Start a worker.
 * @param {string} script
 * @param {(answer: Answer) => void} hear
 * @param {(text: string) => void} fail
 */
export function startEngine(script, hear, fail) {
  const url = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
  const worker = new Worker(url);
  worker.onmessage = (event) => hear(event.data);
  worker.onerror = (event) => fail(event.message || "the worker could not be started");
  return {
    send: (/** @type {Request} */ request) => worker.postMessage(request),
    end: () => {
      worker.terminate();
      URL.revokeObjectURL(url);
    },
  };
}
