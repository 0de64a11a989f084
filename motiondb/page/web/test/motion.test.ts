import assert from "node:assert/strict";
import test from "node:test";
import { bonesOf, CAPSULE, sharesOf, writeCapsules } from "../src/player/body.ts";
import { eyeOf, orbitAround, pan, turn, zoom } from "../src/player/camera.ts";
import { makeFigures } from "../src/player/figures.ts";
import { pictureOf } from "../src/player/flat.ts";
import { CANONICAL } from "./canonical.ts";
import { boundsOf, frameAt, poseAt, unite, type Motion } from "../src/player/motion.ts";

const motion: Motion = {
  fps: 10,
  frames: 3,
  start: 2,
  points: ["a", "b"],
  parents: [-1, 0],
  radii: [0, 0.2],
  positions: new Float32Array([0, 0, 0, 1, 1, 1, 10, 0, 0, 11, 1, 1, 20, 0, -4, 21, 9, 1]),
  contacts: new Uint8Array([0, 1, 3]),
};

test("poses between two frames are interpolated, from the start of the track", () => {
  const pose = new Float32Array(6);
  poseAt(motion, 2.05, pose);
  assert.ok(Math.abs(pose[0]! - 5) < 1e-4);
  poseAt(motion, 0, pose);
  assert.equal(pose[0], 0);
  poseAt(motion, 99, pose);
  assert.equal(pose[0], 20);
});

test("a time shows the frame that began last", () => {
  assert.deepEqual(
    [2, 2.09, 2.1, 2.29, 9, 0].map((time) => frameAt(motion, time)),
    [0, 0, 1, 2, 2, 0],
  );
});

test("bounds hold all points of the interval, and no others", () => {
  assert.deepEqual(boundsOf(motion), { min: [0, 0, -4], max: [21, 9, 1] });
  assert.deepEqual(boundsOf(motion, 2, 2.05), { min: [0, 0, 0], max: [11, 1, 1] });
  assert.deepEqual(unite([]), { min: [-0.5, 0, -0.5], max: [0.5, 1.75, 0.5] });
});

test("the canonical body has 24 capsules, the same on both sides", () => {
  const bones = bonesOf(CANONICAL, [], []);
  assert.equal(bones.length, 24);
  const sides = (side: string) =>
    bones
      .filter((bone) => CANONICAL[bone.to]!.startsWith(side) && !CANONICAL[bone.from]!.endsWith("hip"))
      .map((bone) => bone.fromRadius);
  assert.deepEqual(sides("l_"), sides("r_"));
  assert.ok(sharesOf(CANONICAL, bones).every((share) => share > 0 && share <= 1));
});

test("another skeleton gets the radii that come with it", () => {
  assert.deepEqual(bonesOf(motion.points, motion.parents, motion.radii), [
    { from: 0, to: 1, fromRadius: 0.2, toRadius: 0.2 },
  ]);
});

test("capsules are written after those that are there", () => {
  const into = new Float32Array(2 * CAPSULE);
  writeCapsules([{ from: 0, to: 1, fromRadius: 0.1, toRadius: 0.2 }], [0.5], [0, 0, 0, 2, 4, 6], into, 1);
  assert.deepEqual(
    [...into.slice(CAPSULE)].map((x) => Number(x.toFixed(3))),
    [0, 0, 0, 0.1, 1, 2, 3, 0.2],
  );
});

test("figures are lit only inside their interval, and never outgrow their room", () => {
  const grey = [0.5, 0.5, 0.5] as const;
  const red = [1, 0, 0] as const;
  const figures = makeFigures(
    [{ motion, colour: grey, litColour: red, lit: [2.1, 2.2], shift: [100, 0] }],
    [],
    grey,
    grey,
  );
  assert.deepEqual(
    [...figures.draw(2.0, { trails: false, contacts: false }).bodies.tints.slice(0, 3)],
    [...grey],
  );
  const lit = figures.draw(2.15, { trails: true, contacts: true });
  assert.deepEqual([...lit.bodies.tints.slice(0, 3)], [...red]);
  for (const drawn of [lit.bodies, lit.marks, lit.prints]) assert.ok(drawn.count * 3 <= drawn.tints.length);
  assert.ok(lit.marks.count > 0);
  assert.ok(lit.bodies.capsules[0]! > 100);
});

test("a foot on the ground has a flat print from heel to toe", () => {
  const feet: Motion = {
    ...motion,
    points: ["l_ankle", "l_toe_end", "r_ankle", "r_toe_end"],
    parents: [-1, 0, -1, 2],
    radii: [0, 0, 0, 0],
    frames: 1,
    positions: new Float32Array([0, 0.1, 0, 0, 0, 0.2, 1, 0.4, 0, 1, 0.3, 0.2]),
    contacts: new Uint8Array([1]),
  };
  const grey = [0.5, 0.5, 0.5] as const;
  const figure = { motion: feet, colour: grey, litColour: grey, lit: null, shift: [0, 0] as const };
  const { prints } = makeFigures([figure], [], grey, grey).draw(2, { trails: false, contacts: true });
  assert.equal(prints.count, 1); // the right foot is in the air
  const shown = [...prints.capsules.slice(0, 8)].map((value) => Number(value.toFixed(2)));
  assert.deepEqual(shown, [0, 0, 0, 0.07, 0, 0, 0.2, 0.07]);
});

test("the camera turns, zooms and moves around its target", () => {
  const orbit = orbitAround([-1, 0, -1], [1, 2, 1]);
  assert.deepEqual(orbit.target, [0, 1.05, 0]); // there is more above the joints than below
  const near = (a: number, b: number) => assert.ok(Math.abs(a - b) < 1e-9);
  const front = { ...orbit, azimuth: 0, elevation: 0, distance: 5 };
  const eye = eyeOf(front);
  near(eye[0], 0);
  near(eye[2], 5);
  near(eyeOf(turn(front, Math.PI / 2, 0))[0], 5);
  near(zoom(front, 2).distance, 10);
  assert.ok(turn(front, 0, 99).elevation < Math.PI / 2);
  assert.ok(pan(front, 0.1, 0).target[0] > 0);
});

test("the flat picture puts the target in its middle, and what is nearer is larger", () => {
  const orbit = { target: [1, 1, 1] as const, azimuth: 0.7, elevation: 0.3, distance: 4 };
  const picture = pictureOf(orbit, 200, 100);
  const [x, y, depth] = picture([1, 1, 1]);
  assert.ok(Math.abs(x - 100) < 1e-6 && Math.abs(y - 50) < 1e-6 && Math.abs(depth - 4) < 1e-6);
  assert.ok(picture([1, 2, 1])[1] < 50);
});
