/** Ask for the name under which something generated is kept as a capture. */

import { h } from "../dom/element.ts";
import { openDialog } from "./asking.ts";

/** Open the dialog; it closes when `keep` succeeds, and stays open when it fails. */
export function askToKeep(
  title: string,
  suggested: string,
  keep: (name: string) => Promise<void>,
  fail: (fault: unknown) => void,
): void {
  const input = h("input", { class: "field wide", id: "kept-name", required: true, value: suggested });
  const form = h(
    "form",
    {},
    h("label", { for: "kept-name" }, "Name of the capture"),
    input,
    h(
      "p",
      { class: "muted" },
      "It is marked as generated: it can be searched and exported, but nothing learns from it.",
    ),
    h("div", { class: "row end" }, h("button", { class: "button", type: "submit" }, "Keep")),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    keep(input.value.trim()).then(() => dialog.close(), fail);
  });
  const dialog = openDialog(title, form);
  input.select();
}

/** A name for a generated capture: the words, without signs, and the seed. */
export function suggestedName(words: string, seed: number): string {
  const plain = words.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "_");
  return `new/${plain.slice(0, 40)}_${seed}`;
}
