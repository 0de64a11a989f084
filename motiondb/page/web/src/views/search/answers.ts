/** The answers to a question side by side, and whether anything matches at all. */

import type { Motions } from "../../api/motions.ts";
import type { LikeReply, SearchReply, ShownMatch } from "../../api/types.ts";
import { fill, h, type Child } from "../../dom/element.ts";
import { emptyState } from "../../parts/states.ts";
import { land } from "../../dom/flights.ts";
import { plural } from "../../parts/text.ts";
import type { Stage } from "../../player/stage.ts";
import { makeAnswer, type AnswerCard } from "./answer.ts";
import { certaintyOf, FLOOR, NOTHING_REPLACED, replacedWords, type Grade } from "./certainty.ts";
import type { Selection } from "./selection.ts";

type Answer = LikeReply | SearchReply;

/** The groups of answers, from the top to the bottom. */
const GROUPS: readonly (readonly Grade[])[] = [["likely", "unmeasured"], ["unlikely"], ["folded"]];

export function makeAnswers(context: { stage: Stage; motions: Motions }, selection: Selection | null) {
  const element = h("section.answers", { "aria-label": "Answers" });
  let cards: AnswerCard[] = [];

  function clear(): void {
    cards.forEach((card) => card.close());
    cards = [];
    element.replaceChildren();
  }

  function verdict(answer: Answer, among: boolean): HTMLElement {
    const grades = answer.matches.map((match) => certaintyOf(match).grade);
    const likely = grades.filter((grade) => grade === "likely").length;
    const none = answer.matches_anything === false;
    if (none || (grades.length > 0 && grades.every((grade) => grade === "unlikely" || grade === "folded"))) {
      return h(
        "div.verdict.not-here",
        { role: "status" },
        h("h2", none ? (among ? "Not among these captures" : "Not in this database") : "No likely answer"),
        h(
          "p",
          answer.matches.length === 0
            ? "Nothing is similar to it."
            : none
              ? "Nothing matches well enough. These are the nearest."
              : "Every answer is more likely wrong than right. These are the nearest.",
        ),
      );
    }
    return h(
      "p.verdict.muted",
      { role: "status" },
      likely > 0 ? plural(likely, "likely answer") : plural(answer.matches.length, "answer"),
      answer.not_yet_learned > 0 ? ` · ${plural(answer.not_yet_learned, "capture")} not learned yet` : "",
    );
  }

  /** The cards by how likely they are: those below the floor are folded. */
  function groups(): Child {
    const [main, unlikely, folded] = GROUPS.map((grades) =>
      cards.filter((card) => grades.includes(card.grade)).map((card) => card.element),
    ) as [HTMLElement[], HTMLElement[], HTMLElement[]];
    return [
      main.length > 0 ? h("div.answer-grid", main) : null,
      unlikely.length > 0
        ? [main.length > 0 ? h("h2.group-head", "Unlikely") : null, h("div.answer-grid.smaller", unlikely)]
        : null,
      folded.length > 0
        ? h(
            "details.folded",
            h(
              "summary",
              main.length + unlikely.length > 0
                ? `${folded.length} more, ${folded.length > 1 ? "all " : ""}below ${FLOOR}`
                : `Show the nearest: ${plural(folded.length, "answer")} below ${FLOOR}`,
            ),
            h("div.answer-grid.smaller", folded),
          )
        : null,
    ];
  }

  /** Cards without content, while there are none with. */
  function wait(): void {
    if (cards.length > 0) return;
    const empty = Array.from({ length: 8 }, () =>
      h(
        "div.skeleton",
        { "aria-hidden": "true" },
        h("div.skeleton-picture"),
        h("div.skeleton-line"),
        h("div.skeleton-line.short"),
      ),
    );
    fill(element, h("div.answer-grid", empty));
  }

  return {
    element,
    clear,
    /** Show that there will be answers, while there are none. */
    wait,
    /** `among`: not the whole database was asked, but the captures of a filter. */
    show(answer: Answer, among = false): void {
      clear();
      selection?.clear();
      if (answer.matches.length === 0 && answer.matches_anything !== false) {
        fill(element, emptyState("No answers", "No capture passes the filter."));
        return;
      }
      const replaced = "taken" in answer ? replacedWords(answer) : NOTHING_REPLACED;
      // The groups are read one after the other: their answers are numbered as they stand.
      const sure = (match: ShownMatch): number => certaintyOf(match).value ?? -1;
      const ordered = GROUPS.flatMap((grades) =>
        answer.matches
          .filter((match) => grades.includes(certaintyOf(match).grade))
          .sort((a, b) => sure(b) - sure(a)),
      );
      cards = ordered.map((match: ShownMatch, i) =>
        makeAnswer(
          context,
          { ...match, rank: i + 1 },
          {
            replaced,
            measured: "measured" in answer ? answer.measured : [],
            scored:
              !("missing" in answer) ||
              (answer.missing.length === 0 && Object.keys(answer.by_meaning).length === 0),
            ...(selection
              ? { actions: { select: (one: ShownMatch, on: boolean) => selection.set(one, on) } }
              : {}),
          },
        ),
      );
      selection?.onClear(() => cards.forEach((card) => card.setSelected(false)));
      fill(element, verdict(answer, among), groups());
      land(ordered.map((match, i) => [match.capture, cards[i]!.element]));
    },
  };
}

export type Answers = ReturnType<typeof makeAnswers>;
