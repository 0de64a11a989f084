/** The table of captures: a head to sort by, rows that exist only while they are in sight. */

import type { CaptureRow } from "../../api/types.ts";
import { h } from "../../dom/element.ts";
import { makeVirtualList, type VirtualList } from "../../parts/virtual.ts";
import { isEditing } from "./editing.ts";
import { makeRangePick } from "./picking.ts";
import { COLUMNS, makeRow, ROW_HEIGHT, showRow, type RowParts } from "./row.ts";
import type { Rows } from "./rows.ts";
import type { Thumbs } from "./thumbs.ts";

export interface Table {
  readonly element: HTMLElement;
  /** The number of rows changed. */
  reset(sort: string): void;
  refresh(): void;
  choose(name: string | null): void;
  /** Leave out the columns of tags that no listed capture has. */
  leaveOut(known: ReadonlySet<string>): void;
  /** Bring a row into sight. */
  reveal(index: number): void;
  /** Give the row of a capture the focus, if it is in sight; else the table. */
  focus(name: string): void;
  close(): void;
}

export interface TableOptions {
  rows: Rows;
  thumbs: Thumbs;
  canEdit(): boolean;
  hasLearned(): boolean;
  onSort(sort: string): void;
  onChoose(name: string): void;
  onEdit(capture: CaptureRow, cell: HTMLElement): void;
  isPicked(name: string): boolean;
  /** Captures were selected, or not any more. */
  onPick(names: readonly string[], picked: boolean): void;
}

/** Columns and tags that do not stand in the column of tags. */
const NO_TAGS = new Set(["kind", "format", "performer", "licence"]);

export function makeTable(options: TableOptions): Table {
  const { rows } = options;
  const parts = new WeakMap<HTMLElement, RowParts>();
  const indices = new WeakMap<HTMLElement, number>();
  let chosen: string | null = null;
  let focused = 0;
  const pickRange = makeRangePick(rows, options);
  let sort = "name";

  const heads = COLUMNS.map(({ title, sort: by, kind }) =>
    h(
      "div",
      { role: "columnheader", class: `cell cell-${kind}` },
      by ? h("button.sort", { type: "button", on: { click: () => sortBy(by) } }, title) : title,
    ),
  );
  const head = h("div.table-head", { role: "row", "aria-rowindex": 1 }, heads);
  const body = h("div.table-body", { role: "rowgroup" });
  const element = h(
    "div.table",
    { role: "grid", "aria-label": "Captures", "aria-colcount": COLUMNS.length, tabindex: 0 },
    h("div.table-head-group", { role: "rowgroup" }, head),
    body,
  );

  function sortBy(by: string): void {
    options.onSort(sort === by ? `-${by}` : by);
  }

  const list: VirtualList = makeVirtualList({
    viewport: element,
    body,
    rowHeight: ROW_HEIGHT,
    make() {
      const made = makeRow();
      parts.set(made.row, made);
      return made.row;
    },
    render(row, index) {
      indices.set(row, index);
      const capture = rows.at(index);
      if (isEditing(row)) return; // its words are being edited
      showRow(parts.get(row)!, index, capture, {
        chosen: capture !== null && capture.name === chosen,
        picked: capture !== null && options.isPicked(capture.name),
        canEdit: options.canEdit(),
        learned: options.hasLearned(),
        thumbs: options.thumbs,
      });
    },
    onRange: (start, end) => rows.want(start, end),
  });

  function rowOf(target: EventTarget | null): HTMLElement | null {
    return (target as HTMLElement).closest<HTMLElement>(".row-capture");
  }

  function edit(row: HTMLElement): void {
    const capture = rows.at(indices.get(row) ?? -1);
    if (capture && options.canEdit()) options.onEdit(capture, parts.get(row)!.cells[4]!);
  }

  function pick(index: number): void {
    const capture = rows.at(index);
    focused = index;
    if (capture) options.onChoose(capture.name);
  }

  /** Select a row; with Shift, all from the row that was selected before. The name opens it. */
  function select(event: MouseEvent, box: HTMLInputElement, index: number): void {
    if (event.target !== box) {
      event.preventDefault(); // the label is there to be read with the box, the name opens the row
      return pick(index);
    }
    void pickRange(index, event.shiftKey, box.checked);
  }

  element.addEventListener("click", (event) => {
    const row = rowOf(event.target);
    if (!row) return;
    if ((event.target as HTMLElement).closest("[data-edit]")) return edit(row);
    const box = (event.target as HTMLElement)
      .closest("label")
      ?.querySelector<HTMLInputElement>("[data-pick]");
    if (box) return select(event, box, indices.get(row) ?? 0);
    if ((event.target as HTMLElement).matches("input")) return;
    pick(indices.get(row) ?? 0);
  });

  const STEPS: Record<string, number> = { ArrowDown: 1, ArrowUp: -1, PageDown: 8, PageUp: -8 };
  element.addEventListener("keydown", (event) => {
    if ((event.target as HTMLElement).matches("input, button")) return;
    const row = rowOf(event.target);
    const last = rows.total - 1;
    if (event.key in STEPS || event.key === "Home" || event.key === "End") {
      event.preventDefault();
      const from = row ? (indices.get(row) ?? 0) : focused - 1;
      const to = event.key === "Home" ? 0 : event.key === "End" ? last : from + (STEPS[event.key] ?? 0);
      focused = Math.min(Math.max(to, 0), last);
      list.reveal(focused);
      list.row(focused)?.focus({ preventScroll: true });
    } else if (row && (event.key === "Enter" || event.key === " ")) {
      event.preventDefault();
      pick(indices.get(row) ?? 0);
    } else if (row && event.key === "x") {
      const capture = rows.at(indices.get(row) ?? -1);
      if (capture) options.onPick([capture.name], !options.isPicked(capture.name));
    } else if (row && (event.key === "e" || event.key === "F2")) {
      event.preventDefault();
      edit(row);
    }
  });

  return {
    element,
    reset(nextSort) {
      sort = nextSort;
      COLUMNS.forEach((column, i) => {
        const direction =
          sort === column.sort ? "ascending" : sort === `-${column.sort}` ? "descending" : null;
        if (direction) heads[i]!.setAttribute("aria-sort", direction);
        else heads[i]!.removeAttribute("aria-sort");
      });
      element.setAttribute("aria-rowcount", String(rows.total + 1));
      list.reset(rows.total);
    },
    refresh: () => list.refresh(),
    leaveOut(known) {
      const others = [...known].some((tag) => !NO_TAGS.has(tag));
      for (const kind of ["performer", "licence"])
        element.classList.toggle(`without-${kind}`, !known.has(kind));
      element.classList.toggle("without-tags", !others);
    },
    choose(name) {
      chosen = name;
      list.refresh();
    },
    reveal: (index) => list.reveal(index),
    focus(name) {
      const index = rows.find(name);
      const row = index < 0 ? null : list.row(index);
      (row ?? element).focus({ preventScroll: true });
    },
    close: () => list.close(),
  };
}
