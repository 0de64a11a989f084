/** Unsaved drawings, one for each board, kept in this browser until they are saved or discarded. */

import type { DiagramShape } from "../../api/types.ts";

/** The board that a drawing changes. */
export interface Edited {
  /** The database whose boards these are: another one may be served at the same address. */
  database: string;
  /** The name of the board; "": a new one. */
  name: string;
  /** The text of its file when the drawing began; a draft of an older file is not shown. */
  text: string;
}

/** The key of the draft of a board. */
export function draftKey({ database, name, text }: Edited): string {
  let digest = 0x811c9dc5; // FNV-1a: short, and there without a secure address
  for (let i = 0; i < text.length; i += 1) digest = Math.imul(digest ^ text.charCodeAt(i), 0x01000193);
  return `motiondb-board:${JSON.stringify([database, name, (digest >>> 0).toString(16)])}`;
}

/** Remember the changed drawing of a board. */
export function keepDraft(edited: Edited, diagram: DiagramShape): void {
  try {
    localStorage.setItem(draftKey(edited), JSON.stringify(diagram));
  } catch {
    // the browser stores nothing; the board works without it
  }
}

/** Forget the draft of a board: it was saved, or discarded. */
export function dropDraft(edited: Edited): void {
  try {
    localStorage.removeItem(draftKey(edited));
  } catch {
    // nothing was kept
  }
}

/** The draft of a board; null if there is none. */
export function readDraft(edited: Edited): DiagramShape | null {
  try {
    return JSON.parse(localStorage.getItem(draftKey(edited)) ?? "null") as DiagramShape | null;
  } catch {
    return null;
  }
}
