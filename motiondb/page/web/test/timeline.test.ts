import assert from "node:assert/strict";
import test from "node:test";
import { rgbOf, tintOf } from "../src/parts/tint.ts";
import { bytesText, plural, seconds, signed } from "../src/parts/text.ts";
import { lacksLane, packRows, stretchLane, symbolLane, wordLane } from "../src/timeline/lanes.ts";
import { niceTicks } from "../src/timeline/ticks.ts";
import { pixelsOf } from "../src/dom/wheel.ts";
import type { PlacedSymbol } from "../src/api/types.ts";
import { MOST, strokeFrom, strokeTo } from "../src/views/search/path.ts";
import { tapped, textOf, timesOf } from "../src/views/search/rhythm.ts";
import { axisEnds, clustersOf, foundSymbols } from "../src/views/symbols/clusters.ts";
import { placeMarks } from "../src/views/symbols/labels.ts";
import { ellipseOf, fitAxes, NO_ZOOM, zoomAt, zoomed } from "../src/views/symbols/projection.ts";

test("blocks that overlap get rows of their own, as few as possible", () => {
  const rows = packRows([
    { start: 0, end: 10 },
    { start: 0, end: 3 },
    { start: 3, end: 5 },
    { start: 4, end: 6 },
  ]);
  assert.deepEqual(rows, [0, 1, 1, 2]);
});

test("no row ever holds two blocks that overlap", () => {
  for (let seed = 1; seed < 60; seed += 1) {
    const number = (i: number) => ((seed * 7919 + i * 104729) % 97) / 10;
    const blocks = Array.from({ length: 12 }, (_, i) => ({
      start: number(i),
      end: number(i) + 0.1 + number(i + 50) / 4,
    }));
    const rows = packRows(blocks);
    blocks.forEach((a, i) =>
      blocks.forEach((b, j) => {
        if (i < j && rows[i] === rows[j]) assert.ok(a.end <= b.start + 1e-6 || b.end <= a.start + 1e-6);
      }),
    );
  }
});

test("rulers have round times and not too many", () => {
  assert.deepEqual(niceTicks(5.7, 6), [0, 1, 2, 3, 4, 5]);
  for (const duration of [0.3, 1, 7, 59, 61, 3600]) assert.ok(niceTicks(duration, 8).length <= 9);
});

test("a part of a ruler has the marks of the whole ruler there", () => {
  for (const [duration, most] of [
    [5.7, 30],
    [600, 3600],
    [3600, 21600],
  ] as const) {
    const [from, to] = [duration * 0.4, duration * 0.4 + 6];
    const whole = niceTicks(duration, most);
    const part = niceTicks(duration, most, from, to);
    assert.deepEqual(
      part,
      whole.filter((time) => time >= from && time < to),
    );
    assert.ok(part.length <= 40);
    assert.deepEqual(niceTicks(duration, most, -duration, 2 * duration), whole);
  }
});

test("a wheel counts in pixels, lines or pages", () => {
  assert.deepEqual(
    [0, 1, 2].map((deltaMode) => pixelsOf({ deltaY: -3, deltaMode })),
    [-3, -48, -1200],
  );
});

test("a drawn line begins with a move, and is thinned where it is long", () => {
  let stroke = strokeFrom([0, 0]);
  assert.equal(strokeTo(stroke, [0.1, 0.1]), stroke);
  for (let n = 1; n <= 2000; n += 1) {
    stroke = strokeTo(stroke, [n * 0.2, 0]);
    assert.ok(stroke.points.length <= MOST);
    assert.ok(n * 0.2 - stroke.points.at(-1)![0] < stroke.apart);
  }
  assert.deepEqual(stroke.points[0], [0, 0]);
  assert.ok(stroke.points.length > MOST / 3);
});

test("findings stand with their sentence, and needs with what they are", () => {
  const found = { measure: 0.5, unit: "m", threshold: 0.09, part: "seat", place: null, boxes: [] };
  const said = "sits on something 50 cm high, 1.0 to 2.0 s";
  const seat = { ...found, kind: "sits", family: "needs", start: 1, end: 2, sentence: said };
  const jump = {
    ...found,
    kind: "jumps",
    family: "fault",
    start: 3,
    end: 4,
    sentence: "it jumps, 3.0 to 4.0 s",
  };
  const [one, two] = lacksLane([seat, jump]).blocks;
  assert.deepEqual([one!.label, one!.title, one!.faint], ["sits on something 50 cm high", said, false]);
  assert.deepEqual([two!.label, two!.faint], ["jumps", true]);
});

test("lanes say what they do not know", () => {
  const [block] = symbolLane([{ symbol: 4, start: 0, end: 1, log_likelihood: null, known: false }]).blocks;
  assert.equal(block!.faint, true);
  assert.match(block!.title, /unlike everything learned/);
  assert.equal(
    wordLane([{ start: 0, end: 1, words: [{ word: "walk", probability: 0.2 }], symbols: [] }]).blocks[0]!
      .label,
    "–",
  );
  const unchecked = wordLane([
    { start: 0, end: 1, words: ["walk", "run"].map((word) => ({ word, probability: null })), symbols: [] },
  ]).blocks[0]!;
  assert.deepEqual([unchecked.label, unchecked.faint], ["walk", true]);
  assert.match(unchecked.title, /^walk, run, /);
  const drawn = stretchLane([
    { start: 0, end: 1, capture: "", source_start: 0, licence: "unknown", edits: [] },
  ]).blocks[0]!;
  assert.equal(drawn.label, "drawn from the model");
});

test("a stretch names its licence", () => {
  const title = stretchLane([{ start: 0, end: 1, capture: "a", source_start: 2, licence: "CC0", edits: [] }])
    .blocks[0]!.title;
  assert.match(title, /a from 2\.00 s, licence CC0/);
});

