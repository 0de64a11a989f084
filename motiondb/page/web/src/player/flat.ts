/** Figures without WebGL: the same capsules as thick lines on a plain canvas, from far to near. */

import { CAPSULE } from "./body.ts";
import { eyeOf, FIELD_OF_VIEW, type Orbit } from "./camera.ts";
import type { Picture } from "./figures.ts";

type Point = readonly [x: number, y: number, depth: number];

/** A function from places in the world to places on a picture of a height, seen by a camera. */
export function pictureOf(orbit: Orbit, width: number, height: number): (p: readonly number[]) => Point {
  const eye = eyeOf(orbit);
  const [sa, ca] = [Math.sin(orbit.azimuth), Math.cos(orbit.azimuth)];
  const [se, ce] = [Math.sin(orbit.elevation), Math.cos(orbit.elevation)];
  const size = height / 2 / Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
  return (p) => {
    const [x, y, z] = [p[0]! - eye[0], p[1]! - eye[1], p[2]! - eye[2]];
    const right = x * ca - z * sa;
    const back = x * sa + z * ca;
    const up = y * ce - back * se;
    const depth = Math.max(-(back * ce + y * se), 0.05);
    return [width / 2 + (right * size) / depth, height / 2 - (up * size) / depth, depth];
  };
}

/** Draw bodies and marks on a canvas. */
export function paintFlat(canvas: HTMLCanvasElement, shown: Picture, orbit: Orbit): void {
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const context = canvas.getContext("2d");
  if (!context || width === 0) return;
  context.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--stage");
  context.fillRect(0, 0, width, height);
  const picture = pictureOf(orbit, width, height);
  const size = height / 2 / Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
  const strokes = [];
  for (const drawn of [shown.bodies, shown.marks, shown.prints]) {
    for (let i = 0; i < drawn.count; i += 1) {
      const c = drawn.capsules.subarray(i * CAPSULE, (i + 1) * CAPSULE);
      const a = picture([c[0]!, c[1]!, c[2]!]);
      const b = picture([c[4]!, c[5]!, c[6]!]);
      const depth = (a[2] + b[2]) / 2;
      const [red, green, blue] = drawn.tints.subarray(3 * i, 3 * i + 3);
      const colour = `rgb(${red! * 255} ${green! * 255} ${blue! * 255})`;
      strokes.push({ a, b, depth, wide: ((c[3]! + c[7]!) * size) / depth, colour });
    }
  }
  strokes.sort((p, q) => q.depth - p.depth);
  context.lineCap = "round";
  for (const { a, b, wide, colour } of strokes) {
    context.strokeStyle = colour;
    context.lineWidth = Math.max(wide, 1);
    context.beginPath();
    context.moveTo(a[0], a[1]);
    context.lineTo(b[0] + 0.01, b[1]);
    context.stroke();
  }
}
