/** What a newcomer sees above the catalogue: what this is, and questions that find something. */

import { get } from "../../api/client.ts";
import type { ExamplesReply } from "../../api/types.ts";
import { fill, h } from "../../dom/element.ts";
import { routeTo } from "../../shell/router.ts";
import type { Context } from "../view.ts";

export interface Welcome {
  readonly element: HTMLElement;
  /** Show the questions of this revision of the database. */
  load(): void;
}

export function makeWelcome(context: Context): Welcome {
  const examples = h("div", { class: "chips examples" });
  const element = h(
    "section",
    { class: "welcome", "aria-label": "About" },
    h(
      "p",
      { class: "welcome-text" },
      h("b", {}, "A library of human motion that you can ask."),
      " Write what somebody does, or choose a motion file: the answers play, and say how certain they are.",
    ),
    examples,
  );
  let asked = -1;

  return {
    element,
    load() {
      const { learned, revision } = context.status();
      if (!learned || revision === asked) return;
      asked = revision;
      get<ExamplesReply>("/api/examples").then(
        ({ examples: found, words }) => {
          const proven = found.map((one) => one.question);
          const offered = proven.length > 0 ? proven : words;
          fill(
            examples,
            offered.length === 0
              ? null
              : h(
                  "span",
                  { class: "chips-lead" },
                  proven.length > 0 ? "Found here, for example" : "Words of its captions",
                ),
            offered.map((q) => h("a", { class: "chip", href: routeTo("search", { q }) }, q)),
          );
        },
        () => undefined, // the box is there without them
      );
    },
  };
}
