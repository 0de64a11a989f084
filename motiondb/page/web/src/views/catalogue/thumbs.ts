/** Small moving figures: one clock paints all that are on screen. */

import { DARK, REDUCED } from "../../dom/wishes.ts";
import { figureShades } from "../../player/colours.ts";
import type { Motions } from "../../api/motions.ts";
import type { Stage } from "../../player/stage.ts";
import { paint, sketchOf, type Sketch } from "../../player/painter.ts";

export interface Thumbs {
  /** Show the figure of a capture on a canvas; null clears it. */
  show(canvas: HTMLCanvasElement, capture: string | null): void;
  /** Let a figure move, or stand; only where all stand until they are pointed at. */
  move(canvas: HTMLCanvasElement, moving: boolean): void;
  close(): void;
}

/** Pictures per second: enough for a thumbnail. */
const RATE = 20;

/** `still`: the figures stand until they are pointed at. */
export function makeThumbs({ motions, stage }: { motions: Motions; stage: Stage }, still = false): Thumbs {
  const moving = new Set<HTMLCanvasElement>();
  const wanted = new Map<HTMLCanvasElement, string>();
  const sketches = new Map<HTMLCanvasElement, Sketch>();
  let colours = figureShades();
  let painted = 0;
  let closed = false;

  function draw(canvas: HTMLCanvasElement, sketch: Sketch, now: number): void {
    const context = canvas.getContext("2d");
    const length = sketch.motion.frames / sketch.motion.fps;
    if (context) paint(context, sketch, sketch.motion.start + (now % Math.max(length, 0.1)), colours);
  }

  function frame(now: number): void {
    if (closed) return;
    requestAnimationFrame(frame);
    if ((REDUCED.matches && moving.size === 0) || stage.resting || now - painted < 1000 / RATE) return;
    painted = now;
    for (const [canvas, sketch] of sketches) {
      if (canvas.isConnected && (!still || moving.has(canvas))) draw(canvas, sketch, now / 1000);
    }
  }
  /** The moment that a standing figure shows, seconds from its start. */
  const momentOf = (sketch: Sketch): number => 0.5 * Math.min(sketch.motion.frames / sketch.motion.fps, 2);
  function recolour(): void {
    colours = figureShades();
    for (const [canvas, sketch] of sketches) draw(canvas, sketch, momentOf(sketch));
  }
  DARK.addEventListener("change", recolour);
  requestAnimationFrame(frame);

  return {
    show(canvas, capture) {
      if (capture !== null && wanted.get(canvas) === capture) return;
      sketches.delete(canvas);
      canvas.getContext("2d")?.clearRect(0, 0, canvas.width, canvas.height);
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
          draw(canvas, sketch, momentOf(sketch));
        },
        () => undefined, // a row without a figure is still a row
      );
    },
    move(canvas, on) {
      if (on) moving.add(canvas);
      else moving.delete(canvas);
    },
    close() {
      closed = true;
      DARK.removeEventListener("change", recolour);
    },
  };
}
