/** The path of the root on the ground, seen from above, in the colours of the terminals. */

import { fill, h, svg } from "../../dom/element.ts";
import type { TerminalColours } from "./colours.ts";
import { cutPath, timesOf } from "./layout.ts";
import type { SequenceReply } from "../../api/types.ts";
import type { Spot } from "./selection.ts";

const SIZE = { width: 320, height: 220, margin: 22 };
/** A path that covers less ground than this is not enlarged any more, metres. */
const SMALLEST = 1.5;

/** One scale for both axes; x to the right, z towards the viewer, as the player shows it from above. */
function viewOf(points: readonly Spot[]) {
  const xs = points.map(([x]) => x);
  const zs = points.map(([, z]) => z);
  const [left, right, back, front] = [Math.min(...xs), Math.max(...xs), Math.min(...zs), Math.max(...zs)];
  const scale = Math.min(
    (SIZE.width - 2 * SIZE.margin) / Math.max(right - left, SMALLEST),
    (SIZE.height - 2 * SIZE.margin) / Math.max(front - back, SMALLEST),
  );
  return {
    scale,
    place: ([x, z]: Spot) => [
      SIZE.width / 2 + (x - (left + right) / 2) * scale,
      SIZE.height / 2 + (z - (back + front) / 2) * scale,
    ],
  };
}

type View = ReturnType<typeof viewOf>;

/** A length that is easy to read and fits as a scale bar, metres. */
function barLength(scale: number): number {
  return [0.5, 1, 2, 5, 10, 20, 50].find((metres) => metres * scale >= 36) ?? 100;
}

export function makePlan(choose: (at: number) => void) {
  const element = h("div.plan");
  const region = svg("g.plan-region");
  const here = svg("circle.plan-here", { r: 5 });
  let shown: SequenceReply | null = null;
  let view: View | null = null;

  const pointsOf = (line: readonly Spot[]): string =>
    line
      .map((spot) =>
        view!
          .place(spot)
          .map((value) => value.toFixed(1))
          .join(","),
      )
      .join(" ");

  function scaleBar(scale: number): SVGElement {
    const metres = barLength(scale);
    const [right, bottom] = [SIZE.width - 8, SIZE.height - 8];
    return svg(
      "g.plan-scale",
      svg("path", { d: `M${right - metres * scale} ${bottom}H${right}` }),
      svg("text", { x: right, y: bottom - 5 }, `${metres} m`),
    );
  }

  return {
    element,
    show(sequence: SequenceReply, colours: TerminalColours): void {
      shown = sequence;
      view = viewOf(sequence.path.points);
      const lines = sequence.strip.map((item) =>
        svg(
          "polyline",
          {
            points: pointsOf(cutPath(sequence.path, item.start, item.end)),
            stroke: colours.of(item.terminal).strong,
            on: { click: () => choose(item.at) },
          },
          svg("title", [item.terminal, ...item.words].join(" ")),
        ),
      );
      const [x, y] = view.place(sequence.path.points[0] ?? [0, 0]);
      fill(region);
      fill(
        element,
        svg(
          "svg",
          {
            viewBox: `0 0 ${SIZE.width} ${SIZE.height}`,
            role: "img",
            "aria-label": "Path of the root on the ground, from above",
          },
          region,
          svg("g.plan-path", lines),
          svg("circle.plan-start", { cx: x, cy: y, r: 3.5 }),
          here,
          scaleBar(view.scale),
        ),
      );
      this.setTime(0);
    },
    setTime(time: number): void {
      const [spot] = shown ? cutPath(shown.path, time, time) : [];
      if (!spot || !view) return;
      const [x, y] = view.place(spot);
      here.setAttribute("cx", x.toFixed(1));
      here.setAttribute("cy", y.toFixed(1));
    },
    mark(part: readonly [start: number, end: number] | null): void {
      if (!part || !shown || !view) return fill(region);
      const line = cutPath(shown.path, ...timesOf(shown.strip, ...part));
      fill(region, svg("polyline", { points: pointsOf(line) }));
    },
  };
}
