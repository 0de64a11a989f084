/**
 * The mannequin on a plain canvas, filled triangle by triangle: for small pictures in lists.
 *
 * Dozens of them move at once, and they are seen before three.js is there. Small ones are drawn twice
 * as large and made smaller, so that their edges are smooth.
 */

import { BRIGHT, TO_BACK, TO_LAMP } from "../lamps.ts";
import { makeRig, type Rig } from "./bones.ts";
import { meshOf } from "./mesh.ts";
import { place } from "./skin.ts";
import type { Vector } from "./turns.ts";

export interface Portrait {
  points: readonly string[];
  /** (points, 3), metres. */
  pose: ArrayLike<number>;
  /** Like #96a2aa. */
  colour: string;
  /** Directions to the right, up and towards the eye. */
  view: readonly [right: Vector, up: Vector, near: Vector];
  /** A place in the world, where it is on the picture, and pixels for a metre. */
  middle: Vector;
  origin: readonly [x: number, y: number];
  size: number;
}

/** Points for each of a picture's width and height; large pictures have one. */
const finerOf = (size: number): number => (size < 240 ? 2 : 1);
/** Share by which triangles are larger than they are, so that rounding leaves no gap between them. */
const EDGE = 1e-4;
const rigs = new Map<string, Rig>();
let [places, normals, seen] = [new Float32Array(0), new Float32Array(0), new Float32Array(0)];
let lights = new Float32Array(0);
let depth = new Float32Array(0);
const sheet = document.createElement("canvas");
const pencil = sheet.getContext("2d", { willReadFrequently: true })!;

/** Draw a body. */
export function drawPortrait(context: CanvasRenderingContext2D, shown: Portrait): void {
  const mesh = meshOf("small");
  const key = shown.points.join(" ");
  const rig = rigs.get(key) ?? makeRig(shown.points);
  rigs.set(key, rig);
  const finer = finerOf(shown.size);
  if (places.length === 0) {
    [places, normals, seen] = [0, 1, 2].map(() => new Float32Array(mesh.position.length)) as [
      Float32Array<ArrayBuffer>,
      Float32Array<ArrayBuffer>,
      Float32Array<ArrayBuffer>,
    ];
    lights = new Float32Array(places.length / 3);
  }
  rig.follow(shown.pose);
  place(mesh, rig.matrices, places, normals);

  // Where the corners are on the picture, and how bright.
  const scale = finer * shown.size;
  const [right, up, towards] = shown.view;
  const [mx, my, mz] = shown.middle;
  const [ox, oy] = [finer * shown.origin[0], finer * shown.origin[1]];
  let [left, top, most, bottom] = [Infinity, Infinity, -Infinity, -Infinity];
  for (let i = 0; i < places.length; i += 3) {
    const x = places[i]! - mx;
    const y = places[i + 1]! - my;
    const z = places[i + 2]! - mz;
    const across = ox + scale * (right[0] * x + right[1] * y + right[2] * z);
    const down = oy - scale * (up[0] * x + up[1] * y + up[2] * z);
    seen[i] = across;
    seen[i + 1] = down;
    seen[i + 2] = towards[0] * x + towards[1] * y + towards[2] * z;
    if (across < left) left = across;
    if (across > most) most = across;
    if (down < top) top = down;
    if (down > bottom) bottom = down;
    lights[i / 3] = mesh.shade[i / 3]! * lightOf(normals[i]!, normals[i + 1]!, normals[i + 2]!);
  }
  // In whole points of the picture, so that halving is exact.
  const x0 = finer * Math.floor(left / finer);
  const y0 = finer * Math.floor(top / finer);
  const width = finer * Math.ceil((most - x0 + 1) / finer);
  const height = finer * Math.ceil((bottom - y0 + 1) / finer);
  if (!(width > 0 && height > 0)) return;
  const image = pencil.createImageData(width, height);
  fill(image, mesh.index, x0, y0, rgbOf(shown.colour));
  if (sheet.width < width || sheet.height < height) {
    Object.assign(sheet, { width: Math.max(sheet.width, width), height: Math.max(sheet.height, height) });
  }
  pencil.putImageData(image, 0, 0);
  const [w, h] = [width / finer, height / finer];
  context.drawImage(sheet, 0, 0, width, height, x0 / finer, y0 / finer, w, h);
}

