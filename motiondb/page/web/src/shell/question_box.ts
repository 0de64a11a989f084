/** The box in the head of every view: a question in words, or a file to search with. */

import { onSubmit } from "../dom/fields.ts";
import { h } from "../dom/element.ts";
import { icon } from "../dom/icons.ts";
import { fromList } from "../parts/dropping.ts";
import { searchByFile } from "../views/search/by_file.ts";
import type { Context } from "../views/view.ts";
import { go, parseRoute, routeTo } from "./router.ts";

export function makeQuestionBox(context: Context) {
  const box = h("input.question-box", {
    id: "question",
    type: "search",
    placeholder: "Ask for a movement",
    autocomplete: "off",
    "aria-label": "What to search for",
  });
  const file = h("input", {
    type: "file",
    hidden: true,
    "aria-label": "A file to search with",
    accept: [...context.status().accepts.captures, ...context.status().accepts.skeletons].join(","),
    multiple: true,
    on: {
      change: () => {
        void searchByFile(context, fromList(file.files));
        file.value = "";
      },
    },
  });
  const element = h(
    "form.question-form",
    { role: "search", "aria-label": "Ask" },
    icon("search"),
    box,
    file,
    h(
      "button.button.plain.by-example",
      {
        type: "button",
        "aria-label": "Search by example",
        title: "Search by example: choose a motion file",
        on: { click: () => file.click() },
      },
      icon("file"),
      h("span.by-example-text", "By example"),
    ),
    h("button.button", { type: "submit" }, "Search"),
  );
  let known = "";
  onSubmit(element, () => {
    const q = box.value.trim();
    known = q; // the address of it may be gone again before it is shown: somebody goes back
    if (!q) return go(routeTo("catalogue"));
    const { view, parameters } = parseRoute(location.hash, "");
    const kept = view === "search" ? ["where", "limit", "exact", "symbols", "path", "rhythm"] : [];
    go(routeTo("search", { q, ...Object.fromEntries(kept.map((name) => [name, parameters.get(name)])) }));
  });
  return {
    element,
    /** Show the question of the present address; "" where there is none. */
    show(question: string): void {
      if (question !== known) box.value = question; // what somebody is typing stays
      known = question;
    },
    focus(): void {
      box.focus();
      box.select();
    },
  };
}
