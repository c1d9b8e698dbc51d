// A canvas with the resolution of the screen, and its size in CSS pixels.

/** @typedef {ReturnType<typeof surfaceOf>} Surface */

/** Measured sizes, so that drawing does not trigger a layout. @type {WeakMap<Element, { width: number, height: number }>} */
const sizes = new WeakMap();
/** @type {ResizeObserver | null} */
let observer = null;

/**
 * Return the size of an element in CSS pixels.
 * @param {Element} element
 */
function sizeOf(element) {
  const known = sizes.get(element);
  if (known !== undefined) { return known; }
  observer ??= new ResizeObserver((entries) => entries.forEach(({ target }) => sizes.set(target, { width: target.clientWidth, height: target.clientHeight })));
  observer.observe(element);
  const size = { width: element.clientWidth, height: element.clientHeight };
  sizes.set(element, size);
  return size;
}

/**
 * Clear a canvas and return its surface.
 * @param {HTMLCanvasElement} canvas
 */
export function surfaceOf(canvas) {
  const ratio = window.devicePixelRatio || 1, { width, height } = sizeOf(canvas);
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  const context = canvas.getContext("2d");
  if (context === null) { throw new Error("this browser does not support canvas"); }
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

/**
 * Draw an arrow.
 * @param {CanvasRenderingContext2D} context
 * @param {number} x0
 * @param {number} y0
 * @param {number} x1
 * @param {number} y1
 * @param {string} colour
 * @param {number} [width]
 */
export function arrow(context, x0, y0, x1, y1, colour, width = 2.5) {
  const length = Math.hypot(x1 - x0, y1 - y0);
  if (length < 1) { return; }
  const [ux, uy] = [(x1 - x0) / length, (y1 - y0) / length], head = Math.min(3.2 * width + 2, length);
  context.save();
  context.strokeStyle = context.fillStyle = colour;
  context.lineWidth = width;
  context.lineCap = "round";
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1 - 0.8 * head * ux, y1 - 0.8 * head * uy);
  context.stroke();
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x1 - head * ux - 0.45 * head * uy, y1 - head * uy + 0.45 * head * ux);
  context.lineTo(x1 - head * ux + 0.45 * head * uy, y1 - head * uy - 0.45 * head * ux);
  context.fill();
  context.restore();
}
