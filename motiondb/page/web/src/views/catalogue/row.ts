/** One row of the catalogue. */

import type { CaptureRow } from "../../api/types.ts";
import { fill, h } from "../../dom/element.ts";
import { onPage } from "../../api/advice.ts";
import { breakable, plural, seconds } from "../../parts/text.ts";
import type { Thumbs } from "./thumbs.ts";

export interface RowParts {
  row: HTMLElement;
  thumb: HTMLCanvasElement;
  cells: HTMLElement[];
}

export interface Column {
  title: string;
  /** The name to sort by; null: cannot be sorted. */
  sort: string | null;
  kind: string;
}

export const COLUMNS: readonly Column[] = [
  { title: "Figure", sort: null, kind: "figure" },
  { title: "Capture", sort: "name", kind: "name" },
  { title: "Length", sort: "duration", kind: "length" },
  { title: "Performer", sort: "performer", kind: "performer" },
  { title: "Words", sort: "words", kind: "words" },
  { title: "Tags", sort: null, kind: "tags" },
  { title: "Licence", sort: "licence", kind: "licence" },
];

/** The height of a row, pixels; the style says the same. */
export const ROW_HEIGHT = 68;
const THUMB = { width: 48, height: 60 };

/** Tags that have a column of their own. */
const OWN_COLUMN = new Set(["performer", "licence"]);

export function makeRow(): RowParts {
  const scale = Math.min(devicePixelRatio, 2);
  const thumb = h("canvas.thumb", {
    width: THUMB.width * scale,
    height: THUMB.height * scale,
    "aria-hidden": "true",
  });
  const cells = COLUMNS.map(({ kind }) => h("div", { role: "gridcell", class: `cell cell-${kind}` }));
  cells[0]!.append(thumb);
  return { row: h("div.row-capture", { role: "row", tabindex: -1 }, cells), thumb, cells };
}

/** The captions of the whole capture, as they are written into one line. */
export function wholeWords(row: Pick<CaptureRow, "words">): string {
  return row.words
    .filter((one) => one.start === null)
    .map((one) => one.words)
    .join("; ");
}

/** Fill a row with a capture; null while it has not arrived. */
export function showRow(
  parts: RowParts,
  index: number,
  capture: CaptureRow | null,
  options: {
    chosen: boolean;
    /** Whether it is one of several that are selected. */
    picked: boolean;
    canEdit: boolean;
    /** Whether the database has learned: before, no capture has, and a line above says so. */
    learned: boolean;
    thumbs: Thumbs;
  },
): void {
  const { row, cells, thumb } = parts;
  row.setAttribute("aria-rowindex", String(index + 2)); // the head is row 1
  row.setAttribute("aria-selected", String(options.chosen));
  row.tabIndex = options.chosen ? 0 : -1;
  row.classList.toggle("waiting", capture === null);
  options.thumbs.show(thumb, capture?.name ?? null);
  const [, name, length, performer, words, tags, licence] = cells as [
    HTMLElement,
    HTMLElement,
    HTMLElement,
    HTMLElement,
    HTMLElement,
    HTMLElement,
    HTMLElement,
  ];
  if (!capture) {
    for (const cell of cells.slice(1)) cell.replaceChildren();
    return;
  }
  fill(
    name,
    h(
      "label.check",
      h("input", {
        type: "checkbox",
        tabindex: -1,
        checked: options.picked,
        "data-pick": capture.name,
        "aria-label": `Select ${capture.name}`,
      }),
      h("span.capture-name", breakable(capture.name)),
    ),
    badges(capture, options),
  );
  length.textContent = seconds(capture.duration);
  performer.textContent = capture.tags["performer"] ?? "";
  fill(words, wordsOf(capture, options.canEdit));
  const others = Object.entries(capture.tags).filter(([key]) => !OWN_COLUMN.has(key));
  const said = others.map(([key, value]) => `${key} = ${value}`);
  tags.title = said.slice(1).join("\n");
  fill(tags, [
    ...others
      .slice(0, others.length > 2 ? 1 : 2)
      .map(([key, value], i) => h("span.tag", { title: said[i]! }, `${key}: ${value}`)),
    others.length > 2 ? h("span.tag", `${others.length - 1} more`) : null,
  ]);
  licence.textContent = capture.tags["licence"] ?? "unknown";
  licence.title = capture.tags["licence"] ?? "The licence of this capture is not known.";
}

function badges(capture: CaptureRow, options: { learned: boolean }): HTMLElement {
  const marks: [string, string][] = [];
  if (capture.kind === "generated") marks.push(["generated", "Made by motiondb; nothing learns from it."]);
  if (options.learned && !capture.learned && capture.kind !== "generated")
    marks.push(["not learned yet", "Learn again to search it with its own words."]);
  if (capture.copies > 0)
    marks.push([plural(capture.copies, "copy", "copies"), "There are copies, cuts or mirror images of it."]);
  for (const note of capture.notes)
    marks.push([/replaced|interpolated/.test(note) ? "repaired" : "to check", onPage(note)]);
  return h(
    "span.badges",
    marks.map(([text, title]) => h("span.badge", { title }, text)),
  );
}

function wordsOf(capture: CaptureRow, canEdit: boolean): Node {
  const whole = wholeWords(capture);
  const parts = capture.words.filter((one) => one.start !== null);
  const text = [
    h("span", { class: whole ? "" : "muted" }, whole || (parts.length > 0 ? "" : "no words")),
    parts.length > 0
      ? h("span.muted", whole ? " · " : "", plural(parts.length, "caption"), " of parts")
      : null,
  ];
  if (!canEdit) return h("span.words-text", { title: whole }, text);
  return h(
    "button.words-button",
    {
      type: "button",
      tabindex: -1,
      "data-edit": "words",
      title: "Edit the words (E)",
    },
    text,
  );
}
