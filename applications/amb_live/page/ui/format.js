// Numbers and names as text: four digits, a prefix of the unit, a true minus sign; a code in capitals.

const PREFIXES = /** @type {const} */ ([[1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]]);

/** Units that take a prefix, with how they are written; the others are displayed as they are. @type {Record<string, string>} */
const PREFIXED = { m: "m", N: "N", J: "J", A: "A", V: "V", W: "W", s: "s", "N/m": "N/m" };

/** @type {Record<string, string>} */
const WRITTEN = {
  "kg.m": "kg m", "N.s/m": "N s/m", "N/(m.s)": "N/(m s)", "rad/s": "rad/s", "m/s2": "m/s²", "N.m": "N m", "N.m.s": "N m s",
  "kg.m2": "kg m²", "1/s": "1/s", "N.s": "N s", m2: "m²", Ohm: "Ω", "rad/s2": "rad/s²",
};

/**
 * Return a unit as it is printed.
 * @param {string} unit
 */
export function unitText(unit) {
  return WRITTEN[unit] ?? unit;
}

/**
 * Return a number with up to `digits` significant digits, without exponent where that is short.
 * @param {number} value
 * @param {number} [digits]
 */
export function numberText(value, digits = 4) {
  if (!Number.isFinite(value)) { return "–"; }
  if (value === 0) { return "0"; }
  const size = Math.abs(value);
  const text = size >= 1e6 || size < 1e-4 ? value.toExponential(Math.max(digits - 2, 0)) : String(Number(value.toPrecision(digits)));
  return text.replace("-", "−");
}

/**
 * Return a value with the prefix of its unit that leaves 1 to 3 digits before the point.
 * @param {number} value in the unit
 * @param {string} unit
 * @param {number} [digits] significant ones
 */
export function quantityText(value, unit, digits = 3) {
  if (!Number.isFinite(value)) { return "–"; }
  const base = PREFIXED[unit];
  if (base === undefined) { return `${numberText(value, digits)} ${unitText(unit)}`.trim(); }
  const size = Math.abs(value);
  const [scale, prefix] = size < 5e-10 ? [1, ""] : (PREFIXES.find(([factor]) => size >= 0.9995 * factor) ?? [1e-9, "n"]);
  const scaled = value / scale, rounded = Math.abs(Number(scaled.toPrecision(digits)));
  const decimals = Math.max(digits - 1 - Math.floor(Math.log10(rounded)), 0);
  const text = size < 5e-10 ? "0" : scaled.toFixed(Math.min(decimals, digits));
  return `${text.replace("-", "−")} ${prefix}${base}`;
}

/**
 * Return a time in s with a fixed number of decimals, so that a running clock does not jump.
 * @param {number} seconds
 */
export function clockText(seconds) {
  return `${seconds.toFixed(4).replace("-", "−")} s`;
}

/**
 * Return the pace of the simulation as text.
 * @param {number} factor simulated over real time
 */
export function factorText(factor) {
  return factor >= 1 ? `${numberText(factor, 2)}×` : `1/${numberText(1 / factor, 3)}`;
}

/**
 * Return a name as a reader sees it: a letter or two with a number in capitals (W1), any other as in its file.
 * @param {string} name
 */
export function nameLabel(name) {
  return /^[a-z]{1,2}\d+$/.test(name) ? name.toUpperCase() : name;
}
