/** Describe and generate: motion from a sentence, with the actions it shows and does not show. */

import { choice, named, numberField, onSubmit } from "../../dom/fields.ts";
import { makeLatest } from "../../api/latest.ts";
import { get, isAbort, post } from "../../api/client.ts";
import type { MadeReply } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { emptyState, showFault } from "../../parts/states.ts";
import { go, rewrite, routeTo } from "../../shell/router.ts";
import { offeredQuestions } from "../wall/offered.ts";
import { faultWithWords } from "../known_words.ts";
import { notLearned } from "../not_learned.ts";
import { questionElement } from "../search/question.ts";
import type { Context, OpenView } from "../view.ts";
import { blocksOf, type Chosen, type Wish } from "./blocks.ts";
import { makeVariant, type Variant } from "./variant.ts";

const METHODS: readonly [string, string][] = [
  ["stitched", "stitched from captures"],
  ["trajectory", "most likely trajectory"],
];

export function open(host: HTMLElement, context: Context): OpenView {
  let variants: Variant[] = [];
  let asked = "";
  const latest = makeLatest();
  const chosen: Chosen = { at: 0, focus: false };

  const box = h("input.question-box", {
    id: "sentence",
    placeholder: "a person walks then kicks",
    autocomplete: "off",
    "aria-label": "What the person does",
  });
  const seed = numberField("seed", 0, { value: 0 });
  const count = choice(
    "variants",
    [1, 2, 3, 4, 6, 8],
    () => asked && box.value.trim() && form.requestSubmit(), // as "Next seed" does
  );
  const method = choice("method", METHODS);
  const exact = h("input", { type: "checkbox", id: "exact" });
  const understood = h("div", { "aria-live": "polite" });
  const results = h("section.answers", { "aria-label": "Generated motion" });
  const sync = button("plain", "Play together", () => void together(), {
    title: "Start all variants at the same moment",
  });
  const form = h(
    "form.search-form",
    h("div.search-line", box, h("button.button", { type: "submit" }, "Generate")),
    h(
      "div.row.settings",
      named("Seed", seed),
      button(
        "plain",
        "Next seed",
        () => {
          seed.value = String((seed.valueAsNumber || 0) + Number(count.value));
          form.requestSubmit();
        },
        { title: "Generate with the next seed" },
      ),
      named("Variants", count),
      named("Method", method),
      h("label.check", { title: "Do not replace unknown words by known ones" }, exact, "Only known words"),
      sync,
    ),
  );
  fill(host, h("h1.hidden-heading", "Generate"), form, understood, results);

  onSubmit(form, () => {
    const q = box.value.trim();
    if (!q) return box.focus();
    go(
      routeTo("generate", {
        q,
        seed: seed.value || "0",
        variants: count.value === "1" ? "" : count.value,
        method: method.value === "stitched" ? "" : method.value,
        exact: exact.checked ? "1" : "",
      }),
    );
  });

  /** Play all variants from their start, as soon as all are loaded, so that they can be compared. */
  async function together(): Promise<void> {
    const wanted = variants;
    await Promise.all(wanted.map(({ clip }) => clip.ready()));
    if (variants === wanted) wanted.forEach(({ clip }) => clip.replay());
  }

  function clear(): void {
    variants.forEach((variant) => variant.close());
    variants = [];
    results.replaceChildren();
  }

  function showVariants(made: readonly MadeReply[]): void {
    clear();
    const canSave = !context.status().read_only;
    variants = made.map((one) =>
      makeVariant(context, one, {
        fail: context.fail,
        notify: (text) => context.notify(text),
        canSave,
        blocks: (of, seek) => blocksOf(context, of, chosen, (wishes) => void change(of, wishes), seek),
      }),
    );
    sync.hidden = made.length < 2;
    fill(
      results,
      h(
        "div.answer-grid.wide",
        variants.map((one) => one.element),
      ),
    );
  }

  async function make(parameters: URLSearchParams): Promise<void> {
    clear();
    chosen.at = 0;
    understood.replaceChildren();
    fill(
      results,
      h("p.muted", { role: "status" }, "Making motion…"),
      h("progress", { "aria-label": "Making motion" }),
    );
    try {
      const asking = post("/api/generate", {
        words: parameters.get("q"),
        seed: Number(parameters.get("seed") ?? 0),
        variants: Number(parameters.get("variants") ?? 1),
        method: parameters.get("method") ?? "stitched",
        exact: parameters.has("exact"),
      });
      const answer = await latest(asking);
      const replace = (word: string, by: string): void => {
        box.value = box.value.replaceAll(word, by);
        form.requestSubmit();
      };
      fill(
        understood,
        questionElement(answer.question, answer.sentences, answer.unknown, answer.suggested, replace),
      );
      showVariants(answer.variants);
    } catch (fault) {
      if (isAbort(fault)) return;
      const choose = (word: string): void => go(routeTo("generate", { q: word, seed: 0 }));
      fill(results, notLearned(fault, context) ?? faultWithWords(fault, choose));
    }
  }

  /** Make the motion of a changed timeline; the step back in the history returns to this one. */
  async function change(made: MadeReply, blocks: readonly Wish[]): Promise<void> {
    results.setAttribute("aria-busy", "true");
    host.classList.add("busy");
    try {
      const body = { blocks, seed: made.seed, method: "stitched", exact: exact.checked };
      const answer = await latest(post("/api/generate", body));
      // A first motion of a sentence has no address of its own yet: Back would make it again.
      if (!asked.includes("made=")) rewrite(routeTo("generate", { q: made.words, made: made.id }));
      go(routeTo("generate", { made: answer.variants[0]!.id }));
    } finally {
      results.removeAttribute("aria-busy");
      host.classList.remove("busy");
    }
  }

  async function showOne(id: string): Promise<void> {
    try {
      const [made] = (await latest(get("/api/made", { id }))).variants;
      box.value = made.words;
      showVariants([made]);
    } catch (fault) {
      if (!isAbort(fault)) showFault(results, fault);
    }
  }

  function showStart(): void {
    void latest();
    clear();
    understood.replaceChildren();
    fill(
      results,
      !context.status().learned
        ? notLearned(null, context)
        : emptyState(
            "Write a sentence",
            "Motion is put together from captures that show these actions. Actions that cannot be shown are named, and every stretch keeps its source and licence.",
          ),
    );
    if (context.status().learned) void offerExamples();
  }

  /** Offer what this database was found to show, one action or several. */
  async function offerExamples(): Promise<void> {
    const state = results.firstElementChild;
    const { questions } = await offeredQuestions(context).catch(() => ({ questions: [] }));
    if (!state?.isConnected || questions.length === 0) return;
    const offered = questions.map((q) =>
      h("a.button.plain", { href: routeTo("generate", { q, seed: 0 }) }, q),
    );
    state.append(h("div.row", offered));
  }

  return {
    update(parameters) {
      const key = parameters.toString();
      if (key === asked && key !== "") return;
      asked = key;
      box.value = parameters.get("q") ?? "";
      seed.value = parameters.get("seed") ?? "0";
      count.value = parameters.get("variants") ?? "1";
      method.value = parameters.get("method") ?? "stitched";
      exact.checked = parameters.has("exact");
      sync.hidden = true;
      const made = parameters.get("made");
      if (made) void showOne(made);
      else if (parameters.get("q")) void make(parameters);
      else showStart();
    },
    news(news) {
      if (news.kind === "revision" && !asked) showStart();
    },
    close() {
      void latest();
      clear();
    },
  };
}
