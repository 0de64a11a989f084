/** The answers of a file without a server, shown with the same parts as in the page. */

import type { Motions } from "../api/motions.ts";
import type {
  CaptureFacts,
  GenerateAnswer,
  LikeAnswer,
  SearchAnswer,
  Source,
  Stretch,
} from "../api/types.ts";
import { append, h } from "../dom/element.ts";
import type { Stage } from "../player/stage.ts";
import { makeTake } from "../take/take.ts";
import { stretchLane, type Lane } from "../timeline/lanes.ts";
import { lanesOf } from "../views/catalogue/details.ts";
import { makeAnswers } from "../views/search/answers.ts";
import { questionElement } from "../views/search/question.ts";
import { makeVariant } from "../views/generate/variant.ts";
import type { Embedded } from "./embedded.ts";

export interface EmbeddedContext {
  readonly stage: Stage;
  readonly motions: Motions;
  readonly data: Embedded;
}

interface SequenceFacts {
  ref: string;
  string: string[];
  strip: { terminal: string; start: number; end: number; words: string[] }[];
  sources: Source[];
  stretches: Stretch[];
}

interface SceneFacts {
  ref: string;
  actions: Record<string, { terminal: string; start: number; end: number }[]>;
  text: string;
}

/** Show the answer that a file holds. */
export function renderAnswer(host: HTMLElement, context: EmbeddedContext): void {
  const { kind, answer } = context.data;
  if (kind === "search") return renderSearch(host, context, answer as SearchAnswer);
  if (kind === "like") return renderLike(host, context, answer as LikeAnswer);
  if (kind === "generate") return renderGenerated(host, context, answer as GenerateAnswer);
  if (kind === "capture") {
    const facts = answer as CaptureFacts;
    return renderTake(host, context, facts.ref, lanesOf(facts), [
      {
        capture: facts.name,
        licence: facts.licence ?? "not known",
        sha256: facts.sha256,
        frames: facts.frames,
      },
    ]);
  }
  if (kind === "sequence") {
    const facts = answer as SequenceFacts;
    return renderTake(host, context, facts.ref, sequenceLanes(facts), facts.sources);
  }
  const facts = answer as SceneFacts;
  renderTake(host, context, facts.ref, sceneLanes(facts), []);
  append(host, [
    h("details", {}, h("summary", {}, "The diagram as text"), h("pre", { tabindex: 0 }, facts.text)),
  ]);
}

function renderSearch(host: HTMLElement, context: EmbeddedContext, answer: SearchAnswer): void {
  const answers = makeAnswers(context, null);
  append(host, [
    questionElement(
      answer.question,
      [...answer.sentences, ...answer.sources],
      answer.unknown,
      {},
      () => undefined,
    ),
    answers.element,
  ]);
  answers.show(answer);
}

function renderLike(host: HTMLElement, context: EmbeddedContext, answer: LikeAnswer): void {
  const example = "example" in context.data.motions ? "example" : answer.ref;
  if (example in context.data.motions) renderTake(host, context, example, [], []);
  const answers = makeAnswers(context, null);
  append(host, [answers.element]);
  answers.show(answer);
}

function renderGenerated(host: HTMLElement, context: EmbeddedContext, answer: GenerateAnswer): void {
  append(host, [
    questionElement(answer.question, answer.sentences, answer.unknown, {}, () => undefined),
    h(
      "div",
      { class: "answer-grid wide" },
      answer.variants.map((made) => makeVariant(context, made, null).element),
    ),
  ]);
}

function renderTake(
  host: HTMLElement,
  context: EmbeddedContext,
  ref: string,
  lanes: readonly Lane[],
  sources: readonly Source[],
): void {
  const take = makeTake(context, { label: context.data.title });
  append(host, [
    take.element,
    sources.length > 0
      ? h(
          "section",
          {},
          h("h2", {}, "Sources and licences"),
          h(
            "ul",
            { class: "plain" },
            sources.map((one) =>
              h(
                "li",
                {},
                one.capture,
                h("span", { class: "muted" }, ` ${one.frames} frames, licence ${one.licence}`),
              ),
            ),
          ),
        )
      : null,
  ]);
  void take.load({ ref, lanes });
}

function sequenceLanes(facts: SequenceFacts): Lane[] {
  const blocks = facts.strip.map(({ terminal, start, end, words }) => ({
    start,
    end,
    label: words.length > 0 ? `${terminal} ${words.join(" ")}` : terminal,
    title: `terminal ${terminal}: ${words.join(" ")}`,
  }));
  return [{ name: "terminals", kind: "parts", blocks }, stretchLane(facts.stretches)];
}

function sceneLanes(facts: SceneFacts): Lane[] {
  return Object.entries(facts.actions).map(([player, actions]) => ({
    name: player,
    kind: "parts" as const,
    blocks: actions.map(({ terminal, start, end }) => ({
      start,
      end,
      label: terminal,
      title: `${player}: ${terminal}, ${start.toFixed(2)} to ${end.toFixed(2)} s`,
    })),
  }));
}
