/** What a newcomer sees above the catalogue: what this is, and questions that find something. */

import { get } from "../../api/client.ts";
import type { ExamplesReply } from "../../api/types.ts";
import { fill, h } from "../../dom/element.ts";
import { routeTo } from "../../shell/router.ts";
import type { Context } from "../view.ts";

/**
 * Questions to begin with, and what is known of them: they find something here, or their words are
 * in the captions, or they were learned from captures of others.
 */
export async function offeredQuestions(
  context: Context,
): Promise<{ lead: string; questions: readonly string[] }> {
  const { examples, words } = await get<ExamplesReply>("/api/examples");
  if (examples.length > 0)
    return { lead: "Found here, for example", questions: examples.map((one) => one.question) };
  const own = context.status().captures_with_words > 0;
  return { lead: own ? "Words of its captions" : "Words that it knows", questions: words };
}

export interface Welcome {
  readonly element: HTMLElement;
  /** Show the questions of this revision of the database. */
  load(): void;
}

export function makeWelcome(context: Context): Welcome {
  const awaited = context.status().learned ? " awaited" : "";
  const examples = h("div", { class: `chips examples${awaited}` });
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
      offeredQuestions(context).then(
        ({ lead, questions: offered }) => {
          examples.classList.toggle("awaited", offered.length > 0);
          fill(
            examples,
            offered.length === 0 ? null : h("span", { class: "chips-lead" }, lead),
            offered.map((q) => h("a", { class: "chip", href: routeTo("search", { q }) }, q)),
          );
        },
        () => examples.classList.remove("awaited"), // the box is there without them
      );
    },
  };
}
