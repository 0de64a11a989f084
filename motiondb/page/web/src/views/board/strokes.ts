/** The lines of a tactics diagram in metres, as coaches draw them: curves, waves, zigzags, links. */

import { placeBefore } from "./edits.ts";
import { lookOf, verbOf } from "./verbs.ts";
import type { DiagramShape } from "../../api/types.ts";
import type { Spot } from "./spot.ts";

/** Radius of the circle of a player, metres. */
export const RADIUS = 0.36;

/** Height and length of the waves of a way with the object, and of the teeth of an act, metres. */
const WAVE = { height: 0.14, length: 0.7 };
const TEETH = { height: 0.2, length: 0.45 };
/** Samples between two points of a curve; with so many no corners are visible. */
const SAMPLES = 24;

export interface Stroke {
  points: Spot[];
  arrow: boolean;
  /** A bar across the end: a screen. */
  bar: boolean;
  look: "move" | "give" | "send" | "link";
}

const apart = (a: Spot, b: Spot): number => Math.hypot(a[0] - b[0], a[1] - b[1]);
const mix = (a: Spot, b: Spot, share: number): Spot => [
  a[0] + (b[0] - a[0]) * share,
  a[1] + (b[1] - a[1]) * share,
];

/** A centripetal Catmull-Rom spline through points; points at the same place count once. */
export function smoothCurve(points: readonly Spot[]): Spot[] {
  const through = points.filter((point, i) => i === 0 || apart(point, points[i - 1]!) > 1e-9);
  if (through.length < 2) return [...through];
  const first = mix(through[1]!, through[0]!, 2);
  const last = mix(through.at(-2)!, through.at(-1)!, 2);
  const extended = [first, ...through, last];
  const curve: Spot[] = [];
  for (let i = 0; i + 3 < extended.length; i += 1) curve.push(...part(extended.slice(i, i + 4)));
  return [...curve, through.at(-1)!];
}

function part(points: readonly Spot[]): Spot[] {
  const knots = [0];
  for (let i = 1; i < 4; i += 1) knots.push(knots[i - 1]! + Math.sqrt(apart(points[i - 1]!, points[i]!)));
  const at = (i: number): number => knots[i]!;
  return Array.from({ length: SAMPLES }, (_, k) => {
    const t = at(1) + ((at(2) - at(1)) * k) / SAMPLES;
    const share = (i: number, j: number): number => (t - at(i)) / (at(j) - at(i));
    const [a, b, c] = [0, 1, 2].map((i) => mix(points[i]!, points[i + 1]!, share(i, i + 1)));
    return mix(mix(a!, b!, share(0, 2)), mix(b!, c!, share(1, 3)), share(1, 2));
  });
}

/** Points along a line at about equal distances, with the distance and the normal of each. */
function evenly(points: readonly Spot[], spacing: number): { at: Spot; along: number; normal: Spot }[] {
  const along = [0];
  for (let i = 1; i < points.length; i += 1) along.push(along[i - 1]! + apart(points[i - 1]!, points[i]!));
  const whole = along.at(-1)!;
  const count = Math.max(Math.trunc(whole / spacing), 2);
  const placeAt = (distance: number): Spot => {
    const next = Math.max(
      along.findIndex((value) => value >= distance - 1e-12),
      1,
    );
    const share = (distance - along[next - 1]!) / (along[next]! - along[next - 1]! || 1);
    return mix(points[next - 1]!, points[next]!, share);
  };
  const even = Array.from({ length: count + 1 }, (_, i) => placeAt((whole * i) / count));
  return even.map((at, i) => {
    const [before, after] = [even[Math.max(i - 1, 0)]!, even[Math.min(i + 1, count)]!];
    const length = apart(before, after) || 1;
    return {
      at,
      along: (whole * i) / count,
      normal: [-(after[1] - before[1]) / length, (after[0] - before[0]) / length],
    };
  });
}

