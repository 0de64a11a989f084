/** The rows of the catalogue, asked for page by page as they come into sight. */

import { get } from "../../api/client.ts";
import type { CaptureRow } from "../../api/types.ts";

const PAGE = 100;
/** The largest page that the server gives. */
const MOST = 1000;

/** `arrived` is called when rows came. */
export function makeRows(arrived: () => void) {
  let held = {
    where: "",
    sort: "name",
    total: 0,
    /** The place of the row that was looked for. */
    found: null as number | null,
    pages: new Map<number, CaptureRow[] | "asked">(),
  };
  let current = new AbortController();

  async function load(page: number): Promise<void> {
    const [mine, { signal }] = [held, current];
    const { where, sort } = mine;
    mine.pages.set(page, "asked");
    const query = { where, sort, offset: page * PAGE, limit: PAGE };
    try {
      const answer = await get("/api/captures", query, signal);
      mine.total = answer.total;
      mine.pages.set(page, answer.captures);
      if (mine === held) arrived();
    } catch (fault) {
      mine.pages.delete(page);
      throw fault;
    }
  }

  function at(index: number): CaptureRow | null {
    const page = held.pages.get(Math.floor(index / PAGE));
    return page && page !== "asked" ? (page[index % PAGE] ?? null) : null;
  }

  return {
    at,
    get total(): number {
      return held.total;
    },
    /** Ask for the rows of a range that are not there yet. */
    want(start: number, end: number): void {
      for (let page = Math.floor(start / PAGE); page * PAGE < end; page += 1) {
        if (!held.pages.has(page)) void load(page);
      }
    },
    get found() {
      return held.found;
    },
    /** Begin again with a filter and an order; resolves when the first page is there. */
    async ask(where: string, sort: string, find?: string): Promise<void> {
      current.abort();
      current = new AbortController();
      const query = { where, sort, offset: 0, limit: PAGE, find };
      const { total, found, captures } = await get("/api/captures", query, current.signal); // the rows stay meanwhile
      held = { where, sort, total, found: find ? (found ?? null) : null, pages: new Map([[0, captures]]) };
    },
    find(name: string): number {
      for (const [page, rows] of held.pages) {
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
        const query = { where: held.where, sort: held.sort, offset, limit };
        const page = await get("/api/captures", query, current.signal);
        if (page.captures.length === 0) break; // fewer are left by now
        names.push(...page.captures.map((row) => row.name));
      }
      return names;
    },
    /** The tags of the rows that are there. */
    tags: () =>
      [...held.pages.values()].flatMap((page) =>
        page === "asked" ? [] : page.flatMap((row) => Object.keys(row.tags)),
      ),
    /** Replace a row that was edited. */
    replace(row: CaptureRow): void {
      for (const rows of held.pages.values()) {
        if (rows === "asked") continue;
        const at = rows.findIndex((one) => one.name === row.name);
        if (at >= 0) rows[at] = row;
      }
    },
  };
}

export type Rows = ReturnType<typeof makeRows>;
