/**
 * The mesh of the mannequin: the surface of its shape as triangles, with the bones of every corner.
 *
 * Dual contouring on a grid whose steps are small where the shape is: a corner in each cell that
 * the surface passes, moved onto it, and a quad around each edge of the grid that leaves the shape.
 * After Gibson, Constrained elastic surface nets (1998). The surface is closed, and the same on both
 * sides.
 */

import { numberOf, opposite } from "./bones.ts";
import { CONES, distance, outside } from "./shape.ts";

export interface Mesh {
  /** (corners, 3): metres in the rest pose. */
  position: Float32Array;
  /** (corners, 3): unit vectors. */
  normal: Float32Array;
  /** (corners,): how much light reaches a corner, and how far it is of a joint; 0 to 255. */
  shade: Uint8Array;
  /** (corners, 4): numbers of bones, and their shares, which add up to 1. */
  bone: Uint8Array;
  share: Float32Array;
  /** (triangles, 3), counter-clockwise seen from outside. */
  index: Uint16Array;
}

/** Steps of the grid: up to which place each is taken, metres. Chosen by eye. */
type Steps = readonly (readonly [upTo: number, step: number])[];
const ACROSS: Steps = [
  [0.105, 0.0125],
  [0.2, 0.02],
  [0.4, 0.04],
  [0.5, 0.022],
  [0.66, 0.04],
  [0.9, 0.0145],
];
const UP: Steps = [
  [-0.86, 0.014],
  [-0.8, 0.03],
  [-0.52, 0.05],
  [-0.36, 0.028],
  [-0.14, 0.05],
  [0.38, 0.026],
  [0.5, 0.017],
  [0.58, 0.018],
  [0.83, 0.0115],
];
const AHEAD: Steps = [
  [0.045, 0.019],
  [0.14, 0.0115],
  [0.24, 0.016],
];
const [LOWEST, REARMOST] = [-0.96, -0.16];

/** The places of a grid along one axis. */
function places(start: number, steps: Steps, coarse: number): number[] {
  const found = [start];
  for (const [upTo, step] of steps) {
    const begin = found[found.length - 1]!;
    const count = Math.max(Math.round((upTo - begin) / (step * coarse)), 1);
    for (let i = 1; i <= count; i += 1) found.push(begin + ((upTo - begin) * i) / count);
  }
  return found;
}

/** The same on both sides of 0, which lies in the middle of a step. */
function mirrored(places: readonly number[]): number[] {
  return [...places.map((x) => -x).reverse(), ...places];
}

