// What the keys of the page do.

/**
 * @typedef {object} Actions
 * @property {import("./transport.js").Transport} transport
 * @property {() => void} step
 * @property {() => void} reset
 * @property {() => void} original
 * @property {() => void} share
 * @property {() => void} save
 * @property {() => void} saveCsv
 * @property {() => void} theory
 * @property {() => void} switchTheme
 * @property {() => void} help
 */

/**
 * Return the shortcuts, with what the help says of them.
 * @param {Actions} act
 */
export function shortcutsOf({ transport, ...act }) {
  return [
    { key: " ", label: "space", what: "run or pause", act: transport.toggle },
    { key: "s", label: "S", what: "single communication step", act: act.step },
    { key: "r", label: "R", what: "reset: restart with the present controls", act: act.reset },
    { key: "o", label: "O", what: "the scenario without your changes", act: act.original },
    { key: "-", label: "−", what: "slower", act: () => transport.change(-0.25) },
    { key: "+", label: "+", what: "faster", act: () => transport.change(0.25) },
    { key: "1", label: "1", what: "real time", act: () => transport.setPace(1) },
    { key: "0", label: "0", what: "a tenth of real time", act: () => transport.setPace(0.1) },
    { key: "l", label: "L", what: "copy a link with the settings", act: act.share },
    { key: "f", label: "F", what: "save as a scenario", act: act.save },
    { key: "c", label: "C", what: "save the curves as CSV", act: act.saveCsv },
    { key: "t", label: "T", what: "theory", act: act.theory },
    { key: "d", label: "D", what: "dark or light", act: act.switchTheme },
    { key: "?", label: "?", what: "this help", act: act.help },
  ];
}
