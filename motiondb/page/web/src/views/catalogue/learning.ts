/** Learn again, and say when that is worth it. */

import { post } from "../../api/client.ts";
import type { JobReply, Status } from "../../api/types.ts";
import { h } from "../../dom/element.ts";
import { openDialog } from "../../parts/asking.ts";
import { plural } from "../../parts/text.ts";
import type { Context } from "../view.ts";

/** Why the database should learn (again); null: there is no reason. */
export function reasonToLearn(status: Status): string | null {
  if (status.captures === 0) return null;
  if (!status.learned)
    return "This database has not learned yet. Learning finds the movements and the meanings of words; search, description and generation need it.";
  if (status.drift?.relearn)
    return `Learning again is worth it: ${status.drift.reasons.join("; ") || "the captures or words have changed"}.`;
  if (status.not_yet_learned) {
    return `${plural(status.not_yet_learned, "capture")} added since the last learning: ${status.not_yet_learned === 1 ? "it" : "they"} can be searched, but nothing was learned from ${status.not_yet_learned === 1 ? "it" : "them"}.`;
  }
  return null;
}

/** Ask for the settings, then start. */
export function openLearning(context: Context): void {
  const symbols = h("input", {
    type: "number",
    class: "number",
    id: "symbols",
    min: 2,
    max: 1000,
    step: 1,
    placeholder: "auto",
  });
  const seed = h("input", { type: "number", class: "number", id: "learn-seed", min: 0, step: 1, value: 0 });
  const form = h(
    "form",
    {},
    h(
      "p",
      {},
      `All ${plural(context.status().captures, "capture")} are cut into movements, and words are learned from the captions. The earlier result is replaced when learning is done, not before.`,
    ),
    h(
      "div",
      { class: "form-grid" },
      h("label", { for: "symbols" }, "Motion symbols"),
      symbols,
      h("label", { for: "learn-seed" }, "Seed"),
      seed,
    ),
    h("p", { class: "muted" }, "Without a number, the number of symbols is chosen from the data."),
    h(
      "div",
      { class: "row end" },
      h("button", { class: "button plain", type: "button", on: { click: () => dialog.close() } }, "Cancel"),
      h("button", { class: "button", type: "submit", autofocus: true }, "Learn"),
    ),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const body = { symbols: symbols.value ? symbols.valueAsNumber : null, seed: seed.valueAsNumber || 0 };
    post<JobReply>("/api/learn", body).then(() => dialog.close(), context.fail);
  });
  const dialog = openDialog("Learn", form);
}
