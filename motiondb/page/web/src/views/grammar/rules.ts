/** The rules of a grammar, edited as text; edits are checked by the server and can be undone. */

import { messageOf, post, put } from "../../api/client.ts";
import type { GrammarEdited, GrammarReply } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { askLine } from "../../parts/asking.ts";
import type { Context } from "../view.ts";
import { coloursOf, type TerminalColours } from "./colours.ts";

/** The rules, each terminal in its colour; everything else as the server prints it. */
function rulesOf(facts: GrammarReply, colours: TerminalColours): HTMLElement {
  const names = new Set(facts.terminals.map((one) => one.terminal));
  const parts = facts.text_with_loops.split(/(\s+|[()|])/);
  return h(
    "pre.grammar-rules",
    { tabindex: 0, "aria-label": "Rules" },
    parts.map((part) => {
      const name = part.replace(/[+*]$/, "");
      if (!names.has(name)) return part;
      const letter = h("span.letter", { style: { background: colours.of(name).soft } }, name);
      return [letter, part.slice(name.length)];
    }),
  );
}

/** Say what an edit took away, if anything. */
function tell(context: Context, done: string, { no_longer_editable: lost }: GrammarEdited): void {
  const gone = lost.length ? ` No longer editable: ${lost.join(", ")}.` : "";
  context.notify(`${done}${gone}`);
}

/** Ask for a new name of a terminal. */
export function askTerminalName(context: Context, facts: GrammarReply, terminal: string): void {
  const label = `Name of the terminal ${terminal}`;
  const note = "A word such as dribble reads better than a letter. The rules follow.";
  askLine({ title: "Rename a terminal", label, value: terminal, note, yes: "Rename" }, async (to) => {
    const body = { grammar: facts.grammar, run: facts.run, terminal, to };
    tell(context, `${terminal} is now ${to}.`, await put("/api/grammar/terminal", body));
    void context.refresh();
  });
}

export function makeRules(context: Context) {
  const element = h("div");
  let facts: GrammarReply | null = null;
  let editing = false;

  function edit(): void {
    const edited = facts!;
    editing = true;
    const fault = h("p.bad.small", { role: "alert" });
    const area = h("textarea.field.wide.grammar-text", {
      rows: Math.min(edited.text.split("\n").length + 3, 20),
      "aria-label": "Rules as text",
      spellcheck: false,
    });
    area.value = edited.text;
    const leave = (): void => {
      editing = false;
      draw();
    };
    const save = async (): Promise<void> => {
      const body = { grammar: edited.grammar, run: edited.run, text: area.value };
      try {
        const done = await put("/api/grammar/rules", body);
        editing = false;
        tell(context, "The rules are saved.", done);
        await context.refresh();
        draw();
      } catch (problem) {
        fault.textContent = messageOf(problem);
      }
    };
    fill(
      element,
      area,
      h(
        "p.muted.small",
        "One nonterminal a line, alternatives divided by |, a probability as [0.5], empty for nothing. The rules must still derive every sentence of the captures.",
      ),
      fault,
      h(
        "div.row",
        button("main", "Save the rules", () => void save()),
        button("plain", "Cancel", leave),
      ),
    );
    area.focus();
  }

  async function undo(): Promise<void> {
    const { grammar, run } = facts!;
    try {
      await post("/api/grammar/undo", { grammar, run });
      context.notify("The last edit is taken back.");
      await context.refresh();
    } catch (problem) {
      context.fail(problem);
    }
  }

  function draw(): void {
    if (!facts || editing) return;
    const [last] = facts.edits;
    fill(
      element,
      rulesOf(facts, coloursOf(facts.terminals)),
      context.status().read_only
        ? null
        : h(
            "div.row",
            button("plain", "Edit the rules…", edit),
            last ? button("plain", `Undo: ${last}`, undo) : null,
            last ? h("span.muted.small", "Edited by hand since it was learned.") : null,
          ),
    );
  }

  return {
    element,
    /** Show the rules of a grammar; rules that are being edited stay as they are. */
    show(next: GrammarReply): void {
      if (facts && facts.grammar !== next.grammar) editing = false;
      facts = next;
      draw();
    },
  };
}
