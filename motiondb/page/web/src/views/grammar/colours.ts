/** One colour for each terminal of a grammar, the same in the strip, the path and the lists. */

import { hueOf, rgbOf, tintOf, type Tint } from "../../parts/tint.ts";
import type { Colour } from "../../player/figures.ts";

export interface TerminalColours {
  of(terminal: string): Tint;
  /** The strong colour as numbers between 0 and 1. */
  rgb(terminal: string): Colour;
}

export function coloursOf(terminals: readonly { terminal: string }[]): TerminalColours {
  const number = new Map(terminals.map(({ terminal }, i) => [terminal, i]));
  const numberOf = (terminal: string): number => number.get(terminal) ?? number.size;
  return {
    of: (terminal) => tintOf(numberOf(terminal)),
    rgb: (terminal) => rgbOf(0.62, 0.13, hueOf(numberOf(terminal))),
  };
}
