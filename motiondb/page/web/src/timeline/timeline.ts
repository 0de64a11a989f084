/** A take over time: lanes of blocks, a cursor, and a part selected by dragging. */

import { PAGE, pixelsOf } from "../dom/wheel.ts";
import { fill, h } from "../dom/element.ts";
import { packRows, type Block, type Lane } from "./lanes.ts";
import { niceTicks } from "./ticks.ts";

export type Interval = readonly [start: number, end: number];

export interface TimelineOptions {
  duration: number;
  label: string;
  onSeek(time: number): void;
  /** Called when a part was dragged or cleared; absent: nothing can be selected. */
  onSelect?(selection: Interval | null): void;
  /** Smaller, for lists of answers. */
  small?: boolean;
  /** A lane above the others, over the same time. */
  top?: HTMLElement | null;
}

/** A file without a server has no other views to go to. */
const hasViews = (): boolean => document.getElementById("motiondb-data") === null;

/** A drag shorter than this is a click, pixels. */
export const CLICK = 4;
/** A press this near to an end of the selection moves that end, pixels. */
const GRIP = 7;
/** Seconds of a take that are seen at the nearest, and how much nearer a button brings it. */
const NEAREST = 2;
const NEARER = 1.6;

export function makeTimeline(options: TimelineOptions) {
  const { duration } = options;
  const percent = (time: number): string => `${(Math.min(Math.max(time, 0), duration) / duration) * 100}%`;
  const cursor = h("div.timeline-cursor");
  const litLayer = h("div.timeline-lit-layer");
  const chosen = h("div.timeline-selection", { hidden: true });
  const lanesBox = h("div.timeline-lanes");
  const ruler = h("div.timeline-ruler", { "aria-hidden": "true" });
  const area = h("div.timeline-area", ruler, litLayer, options.top, lanesBox, chosen, cursor);
  const element = h(
    "div",
    { class: options.small ? "timeline small" : "timeline", role: "group", "aria-label": options.label },
    h("div.timeline-scroll", area),
  );
  const view = area.parentElement!;
  let nearness = 1;

  /** Shows a shorter part; the moment below a place of the window stays where it is. */
  function bring(factor: number, x = view.getBoundingClientRect().left + view.clientWidth / 2): void {
    const before = area.getBoundingClientRect();
    const share = (x - before.left) / before.width;
    nearness = Math.min(Math.max(nearness * factor, 1), Math.max(duration / NEAREST, 1));
    area.style.width = `${nearness * 100}%`;
    const after = area.getBoundingClientRect();
    view.scrollLeft += after.left + share * after.width - x;
    showRuler();
  }

  /** The cursor stays in sight where it was in sight. */
  function keepInSight(before: number, now: number): void {
    const [left, width] = [view.scrollLeft, view.clientWidth];
    const at = (time: number): number => (time / duration) * area.clientWidth - left;
    const inside = (x: number): boolean => x >= 0 && x <= width;
    if (inside(at(before)) && !inside(at(now))) view.scrollLeft += at(now) - width / 4;
  }

  if (!options.small && duration > 2 * NEAREST) {
    const zoom = (text: string, label: string, factor: number): HTMLElement =>
      h(
        "button.tool",
        {
          type: "button",
          "aria-label": label,
          title: label,
          on: { click: () => bring(factor) },
        },
        text,
      );
    element.append(
      h(
        "div.timeline-zoom",
        zoom("\u2212", "Show more of the time line", 1 / NEARER),
        zoom("+", "Show less of the time line (Ctrl + wheel)", NEARER),
      ),
    );
    view.addEventListener(
      "wheel",
      (event) => {
        if (!event.ctrlKey) return;
        event.preventDefault();
        bring(Math.exp(-pixelsOf(event) / PAGE), event.clientX);
      },
      { passive: false },
    );
  }
  // A click on a block says what it is, with a link to where more is known of it.
  const more = h("p.timeline-more", { role: "status", hidden: true });
  element.append(more);
  let shown: readonly Lane[] = [];

  function showMore(event: PointerEvent): void {
    const at = document.elementsFromPoint(event.clientX, event.clientY);
    const mark = at.find((one): one is HTMLElement => one.matches("[data-block]"));
    const [lane, number] = (mark?.dataset["block"] ?? "").split("/").map(Number);
    const block = mark ? shown[lane!]?.blocks[number!] : undefined;
    more.hidden = !block?.more;
    if (!block?.more) return;
    fill(more, `${block.title}. `, hasViews() ? h("a", { href: block.more.href }, block.more.text) : null);
  }

  let selection: Interval | null = null;
  let shownTime = 0;
  let ruled: Interval = [0, duration];
  /** Marks the visible part, and a window's width before and behind it. */
  function showRuler(): void {
    const shown = duration / nearness;
    const start = (view.scrollLeft / Math.max(area.clientWidth, 1)) * duration;
    ruled = [start - shown, start + 2 * shown];
    fill(
      ruler,
      niceTicks(duration, Math.round((options.small ? 6 : 12) * nearness), ...ruled).map((time) =>
        h("span", { style: { left: percent(time) } }, `${Number(time.toFixed(2))}`),
      ),
    );
  }
  showRuler();
  view.addEventListener("scroll", () => {
    const half = duration / nearness / 2;
    const start = (view.scrollLeft / Math.max(area.clientWidth, 1)) * duration;
    if (start - half < ruled[0] || start + 3 * half > ruled[1]) showRuler();
  });

  function showSelection(): void {
    chosen.hidden = selection === null;
    if (!selection) return;
    chosen.style.left = percent(selection[0]);
    chosen.style.width = `${((Math.min(selection[1], duration) - selection[0]) / duration) * 100}%`;
  }

  const timeOf = (event: PointerEvent): number => {
    const box = area.getBoundingClientRect();
    return (Math.min(Math.max(event.clientX - box.left, 0), box.width) / box.width) * duration;
  };

  let pressed: { x: number; anchor: number; dragging: boolean } | null = null;
  area.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    area.setPointerCapture(event.pointerId);
    pressed = { x: event.clientX, anchor: timeOf(event), dragging: false };
    if (selection && options.onSelect) {
      const grip = (GRIP / area.clientWidth) * duration;
      const [start, end] = selection;
      if (Math.abs(pressed.anchor - start) < grip) pressed = { ...pressed, anchor: end, dragging: true };
      else if (Math.abs(pressed.anchor - end) < grip) pressed = { ...pressed, anchor: start, dragging: true };
    }
  });
  area.addEventListener("pointermove", (event) => {
    if (!pressed) return;
    if (!options.onSelect) return options.onSeek(timeOf(event));
    if (Math.abs(event.clientX - pressed.x) > CLICK) pressed.dragging = true;
    if (!pressed.dragging) return;
    const now = timeOf(event);
    selection = [Math.min(now, pressed.anchor), Math.max(now, pressed.anchor)];
    showSelection();
  });
  area.addEventListener("pointerup", (event) => {
    if (!pressed) return;
    const { dragging } = pressed;
    pressed = null;
    if (dragging && selection && selection[1] > selection[0]) return options.onSelect?.(selection);
    if (selection) {
      selection = null;
      showSelection();
      options.onSelect?.(null);
    }
    options.onSeek(timeOf(event));
    showMore(event);
  });
  area.addEventListener("pointercancel", () => (pressed = null));

  return {
    element,
    setLanes(lanes: readonly Lane[]): void {
      shown = lanes.filter((lane) => lane.blocks.length > 0);
      const said = more.querySelector("a")?.getAttribute("href"); // stays if its block does
      more.hidden ||= !shown.some(({ blocks }) => blocks.some((one) => one.more?.href === said));
      fill(
        lanesBox,
        shown.map((lane, n) => laneElement(lane, n, percent, duration)),
      );
    },
    setTime(time: number): void {
      cursor.style.left = percent(time);
      if (nearness > 1) keepInSight(shownTime, time);
      shownTime = time;
    },
    /** The highlighted part: the interval that a question matched. */
    setLit(parts: readonly Interval[], likely: readonly boolean[]): void {
      fill(
        litLayer,
        parts.map(([start, end], i) =>
          h("div", {
            class: likely[i] ? "timeline-lit" : "timeline-lit unlikely",
            style: { left: percent(start), width: `${((end - start) / duration) * 100}%` },
          }),
        ),
      );
    },
    get selection() {
      return selection;
    },
    setSelection(next: Interval | null): void {
      selection = next;
      showSelection();
    },
  };
}

