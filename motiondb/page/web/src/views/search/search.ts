/** Search: the answers to the question in the head, or to an example, play side by side. */

import { choice, named, onSubmit } from "../../dom/fields.ts";
import { get, isAbort } from "../../api/client.ts";
import { fill, h } from "../../dom/element.ts";
import { onDrop } from "../../parts/dropping.ts";
import { amend, go, partOf, replace, routeTo } from "../../shell/router.ts";
import type { Interval } from "../../timeline/timeline.ts";
import type { Context, OpenView } from "../view.ts";
import { filterOf } from "../catalogue/filter.ts";
import { wordsQuery } from "./query.ts";
import { faultWithWords } from "../known_words.ts";
import { notLearned } from "../not_learned.ts";
import { makeAnswers } from "./answers.ts";
import { searchByFile } from "./by_file.ts";
import { makeExample, type Example } from "./example.ts";
import { decodingElement, questionElement } from "./question.ts";
import { makePathField } from "./path.ts";
import { makeRhythmField } from "./rhythm.ts";
import { makeSelection } from "./selection.ts";

interface Wanted {
  q: string;
  like: string;
  start: string;
  end: string;
  where: string;
  limit: string;
  exact: string;
  symbols: string;
  path: string;
  rhythm: string;
}

/** Milliseconds after which a question that is not answered yet says so. */
const UNSAID = 150;
const NAMES = ["q", "like", "start", "end", "where", "limit", "exact", "symbols", "path", "rhythm"] as const;
/** What is searched beside words: its route, what it is called there, and what is said of it. */
const BESIDE = {
  path: {
    route: "/api/along",
    parameter: "path",
    looks: "Looking for who goes along it…",
    said: "along the path under Options, anywhere and in any direction",
  },
  rhythm: {
    route: "/api/rhythm",
    parameter: "taps",
    looks: "Looking for who steps in it…",
    said: "in the rhythm under Options, at any moment, .8 to 1.25 times as fast",
  },
} as const;

