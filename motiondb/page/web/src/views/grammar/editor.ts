/** The editor of one sequence: play it, choose a part and derive it again, undo edits. */

import { showFault } from "../../parts/states.ts";
import { makeLatest } from "../../api/latest.ts";
import { get, isAbort, post } from "../../api/client.ts";
import { fill, h } from "../../dom/element.ts";
import type { Context } from "../view.ts";
import { coloursOf, type TerminalColours } from "./colours.ts";
import { makeCorners } from "./corners.ts";
import { makeEditorBar, madeFacts } from "./editor_bar.ts";
import { regionOf, waysTo } from "./layout.ts";
import { redoOf, rememberRedo } from "./moves.ts";
import { makePlan } from "./plan.ts";
import { regionHint, regionPanel } from "./region.ts";
import { makeScene } from "./scene.ts";
import { makeStrip } from "./strip.ts";
import { makeParseTree } from "./tree.ts";
import type { AlternativesReply, GrammarReply, SequenceReply, TreeNode } from "../../api/types.ts";
import type { Selection } from "./selection.ts";

export interface EditorRoute {
  /** Another sequence: a step that the back button undoes. */
  sequence(id: string): void;
  /** Another region of the same sequence, or the tree shown or hidden. */
  region(selection: Selection | null, tree: boolean): void;
}