export type Timeline = ReturnType<typeof makeTimeline>;

function classOf(block: Block): string {
  const { faint, missing, colour } = block;
  const tinted = colour !== undefined && colour !== "transparent";
  return `block${faint ? " faint" : ""}${missing ? " missing" : ""}${tinted ? " tinted" : ""}`;
}

function laneElement(
  lane: Lane,
  number: number,
  percent: (time: number) => string,
  duration: number,
): HTMLElement {
  const rows = packRows(lane.blocks);
  const count = Math.max(...rows) + 1;
  const blocks = lane.blocks.map((block, i) =>
    h(
      "li",
      {
        class: classOf(block),
        title: block.title,
        "aria-label": block.title,
        ...(block.more ? { "data-block": `${number}/${i}` } : {}),
        style: {
          left: percent(block.start),
          width: `${((block.end - block.start) / duration) * 100}%`,
          top: `calc(${rows[i]} * var(--row))`,
          ...(block.colour ? { background: block.colour } : {}),
        },
      },
      h("span", block.label),
    ),
  );
  return h(
    "div",
    { class: `lane lane-${lane.kind}` },
    h("span.lane-name", lane.name),
    h("ul", { style: { height: `calc(${count} * var(--row))` }, "aria-label": lane.name }, blocks),
  );
}
