import assert from "node:assert/strict";
import { test } from "node:test";
import { fitted, projection, turned } from "../../../applications/amb_live/page/ui/camera.js";
import { apart, deflection, enlargementOf, roomOf } from "../../../applications/amb_live/page/ui/shaft.js";

const geometry = {
  nodes: [{ z: 0, radius: 0.02 }, { z: 1, radius: 0.02 }, { z: 2, radius: 0.02 }],
  discs: [{ name: "d", z: 2, radius: 0.1, width: 0.02, unbalance: true }], bearings: [], planes: [], faces: [], thrust: "",
  sites: [{ name: "r", z: 0, clearance: 5e-4 }],
  shape: { places: [{ z: 0, x: "ax", y: "ay" }, { z: 2, x: "bx", y: "by" }], rows: [[1, 0], [0.5, 0.5], [0, 1]] },
};
const value = (name) => ({ ax: 1e-3, ay: 0, bx: 0, by: 2e-3 })[name];
const near = (found, wanted) => found.forEach((one, k) => assert.ok(Math.abs(one - wanted[k]) < 1e-12, `${found} is not ${wanted}`));

test("the shaft passes through what the planes show, and between them as its shape says", () => {
  const bent = deflection(geometry, value);
  near(bent.at(0), [1e-3, 0]);
  near(bent.at(1), [0.5e-3, 1e-3]);
  near(bent.at(1.5), [0.25e-3, 1.5e-3]);
  near(bent.at(2), [0, 2e-3]);
});

test("displacements are enlarged by a round number, so that a clearance is as wide as most of a disc", () => {
  assert.equal(enlargementOf(geometry), 100); // 0.5 mm as wide as half of the disc's 100 mm
});

test("the picture has room for the disc that is farthest out", () => {
  assert.ok(Math.abs(roomOf(geometry, value, 100) - (0.1 + 0.2 + 0.05)) < 1e-12);
});

test("a camera that looks along the shaft sees up as up and right as right", () => {
  const project = projection({ yaw: 0, pitch: 0, scale: 100, distance: 10, centre: [50, 50] });
  near(project(0, 0, 0), [50, 50, 0]);
  assert.ok(project(0, 1, 0)[0] > 50 && project(0, 0, 1)[1] < 50 && project(1, 0, 0)[2] > 0);
});

test("every corner of what is shown is on the screen, from wherever one looks", () => {
  for (const [yaw, pitch] of [[-1, 0.3], [0.4, -0.9], [1.5, 1.2]]) {
    const camera = fitted(turned({ yaw: 0, pitch: 0, scale: 1, distance: 1, centre: [0, 0] }, yaw, pitch), 2, 0.2, 400, 200);
    const project = projection(camera);
    for (const z of [-1, 1]) {
      for (const u of [-0.2, 0.2]) {
        for (const v of [-0.2, 0.2]) {
          const [x, y] = project(z, u, v);
          assert.ok(x >= 0 && x <= 400 && y >= 0 && y <= 200, `${x}, ${y}`);
        }
      }
    }
  }
});

test("a rotor of a tenth of the size looks the same", () => {
  const small = {
    ...geometry, nodes: geometry.nodes.map((node) => ({ z: 0.1 * node.z, radius: 0.1 * node.radius })),
    discs: geometry.discs.map((item) => ({ ...item, z: 0.1 * item.z, radius: 0.1 * item.radius })),
    sites: geometry.sites.map((item) => ({ ...item, clearance: 0.1 * item.clearance })),
  };
  assert.equal(enlargementOf(small), enlargementOf(geometry));
  const bare = (one) => enlargementOf({ ...one, discs: [] });
  assert.equal(bare(small), bare(geometry));
});

test("names keep apart: each moves away from the drawing until its row is free", () => {
  const names = [0, 10, 20, 300].map((x) => ({ x, y: 0, step: -15, half: 30 }));
  const placed = apart(names);
  assert.deepEqual(placed.map((name) => name.y), [0, -15, -30, 0]);
  assert.deepEqual(placed.map((name) => name.x), [0, 10, 20, 300]);
});
