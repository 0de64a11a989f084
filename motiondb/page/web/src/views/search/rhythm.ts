/** A rhythm: tapped with a button or its keys, or written as times in seconds. */

import { button } from "../../dom/button.ts";
import { fill, h, svg } from "../../dom/element.ts";
import { plural } from "../../parts/text.ts";

export interface RhythmField {
  readonly element: HTMLElement;
  /** Times of the taps as the server reads them, "0 0.5 1"; "" where nothing is tapped. */
  value: string;
  /** Stop what is replayed, and ask no more. */
  close(): void;
}

/** Seconds: two taps that are nearer are one; a rhythm ends after so long without a tap. */
const APART = 0.1;
const PAUSE = 1.5;
/** Fewest taps of a rhythm. */
export const FEWEST = 3;

/** The taps with one more, seconds of any clock: a tap after a pause begins anew. */
export function tapped(taps: readonly number[], at: number): readonly number[] {
  const last = taps.at(-1);
  if (last === undefined || at - last > PAUSE) return [at];
  return at - last < APART ? taps : [...taps, at];
}

/** The times of taps as text, from the first one on. */
export const textOf = (taps: readonly number[]): string =>
  taps.map((at) => Number((at - taps[0]!).toFixed(2))).join(" ");

/** The times of a text, ascending; none if it holds anything else. */
export function timesOf(text: string): number[] {
  const times = text
    .trim()
    .split(/[\s,]+/)
    .filter(Boolean)
    .map(Number);
  return times.every((at, n) => Number.isFinite(at) && (n === 0 || at > times[n - 1]!)) ? times : [];
}

/** What a rhythm is in words: "4 taps, 2.0 a second". */
function said(times: readonly number[]): string {
  if (times.length < 2) return times.length === 1 ? "1 tap" : "";
  const rate = (times.length - 1) / (times.at(-1)! - times[0]!);
  const more = times.length < FEWEST ? `, ${FEWEST - times.length} more to search` : "";
  return `${plural(times.length, "tap")}, ${rate.toFixed(1)} a second${more}`;
}

/** A pad to tap on, its taps as marks, and their times as text; `ended` follows a whole rhythm. */
export function makeRhythmField(id: string, ended: () => void): RhythmField {
  let taps: readonly number[] = [];
  let waiting: ReturnType<typeof setTimeout> | undefined;
  let replaying: ReturnType<typeof setTimeout> | undefined;
  const text = h("input.field", {
    id,
    placeholder: "0 0.5 1 1.5",
    spellcheck: false,
    on: { input: () => show() },
  });
  const marks = svg("g");
  const dot = svg("circle.tap-dot", { cy: 12, r: 4 });
  const strip = svg(
    "svg.tap-strip",
    { viewBox: "0 0 240 24", "aria-hidden": "true" },
    svg("line.path-grid.tap-line", { x1: 8, x2: 232, y1: 12, y2: 12 }),
    marks,
    dot,
  );
  const pad = h("button.button.plain.tap-pad", { type: "button", "aria-describedby": `${id}-hint` }, "Tap");
  const replayButton = button("plain", "Replay", () => (replaying === undefined ? replay() : stop()));
  const clearButton = button("plain", "Clear", () => {
    end();
    text.value = "";
    show();
    pad.focus();
  });
  const told = h("span.muted.small", { role: "status" });

  const placeOf = (at: number, times: readonly number[]): number =>
    8 + (224 * (at - times[0]!)) / Math.max(times.at(-1)! - times[0]!, PAUSE);

  /** Show the times of the text; the words for them only when `whole`, so that they do not chatter. */
  function show(whole = true): void {
    const times = timesOf(text.value);
    stop();
    fill(
      marks,
      times.map((at) =>
        svg("line.path-line.tap-mark", {
          x1: placeOf(at, times),
          x2: placeOf(at, times),
          y1: 3,
          y2: 21,
        }),
      ),
    );
    replayButton.disabled = times.length < 2;
    clearButton.disabled = text.value === "";
    if (whole) told.textContent = said(times);
  }

  function stop(): void {
    clearTimeout(replaying);
    replaying = undefined;
    dot.classList.remove("on");
    replayButton.textContent = "Replay";
  }

  /** A dot jumps from tap to tap at their times, again and again. */
  function replay(): void {
    const times = timesOf(text.value);
    if (times.length < 2) return;
    const mean = (times.at(-1)! - times[0]!) / (times.length - 1);
    replayButton.textContent = "Stop";
    const on = (n: number): void => {
      dot.setAttribute("cx", String(placeOf(times[n]!, times)));
      dot.classList.toggle("on", n >= 0);
      const next = (n + 1) % times.length;
      replaying = setTimeout(() => on(next), 1000 * (next ? times[next]! - times[n]! : mean));
    };
    on(0);
  }

  function end(): void {
    clearTimeout(waiting);
    taps = [];
  }

  function tap(event: Event): void {
    taps = tapped(taps, event.timeStamp / 1000);
    text.value = textOf(taps);
    show(false);
    clearTimeout(waiting);
    waiting = setTimeout(() => {
      const enough = taps.length >= FEWEST;
      end();
      show();
      if (enough) ended();
    }, 1000 * PAUSE);
  }

  pad.addEventListener("pointerdown", (event) => {
    if (event.button === 0) tap(event);
  });
  pad.addEventListener("keydown", (event) => {
    const typed = event.key.length === 1 || event.key === "Enter"; // not Tab, and no shortcut
    if (!typed || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault(); // and so no click either
    event.stopPropagation();
    if (!event.repeat) tap(event);
  });
  pad.addEventListener("keyup", (event) => {
    if (event.key === " ") event.preventDefault(); // Firefox clicks then
  });
  pad.addEventListener("click", (event) => {
    if (event.detail === 0) tap(event); // of a screen reader
  });
  show();
  return {
    element: h(
      "div.path-field",
      pad,
      strip,
      h("div.tap-tools", replayButton, clearButton, told),
      text,
      h(
        "p.muted.small",
        { id: `${id}-hint` },
        "Three or more taps where the feet should land: press it, or the space bar while it has the focus. After a pause it is searched; the next tap begins anew.",
      ),
    ),
    get value() {
      return text.value.trim();
    },
    set value(times) {
      if (times === text.value.trim() || taps.length > 0) return;
      text.value = times;
      show();
    },
    close() {
      end();
      stop();
    },
  };
}
