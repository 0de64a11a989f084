/** The map of motion symbols: a dot for each, an ellipse for each cluster. Nearby symbols are alike. */

import type { PlacedSymbol, SpaceReply } from "../../api/types.ts";
import { h, svg } from "../../dom/element.ts";
import { tintOf } from "../../parts/tint.ts";
import { wordsThatFit, type Placed } from "./labels.ts";
import { ellipseOf, fitAxes, NO_ZOOM, zoomAt, zoomed, type Zoom } from "./projection.ts";

export interface SymbolMap {
  readonly element: HTMLElement;
  show(space: SpaceReply, axes: readonly [number, number]): void;
  choose(symbol: number | null): void;
  /** Enlarge (above 1) or shrink around the middle; 0: see everything. */
  enlarge(by: number): void;
}

const SIZE = { width: 900, height: 640, margin: 60 };

/** A word is written beside a dot from this probability on. */
const LIKELY = 0.3;

function nameOf(symbol: PlacedSymbol): string {
  const words = symbol.words
    .slice(0, 2)
    .map(({ word }) => word)
    .join(" ");
  return `Symbol ${symbol.symbol}${words ? `: ${words}` : ""}, ${symbol.count} segments`;
}

/** The radius of a dot: its area follows the number of segments. */
function radius(count: number, largest: number): number {
  return 7 + 15 * Math.sqrt(count / Math.max(largest, 1));
}

export function makeSymbolMap(click: (symbol: number) => void): SymbolMap {
  const element = h("div", { class: "symbol-map" });
  let dots = new Map<number, SVGElement>();
  let shown: { space: SpaceReply; axes: readonly [number, number] } | null = null;
  let chosen: number | null = null;
  let zoom: Zoom = NO_ZOOM;

  function dot(facts: PlacedSymbol, placed: Placed, written: boolean): SVGElement {
    const { x, y, radius: size } = placed;
    const tint = tintOf(facts.symbol);
    const press = (): void => click(facts.symbol);
    return svg(
      "g",
      {
        class: "dot",
        role: "button",
        tabindex: 0,
        transform: `translate(${x} ${y})`,
        "data-symbol": facts.symbol,
        on: {
          click: press,
          keydown: (event: KeyboardEvent) => {
            if (event.key === "Enter" || event.key === " ") {
              event.preventDefault();
              press();
            }
          },
        },
      },
      svg("title", {}, nameOf(facts)),
      svg("circle", { r: size, fill: tint.soft, stroke: tint.strong }),
      svg("text", { class: "dot-number", y: 4 }, facts.symbol),
      svg("text", { class: written ? "dot-word" : "dot-word covered", y: size + 14 }, placed.word),
    );
  }

  function draw(): void {
    if (!shown) return;
    const { symbols, clusters } = shown.space;
    const whole = fitAxes(
      symbols.map((one) => one.at),
      ...shown.axes,
      SIZE,
    );
    const axes = zoomed(whole, zoom, SIZE);
    const largest = Math.max(...symbols.map((one) => one.count));
    const ellipses = clusters.map(({ cluster, mean, covariance }) => {
      const { x, y, rx, ry, angle } = ellipseOf(mean, covariance, axes);
      return svg(
        "ellipse",
        { class: "cluster", cx: x, cy: y, rx, ry, transform: `rotate(${angle} ${x} ${y})` },
        svg("title", {}, `Cluster ${cluster}`),
      );
    });
    // Large dots first, so that small ones lie above them.
    const ordered = [...symbols].sort((a, b) => b.count - a.count);
    const placed = ordered.map((one): Placed => {
      const [x, y] = axes.place(one.at);
      const first = one.words[0];
      return {
        x,
        y,
        radius: radius(one.count, largest),
        word: first && first.probability >= LIKELY ? first.word : "",
      };
    });
    const written = wordsThatFit(placed);
    dots = new Map(ordered.map((one, i) => [one.symbol, dot(one, placed[i]!, written[i]!)]));
    element.replaceChildren(
      svg(
        "svg",
        { viewBox: `0 0 ${SIZE.width} ${SIZE.height}`, role: "group", "aria-label": "Map of motion symbols" },
        ellipses,
        [...dots.values()],
      ),
    );
    markChosen();
  }

  function markChosen(): void {
    for (const [number, mark] of dots) {
      mark.classList.toggle("chosen", number === chosen);
      if (number === chosen) mark.setAttribute("aria-current", "true");
      else mark.removeAttribute("aria-current");
    }
  }

  function setZoom(next: Zoom): void {
    zoom = next.factor === 1 ? NO_ZOOM : next;
    draw();
  }

  /** The place of a pointer in the units of the picture. */
  function placeOf(event: MouseEvent): [x: number, y: number] {
    const box = element.getBoundingClientRect();
    const unit = Math.max(SIZE.width / box.width, SIZE.height / box.height);
    return [
      SIZE.width / 2 + (event.clientX - box.left - box.width / 2) * unit,
      SIZE.height / 2 + (event.clientY - box.top - box.height / 2) * unit,
    ];
  }

  element.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      setZoom(zoomAt(zoom, Math.exp(-event.deltaY * 0.0015), ...placeOf(event), SIZE));
    },
    { passive: false },
  );
  element.addEventListener("pointermove", (event) => {
    if (event.buttons !== 1 || zoom.factor === 1) return;
    const unit = SIZE.width / element.clientWidth;
    setZoom({ ...zoom, x: zoom.x + event.movementX * unit, y: zoom.y + event.movementY * unit });
  });

  return {
    element,
    show(space, axes) {
      shown = { space, axes };
      draw();
    },
    choose(symbol) {
      chosen = symbol;
      markChosen();
    },
    enlarge(by) {
      setZoom(by === 0 ? NO_ZOOM : zoomAt(zoom, by, SIZE.width / 2, SIZE.height / 2, SIZE));
    },
  };
}
