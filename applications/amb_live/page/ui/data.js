// The data of the page, written by Python: scenarios, with shared parts once.

import { byId } from "./dom.js";

/** @typedef {import("../protocol.js").Rig} Rig */
/** @typedef {import("../protocol.js").Component} Component */
/** @typedef {import("../protocol.js").Parts} Parts */

/**
 * Scenarios whose components refer to their variables by a key.
 * @typedef {object} Described
 * @property {string} documentation address of the documentation; empty without any
 * @property {(Omit<Rig, "components"> & { components: (Omit<Component, "variables"> & { variables: string })[] })[]} rigs
 * @property {Record<string, Component["variables"]>} variables
 */

/**
 * @typedef {object} PageData
 * @property {Described} described
 * @property {Record<string, string>} parts packed
 */

/** Read the data of the page. */
export async function readPageData() {
  const { described, parts } = JSON.parse(byId("data", HTMLScriptElement).text);
  return { described: JSON.parse(new TextDecoder().decode(await unpacked(described))), parts };
}

/**
 * Return a scenario of the page; the first if the name is unknown.
 * @param {PageData} data
 * @param {string} scenario
 */
export function rigOf({ described }, scenario) {
  const chosen = described.rigs.find((rig) => rig.scenario === scenario) ?? described.rigs[0];
  return { ...chosen, components: chosen.components.map((item) => ({ ...item, variables: described.variables[item.variables] })) };
}

/**
 * Return the bytes that a scenario needs.
 * @param {PageData} data
 * @param {Rig} rig
 */
export async function partsOf({ parts }, rig) {
  return Object.fromEntries(await Promise.all([rig.module, rig.data].map(async (key) => /** @type {const} */ ([key, await unpacked(parts[key])]))));
}

/**
 * Return the bytes of a text by Python: base64 of gzip.
 * @param {string} text
 */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
