// When the page is drawn: for a while after anything was heard of the worker or of the user.

const REDRAW_MS = 1000; // ms that the page is drawn after anything happened
const EVENTS = ["pointerdown", "pointermove", "keydown", "input", "click", "resize", "scroll"];

/**
 * Draw the page at every frame while anything happens; return what makes it draw for a while.
 * @param {() => number} heard how many answers of the worker were heard
 * @param {(now: number) => void} draw
 * @param {(now: number) => void} always what is done at every frame
 */
export function startRedraw(heard, draw, always) {
  let drawn = -1, rests = 0; // what was heard when it was drawn last, and when drawing may rest (ms)

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
