/** Terminals as coloured letters. */

import { h } from "../../dom/element.ts";
import type { TerminalColours } from "./colours.ts";

/** A string of terminals, each in its colour; read as text by screen readers. */
export function letters(string: readonly string[], colours: TerminalColours): HTMLElement {
  if (string.length === 0) return h("span.muted", "(nothing)");
  return h(
    "span.letters",
    string.flatMap((terminal) => [
      h("span.letter", { style: { background: colours.of(terminal).soft } }, terminal),
      " ",
    ]),
  );
}
