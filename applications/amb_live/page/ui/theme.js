// Dark or light: as the system prefers until the user chooses, and then as chosen.

const KEY = "amb-cosim-live-theme";

/**
 * Apply the theme, and return what switches it.
 * @param {() => void} changed called after each change
 */
export function startTheme(changed) {
  const system = matchMedia("(prefers-color-scheme: light)");
  const apply = () => {
    document.documentElement.dataset.theme = chosen() ?? (system.matches ? "light" : "dark");
    changed();
  };
  system.addEventListener("change", apply);
  apply();
  return () => {
    choose(document.documentElement.dataset.theme === "light" ? "dark" : "light");
    apply();
  };
}

/** A page opened from a file may have no storage. @returns {string | null} */
function chosen() {
  try { return localStorage.getItem(KEY); } catch { return null; }
}

/** @param {string} theme */
function choose(theme) {
  try { localStorage.setItem(KEY, theme); } catch { document.documentElement.dataset.theme = theme; }
}
