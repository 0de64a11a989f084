/** Ask for new names: one for a capture, or a pattern for several. */

import { named } from "../../dom/fields.ts";
import { h } from "../../dom/element.ts";
import { openForm } from "../../parts/asking.ts";
import { plural } from "../../parts/text.ts";

/** In a pattern: any letters. */
const ANY = "*";
/** Names that the dialog shows as examples. */
const SHOWN = 3;

/** What the server is asked for. */
export interface Renaming {
  old: string;
  new: string;
  captures?: string[];
}

/** A pattern that all names fit: the letters with which all begin, then any. */
export function commonPattern(names: readonly string[]): string {
  let common = names[0] ?? "";
  for (const name of names) while (!name.startsWith(common)) common = common.slice(0, -1);
  return common + ANY;
}

/** What patterns make of a name; null where it does not fit the old one. */
export function byPattern(name: string, old: string, fresh: string): string | null {
  const [before, after, ...rest] = old.split(ANY);
  const [head, tail, ...more] = fresh.split(ANY);
  if (after === undefined || tail === undefined || rest.length + more.length > 0) return null;
  const fits = name.startsWith(before!) && name.endsWith(after) && name.length >= old.length - 1;
  return fits ? head + name.slice(before!.length, name.length - after.length) + tail : null;
}

/** Open the dialog; it stays open where the captures cannot be renamed. */
export function askNames(names: readonly string[], run: (body: Renaming) => Promise<void>): void {
  const [only] = names;
  const several = names.length > 1;
  const pattern = several ? commonPattern(names) : only!;
  const field = (id: string): HTMLInputElement =>
    h("input.field.wide", { id, required: true, value: pattern, spellcheck: false });
  const [old, fresh] = [field("old-names"), field("new-names")];
  fresh.autofocus = true;
  const shown = h("p.small.muted", { role: "status" });

  function show(): void {
    if (!several) return;
    const fitting = names.flatMap((name) => {
      const next = byPattern(name, old.value.trim(), fresh.value.trim());
      return next === null ? [] : [`${name} → ${next}`];
    });
    const same = old.value.trim() === fresh.value.trim();
    const more = fitting.length > SHOWN ? `; … ${fitting.length} of ${names.length}` : "";
    shown.textContent = same
      ? "Change what all of them become."
      : fitting.length > 0
        ? fitting.slice(0, SHOWN).join("; ") + more
        : `None fits. Write ${ANY} once in both: it stands for any letters.`;
  }

  old.addEventListener("input", show);
  fresh.addEventListener("input", show);
  const content = [
    several
      ? [
          h("p.muted", `${plural(names.length, "capture")}. ${ANY} stands for any letters.`),
          named("Names like", old),
        ]
      : null,
    h("label", { for: "new-names" }, several ? "become" : `The new name of ${only}`),
    fresh,
    shown,
  ];
  openForm("Rename", content, "Rename", () => {
    const name = fresh.value.trim();
    return run(
      several ? { old: old.value.trim(), new: name, captures: [...names] } : { old: only!, new: name },
    );
  });
  show();
}
