// Messages to the user for the worker's answers.

import { download } from "./dom.js";
import { addMessage, showFailure, showNotice } from "./messages.js";

/**
 * Show the message of an answer, and download a saved scenario.
 * @param {import("../protocol.js").Answer} answer
 */
export function showAnswer(answer) {
  if (answer.type === "refused") { showFailure(answer.text); }
  if (answer.type === "failed") { showFailure(`${answer.component || "The run failed"} at ${answer.time.toFixed(4)} s: ${answer.text}. Go back in time, or reset.`); }
  if (answer.type === "warning") { addMessage(answer.component, answer.text, answer.time); }
  if (answer.type === "ended" && answer.reason !== "reached") { showNotice(answer.reason === "completed" ? "The scenario ends here. Run continues it." : answer.text); }
  if (answer.type === "saved") {
    download(`${answer.name}.toml`, answer.toml, "application/toml");
    showNotice(`Saved ${answer.name}.toml: amb-cosim run ${answer.name}.toml repeats this run.`);
  }
}
