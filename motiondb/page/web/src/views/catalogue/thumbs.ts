/** Small moving figures: one clock paints all that are on screen. */

import { DARK, REDUCED } from "../../dom/wishes.ts";
import type { Motions } from "../../api/motions.ts";
import {
  figureShades,
  nextPainting,
  paint,
  sketchOf,
  whenDressed,
  type Sketch,
} from "../../player/painter.ts";

/** Seconds from which a motion plays; a shorter one would flicker, so it stands. */
const SHORTEST = 0.5;
/** Pictures per second: enough for a thumbnail. */
const RATE = 24;
/** Seconds at both ends of a thumbnail in which it fades, so that it does not jump as it begins anew. */
const FADE = 0.08;

/** Dozens of small pictures are drawn sooner by the processor than they are sent to a graphics processor. */
const pencilOf = (canvas: HTMLCanvasElement): CanvasRenderingContext2D | null =>
  canvas.getContext("2d", { willReadFrequently: true });

/** `still`: the figures stand until they are pointed at. `resting`: whether all are to stand still. */
export function makeThumbs(motions: Motions, resting: () => boolean, still = false) {
  const moving = new Set<HTMLCanvasElement>();
  const wanted = new Map<HTMLCanvasElement, string>();
  const sketches = new Map<HTMLCanvasElement, Sketch>();
  let colours = figureShades();
  let next = 0;
  let closed = false;

  function draw(canvas: HTMLCanvasElement, sketch: Sketch, now: number): void {
    const context = pencilOf(canvas);
    const length = (sketch.motion.frames - 1) / sketch.motion.fps;
    if (length < SHORTEST) return stand(canvas, sketch);
    const time = (now + sketch.motion.start) % length; // they do not all begin at once
    if (!context) return;
    context.globalAlpha = Math.min(1, Math.min(time, length - time) / FADE);
    paint(context, sketch, sketch.motion.start + time, colours);
    context.globalAlpha = 1;
  }

  function frame(now: number): void {
    if (closed) return;
    requestAnimationFrame(frame);
    if ((REDUCED.matches && moving.size === 0) || resting() || now < next) return;
    const began = performance.now();
    for (const [canvas, sketch] of sketches) {
      if (canvas.isConnected && (!still || moving.has(canvas))) draw(canvas, sketch, now / 1000);
    }
    next = nextPainting(now, began, RATE);
  }
  /** Draw the pose that shows what happens. */
  function stand(canvas: HTMLCanvasElement, sketch: Sketch): void {
    const context = pencilOf(canvas);
    if (context) paint(context, sketch, sketch.motion.moment ?? sketch.motion.start, colours);
  }
  function recolour(): void {
    colours = figureShades();
    for (const [canvas, sketch] of sketches) stand(canvas, sketch);
  }
  DARK.addEventListener("change", recolour);
  requestAnimationFrame(frame);
  void whenDressed().then(recolour);

  return {
    /** Show the figure of a capture on a canvas; null clears it. */
    show(canvas: HTMLCanvasElement, capture: string | null): void {
      if (capture !== null && wanted.get(canvas) === capture) return;
      sketches.delete(canvas);
      pencilOf(canvas)?.clearRect(0, 0, canvas.width, canvas.height);
      if (capture === null) {
        wanted.delete(canvas);
        return;
      }
      wanted.set(canvas, capture);
      motions.thumb(capture).then(
        (motion) => {
          if (!motion || wanted.get(canvas) !== capture) return;
          const sketch = sketchOf(motion);
          sketches.set(canvas, sketch);
          stand(canvas, sketch);
        },
        () => undefined, // a row without a figure is still a row
      );
    },
    /** Let a figure move, or stand; only where all stand until they are pointed at. */
    move(canvas: HTMLCanvasElement, on: boolean): void {
      if (on) moving.add(canvas);
      else if (moving.delete(canvas) && still) {
        const sketch = sketches.get(canvas);
        if (sketch) stand(canvas, sketch);
      }
    },
    close(): void {
      closed = true;
      DARK.removeEventListener("change", recolour);
    },
  };
}

export type Thumbs = ReturnType<typeof makeThumbs>;
