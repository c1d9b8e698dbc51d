// Functions that look up and create elements of the page.

/**
 * Return the element with an id.
 * @template {HTMLElement} T
 * @param {string} id
 * @param {new () => T} kind
 */
export function byId(id, kind) {
  const element = document.getElementById(id);
  if (!(element instanceof kind)) { throw new Error(`the page has no ${kind.name} #${id}`); }
  return element;
}

/**
 * Return a new element.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, string | boolean>} [attributes] `text` is its content
 * @param {(Node | string)[]} [children]
 */
export function make(tag, attributes = {}, children = []) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "text") {
      element.textContent = String(value);
    } else if (value !== false) {
      element.setAttribute(name, value === true ? "" : value);
    }
  }
  element.append(...children);
  return element;
}

/**
 * Return a text as nodes, with indices (`_x`) and exponents (`^{x}`) as elements.
 * @param {string} text
 */
export function typeset(text) {
  return text.split(/(_[A-Za-z]+|\^\{[^}]*\})/).filter((part) => part !== "").map((part) => {
    if (part.startsWith("_")) { return make("sub", { text: part.slice(1) }); }
    return part.startsWith("^{") ? make("sup", { text: part.slice(2, -1) }) : part;
  });
}

/**
 * Set an element's text if it differs, which avoids needless redrawing.
 * @param {HTMLElement} element
 * @param {string} text
 */
export function setText(element, text) {
  if (element.textContent !== text) { element.textContent = text; }
}

/**
 * Offer a file to save.
 * @param {string} name
 * @param {string} text
 * @param {string} kind media type
 */
export function download(name, text, kind) {
  const url = URL.createObjectURL(new Blob([text], { type: kind }));
  make("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
