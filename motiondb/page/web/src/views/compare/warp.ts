/**
 * One motion played in the time of another: dynamic time warping.
 *
 * The poses of both parts are compared with the pelvis over one spot, facing one way. The path
 * through their distances d with the least sum gives each moment of the first part a moment of the
 * second: D(i, j) = d(i, j) + min(D(i-1, j), D(i, j-1), D(i-1, j-1)).
 */

import { poseAt, type Motion } from "../../player/motion.ts";
import type { Part } from "./address.ts";

/** Poses a second that are compared, and the most of a part; longer ones are looked at less often. */
const RATE = 15;
const MOST = 600;

/** For each row of a matrix of costs (rows, columns) the mean column of the cheapest path. */
export function cheapestPath(costs: readonly ArrayLike<number>[]): number[] {
  const columns = costs[0]?.length ?? 0;
  const sums: Float64Array[] = [];
  costs.forEach((row, i) => {
    const sum = new Float64Array(columns);
    for (let j = 0; j < columns; j += 1) {
      const before = Math.min(
        sums[i - 1]?.[j] ?? Infinity,
        j > 0 ? sum[j - 1]! : Infinity,
        j > 0 ? (sums[i - 1]?.[j - 1] ?? Infinity) : Infinity,
      );
      sum[j] = row[j]! + (i + j > 0 ? before : 0);
    }
    sums.push(sum);
  });
  const found: number[][] = costs.map(() => []);
  for (let i = costs.length - 1, j = columns - 1; i >= 0 && j >= 0;) {
    found[i]!.push(j);
    const [up, left, both] = [
      sums[i - 1]?.[j] ?? Infinity,
      j > 0 ? sums[i]![j - 1]! : Infinity,
      j > 0 ? (sums[i - 1]?.[j - 1] ?? Infinity) : Infinity,
    ];
    if (both <= up && both <= left) [i, j] = [i - 1, j - 1];
    else if (up <= left) i -= 1;
    else j -= 1;
  }
  return found.map((some) => some.reduce((a, b) => a + b, 0) / Math.max(some.length, 1));
}

/** Moments of a part, evenly. */
function momentsOf({ start, end }: Part): number[] {
  const n = Math.min(Math.max(Math.round((end - start) * RATE), 2), MOST);
  return Array.from({ length: n }, (_, i) => start + ((end - start) * i) / (n - 1));
}

/** The value at a place of evenly known ones. */
function between(values: readonly number[], place: number): number {
  const low = Math.min(Math.max(Math.floor(place), 0), values.length - 1);
  const high = Math.min(low + 1, values.length - 1);
  return values[low]! + (values[high]! - values[low]!) * Math.min(Math.max(place - low, 0), 1);
}

/**
 * The second motion in the time of the first. Inside the parts its time is stretched, so that like
 * poses come at like moments; before and after them it goes on as it was.
 */
export function inTimeOf(
  first: Motion,
  part: Part,
  second: Motion,
  other: Part,
  ownPose: (motion: Motion, time: number) => Float32Array,
): Motion {
  const [times, others] = [momentsOf(part), momentsOf(other)];
  const poses = others.map((time) => ownPose(second, time));
  const costs = times.map((time) => {
    const pose = ownPose(first, time);
    return poses.map((one) => distance(pose, one));
  });
  const moments = cheapestPath(costs).map((place) => between(others, place));
  const source = (time: number): number => {
    if (time <= part.start) return other.start + time - part.start;
    if (time >= part.end) return other.end + time - part.end;
    return between(moments, ((time - part.start) / (part.end - part.start)) * (times.length - 1));
  };
  const last = (motion: Motion): number => motion.start + (motion.frames - 1) / motion.fps;
  const from = part.start - Math.max(Math.min(part.start - first.start, other.start - second.start), 0);
  const to = part.end + Math.max(Math.min(last(first) - part.end, last(second) - other.end), 0);
  const frames = Math.max(Math.round((to - from) * first.fps) + 1, 1);
  const width = second.points.length * 3;
  const positions = new Float32Array(frames * width);
  const pose = new Float32Array(width);
  for (let frame = 0; frame < frames; frame += 1) {
    poseAt(second, source(from + frame / first.fps), pose);
    positions.set(pose, frame * width);
  }
  return { ...second, fps: first.fps, frames, start: from, positions, contacts: null };
}

/** The mean distance of the points of two poses, metres. */
function distance(a: Float32Array, b: Float32Array): number {
  let sum = 0;
  for (let k = 0; k < a.length; k += 3) {
    sum += Math.hypot(a[k]! - b[k]!, a[k + 1]! - b[k + 1]!, a[k + 2]! - b[k + 2]!);
  }
  return sum / (a.length / 3);
}
