/** How certain an answer is, and how that is said and shown. */

import type { MatchPart, SearchReply, ShownMatch } from "../../api/types.ts";

/** Answers below this are folded: they are listed because something must be nearest. */
export const FLOOR = 0.05;
/** From here on an answer is more likely right than wrong. */
export const LIKELY = 0.5;

export type Grade = "likely" | "unlikely" | "folded" | "unmeasured";

export interface Certainty {
  /** The probability that the capture shows all that was asked; null: not measured. */
  value: number | null;
  /** Where it was not measured for the whole: it is at most this, the least of the known parts. */
  most: number | null;
  grade: Grade;
}

export function certaintyOf(match: Pick<ShownMatch, "probability" | "parts" | "contradicted">): Certainty {
  const parts = match.parts.map((part) => part.probability).filter((one) => one !== null);
  const most = match.probability === null && parts.length > 0 ? Math.min(...parts) : null;
  const value = match.probability;
  if (match.contradicted.length > 0) return { value, most, grade: "unlikely" };
  const known = value ?? most;
  const grade: Grade =
    known === null ? "unmeasured" : known >= LIKELY ? "likely" : known >= FLOOR ? "unlikely" : "folded";
  // At most likely is not likely: the order of the parts was not seen.
  return { value, most, grade: value === null && grade === "likely" ? "unmeasured" : grade };
}

/** A probability of the question in words: none below is exact, so the number stands beside it. */
export function sayGrade(value: number): string {
  if (value >= 0.95) return "almost certain";
  if (value >= 0.75) return "very likely";
  if (value >= LIKELY) return "more likely than not";
  if (value >= 0.2) return "unlikely";
  return "very unlikely";
}

/** For each replaced word of the question: the words that stand for it. */
export type Replaced = ReadonlyMap<string, string>;

export const NOTHING_REPLACED: Replaced = new Map();

export function replacedWords(answer: Pick<SearchReply, "taken">): Replaced {
  return new Map(
    Object.entries(answer.taken)
      .filter(([, known]) => known.length > 0)
      .map(([word, known]) => [word, known.map((one) => one.word).join(" or ")]),
  );
}

/** A part in the words that were really looked for. */
export function sayPart(part: Pick<MatchPart, "words">, replaced: Replaced) {
  const asked = part.words.split(" ");
  const instead = asked.filter((word) => replaced.has(word));
  return {
    /** The words that were really looked for. */
    words: asked.map((word) => replaced.get(word) ?? word).join(" "),
    /** The words of the question that they stand for; "" where they are the same. */
    instead: instead.join(" "),
  };
}

/** Whether the probability of the whole answer says all that is known of its one part. */
export function saysAll(
  match: Pick<ShownMatch, "parts" | "probability">,
): match is typeof match & { parts: [MatchPart] } {
  const [part, ...others] = match.parts;
  if (!part || others.length > 0) return false;
  if (part.probability === null || match.probability === null) return true;
  return Math.abs(part.probability - match.probability) < 0.005;
}

/** Whether a part is more likely at its place than elsewhere, as far as that is known. */
export const isPlaced = (part: MatchPart): boolean =>
  part.interval_probability === null || part.interval_probability >= LIKELY;

/** Whether a place is the whole take, but for the length of a frame or two. */
export function isWhole(part: Pick<MatchPart, "start" | "end">, duration: number): boolean {
  return part.start < 0.04 && duration - part.end < 0.08;
}
