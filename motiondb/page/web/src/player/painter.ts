/**
 * Draw a figure on a 2D canvas: for thumbnails.
 *
 * A person is the mannequin of the player, whose code comes after the first pictures. Until then,
 * and for other bodies, capsules are projected without perspective, sorted from far to near, and
 * drawn as thick lines with round ends: an edge in the colour of the ground, the limb, and a light
 * along it.
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

let mannequin: typeof import("./mannequin/figure.ts") | null = null;
let coming: Promise<unknown> | null = null;

/** Ends when figures are drawn as they are to be: what stands is drawn anew then. */
export function whenDressed(): Promise<unknown> {
  coming ??= import("./mannequin/figure.ts").then((code) => (mannequin = code));
  return coming;
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
    const [right, up] = project(x - positions[root]!, y, z - positions[root + 2]!);
    tall = Math.max(tall, up + 0.15);
    wide = Math.max(wide, Math.abs(right) + 0.12);
  }
  return { tall, wide };
}

/** A stroke whose two ends are together this much nearer or farther, metres, is on another side. */
const APART = 0.16;
/** What fits into the height of a canvas at least, metres. */
const TALL = 1.9;
/** From this many pixels a metre on, limbs have an edge and a light. */
const LARGE = 40;
/** The direction of view: turned about the vertical, then tilted down, radians. */
const [AZIMUTH, ELEVATION] = [0.6, 0.2];
const [SIN_A, COS_A] = [Math.sin(AZIMUTH), Math.cos(AZIMUTH)];
const [SIN_E, COS_E] = [Math.sin(ELEVATION), Math.cos(ELEVATION)];
/** Directions to the right, up and towards the eye. */
const AXES = [
  [COS_A, 0, -SIN_A],
  [-SIN_A * SIN_E, COS_E, -COS_A * SIN_E],
  [SIN_A * COS_E, SIN_E, COS_A * COS_E],
] as const;

/** Right, up and nearness of a point. */
function project(x: number, y: number, z: number): [right: number, up: number, near: number] {
  return AXES.map((axis) => axis[0] * x + axis[1] * y + axis[2] * z) as [number, number, number];
}

/** Colours of the near side of a body, of its middle and of its far side; of the ground, a shadow, and all of it. */
export type Shades = readonly [
  near: string,
  middle: string,
  far: string,
  ground: string,
  shadow: string,
  whole: string,
];

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
    shade("figure"),
  ];
}

/** The same for a figure that shows what was asked for. */
export function litShades(): Shades {
  const [, , , ground, shadow] = figureShades();
  const lit = getComputedStyle(document.documentElement).getPropertyValue("--figure-lit");
  const mixed = (by: string): string => `color-mix(in srgb, ${lit} 72%, ${by})`;
  return [mixed("black"), lit, mixed(ground), ground, shadow, lit];
}

/** Pauses are at least this many times as long as the painting, so that the page has time. By hand. */
const PAUSE = 2.5;

/** When what moves is to be painted again, after a frame at `now` whose painting began then. */
export function nextPainting(now: number, began: number, rate: number): number {
  const least = (1 + PAUSE) * (performance.now() - began);
  return now + Math.max(1000 / rate, least) - 2; // frames are not exact
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
  const size = (height * 0.86) / sketch.tall;
  const [, , , ground, shadow, whole] = colours;
  drawShadow(context, shadow, x0, y0, 0.5 * size);
  const [rootX, , rootZ] = sketch.pose;
  const { points } = sketch.motion;
  if (mannequin?.fits(points)) {
    const { pose } = sketch;
    const middle = [rootX!, 0, rootZ!] as const;
    mannequin.drawPortrait(context, {
      points,
      pose,
      colour: whole,
      view: AXES,
      middle,
      origin: [x0, y0],
      size,
    });
    return;
  }
  const count = writeCapsules(sketch.bones, sketch.shares, sketch.pose, sketch.capsules, 0);
  const strokes = [];
  for (let i = 0; i < count; i += 1) {
    const c = sketch.capsules.subarray(i * CAPSULE, (i + 1) * CAPSULE);
    const a = project(c[0]! - rootX!, c[1]!, c[2]! - rootZ!);
    const b = project(c[4]! - rootX!, c[5]!, c[6]! - rootZ!);
    strokes.push({ a, b, wide: Math.max((c[3]! + c[7]!) * size, 1), near: a[2] + b[2] });
  }
  strokes.sort((p, q) => p.near - q.near);
  const middle = strokes[strokes.length >> 1]?.near ?? 0;
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

/** A soft spot under a figure. */
function drawShadow(
  context: CanvasRenderingContext2D,
  colour: string,
  x: number,
  y: number,
  radius: number,
): void {
  const soft = context.createRadialGradient(0, 0, 0, 0, 0, radius);
  soft.addColorStop(0.35, colour);
  soft.addColorStop(1, `${colour.trim()}00`);
  context.save();
  context.translate(x, y);
  context.scale(1, 0.25);
  context.fillStyle = soft;
  context.fillRect(-radius, -radius, 2 * radius, 2 * radius);
  context.restore();
}
