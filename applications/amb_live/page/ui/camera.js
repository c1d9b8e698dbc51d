// Projection of points of the rig to the screen. Rig coordinates: z along the shaft, u to the right and v up as seen from the motor.

/**
 * @typedef {object} Camera
 * @property {number} yaw about the vertical (rad); 0 looks along the shaft
 * @property {number} pitch from above (rad)
 * @property {number} scale pixels per metre
 * @property {number} distance of the eye from the middle (m)
 * @property {readonly [number, number]} centre of the screen (pixels)
 */

/** A point on the screen, and its distance behind the middle (m).
 * @typedef {[x: number, y: number, depth: number]} Projected */

/**
 * Return a function that projects a point (z from the middle of the shaft, u, v; m) to the screen, in weak perspective.
 * @param {Camera} camera
 * @returns {(z: number, u: number, v: number) => Projected}
 */
export function projection(camera) {
  const [cy, sy, cp, sp] = [Math.cos(camera.yaw), Math.sin(camera.yaw), Math.cos(camera.pitch), Math.sin(camera.pitch)];
  return (z, u, v) => {
    const right = cy * u + sy * z, away = cy * z - sy * u;
    const up = cp * v + sp * away, depth = cp * away - sp * v;
    const share = camera.distance / (camera.distance + depth);
    return [camera.centre[0] + camera.scale * share * right, camera.centre[1] - camera.scale * share * up, depth];
  };
}

/**
 * Return a camera turned by a drag or a key.
 * @param {Camera} camera
 * @param {number} yaw rad
 * @param {number} pitch rad
 */
export function turned(camera, yaw, pitch) {
  return { ...camera, yaw: camera.yaw + yaw, pitch: Math.min(Math.max(camera.pitch + pitch, -1.4), 1.4) };
}

/**
 * Return a camera that shows the whole shaft: the box around it fills the screen.
 * @param {Camera} camera
 * @param {number} length of the shaft (m)
 * @param {number} reach largest radius of what is drawn (m)
 * @param {number} width pixels
 * @param {number} height pixels
 * @returns {Camera}
 */
export function fitted(camera, length, reach, width, height) {
  const plain = { ...camera, scale: 1, distance: 2.6 * length, centre: /** @type {const} */ ([0, 0]) };
  const project = projection(plain);
  const corners = [-0.5, 0.5].flatMap((end) => [-1, 1].flatMap((u) => [-1.25, 1].map((v) => project(end * length, u * reach, v * reach))));
  const [x, y] = [0, 1].map((axis) => corners.map((corner) => corner[axis]));
  const [left, right, top, bottom] = [Math.min(...x), Math.max(...x), Math.min(...y), Math.max(...y)];
  const scale = 0.94 * Math.min(width / (right - left), height / (bottom - top));
  return { ...plain, scale, centre: [0.5 * width - 0.5 * scale * (left + right), 0.5 * height - 0.5 * scale * (top + bottom)] };
}