/** The light of a surface, as in the shaders, over 255. */
function lightOf(x: number, y: number, z: number): number {
  const length = Math.sqrt(x * x + y * y + z * z) || 1;
  const lamp = Math.max(x * TO_LAMP[0] + y * TO_LAMP[1] + z * TO_LAMP[2], 0) / length;
  const back = Math.max(x * TO_BACK[0] + y * TO_BACK[1] + z * TO_BACK[2], 0) / length;
  const sky = 0.5 + (0.5 * y) / length;
  const all = BRIGHT.ground + (BRIGHT.sky - BRIGHT.ground) * sky + BRIGHT.lamp * lamp + BRIGHT.back * back;
  return all / 255;
}

/** Fill the triangles that face the eye; the nearest at each point is seen. */
function fill(image: ImageData, index: Uint16Array, x0: number, y0: number, colour: readonly number[]): void {
  const { width, height, data } = image;
  if (depth.length < width * height) depth = new Float32Array(width * height);
  depth.fill(-Infinity, 0, width * height);
  const red = colour[0]!;
  const green = colour[1]!;
  const blue = colour[2]!;
  for (let t = 0; t < index.length; t += 3) {
    const a = 3 * index[t]!;
    const b = 3 * index[t + 1]!;
    const c = 3 * index[t + 2]!;
    const ax = seen[a]! - x0;
    const ay = seen[a + 1]! - y0;
    const bx = seen[b]! - x0;
    const by = seen[b + 1]! - y0;
    const cx = seen[c]! - x0;
    const cy = seen[c + 1]! - y0;
    const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    if (area >= 0) continue; // y points down on a picture: what faces the eye turns the other way
    const az = seen[a + 2]!;
    const bz = seen[b + 2]!;
    const cz = seen[c + 2]!;
    const al = lights[a / 3]!;
    const bl = lights[b / 3]!;
    const cl = lights[c / 3]!;
    const yFrom = Math.max(Math.ceil(Math.min(ay, by, cy) - 0.5), 0);
    const yTo = Math.min(Math.floor(Math.max(ay, by, cy) - 0.5), height - 1);
    const xFrom = Math.max(Math.ceil(Math.min(ax, bx, cx) - 0.5), 0);
    const xTo = Math.min(Math.floor(Math.max(ax, bx, cx) - 0.5), width - 1);
    const ux = (by - cy) / area;
    const uy = (cx - bx) / area;
    const vx = (cy - ay) / area;
    const vy = (ax - cx) / area;
    for (let y = yFrom; y <= yTo; y += 1) {
      let u = ux * (xFrom + 0.5 - bx) + uy * (y + 0.5 - by);
      let v = vx * (xFrom + 0.5 - cx) + vy * (y + 0.5 - cy);
      for (let x = xFrom; x <= xTo; x += 1, u += ux, v += vx) {
        const w = 1 - u - v;
        if (u < -EDGE || v < -EDGE || w < -EDGE) continue;
        const at = y * width + x;
        const near = u * az + v * bz + w * cz;
        if (near <= depth[at]!) continue;
        depth[at] = near;
        const light = u * al + v * bl + w * cl;
        data[4 * at] = red * light;
        data[4 * at + 1] = green * light;
        data[4 * at + 2] = blue * light;
        data[4 * at + 3] = 255;
      }
    }
  }
}

/** Red, green and blue of a colour like #96a2aa, 0 to 255. */
function rgbOf(colour: string): number[] {
  const value = parseInt(colour.trim().slice(1), 16);
  return [value >> 16, (value >> 8) & 255, value & 255];
}
