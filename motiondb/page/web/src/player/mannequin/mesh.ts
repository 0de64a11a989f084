/**
 * The mesh of the mannequin: the surface of its shape as triangles, with the bones of every corner.
 *
 * Dual contouring on a grid whose steps are small where the shape is: a corner in each cell that
 * the surface passes, moved onto it, and a quad around each edge of the grid that leaves the shape.
 * After Gibson, Constrained elastic surface nets (1998). The surface is closed, and the same on both
 * sides.
 */

import { BONES, numberOf, OPPOSITE, opposite } from "./bones.ts";
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
  [0.09, 0.0125],
  [0.13, 0.0135],
  [0.24, 0.022],
  [0.3, 0.0135],
  [0.385, 0.022],
  [0.55, 0.0088],
];
const UP: Steps = [
  [-0.86, 0.014],
  [-0.8, 0.022],
  [-0.52, 0.05],
  [-0.36, 0.028],
  [-0.14, 0.05],
  [0.38, 0.03],
  [0.5, 0.0165],
  [0.58, 0.018],
  [0.83, 0.0115],
];
const AHEAD: Steps = [
  [0.045, 0.019],
  [0.14, 0.0115],
  [0.22, 0.015],
];
const [LOWEST, REARMOST] = [-0.96, -0.16];
/** How much wider the grid is across and ahead at a height: it is finest at head, hands and feet. */
const WIDER: readonly (readonly [height: number, across: number, ahead: number])[] = [
  [-0.96, 1.2, 1.1],
  [-0.8, 1.2, 1.1],
  [-0.7, 1.7, 1.6],
  [0.24, 1.7, 1.6],
  [0.39, 1.7, 1.05],
  [0.48, 1.7, 1.05],
  [0.6, 1, 1],
  [0.83, 1, 1],
];

function widerAt(height: number): [across: number, ahead: number] {
  const above = WIDER.findIndex(([at]) => at >= height - 1e-9);
  const [low, high] = [WIDER[Math.max(above - 1, 0)]!, WIDER[above]!];
  const share = high[0] > low[0] ? (height - low[0]) / (high[0] - low[0]) : 0;
  return [low[1] + share * (high[1] - low[1]), low[2] + share * (high[2] - low[2])];
}

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

/** How much larger the steps of a mesh are than the finest. Chosen by eye. */
const COARSE = { fine: 1, large: 1.3, small: 2 };
export type Detail = keyof typeof COARSE;

const made = new Map<Detail, Mesh>();

/** A mesh; it is computed when it is first needed. */
export function meshOf(kind: Detail): Mesh {
  const mesh = made.get(kind) ?? makeMesh(COARSE[kind]);
  made.set(kind, mesh);
  return mesh;
}

