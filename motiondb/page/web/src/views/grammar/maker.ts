/** Make a sequence of a grammar: seed, length, or a pattern that it must match. */

import { named, numberField, onSubmit } from "../../dom/fields.ts";
import { button } from "../../dom/button.ts";
import { h } from "../../dom/element.ts";
import type { Wish } from "./selection.ts";

export function makeMaker(make: (wish: Wish) => void) {
  const seed = numberField("sequence-seed", 0, { value: 0 });
  const length = numberField("sequence-length", 1, { max: 200, placeholder: "any" });
  const like = h("input.field", {
    id: "sequence-like",
    placeholder: "a ... catch ? b",
    autocomplete: "off",
    title: "Terminals and words in their order, ? for any one terminal, ... for any number of them",
  });
  const submit = h("button.button", { type: "submit" }, "Make a sequence");
  const next = button(
    "plain",
    "Next seed",
    () => {
      seed.value = String((seed.valueAsNumber || 0) + 1);
      element.requestSubmit();
    },
    { title: "Make a sequence with the next seed" },
  );
  const element = h(
    "form.row.settings.maker",
    h("span.maker-field", named("Seed", seed)),
    h("span.maker-field", named("Terminals", length)),
    h("span.maker-field", named("Like", like)),
    submit,
    next,
  );
  const fields = [seed, length, like];
  let known = fields.map((field) => field.value);
  onSubmit(element, () => {
    known = fields.map((field) => field.value);
    make({
      seed: seed.valueAsNumber || 0,
      length: length.value ? length.valueAsNumber : null,
      like: like.value.trim() || null,
    });
  });
  return {
    element,
    show(wish: Wish): void {
      const values = [String(wish.seed), String(wish.length ?? ""), wish.like ?? ""];
      // What somebody types while a sequence is made stays: only what is new is shown.
      fields.forEach((field, k) => {
        if (values[k] !== known[k]) field.value = values[k] ?? "";
      });
      known = values;
    },
    busy(busy: boolean): void {
      submit.disabled = busy;
      next.disabled = busy;
      submit.textContent = busy ? "Making…" : "Make a sequence";
    },
  };
}
