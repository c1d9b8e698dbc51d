// Settings and changes in the hash of a link: the name of the scenario, =, and JSON in base64url.

/** @typedef {import("../protocol.js").UserChanges} UserChanges */

/**
 * Return the hash of a link, without `#`.
 * @param {string} scenario
 * @param {UserChanges} userChanges
 */
export function toHash(scenario, { settings, changes }) {
  const isChanged = Object.keys(settings.values ?? {}).length > 0 || settings.events === false || changes.length > 0;
  const compact = [settings.values ?? {}, settings.events !== false, changes.map(({ point, values, until }) => [point, values, until])];
  const text = isChanged ? String.fromCharCode(...new TextEncoder().encode(JSON.stringify(compact))) : "";
  return encodeURIComponent(scenario) + (isChanged ? `=${btoa(text).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "")}` : "");
}

/**
 * Return the scenario and the changes of a hash by `toHash`.
 * @param {string} hash with or without `#`
 * @param {number} stepSize s
 * @throws {Error} if the hash is damaged
 */
export function fromHash(hash, stepSize) {
  const text = hash.replace(/^#/, ""), equals = text.indexOf("=");
  const name = equals < 0 ? text : text.slice(0, equals), scenario = decodeURIComponent(name);
  if (equals < 0) { return { scenario, userChanges: { settings: {}, changes: [] } }; }
  try {
    const bytes = Uint8Array.from(atob(text.slice(equals + 1).replaceAll("-", "+").replaceAll("_", "/")), (item) => item.charCodeAt(0));
    const [values, events, changes] = JSON.parse(new TextDecoder().decode(bytes));
    const userChanges = { settings: { values: numbers(values), events: events !== false }, changes: changes.map(changeOf) };
    return { scenario, userChanges };
  } catch {
    throw new Error("the link is damaged: the part after the scenario's name is not valid");
  }

  /** @param {[number, unknown, number?]} change */
  function changeOf([point, values, until]) {
    if (!Number.isInteger(point) || point < 0) { throw new Error(); }
    const change = { point, time: point * stepSize, values: numbers(values) };
    return until === undefined || until === null ? change : { ...change, until: Number(until) };
  }
}

/** @param {unknown} values */
function numbers(values) {
  const entries = Object.entries(/** @type {Record<string, number>} */ (values));
  if (entries.some(([, value]) => typeof value !== "number")) { throw new Error(); }
  return Object.fromEntries(entries);
}
