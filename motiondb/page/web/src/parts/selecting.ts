/** Put captures, or parts of them, into a selection that the database keeps under a name. */

import { named } from "../dom/fields.ts";
import { get, post } from "../api/client.ts";
import type { CapturesChanged, Part } from "../api/types.ts";
import { button } from "../dom/button.ts";
import { fill, h } from "../dom/element.ts";
import type { Context } from "../views/view.ts";
import { openForm } from "./asking.ts";
import { plural } from "./text.ts";

/** Say that a selection was changed, with a way to undo it. */
export async function tellChanged(context: Context, text: string, changed: CapturesChanged): Promise<void> {
  const undo = async (): Promise<void> => {
    await post("/api/undo", {});
    context.notify("The last change of a selection is undone.");
    await context.refresh();
  };
  context.notify(text, changed.changed.length > 0 ? { label: "Undo", run: () => void undo() } : undefined);
  await context.refresh();
}

/** Ask for a selection, an old or a new one, and put `items` into it; `what` says what they are. */
export function askSelection(context: Context, items: readonly Part[], what: string): void {
  const name = h("input.field.wide", {
    id: "selection-name",
    required: true,
    maxlength: 100,
    placeholder: "fight day 2",
    autocomplete: "off",
  });
  const known = h("div.row.known-selections");
  const content = [h("p.muted", what), named("Name of the selection, an old or a new one", name), known];
  openForm("Add to a selection", content, "Add", async () => {
    const wanted = name.value.trim();
    const done = await post("/api/selection/add", { name: wanted, items });
    const count = done.changed.length;
    const text = count > 0 ? `Added to “${wanted}”.` : `“${wanted}” has all of it already.`;
    await tellChanged(context, text, done);
  });
  name.focus();
  void get("/api/selections")
    .then(({ selections }) => {
      fill(
        known,
        selections.map((one) =>
          button("plain", one.selection, () => void (name.value = one.selection), {
            title: plural(one.parts, "part"),
          }),
        ),
      );
    })
    .catch(() => undefined); // a name can be typed
}
