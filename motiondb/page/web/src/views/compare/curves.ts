/** The differences to the first figure over time, one curve for each other figure. */

import { fill, h, svg } from "../../dom/element.ts";
import { bodyPart, type Difference } from "./aligned.ts";

export interface Curve {
  /** The number of the figure, from 1. */
  figure: number;
  colour: string;
  difference: Difference;
}

const HEIGHT = 64;
/** The scale is at least this, metres: the curves of like motions stay low. */
const LEAST = 0.2;

const centimetres = (metres: number): string => `${Math.round(metres * 100)} cm`;

export function makeCurves() {
  const element = h("div.compare-curves");
  const cursor = svg("line.compare-cursor", { y1: 0, y2: HEIGHT });
  const now = h("ul.plain.small.compare-now");
  let shown: readonly Curve[] = [];
  let points: readonly string[] = [];

  function said({ figure, colour, difference: { times, mean, worst } }: Curve, time: number): HTMLElement {
    const swatch = h("span.swatch", { style: { background: colour } });
    const [first, last] = [times[0], times.at(-1)];
    const covered = first !== undefined && time >= first - 0.05 && time <= last! + 0.05;
    const n = covered
      ? times.reduce((best, t, i) => (Math.abs(t - time) < Math.abs(times[best]! - time) ? i : best), 0)
      : -1;
    const here =
      n < 0
        ? "not both there now"
        : `${centimetres(mean[n]!)} now, most at the ${bodyPart(points[worst[n]!] ?? "")}`;
    const whole = mean.length
      ? `, ${centimetres(mean.reduce((a, b) => a + b, 0) / mean.length)} on average`
      : "";
    return h("li", swatch, h("b", `${figure} and 1`), `: ${here}${whole}`);
  }

  function setTime(time: number): void {
    cursor.setAttribute("x1", String(time));
    cursor.setAttribute("x2", String(time));
    fill(
      now,
      shown.map((one) => said(one, time)),
    );
  }

  return {
    element,
    show(curves: readonly Curve[], names: readonly string[], duration: number): void {
      shown = curves;
      points = names;
      if (curves.length === 0) return element.replaceChildren();
      const most = Math.max(LEAST, ...curves.flatMap((one) => one.difference.mean));
      const lines = curves.map(({ colour, difference: { times, mean } }) =>
        svg("polyline.compare-curve", {
          stroke: colour,
          points: times
            .map((t, i) => `${t.toFixed(3)},${(HEIGHT * (1 - mean[i]! / most)).toFixed(2)}`)
            .join(" "),
        }),
      );
      fill(
        element,
        h("h3", "Difference of the poses"),
        h(
          "p.small.muted",
          "Mean distance of the joints, at the same moment, with the pelvis on one spot and facing the same way.",
        ),
        h(
          "div.compare-plot",
          h("span.compare-most", centimetres(most)),
          svg(
            "svg",
            { viewBox: `0 0 ${duration} ${HEIGHT}`, preserveAspectRatio: "none", "aria-hidden": "true" },
            lines,
            cursor,
          ),
        ),
        now,
      );
    },
    setTime,
  };
}
