/**
 * Draw a figure on a 2D canvas: for thumbnails, and where there is no WebGL.
 *
 * The capsules are projected without perspective, sorted from far to near, and drawn as thick
 * lines with round ends: an edge in the colour of the ground, the limb, and a light along it. About
 * 75 strokes a figure: dozens of thumbnails cost a few milliseconds.
 */

import { bonesOf, CAPSULE, sharesOf, writeCapsules, type Bone } from "./body.ts";
import { poseAt, type Motion } from "./motion.ts";

export interface Sketch {
  motion: Motion;
  bones: readonly Bone[];
  shares: readonly number[];
  pose: Float32Array;
  capsules: Float32Array;
  /** What fits into the height of a canvas, and half of what fits into its width; metres. */
  tall: number;
  wide: number;
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
    ...sizeOf(motion),
  };
}

/** How much room a motion needs: raised hands and jumps are not cut off. */
function sizeOf({ positions, frames, points }: Motion): { tall: number; wide: number } {
  let [tall, wide] = [TALL, 0.3];
  for (let i = 0; i < frames * points.length; i += 1) {
    const root = 3 * (i - (i % points.length));
    const [x, y, z] = [positions[3 * i]!, positions[3 * i + 1]!, positions[3 * i + 2]!];
    const [right, up] = project(x - positions[root]!, y, z - positions[root + 2]!, VIEW);
    tall = Math.max(tall, up + 0.15);
    wide = Math.max(wide, Math.abs(right) + 0.12);
  }
  return { tall, wide };
}

/** The direction of view: turned about the vertical, then tilted down. */
export interface View {
  azimuth: number;
  elevation: number;
}

/** A stroke whose two ends are together this much nearer or farther, metres, is on another side. */
const APART = 0.16;
/** What fits into the height of a canvas at least, metres. */
const TALL = 1.9;
/** From this many pixels a metre on, limbs have an edge and a light. */
const LARGE = 40;
const VIEW: View = { azimuth: 0.6, elevation: 0.2 };

/** Right, up and nearness of a point seen from a direction. */
export function project(x: number, y: number, z: number, view: View): [number, number, number] {
  const right = x * Math.cos(view.azimuth) - z * Math.sin(view.azimuth);
  const towards = x * Math.sin(view.azimuth) + z * Math.cos(view.azimuth);
  const up = y * Math.cos(view.elevation) - towards * Math.sin(view.elevation);
  return [right, up, towards * Math.cos(view.elevation) + y * Math.sin(view.elevation)];
}

/** Colours of the near side of a body, of its middle and of its far side; of the ground, and of a shadow. */
export type Shades = readonly [near: string, middle: string, far: string, ground: string, shadow: string];

/** The colours of painted figures in the present scheme, light or dark. */
export function figureShades(): Shades {
  const style = getComputedStyle(document.documentElement);
  const shade = (name: string): string => style.getPropertyValue(`--${name}`);
  return [
    shade("figure-near"),
    shade("figure-middle"),
    shade("figure-far"),
    shade("stage"),
    shade("stage-shadow"),
  ];
}

/** The same for a figure that shows what was asked for. */
export function litShades(): Shades {
  const [, , , ground, shadow] = figureShades();
  const lit = getComputedStyle(document.documentElement).getPropertyValue("--figure-lit");
  const mixed = (by: string): string => `color-mix(in srgb, ${lit} 72%, ${by})`;
  return [mixed("black"), lit, mixed(ground), ground, shadow];
}

/** Draw one pose on a canvas that nothing was drawn on yet, as a player will show it. */
export function paintPoster(canvas: HTMLCanvasElement, motion: Motion, shades: Shades): void {
  const scale = Math.min(devicePixelRatio, 2);
  Object.assign(canvas, { width: canvas.clientWidth * scale, height: canvas.clientHeight * scale });
  const context = canvas.getContext("2d", { alpha: false });
  if (!context) return;
  const { width, height } = context.canvas;
  context.fillStyle = shades[3];
  context.fillRect(0, 0, width, height);
  const seen = height * 0.86; // as large as the camera of a clip shows it
  paintAt(context, sketchOf(motion), motion.start, shades, [width / 2, height * 0.9, seen]);
}

/** Draw a motion at a time; the figure stays in the middle of the canvas. */
export function paint(
  context: CanvasRenderingContext2D,
  sketch: Sketch,
  seconds: number,
  colours: Shades,
): void {
  const { width, height } = context.canvas;
  context.clearRect(0, 0, width, height);
  const fits = (sketch.tall * width) / (2 * sketch.wide * 0.86); // arms that are held out fit in
  paintAt(context, sketch, seconds, colours, [width / 2, height * 0.94, Math.min(height, fits)]);
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
  const size = (height * 0.86) / sketch.tall;
  const strokes = [];
  for (let i = 0; i < count; i += 1) {
    const c = sketch.capsules.subarray(i * CAPSULE, (i + 1) * CAPSULE);
    const a = project(c[0]! - rootX!, c[1]!, c[2]! - rootZ!, VIEW);
    const b = project(c[4]! - rootX!, c[5]!, c[6]! - rootZ!, VIEW);
    strokes.push({ a, b, wide: Math.max((c[3]! + c[7]!) * size, 1), near: a[2] + b[2] });
  }
  strokes.sort((p, q) => p.near - q.near);
  const middle = strokes[strokes.length >> 1]?.near ?? 0;
  const [, , , ground, shadow] = colours;
  context.fillStyle = shadow;
  context.beginPath();
  context.ellipse(x0, y0, 0.42 * size, 0.1 * size, 0, 0, 2 * Math.PI);
  context.fill();
  context.lineCap = "round";
  for (const { a, b, wide, near } of strokes) {
    const line = (colour: string, width: number, shift = 0): void => {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.beginPath();
      context.moveTo(x0 + a[0] * size - shift, y0 - a[1] * size - shift);
      context.lineTo(x0 + b[0] * size + 0.01 - shift, y0 - b[1] * size - shift);
      context.stroke();
    };
    if (size > LARGE) line(ground, wide + 0.025 * size);
    line(colours[near > middle + APART ? 0 : near > middle - APART ? 1 : 2], wide);
    if (size > LARGE) line("rgb(255 255 255 / 16%)", 0.4 * wide, 0.17 * wide);
  }
}
