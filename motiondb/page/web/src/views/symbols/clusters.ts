/** What the clusters of the symbol space are about, and a colour for each. */

import type { PlacedSymbol } from "../../api/types.ts";
import { tintOf, type Tint } from "../../parts/tint.ts";

export interface Cluster {
  cluster: number;
  tint: Tint;
  /** Number of its symbols. */
  symbols: number;
  /** The words that are most often said of its segments, the most frequent first. */
  words: string[];
}

/** Most words that name a cluster. */
const WORDS = 3;
/** A word counts from this probability on, as on the map. */
export const LIKELY = 0.3;

/** The clusters that have symbols, the one with the most segments first. */
export function clustersOf(symbols: readonly PlacedSymbol[]): Cluster[] {
  const numbers = [...new Set(symbols.map((one) => one.cluster))];
  const rows = numbers.map((cluster) => {
    const members = symbols.filter((one) => one.cluster === cluster);
    const weights = new Map<string, number>();
    for (const { words, count } of members) {
      for (const { word, probability } of words) {
        if (probability >= LIKELY) weights.set(word, (weights.get(word) ?? 0) + probability * count);
      }
    }
    const words = [...weights].sort((a, b) => b[1] - a[1]).slice(0, WORDS);
    return {
      row: { cluster, tint: tintOf(cluster), symbols: members.length, words: words.map(([word]) => word) },
      segments: members.reduce((sum, one) => sum + one.count, 0),
    };
  });
  return rows.sort((a, b) => b.segments - a.segments).map(({ row }) => row);
}

/** The words at both ends of an axis; none where no movement has a probable word. */
export interface AxisEnds {
  low: string[];
  high: string[];
}

/** Most words that an end of an axis is known by. */
const ENDS = 2;

/** The words of the movements that lie farthest out at both ends of an axis of the space. */
export function axisEnds(symbols: readonly PlacedSymbol[], axis: number): AxisEnds {
  const likely = symbols.filter((one) => (one.words[0]?.probability ?? 0) >= LIKELY);
  const sorted = [...likely].sort((a, b) => (a.at[axis] ?? 0) - (b.at[axis] ?? 0));
  const words = sorted.map((one) => one.words[0]!.word);
  const low = [...new Set(words)].slice(0, ENDS);
  const high = [...new Set(words.reverse())].filter((word) => !low.includes(word)).slice(0, ENDS);
  return { low, high };
}

/** The symbols that a text looks for: its number, or a word that begins with it; null: all. */
export function foundSymbols(symbols: readonly PlacedSymbol[], text: string): Set<number> | null {
  const typed = text.trim().toLowerCase();
  if (!typed) return null;
  const fits = (one: PlacedSymbol): boolean =>
    String(one.symbol) === typed ||
    one.words.some(({ word, probability }) => probability >= 0.05 && word.toLowerCase().startsWith(typed));
  return new Set(symbols.filter(fits).map((one) => one.symbol));
}
