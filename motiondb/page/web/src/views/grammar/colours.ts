/** One colour for each terminal of a grammar, the same in the strip, the path and the lists. */

import { hueOf, rgbOf, tintOf } from "../../parts/tint.ts";

export function coloursOf(terminals: readonly { terminal: string }[]) {
  const number = new Map(terminals.map(({ terminal }, i) => [terminal, i]));
  const numberOf = (terminal: string): number => number.get(terminal) ?? number.size;
  return {
    of: (terminal: string) => tintOf(numberOf(terminal)),
    /** The strong colour as numbers between 0 and 1. */
    rgb: (terminal: string) => rgbOf(0.62, 0.13, hueOf(numberOf(terminal))),
  };
}

export type TerminalColours = ReturnType<typeof coloursOf>;