export function makeEditor(context: Context, route: EditorRoute) {
  let sequence: SequenceReply | null = null;
  let colours: TerminalColours = coloursOf([]);
  let selection: Selection | null = null;
  let treeShown = false;
  let wanted = "";
  const latest = makeLatest();

  const corners = makeCorners(context, choose);
  const scene = makeScene(context, corners.element);
  const strip = makeStrip((at) => select({ at, wider: 0, draw: 0 }));
  const tree = makeParseTree((node) => {
    const way = sequence && waysTo(sequence.nodes, node, selection?.at ?? 0);
    if (way) select({ ...way, draw: 0 });
  });
  const plan = makePlan((at) => select({ at, wider: 0, draw: 0 }));
  const bar = makeEditorBar(context, {
    undo,
    redo,
    showTree: (shown) => {
      treeShown = shown;
      showTree();
      route.region(selection, treeShown);
    },
  });
  const said = h("p.visually-hidden", { role: "status", "aria-label": "Chosen region" });
  const panel = h("div");
  const made = h("div.made-facts");
  const ground = h("div.strip-box", { tabindex: -1 }, tree.element, strip.element);
  const body = h(
    "div.editor-body",
    h("div.editor-left", scene.element, ground),
    h("aside.editor-side", { "aria-label": "Path and region" }, plan.element, panel, made),
  );
  const fault = h("div");
  const element = h("section.editor", { "aria-label": "Sequence" }, bar.element, fault, body, said);
  scene.player.onTime((time) => {
    strip.setTime(time);
    plan.setTime(time);
  });

  function showTree(): void {
    tree.element.hidden = !treeShown;
    element.classList.toggle("with-tree", treeShown);
    bar.setTree(treeShown);
    if (treeShown) tree.mark(chosenNode());
  }

  /** The node of the chosen region. */
  function chosenNode(): number | null {
    return sequence && selection ? regionOf(sequence.nodes, selection.at, selection.wider) : null;
  }

  function chosenRegion(): TreeNode | null {
    const node = chosenNode();
    return node === null ? null : sequence!.nodes[node]!;
  }

  function mark(): void {
    const part = chosenRegion();
    const region = part ? ([part.start, part.end] as const) : null;
    strip.mark(selection?.at ?? null, region);
    plan.mark(region);
    scene.mark(region);
    if (treeShown) tree.mark(chosenNode());
  }

  function showPanel(): void {
    if (!sequence || !selection) return fill(panel, regionHint());
    const { at, wider, draw } = selection;
    fill(
      panel,
      regionPanel(sequence, selection, chosenRegion(), colours, {
        widen,
        narrow,
        others: () => select({ at, wider, draw: draw + 1 }),
        clear: () => select(null),
      }),
    );
  }

  function widen(): void {
    const region = chosenRegion();
    if (selection && region && region.parent >= 0)
      select({ ...selection, wider: selection.wider + 1, draw: 0 });
  }

  function narrow(): void {
    if (selection?.wider) select({ ...selection, wider: selection.wider - 1, draw: 0 });
  }

  function select(next: Selection | null): void {
    route.region(next, treeShown);
    void load(next);
  }

  /** Request the alternatives of a region; the old ones stay until the answer arrives. */
  async function load(next: Selection | null): Promise<void> {
    selection = sequence && next && sequence.strip[next.at] ? next : null;
    corners.wait();
    if (!selection) {
      corners.say("");
      said.textContent = "";
    }
    mark();
    showPanel();
    if (!sequence || !selection) return void latest();
    const { at, wider, draw } = selection;
    try {
      const body = { id: sequence.id, at, wider, seed: draw };
      showAlternatives(await latest(post("/api/sequences/alternatives", body)));
    } catch (problem) {
      if (isAbort(problem)) return;
      corners.say("");
      showFault(panel, problem, [{ label: "Clear", run: () => select(null) }]);
    }
  }

  function showAlternatives({ region, alternatives, can_widen }: AlternativesReply): void {
    const item = sequence!.strip[selection!.at]!;
    const string = sequence!.string.slice(region.start, region.end).join(" ");
    const count = alternatives.length;
    said.textContent = `${item.terminal} is generated by ${item.nonterminal}. Region ${region.symbol}: ${string}. ${count} alternatives.`;
    if (count > 0) corners.show(alternatives, colours);
    else {
      corners.say(
        `${region.symbol} derives nothing else.${can_widen ? " A wider region may have alternatives." : ""}`,
      );
    }
  }

  function choose(alternative: SequenceReply): void {
    route.sequence(alternative.id);
  }

  function undo(): void {
    if (!sequence?.parent) return;
    rememberRedo(sequence.parent, sequence.id);
    route.sequence(sequence.parent);
  }

  function redo(): void {
    const next = sequence && redoOf(sequence.id);
    if (next) route.sequence(next);
  }

  function show(next: SequenceReply): void {
    const edit = sequence !== null && (next.parent === sequence.id || sequence.parent === next.id);
    sequence = next;
    fault.replaceChildren();
    body.hidden = false;
    const layout = strip.show(next, colours);
    tree.show(next, layout, colours);
    tree.element.style.minWidth = strip.element.style.minWidth;
    plan.show(next, colours);
    fill(made, madeFacts(next));
    bar.show(next, redoOf(next.id) !== null);
    void scene.show(next, colours, edit);
    if (edit) strip.focus(next.edited?.start ?? 0);
  }

  function rest(): void {
    void latest();
    wanted = "";
    sequence = selection = null;
    corners.say("");
    scene.rest();
  }

  const KEYS: Record<string, () => void> = {
    w: widen,
    n: narrow,
    Escape: () => selection && select(null),
  };
  element.addEventListener("keydown", (event) => {
    const target = event.target as Element;
    if (target.matches("input, select, textarea, dialog *, canvas")) return;
    if (event.ctrlKey || event.metaKey) {
      if (event.key === "z" || event.key === "y") {
        event.preventDefault();
        if (event.key === "z" && !event.shiftKey) undo();
        else redo();
      }
      return;
    }
    const button = corners.element.querySelector<HTMLElement>(`[data-alternative="${event.key}"]`);
    const action = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (/^[1-9]$/.test(event.key) && button) button.click();
    else if (action) action();
    else return;
    event.preventDefault();
  });

  return {
    element,
    /** Show a sequence of a grammar, with a region if one is chosen. */
    async open(id: string, next: Selection | null, shown: boolean, grammar: GrammarReply): Promise<void> {
      colours = coloursOf(grammar.terminals);
      treeShown = shown;
      wanted = id;
      if (sequence?.id !== id) {
        try {
          const got = await get("/api/sequence", { id });
          if (wanted !== id) return;
          show(got);
        } catch (problem) {
          if (wanted !== id) return;
          sequence = null;
          body.hidden = true;
          showFault(fault, problem);
          bar.show(null, false);
          return;
        }
      }
      showTree();
      await load(next);
    },
    /** Show nothing. */
    rest,
    close(): void {
      rest();
      scene.close();
    },
  };
}
