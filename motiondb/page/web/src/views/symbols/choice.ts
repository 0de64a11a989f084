/** The part of the library that is worth training on: a share, and what it covers of the map. */

import { named } from "../../dom/fields.ts";
import { makeLatest } from "../../api/latest.ts";
import { get, isAbort, messageOf } from "../../api/client.ts";
import type { ChoiceReply } from "../../api/types.ts";
import { h } from "../../dom/element.ts";
import { plural } from "../../parts/text.ts";

/** What is said of a choice. */
export function choiceText({ choice, symbols }: ChoiceReply): string {
  const { chosen, seconds, intervals, distance, bound } = choice;
  return (
    `${Math.round(chosen)} of ${Math.round(seconds)} s, ${plural(intervals, "interval")} of ` +
    `${plural(symbols.length, "symbol")}: mean distance to the choice ${distance.toFixed(3)}, none as long ` +
    `can be under ${bound.toFixed(3)}`
  );
}

/** Make the slider; `show` is told what was chosen. */
export function makeChoice(show: (reply: ChoiceReply) => void): { readonly element: HTMLElement } {
  const said = h("output.muted.small", { role: "status" });
  const percent = h("span", "3 %");
  const slider = h("input", {
    id: "train-share",
    type: "range",
    min: 1,
    max: 30,
    value: 3,
    on: {
      input: () => void (percent.textContent = `${slider.value} %`),
      change: () => void choose(),
    },
  });
  const element = h(
    "div.row",
    { role: "group", "aria-label": "What to train on" },
    named("To train on", slider),
    percent,
    said,
  );
  const latest = makeLatest();

  async function choose(): Promise<void> {
    said.textContent = "Choosing…";
    try {
      const reply = await latest(get("/api/choice", { share: Number(slider.value) / 100 }));
      said.textContent = choiceText(reply);
      show(reply);
    } catch (fault) {
      if (!isAbort(fault)) said.textContent = messageOf(fault);
    }
  }

  return { element };
}
