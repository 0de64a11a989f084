/**
 * The bones of the mannequin, turned so that its joints lie on the points of a pose.
 *
 * A pose says where joints are. Trunk and pelvis have three points, and so a direction; a limb is
 * turned the least way from the bone before it, as the server turns it, and then about itself: the
 * arm so that the elbow bends forward, the leg so that knee and toes point the same way. A bone
 * that is longer than that of the mannequin is larger as a whole. Every joint between two bones of
 * a limb has a bone of its own, which is turned half the way: thick joints do not collapse.
 */

import {
  about,
  after,
  back,
  between,
  halfway,
  lengthOf,
  minus,
  NO_TURN,
  plus,
  turned,
  unit,
  upright,
  type Turn,
  type Vector,
} from "./turns.ts";

/** Where the points are in the rest pose: the standard body of `motiondb.body.body`, metres. */
const REST: Readonly<Record<string, Vector>> = {
  pelvis: [0, 0, 0],
  spine: [0, 0.12, 0],
  chest: [0, 0.26, 0],
  neck: [0, 0.5, 0],
  head: [0, 0.6, 0.01],
  head_end: [0, 0.78, 0.01],
  l_hip: [0.09, 0, 0],
  l_knee: [0.09, -0.43, 0],
  l_ankle: [0.09, -0.85, 0],
  l_toe: [0.09, -0.91, 0.14],
  l_toe_end: [0.09, -0.93, 0.2],
  l_collar: [0.03, 0.44, 0],
  l_shoulder: [0.17, 0.44, 0],
  l_elbow: [0.45, 0.44, 0],
  l_wrist: [0.7, 0.44, 0],
  l_hand_end: [0.87, 0.44, 0],
};

/** A bone from one point to another; a joint lies at one point, half-way between two bones. */
type Row =
  | readonly [bone: string, from: string, to: string]
  | readonly [joint: string, at: string, before: string, after: string];

const LIMBS: readonly Row[] = [
  ["l_collar", "l_collar", "l_shoulder"],
  ["l_upper", "l_shoulder", "l_elbow"],
  ["l_fore", "l_elbow", "l_wrist"],
  ["l_hand", "l_wrist", "l_hand_end"],
  ["l_thigh", "l_hip", "l_knee"],
  ["l_shin", "l_knee", "l_ankle"],
  ["l_foot", "l_ankle", "l_toe"],
  ["l_toes", "l_toe", "l_toe_end"],
  ["l_shoulder", "l_shoulder", "l_collar", "l_upper"],
  ["l_elbow", "l_elbow", "l_upper", "l_fore"],
  ["l_wrist", "l_wrist", "l_fore", "l_hand"],
  ["l_hip", "l_hip", "pelvis", "l_thigh"],
  ["l_knee", "l_knee", "l_thigh", "l_shin"],
  ["l_ankle", "l_ankle", "l_shin", "l_foot"],
];

/** The name of the same on the right side. */
export const opposite = (name: string): string => name.replace(/^l_/, "r_");

export const BONES: readonly Row[] = [
  ["pelvis", "pelvis", "spine"],
  ["belly", "spine", "chest"],
  ["chest", "chest", "neck"],
  ["neck", "neck", "head"],
  ["head", "head", "head_end"],
  ...LIMBS,
  ...LIMBS.map((row) => row.map(opposite) as unknown as Row),
];

const NUMBERS = new Map(BONES.map(([name], i) => [name, i]));

/** For each bone, the number of the same on the other side. */
export const OPPOSITE: readonly number[] = BONES.map(
  ([name], i) => NUMBERS.get(name[0] === "r" ? name.replace(/^r_/, "l_") : opposite(name)) ?? i,
);

/** The number of a bone. */
export function numberOf(bone: string): number {
  return NUMBERS.get(bone)!;
}

/** Where a point is in the rest pose. */
export function restOf(point: string): Vector {
  const [x, y, z] = (REST[point] ?? REST[point.replace(/^r_/, "l_")])!;
  return [point.startsWith("r_") ? -x : x, y, z];
}

/** The points that the mannequin needs, those of the right side too. */
export const POINTS: readonly string[] = [
  ...new Set(Object.keys(REST).flatMap((name) => [name, opposite(name)])),
];

/** Whether a body has the points that the mannequin needs. */
export function fits(points: readonly string[]): boolean {
  return POINTS.every((name) => points.includes(name));
}

const [X, Y]: [Vector, Vector] = [
  [1, 0, 0],
  [0, 1, 0],
];
/** Bones from one point to another: the direction and the length at rest. */
const ALONG = new Map(
  BONES.filter((row) => row.length === 3).map(([bone, from, to]) => {
    const rest = minus(restOf(to!), restOf(from));
    return [bone, { from, to: to!, direction: unit(rest), length: lengthOf(rest) }];
  }),
);

function ramp(value: number, from: number, to: number): number {
  const share = Math.min(Math.max((value - from) / (to - from), 0), 1);
  return share * share * (3 - 2 * share);
}

/** An angle that fades towards half a turn, where its sign would jump. */
function bounded(angle: number): number {
  return angle * (1 - ramp(Math.abs(angle), 1.9, 2.9));
}

