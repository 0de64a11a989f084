/** One grammar: its facts, rules, terminals (each plays its medoid), captures, and kept sequences. */

import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { interval, plural, probability, seconds } from "../../parts/text.ts";
import { routeTo } from "../../shell/router.ts";
import { makeClip, type Clip } from "../../take/clip.ts";
import type { Context } from "../view.ts";
import { coloursOf, type TerminalColours } from "./colours.ts";
import type { GrammarReply, TerminalRow } from "../../api/types.ts";
import { makeAsking } from "./asking.ts";
import { makeQuestions } from "./questions.ts";
import { askTerminalName, makeRules } from "./rules.ts";

/** The facts in one line, as the command line prints them. */
export function summaryOf(facts: GrammarReply): string {
  const whole = facts.captures.reduce((sum, one) => sum + one.seconds, 0);
  return [
    `${plural(facts.captures.length, "capture")} (${seconds(whole)})`,
    `${plural(facts.segments, "segment")} of ${plural(facts.terminals.length, "terminal")}`,
    plural(facts.sentences, "sentence"),
    plural(facts.nonterminals, "nonterminal"),
    plural(facts.rules, "rule"),
    `${(facts.bits["sum"] ?? 0).toFixed(1)} bits`,
  ].join(", ");
}

function bitsOf(facts: GrammarReply): string {
  const parts = Object.entries(facts.bits).filter(([name]) => name !== "sum");
  return parts.map(([name, bits]) => `${name} ${bits.toFixed(1)}`).join(" + ");
}

export function makeFacts(context: Context) {
  let clip: Clip | null = null;
  const rules = makeRules(context);
  const asking = makeAsking();
  const questions = makeQuestions(context);
  const about = h("div");
  const terminalsBox = h("div");
  const rest = h("div");
  const element = h(
    "div.grammar-facts",
    h("section", { "aria-label": "Rules" }, h("h3", "Rules"), rules.element, about),
    terminalsBox,
    asking.element,
    questions.element,
    rest,
  );

  function closeClip(): void {
    clip?.close();
    clip = null;
  }

  function play(one: TerminalRow, box: HTMLElement, facts: GrammarReply): void {
    const { capture, start, end } = one.medoid;
    closeClip();
    clip = makeClip(context, {
      ref: `capture:${capture}`,
      part: [start, end],
      lit: [start, end],
      label: `Terminal ${one.terminal}: ${capture}, ${interval(start, end)}`,
    });
    fill(
      box,
      clip.element,
      h(
        "p.small",
        h("b", one.terminal),
        " ",
        h("span.muted", `${capture} `),
        h("span.muted.time", interval(start, end)),
      ),
      context.status().read_only
        ? null
        : button("plain", `Rename ${one.terminal}…`, () => askTerminalName(context, facts, one.terminal)),
    );
  }

  function terminalRow(
    one: TerminalRow,
    colours: TerminalColours,
    box: HTMLElement,
    facts: GrammarReply,
  ): HTMLElement {
    const words = one.words.map(({ word, probability: p }) => [
      word,
      h("span.chip-detail", ` ${probability(p)}  `),
    ]);
    return h(
      "li",
      h(
        "button.terminal",
        {
          type: "button",
          title: `Play the medoid of ${one.terminal}`,
          "data-terminal": one.terminal,
          on: { click: () => play(one, box, facts) },
        },
        h("span.letter", { style: { background: colours.of(one.terminal).soft } }, one.terminal),
        h("span.terminal-words", words.length ? words : h("span.muted", "no words")),
        h("span.muted.time", `${one.count} × ${one.seconds.toFixed(2)} s`),
      ),
    );
  }

  function terminals(facts: GrammarReply, colours: TerminalColours): HTMLElement {
    const box = h("div.terminal-clip");
    const list = h(
      "ul.plain.terminal-list",
      facts.terminals.map((one) => terminalRow(one, colours, box, facts)),
    );
    fill(box, h("p.muted.small", "Choose a terminal: its most typical segment plays here."));
    return h(
      "section",
      { "aria-label": "Terminals" },
      h("h3", `Terminals (${facts.terminals.length})`),
      h("div.terminal-body", list, box),
    );
  }

  return {
    element,
    show(facts: GrammarReply): void {
      closeClip();
      const colours = coloursOf(facts.terminals);
      const [shortest, mean, longest] = facts.sentence_lengths;
      rules.show(facts);
      asking.show(facts);
      questions.show(facts.grammar, facts.run);
      fill(
        about,
        h(
          "p.muted.small",
          `Description length: ${bitsOf(facts)}. Sentences have ${shortest} to ${longest} terminals, ${mean.toFixed(1)} on average.`,
        ),
        h(
          "p.small",
          facts.derives_new
            ? "It derives sentences that were not in the captures."
            : "It derives no sentence that was not in the captures: new sequences repeat those. Shorter sentences or more takes of the activity may give rules.",
        ),
      );
      fill(terminalsBox, terminals(facts, colours));
      fill(
        rest,
        h(
          "section",
          { "aria-label": "Captures and sequences" },
          h("h3", "Learned from"),
          h(
            "ul.plain.small",
            facts.captures.map((one) =>
              h(
                "li",
                one.there
                  ? h("a", { href: routeTo("catalogue", { capture: one.capture }) }, one.capture)
                  : one.capture,
                h(
                  "span.muted",
                  ` ${seconds(one.seconds)}${one.there ? "" : ", removed: add it again to play its segments"}`,
                ),
              ),
            ),
          ),
          h("h3", "Kept sequences"),
          facts.sequences.length
            ? h(
                "ul.plain.small",
                facts.sequences.map((name) =>
                  h("li", h("a", { href: routeTo("grammar", { name: facts.grammar, open: name }) }, name)),
                ),
              )
            : h("p.muted.small", "None yet. A sequence that is kept can be opened and edited again."),
        ),
      );
    },
    close(): void {
      closeClip();
      questions.close();
    },
  };
}
