import assert from "node:assert/strict";
import test from "node:test";
import { certaintyOf, replacedWords, sayPart } from "../src/views/search/certainty.ts";
import { chipsOf, sayShare, type Chip, type QuestionTree } from "../src/views/search/question.ts";
import { reasonRows } from "../src/views/search/reasons.ts";

const action = (...words: string[]): QuestionTree => ({ kind: "action", words, sides: [], manner: [] });

function text(chips: readonly Chip[]): string {
  return chips
    .map((chip) =>
      chip.kind === "group" ? `[${chip.excluded ? "!" : ""}${chip.text}: ${text(chip.chips)}]` : chip.text,
    )
    .join(" ");
}

test("actions in order are chips with words between them", () => {
  assert.equal(
    text(chipsOf({ kind: "in_order", parts: [action("walk"), action("turn", "left"), action("sit")] })),
    "walk then turn left then sit",
  );
});

test("what is inside another part is framed, exclusions are marked", () => {
  const tree: QuestionTree = {
    kind: "in_order",
    parts: [
      { kind: "any_of", parts: [action("walk"), action("run")] },
      { kind: "without", part: action("sit"), excluded: [action("wave")] },
    ],
  };
  assert.equal(text(chipsOf(tree)), "[: walk or run] then sit [!not: wave]");
});

test("counts and lengths say their limits", () => {
  assert.equal(
    text(chipsOf({ kind: "repeated", part: action("jump"), at_least: 3, at_most: null })),
    "[at least 3 times: jump]",
  );
  assert.equal(
    text(chipsOf({ kind: "repeated", part: action("jump"), at_least: 2, at_most: 2 })),
    "[2 times: jump]",
  );
  assert.equal(
    text(chipsOf({ kind: "lasting", part: action("walk"), least_seconds: 2, most_seconds: 5 })),
    "[for 2 to 5 s: walk]",
  );
});

test("side and manner stand on the chip", () => {
  const [chip] = chipsOf({
    kind: "action",
    words: ["wave"],
    sides: [{ side: "left", limb: "hand" }],
    manner: ["slowly"],
  });
  assert.equal(chip?.kind === "action" && chip.detail, "left hand, slowly");
});

test("the reasons add up to the log-odds", () => {
  const word = (name: string, contribution: number) => ({
    word: name,
    log_odds: 0,
    log_probability: 0,
    contribution,
    prior: -1.6,
    written: 2,
    likeness: 0,
    symbols: [{ symbol: 1, from: 0, to: 2.9, share: 3.5 }],
    strongest: [{ symbol: 1, from: 0, to: 2.9, share: 3.5 }],
    others: 0,
  });
  const rows = reasonRows({
    log_odds: 4,
    together: 0.5,
    suggests: [],
    words: [word("turn", 3), word("left", 1)],
    excluded: [{ amount: -0.5, log_odds: -3, words: [word("run", -3)] }],
  });
  assert.equal(
    rows.reduce((sum, row) => sum + row.amount, 0),
    4,
  );
  assert.deepEqual(
    rows.map((row) => row.label),
    ["turn", "left", "together", "not run"],
  );
  assert.match(rows[0]!.detail, /usual −1\.600, written \+2\.000, symbol 1 \+3\.500 \(0\.0–2\.9 s\)/);
});

test("every number of --explain is shown, and they add up", () => {
  const word = {
    word: "walk",
    log_odds: 0,
    log_probability: 0,
    contribution: 2.45,
    prior: -1.2,
    written: 0,
    likeness: 0.7,
    symbols: [],
    strongest: [
      { symbol: 2, from: 0, to: 1.5, share: 3 },
      { symbol: 1, from: 1.5, to: 2, share: -0.4 },
    ],
    others: 0.35,
  };
  const [row] = reasonRows({ log_odds: 2.45, together: 0, words: [word], excluded: [], suggests: [] });
  assert.equal(
    row!.detail,
    "usual −1.200, likeness +0.700, symbol 2 +3.000 (0.0–1.5 s)," +
      " symbol 1 −0.400 (1.5–2.0 s), others +0.350",
  );
  const shown = [...row!.detail.matchAll(/([+−])(\d+\.\d{3})/g)].map(
    ([, sign, number]) => (sign === "−" ? -1 : 1) * Number(number),
  );
  assert.ok(Math.abs(shown.reduce((sum, one) => sum + one, 0) - row!.amount) < 1e-9);
});

test("an answer is drawn by what is known about it", () => {
  const part = (probability: number | null) => ({
    words: "walk",
    start: 0,
    end: 1,
    probability,
    interval_probability: null,
    place: "known",
  });
  const graded = (probability: number | null, ...parts: (number | null)[]): string =>
    certaintyOf({ probability, parts: parts.map(part), contradicted: [] }).grade;
  assert.equal(graded(0.5, 0.5), "likely");
  assert.equal(graded(0.49, 0.49), "unlikely");
  assert.equal(graded(0.049, 0.049), "folded");
  assert.equal(graded(null, null), "unmeasured");
  assert.equal(graded(null, 0.9, 0.02), "folded"); // the whole is at most its least part
  assert.equal(graded(null, 0.9, null, 0.02), "folded"); // also where another part is not measured
  assert.equal(graded(null, 0.9, 0.8), "unmeasured"); // likely parts do not make it likely
  const otherWay = { probability: null, parts: [part(null)], contradicted: ["backward"] };
  assert.equal(certaintyOf(otherWay).grade, "unlikely");
});

test("a replaced word carries its real name", () => {
  const replaced = replacedWords({ taken: { moonwalk: [{ word: "walk", probability: 0.8 }] } });
  assert.deepEqual(sayPart({ words: "moonwalk left" }, replaced), {
    words: "walk left",
    instead: "moonwalk",
  });
});

test("the number beside a word that stands for another is explained", () => {
  assert.equal(
    sayShare("'moonwalk' is not in the captions; taken as walk (0.8), which may mean more"),
    "'moonwalk' is not in the captions; taken as walk, which it means with probability 0.8 and which may mean more",
  );
});
