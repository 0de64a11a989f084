/**
 * A long list of which only the visible rows exist.
 *
 * All rows have one height. Rows are asked for by page, and drawn again when a page arrives; rows
 * that leave the window are used again for those that come in.
 */

export interface VirtualOptions {
  /** The element that scrolls. */
  viewport: HTMLElement;
  /** The element that holds the rows; it gets the height of all rows. */
  body: HTMLElement;
  rowHeight: number;
  make(): HTMLElement;
  /** Show a row; called again whenever its data may have changed. */
  render(row: HTMLElement, index: number): void;
  /** The rows in sight changed: half-open range. */
  onRange?(start: number, end: number): void;
}

/** Rows that are drawn beyond each edge of the window. */
const BEYOND = 4;

/** The rows to draw for a place of scrolling: half-open range. */
export function rowsInSight(
  top: number,
  height: number,
  rowHeight: number,
  total: number,
): [start: number, end: number] {
  const start = Math.max(Math.floor(top / rowHeight) - BEYOND, 0);
  const end = Math.min(Math.ceil((top + height) / rowHeight) + BEYOND, total);
  return [Math.min(start, end), end];
}

export function makeVirtualList(options: VirtualOptions) {
  const { viewport, body, rowHeight } = options;
  const rows = new Map<number, HTMLElement>();
  const spare: HTMLElement[] = [];
  let total = 0;
  let planned = false;
  let drawn = "";

  function draw(): void {
    planned = false;
    const top = Math.max(viewport.scrollTop - body.offsetTop, 0);
    const [start, end] = rowsInSight(top, viewport.clientHeight, rowHeight, total);
    for (const [index, row] of rows) {
      if (index >= start && index < end) continue;
      if (row.querySelector("input.in-place")) continue; // somebody types in it
      rows.delete(index);
      row.remove();
      spare.push(row);
    }
    // From the last to the first, so that each row is put before the next one: screen readers
    // and the Tab key meet the rows in their order.
    for (let index = end - 1; index >= start; index -= 1) {
      if (rows.has(index)) continue;
      const row = spare.pop() ?? options.make();
      row.style.transform = `translateY(${index * rowHeight}px)`;
      rows.set(index, row);
      options.render(row, index);
      body.insertBefore(row, rows.get(index + 1) ?? null);
    }
    const range = `${start} ${end}`;
    if (range !== drawn) {
      drawn = range;
      options.onRange?.(start, end);
    }
  }

  function plan(): void {
    if (planned) return;
    planned = true;
    requestAnimationFrame(draw);
  }

  viewport.addEventListener("scroll", plan, { passive: true });
  const sized = new ResizeObserver(plan);
  sized.observe(viewport);

  return {
    /** Draw everything again, with another number of rows. */
    reset(count: number): void {
      total = count;
      body.style.height = `${total * rowHeight}px`;
      for (const row of rows.values()) {
        row.remove();
        spare.push(row);
      }
      rows.clear();
      drawn = "";
      draw();
    },
    /** Draw the visible rows again. */
    refresh(): void {
      for (const [index, row] of rows) options.render(row, index);
    },
    /** Bring a row into sight. */
    reveal(index: number): void {
      const top = body.offsetTop + index * rowHeight;
      const head = body.offsetTop;
      if (top - head < viewport.scrollTop) viewport.scrollTop = top - head;
      else if (top + rowHeight > viewport.scrollTop + viewport.clientHeight) {
        viewport.scrollTop = top + rowHeight - viewport.clientHeight;
      }
      draw();
    },
    /** The element of a row, if it is drawn. */
    row: (index: number) => rows.get(index) ?? null,
    close(): void {
      viewport.removeEventListener("scroll", plan);
      sized.disconnect();
    },
  };
}

export type VirtualList = ReturnType<typeof makeVirtualList>;
