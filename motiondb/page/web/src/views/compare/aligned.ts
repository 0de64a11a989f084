/** Motions brought to one clock and one ground: aligned at a moment, moved and turned alike. */

import type { BodyTrack } from "../../api/container.ts";
import { poseAt, type Motion } from "../../player/motion.ts";
import type { Interval } from "../../timeline/timeline.ts";
import type { Moment, Part } from "./address.ts";
import { inTimeOf } from "./warp.ts";

type Pose = Pick<Motion, "points" | "positions" | "fps" | "frames" | "start">;

/** Metres between figures that stand side by side. Chosen by eye: arms and steps have room. */
const APART = 1.7;
/** Steps a second at which differences are measured. */
const RATE = 15;

/** The time of a part that is shown at the same moment as those of the others. */
export function momentOf({ start, end }: Part, at: Moment): number {
  return at === "end" ? end : at === "middle" ? (start + end) / 2 : start;
}

/** The direction that the hips face, radians around the vertical; 0 where there are no hips. */
export function headingOf(points: readonly string[], pose: ArrayLike<number>): number {
  const [left, right] = [points.indexOf("l_hip"), points.indexOf("r_hip")];
  if (left < 0 || right < 0) return 0;
  const across = (axis: number): number => pose[3 * left + axis]! - pose[3 * right + axis]!;
  return Math.atan2(-across(2), across(0));
}

/** Turn places around the vertical and move them: the origin and the heading become those of a place. */
function moved(
  positions: ArrayLike<number>,
  [x, z]: readonly [number, number],
  heading: number,
  [toX, toZ]: readonly [number, number],
): Float32Array {
  const [c, s] = [Math.cos(-heading), Math.sin(-heading)];
  const out = new Float32Array(positions.length);
  for (let i = 0; i < positions.length; i += 3) {
    const [dx, dz] = [positions[i]! - x, positions[i + 2]! - z];
    out[i] = c * dx + s * dz + toX;
    out[i + 1] = positions[i + 1]!;
    out[i + 2] = c * dz - s * dx + toZ;
  }
  return out;
}

/**
 * Tracks on one clock, each facing the same way at its moment, side by side or on one spot.
 * Returns them with the interval of each part on the common clock.
 */
export function alignTracks(
  takes: readonly BodyTrack[],
  found: readonly Part[],
  at: Moment,
  overlaid: boolean,
): { tracks: BodyTrack[]; spans: Interval[] } {
  const stretched = at === "poses";
  const tracks = takes.map((track, i) =>
    stretched && i > 0
      ? { ...track, motion: inTimeOf(takes[0]!.motion, found[0]!, track.motion, found[i]!, ownPose) }
      : track,
  );
  const parts = stretched ? found.map(() => found[0]!) : found;
  const before = tracks.map(({ motion }, i) => momentOf(parts[i]!, at) - motion.start);
  const clock = Math.max(...before, 0);
  const shifts = tracks.map((_, i) => clock - momentOf(parts[i]!, at));
  return {
    spans: parts.map(({ start, end }, i): Interval => [start + shifts[i]!, end + shifts[i]!]),
    tracks: tracks.map((track, i) => {
      const { motion } = track;
      const pose = new Float32Array(motion.points.length * 3);
      poseAt(motion, momentOf(parts[i]!, at), pose);
      const slot = overlaid ? 0 : (i - (tracks.length - 1) / 2) * APART;
      const positions = moved(motion.positions, [pose[0]!, pose[2]!], headingOf(motion.points, pose), [
        slot,
        0,
      ]);
      return { ...track, motion: { ...motion, start: motion.start + shifts[i]!, positions } };
    }),
  };
}

/** How far two motions are apart at the moments that both cover. */
export interface Difference {
  times: number[];
  /** Mean distance over the body at each time, metres. */
  mean: number[];
  /** The number of the point that is farthest from its counterpart at each time. */
  worst: number[];
}

/** The pose of a time with the pelvis over the origin, facing +z. */
function ownPose(motion: Pose, time: number): Float32Array {
  const pose = new Float32Array(motion.points.length * 3);
  poseAt(motion, time, pose);
  return moved(pose, [pose[0]!, pose[2]!], headingOf(motion.points, pose), [0, 0]);
}

/**
 * The distance of two motions moment by moment, each with its pelvis over one spot and facing the
 * same way, so that where they go does not count. Their times are taken as they are.
 */
export function differenceOf(first: Pose, second: Pose): Difference {
  const from = Math.max(first.start, second.start);
  const end = (one: Pose): number => one.start + (one.frames - 1) / one.fps;
  const to = Math.min(end(first), end(second));
  const found: Difference = { times: [], mean: [], worst: [] };
  for (let n = 0; n / RATE <= to - from; n += 1) {
    const time = from + n / RATE;
    const [a, b] = [ownPose(first, time), ownPose(second, time)];
    let [sum, most, worst] = [0, -1, 0];
    for (let p = 0; p < a.length / 3; p += 1) {
      const apart = Math.hypot(
        a[3 * p]! - b[3 * p]!,
        a[3 * p + 1]! - b[3 * p + 1]!,
        a[3 * p + 2]! - b[3 * p + 2]!,
      );
      sum += apart;
      if (apart > most) [most, worst] = [apart, p];
    }
    found.times.push(time);
    found.mean.push(sum / (a.length / 3));
    found.worst.push(worst);
  }
  return found;
}

/** The name of a point in words: `l_hand_end` is the left hand. */
export function bodyPart(point: string): string {
  const side = point.startsWith("l_") ? "left " : point.startsWith("r_") ? "right " : "";
  return side + point.replace(/^[lr]_/, "").replace(/_end$/, "");
}
