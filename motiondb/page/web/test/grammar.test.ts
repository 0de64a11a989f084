/** Grammars: where terminals, paths and nodes of a tree lie, and the addresses of the view. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { addressOf, routeOf } from "../src/views/grammar/address.ts";
import {
  cutPath,
  depthsOf,
  layStrip,
  lineTo,
  placeOf,
  placeOfTime,
  positionAt,
  regionOf,
  spaced,
  timesOf,
  waysTo,
} from "../src/views/grammar/layout.ts";
import type { TreeNode } from "../src/api/types.ts";

const STRIP = [
  { start: 0, end: 2 },
  { start: 2, end: 2.1 },
  { start: 2.1, end: 4 },
];

/** S(a A(b B() c)): B derives nothing. */
const TREE: TreeNode[] = [
  { symbol: "S", parent: -1, start: 0, end: 3, is_terminal: false },
  { symbol: "a", parent: 0, start: 0, end: 1, is_terminal: true },
  { symbol: "A", parent: 0, start: 1, end: 3, is_terminal: false },
  { symbol: "b", parent: 2, start: 1, end: 2, is_terminal: true },
  { symbol: "B", parent: 2, start: 2, end: 2, is_terminal: false },
  { symbol: "c", parent: 2, start: 2, end: 3, is_terminal: true },
];

/** A tree that goes down at every terminal: X -> x X | x. */
function deep(levels: number): TreeNode[] {
  return Array.from({ length: levels }, (_, i): TreeNode[] => [
    { symbol: "X", parent: i === 0 ? -1 : 2 * i - 2, start: i, end: levels, is_terminal: false },
    { symbol: "x", parent: 2 * i, start: i, end: i + 1, is_terminal: true },
  ]).flat();
}

const near = (found: number, expected: number): void =>
  assert.ok(Math.abs(found - expected) < 1e-9, `${found}`);

test("terminals are as wide as they last, but never too narrow for a letter", () => {
  const { lefts, widths } = layStrip(STRIP);
  near(
    widths.reduce((sum, one) => sum + one, 0),
    1,
  );
  assert.equal(lefts[0], 0);
  near(widths[0]! / widths[2]!, 2 / 1.9);
  near(widths[1]! / widths[0]!, (0.45 * 4) / 3 / 2); // widened to 0.45 of the mean duration
});

test("a time lies inside the terminal that plays it", () => {
  const layout = layStrip(STRIP);
  assert.equal(positionAt(STRIP, 2.05), 1);
  near(placeOfTime(layout, STRIP, 0), 0);
  near(placeOfTime(layout, STRIP, 1), layout.widths[0]! / 2);
  near(placeOfTime(layout, STRIP, 2.05), layout.lefts[1]! + layout.widths[1]! / 2);
  near(placeOfTime(layout, STRIP, 9), 1);
});

test("a region covers its positions; where it has none, it lies at the seam", () => {
  const layout = layStrip(STRIP);
  assert.deepEqual(placeOf(layout, 0, 3), [0, 1]);
  assert.deepEqual(placeOf(layout, 2, 2), [layout.lefts[2], 0]);
  assert.deepEqual(timesOf(STRIP, 1, 3), [2, 4]);
  assert.deepEqual(timesOf(STRIP, 1, 1), [2, 2]);
  assert.deepEqual(timesOf(STRIP, 3, 3), [4, 4]);
});

test("a path is cut at times, between its points too", () => {
  const path = {
    fps: 10,
    points: [
      [0, 0],
      [1, 0],
      [1, 2],
    ] as [number, number][],
  };
  assert.deepEqual(cutPath(path, 0.05, 0.15), [
    [0.5, 0],
    [1, 0],
    [1, 1],
  ]);
  assert.deepEqual(cutPath(path, 0, 0.1), [
    [0, 0],
    [1, 0],
  ]);
  assert.deepEqual(cutPath(path, 5, 5), [
    [1, 2],
    [1, 2],
  ]);
});

test("spots lie at equal distances along a line, over its corners", () => {
  const spots = spaced(
    [
      [0, 0],
      [1, 0],
      [1, 1],
    ],
    0.75,
  );
  assert.deepEqual(spots, [
    [0, 0],
    [0.75, 0],
    [1, 0.5],
  ]);
  assert.deepEqual(
    spaced(
      [
        [2, 2],
        [2, 2],
      ],
      0.1,
    ),
    [[2, 2]],
  );
});

test("the tree is walked from a terminal to the root and back", () => {
  assert.deepEqual(depthsOf(TREE), [0, 1, 1, 2, 2, 2]);
  assert.deepEqual(lineTo(TREE, 2), [0, 2]);
  assert.equal(regionOf(TREE, 2, 0), 2);
  assert.equal(regionOf(TREE, 2, 1), 0);
  assert.equal(regionOf(TREE, 2, 2), null);
});

test("a node is reached from the chosen terminal, or else from its first one", () => {
  assert.deepEqual(waysTo(TREE, 0, 2), { at: 2, wider: 1 });
  assert.deepEqual(waysTo(TREE, 2, 0), { at: 1, wider: 0 });
  assert.equal(waysTo(TREE, 4, 2), null); // it generates nothing: no terminal can be picked
  assert.equal(waysTo(TREE, 3, 1), null);
});

test("trees may be thousands of levels deep", () => {
  const tree = deep(5000);
  assert.equal(depthsOf(tree).at(-1), 5000);
  assert.equal(lineTo(tree, 4999).length, 5000);
  assert.deepEqual(waysTo(tree, 0, 4999), { at: 4999, wider: 4999 });
  assert.equal(regionOf(tree, 4999, 4999), 0);
});

test("an address says what is shown, and is read back", () => {
  const text = "name=my+play&seed=3&length=8&like=a+...+b&sequence=q1&at=2&wider=1&draw=4&tree=1";
  const route = routeOf(new URLSearchParams(text));
  assert.deepEqual(route.selection, { at: 2, wider: 1, draw: 4 });
  assert.deepEqual(route.wish, { seed: 3, length: 8, like: "a ... b" });
  assert.equal(addressOf(route), `#/grammar?${text}`);
  const bare = routeOf(new URLSearchParams("name=play&at=-1&length=x"));
  assert.equal(bare.selection, null);
  assert.equal(addressOf(bare), "#/grammar?name=play");
  const first = routeOf(new URLSearchParams("name=play&sequence=q1&at=0"));
  assert.equal(addressOf(first), "#/grammar?name=play&sequence=q1&at=0");
});
