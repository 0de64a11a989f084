/**
 * The parse tree over the strip: every nonterminal is a bar over the terminals that it generates, the
 * root at the top. Nodes have one row a level, so that a tree of any depth can be drawn and scrolled.
 */

import { fill, h } from "../../dom/element.ts";
import type { TerminalColours } from "./colours.ts";
import { depthsOf, placeOf, type StripLayout } from "./layout.ts";
import type { SequenceReply, TreeNode } from "../../api/types.ts";

/** Height of a level, pixels. */
const ROW = 22;

export function makeParseTree(choose: (node: number) => void) {
  const element = h("div.parse-tree", {
    role: "tree",
    "aria-label": "Parse tree. Arrow keys walk over it, Enter chooses a region",
  });
  let tree: readonly TreeNode[] = [];
  let bars = new Map<number, HTMLElement>();
  let focused = 0;

  function setFocused(node: number): void {
    bars.get(focused)?.setAttribute("tabindex", "-1");
    focused = node;
    bars.get(focused)?.setAttribute("tabindex", "0");
  }

  /** The next bar in the order of the tree, `by` steps on. */
  function beside(by: number): number {
    const order = [...bars.keys()];
    return order[order.indexOf(focused) + by] ?? focused;
  }

  const MOVES: Record<string, () => number> = {
    ArrowUp: () => tree[focused]!.parent,
    ArrowDown: () => [...bars.keys()].find((node) => tree[node]!.parent === focused) ?? focused,
    ArrowLeft: () => beside(-1),
    ArrowRight: () => beside(1),
    Home: () => 0,
  };
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const move = MOVES[event.key];
    if (move) {
      const node = move();
      if (bars.has(node)) setFocused(node);
      bars.get(focused)?.focus();
    } else if (event.key === "Enter" || event.key === " ") choose(focused);
    else return;
    event.preventDefault();
  });

  function bar(node: number, depth: number, layout: StripLayout, string: readonly string[]): HTMLElement {
    const { symbol, start, end } = tree[node]!;
    const [left, width] = placeOf(layout, start, end);
    const generates = start < end ? string.slice(start, end).join(" ") : "nothing";
    return h(
      "div",
      {
        class: start < end ? "tree-bar" : "tree-bar nothing",
        role: "treeitem",
        tabindex: -1,
        "aria-level": depth + 1,
        "aria-selected": "false",
        "aria-label": `${symbol}: ${generates}`,
        title: `${symbol} generates ${generates}`,
        "data-node": node,
        style: { left: `${100 * left}%`, width: `${100 * width}%`, top: `${depth * ROW}px` },
        on: {
          click: () => {
            setFocused(node);
            choose(node);
          },
        },
      },
      h("span.tree-symbol", symbol),
    );
  }

  return {
    element,
    show(sequence: SequenceReply, layout: StripLayout, colours: TerminalColours): void {
      tree = sequence.nodes;
      const depths = depthsOf(tree);
      const height = (depths.reduce((most, depth) => Math.max(most, depth), 0) + 1) * ROW;
      element.style.height = `${height}px`;
      const leaves: HTMLElement[] = [];
      bars = new Map();
      tree.forEach((node, i) => {
        if (!node.is_terminal) {
          bars.set(i, bar(i, depths[i]!, layout, sequence.string));
          return;
        }
        const [left, width] = placeOf(layout, node.start, node.end);
        leaves.push(
          h("div.tree-leaf", {
            role: "presentation",
            style: {
              left: `${100 * left}%`,
              width: `${100 * width}%`,
              top: `${depths[i]! * ROW}px`,
              background: colours.of(node.symbol).soft,
            },
          }),
        );
      });
      focused = 0;
      fill(element, leaves, [...bars.values()]);
      setFocused(0);
    },
    /** Highlight the region; null: none. */
    mark(node: number | null): void {
      for (const [i, one] of bars) {
        one.classList.toggle("chosen", i === node);
        one.setAttribute("aria-selected", String(i === node));
      }
      if (node === null) return;
      setFocused(node);
      bars.get(node)?.scrollIntoView({ block: "nearest", inline: "nearest" });
    },
  };
}
