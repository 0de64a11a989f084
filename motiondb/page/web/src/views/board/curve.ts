/** The error of a scene while it is sampled, on a logarithmic scale. */

import { fill, h, svg } from "../../dom/element.ts";

const SIZE = { width: 320, height: 76, left: 44, bottom: 16 };

/** Points of the picture for a curve of [share, error]; errors that are not positive are left out. */
export function curvePoints(
  curve: readonly (readonly [number, number])[],
  width: number,
  height: number,
): [x: number, y: number][] {
  const known = curve.filter(([, error]) => error > 0);
  if (known.length === 0) return [];
  const logs = known.map(([, error]) => Math.log(error));
  const [low, high] = [Math.min(...logs), Math.max(...logs)];
  const most = Math.max(...known.map(([share]) => share), 1e-9);
  return known.map(([share], i) => [
    (share / most) * width,
    high > low ? ((high - logs[i]!) / (high - low)) * height : height / 2,
  ]);
}

/** The points of each try: a scene with broken rules is sampled again, from the start. */
export function triesOf(points: readonly (readonly [number, number])[]): (readonly [number, number])[][] {
  const tries: (readonly [number, number])[][] = [];
  points.forEach((point, i) => {
    if (i === 0 || point[0] < points[i - 1]![0]) tries.push([]);
    tries.at(-1)!.push(point);
  });
  return tries;
}

const short = (value: number): string => (value >= 100 ? value.toFixed(0) : value.toPrecision(2));

export function makeErrorCurve() {
  const element = h("div.board-curve");
  return {
    element,
    show(curve: readonly (readonly [number, number])[]): void {
      const known = curve.filter(([, error]) => error > 0).map(([, error]) => error);
      if (known.length < 2) {
        element.replaceChildren();
        return;
      }
      const [width, height] = [SIZE.width - SIZE.left, SIZE.height - SIZE.bottom - 6];
      const tries = triesOf(curvePoints(curve, width, height));
      const again = tries.length > 1 ? `, try ${tries.length}` : "";
      const [first, last] = [known[0]!, known.at(-1)!];
      fill(
        element,
        svg(
          "svg",
          {
            viewBox: `0 0 ${SIZE.width} ${SIZE.height}`,
            role: "img",
            "aria-label": `Error of the scene while sampling: from ${short(first)} down to ${short(last)}`,
          },
          svg("text", { x: SIZE.left - 6, y: 12, "text-anchor": "end" }, short(Math.max(...known))),
          svg("text", { x: SIZE.left - 6, y: height + 6, "text-anchor": "end" }, short(Math.min(...known))),
          svg("line.board-axis", { x1: SIZE.left, y1: height + 6, x2: SIZE.width, y2: height + 6 }),
          tries.map((points, i) =>
            svg("polyline", {
              class: i + 1 < tries.length ? "board-error earlier" : "board-error",
              points: points.map(([x, y]) => `${(SIZE.left + x).toFixed(1)},${(6 + y).toFixed(1)}`).join(" "),
            }),
          ),
          svg(
            "text",
            { x: SIZE.left, y: SIZE.height - 2 },
            `how far from natural and from its rules${again}`,
          ),
        ),
      );
    },
  };
}
