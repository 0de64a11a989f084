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
  /** Called before each frame with the seconds since the last; true: draw this view. */
  update(seconds: number): boolean;
  /** Called when the colours of the page change, and once at the start. */
  recolour(colours: StageColours): void;
}

/** Largest pixel ratio; a larger one costs time but is not visible. */
const MOST_PIXELS_PER_POINT = 2;
/** Longest time step, seconds; a longer pause (a hidden tab) counts as this. */
const LONGEST_STEP = 0.1;

interface Entry {
  view: StageView;
  visible: boolean;
  stale: boolean;
}

export interface Stage {
  readonly available: boolean;
  /** Start drawing a view; returns a function that stops it. */
  add(view: StageView): () => void;
  /** Frames drawn in the last second, all views together. */
  framesPerSecond(): number;
}

function makeRenderer(): THREE.WebGLRenderer | null {
  try {
    const renderer = new THREE.WebGLRenderer({ antialias: true, powerPreference: "high-performance" });
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
  let colours: StageColours | null = null;
  let last = 0;
  let running = false;
  let drawn: number[] = [];

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
    const seconds = Math.min((now - last) / 1000, LONGEST_STEP);
    last = now;
    drawn = drawn.filter((time) => time > now - 1000);
    let any = false;
    for (const entry of entries.values()) {
      if (!entry.visible) continue;
      const changed = entry.view.update(seconds);
      if ((changed || entry.stale) && renderer) {
        entry.stale = false;
        draw(renderer, entry.view);
        any = true;
      }
    }
    if (any) drawn.push(now);
  }

  return {
    get available() {
      renderer ??= makeRenderer();
      return renderer !== null;
    },
    add(view) {
      if (renderer === undefined) renderer = makeRenderer();
      colours ??= stageColours();
      view.recolour(colours);
      entries.set(view.canvas, { view, visible: false, stale: true });
      seen.observe(view.canvas);
      sized.observe(view.canvas);
      if (!running) {
        running = true;
        last = performance.now();
        requestAnimationFrame(frame);
      }
      return () => {
        entries.delete(view.canvas);
        seen.unobserve(view.canvas);
        sized.unobserve(view.canvas);
      };
    },
    framesPerSecond: () => drawn.length,
  };
}
