import assert from "node:assert/strict";
import test from "node:test";
import { BONES, fits, makeRig, numberOf, OPPOSITE, restOf, type Rig } from "../src/player/mannequin/bones.ts";
import { makeMesh, meshOf } from "../src/player/mannequin/mesh.ts";
import { cross } from "../src/player/mannequin/turns.ts";
import { distance } from "../src/player/mannequin/shape.ts";
import { CANONICAL } from "./canonical.ts";

const mesh = meshOf("small");
const corners = mesh.position.length / 3;
const REST = CANONICAL.flatMap(restOf);

/** A pose of random places, from a small generator of random numbers. */
function randomPose(seed: number): number[] {
  let state = seed;
  return REST.map((value) => {
    state = (state * 48271) % 2147483647;
    return value + 0.4 * (state / 2147483647 - 0.5);
  });
}

/** A pose with some points elsewhere. */
function posed(places: Record<string, readonly number[]>): number[] {
  return CANONICAL.flatMap((name) => places[name] ?? restOf(name));
}

type Spot = readonly [number, number, number];
const distanceOf = (a: Spot, b: Spot): number => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

/** Where a bone brings a place of the rest pose, and where it turns a direction. */
function brought({ matrices }: Rig, bone: string, [x, y, z]: Spot, moved = 1): [number, number, number] {
  const m = matrices.subarray(16 * numberOf(bone));
  const at = (n: number): number => m[n]! * x + m[4 + n]! * y + m[8 + n]! * z + moved * m[12 + n]!;
  return [at(0), at(1), at(2)];
}

function turned(rig: Rig, bone: string, direction: Spot): { x: number; y: number; z: number } {
  const [x, y, z] = brought(rig, bone, direction, 0);
  const length = Math.hypot(x, y, z);
  return { x: x / length, y: y / length, z: z / length };
}

test("the surface of the mannequin is closed, and each of its edges has two sides", () => {
  for (const { index } of [mesh, meshOf("large"), meshOf("fine")]) {
    const edges = new Map<string, number>();
    for (let i = 0; i < index.length; i += 3) {
      for (let n = 0; n < 3; n += 1) {
        const [a, b] = [index[i + n]!, index[i + ((n + 1) % 3)]!];
        const key = `${Math.min(a, b)} ${Math.max(a, b)}`;
        edges.set(key, (edges.get(key) ?? 0) + (a < b ? 1 : -1));
      }
    }
    assert.ok([...edges.values()].every((sum) => sum === 0));
  }
});

test("its corners lie on the shape and on the ground, and its triangles look outwards", () => {
  let volume = 0;
  const at = (corner: number): Spot =>
    [...mesh.position.subarray(3 * corner, 3 * corner + 3)] as unknown as Spot;
  for (let i = 0; i < mesh.index.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((n) => at(mesh.index[i + n]!));
    const [u, v, w] = cross(b!, c!);
    volume += (a![0] * u + a![1] * v + a![2] * w) / 6;
  }
  assert.ok(volume > 0.05 && volume < 0.09, `${volume} cubic metres`); // a person has about 0.07
  const off = Array.from({ length: corners }, (_, i) => Math.abs(distance(...at(i))));
  assert.ok(Math.max(...off) < 0.01);
  const lowest = Math.min(...Array.from({ length: corners }, (_, i) => at(i)[1]));
  assert.ok(Math.abs(lowest + 0.93) < 0.002); // the sole, where the standard body has the ground
});

test("shares of bones add up to 1, and both sides are alike", () => {
  const key = (corner: number, side: number): string =>
    [0, 1, 2].map((n) => (mesh.position[3 * corner + n]! * (n === 0 ? side : 1)).toFixed(6)).join(" ");
  const found = new Map(Array.from({ length: corners }, (_, i) => [key(i, 1), i]));
  for (let i = 0; i < corners; i += 1) {
    const shares = [...mesh.share.subarray(4 * i, 4 * i + 4)];
    assert.ok(Math.abs(shares.reduce((sum, value) => sum + value, 0) - 1) < 1e-6);
    const twin = found.get(key(i, -1).replace(/^-0\.000000/, "0.000000"));
    assert.ok(twin !== undefined);
    if (twin === i) continue;
    shares.forEach((share, n) => {
      if (share > 0) assert.equal(mesh.bone[4 * twin + n], OPPOSITE[mesh.bone[4 * i + n]!]);
    });
    const right = [0, 1, 2, 3].some((n) => shares[n]! > 0 && BONES[mesh.bone[4 * i + n]!]![0][0] === "r");
    assert.ok(!right || mesh.position[3 * i]! < 0.03); // left is left
  }
});

