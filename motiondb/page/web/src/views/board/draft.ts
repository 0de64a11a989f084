/** The diagram as it was left, so that it survives a reload of the page. */

import type { Diagram } from "./types.ts";

const KEY = "motiondb-board";

interface Draft {
  name: string;
  diagram: Diagram;
}

/** Remember a changed diagram for this tab of the browser. */
export function keepDraft(name: string, diagram: Diagram): void {
  try {
    sessionStorage.setItem(KEY, JSON.stringify({ name, diagram } satisfies Draft));
  } catch {
    // the browser keeps nothing; the board works without
  }
}

/** Forget the diagram: it was saved, or another one is open. */
export function dropDraft(): void {
  try {
    sessionStorage.removeItem(KEY);
  } catch {
    // nothing was kept
  }
}

/** The diagram that was left under a name; null where there is none. */
export function readDraft(name: string): Diagram | null {
  try {
    const draft = JSON.parse(sessionStorage.getItem(KEY) ?? "null") as Draft | null;
    return draft?.name === name ? draft.diagram : null;
  } catch {
    return null;
  }
}
