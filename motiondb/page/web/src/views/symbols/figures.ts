/** Small moving figures on the dots of the map, painted on one canvas under it. */

import { DARK, REDUCED } from "../../dom/wishes.ts";
import type { BodyTrack } from "../../api/container.ts";
import type { Motions } from "../../api/motions.ts";
import type { PlacedSymbol } from "../../api/types.ts";
import { h } from "../../dom/element.ts";
import {
  figureShades,
  nextPainting,
  paintAt,
  sketchOf,
  whenDressed,
  type Sketch,
} from "../../player/painter.ts";
import { alignTracks } from "../compare/aligned.ts";
import { FIGURE } from "./labels.ts";

export interface Spot {
  symbol: number;
  x: number;
  y: number;
}

/** Pictures per second: enough for figures of this size. */
const RATE = 15;

export function makeMapFigures(motions: Motions, size: { width: number; height: number }) {
  const element = h("canvas.symbol-figures", { "aria-hidden": "true" });
  const sketches = new Map<number, Sketch>();
  let spots: readonly Spot[] = [];
  let colours = figureShades();
  let next = 0;
  let stale = true;
  let closed = false;

  function draw(seconds: number): void {
    const scale = Math.min(devicePixelRatio, 2);
    const [width, height] = [element.clientWidth, element.clientHeight];
    const context = element.getContext("2d");
    if (!context || width === 0) return;
    Object.assign(element, { width: width * scale, height: height * scale });
    // The picture is scaled and centred as the SVG over it.
    const unit = Math.min(width / size.width, height / size.height) * scale;
    const [left, top] = [(width * scale - size.width * unit) / 2, (height * scale - size.height * unit) / 2];
    for (const { symbol, x, y } of spots) {
      const sketch = sketches.get(symbol);
      if (!sketch) continue;
      const { start, frames, fps } = sketch.motion;
      const time = start + (seconds % Math.max(frames / fps, 0.1));
      paintAt(context, sketch, time, colours, [left + x * unit, top + y * unit, FIGURE.height * unit]);
    }
  }

  function frame(now: number): void {
    if (closed) return;
    requestAnimationFrame(frame);
    if ((REDUCED.matches && !stale) || now < next) return;
    const began = performance.now();
    stale = false;
    draw(REDUCED.matches ? 0.4 : now / 1000);
    next = nextPainting(now, began, RATE);
  }
  const recolour = (): void => {
    colours = figureShades();
    stale = true;
  };
  DARK.addEventListener("change", recolour);
  void whenDressed().then(() => (stale = true));
  const sized = new ResizeObserver(() => (stale = true));
  sized.observe(element);
  requestAnimationFrame(frame);

  return {
    element,
    /** Load the typical segments of these symbols. */
    load(symbols: readonly PlacedSymbol[]): void {
      for (const { symbol, typical } of symbols) {
        if (!typical) continue;
        const { ref, start, end } = typical;
        motions.tracks(ref, start, end).then(
          (tracks) => {
            const body = tracks.find((one): one is BodyTrack => one.kind === "body");
            if (!body || body.motion.frames === 0) return;
            const part = { ref, start, end };
            const { motion } = alignTracks([body], [part], "start", true).tracks[0]!; // facing forward
            sketches.set(symbol, sketchOf(motion));
            stale = true;
          },
          () => undefined, // a symbol without a figure still has its dot
        );
      }
    },
    /** Where figures stand, in units of the picture. */
    place(next: readonly Spot[]): void {
      spots = next;
      stale = true;
    },
    close(): void {
      closed = true;
      sized.disconnect();
      DARK.removeEventListener("change", recolour);
    },
  };
}
