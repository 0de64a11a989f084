/** Grammars and sequences as the server sends them. Times in seconds, places [x, z] in metres. */

import type { Source, Stretch, DescribedWord } from "../../api/types.ts";

export type Spot = readonly [x: number, z: number];

export interface GrammarRow {
  name: string;
  captures: number;
  seconds: number;
  segments: number;
  terminals: number;
  sentences: number;
  nonterminals: number;
  rules: number;
  bits: number;
  /** Whether it derives a string that is not among its sentences. */
  derives_new: boolean;
}

export interface Terminal {
  terminal: string;
  count: number;
  seconds: number;
  words: DescribedWord[];
  symbols: { symbol: number; share: number }[];
  medoid: { capture: string; start: number; end: number };
}

export interface GrammarFacts {
  grammar: string;
  seed: number;
  captures: { capture: string; sha256: string; seconds: number; there: boolean }[];
  frames: number;
  segments: number;
  terminals: Terminal[];
  sentences: number;
  /** Shortest, mean, longest. */
  sentence_lengths: [number, number, number];
  nonterminals: number;
  rules: number;
  derives_new: boolean;
  bits: Record<string, number>;
  text: string;
  /** The rules with repetitions written as `X+`. */
  text_with_loops: string;
  /** Names of the captures that hold sequences of it. */
  sequences: string[];
}

export interface StripItem {
  at: number;
  terminal: string;
  nonterminal: string;
  start: number;
  end: number;
  words: string[];
  capture: string;
  source_start: number;
  source_end: number;
}

/** A node of a derivation; nodes stand in preorder. */
export interface TreeNode {
  symbol: string;
  /** Number of the parent, -1 for the root. */
  parent: number;
  /** Positions in the string that it covers. */
  start: number;
  end: number;
  terminal: boolean;
}

export interface RootPath {
  /** Points per second. */
  fps: number;
  points: Spot[];
}

export interface Sequence {
  id: string;
  ref: string;
  parent: string | null;
  grammar: string;
  seed: number;
  string: string[];
  seconds: number;
  join_cost: number | null;
  foot_slip: number | null;
  foot_slip_of_sources: number | null;
  strip: StripItem[];
  path: RootPath;
  tree: TreeNode[];
  tree_text: string;
  sources: Source[];
  stretches: Stretch[];
  /** The positions that differ from the parent. */
  edited: { start: number; end: number } | null;
  saved: string | null;
}

/** Another derivation of a region: a whole sequence, or why it cannot be played. */
export type Alternative = { region: string[]; log_probability: number | null } & (
  (Sequence & { not_playable?: undefined }) | { string: string[]; not_playable: string }
);

export interface Alternatives {
  region: { symbol: string; start: number; end: number; path: number[]; position: number };
  can_widen: boolean;
  can_narrow: boolean;
  alternatives: Alternative[];
}

/** A terminal, the levels by which its region is wider, and which draw of alternatives is shown. */
export interface Selection {
  at: number;
  wider: number;
  draw: number;
}

/** What a sequence is made from. */
export interface Wish {
  seed: number;
  length: number | null;
  like: string | null;
}
