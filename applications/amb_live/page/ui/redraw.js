// When the page is drawn: for a while after any answer of the worker or action of the user.

const REDRAW_MS = 1000; // for which the page is drawn after anything happened
const EVENTS = ["pointerdown", "pointermove", "keydown", "input", "click", "resize", "scroll"];

/**
 * Draw the page at every frame while anything happens; return a function that lets it draw for a while.
 * @param {() => number} answerCount answers of the worker so far
 * @param {(now: number) => void} draw
 * @param {(now: number) => void} always called at every frame
 */
export function startRedraw(answerCount, draw, always) {
  let drawnAnswers = -1, drawUntil = 0; // answers at the latest drawing, and when drawing may pause (ms)

  /** @param {number} now ms */
  function drawFrame(now) {
    if (answerCount() !== drawnAnswers) { [drawnAnswers, drawUntil] = [answerCount(), now + REDRAW_MS]; }
    if (now < drawUntil) { draw(now); }
    always(now);
    requestAnimationFrame(drawFrame);
  }

  const wake = () => { drawUntil = performance.now() + REDRAW_MS; };
  for (const name of EVENTS) { addEventListener(name, wake, { passive: true, capture: true }); }
  requestAnimationFrame(drawFrame);
  return wake;
}
