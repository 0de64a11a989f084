/** Questions to a grammar: parse a capture, what may come next, and how it compares. */

import { named, onSubmit } from "../../dom/fields.ts";
import { get, messageOf, post } from "../../api/client.ts";
import type { CompareReply, GrammarReply, ParseAnswer } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h, type Child } from "../../dom/element.ts";
import { interval, probability } from "../../parts/text.ts";
import { routeTo } from "../../shell/router.ts";
import { coloursOf, type TerminalColours } from "./colours.ts";

const percent = (share: number | null): string => (share === null ? "–" : `${Math.round(share * 100)}%`);

/** What is compared, each with what stands in its row. */
const COMPARED: readonly [string, (row: CompareReply["grammars"][number]) => Child][] = [
  ["nonterminals", (row) => row.nonterminals],
  ["rules", (row) => row.rules],
  ["bits", (row) => row.bits.toFixed(1)],
  ["strings", (row) => row.strings?.toLocaleString("en") ?? "more than 10,000"],
  ["held out", (row) => percent(row.held_out)],
  ["new", (row) => percent(row.new)],
  ["outside", (row) => percent(row.outside)],
];

export function makeAsking() {
  let facts: GrammarReply | null = null;
  let colours: TerminalColours = coloursOf([]);

  const capture = h("input.field", {
    id: "parse-capture",
    list: "parse-captures",
    required: true,
    placeholder: "name of a capture",
  });
  const known = h("datalist", { id: "parse-captures" });
  const parsed = h("div", { "aria-live": "polite" });
  const parseForm = h(
    "form.row",
    named("Capture", capture),
    known,
    h("button.button.plain", { type: "submit" }, "Parse"),
  );
  const beginning = h("input.field", { id: "suggest-beginning", placeholder: "from the start" });
  const next = h("div", { "aria-live": "polite" });
  const suggestForm = h(
    "form.row",
    named("After", beginning),
    h("button.button.plain", { type: "submit" }, "What may come next"),
  );
  const compared = h("div", { "aria-live": "polite" });
  const compareButton = button("plain", "Compare with a finite state machine", () => void compare());
  const element = h(
    "section.grammar-asking",
    { "aria-label": "Questions to the grammar" },
    h("h3", "Parse a capture"),
    parseForm,
    parsed,
    h("h3", "What may come next"),
    suggestForm,
    next,
    h("h3", "Compare"),
    compareButton,
    compared,
  );

  const letter = (name: string): HTMLElement =>
    h("span.letter", { style: { background: colours.of(name).soft } }, name);

  /** Ask, and show the answer or the fault, unless another grammar is shown by then. */
  async function ask<T>(box: HTMLElement, question: Promise<T>, show: (answer: T) => Child): Promise<void> {
    const mine = facts?.grammar;
    fill(box, h("p.muted.small", "Asking…"));
    try {
      const answer = await question;
      if (facts?.grammar === mine) fill(box, show(answer));
    } catch (problem) {
      if (facts?.grammar === mine) fill(box, h("p.bad.small", { role: "alert" }, messageOf(problem)));
    }
  }

  function showParse(answer: ParseAnswer, name: string): Child {
    const { fault, unlike, string, spans } = answer;
    const far = new Set(unlike);
    const link = (from: number, to: number): string =>
      routeTo("catalogue", { capture: name, start: from.toFixed(3), end: to.toFixed(3) });
    return [
      h(
        "ol.plain.parse-string",
        { "aria-label": "Its terminals" },
        string.map((one, i) => {
          const [from, to] = spans[i]!;
          const odd = far.has(i) ? ", unlike all that it was learned from" : "";
          return h(
            "li",
            { class: far.has(i) ? "unlike" : "" },
            h(
              "a",
              { href: link(from, to), title: `${interval(from, to)}${odd}` },
              letter(one),
              far.has(i) ? "?" : "",
            ),
          );
        }),
      ),
      h(
        "p.small",
        answer.learned_from
          ? "The grammar was learned from this capture: these are the stored sentences."
          : answer.is_unlike
            ? `For ${percent(answer.share_unlike)} of its time the capture is unlike all that the grammar was learned from: its string has no meaning.`
            : unlike.length
              ? `Terminals with ? are unlike all that the grammar was learned from (${percent(answer.share_unlike)} of the time).`
              : answer.usual_distance === null
                ? "Whether parts are unlike what the grammar was learned from could not be measured."
                : "Every part is like what the grammar was learned from.",
      ),
      fault
        ? h("p.bad.small", `It does not parse: ${fault.says}`)
        : h(
            "ul.plain.small",
            { "aria-label": "Its sentences" },
            answer.sentences.map((one) => h("li", h("code", one.tree))),
          ),
    ];
  }

  onSubmit(parseForm, () => {
    const name = capture.value.trim();
    const question = post("/api/grammar/parse", { grammar: facts!.grammar, capture: name });
    void ask(parsed, question, (answer) => showParse(answer, name));
  });

  function suggest(): void {
    const question = get("/api/grammar/suggest", {
      name: facts!.grammar,
      beginning: beginning.value,
    });
    void ask(next, question, ({ next: rows }) =>
      h(
        "ul.plain.suggest-list",
        { "aria-label": "What may come next" },
        rows.map((row) => {
          const name = row.terminal;
          const words = facts?.terminals.find((one) => one.terminal === name)?.words.map((one) => one.word);
          const add = (): void => {
            beginning.value = `${beginning.value.trim()} ${name}`.trim();
            suggest();
          };
          return h(
            "li",
            name === null
              ? h("span.muted", "the end")
              : button("link", letter(name), add, { title: "Go on after this terminal" }),
            h("span.time", ` ${probability(row.probability)} `),
            h("span.muted.small", words?.join(" ") ?? ""),
          );
        }),
      ),
    );
  }
  onSubmit(suggestForm, () => {
    suggest();
  });

  async function compare(): Promise<void> {
    compareButton.disabled = true;
    const question = get("/api/grammar/compare", { name: facts!.grammar });
    await ask(compared, question, ({ grammars }) => [
      h(
        "div.grammar-table.compared",
        h(
          "table",
          h(
            "thead",
            h(
              "tr",
              h("td"),
              grammars.map((row) => h("th", { scope: "col" }, row.kind)),
            ),
          ),
          h(
            "tbody",
            COMPARED.map(([name, value]) =>
              h(
                "tr",
                h("th", { scope: "row" }, name),
                grammars.map((row) => h("td", value(row))),
              ),
            ),
          ),
        ),
      ),
      h(
        "p.muted.small",
        "Held out: share of sentences that a grammar learned from the others derives. New: share of strings that are not sentences. Outside: share that this grammar does not derive.",
      ),
    ]);
    compareButton.disabled = false;
  }

  return {
    element,
    show(shown: GrammarReply): void {
      if (facts && (facts.grammar !== shown.grammar || facts.run !== shown.run)) {
        for (const box of [parsed, next, compared]) box.replaceChildren(); // answers of other rules
        beginning.value = "";
      }
      facts = shown;
      colours = coloursOf(shown.terminals);
      fill(
        known,
        shown.captures.filter((one) => one.there).map((one) => h("option", { value: one.capture })),
      );
    },
  };
}

export type Asking = ReturnType<typeof makeAsking>;
