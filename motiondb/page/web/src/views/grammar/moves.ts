/**
 * Undo and redo of edits: undo goes to the parent, which the server knows; redo goes to the edit
 * that was undone, which the browser remembers while the tab is open.
 */

const KEY = "motiondb-grammar-redo";

function read(): Record<string, string> {
  try {
    return JSON.parse(sessionStorage.getItem(KEY) ?? "{}") as Record<string, string>;
  } catch {
    return {}; // no storage: redo works until the page is loaded again
  }
}

const left: Record<string, string> = read();

/** Remember that an edit of a sequence was undone. */
export function rememberRedo(parent: string, child: string): void {
  left[parent] = child;
  store();
}

/** The edit that redo goes to; null: there is none. */
export function redoOf(id: string): string | null {
  return left[id] ?? null;
}

function store(): void {
  try {
    sessionStorage.setItem(KEY, JSON.stringify(left));
  } catch {
    // private windows may have no storage
  }
}