/** Make the bones of a body with these points. */
export function makeRig(points: readonly string[]) {
  const matrices = new Float32Array(16 * BONES.length);
  const place = new Map<string, Vector>();
  const turns = new Map<string, Turn>();
  const sizes = new Map<string, number>();
  const at = (name: string): Vector => place.get(name)!;
  const turn = (name: string): Turn => turns.get(name) ?? NO_TURN;

  /** The direction of a bone, as seen in a frame. */
  function seen(bone: string, frame: Turn): Vector {
    const { from, to } = ALONG.get(bone)!;
    return unit(turned(back(frame), minus(at(to), at(from))));
  }

  /** A bone turned the least way from a frame. */
  function swung(bone: string, frame: Turn): Turn {
    return after(frame, between(ALONG.get(bone)!.direction, seen(bone, frame)));
  }

  function turnTrunk(): void {
    const collars = minus(at("l_collar"), at("r_collar"));
    const chest = upright(
      plus(collars, minus(at("l_shoulder"), at("r_shoulder")), 0.1),
      minus(at("neck"), at("chest")),
    );
    const pelvis = upright(minus(at("l_hip"), at("r_hip")), minus(at("spine"), at("pelvis")));
    const left = plus(turned(pelvis, X), turned(chest, X));
    turns.set("chest", chest).set("pelvis", pelvis);
    turns.set("belly", upright(left, minus(at("chest"), at("spine"))));
    turns.set("neck", swung("neck", chest));
    turns.set("head", swung("head", turn("neck")));
  }

  /** Bend toes that would be in the ground: captures of feet have none, and push off with a stiff foot. */
  function bendToes(side: string): void {
    const [toe, end] = [at(`${side}toe`), at(`${side}toe_end`)];
    const [x, y, z] = minus(end, toe);
    const reach = Math.sqrt(Math.max(x * x + y * y + z * z - toe[1] * toe[1], 0));
    const flat = Math.hypot(x, z);
    if (end[1] >= 0 || toe[1] <= 0 || reach === 0 || flat < 1e-6) return;
    place.set(`${side}toe_end`, [toe[0] + (x * reach) / flat, 0, toe[2] + (z * reach) / flat]);
  }

  function turnArm(side: string): void {
    const [collar, upper, fore, hand] = ["collar", "upper", "fore", "hand"].map((name) => side + name);
    turns.set(collar!, swung(collar!, turn("chest")));
    const swing = swung(upper!, turn(collar!));
    const [, y, z] = seen(fore!, swing);
    const angle = bounded(Math.atan2(-y, z)) * ramp(Math.hypot(y, z), 0.15, 0.6);
    turns.set(upper!, after(swing, about(X, angle)));
    turns.set(fore!, swung(fore!, turn(upper!)));
    turns.set(hand!, swung(hand!, turn(fore!)));
  }

  function turnLeg(side: string): void {
    const [thigh, shin, foot, toes] = ["thigh", "shin", "foot", "toes"].map((name) => side + name);
    const swing = swung(thigh!, turn("pelvis"));
    const knee = seen(shin!, swing);
    const ahead = seen(foot!, swung(shin!, swing));
    const angle = Math.atan2(0.7 * ahead[0] - 2 * knee[0], 0.3 + 0.7 * ahead[2] - 2 * knee[2]);
    turns.set(thigh!, after(swing, about(Y, bounded(angle))));
    const straight = swung(shin!, turn(thigh!));
    const [x, , z] = seen(foot!, straight);
    const yaw = 0.5 * bounded(Math.atan2(x, z)) * ramp(Math.hypot(x, z), 0.2, 0.6);
    turns.set(shin!, after(straight, about(Y, Math.min(Math.max(yaw, -0.6), 0.6))));
    turns.set(foot!, swung(foot!, turn(shin!)));
    turns.set(toes!, swung(toes!, turn(foot!)));
  }

  /** Write the matrix of a bone that begins at a point. */
  function write(number: number, bone: string, point: string): void {
    const [size, frame] = [sizes.get(bone)!, turn(bone)];
    const axes = [X, Y, [0, 0, 1] as Vector].map((axis) => turned(frame, axis));
    const [rest, now] = [restOf(point), at(point)];
    for (let n = 0; n < 3; n += 1) {
      let moved = now[n]!;
      axes.forEach((axis, m) => {
        matrices[16 * number + 4 * m + n] = size * axis[n]!;
        moved -= size * axis[n]! * rest[m]!;
      });
      matrices[16 * number + 12 + n] = moved;
    }
    matrices[16 * number + 15] = 1;
  }

  return {
    /** (bones, 16): what brings places of the rest pose to where the bones are; columns first. */
    matrices,
    /** Turn the bones to a pose: (points, 3). */
    follow(pose: ArrayLike<number>): void {
      points.forEach((name, i) => place.set(name, [pose[3 * i]!, pose[3 * i + 1]!, pose[3 * i + 2]!]));
      turnTrunk();
      for (const side of ["l_", "r_"]) {
        bendToes(side);
        turnArm(side);
        turnLeg(side);
      }
      for (const [bone, { from, to, length }] of ALONG) {
        sizes.set(bone, lengthOf(minus(at(to), at(from))) / length);
      }
      BONES.forEach((row, i) => {
        const [bone, point] = row;
        if (row.length === 4) {
          turns.set(bone, halfway(turn(row[2]), turn(row[3])));
          sizes.set(bone, (sizes.get(row[2])! + sizes.get(row[3])!) / 2);
        }
        write(i, bone, point);
      });
    },
  };
}

export type Rig = ReturnType<typeof makeRig>;
