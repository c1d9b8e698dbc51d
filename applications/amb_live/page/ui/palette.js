// Colours of the drawings, taken from the style sheet, which alone decides between dark and light.

/**
 * @typedef {object} Palette
 * @property {string} ink
 * @property {string} soft
 * @property {string} line
 * @property {string} ground
 * @property {string} panel
 * @property {string} metal
 * @property {string} touch colour of contact
 * @property {string} push colour of a force applied by hand
 * @property {string} font
 * @property {readonly string[]} series a colour for each bearing, after Okabe and Ito
 */

const SERIES = ["--series-1", "--series-2", "--series-3", "--series-4", "--series-5", "--series-6"];

/**
 * Read the present palette.
 * @param {Element} [element]
 */
export function readPalette(element = document.documentElement) {
  const style = getComputedStyle(element);
  const value = (/** @type {string} */ name) => style.getPropertyValue(name).trim();
  return {
    ink: value("--ink"), soft: value("--soft"), line: value("--line"), ground: value("--ground"), panel: value("--panel"), metal: value("--metal"),
    touch: value("--touch"), push: value("--push"), font: value("--font"), series: SERIES.map(value),
  };
}

/**
 * Return the colour of a contact site: that of the bearing that it protects, or one after those of the bearings.
 * @param {Pick<import("../protocol.js").Geometry, "bearings" | "sites">} geometry
 * @param {import("../protocol.js").Site} site
 * @returns {number} index into `series`
 */
export function seriesOfSite(geometry, site) {
  const protects = (/** @type {import("../protocol.js").Site} */ other) => geometry.bearings.findIndex((item) => item.name === other.bearing);
  const others = geometry.sites.filter((item) => protects(item) < 0);
  const index = protects(site);
  return index >= 0 ? index : (geometry.bearings.length + others.findIndex((item) => item.name === site.name)) % SERIES.length;
}

/**
 * Return the colour of a face: that of the retainer on which it lands, or one after those of all sites.
 * @param {Pick<import("../protocol.js").Geometry, "bearings" | "sites" | "faces">} geometry
 * @param {import("../protocol.js").Face} face
 * @returns {number} index into `series`
 */
export function seriesOfFace(geometry, face) {
  const site = geometry.sites.find((item) => item.name === face.retainer);
  return site !== undefined ? seriesOfSite(geometry, site) : (geometry.bearings.length + geometry.sites.length + geometry.faces.indexOf(face)) % SERIES.length;
}

/**
 * Return a colour with less than full opacity.
 * @param {string} colour as #rrggbb
 * @param {number} opacity from 0 to 1
 */
export function faded(colour, opacity) {
  const level = Math.round(255 * Math.min(Math.max(opacity, 0), 1));
  return `${colour}${level.toString(16).padStart(2, "0")}`;
}

/**
 * Return a colour between two.
 * @param {string} from as #rrggbb
 * @param {string} to as #rrggbb
 * @param {number} share of `to`, from 0 to 1
 */
export function mixed(from, to, share) {
  const part = (/** @type {string} */ colour, /** @type {number} */ k) => parseInt(colour.slice(1 + 2 * k, 3 + 2 * k), 16);
  return `#${[0, 1, 2].map((k) => Math.round(part(from, k) + share * (part(to, k) - part(from, k))).toString(16).padStart(2, "0")).join("")}`;
}
