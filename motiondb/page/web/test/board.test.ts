import assert from "node:assert/strict";
import { test } from "node:test";
import {
  addElement,
  addPlayer,
  emptyDiagram,
  moveTo,
  nextStep,
  onCourt,
  placeBefore,
  removePlayer,
} from "../src/views/board/edits.ts";
import { curvePoints, triesOf } from "../src/views/board/curve.ts";
import { draftKey } from "../src/views/board/draft.ts";
import { sayFault } from "../src/views/board/reasons.ts";
import { inOrder, ruleSentence } from "../src/views/board/rules.ts";
import { smoothCurve, strokeOf, waved, zigzag } from "../src/views/board/strokes.ts";
import { useGround } from "../src/views/board/verbs.ts";
import type { BoardVerb, MeasuredRule } from "../src/api/types.ts";
import type { Spot } from "../src/views/board/spot.ts";

const verb = (name: string, look: string, more: Partial<BoardVerb> = {}): BoardVerb => ({
  name,
  look,
  holding: look,
  link: "",
  role: "",
  goes: look === "way",
  bar: false,
  declared: true,
  ...more,
});

useGround({
  grammar: "basketball",
  teams: ["attack", "defence"],
  places: [],
  object: "ball",
  ground: { width: 15, length: 14, left: -7.5, back: -1.575, own: false, marks: [] },
  verbs: [
    verb("move", "way", { holding: "wave" }),
    ...["walk", "run", "cut"].map((name) => verb(name, "way")),
    verb("pass", "give", { link: "to", role: "receiver" }),
    verb("shoot", "send", { link: "at", role: "target" }),
    verb("guard", "link", { link: "on", role: "opponent" }),
  ],
});
const RIM = { name: "rim", at: [0, 0] as Spot, given: true, height: 3.05, width: 0.45, tall: 0 };

const length = (points: readonly Spot[]): number =>
  points.slice(1).reduce((sum, [x, z], i) => sum + Math.hypot(x - points[i]![0], z - points[i]![1]), 0);

test("places stay on the court and are whole centimetres", () => {
  const diagram = emptyDiagram();
  assert.deepEqual(onCourt([9, -3], diagram), [7.5, -1.57]);
  assert.deepEqual(onCourt([1.23456, 20], diagram), [1.23, 12.43]);
});

test("a new defender guards the nearest attacker, and names are not used twice", () => {
  const [once, first] = addPlayer(emptyDiagram(), "defence", [-4, 5]);
  const [twice, second] = addPlayer(once, "attack", [3, 3]);
  assert.equal(first, "D1");
  assert.equal(once.players.at(-1)!.guards, "A2");
  assert.equal(second, "A3");
  assert.equal(twice.players.length, 4);
});

test("actions follow one another in steps; a pass goes to the nearest of the team", () => {
  let diagram = addElement(emptyDiagram(), "cut", "A1", { to: [1, 5] });
  diagram = addElement(diagram, "pass", "A1", {});
  assert.deepEqual(
    diagram.elements.map(({ step, other, to }) => [step, other, to]),
    [
      [1, "", [1, 5]],
      [2, "A2", null],
    ],
  );
  assert.equal(nextStep(diagram, "A2"), 3);
});

test("a player stands at the end of the last move of an earlier step", () => {
  let diagram = addElement(emptyDiagram(), "run", "A1", { to: [1, 5] });
  diagram = addElement(diagram, "run", "A1", { to: [2, 3] });
  assert.deepEqual(placeBefore(diagram, "A1", 1, 0), [0, 8]);
  assert.deepEqual(placeBefore(diagram, "A1", 2, 1), [1, 5]);
  assert.deepEqual(placeBefore(diagram, "A1", 9), [2, 3]);
});

test("removing a player removes what is done with the player", () => {
  let diagram = addElement(emptyDiagram(), "pass", "A1", { other: "A2" });
  [diagram] = addPlayer(diagram, "defence", [-4, 5]);
  const left = removePlayer(diagram, "A2");
  assert.deepEqual(left.elements, []);
  assert.equal(left.players.find((one) => one.name === "D1")!.guards, "");
});

