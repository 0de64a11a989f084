/** Ask for the words of a part that was dragged on the timeline. */

import { h } from "../../dom/element.ts";
import { interval } from "../../parts/text.ts";
import { openDialog } from "../../parts/asking.ts";
import type { Interval } from "../../timeline/timeline.ts";

export function askWords(capture: string, part: Interval, save: (words: string) => Promise<unknown>): void {
  const input = h("input", {
    class: "field wide",
    id: "part-words",
    required: true,
    autofocus: true,
    placeholder: "turns left",
  });
  const form = h(
    "form",
    {
      on: {
        submit: (event) => {
          event.preventDefault();
          void save(input.value.trim()).then((saved) => saved && dialog.close());
        },
      },
    },
    h("p", { class: "muted" }, `${capture}, ${interval(part[0], part[1])}`),
    h("label", { for: "part-words" }, "What happens in this part?"),
    input,
    h(
      "div",
      { class: "row end" },
      h("button", { class: "button plain", type: "button", on: { click: () => dialog.close() } }, "Cancel"),
      h("button", { class: "button", type: "submit" }, "Save words"),
    ),
  );
  const dialog = openDialog("Words of a part", form);
}