/** Make the mesh; `coarse`: how many times larger the steps are. */
export function makeMesh(coarse = 1): Mesh {
  const xs = mirrored(places(ACROSS[0]![1] * coarse * 0.5, ACROSS, coarse));
  const ys = places(LOWEST, UP, coarse);
  const zs = places(REARMOST, AHEAD, coarse);
  const [nx, ny, nz] = [xs.length, ys.length, zs.length];
  const wider = ys.map(widerAt);
  const node = (i: number, j: number, k: number): Place => [
    xs[i]! * wider[j]![0],
    ys[j]!,
    zs[k]! * wider[j]![1],
  ];
  const [di, dj] = [ny * nz, nz];
  const far = new Float64Array(nx * di);
  for (let i = nx / 2; i < nx; i += 1) {
    for (let j = 0; j < ny; j += 1) {
      for (let k = 0; k < nz; k += 1) {
        const value = distance(xs[i]! * wider[j]![0], ys[j]!, zs[k]! * wider[j]![1]);
        far[i * di + j * dj + k] = far[(nx - 1 - i) * di + j * dj + k] = value;
      }
    }
  }
  const nodes = NODES.map(([p, q, r]) => p * di + q * dj + r);
  const inside = (at: number): boolean => far[at]! < 0;

  // The corners of the left half, and which cell has which; those of the middle come first.
  const left: Place[] = [];
  const cornerOf = new Int32Array(nx * di).fill(-1);
  let middle = 0;
  for (let i = nx / 2 - 1; i + 1 < nx; i += 1) {
    for (let j = 0; j + 1 < ny; j += 1) {
      for (let k = 0; k + 1 < nz; k += 1) {
        const corner = cornerIn(i, j, k);
        if (!corner) continue;
        cornerOf[i * di + j * dj + k] = left.length;
        const size: Place = [
          (xs[i + 1]! - xs[i]!) * wider[j]![0],
          ys[j + 1]! - ys[j]!,
          (zs[k + 1]! - zs[k]!) * wider[j]![1],
        ];
        const [x, y, z] = onto(corner, size);
        left.push([i === nx / 2 - 1 ? 0 : x, y, z]);
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
  function cornerIn(i: number, j: number, k: number): Place | null {
    const at = i * di + j * dj + k;
    if (nodes.every((step) => far[at + step]! >= 0) || nodes.every((step) => far[at + step]! < 0))
      return null;
    const sum = [0, 0, 0];
    let count = 0;
    for (const [[p, q, r], [s, t, u]] of EDGES) {
      const [fa, fb] = [far[at + p * di + q * dj + r]!, far[at + s * di + t * dj + u]!];
      if (fa < 0 === fb < 0) continue;
      const [a, b] = [node(i + p, j + q, k + r), node(i + s, j + t, k + u)];
      const share = fa / (fa - fb);
      for (let n = 0; n < 3; n += 1) sum[n]! += a[n]! + share * (b[n]! - a[n]!);
      count += 1;
    }
    return [sum[0]! / count, sum[1]! / count, sum[2]! / count];
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

  return dressed(left, middle, Uint16Array.from(index), 0.003 * coarse * coarse);
}

type Place = readonly [x: number, y: number, z: number];

/** The nodes of a cell, and the ends of its edges. */
const NODES: readonly Place[] = [0, 1, 2, 3, 4, 5, 6, 7].map((n) => [n & 1, (n >> 1) & 1, n >> 2]);
const EDGES = NODES.flatMap((a) =>
  NODES.filter((b) => b.every((value, n) => value >= a[n]!))
    .filter((b) => b[0] + b[1] + b[2] === a[0] + a[1] + a[2] + 1)
    .map((b): readonly [Place, Place] => [a, b]),
);

/** A corner moved onto the surface, by no more than half of its cell. */
function onto(corner: Place, size: Place): Place {
  const p = [...corner] as [number, number, number];
  for (let step = 0; step < 2; step += 1) {
    const slope = slopeAt(p, 0.002);
    const square = slope[0] ** 2 + slope[1] ** 2 + slope[2] ** 2;
    const move = square > 1e-9 ? distance(...p) / square : 0;
    for (let n = 0; n < 3; n += 1) {
      const room = 0.5 * size[n]!;
      p[n] = Math.min(Math.max(p[n]! - move * slope[n]!, corner[n]! - room), corner[n]! + room);
    }
  }
  return p;
}

/**
 * The direction in which the distance grows, and how fast: from the corners of a tetrahedron, `e`
 * metres away. What is smaller than the steps of a grid must not be seen in its normals.
 */
function slopeAt([x, y, z]: Place, e: number): [number, number, number] {
  const a = distance(x + e, y - e, z - e);
  const b = distance(x - e, y - e, z + e);
  const c = distance(x - e, y + e, z - e);
  const d = distance(x + e, y + e, z + e);
  return [(a - b - c + d) / (4 * e), (-a - b + c + d) / (4 * e), (-a + b - c + d) / (4 * e)];
}

/** Distances from the surface at which is asked how open it is, metres. */
const OPEN = [0.03, 0.06, 0.1];

/** Height above which there is only the head, metres. */
const CHIN = 0.59;

/** Normals, light and bones for the corners of the left half, and for those of the right. */
function dressed(left: readonly Place[], middle: number, index: Uint16Array, blur: number): Mesh {
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
    const slope = slopeAt(p, blur);
    const length = Math.sqrt(slope[0] ** 2 + slope[1] ** 2 + slope[2] ** 2) || 1;
    const normal: Place = [slope[0] / length, slope[1] / length, slope[2] / length];
    const shade = shadeAt(p, normal);
    const bones = bonesAt(p);
    put(i, 1);
    if (i >= middle) put(i + left.length - middle, -1);

    function put(corner: number, side: number): void {
      mesh.position.set([side * p[0], p[1], p[2]], 3 * corner);
      mesh.normal.set([side * normal[0], normal[1], normal[2]], 3 * corner);
      mesh.shade[corner] = shade;
      bones.forEach(([bone, share], n) => {
        mesh.bone[4 * corner + n] = side > 0 ? bone : OPPOSITE[bone]!;
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
  // A face that is seen from afar must not look bearded.
  const dark = p[1] > CHIN ? 0.05 : 0.17;
  return Math.round(255 * Math.max(1 - dark * closed, 0.5));
}

/** How much farther than the nearest cone one may be to have a share, metres. Chosen by eye. */
const REACH = 0.055;
/** Half the width of the zone in the middle in which both legs have a share, metres. */
const BETWEEN = 0.02;

/** The bones of the cones, and of those on the right side. */
const OWN = CONES.map(({ bone }) => numberOf(bone));
const TWIN = CONES.map(({ bone }) => numberOf(opposite(bone)));

/** The bones that move a place, at most four, and their shares. */
function bonesAt([x, y, z]: Place): [bone: number, share: number][] {
  const own = CONES.map((one) => outside(one, x, y, z));
  // Only near the middle does the other side matter.
  const other = CONES.map((one, n) =>
    OWN[n] === TWIN[n] || x < BETWEEN ? outside(one, -x, y, z) : Infinity,
  );
  const fars = own.map((far, n) => (OWN[n] === TWIN[n] ? Math.min(far, other[n]!) : far));
  const least = Math.min(...fars);
  const towards = Math.min(0.5 + x / (2 * BETWEEN), 1);
  const shares = new Float64Array(BONES.length);
  const add = (bone: number, far: number, part: number): void => {
    const close = Math.max(1 - Math.max(far - least, 0) / REACH, 0);
    shares[bone] = Math.max(shares[bone]!, part * close * close * close);
  };
  CONES.forEach((_, n) => {
    const sided = OWN[n] !== TWIN[n];
    add(OWN[n]!, fars[n]!, sided ? towards : 1);
    if (sided && towards < 1) add(TWIN[n]!, other[n]!, 1 - towards);
  });
  const most = [...shares.keys()].filter((bone) => shares[bone]! > 0);
  most.sort((p, q) => shares[q]! - shares[p]! || p - q).splice(4);
  const sum = most.reduce((total, bone) => total + shares[bone]!, 0);
  return most.map((bone) => [bone, shares[bone]! / sum]);
}
