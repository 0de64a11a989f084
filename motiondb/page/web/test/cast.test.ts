import assert from "node:assert/strict";
import test from "node:test";
import type { BodyTrack } from "../src/api/container.ts";
import { castColours } from "../src/player/cast_colours.ts";

const body = (name: string, team: string | null): BodyTrack => ({
  kind: "body",
  name,
  ref: null,
  team,
  motion: {
    fps: 30,
    frames: 0,
    start: 0,
    points: [],
    parents: [],
    radii: [],
    positions: new Float32Array(0),
    contacts: null,
  },
});

test("one figure keeps its own colour", () => {
  assert.equal(castColours([body("A1", "attack")]), undefined);
});

test("a team has one colour, and the other team another", () => {
  const [a, b, c] = castColours([body("A1", "attack"), body("D1", "defence"), body("A2", "attack")])!;
  assert.deepEqual(a, c);
  assert.notDeepEqual(a, b);
});

test("characters without a team differ", () => {
  const [a, b] = castColours([body("x", null), body("y", null)])!;
  assert.notDeepEqual(a, b);
});
