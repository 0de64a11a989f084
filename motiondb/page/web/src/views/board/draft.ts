/** The unsaved diagram, kept so that it survives a reload of the page. */

import type { DiagramShape } from "../../api/types.ts";

const KEY = "motiondb-board";

interface Draft {
  name: string;
  diagram: DiagramShape;
}

/** Remember a changed diagram for this tab of the browser. */
export function keepDraft(name: string, diagram: DiagramShape): void {
  try {
    sessionStorage.setItem(KEY, JSON.stringify({ name, diagram } satisfies Draft));
  } catch {
    // the browser stores nothing; the board works without it
  }
}

/** Delete the draft: the diagram was saved, or another one is open. */
export function dropDraft(): void {
  try {
    sessionStorage.removeItem(KEY);
  } catch {
    // nothing was kept
  }
}

/** The draft of a name; null if there is none. */
export function readDraft(name: string): DiagramShape | null {
  try {
    const draft = JSON.parse(sessionStorage.getItem(KEY) ?? "null") as Draft | null;
    return draft?.name === name ? draft.diagram : null;
  } catch {
    return null;
  }
}
