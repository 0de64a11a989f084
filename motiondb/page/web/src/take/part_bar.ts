/** The times of a selected part, as numbers that can be typed, and actions for the part. */

import { button } from "../dom/button.ts";
import { h, type Child } from "../dom/element.ts";
import { icon } from "../dom/icons.ts";
import type { Interval } from "../timeline/timeline.ts";

/** Shortest part that can be typed, seconds: about three frames. */
const SHORTEST = 0.1;

export function makePartBar(
  actions: readonly { label: string; run: (part: Interval) => void }[],
  change: (part: Interval | null) => void,
  more: Child = null,
) {
  let part: Interval | null = null;
  let whole = 0;
  const from = number("Start of the part, seconds");
  const to = number("End of the part, seconds");

  function number(label: string): HTMLInputElement {
    return h("input.number", {
      type: "number",
      step: 0.05,
      min: 0,
      "aria-label": label,
      on: { change: () => typed() },
    });
  }

  function typed(): void {
    const start = Math.min(Math.max(from.valueAsNumber || 0, 0), Math.max(whole - SHORTEST, 0));
    const end = Math.min(Math.max(to.valueAsNumber || 0, start + SHORTEST), whole);
    change([start, end]);
  }

  const hint = h(
    "p.hint",
    "Drag on the timeline to select a part, or ",
    button("link", "type its times", () => change([0, Math.min(1, whole)])),
    ".",
  );
  const fields = h(
    "div.part-fields",
    { hidden: true },
    h("span.part-times", "Part ", from, " to ", to, " s"),
    actions.map(({ label, run }) => button("plain", label, () => part && run(part))),
    more,
    button("tool", icon("close"), () => change(null), {
      "aria-label": "Clear the part",
      title: "Clear the part",
    }),
  );
  return {
    element: h("div.part-bar", hint, fields),
    show(next: Interval | null, duration: number): void {
      part = next;
      whole = duration;
      hint.hidden = next !== null;
      fields.hidden = next === null;
      if (!next) return;
      from.max = to.max = String(duration);
      from.value = next[0].toFixed(2);
      to.value = next[1].toFixed(2);
    },
  };
}