test("tints of neighbours differ, and colours stay inside sRGB", () => {
  assert.notEqual(tintOf(1).soft, tintOf(2).soft);
  assert.equal(tintOf(7).soft, tintOf(7).soft);
  assert.deepEqual(
    rgbOf(1, 0, 0).map((x) => Math.round(x * 255)),
    [255, 255, 255],
  );
  for (let i = 0; i < 100; i += 1)
    for (const part of rgbOf(0.86, 0.2, i * 3.6)) assert.ok(part >= 0 && part <= 1);
});

test("numbers read as people write them", () => {
  assert.deepEqual([seconds(2.5), seconds(27.67), seconds(685.1)], ["2.50 s", "27.7 s", "11 min 25 s"]);
  assert.deepEqual([signed(-1.617), signed(2)], ["−1.62", "+2.00"]);
  assert.deepEqual(
    [plural(1, "capture"), plural(10_000, "capture"), plural(2, "copy", "copies")],
    ["1 capture", "10,000 captures", "2 copies"],
  );
  assert.deepEqual([bytesText(999), bytesText(1500), bytesText(104857600)], ["999 B", "1.5 kB", "105 MB"]);
});

test("the map fits its picture with one scale for both axes", () => {
  const size = { width: 100, height: 100, margin: 10 };
  const axes = fitAxes(
    [
      [-1, 0],
      [3, 1],
    ],
    0,
    1,
    size,
  );
  assert.equal(axes.scale, 20);
  assert.deepEqual(axes.place([3, 0.5]), [90, 50]);
  const line = fitAxes([[0], [2]], 0, 1, size);
  assert.deepEqual(line.place([2]), [90, 50]);
});

test("the ellipse of a round Gaussian is a circle, of a tilted one is turned", () => {
  const axes = fitAxes(
    [
      [-1, -1],
      [1, 1],
    ],
    0,
    1,
    { width: 100, height: 100, margin: 10 },
  );
  const round = ellipseOf(
    [0, 0],
    [
      [1, 0],
      [0, 1],
    ],
    axes,
  );
  assert.equal(round.rx, round.ry);
  const tilted = ellipseOf(
    [0, 0],
    [
      [2, 1],
      [1, 2],
    ],
    axes,
  );
  assert.ok(Math.abs(Math.abs(tilted.angle) - 45) < 1e-9);
  assert.ok(Math.abs(tilted.rx / tilted.ry - Math.sqrt(3)) < 1e-9);
});

test("a zoom keeps the place under the pointer, and stops at the whole map", () => {
  const size = { width: 100, height: 100, margin: 10 };
  const axes = fitAxes(
    [
      [-1, 0],
      [3, 1],
    ],
    0,
    1,
    size,
  );
  const [x, y] = axes.place([3, 0.5]);
  const zoom = zoomAt(NO_ZOOM, 3, x, y, size);
  assert.deepEqual(
    zoomed(axes, zoom, size)
      .place([3, 0.5])
      .map((one) => Math.round(one)),
    [x, y],
  );
  assert.equal(zoomed(axes, zoom, size).scale, 60);
  assert.equal(zoomAt(zoom, 0.01, 0, 0, size).factor, 1);
});

test("a figure or a word that would cover another one is not drawn", () => {
  const { figures, words } = placeMarks([
    { x: 0, y: 0, radius: 10, word: "walk" },
    { x: 5, y: 2, radius: 10, word: "run" },
    { x: 200, y: 0, radius: 10, word: "kick" },
    { x: 200, y: 50, radius: 10, word: "" },
  ]);
  assert.deepEqual(figures, [true, false, true, true]);
  assert.deepEqual(words, [true, false, false, false]); // "kick" would cover the figure below it
});

test("a cluster is named by the words of most of its segments, and symbols are found by words", () => {
  const one = (symbol: number, cluster: number, count: number, word: string, probability: number) =>
    ({ symbol, cluster, count, words: [{ word, probability }] }) as unknown as PlacedSymbol;
  const all = [one(0, 4, 10, "walk", 0.9), one(1, 4, 30, "run", 0.8), one(2, 7, 90, "jump", 0.1)];
  assert.deepEqual(
    clustersOf(all).map(({ cluster, words }) => [cluster, words]),
    [
      [7, []],
      [4, ["run", "walk"]],
    ],
  );
  assert.deepEqual([...foundSymbols(all, "WA")!], [0]);
  assert.deepEqual([...foundSymbols(all, "2")!], [2]);
  assert.equal(foundSymbols(all, " "), null);
});

test("the ends of an axis are named by the outermost movements with a probable word", () => {
  const one = (at: number, word: string, probability: number): PlacedSymbol =>
    ({ at: [at], words: [{ word, probability }] }) as unknown as PlacedSymbol;
  const all = [one(-3, "odd", 0.1), one(-2, "sit", 0.9), one(-1, "sit", 0.8), one(0, "bow", 0.5)];
  assert.deepEqual(axisEnds(all, 0), { low: ["sit", "bow"], high: [] });
  const more = [...all, one(3, "run", 0.7), one(2, "walk", 0.9)];
  assert.deepEqual(axisEnds(more, 0), { low: ["sit", "bow"], high: ["run", "walk"] });
});

test("a bounce is no tap, and a tap after a pause begins a rhythm anew", () => {
  const taps = [10, 10.5, 10.53, 11.25].reduce(tapped, [] as readonly number[]);
  assert.equal(textOf(taps), "0 0.5 1.25");
  assert.deepEqual(timesOf(textOf(taps)), [0, 0.5, 1.25]);
  assert.deepEqual(tapped(taps, 13), [13]);
  for (const text of ["0 x", "1 0", "0 0"]) assert.deepEqual(timesOf(text), []);
});
