/** A motion as the player reads it: points of a body over time. Metres, seconds, y up. */

export interface Motion {
  fps: number;
  frames: number;
  /** Seconds in the take of the first frame. */
  start: number;
  points: readonly string[];
  /** The number of each point's parent, -1 for the root. */
  parents: readonly number[];
  /** Radius of the capsule that ends in each point, metres. */
  radii: readonly number[];
  /** (frames, points, 3). */
  positions: Float32Array;
  /** (frames,): bit 0 the left foot is on the ground, bit 1 the right foot; null where not known. */
  contacts: Uint8Array | null;
  /** Of a thumbnail: the time in the take of the pose that shows what happens. */
  moment?: number | null;
}

/** A ball over time. */
export interface BallMotion {
  fps: number;
  frames: number;
  start: number;
  /** (frames, 3). */
  positions: Float32Array;
  radius: number;
}

/** The position of a time among frames: the frame before it, and the fraction of the way to the next. */
function placeAt(motion: { fps: number; frames: number; start: number }, seconds: number): [number, number] {
  const place = Math.min(Math.max((seconds - motion.start) * motion.fps, 0), motion.frames - 1);
  const before = Math.floor(place);
  return [before, place - before];
}

/** The frame that is shown at a time of the take, counted from the first frame of the motion. */
export function frameAt(motion: Motion, seconds: number): number {
  const frame = Math.floor((seconds - motion.start) * motion.fps + 1e-6);
  return Math.min(Math.max(frame, 0), motion.frames - 1);
}

/** Write the values of a time into `pose`, interpolated between the two frames around it. */
export function poseAt(
  motion: Pick<Motion, "fps" | "frames" | "start" | "positions">,
  seconds: number,
  pose: Float32Array,
): void {
  if (motion.frames === 0) return;
  const [before, share] = placeAt(motion, seconds);
  const first = before * pose.length;
  const second = Math.min(before + 1, motion.frames - 1) * pose.length;
  for (let i = 0; i < pose.length; i += 1) {
    const a = motion.positions[first + i]!;
    pose[i] = a + share * (motion.positions[second + i]! - a);
  }
}

export interface Box {
  min: [number, number, number];
  max: [number, number, number];
}

function emptyBox(): Box {
  return { min: [Infinity, Infinity, Infinity], max: [-Infinity, -Infinity, -Infinity] };
}

/** The box around all points between two times of the take. */
export function boundsOf(motion: Motion, from = -Infinity, to = Infinity): Box {
  const box = emptyBox();
  const size = motion.points.length * 3;
  const start = Math.max(Math.floor((from - motion.start) * motion.fps), 0);
  const end = Math.min(Math.ceil((to - motion.start) * motion.fps) + 1, motion.frames);
  for (let i = start * size; i < end * size; i += 1) {
    const value = motion.positions[i]!;
    box.min[i % 3] = Math.min(box.min[i % 3]!, value);
    box.max[i % 3] = Math.max(box.max[i % 3]!, value);
  }
  return box;
}

/** The smallest box around several boxes; a box of a standing person where there are none. */
export function unite(boxes: readonly Box[]): Box {
  const all = emptyBox();
  for (const box of boxes) {
    for (let axis = 0; axis < 3; axis += 1) {
      all.min[axis] = Math.min(all.min[axis]!, box.min[axis]!);
      all.max[axis] = Math.max(all.max[axis]!, box.max[axis]!);
    }
  }
  return Number.isFinite(all.min[0]) ? all : { min: [-0.5, 0, -0.5], max: [0.5, 1.75, 0.5] };
}

/** Seconds before and after its time in which a box is seen. Chosen by eye. */
const AROUND = 0.5;

/** Which boxes are seen at a time. */
export function seenAt(parts: readonly { start: number; end: number }[], time: number): boolean[] {
  return parts.map(({ start, end }) => start - AROUND <= time && time < end + AROUND);
}
