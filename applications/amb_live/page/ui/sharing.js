// Export for the user: a link with the settings, a scenario, the curves.

import { csvOf } from "../engine/csv.js";
import { toHash } from "../engine/link.js";
import { download } from "./dom.js";
import { showNotice } from "./messages.js";

/** @typedef {ReturnType<typeof makeSharing>} Sharing */

/**
 * Return the functions that export a session.
 * @param {() => import("./session.js").Session} present
 * @param {(request: import("../protocol.js").Request) => void} send
 */
export function makeSharing(present, send) {
  function share() {
    if (!hasAddress()) { showNotice("In this frame the page has no address; save your run with Scenario."); return; }
    const { rig, userChanges } = present();
    remember(toHash(rig.scenario, userChanges));
    const refused = () => showNotice("The address now contains the settings: copy it from the address bar.");
    const done = () => showNotice("The address now contains the settings, and is in the clipboard.");
    if (navigator.clipboard === undefined) { refused(); } else { navigator.clipboard.writeText(location.href).then(done, refused); }
  }

  function save() {
    const { scenario, description } = present().rig;
    send({ type: "save", name: `${scenario}_live`, description: `${description}; changed by hand` });
  }

  function saveCsv() {
    const session = present();
    const unit = (/** @type {string} */ name) => (name === "time" ? "s" : session.variables.get(name)?.unit ?? "");
    download(`${session.rig.scenario}.csv`, csvOf(session.traces.columns().map((column) => ({ ...column, unit: unit(column.name) }))), "text/csv");
  }

  return { share, save, saveCsv };
}

/**
 * Write the settings into the address, if the page has one.
 * @param {string} hash
 */
export function remember(hash) {
  if (hasAddress()) { history.replaceState(null, "", `#${hash}`); }
}

/** Return whether the page has an address, which it lacks in a frame of a notebook. */
function hasAddress() {
  return location.protocol !== "about:";
}
