/**
 * One WebGL renderer for all players of the page.
 *
 * A browser allows few WebGL contexts. Each view has a plain canvas; the renderer draws the view's
 * scene off screen and the result is copied. Only views that are on screen and have changed are
 * drawn. Where there is no WebGL, `Stage` says so and players draw flat figures instead.
 */

import * as THREE from "three";
import { DARK, stageColours, type StageColours } from "./colours.ts";

export interface StageView {
  readonly canvas: HTMLCanvasElement;
  readonly scene: THREE.Scene;
  readonly camera: THREE.PerspectiveCamera;
  /** Whether there is nothing to see yet; the canvas then has the colour of the page. */
  isEmpty(): boolean;
  /** Called before each frame with the seconds since the last; true: draw this view. */
  update(seconds: number): boolean;
  /** Called when the colours of the page change, and once at the start. */
  recolour(colours: StageColours): void;
}

/** Sharper than this is not seen, but costs. */
const MOST_PIXELS_PER_POINT = 2;
/** A longer pause (a hidden tab) counts as this, in seconds. */
const LONGEST_STEP = 0.25;
/**
 * Milliseconds of a frame in which views are drawn; the others have their turn in the next frame.
 * Without a graphics processor many players would else leave no time for the page itself.
 * Chosen by hand: a frame has 16.
 */
const DRAWING = 10;

/**
 * A view whose frames take longer, milliseconds, is drawn without smoothed edges while it moves, and
 * with them when it stands still. Chosen by hand: sixty frames a second leave 16.
 */
const SLOW = 8;
/** The share of the newest frame in the time that a view takes. Chosen by hand. */
const NEWEST = 0.2;
/** Per frame without smoothed edges, what is left of the time that one with them took: after some
 * hundred frames it is tried again, as the machine may have been busy. Chosen by hand. */
const FORGET = 0.9995;

interface Entry {
  view: StageView;
  visible: boolean;
  stale: boolean;
  /** When it had its last turn, milliseconds. */
  last: number;
  /** Milliseconds that a frame with smoothed edges takes, over the last ones. */
  takes: number;
  /** Whether the last frame was drawn without smoothed edges. */
  rough: boolean;
}

export interface Stage {
  readonly available: boolean;
  /** Begin to draw a view; returns how to end. */
  add(view: StageView): () => void;
}

function makeRenderer(antialias: boolean): THREE.WebGLRenderer | null {
  try {
    const renderer = new THREE.WebGLRenderer({ antialias, powerPreference: "high-performance" });
    renderer.outputColorSpace = THREE.LinearSRGBColorSpace; // the shaders give display colours
    renderer.autoClear = true;
    return renderer;
  } catch {
    return null;
  }
}

/** Make the stage; the renderer is made with the first view. */
export function makeStage(): Stage {
  const entries = new Map<Element, Entry>();
  let renderer: THREE.WebGLRenderer | null | undefined;
  let quick: THREE.WebGLRenderer | null | undefined; // without smoothed edges; made when needed
  let colours: StageColours | null = null;
  let running = false;
  let turn = 0;

  const seen = new IntersectionObserver((changes) => {
    for (const change of changes) {
      const entry = entries.get(change.target);
      if (entry) Object.assign(entry, { visible: change.isIntersecting, stale: true });
    }
  });
  const sized = new ResizeObserver((changes) => {
    for (const change of changes) {
      const entry = entries.get(change.target);
      if (entry) entry.stale = true;
    }
  });
  DARK.addEventListener("change", () => {
    colours = stageColours();
    for (const entry of entries.values()) {
      entry.view.recolour(colours);
      entry.stale = true;
    }
  });

  function draw(gl: THREE.WebGLRenderer, view: StageView): void {
    const { canvas, camera, scene } = view;
    const scale = Math.min(devicePixelRatio, MOST_PIXELS_PER_POINT);
    const width = Math.round(canvas.clientWidth * scale);
    const height = Math.round(canvas.clientHeight * scale);
    if (width === 0 || height === 0) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const source = gl.domElement;
    if (source.width < width || source.height < height) {
      gl.setSize(Math.max(source.width, width), Math.max(source.height, height), false);
    }
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    gl.setViewport(0, 0, width, height);
    gl.setScissor(0, 0, width, height);
    gl.setScissorTest(true);
    gl.render(scene, camera);
    const context = canvas.getContext("2d", { alpha: false });
    context?.drawImage(source, 0, source.height - height, width, height, 0, 0, width, height);
  }

  function frame(now: number): void {
    if (entries.size === 0) {
      running = false;
      return;
    }
    requestAnimationFrame(frame);
    const all = [...entries.values()];
    const began = performance.now();
    const first = turn % all.length;
    for (let i = 0; i < all.length; i += 1) {
      const entry = all[(first + i) % all.length]!;
      if (!entry.visible) {
        entry.last = now;
        continue;
      }
      if (performance.now() - began > DRAWING) {
        turn = first + i;
        break;
      }
      const changed = entry.view.update(Math.min((now - entry.last) / 1000, LONGEST_STEP));
      entry.last = now;
      if ((changed || entry.stale || entry.rough) && renderer && !entry.view.isEmpty()) {
        entry.stale = false;
        drawEntry(renderer, entry, changed);
      }
    }
  }

  function drawEntry(sharp: THREE.WebGLRenderer, entry: Entry, moves: boolean): void {
    const isRough = moves && entry.takes > SLOW;
    if (isRough && quick === undefined) quick = makeRenderer(false);
    const began = performance.now();
    draw((isRough && quick) || sharp, entry.view);
    if (isRough) entry.takes *= FORGET;
    else if (moves && !entry.rough) entry.takes += NEWEST * (performance.now() - began - entry.takes);
    entry.rough = isRough;
  }

  return {
    get available() {
      renderer ??= makeRenderer(true);
      return renderer !== null;
    },
    add(view) {
      if (renderer === undefined) renderer = makeRenderer(true);
      colours ??= stageColours();
      view.recolour(colours);
      entries.set(view.canvas, {
        view,
        visible: false,
        stale: true,
        last: performance.now(),
        takes: 0,
        rough: false,
      });
      seen.observe(view.canvas);
      sized.observe(view.canvas);
      if (!running) {
        running = true;
        requestAnimationFrame(frame);
      }
      return () => {
        entries.delete(view.canvas);
        seen.unobserve(view.canvas);
        sized.unobserve(view.canvas);
      };
    },
  };
}