test("a nose says where the face looks, and thumbs and toes point ahead", () => {
  for (const { position } of [meshOf("large"), meshOf("fine")]) {
    const places = Array.from({ length: position.length / 3 }, (_, i) => position.slice(3 * i, 3 * i + 3));
    const foremost = (part: Float32Array[]) => part.reduce((a, b) => (b[2]! > a[2]! ? b : a));
    const nose = foremost(places.filter(([, y]) => y! > 0.58));
    assert.ok(Math.abs(nose[0]!) < 0.015 && nose[1]! > 0.65 && nose[1]! < 0.69 && nose[2]! > 0.11);
    const hand = places.filter(([x]) => x! > 0.72);
    const thumb = foremost(hand);
    assert.ok(thumb[2]! > 0.06 && thumb[0]! < 0.82);
    assert.ok(Math.max(...hand.map(([x]) => x!)) > 0.86); // fingers are longer than the thumb
    assert.ok(foremost(places.filter(([, y]) => y! < -0.85))[2]! > 0.19);
  }
});

test("the same mesh is computed again", () => {
  assert.deepEqual(makeMesh(2), mesh);
});

test("the rest pose moves nothing", () => {
  const rig = makeRig(CANONICAL);
  rig.follow(REST);
  for (const [bone, from] of BONES) {
    assert.ok(distanceOf(brought(rig, bone, restOf(from!)), restOf(from!)) < 1e-6);
    assert.ok(turned(rig, bone, [0, 0, 1]).z > 1 - 1e-6, bone);
    assert.ok(turned(rig, bone, [1, 0, 0]).x > 1 - 1e-6, bone);
  }
});

test("whatever the pose and the lengths, the joints of the mannequin lie on its points", () => {
  const rig = makeRig(CANONICAL);
  for (let seed = 1; seed <= 20; seed += 1) {
    const pose = randomPose(seed);
    rig.follow(pose);
    const at = (name: string) => pose.slice(3 * CANONICAL.indexOf(name)) as unknown as Spot;
    for (const row of BONES) {
      const ends = row.length === 3 ? [row[1], row[2]] : [row[1]];
      for (const end of ends) {
        assert.ok(distanceOf(brought(rig, row[0], restOf(end)), at(end)) < 1e-3, `${row[0]} ${end}`);
      }
    }
  }
});

test("a mirrored pose is a mirrored mannequin", () => {
  const [one, other] = [makeRig(CANONICAL), makeRig(CANONICAL)];
  const swap = (name: string) => name.replace(/^[lr]_/, (side) => (side === "l_" ? "r_" : "l_"));
  const pose = randomPose(7);
  const mirrored = CANONICAL.flatMap((name) => {
    const [x, y, z] = pose.slice(3 * CANONICAL.indexOf(swap(name)));
    return [-x!, y!, z!];
  });
  one.follow(pose);
  other.follow(mirrored);
  for (const [bone] of BONES) {
    const [seen, twin] = [turned(one, bone, [0, 0, 1]), turned(other, swap(bone), [0, 0, 1])];
    assert.ok(distanceOf([-seen.x, seen.y, seen.z], [twin.x, twin.y, twin.z]) < 1e-3, bone);
  }
});

test("elbows bend forward, and knees point where the toes point", () => {
  const rig = makeRig(CANONICAL);
  // Upper arm to the side, forearm up: the palm, which looks down at rest, looks ahead.
  rig.follow(posed({ l_wrist: [0.45, 0.69, 0], l_hand_end: [0.45, 0.86, 0] }));
  assert.ok(turned(rig, "l_hand", [0, -1, 0]).z > 0.99);
  // A straight leg whose foot points to the left is turned as a whole.
  rig.follow(posed({ l_toe: [0.23, -0.91, 0], l_toe_end: [0.29, -0.93, 0] }));
  assert.ok(turned(rig, "l_foot", [0, 0, 1]).x > 0.9);
  assert.ok(turned(rig, "l_thigh", [0, 0, 1]).x > 0.5);
  // The heel drawn up behind: the front of the thigh still looks ahead.
  rig.follow(
    posed({ l_ankle: [0.09, -0.43, -0.42], l_toe: [0.09, -0.57, -0.48], l_toe_end: [0.09, -0.63, -0.5] }),
  );
  assert.ok(turned(rig, "l_thigh", [0, 0, 1]).z > 0.99);
  assert.ok(turned(rig, "l_shin", [0, 0, 1]).y < -0.99);
});

test("toes bend where they would be in the ground, as long as before", () => {
  const rig = makeRig(CANONICAL);
  rig.follow(posed({ l_ankle: [0.09, 0.12, 0], l_toe: [0.09, 0.03, 0.12], l_toe_end: [0.09, -0.02, 0.16] }));
  const [, y, z] = brought(rig, "l_toes", restOf("l_toe_end"));
  assert.ok(Math.abs(y) < 1e-6 && Math.abs(Math.hypot(0.03, z - 0.12) - Math.hypot(0.05, 0.04)) < 1e-6);
});

test("only bodies with all its points are mannequins", () => {
  assert.ok(fits(CANONICAL));
  assert.ok(!fits(CANONICAL.slice(1)));
});
