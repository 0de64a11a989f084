/** Unsaved drawings, one for each board, kept in this browser until they are saved or discarded. */

import type { DiagramShape } from "../../api/types.ts";

const keyOf = (name: string): string => `motiondb-board:${name}`;

/** Remember the changed drawing of a board. */
export function keepDraft(name: string, diagram: DiagramShape): void {
  try {
    localStorage.setItem(keyOf(name), JSON.stringify(diagram));
  } catch {
    // the browser stores nothing; the board works without it
  }
}

/** Forget the draft of a board: it was saved, or discarded. */
export function dropDraft(name: string): void {
  try {
    localStorage.removeItem(keyOf(name));
  } catch {
    // nothing was kept
  }
}

/** The draft of a board; null if there is none. */
export function readDraft(name: string): DiagramShape | null {
  try {
    return JSON.parse(localStorage.getItem(keyOf(name)) ?? "null") as DiagramShape | null;
  } catch {
    return null;
  }
}