const shifted = ({ at, normal }: { at: Spot; normal: Spot }, by: number): Spot => [
  at[0] + normal[0] * by,
  at[1] + normal[1] * by,
];

/** A line with waves, straight at its end so that an arrow fits there. */
export function waved(points: readonly Spot[]): Spot[] {
  const even = evenly(points, 0.03);
  const whole = even.at(-1)!.along;
  const clip = (value: number): number => Math.min(Math.max(value, 0), 1);
  return even.map((one) => {
    const fade = clip((whole - 0.45 - one.along) / 0.2) * clip(one.along / 0.2);
    return shifted(one, WAVE.height * fade * Math.sin((2 * Math.PI * one.along) / WAVE.length));
  });
}

/** A line with teeth; its ends stay. */
export function zigzag(points: readonly Spot[]): Spot[] {
  const even = evenly(points, TEETH.length / 2);
  return even.map((one, i) =>
    i === 0 || i === even.length - 1 ? one.at : shifted(one, i % 2 ? TEETH.height : -TEETH.height),
  );
}

/** A path without the part inside the circle that it starts from. */
function fromCircle(points: Spot[]): Spot[] {
  const out = points.findIndex((point) => apart(point, points[0]!) > RADIUS);
  return out > 0 ? points.slice(out) : points;
}

/** A straight link from circle to circle, or to the target. */
function shortened(from: Spot, to: Spot, gap: number): Spot[] {
  const length = apart(from, to);
  if (length < RADIUS + gap + 0.1) return [from, to];
  return [mix(from, to, RADIUS / length), mix(from, to, 1 - gap / length)];
}

/** Whether a player has the object before an element, by following what is given from the first holder. */
function hasBall(diagram: DiagramShape, holder: string | null, player: string, step: number): boolean {
  let has = holder === player;
  for (const one of [...diagram.elements].sort((a, b) => a.step - b.step)) {
    if (lookOf(one.kind) !== "give") continue;
    if (one.player === player && one.step < step) has = false;
    if (one.other === player && Math.max(one.step, one.caught) < step) has = true;
  }
  return has;
}

/** The line of an element. */
export function strokeOf(diagram: DiagramShape, index: number, holder: string | null): Stroke {
  const element = diagram.elements[index]!;
  const { kind, step, player } = element;
  const from = placeBefore(diagram, player, step, index);
  let look = lookOf(kind, hasBall(diagram, holder, player, step));
  if (look === "act" && element.other && !element.to) look = "link";
  const placed = diagram.places.find((one) => one.name === element.target);
  if (look === "send") {
    const target = placed ?? diagram.places.find((one) => one.width > 0);
    const to = element.other ? placeBefore(diagram, element.other, step, index) : target?.at;
    return { points: to ? shortened(from, to, 0.25) : [from], arrow: true, bar: false, look: "send" };
  }
  if ((look === "give" || look === "link") && (element.other || placed)) {
    const until = look === "give" ? Math.max(element.caught, step) : step;
    const to = element.other ? placeBefore(diagram, element.other, until, index) : placed!.at;
    return { points: shortened(from, to, RADIUS), arrow: look === "give", bar: false, look };
  }
  if (look === "act") {
    const way = element.to
      ? fromCircle(smoothCurve([from, ...element.via, element.to]))
      : ([
          [from[0] + 0.45, from[1]],
          [from[0] + 1.25, from[1]],
        ] as Spot[]);
    return { points: zigzag(way), arrow: element.to !== null, bar: false, look: "move" };
  }
  const way = smoothCurve([from, ...element.via, ...(element.to ? [element.to] : [])]);
  const points = fromCircle(way);
  const bar = verbOf(kind)?.bar ?? false;
  return {
    points: look === "wave" && points.length > 1 ? waved(points) : points,
    arrow: !bar && element.to !== null,
    bar,
    look: "move",
  };
}