test("moving a point of a way moves nothing else", () => {
  let diagram = addElement(emptyDiagram(), "run", "A1", { to: [1, 5] });
  diagram.elements[0]!.via = [
    [0, 7],
    [0, 6],
  ];
  diagram = moveTo(diagram, { what: "element", index: 0, point: 1 }, [2, 2]);
  assert.deepEqual(diagram.elements[0]!.via, [
    [0, 7],
    [2, 2],
  ]);
  assert.deepEqual(diagram.elements[0]!.to, [1, 5]);
});

test("a smooth curve passes through its points, and a straight one is straight", () => {
  const through: Spot[] = [
    [0, 0],
    [1, 2],
    [3, 2],
  ];
  const curve = smoothCurve(through);
  for (const point of through) {
    assert.ok(curve.some(([x, z]) => Math.hypot(x - point[0], z - point[1]) < 1e-9));
  }
  const straight = smoothCurve([
    [0, 0],
    [2, 0],
  ]);
  assert.ok(Math.abs(length(straight) - 2) < 1e-9);
  assert.equal(
    smoothCurve([
      [1, 1],
      [1, 1],
    ]).length,
    1,
  );
});

test("waves and teeth keep both ends and are longer than the line", () => {
  const line = smoothCurve([
    [0, 0],
    [0, 4],
  ]);
  for (const drawn of [waved(line), zigzag(line)]) {
    assert.deepEqual(drawn[0], [0, 0]);
    const [x, z] = drawn.at(-1)!;
    assert.ok(Math.hypot(x, z - 4) < 1e-9);
    assert.ok(length(drawn) > 4.2);
  }
});

test("a move of the holder is a dribble until the ball is passed", () => {
  let diagram = addElement(emptyDiagram(), "move", "A1", { to: [0, 5] });
  const straight = strokeOf(diagram, 0, null).points;
  assert.ok(length(strokeOf(diagram, 0, "A1").points) > length(straight) + 0.1);
  diagram = addElement(emptyDiagram(), "pass", "A1", { other: "A2" });
  diagram = addElement(diagram, "move", "A1", { to: [0, 5] });
  assert.ok(Math.abs(length(strokeOf(diagram, 1, "A1").points) - length(straight)) < 1e-9);
});

test("a shot leads to the ring, a pass to where its receiver will be", () => {
  let diagram = addElement({ ...emptyDiagram(), places: [RIM] }, "shoot", "A1", {});
  const [x, z] = strokeOf(diagram, 0, "A1").points.at(-1)!;
  assert.ok(Math.abs(Math.hypot(x, z) - 0.25) < 1e-9);
  diagram = addElement(emptyDiagram(), "run", "A2", { to: [0, 4] });
  diagram = addElement(diagram, "pass", "A1", { other: "A2" });
  diagram.elements[1]!.step = 2;
  const end = strokeOf(diagram, 1, "A1").points.at(-1)!;
  assert.ok(Math.hypot(end[0], end[1] - 4.36) < 1e-6);
});

test("a second try begins a line of its own", () => {
  const points: [number, number][] = [
    [0, 0],
    [50, 9],
    [0, 1],
    [0, 2],
    [60, 9],
  ];
  assert.deepEqual(triesOf(points), [points.slice(0, 2), points.slice(2)]);
  assert.deepEqual(triesOf([]), []);
});

test("the curve of errors falls from the top left to the bottom right", () => {
  const points = curvePoints(
    [
      [0.1, 100],
      [0.5, 10],
      [1, 1],
    ],
    200,
    50,
  );
  assert.deepEqual(
    points.map(([x, y]) => [Math.round(x), Math.round(y)]),
    [
      [20, 0],
      [100, 25],
      [200, 50],
    ],
  );
});

