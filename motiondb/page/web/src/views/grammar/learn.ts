/** Choose captures and settings, and learn a grammar from them. */

import { choice, named, numberField, onSubmit } from "../../dom/fields.ts";
import { makeLatest } from "../../api/latest.ts";
import { get, isAbort, messageOf, post } from "../../api/client.ts";
import type { CaptureRow, JobReply } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { openDialog } from "../../parts/asking.ts";
import { plural, seconds } from "../../parts/text.ts";
import type { Context } from "../view.ts";

/** Captures that are listed at once, the longest first. */
const LISTED = 100;
/** Milliseconds after the last letter before the filter is sent. */
const PAUSE = 250;

interface Picker {
  readonly element: HTMLElement;
  readonly chosen: ReadonlyMap<string, number>;
}

/** A list of captures with boxes; what is chosen stays chosen while the list is filtered. */
function capturePicker(change: () => void): Picker {
  const chosen = new Map<string, number>();
  const list = h("ul.plain.capture-picker", { "aria-label": "Captures, the longest first" });
  const note = h("p.muted.small", { role: "status" });
  const filter = h("input.field.wide", {
    id: "grammar-where",
    placeholder: "performer=ana and action=dance",
    autocomplete: "off",
    on: { input: () => later() },
  });
  let timer = 0;
  const latest = makeLatest();

  function later(): void {
    clearTimeout(timer);
    timer = window.setTimeout(() => void load(), PAUSE);
  }

  function row(capture: CaptureRow): HTMLElement {
    const box = h("input", {
      type: "checkbox",
      checked: chosen.has(capture.name),
      on: {
        change: () => {
          if (box.checked) chosen.set(capture.name, capture.duration);
          else chosen.delete(capture.name);
          tell();
        },
      },
    });
    const words = capture.words.map((one) => one.words).join(", ");
    return h(
      "li",
      h(
        "label.check",
        box,
        h("span.pick-name", capture.name),
        h("span.muted.time", seconds(capture.duration)),
        h("span.muted.pick-words", words),
      ),
    );
  }

  function tell(): void {
    const whole = [...chosen.values()].reduce((sum, one) => sum + one, 0);
    note.textContent = chosen.size ? `${plural(chosen.size, "capture")} chosen, ${seconds(whole)}.` : "";
    change();
  }

  async function load(): Promise<void> {
    try {
      const parameters = { where: filter.value.trim(), sort: "-duration", limit: LISTED };
      const { captures, total } = await latest(get("/api/captures", parameters));
      const rows = captures.filter((one) => one.kind !== "generated");
      filter.removeAttribute("aria-invalid");
      fill(
        list,
        rows.map(row),
        total > captures.length
          ? h("li.muted.small", `${plural(total - captures.length, "more capture")}: filter to see them`)
          : null,
      );
      tell();
    } catch (fault) {
      if (isAbort(fault)) return;
      filter.setAttribute("aria-invalid", "true");
      note.textContent = messageOf(fault);
    }
  }

  void load();
  const element = h(
    "fieldset",
    h("legend", "Captures"),
    h("label.small", { for: "grammar-where" }, "Filter"),
    filter,
    list,
    note,
  );
  return { element, chosen };
}

function settings(learned: boolean) {
  const number = (id: string, value: number | null): HTMLInputElement =>
    numberField(id, 1, { max: 1000, ...(value === null ? { placeholder: "default" } : { value }) });
  const name = h("input.field", { id: "grammar-name", maxlength: 200, autocomplete: "off" });
  const kind = h(
    "select.field",
    {
      id: "grammar-terminals",
      on: { change: () => void (count.hidden = kind.value !== "count") },
    },
    h("option", { value: "default" }, "default number"),
    h("option", { value: "count" }, "this number:"),
    h("option", { value: "symbols", disabled: !learned }, "the motion symbols"),
  );
  const count = numberField("", 1, {
    max: 1000,
    value: 12,
    hidden: true,
    "aria-label": "Number of terminals",
  });
  const sentences = choice("grammar-sentences", [
    ["auto", "found in the strings"],
    ["captions", "between captions"],
    ["captures", "one for each capture"],
  ]);
  const shortest = number("grammar-shortest", 3);
  const longest = number("grammar-longest", 20);
  const seed = numberField("grammar-seed", 0, { value: 0 });
  return {
    rows: [
      named("Name", name),
      h("label", { for: kind.id }, "Terminals"),
      h("span.row", kind, count),
      named("Sentences", sentences),
      named("Shortest sentence", shortest),
      named("Longest sentence", longest),
      named("Seed", seed),
    ],
    body: () => ({
      name: name.value.trim() || null,
      terminals: kind.value === "count" ? count.valueAsNumber : null,
      from_symbols: kind.value === "symbols",
      sentences: sentences.value,
      shortest: shortest.valueAsNumber,
      longest: longest.valueAsNumber,
      seed: seed.valueAsNumber || 0,
    }),
  };
}

/** Ask for captures and settings, then start the job. */
export function openGrammarLearning(context: Context, started: (job: JobReply) => void): void {
  const submit = h("button.button", { type: "submit", disabled: true }, "Learn");
  const picker = capturePicker(() => void (submit.disabled = picker.chosen.size === 0));
  const chosen = settings(context.status().learned);
  const fault = h("p.bad.small", { role: "alert" });
  const form = h(
    "form.grammar-learning",
    h(
      "p.muted",
      "A few minutes of one activity give the best rules. A grammar of the same name is replaced.",
    ),
    picker.element,
    h("div.form-grid", chosen.rows),
    fault,
    h(
      "div.row.end",
      button("plain", "Cancel", () => dialog.close()),
      submit,
    ),
  );
  onSubmit(form, () => {
    post("/api/grammars", { captures: [...picker.chosen.keys()], ...chosen.body() }).then(
      (job) => {
        dialog.close();
        started(job);
      },
      (problem: unknown) => void (fault.textContent = messageOf(problem)),
    );
  });
  const dialog = openDialog("Learn a grammar", form);
}
