import assert from "node:assert/strict";
import { test } from "node:test";
import type { BodyTrack } from "../src/api/container.ts";
import { addressOf, comparisonOf } from "../src/views/compare/address.ts";
import { cheapestPath } from "../src/views/compare/warp.ts";
import { alignTracks, bodyPart, differenceOf } from "../src/views/compare/aligned.ts";

const POINTS = ["pelvis", "l_hip", "r_hip", "l_hand_end"];
const pose = (x: number, hand: number) => [x, 1, 0, x + 0.1, 1, 0, x - 0.1, 1, 0, x, hand, 0.5];

/** A track of three frames at 1 frame a second that begins at a time. */
const track = (start: number, ...poses: number[][]): BodyTrack => ({
  kind: "body",
  name: "",
  ref: null,
  team: null,
  motion: {
    fps: 1,
    frames: poses.length,
    start,
    points: POINTS,
    parents: [-1, 0, 0, 0],
    radii: [0, 0, 0, 0],
    positions: new Float32Array(poses.flat()),
    contacts: null,
  },
});

test("the address of a comparison is read again", () => {
  const parts = [{ ref: "capture:a-1/b c|d", start: 0.25, end: 1 }];
  const one = { parts, at: "end", overlaid: true, time: 2 } as const;
  const query = addressOf(one).split("?")[1]!;
  assert.deepEqual(comparisonOf(new URLSearchParams(query)), one);
  assert.deepEqual(comparisonOf(new URLSearchParams("part=2-1 capture:a&part=x")).parts, []);
});

test("parts are aligned at a moment, on one clock and on one spot", () => {
  const first = track(4, pose(0, 1), pose(1, 1), pose(2, 1));
  const second = track(0, pose(7, 2), pose(8, 2), pose(9, 2));
  const parts = [
    { ref: "capture:a", start: 5, end: 6 },
    { ref: "capture:b", start: 0, end: 2 },
  ];
  const { tracks, spans } = alignTracks([first, second], parts, "start", true);
  // 5 s of the one and 0 s of the other are 1 s of the clock
  assert.deepEqual(spans, [
    [1, 2],
    [1, 3],
  ]);
  assert.deepEqual(
    tracks.map(({ motion }) => motion.start),
    [0, 1],
  );
  const root = (i: number, frame: number): number => tracks[i]!.motion.positions[frame * 12]!;
  assert.ok(Math.abs(root(0, 1)) < 1e-6 && Math.abs(root(1, 0)) < 1e-6);
});

test("the difference leaves out where motions go, and names the part that differs", () => {
  const first = track(0, pose(0, 1), pose(1, 1)).motion;
  const second = track(0, pose(5, 1.4), pose(5, 1.4)).motion;
  const { mean, worst } = differenceOf(first, second);
  for (const value of mean) assert.ok(Math.abs(value - 0.1) < 1e-6); // 0.4 m of one point of four
  assert.equal(bodyPart(POINTS[worst[0]!]!), "left hand");
});

test("the cheapest path waits where the other motion waits", () => {
  const [first, second] = [
    [0, 1, 2, 3],
    [0, 0, 0, 1, 2, 3],
  ];
  const costs = first.map((a) => second.map((b) => Math.abs(a - b)));
  assert.deepEqual(cheapestPath(costs), [1, 3, 4, 5]); // the first 0 meets three
});

test("with stretched time a slow motion shows the poses of a fast one at the same moments", () => {
  const raised = (...hands: number[]) => hands.map((hand) => pose(0, hand));
  const fast = track(0, ...raised(1, 1.5, 2));
  const slow = track(0, ...raised(1, 1.25, 1.5, 1.75, 2));
  const parts = [
    { ref: "capture:fast", start: 0, end: 2 },
    { ref: "capture:slow", start: 0, end: 4 },
  ];
  const [still, stretched] = (["start", "poses"] as const).map((at) => {
    const { tracks } = alignTracks([fast, slow], parts, at, true);
    return Math.max(...differenceOf(tracks[0]!.motion, tracks[1]!.motion).mean);
  });
  assert.ok(still! > 0.1 && stretched! < 0.02, `${still} ${stretched}`);
});