test("broken rules come first", () => {
  const rule = (kept: boolean, frame: number): MeasuredRule => ({
    player: "A1",
    action: "run",
    rule: "position",
    about: "",
    unit: "m",
    before: 0,
    after: 0,
    threshold: 0,
    frame,
    clip: 0,
    start: 0,
    end: 1,
    frames: 1,
    kept,
  });
  const ordered = inOrder([rule(true, 1), rule(false, 9), rule(true, 0)]);
  assert.deepEqual(
    ordered.map((one) => one.frame),
    [9, 0, 1],
  );
});

test("an action after another one gets its own step, and moves what comes later", () => {
  let play = addElement(emptyDiagram(), "run", "A1", { to: [1, 4] });
  play = addElement(play, "shoot", "A1", {});
  play = addElement(play, "walk", "A2", { to: [-3, 3] });
  const between = addElement(play, "pass", "A1", { after: 0, other: "A2" });
  assert.deepEqual(
    between.elements.map((one) => [one.kind, one.step]),
    [
      ["run", 1],
      ["shoot", 3],
      ["walk", 1],
      ["pass", 2],
    ],
  );
});

test("a rule is said in a sentence with the names of the board", () => {
  const play = addElement({ ...emptyDiagram(), places: [RIM] }, "run", "A1", { to: [1, 4] });
  const rule = { player: "A1", action: "run", unit: "m", after: 0.1, threshold: 0.3 } as MeasuredRule;
  const said = (kind: string, about: string) => ruleSentence({ ...rule, rule: kind, about }, play);
  assert.equal(said("position", "(1, 4)"), "at the end of its run in step 1");
  assert.equal(said("position", "(0, 8)"), "at the place where A1 starts");
  assert.equal(said("distance", "(0, 0), 0 to 2.5 m"), "at most 2.5 m from the rim");
  assert.equal(said("line", "A2 - (0, 0)"), "on the line from A2 to the rim");
  assert.equal(said("synchronisation", "A2 catch|hold"), "in time with A2's catch or hold");
  assert.equal(said("direction", "90 deg"), "faces 90° from the board's top");
});

test("a draft belongs to one database, one board, and one text of its file", () => {
  const edited = { database: "a.duckdb", name: "play", text: "one" };
  const others = [{ database: "b.duckdb" }, { name: "other" }, { text: "two" }];
  const keys = [{}, ...others].map((change) => draftKey({ ...edited, ...change }));
  assert.equal(new Set(keys).size, 4);
  assert.equal(draftKey({ ...edited }), keys[0]);
});

test("reasons are said to somebody who draws", () => {
  const said = (code: string, fields: Record<string, string>): string =>
    sayFault({
      line: 6,
      player: "",
      message: "as it is told",
      code,
      fields: { expected: "two players", found: "A1 twice", advice: "Do it.", ...fields },
    });
  const held = { player: "A1", thing: "ball", since: "shoot A1" };
  assert.equal(said("empty_handed", held), "A1 does not have the ball since 'shoot A1'. Do it.");
  assert.equal(said("empty_handed", { ...held, since: "" }), "A1 does not have the ball. Do it.");
  assert.equal(said("hands_full", held), "A1 has the ball. Do it.");
  assert.equal(
    said("too_near", { least: "0.5 m", other: "A1", apart: "0.1 m" }),
    "It is 0.1 m from A1; at least 0.5 m is needed. Do it.",
  );
  assert.equal(
    said("not_allowed", { player: "A1", grammar: "basketball", missing: "guard" }),
    "The grammar basketball has no guard for A1. Leave it out.",
  );
  assert.match(said("not_allowed", { player: "A1", grammar: "basketball" }), /in this order\. Leave one/);
  assert.match(said("nobody", {}), /^Nobody is on the board/);
  assert.equal(said("", {}), "Needed: two players. Here: A1 twice. Do it.");
  assert.equal(said("apart", { found: "A at 0 0" }), "Needed: two players. Here: A at 0 0. Do it.");
  const bare = { line: 0, player: "", message: "as it is told", code: "", fields: {} };
  assert.equal(sayFault(bare), "as it is told");
});
