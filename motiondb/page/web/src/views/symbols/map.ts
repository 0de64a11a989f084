/** The map of motion symbols: a dot for each, an ellipse for each cluster. Nearby symbols are alike. */

import type { PlacedSymbol, SpaceReply } from "../../api/types.ts";
import { h, svg } from "../../dom/element.ts";
import { pixelsOf } from "../../dom/wheel.ts";
import { tintOf, type Tint } from "../../parts/tint.ts";
import type { Motions } from "../../api/motions.ts";
import { axisEnds, LIKELY, type AxisEnds } from "./clusters.ts";
import { makeMapFigures, type Spot } from "./figures.ts";
import { placeMarks, type Placed } from "./labels.ts";
import { ellipseOf, fitAxes, NO_ZOOM, zoomAt, zoomed, type Zoom } from "./projection.ts";

const PLAIN: Tint = { soft: "var(--accent-soft)", strong: "var(--accent-line)" };
const WIDE = { width: 900, height: 640, margin: 60 };
/** On a phone the same units would be too small to read. */
const NARROW = { width: 420, height: 460, margin: 36 };

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

export function makeSymbolMap(motions: Motions, click: (symbol: number) => void) {
  const SIZE = innerWidth < 700 ? NARROW : WIDE;
  const figures = makeMapFigures(motions, SIZE);
  const picture = h("div");
  const element = h("div.symbol-map", picture, figures.element);
  let dots = new Map<number, SVGElement>();
  let shown: { space: SpaceReply; axes: readonly [number, number] } | null = null;
  let chosen: number | null = null;
  let found: ReadonlySet<number> | null = null;
  let zoom: Zoom = NO_ZOOM;
  let spots: Spot[] = [];
  let words: SVGElement[] = [];

  function dot(facts: PlacedSymbol, placed: Placed, written: boolean): SVGElement {
    const { x, y, radius: size } = placed;
    // One cluster alone needs no colour of its own.
    const tint = shown!.space.clusters.length > 1 ? tintOf(facts.cluster) : PLAIN;
    const press = (): void => click(facts.symbol);
    return svg(
      "g.dot",
      {
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
      svg("title", nameOf(facts)),
      svg("circle", { r: size, fill: tint.soft, stroke: tint.strong }),
      // Words that fit are written above all dots; the others appear while the dot is looked at.
      written ? null : svg("text.dot-word.covered", { y: size + 14 }, placed.word),
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
    const several = clusters.length > 1 ? clusters : []; // one alone says nothing
    const ellipses = several.map(({ cluster, mean, covariance }) => {
      const { x, y, rx, ry, angle } = ellipseOf(mean, covariance, axes);
      return svg(
        "ellipse.cluster",
        {
          cx: x,
          cy: y,
          rx,
          ry,
          transform: `rotate(${angle} ${x} ${y})`,
          stroke: tintOf(cluster).strong,
        },
        svg("title", `Cluster ${cluster}`),
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
    const marks = placeMarks(placed);
    dots = new Map(ordered.map((one, i) => [one.symbol, dot(one, placed[i]!, marks.words[i]!)]));
    spots = ordered.flatMap((one, i) =>
      marks.figures[i] ? [{ symbol: one.symbol, x: placed[i]!.x, y: placed[i]!.y }] : [],
    );
    words = placed.flatMap(({ x, y, radius: size, word }, i) =>
      marks.words[i]
        ? [svg("text.dot-word", { "data-of": ordered[i]!.symbol, x, y: y + size + 14 }, word)]
        : [],
    );
    picture.replaceChildren(
      svg(
        "svg",
        { viewBox: `0 0 ${SIZE.width} ${SIZE.height}`, role: "group", "aria-label": "Map of motion symbols" },
        ellipses,
        [...dots.values()],
        axisNames(shown.space.symbols, shown.axes),
        svg("g.map-words", { "aria-hidden": "true" }, words),
      ),
    );
    markChosen();
  }

  /** What lies at the ends of both axes, at the edges of the picture. */
  function axisNames(symbols: readonly PlacedSymbol[], axes: readonly [number, number]): SVGElement[] {
    const [across, up] = axes.map((axis) => axisEnds(symbols, axis)) as [AxisEnds, AxisEnds];
    const { width, height } = SIZE;
    const name = (words: readonly string[], before: string, after: string, place: object): SVGElement[] =>
      words.length ? [svg("text.map-axis", { ...place }, before + words.join(", ") + after)] : [];
    return [
      ...name(across.low, "← ", "", { x: 4, y: height - 6 }),
      ...name(across.high, "", " →", { x: width - 4, y: height - 6, "text-anchor": "end" }),
      ...name(up.high, "↑ ", "", { x: 4, y: 14 }),
      ...name(up.low, "↓ ", "", { x: width / 2, y: height - 6, "text-anchor": "middle" }),
    ];
  }

  /** Draw a dot over those around it. */
  function raise(mark: SVGElement): void {
    const focused = mark === document.activeElement; // an element that is moved loses the focus
    mark.parentNode?.append(mark);
    if (focused) mark.focus();
  }

  function markChosen(): void {
    for (const [number, mark] of dots) {
      mark.classList.toggle("chosen", number === chosen);
      mark.classList.toggle("other", found !== null && !found.has(number));
      if (number === chosen) {
        mark.setAttribute("aria-current", "true");
        raise(mark);
      } else mark.removeAttribute("aria-current");
    }
    for (const word of words) {
      const of = Number(word.dataset["of"]);
      word.classList.toggle("other", found !== null && !found.has(of));
      word.classList.toggle("chosen", of === chosen);
    }
    figures.place(spots.filter(({ symbol }) => !found || found.has(symbol)));
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
      setZoom(zoomAt(zoom, Math.exp(-pixelsOf(event) * 0.0015), ...placeOf(event), SIZE));
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
    show(space: SpaceReply, axes: readonly [number, number]): void {
      if (shown?.space !== space) figures.load(space.symbols);
      shown = { space, axes };
      draw();
    },
    choose(symbol: number | null): void {
      chosen = symbol;
      markChosen();
    },
    /** Show these symbols strongly and the others faintly; null: all alike. */
    find(symbols: ReadonlySet<number> | null): void {
      found = symbols;
      markChosen();
    },
    close: figures.close,
    /** Enlarge (above 1) or shrink around the middle; 0: see everything. */
    enlarge(by: number): void {
      setZoom(by === 0 ? NO_ZOOM : zoomAt(zoom, by, SIZE.width / 2, SIZE.height / 2, SIZE));
    },
  };
}
