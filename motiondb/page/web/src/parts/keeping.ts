/** Ask for the name under which something generated is kept as a capture. */

import { askLine } from "./asking.ts";

export function askToKeep(title: string, suggested: string, keep: (name: string) => Promise<void>): void {
  const note = "It is marked as generated: it can be searched and exported, but nothing learns from it.";
  askLine({ title, label: "Name of the capture", yes: "Keep", value: suggested, note }, keep);
}

/** A name for a generated capture: the words, without signs, and the seed. */
export function suggestedName(words: string, seed: number): string {
  const plain = words.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "_");
  return `new/${plain.slice(0, 40)}_${seed}`;
}