/** Make the mesh; `coarse`: how many times larger the steps are. */
export function makeMesh(coarse = 1): Mesh {
  const xs = mirrored(places(ACROSS[0]![1] * coarse * 0.5, ACROSS, coarse));
  const ys = places(LOWEST, UP, coarse);
  const zs = places(REARMOST, AHEAD, coarse);
  const [nx, ny, nz] = [xs.length, ys.length, zs.length];
  const [di, dj] = [ny * nz, nz];
  const far = new Float64Array(nx * di);
  for (let i = nx / 2; i < nx; i += 1) {
    for (let j = 0; j < ny; j += 1) {
      for (let k = 0; k < nz; k += 1) {
        const value = distance(xs[i]!, ys[j]!, zs[k]!);
        far[i * di + j * dj + k] = far[(nx - 1 - i) * di + j * dj + k] = value;
      }
    }
  }
  const inside = (at: number): boolean => far[at]! < 0;

  // The corners of the left half, and which cell has which; those of the middle come first.
  const left: Place[] = [];
  const cornerOf = new Int32Array(nx * di).fill(-1);
  let middle = 0;
  for (let i = nx / 2 - 1; i + 1 < nx; i += 1) {
    for (let j = 0; j + 1 < ny; j += 1) {
      for (let k = 0; k + 1 < nz; k += 1) {
        const at = i * di + j * dj + k;
        const low = [xs[i]!, ys[j]!, zs[k]!] as const;
        const high = [xs[i + 1]!, ys[j + 1]!, zs[k + 1]!] as const;
        const corner = cornerIn(at, low, high);
        if (!corner) continue;
        cornerOf[at] = left.length;
        left.push(onto(corner, low, high));
      }
    }
    if (i === nx / 2 - 1) middle = left.length;
  }
  for (let i = 0; i < nx / 2 - 1; i += 1) {
    for (let at = i * di; at < (i + 1) * di; at += 1) {
      const twin = cornerOf[at + (nx - 2 - 2 * i) * di]!;
      if (twin >= 0) cornerOf[at] = left.length + twin - middle;
    }
  }

  /** The middle of the places where the edges of a cell cross the surface; null: none does. */
  function cornerIn(at: number, low: Place, high: Place): Place | null {
    const sum: [number, number, number] = [0, 0, 0];
    let count = 0;
    const steps = [di, dj, 1];
    for (let axis = 0; axis < 3; axis += 1) {
      const [one, other] = [(axis + 1) % 3, (axis + 2) % 3];
      for (let corner = 0; corner < 4; corner += 1) {
        const [p, q] = [corner & 1, corner >> 1];
        const a = at + p * steps[one]! + q * steps[other]!;
        const [fa, fb] = [far[a]!, far[a + steps[axis]!]!];
        if (fa < 0 === fb < 0) continue;
        sum[axis]! += low[axis]! + (fa / (fa - fb)) * (high[axis]! - low[axis]!);
        sum[one]! += p ? high[one]! : low[one]!;
        sum[other]! += q ? high[other]! : low[other]!;
        count += 1;
      }
    }
    return count > 0 ? [sum[0] / count, sum[1] / count, sum[2] / count] : null;
  }

  const index: number[] = [];
  for (let i = 1; i + 1 < nx; i += 1) {
    for (let j = 1; j + 1 < ny; j += 1) {
      for (let k = 1; k + 1 < nz; k += 1) {
        const at = i * di + j * dj + k;
        const is = inside(at);
        if (is !== inside(at + di)) quad(at, dj, 1, is);
        if (is !== inside(at + dj)) quad(at, 1, di, is);
        if (is !== inside(at + 1)) quad(at, di, dj, is);
      }
    }
  }

  /** The corners of the four cells around an edge as two triangles, cut along the shorter diagonal. */
  function quad(at: number, one: number, other: number, outwards: boolean): void {
    const around = [at - one - other, at - other, at, at - one].map((cell) => cornerOf[cell]!);
    const [a, b, c, d] = (outwards ? around : around.reverse()) as [number, number, number, number];
    if (apart(a, c) < apart(b, d)) index.push(a, b, c, a, c, d);
    else index.push(b, c, d, b, d, a);
  }

  function place(corner: number): Place {
    const [x, y, z] = left[corner < left.length ? corner : corner - left.length + middle]!;
    return [corner < left.length ? x : -x, y, z];
  }

  function apart(a: number, b: number): number {
    const [p, q] = [place(a), place(b)];
    return (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2;
  }

  return dressed(left, middle, Uint16Array.from(index));
}

type Place = readonly [x: number, y: number, z: number];

/** A corner moved onto the surface: at most a little outside of its cell, not past another corner. */
function onto(corner: Place, low: Place, high: Place): Place {
  const p = [...corner] as [number, number, number];
  for (let step = 0; step < 2; step += 1) {
    const slope = slopeAt(p);
    const square = slope[0] ** 2 + slope[1] ** 2 + slope[2] ** 2;
    const move = square > 1e-9 ? distance(...p) / square : 0;
    for (let n = 0; n < 3; n += 1) {
      const room = 0.25 * (high[n]! - low[n]!);
      p[n] = Math.min(Math.max(p[n]! - move * slope[n]!, low[n]! - room), high[n]! + room);
    }
  }
  if (low[0] < 0) p[0] = 0;
  return p;
}

/** The direction in which the distance grows, and how fast. */
function slopeAt([x, y, z]: Place): [number, number, number] {
  const e = 0.002;
  return [
    (distance(x + e, y, z) - distance(x - e, y, z)) / (2 * e),
    (distance(x, y + e, z) - distance(x, y - e, z)) / (2 * e),
    (distance(x, y, z + e) - distance(x, y, z - e)) / (2 * e),
  ];
}

/** Distances from the surface at which is asked how open it is, metres. */
const OPEN = [0.02, 0.05, 0.1];

/** Normals, light and bones for the corners of the left half, and for those of the right. */
function dressed(left: readonly Place[], middle: number, index: Uint16Array): Mesh {
  const count = 2 * left.length - middle;
  const mesh: Mesh = {
    position: new Float32Array(3 * count),
    normal: new Float32Array(3 * count),
    shade: new Uint8Array(count),
    bone: new Uint8Array(4 * count),
    share: new Float32Array(4 * count),
    index,
  };
  left.forEach((p, i) => {
    const slope = slopeAt(p);
    const length = Math.sqrt(slope[0] ** 2 + slope[1] ** 2 + slope[2] ** 2) || 1;
    const normal: Place = [slope[0] / length, slope[1] / length, slope[2] / length];
    const shade = shadeAt(p, normal);
    const bones = bonesAt(p);
    put(i, 1, numberOf);
    if (i >= middle) put(i + left.length - middle, -1, (bone) => numberOf(opposite(bone)));

    function put(corner: number, side: number, numbered: (bone: string) => number): void {
      mesh.position.set([side * p[0], p[1], p[2]], 3 * corner);
      mesh.normal.set([side * normal[0], normal[1], normal[2]], 3 * corner);
      mesh.shade[corner] = shade;
      bones.forEach(([bone, share], n) => {
        mesh.bone[4 * corner + n] = numbered(bone);
        mesh.share[4 * corner + n] = share;
      });
    }
  });
  return mesh;
}

/** How much light reaches a corner: less where the surface around it is near. */
function shadeAt(p: Place, normal: Place): number {
  let closed = 0;
  for (const d of OPEN) {
    const seen = distance(p[0] + d * normal[0], p[1] + d * normal[1], p[2] + d * normal[2]);
    closed += Math.max(d - seen, 0) / d;
  }
  return Math.round(255 * Math.min(Math.max(1 - 0.17 * closed, 0.5), 1));
}

/** How much farther than the nearest cone one may be to have a share, metres. Chosen by eye. */
const REACH = 0.055;
/** Half the width of the zone in the middle in which both legs have a share, metres. */
const BETWEEN = 0.02;

/** The bones that move a place, at most four, and their shares. */
function bonesAt([x, y, z]: Place): [bone: string, share: number][] {
  const near: [bone: string, far: number, towards: number][] = [];
  let least = Infinity;
  for (const one of CONES) {
    const sided = one.bone.startsWith("l_");
    const other = outside(one, -x, y, z);
    const own = outside(one, x, y, z);
    least = Math.min(least, sided ? own : Math.min(own, other));
    const towards = Math.min(0.5 + x / (2 * BETWEEN), 1);
    if (!sided) near.push([one.bone, Math.min(own, other), 1]);
    else near.push([one.bone, own, towards], [opposite(one.bone), other, 1 - towards]);
  }
  const shares = new Map<string, number>();
  for (const [bone, far, towards] of near) {
    const close = Math.max(1 - Math.max(far - least, 0) / REACH, 0);
    shares.set(bone, Math.max(shares.get(bone) ?? 0, towards * close * close * close));
  }
  const most = [...shares].sort((p, q) => q[1] - p[1] || numberOf(p[0]) - numberOf(q[0])).slice(0, 4);
  const sum = most.reduce((total, [, value]) => total + value, 0);
  return most.map(([bone, value]) => [bone, value / sum]);
}
