/** Where the terminals of a sequence and the nodes of its tree lie, and which part of a path they cover. */

import type { RootPath, WordedTerminal, TreeNode } from "../../api/types.ts";
import type { Spot } from "./selection.ts";

/** A terminal is drawn as if it lasted at least this share of the mean: its letter must fit. */
const LEAST = 0.45;

/** Left edges and widths as shares of the whole strip. */
export interface StripLayout {
  readonly lefts: readonly number[];
  readonly widths: readonly number[];
}

/** Widths follow the durations, but very short terminals are widened. */
export function layStrip(strip: readonly Pick<WordedTerminal, "start" | "end">[]): StripLayout {
  const durations = strip.map(({ start, end }) => Math.max(end - start, 0));
  const mean = durations.reduce((sum, one) => sum + one, 0) / Math.max(strip.length, 1);
  const drawn = durations.map((one) => Math.max(one, LEAST * mean, 1e-6));
  const whole = drawn.reduce((sum, one) => sum + one, 0);
  const widths = drawn.map((one) => one / whole);
  let left = 0;
  const lefts = widths.map((width) => {
    const here = left;
    left += width;
    return here;
  });
  return { lefts, widths };
}

/** Left edge and width of the positions from `start` up to, but not including, `end`. */
export function placeOf(layout: StripLayout, start: number, end: number): [left: number, width: number] {
  const left = start < layout.lefts.length ? layout.lefts[start]! : 1;
  const right = end < layout.lefts.length ? layout.lefts[end]! : 1;
  return [left, Math.max(right - left, 0)];
}

/** The position that plays at a time. */
export function positionAt(strip: readonly Pick<WordedTerminal, "start" | "end">[], time: number): number {
  const after = strip.findIndex(({ end }) => time < end);
  return after < 0 ? strip.length - 1 : after;
}

/** Where a time lies on the strip, as a share of it. */
export function placeOfTime(
  layout: StripLayout,
  strip: readonly Pick<WordedTerminal, "start" | "end">[],
  time: number,
): number {
  const at = positionAt(strip, time);
  if (at < 0) return 0;
  const { start, end } = strip[at]!;
  const share = Math.min(Math.max((time - start) / Math.max(end - start, 1e-9), 0), 1);
  return layout.lefts[at]! + share * layout.widths[at]!;
}

/** The times that the positions from `start` to `end` cover; for an empty range, the time of the seam. */
export function timesOf(
  strip: readonly Pick<WordedTerminal, "start" | "end">[],
  start: number,
  end: number,
): [from: number, to: number] {
  if (start < end) return [strip[start]!.start, strip[end - 1]!.end];
  const seam = strip[start]?.start ?? strip.at(-1)?.end ?? 0;
  return [seam, seam];
}

/** The points of a path between two times, with both ends. */
export function cutPath(path: RootPath, from: number, to: number): Spot[] {
  const { fps, points } = path;
  const last = points.length - 1;
  if (last < 0) return [];
  const at = (time: number): Spot => {
    const place = Math.min(Math.max(time * fps, 0), last);
    const before = Math.min(Math.floor(place), Math.max(last - 1, 0));
    const share = place - before;
    const [a, b] = [points[before]!, points[Math.min(before + 1, last)]!];
    return [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
  };
  const inside = points.filter((_, i) => i > from * fps + 1e-6 && i < to * fps - 1e-6);
  return [at(from), ...inside, at(to)];
}

/** Points along a line at equal distances; a line of length 0 has one. */
export function spaced(line: readonly Spot[], distance: number): Spot[] {
  const spots: Spot[] = line.length > 0 ? [line[0]!] : [];
  let left = distance;
  for (let i = 1; i < line.length; i += 1) {
    const [a, b] = [line[i - 1]!, line[i]!];
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
    let along = left;
    for (; along <= length; along += distance) {
      const share = along / length;
      spots.push([a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]);
    }
    left = along - length;
  }
  return spots;
}

/** The number of edges from the root to each node; parents stand before their children. */
export function depthsOf(tree: readonly TreeNode[]): number[] {
  const depths: number[] = [];
  for (const { parent } of tree) depths.push(parent < 0 ? 0 : depths[parent]! + 1);
  return depths;
}

/** The nodes from the root to the nonterminal that generates a position. */
export function lineTo(tree: readonly TreeNode[], at: number): number[] {
  const leaf = tree.findIndex((node) => node.is_terminal && node.start === at);
  const line: number[] = [];
  for (let node = tree[leaf]?.parent ?? -1; node >= 0; node = tree[node]!.parent) line.push(node);
  return line.reverse();
}

/** The region that a terminal has after it was widened by some levels; null: there is none. */
export function regionOf(tree: readonly TreeNode[], at: number, wider: number): number | null {
  const line = lineTo(tree, at);
  return line[line.length - 1 - wider] ?? null;
}

/** How a node is reached: a position in it, and the levels by which that position's region is widened. */
export function waysTo(
  tree: readonly TreeNode[],
  node: number,
  near: number,
): { at: number; wider: number } | null {
  const { start, end, is_terminal } = tree[node]!;
  if (is_terminal || end <= start) return null;
  const positions = near >= start && near < end ? [near, start] : [start];
  for (const at of positions) {
    const line = lineTo(tree, at);
    const place = line.indexOf(node);
    if (place >= 0) return { at, wider: line.length - 1 - place };
  }
  return null;
}
