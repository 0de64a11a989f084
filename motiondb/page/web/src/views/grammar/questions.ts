/** Questions to a person: whether a terminal can come straight after another, as moving pictures. */

import { named } from "../../dom/fields.ts";
import { get, messageOf, post } from "../../api/client.ts";
import type { AnswerReply, GrammarQuestion } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { interval } from "../../parts/text.ts";
import { makeClip, type Clip } from "../../take/clip.ts";
import type { Context } from "../view.ts";

const ANSWERS = [
  ["yes", "Yes"],
  ["no", "No"],
  ["unknown", "Do not know"],
] as const;

const nameOf = (terminal: string, words: string): string => (words ? `${terminal} (${words})` : terminal);

export function makeQuestions(context: Context) {
  let grammar = "";
  let run = -1;
  let clips: Clip[] = [];
  const author = h("input.field", { id: "answer-author", maxlength: 80, autocomplete: "name" });
  const cards = h("div.questions", { "aria-live": "polite" });
  const begin = button("plain", "Show ten questions", () => void load());
  const element = h(
    "section.grammar-questions",
    { "aria-label": "Questions to you" },
    h("h3", "Questions to you"),
    h(
      "p.muted.small",
      "Can the second movement come straight after the first? Your answers are kept with your name. ",
      "The grammar keeps to them when it is learned again under its name.",
    ),
    h("div.row", named("Your name", author), begin),
    cards,
  );

  function clear(): void {
    clips.forEach((clip) => clip.close());
    clips = [];
    fill(cards);
  }

  async function load(): Promise<void> {
    const [asked, version] = [grammar, run];
    const isStill = (): boolean => asked === grammar && version === run;
    clear();
    begin.disabled = true;
    fill(cards, h("p.muted", "Looking for the pairs that say most…"));
    try {
      const { questions } = await get("/api/grammar/questions", { name: asked });
      if (!isStill()) return;
      const none = h("p.muted", "No pair is left whose answer would change the rules.");
      fill(cards, questions.length ? questions.map(card) : none);
    } catch (fault) {
      if (isStill()) fill(cards, h("p.bad", { role: "alert" }, messageOf(fault)));
    } finally {
      begin.disabled = false;
    }
  }

  function moving(shown: GrammarQuestion["first_shown"], label: string): HTMLElement {
    const part = [shown.start, shown.end] as const;
    const title = `${label}: ${shown.capture}, ${interval(shown.start, shown.end)}`;
    const clip = makeClip(context, { ref: `capture:${shown.capture}`, part, lit: part, label: title });
    clips.push(clip);
    return h("figure", { title }, clip.element, h("figcaption.small", label));
  }

  function card(one: GrammarQuestion): HTMLElement {
    const said = h("p.small", { role: "status" });
    const first = nameOf(one.first, one.first_words);
    const then = nameOf(one.then, one.then_words);
    const choices = ANSWERS.map(([value, label]) =>
      button("plain", label, () => void answer(one, value, label, said, choices), {
        "aria-label": `${label}: ${first}, then ${then}`,
        "data-answer": value,
      }),
    );
    return h(
      "article.question",
      { "aria-label": `${first}, then ${then}?` },
      h("div.question-pair", moving(one.first_shown, first), moving(one.then_shown, `then ${then}?`)),
      context.status().read_only ? null : h("div.row", choices),
      said,
    );
  }

  async function answer(
    one: GrammarQuestion,
    value: AnswerReply["said"],
    label: string,
    said: HTMLElement,
    choices: readonly HTMLButtonElement[],
  ): Promise<void> {
    if (!author.value.trim()) {
      said.textContent = "Write your name first: answers are kept with it.";
      author.focus();
      return;
    }
    choices.forEach((choice) => (choice.disabled = true));
    try {
      const pair = { first: one.first, then: one.then, said: value, author: author.value.trim() };
      const kept = await post("/api/grammar/answers", { grammar, run, ...pair });
      said.textContent = kept.obeyed
        ? `${label}: kept.`
        : `${label}: kept, but the captures show this pair, so rules cannot rule it out.`;
    } catch (fault) {
      said.textContent = messageOf(fault);
    } finally {
      choices.forEach((choice) => (choice.disabled = false));
    }
  }

  return {
    element,
    /** Ask about this version of a grammar. */
    show(name: string, version: number): void {
      if (name === grammar && version === run) return;
      [grammar, run] = [name, version];
      clear();
    },
    close: clear,
  };
}

export type Questions = ReturnType<typeof makeQuestions>;
