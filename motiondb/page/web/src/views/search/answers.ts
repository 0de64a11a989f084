/** The answers to a question side by side, and whether anything matches at all. */

import type { Motions } from "../../api/motions.ts";
import type { LikeReply, SearchReply, ShownMatch } from "../../api/types.ts";
import { fill, h } from "../../dom/element.ts";
import { emptyState } from "../../parts/states.ts";
import { plural } from "../../parts/text.ts";
import type { Stage } from "../../player/stage.ts";
import { makeAnswer, type AnswerCard } from "./answer.ts";
import type { Selection } from "./selection.ts";

type Answer = LikeReply | SearchReply;

export interface Answers {
  readonly element: HTMLElement;
  show(answer: Answer): void;
  clear(): void;
}

export function makeAnswers(
  context: { stage: Stage; motions: Motions },
  selection: Selection | null,
): Answers {
  const element = h("section", { class: "answers", "aria-label": "Answers" });
  let cards: AnswerCard[] = [];

  function clear(): void {
    cards.forEach((card) => card.close());
    cards = [];
    element.replaceChildren();
  }

  function verdict(answer: Answer): HTMLElement {
    const took = answer.took === null ? "" : ` in ${Math.max(Math.round(answer.took * 1000), 1)} ms`;
    if (answer.matches_anything === false) {
      return h(
        "div",
        { class: "verdict not-here", role: "status" },
        h("h2", {}, "Not in this database"),
        h(
          "p",
          {},
          answer.matches.length > 0
            ? "Nothing matches well enough. These are the nearest."
            : "Nothing is similar to it.",
        ),
      );
    }
    return h(
      "p",
      { class: "verdict muted", role: "status" },
      `${plural(answer.matches.length, "answer")}${took}`,
      answer.not_yet_learned > 0 ? ` · ${plural(answer.not_yet_learned, "capture")} not learned yet` : "",
    );
  }

  return {
    element,
    clear,
    show(answer) {
      clear();
      selection?.clear();
      if (answer.matches.length === 0 && answer.matches_anything !== false) {
        fill(element, emptyState("No answers", "No capture passes the filter."));
        return;
      }
      const matches = answer.matches_anything !== false;
      cards = answer.matches.map((match: ShownMatch) =>
        makeAnswer(context, match, {
          matches,
          scored:
            !("missing" in answer) ||
            (answer.missing.length === 0 && Object.keys(answer.by_meaning).length === 0),
          ...(selection
            ? { actions: { select: (one: ShownMatch, on: boolean) => selection.set(one, on) } }
            : {}),
        }),
      );
      selection?.onClear(() => cards.forEach((card) => card.setSelected(false)));
      fill(
        element,
        verdict(answer),
        h(
          "div",
          { class: "answer-grid" },
          cards.map((card) => card.element),
        ),
      );
    },
  };
}