export function open(host: HTMLElement, context: Context): OpenView {
  let wanted = {} as Wanted;
  let asked: string | null = null;
  let abort = new AbortController();
  let example: Example | null = null;

  const selection = makeSelection(context);
  const answers = makeAnswers(context, selection);
  const where = h("input.field", {
    id: "search-where",
    placeholder: "performer = ana",
    spellcheck: false,
  });
  const limit = choice("search-limit", [5, 10, 20, 50]);
  const exact = h("input", { type: "checkbox", id: "search-exact" });
  const symbols = h("input", { type: "checkbox", id: "search-symbols" });
  const path = makePathField("search-path", () => form.requestSubmit());
  const rhythm = makeRhythmField("search-rhythm", () => {
    path.value = ""; // one of both is searched
    form.requestSubmit();
  });
  const understood = h("div", { "aria-live": "polite" });
  const waiting = h("p.muted", { role: "status" });
  const exampleBox = h("div.example-box");
  const more = h(
    "details.search-more",
    h("summary", "Options"),
    h(
      "div.search-options",
      h(
        "div.form-grid",
        named("Among captures where", where),
        named("Answers", limit),
        h("label", { for: "search-exact" }, "Only known words"),
        h("label.check", exact, h("span.muted.small", "do not replace unknown words by known ones")),
        h("label", { for: "search-symbols" }, "By movements"),
        h(
          "label.check",
          symbols,
          h(
            "span.muted.small",
            "turn the words into the movements that they usually mean, and search for these",
          ),
        ),
      ),
      h("div", h("label", { for: "search-path" }, "Along a path"), path.element),
      h("div", h("label", { for: "search-rhythm" }, "In a rhythm"), rhythm.element),
    ),
    h("button.button.plain", { type: "submit" }, "Search again"),
  );
  const form = h("form.search-form", more);
  fill(
    host,
    h("h1.hidden-heading", "Search"),
    h("div.search-head", understood, form),
    waiting,
    exampleBox,
    answers.element,
    selection.element,
  );
  const endDrops = onDrop(host, (files) => void searchByFile(context, files));

  onSubmit(form, () => {
    const options = {
      where: where.value.trim(),
      limit: limit.value === "10" ? "" : limit.value,
      exact: exact.checked ? "1" : "",
      symbols: symbols.checked ? "1" : "",
    };
    // of both, the one that was given last
    const beside =
      path.value && (path.value !== wanted.path || !rhythm.value || rhythm.value === wanted.rhythm)
        ? { path: path.value }
        : { rhythm: rhythm.value };
    if (wanted.q || path.value || rhythm.value) go(routeTo("search", { q: wanted.q, ...options, ...beside }));
    else if (wanted.like)
      go(
        routeTo("search", {
          like: wanted.like,
          start: wanted.start,
          end: wanted.end,
          where: options.where,
          limit: options.limit,
        }),
      );
  });

  function replaceWord(word: string, by: string): void {
    const pattern = new RegExp(
      `(?<![\\p{L}\\p{N}])${word.replace(/[.*+?^${}()|[\]\\]/g, "\\$&")}(?![\\p{L}\\p{N}])`,
      "giu",
    );
    go(routeTo("search", { ...wanted, q: wanted.q.replace(pattern, by) }));
  }

  function busy(on: boolean): void {
    answers.element.setAttribute("aria-busy", String(on));
    host.classList.toggle("busy", on);
    context.stage.rest(on);
  }

  async function ask(): Promise<void> {
    abort.abort();
    abort = new AbortController();
    const { signal } = abort;
    const kind = wanted.path ? "path" : wanted.rhythm ? "rhythm" : null;
    const beside = kind && BESIDE[kind];
    if (!wanted.q && !wanted.like && !beside) return replace(routeTo("catalogue")); // the unfiltered answer
    busy(true);
    if (!wanted.q) understood.replaceChildren(); // the chips of another question
    const late = setTimeout(() => {
      answers.wait();
      const others = beside?.looks ?? "Looking for others that move like it…";
      fill(waiting, wanted.q ? `Looking for “${wanted.q}”…` : others);
    }, UNSAID);
    const told = (): void => {
      clearTimeout(late);
      waiting.replaceChildren();
    };
    signal.addEventListener("abort", told);
    try {
      const rest = { where: filterOf(wanted.where), limit: wanted.limit || "10" };
      if (beside) {
        const asked = { [beside.parameter]: wanted[kind!], words: wanted.q, ...rest };
        const answer = await get(beside.route, asked, signal);
        const read = wanted.q ? `Read as: ${answer.read_as}; ` : "Answers are ";
        fill(understood, h("p.small.muted", `${read}${beside.said}`));
        answers.show(answer, wanted.where !== "");
      } else if (wanted.q) {
        const answer = await get(...wordsQuery(new URLSearchParams({ ...wanted })), signal);
        fill(
          understood,
          questionElement(
            answer.question,
            [...answer.sentences, ...(answer.unchecked ? [answer.unchecked] : [])],
            answer.unknown,
            answer.suggested,
            replaceWord,
          ),
          answer.decoding ? decodingElement(answer.decoding) : null,
        );
        answers.show(answer, wanted.where !== "");
      } else {
        const answer = await get(
          "/api/like",
          { ref: wanted.like, start: wanted.start, end: wanted.end, ...rest },
          signal,
        );
        fill(understood, answer.unchecked ? h("p.small.muted", answer.unchecked) : null);
        answers.show(answer, wanted.where !== "");
      }
    } catch (fault) {
      if (isAbort(fault)) return;
      answers.clear();
      understood.replaceChildren();
      const choose = (word: string): void => go(routeTo("search", { q: word }));
      fill(answers.element, notLearned(fault, context) ?? faultWithWords(fault, choose));
    }
    told();
    busy(false);
  }

  function showExample(): void {
    host.classList.toggle("with-example", wanted.like !== "");
    if (!wanted.like) {
      example?.close();
      example = null;
      exampleBox.replaceChildren();
      return;
    }
    if (!example) {
      example = makeExample(context, searchPart, () => go(routeTo("catalogue")));
      fill(exampleBox, example.element);
    }
    const part: Interval | null =
      wanted.start && wanted.end ? [Number(wanted.start), Number(wanted.end)] : null;
    void example.show(wanted.like, part);
  }

  function searchPart(part: Interval | null): void {
    amend(routeTo("search", { ...wanted, start: part?.[0].toFixed(3), end: part?.[1].toFixed(3) }));
  }

  return {
    update(parameters) {
      wanted = Object.fromEntries(
        NAMES.map((name) => [name, parameters.get(name) ?? ""]),
      ) as unknown as Wanted;
      where.value = wanted.where;
      limit.value = wanted.limit || "10";
      exact.checked = wanted.exact !== "";
      symbols.checked = wanted.symbols !== "";
      path.value = wanted.path;
      rhythm.value = wanted.rhythm;
      if (wanted.where || wanted.exact || wanted.symbols || wanted.path || wanted.rhythm) more.open = true;
      const key = partOf(parameters, NAMES);
      if (key === asked) return;
      asked = key;
      showExample();
      void ask();
    },
    news(news) {
      if (news.kind === "revision") void ask();
    },
    close() {
      endDrops();
      abort.abort();
      rhythm.close();
      context.stage.rest(false);
      answers.clear();
      example?.close();
    },
  };
}
