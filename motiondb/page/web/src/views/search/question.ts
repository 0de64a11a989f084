/** The question as it was understood, as chips: actions, their order, and unused parts. */

import type { Decoding, UnderstoodQuestion, WordProbability } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { h, type Child } from "../../dom/element.ts";
import { signed } from "../../parts/text.ts";
import { routeTo } from "../../shell/router.ts";

export type QuestionTree = UnderstoodQuestion["tree"];

/** A chip of the question: an action, a joint between actions, or a frame around some. */
export type Chip =
  | { kind: "action"; text: string; detail: string }
  | { kind: "joint"; text: string }
  | { kind: "group"; text: string; chips: Chip[]; excluded: boolean };

/** The sentences that nothing matches, which stand as the verdict over the answers. */
const NOTHING = /nothing in this database matches$/;

/** A known word that stands for another, and how likely it means it. */
const SHARE = / (\S+) \((0\.\d+|1(?:\.0)?)\)(?:$|(, which))/;

/** The sentence about a replaced word, with its number explained. */
export function sayShare(sentence: string): string {
  return sentence.replace(
    SHARE,
    (_, word: string, share: string, more?: string) =>
      ` ${word}, which it means with probability ${share}${more ? " and which" : ""}`,
  );
}

const JOINTS = { in_order: "then", at_once: "while", both: "and", any_of: "or" } as const;

function limits(least: number | null, most: number | null, unit: string): string {
  if (least !== null && least === most) return `${least}${unit}`;
  if (least !== null && most !== null) return `${least} to ${most}${unit}`;
  if (least !== null) return `at least ${least}${unit}`;
  return most !== null ? `at most ${most}${unit}` : "";
}

/** The chips of a tree, from left to right. Parts of a part are framed. */
export function chipsOf(tree: QuestionTree, inside = false): Chip[] {
  switch (tree.kind) {
    case "action": {
      const sides = tree.sides.map(({ side, limb }) => `${side} ${limb}`.trim());
      const manner = tree.manner;
      const detail = [...sides, ...manner].filter((one) => one !== "").join(", ");
      return [{ kind: "action", text: tree.words.join(" "), detail }];
    }
    case "anything":
      return [{ kind: "action", text: "anything", detail: "" }];
    case "without":
      return [
        ...chipsOf(tree.part, true),
        ...tree.excluded.map((one): Chip => ({
          kind: "group",
          text: "not",
          chips: chipsOf(one),
          excluded: true,
        })),
      ];
    case "repeated":
      return [
        {
          kind: "group",
          text: limits(tree.at_least, tree.at_most, " times"),
          chips: chipsOf(tree.part),
          excluded: false,
        },
      ];
    case "lasting":
      return [
        {
          kind: "group",
          text: `for ${limits(tree.least_seconds, tree.most_seconds, " s")}`,
          chips: chipsOf(tree.part),
          excluded: false,
        },
      ];
    case "measured":
      return [{ kind: "group", text: tree.said, chips: chipsOf(tree.part), excluded: false }];
    default: {
      const chips = tree.parts.flatMap((part, i): Chip[] => [
        ...(i > 0 ? [{ kind: "joint" as const, text: JOINTS[tree.kind] }] : []),
        ...chipsOf(part, true),
      ]);
      return inside ? [{ kind: "group", text: "", chips, excluded: false }] : chips;
    }
  }
}

function chipElement(chip: Chip): HTMLElement {
  if (chip.kind === "joint") return h("span.chip-joint", chip.text);
  if (chip.kind === "action") {
    return h("span.chip", chip.text, chip.detail ? h("span.chip-detail", chip.detail) : null);
  }
  return h(
    "span",
    { class: chip.excluded ? "chip-group excluded" : "chip-group" },
    chip.text ? h("span.chip-joint", chip.text) : null,
    chip.chips.map(chipElement),
  );
}

/** The symbols that a question was decoded to, each a link to its place on the map. */
export function decodingElement(decoding: Decoding): HTMLElement {
  return h(
    "p.small",
    "Taken as the movements ",
    decoding.symbols.map((symbol) => [h("a", { href: routeTo("symbols", { symbol }) }, symbol), " "]),
    h("span.muted", `(log-probability ${signed(decoding.log_probability)}, ${decoding.certificate})`),
  );
}

/** How the server understood a question: chips, unknown words, and words replaced by known ones. */
export function questionElement(
  question: UnderstoodQuestion,
  sentences: readonly string[],
  unknown: Record<string, string[]>,
  suggested: Record<string, WordProbability[]>,
  replace: (word: string, by: string) => void,
): HTMLElement {
  const link = (word: string, known: readonly string[]): Child =>
    known.map((one, i) => [i > 0 ? " or " : "", button("link", one, () => replace(word, one))]);
  // One remark for a word: the sentence that names it, else one of its own, with words to ask instead.
  const near = new Map<string, readonly string[]>(Object.entries(unknown));
  for (const [word, words] of Object.entries(suggested)) {
    if (words.length > 0)
      near.set(
        word,
        words.map((one) => one.word),
      );
  }
  const named = new Set<string>();
  const remarks = sentences
    .filter((sentence) => !NOTHING.test(sentence)) // the verdict says it
    .map((sentence): Child => {
      const words = [...near.keys()].filter((word) => sentence.includes(`'${word}'`));
      words.forEach((word) => named.add(word));
      const instead = words.flatMap((word) => {
        const known = near.get(word)!;
        return known.length > 0 && !sentence.includes("perhaps") ? ["; perhaps ", link(word, known)] : [];
      });
      return h("li", sayShare(sentence), instead);
    });
  const left = [...near].filter(([word]) => !named.has(word));
  return h(
    "div.question",
    question.tree
      ? h(
          "p.chips",
          { title: question.understood, "aria-label": `Understood: ${question.understood}` },
          h("span.chips-lead", "Understood"),
          chipsOf(question.tree).map(chipElement),
        )
      : h("p.chips", h("span.chips-lead", "Understood"), question.understood || "nothing"),
    h(
      "ul.plain.remarks",
      question.not_used
        .filter(({ text }) => !near.has(text))
        .map(({ text, reason }) => h("li", `“${text}” is not used: ${reason}`)),
      remarks,
      left.map(([word, known]) =>
        h(
          "li",
          `'${word}' is not in the captions; left out`,
          known.length > 0 ? ["; perhaps ", link(word, known)] : null,
        ),
      ),
    ),
  );
}
