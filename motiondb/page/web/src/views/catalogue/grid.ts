/** The captures as large previews, which play while they are pointed at or have the focus. */

import { fill, h } from "../../dom/element.ts";
import { makeVirtualList, type VirtualList } from "../../parts/virtual.ts";
import { seconds } from "../../parts/text.ts";
import { makeRangePick } from "./picking.ts";
import { wholeWords } from "./row.ts";
import type { Table, TableOptions } from "./table.ts";

/** The height of a row of cards with its gap, and the least width of a card, pixels. */
const ROW = 236;
const LEAST_WIDTH = 168;
const PREVIEW = { width: 220, height: 160 };

/** A table in another form: it has the same rows, selection and actions. */
export function makeGrid(options: Omit<TableOptions, "onSort" | "onEdit" | "canEdit" | "hasLearned">): Table {
  const { rows, thumbs } = options;
  let chosen: string | null = null;
  let columns = 1;
  const pickRange = makeRangePick(rows, options);
  /** What a row of cards shows: while it is the same, the cards stay, and with them the focus. */
  const shown = new WeakMap<HTMLElement, readonly unknown[]>();
  const body = h("div.grid-body");
  const element = h(
    "div.table.grid",
    { role: "list", "aria-label": "Captures as previews", tabindex: -1 },
    body,
  );

  function card(index: number): HTMLElement | null {
    const capture = rows.at(index);
    if (!capture) return null;
    const scale = Math.min(devicePixelRatio, 2);
    const canvas = h("canvas.preview", {
      width: PREVIEW.width * scale,
      height: PREVIEW.height * scale,
      "aria-hidden": "true",
    });
    thumbs.show(canvas, capture.name);
    const move = (on: boolean): void => thumbs.move(canvas, on);
    const words = wholeWords(capture) || (capture.words[0]?.words ?? "no words");
    const box = h("input", {
      type: "checkbox",
      checked: options.isPicked(capture.name),
      "aria-label": `Select ${capture.name}`,
      on: {
        click: (event) => void pickRange(index, event.shiftKey, box.checked),
      },
    });
    return h(
      "div",
      {
        class: capture.name === chosen ? "card chosen" : "card",
        role: "listitem",
        on: {
          pointerenter: () => move(true),
          pointerleave: () => move(false),
          focusin: () => move(true),
          focusout: () => move(false),
        },
      },
      h(
        "button.card-open",
        {
          type: "button",
          title: words,
          "data-name": capture.name,
          on: { click: () => options.onChoose(capture.name) },
        },
        canvas,
        h("span.capture-name", capture.name),
        h("span.card-words", words),
      ),
      h("span.card-length", seconds(capture.duration)),
      box,
    );
  }

  /** Show on a card whether it is open and selected. */
  function mark(card: Element, name: string): void {
    card.classList.toggle("chosen", name === chosen);
    card.querySelector("input")!.checked = options.isPicked(name);
  }

  const list: VirtualList = makeVirtualList({
    viewport: element,
    body,
    rowHeight: ROW,
    make: () => h("div.card-row", { role: "presentation" }),
    render(row, index) {
      const end = Math.min((index + 1) * columns, rows.total);
      const captures = Array.from({ length: end - index * columns }, (_, i) => rows.at(index * columns + i));
      const now = [index, columns, ...captures];
      const before = shown.get(row);
      if (before?.length === now.length && now.every((one, i) => one === before[i])) {
        captures.forEach((capture, i) => capture && mark(row.children[i]!, capture.name));
        return;
      }
      shown.set(row, now);
      const cards = captures.map((_, i) => card(index * columns + i) ?? h("div.card", { role: "listitem" }));
      row.style.gridTemplateColumns = `repeat(${columns}, minmax(0, 1fr))`;
      fill(row, cards);
    },
    onRange: (start, end) => rows.want(start * columns, Math.min(end * columns, rows.total)),
  });

  function measure(): boolean {
    const next = Math.max(Math.floor((element.clientWidth - 12) / LEAST_WIDTH), 1);
    const changed = next !== columns;
    columns = next;
    return changed;
  }

  const sized = new ResizeObserver(() => {
    if (measure()) list.reset(Math.ceil(rows.total / columns));
  });
  sized.observe(element);

  return {
    element,
    reset() {
      measure();
      list.reset(Math.ceil(rows.total / columns));
    },
    refresh: () => list.refresh(),
    choose(name) {
      chosen = name;
      list.refresh();
    },
    leaveOut: () => undefined, // a card shows none of these
    reveal: (index) => list.reveal(Math.floor(index / columns)),
    focus(name) {
      const cards = [...element.querySelectorAll<HTMLElement>("[data-name]")];
      (cards.find((one) => one.dataset["name"] === name) ?? element).focus({ preventScroll: true });
    },
    close() {
      sized.disconnect();
      list.close();
    },
  };
}
