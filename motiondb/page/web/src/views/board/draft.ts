/** Unsaved drawings, one for each board, kept in this browser until they are saved or discarded. */

import type { DiagramShape } from "../../api/types.ts";

/** The board that a drawing changes. */
export interface Edited {
  /** The database whose boards these are: another one may be served at the same address. */
  database: string;
  /** The name of the board; "": a new one. */
  name: string;
  /** The text of its file when the drawing began; a draft of an older file is shown on demand. */
  text: string;
}

/** The key of the draft of a board. */
export function draftKey({ database, name, text }: Edited): string {
  let digest = 0x811c9dc5; // FNV-1a: short, and there without a secure address
  for (let i = 0; i < text.length; i += 1) digest = Math.imul(digest ^ text.charCodeAt(i), 0x01000193);
  return `${boardKey(database, name)}${(digest >>> 0).toString(16)}`;
}

/** How the keys of all drafts of a board begin, whatever its file said when they were begun. */
const boardKey = (database: string, name: string): string =>
  `motiondb-board:${JSON.stringify([database, name])}:`;

/** Remember the changed drawing of a board. */
export function keepDraft(edited: Edited, diagram: DiagramShape): void {
  try {
    dropDraft(edited); // also one of an older file: it cannot be shown any more
    localStorage.setItem(draftKey(edited), JSON.stringify(diagram));
  } catch {
    // the browser stores nothing; the board works without it
  }
}

/** Forget all drafts of a board: it was saved, or discarded. */
export function dropDraft({ database, name }: Edited): void {
  try {
    const keys = Object.keys(localStorage).filter((key) => key.startsWith(boardKey(database, name)));
    for (const key of keys) localStorage.removeItem(key);
  } catch {
    // nothing was kept
  }
}

/** The draft of a board whose file was changed since; null if there is none. */
export function olderDraft(edited: Edited): DiagramShape | null {
  try {
    const [own, all] = [draftKey(edited), boardKey(edited.database, edited.name)];
    const key = Object.keys(localStorage).find((one) => one.startsWith(all) && one !== own);
    return JSON.parse((key && localStorage.getItem(key)) ?? "null") as DiagramShape | null;
  } catch {
    return null;
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
