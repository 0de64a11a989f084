/** A path on the floor: drawn from above, or written as points in metres. */

import { fill, h, svg } from "../../dom/element.ts";

export interface PathField {
  readonly element: HTMLElement;
  /** Points as the server reads them, "0,0 0,2 -1.5,2"; "" where nothing is drawn. */
  value: string;
}

type Point = readonly [number, number];

/** A line that is being drawn, and how far apart its points are at least, metres. */
export interface Stroke {
  readonly points: readonly Point[];
  readonly apart: number;
}

/** Metres from the middle of the floor to its edge, and between drawn points. */
const REACH = 4;
const APART = 0.15;
export const MOST = 150;

/** A line that begins at a point; it is drawn from its second point on. */
export const strokeFrom = (at: Point): Stroke => ({ points: [at], apart: APART });

/** A line with one more point, if that is far enough; of too many points every second one is kept. */
export function strokeTo(stroke: Stroke, at: Point): Stroke {
  const [x, y] = stroke.points.at(-1)!;
  if (Math.hypot(at[0] - x, at[1] - y) < stroke.apart) return stroke;
  const points = [...stroke.points, at];
  if (points.length <= MOST) return { ...stroke, points };
  return { points: points.filter((_, n) => n % 2 === 0), apart: 2 * stroke.apart };
}

/** The points of a text; null if it holds anything else. */
export function pointsOf(text: string): Point[] | null {
  const points = text
    .trim()
    .split(/[\s;]+/)
    .filter(Boolean)
    .map((pair) => pair.split(",").map(Number));
  const sound = points.every((pair) => pair.length === 2 && pair.every(Number.isFinite));
  return sound ? (points as unknown as Point[]) : null;
}

/** The line of some points as a picture from above, its beginning marked. */
function lineOf(points: readonly Point[]): SVGElement[] {
  if (points.length === 0) return [];
  const [first] = points;
  return [
    svg("polyline.path-line", {
      points: points.map(([x, y]) => `${x},${-y}`).join(" "),
      "marker-end": "url(#path-end)",
    }),
    svg("circle.path-start", { cx: first![0], cy: -first![1], r: 0.12 }),
  ];
}

/** A floor of 8 by 8 m to draw on, with the points as text below it; `drew` ends a drawn line. */
export function makePathField(id: string, drew: () => void): PathField {
  const text = h("input.field", {
    id,
    placeholder: "0,0 0,2 -1.5,2",
    spellcheck: false,
    on: { input: () => show(pointsOf(text.value) ?? []) },
  });
  const line = svg("g");
  const grid = Array.from({ length: 2 * REACH - 1 }, (_, n) => n - REACH + 1).flatMap((at) => [
    svg("line.path-grid", { x1: at, x2: at, y1: -REACH, y2: REACH }),
    svg("line.path-grid", { y1: at, y2: at, x1: -REACH, x2: REACH }),
  ]);
  const floor = svg(
    "svg.path-floor",
    { viewBox: `${-REACH} ${-REACH} ${2 * REACH} ${2 * REACH}`, "aria-hidden": "true" },
    svg(
      "marker",
      {
        id: "path-end",
        orient: "auto",
        viewBox: "0 0 4 4",
        refX: 2,
        refY: 2,
        markerWidth: 4,
        markerHeight: 4,
      },
      svg("path.path-start", { d: "M0 0 L4 2 L0 4 z" }),
    ),
    grid,
    line,
  );
  let drawn: Stroke | null = null;

  function show(points: readonly Point[]): void {
    fill(line, lineOf(points));
  }

  function at(event: PointerEvent): Point {
    const box = floor.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * 2 * REACH - REACH;
    const y = REACH - ((event.clientY - box.top) / box.height) * 2 * REACH;
    return [Math.round(x * 100) / 100, Math.round(y * 100) / 100];
  }

  function extend(event: PointerEvent): void {
    if (!drawn) return;
    const longer = strokeTo(drawn, at(event));
    if (longer === drawn) return;
    drawn = longer;
    text.value = drawn.points.map((point) => point.join(",")).join(" ");
    show(drawn.points);
  }

  floor.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    floor.setPointerCapture(event.pointerId);
    drawn = strokeFrom(at(event)); // what was drawn before stays until the pointer moves
  });
  floor.addEventListener("pointermove", extend);
  const end = (): void => {
    if (drawn && drawn.points.length > 1) drew();
    drawn = null;
  };
  floor.addEventListener("pointerup", end);
  floor.addEventListener("pointercancel", end);
  return {
    element: h(
      "div.path-field",
      floor,
      text,
      h("p.muted.small", "Drawn from above; a square is a metre. Place and direction are free."),
    ),
    get value() {
      return text.value.trim();
    },
    set value(points) {
      if (points === text.value.trim()) return;
      text.value = points;
      show(pointsOf(points) ?? []);
    },
  };
}
