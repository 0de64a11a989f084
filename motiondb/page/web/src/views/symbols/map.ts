/** The map of motion symbols: a dot for each, an ellipse for each cluster. Nearby symbols are alike. */

import type { SymbolFacts, SymbolSpace } from "../../api/types.ts";
import { h, svg } from "../../dom/element.ts";
import { tintOf } from "../../parts/tint.ts";
import { wordsThatFit, type Placed } from "./labels.ts";
import { ellipseOf, fitAxes } from "./projection.ts";

export interface SymbolMap {
  readonly element: HTMLElement;
  show(space: SymbolSpace, axes: readonly [number, number]): void;
  choose(symbol: number | null): void;
}

const SIZE = { width: 900, height: 640, margin: 60 };

/** A word is written beside a dot from this probability on. */
const LIKELY = 0.3;

function nameOf(symbol: SymbolFacts): string {
  const words = symbol.words.slice(0, 2).map(({ word }) => word).join(" ");
  return `Symbol ${symbol.symbol}${words ? `: ${words}` : ""}, ${symbol.count} segments`;
}

/** The radius of a dot: its area follows the number of segments. */
function radius(count: number, largest: number): number {
  return 7 + 15 * Math.sqrt(count / Math.max(largest, 1));
}

export function makeSymbolMap(click: (symbol: number) => void): SymbolMap {
  const element = h("div", { class: "symbol-map" });
  let dots = new Map<number, SVGElement>();

  function dot(facts: SymbolFacts, placed: Placed, written: boolean): SVGElement {
    const { x, y, radius: size } = placed;
    const tint = tintOf(facts.symbol);
    const press = (): void => click(facts.symbol);
    return svg(
      "g",
      {
        class: "dot", role: "button", tabindex: 0, transform: `translate(${x} ${y})`,
        "data-symbol": facts.symbol,
        on: { click: press, keydown: (event: KeyboardEvent) => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); press(); } } },
      },
      svg("title", {}, nameOf(facts)),
      svg("circle", { r: size, fill: tint.soft, stroke: tint.strong }),
      svg("text", { class: "dot-number", y: 4 }, facts.symbol),
      svg("text", { class: written ? "dot-word" : "dot-word covered", y: size + 14 }, placed.word),
    );
  }

  return {
    element,
    show(space, [first, second]) {
      const axes = fitAxes(space.symbols.map((one) => one.at), first, second, SIZE);
      const largest = Math.max(...space.symbols.map((one) => one.count));
      const clusters = space.clusters.map((cluster) => {
        const { x, y, rx, ry, angle } = ellipseOf(cluster.mean, cluster.covariance, axes);
        return svg("ellipse", { class: "cluster", cx: x, cy: y, rx, ry, transform: `rotate(${angle} ${x} ${y})` },
          svg("title", {}, `Cluster ${cluster.cluster}`));
      });
      // Large dots first, so that small ones lie above them.
      const ordered = [...space.symbols].sort((a, b) => b.count - a.count);
      const placed = ordered.map((one): Placed => {
        const [x, y] = axes.place(one.at);
        const first = one.words[0];
        const word = first && first.probability >= LIKELY ? first.word : "";
        return { x, y, radius: radius(one.count, largest), word };
      });
      const written = wordsThatFit(placed);
      const made = ordered.map((one, i): [number, SVGElement] => [one.symbol, dot(one, placed[i]!, written[i]!)]);
      dots = new Map(made);
      element.replaceChildren(
        svg("svg", { viewBox: `0 0 ${SIZE.width} ${SIZE.height}`, role: "group", "aria-label": "Map of motion symbols" },
          clusters, made.map(([, mark]) => mark)),
      );
    },
    choose(symbol) {
      for (const [number, mark] of dots) {
        mark.classList.toggle("chosen", number === symbol);
        if (number === symbol) mark.setAttribute("aria-current", "true");
        else mark.removeAttribute("aria-current");
      }
    },
  };
}
