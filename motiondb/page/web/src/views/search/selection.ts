/** Answers that were selected, and the bar that downloads them. */

import type { Part, ShownMatch } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { h } from "../../dom/element.ts";
import { download, downloadButtons, type FileFormat } from "../../parts/download.ts";
import { askSelection } from "../../parts/selecting.ts";
import { plural } from "../../parts/text.ts";
import { go } from "../../shell/router.ts";
import type { Context } from "../view.ts";
import { addressWith, compareAddress, MOST } from "../compare/address.ts";

export function makeSelection(context: Context) {
  const chosen = new Map<string, ShownMatch>();
  let cleared: () => void = () => undefined;
  const count = h("span", { role: "status" });
  const whole = h("input", { type: "checkbox", id: "whole-takes" });
  const compareButton = button("main", "Compare", () => compare());
  const element = h(
    "div.selection-bar",
    { role: "region", "aria-label": "Selected answers", hidden: true },
    count,
    compareButton,
    context.status().read_only
      ? null
      : button("plain", "Add to a selection…", () =>
          askSelection(context, items(), plural(chosen.size, "answer")),
        ),
    downloadButtons(context.status().writes, (format) => void save(format), false),
    h("label.check", { for: "whole-takes" }, whole, "whole takes"),
    button("link", "Clear", () => {
      cleared();
      clear();
    }),
  );

  const items = (): Part[] =>
    [...chosen.values()].map(({ ref, start, end }) => (whole.checked ? { ref } : { ref, start, end }));

  async function save(format: FileFormat): Promise<void> {
    await download(items(), format);
  }

  /** Compare the selected answers; one alone is added to the last comparison. */
  function compare(): void {
    const parts = [...chosen.values()].map(({ ref, start, end }) => ({ ref, start, end }));
    go(parts.length > 1 ? compareAddress(parts) : addressWith(parts));
  }

  function show(): void {
    element.hidden = chosen.size === 0;
    compareButton.disabled = chosen.size > MOST;
    compareButton.title = compareButton.disabled
      ? `At most ${MOST} motions can be compared.`
      : chosen.size === 1
        ? "Add this answer to the last comparison"
        : "Play them on one clock and one ground";
    count.textContent = `${plural(chosen.size, "answer")} selected`;
  }

  function clear(): void {
    chosen.clear();
    show();
  }

  return {
    element,
    set(match: ShownMatch, selected: boolean): void {
      const key = `${match.ref} ${match.start} ${match.end}`;
      if (selected) chosen.set(key, match);
      else chosen.delete(key);
      show();
    },
    clear,
    onClear: (listener: () => void) => void (cleared = listener),
  };
}

export type Selection = ReturnType<typeof makeSelection>;
