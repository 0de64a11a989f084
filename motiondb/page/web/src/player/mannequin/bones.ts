/**
 * The bones of the mannequin, turned so that its joints lie on the points of a pose.
 *
 * A pose says where joints are. Trunk and pelvis have three points, and so a direction; a limb is
 * turned the least way from the bone before it, as the server turns it, and then about itself: the
 * arm so that the elbow bends forward, the leg so that knee and toes point the same way. A bone
 * that is longer than that of the mannequin is larger as a whole. Every joint between two bones of
 * a limb has a bone of its own, which is turned half the way: thick joints do not collapse.
 */

import * as THREE from "three";

/** Where the points are in the rest pose: the standard body of `motiondb.body.body`, metres. */
const REST: Readonly<Record<string, readonly [number, number, number]>> = {
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
export function restOf(point: string): THREE.Vector3 {
  const [x, y, z] = (REST[point] ?? REST[point.replace(/^r_/, "l_")])!;
  return new THREE.Vector3(point.startsWith("r_") ? -x : x, y, z);
}

/** Whether a body has the points that the mannequin needs. */
export function fits(points: readonly string[]): boolean {
  return Object.keys(REST).every((name) => points.includes(name) && points.includes(opposite(name)));
}

/** Bones whose world matrices follow poses. */
export interface Rig {
  readonly skeleton: THREE.Skeleton;
  /** Turn the bones to a pose: (points, 3). */
  follow(pose: ArrayLike<number>): void;
}

const [X, Y] = [new THREE.Vector3(1, 0, 0), new THREE.Vector3(0, 1, 0)];

function ramp(value: number, from: number, to: number): number {
  const share = Math.min(Math.max((value - from) / (to - from), 0), 1);
  return share * share * (3 - 2 * share);
}

/** An angle that fades towards half a turn, where its sign would jump. */
function bounded(angle: number): number {
  return angle * (1 - ramp(Math.abs(angle), 1.9, 2.9));
}

/** Make the bones of a body with these points. */
export function makeRig(points: readonly string[]): Rig {
  const bones = BONES.map(() => new THREE.Bone());
  const inverses = BONES.map(([, from]) => {
    const rest = restOf(from);
    return new THREE.Matrix4().makeTranslation(-rest.x, -rest.y, -rest.z);
  });
  const skeleton = new THREE.Skeleton(bones, inverses);
  const place = new Map(points.map((name) => [name, new THREE.Vector3()]));
  const at = (name: string): THREE.Vector3 => place.get(name)!;
  const turns = new Map(BONES.map(([name]) => [name, new THREE.Quaternion()]));
  const turn = (name: string): THREE.Quaternion => turns.get(name)!;
  const sizes = new Map(BONES.map(([name]) => [name, 1]));
  const ends = new Map(BONES.filter((row) => row.length === 3).map(([name, from, to]) => [name, [from, to]]));
  const along = new Map([...ends].map(([name, [a, b]]) => [name, restOf(b!).sub(restOf(a!))]));
  const [u, v, w, basis] = [
    new THREE.Vector3(),
    new THREE.Vector3(),
    new THREE.Vector3(),
    new THREE.Matrix4(),
  ];
  const extra = new THREE.Quaternion();
  const scale = new THREE.Vector3();

  /** From the first to the second end of a bone, as seen in the frame of a bone. */
  function seen(bone: string, frame: THREE.Quaternion, into: THREE.Vector3): THREE.Vector3 {
    const [from, to] = ends.get(bone)!;
    return into.subVectors(at(to!), at(from!)).applyQuaternion(extra.copy(frame).invert()).normalize();
  }

  /** Turn a bone the least way from the frame of another. */
  function swing(bone: string, before: string): void {
    seen(bone, turn(before), v);
    u.copy(along.get(bone)!).normalize();
    turn(bone).copy(turn(before)).multiply(extra.setFromUnitVectors(u, v));
  }

  function twist(bone: string, axis: THREE.Vector3, angle: number): void {
    turn(bone).multiply(extra.setFromAxisAngle(axis, angle));
  }

  /** A frame whose y axis is `up`, and whose x axis is as near to `left` as it can be. */
  function upright(bone: string, left: THREE.Vector3, up: THREE.Vector3): void {
    up.normalize();
    w.crossVectors(left, up).normalize();
    left.crossVectors(up, w);
    turn(bone).setFromRotationMatrix(basis.makeBasis(left, up, w));
  }

  function turnTrunk(): void {
    u.subVectors(at("l_collar"), at("r_collar")).addScaledVector(at("l_shoulder"), 0.1);
    u.addScaledVector(at("r_shoulder"), -0.1);
    upright("chest", u, v.subVectors(at("neck"), at("chest")));
    u.subVectors(at("l_hip"), at("r_hip"));
    upright("pelvis", u, v.subVectors(at("spine"), at("pelvis")));
    // The hips are exact, rather than the direction of the spine.
    u.copy(X).applyQuaternion(turn("pelvis"));
    v.copy(X).applyQuaternion(turn("chest")).add(u);
    upright("belly", v.clone(), u.subVectors(at("chest"), at("spine")));
    swing("neck", "chest");
    swing("head", "neck");
  }

  function turnArm(side: string): void {
    const [collar, upper, fore, hand] = ["collar", "upper", "fore", "hand"].map((name) => `${side}_${name}`);
    swing(collar!, "chest");
    swing(upper!, collar!);
    const bent = seen(fore!, turn(upper!), v);
    const angle = Math.atan2(-bent.y, bent.z);
    twist(upper!, X, bounded(angle) * ramp(Math.hypot(bent.y, bent.z), 0.15, 0.6));
    swing(fore!, upper!);
    swing(hand!, fore!);
  }

  function turnLeg(side: string): void {
    const [thigh, shin, foot, toes] = ["thigh", "shin", "foot", "toes"].map((name) => `${side}_${name}`);
    swing(thigh!, "pelvis");
    const knee = seen(shin!, turn(thigh!), w).clone();
    swing(shin!, thigh!);
    const ahead = seen(foot!, turn(shin!), w);
    const angle = Math.atan2(0.7 * ahead.x - 2 * knee.x, 0.3 + 0.7 * ahead.z - 2 * knee.z);
    twist(thigh!, Y, bounded(angle));
    swing(shin!, thigh!);
    const out = seen(foot!, turn(shin!), w);
    const yaw = Math.atan2(out.x, out.z) * ramp(Math.hypot(out.x, out.z), 0.2, 0.6);
    twist(shin!, Y, Math.min(Math.max(0.5 * bounded(yaw), -0.6), 0.6));
    swing(foot!, shin!);
    swing(toes!, foot!);
  }

  function join([bone, , before, after]: readonly string[]): void {
    turn(bone!).copy(turn(before!)).slerp(turn(after!), 0.5);
    sizes.set(bone!, (sizes.get(before!)! + sizes.get(after!)!) / 2);
  }

  return {
    skeleton,
    follow(pose) {
      points.forEach((name, i) => at(name).set(pose[3 * i]!, pose[3 * i + 1]!, pose[3 * i + 2]!));
      turnTrunk();
      for (const side of ["l", "r"]) {
        turnArm(side);
        turnLeg(side);
      }
      for (const [name, [from, to]] of ends) {
        sizes.set(name, at(from!).distanceTo(at(to!)) / along.get(name)!.length());
      }
      BONES.forEach((row, i) => {
        if (row.length === 4) join(row);
        const size = sizes.get(row[0])!;
        bones[i]!.matrixWorld.compose(at(row[1]), turn(row[0]), scale.set(size, size, size));
      });
    },
  };
}
