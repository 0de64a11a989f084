/**
 * Draw a figure on a 2D canvas: for thumbnails, and where there is no WebGL.
 *
 * The capsules are projected without perspective, sorted from far to near, and drawn as thick
 * lines with round ends. About 25 strokes a figure: hundreds of thumbnails cost a few milliseconds.
 */

import { bonesOf, CAPSULE, sharesOf, writeCapsules, type Bone } from "./body.ts";
import { poseAt, type Motion } from "./motion.ts";

export interface Sketch {
  motion: Motion;
  bones: readonly Bone[];
  shares: readonly number[];
  pose: Float32Array;
  capsules: Float32Array;
}

/** What is computed once for a motion that is drawn many times. */
export function sketchOf(motion: Motion): Sketch {
  const bones = bonesOf(motion.points, motion.parents, motion.radii);
  return {
    motion,
    bones,
    shares: sharesOf(motion.points, bones),
    pose: new Float32Array(motion.points.length * 3),
    capsules: new Float32Array(bones.length * CAPSULE),
  };
}

/** The direction of view: turned about the vertical, then tilted down. */
export interface View {
  azimuth: number;
  elevation: number;
}

/** A stroke whose two ends are together this much nearer or farther, metres, is on another side. */
const APART = 0.16;
/** What fits into the height of a canvas, metres. */
const TALL = 1.9;
const VIEW: View = { azimuth: 0.6, elevation: 0.2 };

/** Right, up and nearness of a point seen from a direction. */
export function project(x: number, y: number, z: number, view: View): [number, number, number] {
  const right = x * Math.cos(view.azimuth) - z * Math.sin(view.azimuth);
  const towards = x * Math.sin(view.azimuth) + z * Math.cos(view.azimuth);
  const up = y * Math.cos(view.elevation) - towards * Math.sin(view.elevation);
  return [right, up, towards * Math.cos(view.elevation) + y * Math.sin(view.elevation)];
}

/** Colours of the near side of a body, of its middle and of its far side. */
export type Shades = readonly [near: string, middle: string, far: string];

/** Draw a motion at a time; the figure stays in the middle of the canvas. */
export function paint(
  context: CanvasRenderingContext2D,
  sketch: Sketch,
  seconds: number,
  colours: Shades,
): void {
  const { width, height } = context.canvas;
  context.clearRect(0, 0, width, height);
  paintAt(context, sketch, seconds, colours, [width / 2, height * 0.94, height]);
}

/** Draw a motion at a time on a picture with others: where its ground is, and the height for it. */
export function paintAt(
  context: CanvasRenderingContext2D,
  sketch: Sketch,
  seconds: number,
  colours: Shades,
  [x0, y0, height]: readonly [x: number, y: number, height: number],
): void {
  poseAt(sketch.motion, seconds, sketch.pose);
  const count = writeCapsules(sketch.bones, sketch.shares, sketch.pose, sketch.capsules, 0);
  const [rootX, , rootZ] = sketch.pose;
  const size = (height * 0.86) / TALL;
  const strokes = [];
  for (let i = 0; i < count; i += 1) {
    const c = sketch.capsules.subarray(i * CAPSULE, (i + 1) * CAPSULE);
    const a = project(c[0]! - rootX!, c[1]!, c[2]! - rootZ!, VIEW);
    const b = project(c[4]! - rootX!, c[5]!, c[6]! - rootZ!, VIEW);
    strokes.push({ a, b, wide: c[3]! + c[7]!, near: a[2] + b[2] });
  }
  strokes.sort((p, q) => p.near - q.near);
  const middle = strokes[strokes.length >> 1]?.near ?? 0;
  context.lineCap = "round";
  for (const { a, b, wide, near } of strokes) {
    context.strokeStyle = colours[near > middle + APART ? 0 : near > middle - APART ? 1 : 2];
    context.lineWidth = Math.max(wide * size, 1);
    context.beginPath();
    context.moveTo(x0 + a[0] * size, y0 - a[1] * size);
    context.lineTo(x0 + b[0] * size + 0.01, y0 - b[1] * size);
    context.stroke();
  }
}
