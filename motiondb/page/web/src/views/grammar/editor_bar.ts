/** Above the sequence: undo, redo, the tree, keep, download; and how the sequence was made. */

import { post } from "../../api/client.ts";
import { fill, h } from "../../dom/element.ts";
import { icon, type IconName } from "../../dom/icons.ts";
import { download } from "../../parts/download.ts";
import { askToKeep, suggestedName } from "../../parts/keeping.ts";
import { sourceList } from "../../parts/sources.ts";
import { plural, seconds } from "../../parts/text.ts";
import { routeTo } from "../../shell/router.ts";
import type { Context } from "../view.ts";
import type { Saved, SequenceReply } from "../../api/types.ts";

export interface EditorBar {
  readonly element: HTMLElement;
  /** Null: there is no sequence. */
  show(sequence: SequenceReply | null, canRedo: boolean): void;
  setTree(shown: boolean): void;
}

export interface BarActions {
  undo(): void;
  redo(): void;
  showTree(shown: boolean): void;
}

function button(picture: IconName | null, label: string, title: string, run: () => void): HTMLButtonElement {
  return h(
    "button",
    { class: "button plain", type: "button", title, on: { click: run } },
    picture ? icon(picture) : null,
    label,
  );
}

export function makeEditorBar(context: Context, actions: BarActions): EditorBar {
  let sequence: SequenceReply | null = null;
  let shown = false;
  const title = h("h2", {});
  const saved = h("span", { class: "small" });
  const undo = button("undo", "Undo", "Undo this edit (Ctrl Z)", actions.undo);
  const redo = button("redo", "Redo", "Redo the edit (Ctrl Y)", actions.redo);
  const tree = button(null, "Parse tree", "Show the parse tree over the strip", () =>
    actions.showTree(!shown),
  );
  const keep = button(null, "Keep…", "Keep the sequence as a capture of the database", askName);
  const save = (format: "bvh" | "glb"): void => {
    if (sequence) download([{ ref: sequence.ref }], format).catch(context.fail);
  };
  const bvh = button("download", "BVH", "Download as BVH", () => save("bvh"));
  const glb = button("download", "glTF", "Download as glTF", () => save("glb"));
  bvh.setAttribute("aria-label", "Download as BVH");
  glb.setAttribute("aria-label", "Download as glTF");
  const tools = h("div", { class: "row" }, undo, redo, tree, keep, bvh, glb, saved);
  const element = h("div", { class: "row editor-bar" }, title, tools);

  function showSaved(name: string | null): void {
    fill(saved, name ? ["kept as ", h("a", { href: routeTo("catalogue", { capture: name }) }, name)] : null);
  }

  function askName(): void {
    const one = sequence;
    if (!one) return;
    const send = async (name: string): Promise<void> => {
      const { capture } = await post<Saved>("/api/sequences/save", { id: one.id, name });
      if (sequence?.id === one.id) showSaved(capture);
      context.notify(`Kept as ${capture}.`);
    };
    askToKeep("Keep this sequence", suggestedName(one.grammar, one.seed), send, context.fail);
  }

  return {
    element,
    show(next, canRedo) {
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
    setTree(next) {
      shown = next;
      tree.setAttribute("aria-pressed", String(next));
    },
  };
}

/** Seams, feet and sources. */
export function madeFacts(sequence: SequenceReply): HTMLElement {
  const cost = (value: number | null): string => value?.toFixed(2) ?? "not known";
  const speed = (metres: number | null): string =>
    metres === null ? "not known" : `${(100 * metres).toFixed(1)} cm/s`;
  return h(
    "div",
    {},
    h(
      "p",
      { class: "muted small" },
      `Seed ${sequence.seed}. Roughness of the seams ${cost(sequence.join_cost)} (0: none). Feet slip ${speed(sequence.foot_slip)}, in the sources ${speed(sequence.foot_slip_of_sources)}.`,
    ),
    sourceList(sequence.sources),
  );
}
