// When the page is drawn: for a while after any answer of the worker or action of the user.

const REDRAW_MS = 1000; // ms that the page is drawn after anything happened
const EVENTS = ["pointerdown", "pointermove", "keydown", "input", "click", "resize", "scroll"];

/**
 * Draw the page at every frame while anything happens; return a function that lets it draw for a while.
 * @param {() => number} heard number of answers of the worker so far
 * @param {(now: number) => void} draw
 * @param {(now: number) => void} always called at every frame
 */
export function startRedraw(heard, draw, always) {
  let drawn = -1, rests = 0; // answers at the latest drawing, and when drawing may pause (ms)

  /** @param {number} now ms */
  function picture(now) {
    if (heard() !== drawn) { [drawn, rests] = [heard(), now + REDRAW_MS]; }
    if (now < rests) { draw(now); }
    always(now);
    requestAnimationFrame(picture);
  }

  const wake = () => { rests = performance.now() + REDRAW_MS; };
  for (const name of EVENTS) { addEventListener(name, wake, { passive: true, capture: true }); }
  requestAnimationFrame(picture);
  return wake;
}
