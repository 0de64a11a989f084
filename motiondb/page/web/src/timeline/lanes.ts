/** The content of a timeline: lanes of blocks, and the rows of blocks that overlap. */

import type { Caption, Finding, Stretch, WordedSegment, WordsOverTime } from "../api/types.ts";
import { probability } from "../parts/text.ts";
import { tintOf } from "../parts/tint.ts";
import { routeTo } from "../shell/router.ts";

export interface Block {
  start: number;
  end: number;
  label: string;
  /** The whole sentence, for pointers and screen readers. */
  title: string;
  /** Colour of the field; the colour of the lane if absent. */
  colour?: string;
  /** Drawn faintly: not known. */
  faint?: boolean;
  /** An address that shows more of it, and the words of its link. */
  more?: { href: string; text: string };
  /** Hatched: it was asked for, and is not shown. */
  missing?: boolean;
}

export interface Lane {
  name: string;
  kind: "symbols" | "words" | "captions" | "stretches" | "parts" | "events";
  blocks: readonly Block[];
}

/** The row of each block, so that blocks of a row do not overlap; as few rows as possible. */
export function packRows(blocks: readonly { start: number; end: number }[]): number[] {
  const order = blocks.map((_, i) => i).sort((a, b) => blocks[a]!.start - blocks[b]!.start);
  const ends: number[] = [];
  const rows = new Array<number>(blocks.length).fill(0);
  for (const i of order) {
    const block = blocks[i]!;
    let row = ends.findIndex((end) => end <= block.start + 1e-6);
    if (row < 0) row = ends.length;
    ends[row] = block.end;
    rows[i] = row;
  }
  return rows;
}

const span = (start: number, end: number): string => `${start.toFixed(2)} to ${end.toFixed(2)} s`;

/** A segment with the word that is most often said of its symbol, where it has one. */
type Segment = Partial<WordedSegment> & Pick<WordedSegment, "symbol" | "start" | "end" | "known">;

/** A word below this probability is written with a question mark: others are as likely. */
const SURE = 0.5;

/** The kinds of movement, each with the word of its symbol, or its number where it has none. */
export function symbolLane(segments: readonly Segment[]): Lane {
  return {
    name: "movements",
    kind: "symbols",
    blocks: segments.map(({ symbol, start, end, known, word, word_probability: p }) => ({
      start,
      end,
      label: word ? (p! >= SURE ? word : `${word}?`) : `movement ${symbol}`,
      title: `${word ? `most often called ${word} (${probability(p)}), ` : ""}symbol ${symbol}, ${span(start, end)}${known ? "" : "; unlike everything learned"}`,
      faint: !known || (word !== null && word !== undefined && p! < SURE),
      more: { href: routeTo("symbols", { symbol }), text: "Show on the map of movements" },
    })),
  };
}

export function captionLane(captions: readonly Caption[], duration: number): Lane {
  return {
    name: "captions",
    kind: "captions",
    blocks: captions.map(({ words, start, end }) => ({
      start: start ?? 0,
      end: end ?? duration,
      label: words,
      title: start === null ? `“${words}”, the whole capture` : `“${words}”, ${span(start, end ?? duration)}`,
    })),
  };
}

/** Words that the motion suggests, the probable ones as label. */
export function wordLane(words: readonly WordsOverTime[]): Lane {
  return {
    name: "likely",
    kind: "words",
    blocks: words.map((one) => {
      const all = one.words.map(({ word, probability: p }) => `${word} ${probability(p)}`.trim()).join(", ");
      const checked = one.words.some((each) => each.probability !== null);
      const probable = one.words.filter((each, n) => (checked ? (each.probability ?? 0) >= 0.5 : n === 0));
      return {
        start: one.start,
        end: one.end,
        label: probable.map(({ word }) => word).join(" ") || "–",
        title: `${all || "no words"}, ${span(one.start, one.end)}`,
        faint: probable.length === 0 || !checked,
      };
    }),
  };
}

/** What a capture lacks: things that it needs, and faults. */
export function lacksLane(findings: readonly Finding[]): Lane {
  return {
    name: "lacks",
    kind: "parts",
    blocks: findings.map(({ kind, family, start, end, sentence }) => ({
      start,
      end,
      label: family === "needs" ? sentence.replace(/, [^,]*$/, "") : kind,
      title: sentence,
      faint: family !== "needs",
    })),
  };
}

/** The source of every stretch of a generated motion, with its licence. */
export function stretchLane(stretches: readonly Stretch[]): Lane {
  const names = [...new Set(stretches.map((one) => one.capture))];
  return {
    name: "sources",
    kind: "stretches",
    blocks: stretches.map((one) => {
      const from = ` from ${one.source_start.toFixed(2)} s`;
      const licence = one.licence ? `, licence ${one.licence}` : "";
      return {
        start: one.start,
        end: one.end,
        label: one.capture || "drawn from the model",
        title: one.capture
          ? `${one.capture}${from}${licence}, ${span(one.start, one.end)}`
          : `drawn from the model, ${span(one.start, one.end)}`,
        colour: one.capture ? tintOf(names.indexOf(one.capture) + 3).soft : "transparent",
        faint: !one.capture,
      };
    }),
  };
}
