/** Learn again, and say when that is worth it. */

import { named, numberField } from "../../dom/fields.ts";
import { post } from "../../api/client.ts";
import type { Status } from "../../api/types.ts";
import { h } from "../../dom/element.ts";
import { openForm } from "../../parts/asking.ts";
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

/** What learning starts from, as it is asked for: what was used before, or what the captions allow. */
function usualStart(status: Status): string {
  const former = status.start?.name ?? "";
  if (status.starts.some(({ name }) => name === former)) return former;
  return status.captures_with_words > 0 ? "none" : (status.starts[0]?.name ?? "none");
}

/** Ask for the settings, then start. */
export function openLearning(context: Context): void {
  const status = context.status();
  const symbols = numberField("symbols", 2, { max: 1000, placeholder: "auto" });
  const seed = numberField("learn-seed", 0, { value: 0 });
  const usual = usualStart(status);
  const start = h(
    "select.field",
    { id: "learn-start", on: { change: () => showStart() } },
    h("option", { value: "none", selected: usual === "none" }, "these captions only"),
    status.starts.map(({ name, words, captions }) =>
      h(
        "option",
        { value: name, selected: usual === name },
        `${name}: ${words} words from ${captions} captures of others`,
      ),
    ),
  );
  const credit = h("p.small.muted");

  function showStart(): void {
    const chosen = status.starts.find(({ name }) => name === start.value);
    credit.textContent = chosen ? `${chosen.name}: ${chosen.credit}` : "";
    symbols.disabled = chosen !== undefined; // it brings its own
    if (symbols.disabled) symbols.value = "";
  }

  const described = status.captures_with_words;
  const content = [
    h(
      "p",
      `The motion of ${plural(status.captures, "capture")} is cut into movements. `,
      described > 0
        ? `Words are learned from the captions of ${plural(described, "capture")}. `
        : "Nobody has written about them yet, so the words must come from the captions of others. ",
      status.learned ? "What was learned before is replaced when this is done, not earlier." : null,
    ),
    h("div.form-grid", named("Learn from", start)),
    credit,
    h(
      "details",
      h("summary", "Settings"),
      h("div.form-grid", named("Number of movements", symbols), named("Seed", seed)),
      h(
        "p.small.muted",
        "Without a number, it is chosen from the data. The same seed gives the same result.",
      ),
    ),
  ];
  showStart();
  openForm("Learn", content, "Learn", () =>
    post("/api/learn", {
      symbols: symbols.value ? symbols.valueAsNumber : null,
      seed: seed.valueAsNumber || 0,
      start: start.value,
    }),
  );
}
