/** The rows of the catalogue, asked for page by page as they come into sight. */

import { get, isAbort } from "../../api/client.ts";
import type { CaptureRow } from "../../api/types.ts";

const PAGE = 100;
/** The largest page that the server gives. */
const MOST = 1000;

/** `arrived` is called when rows came; `failed` when they could not. */
export function makeRows(arrived: () => void, failed: (fault: unknown) => void) {
  let pages = new Map<number, CaptureRow[] | "asked">();
  let total = 0;
  let where = "";
  let sort = "name";
  let current = new AbortController();

  let found: number | null = null;

  async function load(page: number): Promise<void> {
    const signal = current.signal;
    pages.set(page, "asked");
    const answer = await get("/api/captures", { where, sort, offset: page * PAGE, limit: PAGE }, signal);
    if (signal.aborted) return;
    total = answer.total;
    pages.set(page, answer.captures);
  }

  function at(index: number): CaptureRow | null {
    const page = pages.get(Math.floor(index / PAGE));
    return page && page !== "asked" ? (page[index % PAGE] ?? null) : null;
  }

  return {
    at,
    get total() {
      return total;
    },
    /** Ask for the rows of a range that are not there yet. */
    want(start: number, end: number): void {
      for (let page = Math.floor(start / PAGE); page * PAGE < end; page += 1) {
        if (pages.has(page)) continue;
        const asked = pages;
        load(page).then(arrived, (fault: unknown) => {
          asked.delete(page);
          if (!isAbort(fault)) failed(fault);
        });
      }
    },
    /** The number of the row that was asked for by name; null: it is not among these. */
    get found() {
      return found;
    },
    /** Begin again with a filter and an order; resolves when the first page is there. */
    async ask(nextWhere: string, nextSort: string, find?: string): Promise<void> {
      current.abort();
      current = new AbortController();
      const { signal } = current;
      const query = { where: nextWhere, sort: nextSort, offset: 0, limit: PAGE, find };
      const answer = await get("/api/captures", query, signal); // the rows stay meanwhile
      if (signal.aborted) return;
      where = nextWhere;
      sort = nextSort;
      total = answer.total;
      found = find ? (answer.found ?? null) : null;
      pages = new Map([[0, answer.captures]]);
    },
    /** The index of a capture among the rows that are there, or -1. */
    find(name: string): number {
      for (const [page, rows] of pages) {
        if (rows === "asked") continue;
        const at = rows.findIndex((row) => row.name === name);
        if (at >= 0) return page * PAGE + at;
      }
      return -1;
    },
    /** The names of a range of rows, both ends included, also of those that have not arrived. */
    async names(low: number, high: number): Promise<string[]> {
      const names: string[] = [];
      for (let i = low; i <= high; i += 1) {
        const row = at(i);
        if (row) names.push(row.name);
      }
      if (names.length === high - low + 1) return names;
      names.length = 0;
      while (names.length <= high - low) {
        const offset = low + names.length;
        const limit = Math.min(high - offset + 1, MOST);
        const page = await get("/api/captures", { where, sort, offset, limit }, current.signal);
        if (page.captures.length === 0) break; // fewer are left by now
        names.push(...page.captures.map((row) => row.name));
      }
      return names;
    },
    /** The tags of the rows that are there. */
    tags: () =>
      [...pages.values()].flatMap((page) =>
        page === "asked" ? [] : page.flatMap((row) => Object.keys(row.tags)),
      ),
    /** Replace a row that was edited. */
    replace(row: CaptureRow): void {
      for (const rows of pages.values()) {
        if (rows === "asked") continue;
        const at = rows.findIndex((one) => one.name === row.name);
        if (at >= 0) rows[at] = row;
      }
    },
  };
}

export type Rows = ReturnType<typeof makeRows>;
