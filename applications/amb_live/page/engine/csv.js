// Curves as CSV: a line of names with units, then a line for each sample.

/** @param {readonly { name: string, unit: string, values: ArrayLike<number> }[]} columns of equal length */
export function csvOf(columns) {
  const head = columns.map(({ name, unit }) => quoted(unit ? `${name} (${unit})` : name)).join(",");
  const lines = Array.from({ length: columns[0]?.values.length ?? 0 }, (_, k) => columns.map(({ values }) => values[k]).join(","));
  return `${[head, ...lines].join("\r\n")}\r\n`;
}

/** @param {string} text */
function quoted(text) {
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
