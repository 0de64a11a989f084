/** Above the sequence: undo, redo, the tree, keep, download; and how the sequence was made. */

import { post } from "../../api/client.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { icon } from "../../dom/icons.ts";
import { download, downloadButton, type FileFormat } from "../../parts/download.ts";
import { askToKeep, suggestedName } from "../../parts/keeping.ts";
import { sourceList } from "../../parts/sources.ts";
import { plural, seconds } from "../../parts/text.ts";
import { routeTo } from "../../shell/router.ts";
import type { Context } from "../view.ts";
import type { SequenceReply } from "../../api/types.ts";

export interface BarActions {
  undo(): void;
  redo(): void;
  showTree(shown: boolean): void;
}

export function makeEditorBar(context: Context, actions: BarActions) {
  let sequence: SequenceReply | null = null;
  let shown = false;
  const title = h("h2");
  const saved = h("span.small");
  const undo = button("plain", [icon("undo"), "Undo"], actions.undo, { title: "Undo this edit (Ctrl Z)" });
  const redo = button("plain", [icon("redo"), "Redo"], actions.redo, { title: "Redo the edit (Ctrl Y)" });
  const tree = button("plain", "Parse tree", () => actions.showTree(!shown), {
    title: "Show the parse tree over the strip",
  });
  const keep = button("plain", "Keep…", askName, { title: "Keep the sequence as a capture of the database" });
  const save = (format: FileFormat): void => {
    if (sequence) download([{ ref: sequence.ref }], format);
  };
  const files = (["bvh", "glb"] as const).map((format) => downloadButton(format, save));
  const tools = h("div.row", undo, redo, tree, keep, files, saved);
  const element = h("div.row.editor-bar", title, tools);

  function showSaved(name: string | null): void {
    fill(saved, name ? ["kept as ", h("a", { href: routeTo("catalogue", { capture: name }) }, name)] : null);
  }

  function askName(): void {
    const one = sequence;
    if (!one) return;
    const send = async (name: string): Promise<void> => {
      const { capture } = await post("/api/sequences/save", { id: one.id, name });
      if (sequence?.id === one.id) showSaved(capture);
      context.notify(`Kept as ${capture}.`);
    };
    askToKeep("Keep this sequence", suggestedName(one.grammar, one.seed), send);
  }

  return {
    element,
    /** Null: there is no sequence. */
    show(next: SequenceReply | null, canRedo: boolean): void {
      sequence = next;
      tools.hidden = next === null;
      title.textContent = next
        ? `${plural(next.string.length, "terminal")}, ${seconds(next.seconds)}`
        : "This sequence is gone";
      undo.disabled = !next?.parent;
      redo.disabled = !canRedo;
      keep.hidden = context.status().read_only;
      showSaved(next?.saved ?? null);
    },
    setTree(next: boolean): void {
      shown = next;
      tree.setAttribute("aria-pressed", String(next));
    },
  };
}

/** Novelty, seams, feet and sources. */
export function madeFacts(sequence: SequenceReply): HTMLElement {
  const cost = (value: number | null): string => value?.toFixed(2) ?? "not known";
  const speed = (metres: number | null): string =>
    metres === null ? "not known" : `${(100 * metres).toFixed(1)} cm/s`;
  return h(
    "div",
    h("p.small", `${sequence.says[0]?.toUpperCase() ?? ""}${sequence.says.slice(1)}.`),
    h(
      "p.muted.small",
      `Seed ${sequence.seed}. Roughness of the seams ${cost(sequence.join_cost)} (0: none). Feet slip ${speed(sequence.foot_slip)}, in the sources ${speed(sequence.foot_slip_of_sources)}.`,
    ),
    sourceList(sequence.sources),
  );
}
