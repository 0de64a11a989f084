/**
 * The volume of a figure that is no mannequin: which capsules to draw between its points. So are
 * bodies with other points, and all bodies where there is no WebGL.
 *
 * The canonical points of motiondb get tapered capsules with the radii of an average adult; other
 * skeletons get the radii that come with the motion.
 */

export interface Bone {
  /** Points at the two ends. */
  from: number;
  to: number;
  /** Radii at the two ends, metres. */
  fromRadius: number;
  toRadius: number;
}

type Row = readonly [from: string, to: string, fromRadius: number, toRadius: number];

/** One side of the body, to be mirrored. Chosen by hand so that the figure looks like an adult. */
const SIDE: readonly Row[] = [
  ["hip", "knee", 0.09, 0.06],
  ["knee", "ankle", 0.06, 0.04],
  ["ankle", "toe", 0.042, 0.036],
  ["toe", "toe_end", 0.036, 0.028],
  ["chest", "collar", 0.1, 0.07],
  ["collar", "shoulder", 0.072, 0.062],
  ["shoulder", "elbow", 0.056, 0.045],
  ["elbow", "wrist", 0.044, 0.032],
  ["wrist", "hand_end", 0.038, 0.03],
];

const MIDDLE: readonly Row[] = [
  ["l_hip", "r_hip", 0.094, 0.094],
  ["pelvis", "spine", 0.114, 0.106],
  ["spine", "chest", 0.108, 0.12],
  ["chest", "neck", 0.115, 0.06],
  ["neck", "head", 0.056, 0.065],
  ["head", "head_end", 0.082, 0.094],
];

const CENTRAL = new Set(["chest"]);

function sided(name: string, side: string): string {
  return CENTRAL.has(name) ? name : `${side}_${name}`;
}

const TABLE: readonly Row[] = [
  ...MIDDLE,
  ...["l", "r"].flatMap((side) =>
    SIDE.map(([from, to, a, b]): Row => [sided(from, side), sided(to, side), a, b]),
  ),
];

/** The head's capsule ends in the middle of the skull, not at its top: share of the way. */
const HEAD_SHARE = 0.55;
/** The same for hands, whose end lies at the finger tips. */
const HAND_SHARE = 0.8;

/** The capsules of a body with these points. */
export function bonesOf(
  points: readonly string[],
  parents: readonly number[],
  radii: readonly number[],
): readonly Bone[] {
  const number = new Map(points.map((name, index) => [name, index]));
  if (TABLE.every(([from, to]) => number.has(from) && number.has(to))) {
    return TABLE.map(([from, to, fromRadius, toRadius]) => ({
      from: number.get(from)!,
      to: number.get(to)!,
      fromRadius,
      toRadius,
    }));
  }
  return parents.flatMap((parent, point) => {
    const radius = radii[point] || 0.03;
    return parent < 0 ? [] : [{ from: parent, to: point, fromRadius: radius, toRadius: radius }];
  });
}

/** The share of each bone that its capsule covers. */
export function sharesOf(points: readonly string[], bones: readonly Bone[]): readonly number[] {
  return bones.map((bone) => {
    const name = points[bone.to] ?? "";
    if (name === "head_end") return HEAD_SHARE;
    return name.endsWith("hand_end") ? HAND_SHARE : 1;
  });
}

/** Numbers of one capsule in an array of capsules: x, y, z, radius of one end, then of the other. */
export const CAPSULE = 8;

/** Write the capsules of a pose (points * 3) after the first `offset` capsules; return their number. */
export function writeCapsules(
  bones: readonly Bone[],
  shares: readonly number[],
  pose: ArrayLike<number>,
  into: Float32Array,
  offset: number,
): number {
  let at = offset * CAPSULE;
  for (let i = 0; i < bones.length; i += 1) {
    const bone = bones[i]!;
    const share = shares[i]!;
    const a = 3 * bone.from;
    const b = 3 * bone.to;
    for (let axis = 0; axis < 3; axis += 1) {
      const start = pose[a + axis]!;
      into[at + axis] = start;
      into[at + 4 + axis] = start + share * (pose[b + axis]! - start);
    }
    into[at + 3] = bone.fromRadius;
    into[at + 7] = bone.toRadius;
    at += CAPSULE;
  }
  return bones.length;
}
