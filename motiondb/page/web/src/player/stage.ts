/**
 * One WebGL renderer for all players of the page.
 *
 * A browser allows few WebGL contexts. Each view has a plain canvas; the renderer draws the view's
 * scene off screen and the result is copied. Only views that are on screen and have changed are
 * drawn. Where there is no WebGL, `Stage` says so and players draw flat figures instead.
 */

import { DARK } from "../dom/wishes.ts";
import * as THREE from "three";
import { stageColours, type StageColours } from "./colours.ts";
import type { Detail } from "./mannequin/mesh.ts";

export interface StageView {
  readonly canvas: HTMLCanvasElement;
  readonly scene: THREE.Scene;
  readonly camera: THREE.PerspectiveCamera;
  /** Whether there is nothing to see; then nothing is drawn, and the last picture is removed. */
  isEmpty(): boolean;
  /** Called before each frame with the seconds since the last; true: draw this view. */
  update(seconds: number): boolean;
  /** Called before the view is drawn: as well as can be, or fast since it moves. */
  prepare(detail: Detail): void;
  /** Called when the colours of the page change, and once at the start. */
  recolour(colours: StageColours): void;
}

/** Largest pixel ratio; a larger one costs time but is not visible. */
const MOST_PIXELS_PER_POINT = 2;
/** A longer pause (a hidden tab) counts as this, in seconds. */
const LONGEST_STEP = 0.25;
/**
 * Milliseconds of a frame in which views are drawn; the others have their turn in the next frame.
 * Without a graphics processor many players would otherwise leave no time for the page itself.
 * Chosen by hand: a frame has 16.
 */
const DRAWING = 10;

/**
 * Milliseconds without movement after which a picture is drawn as well as can be, where that would
 * be too much while it moves. By hand.
 */
const STILL = 150;
/**
 * A picture higher than this, in pixels, shows hands, faces and smoothed edges when it moves, too: to
 * smooth them without a graphics processor costs a large one a sixth more, a small one half. By eye.
 */
const LARGE = 330;
/** Pixels of a smoothed picture for each of its width and height. Chosen by hand: four for one. */
const FINER = 2;

interface Entry {
  view: StageView;
  visible: boolean;
  stale: boolean;
  /** Whether its canvas holds a picture. */
  drawn: boolean;
  /** When it had its last turn, milliseconds. */
  last: number;
  /** When it was last drawn so that it can move; null: it is as well as can be. */
  rough: number | null;
}

const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/**
 * Whether there is no graphics processor. Edges are then smoothed by drawing larger, and making the
 * picture smaller: always in a large one, in a small one once it stands still.
 */
function isSoftware(renderer: THREE.WebGLRenderer): boolean {
  const gl = renderer.getContext();
  const known = gl.getExtension("WEBGL_debug_renderer_info");
  return SOFTWARE.test(String(gl.getParameter(known ? known.UNMASKED_RENDERER_WEBGL : gl.RENDERER)));
}

/** The renderer: with smoothed edges if there is a graphics processor. */
function chooseRenderer(): { renderer: THREE.WebGLRenderer | null; software: boolean } {
  const plain = makeRenderer(false);
  if (!plain || isSoftware(plain)) return { renderer: plain, software: true };
  plain.dispose();
  plain.forceContextLoss();
  return { renderer: makeRenderer(true), software: false };
}

function makeRenderer(antialias: boolean): THREE.WebGLRenderer | null {
  try {
    const renderer = new THREE.WebGLRenderer({ antialias, powerPreference: "high-performance" });
    renderer.outputColorSpace = THREE.LinearSRGBColorSpace; // the shaders give display colours
    renderer.autoClear = true;
    renderer.shadowMap.enabled = true;
    return renderer;
  } catch {
    return null;
  }
}

/** Make the stage; the renderer is made with the first view. */
export function makeStage() {
  const entries = new Map<Element, Entry>();
  let renderer: THREE.WebGLRenderer | null | undefined;
  let software = false;
  let colours: StageColours | null = null;
  let running = false;
  let resting = false;
  let turn = 0;
  // The size of the renderer's picture for what moves, and whether a smoothed one has changed it.
  let most: [width: number, height: number] = [1, 1];
  let spoiled = false;

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

  function begin(): void {
    if (renderer === undefined) ({ renderer, software } = chooseRenderer());
  }

  function draw(gl: THREE.WebGLRenderer, view: StageView, detail: Detail): void {
    const { canvas, camera, scene } = view;
    const scale = Math.min(devicePixelRatio, MOST_PIXELS_PER_POINT);
    const width = Math.round(canvas.clientWidth * scale);
    const height = Math.round(canvas.clientHeight * scale);
    if (width === 0 || height === 0) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const source = gl.domElement;
    const finer = software && detail !== "small" ? FINER : 1;
    const [across, down] = [width * finer, height * finer];
    if (finer > 1) {
      if (source.width !== across || source.height !== down) gl.setSize(across, down, false);
      spoiled = true;
    } else if (source.width < width || source.height < height || spoiled) {
      spoiled = false;
      most = [Math.max(most[0], width), Math.max(most[1], height)];
      gl.setSize(most[0], most[1], false);
    }
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    view.prepare(software ? detail : "fine");
    gl.setViewport(0, 0, across, down);
    gl.setScissor(0, 0, across, down);
    gl.setScissorTest(true);
    gl.render(scene, camera);
    const context = canvas.getContext("2d", { alpha: false });
    context?.drawImage(source, 0, source.height - down, across, down, 0, 0, width, height);
  }

  /** Remove the picture of a view that was emptied. */
  function wipe(entry: Entry): void {
    const context = entry.view.canvas.getContext("2d", { alpha: false });
    if (!context || !colours) return;
    context.fillStyle = `#${colours.background.getHexString()}`;
    context.fillRect(0, 0, context.canvas.width, context.canvas.height);
    Object.assign(entry, { drawn: false, stale: true, rough: null });
  }

  function frame(now: number): void {
    if (entries.size === 0) {
      running = false;
      return;
    }
    requestAnimationFrame(frame);
    if (resting && software) return;
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
      if (!renderer) continue;
      if (entry.view.isEmpty()) {
        if (entry.drawn) wipe(entry);
      } else if (changed || entry.stale) {
        entry.stale = false;
        entry.rough = software ? now : null;
        draw(renderer, entry.view, entry.view.canvas.clientHeight > LARGE ? "large" : "small");
        entry.drawn = true;
      } else if (entry.rough !== null && now - entry.rough > STILL) {
        entry.rough = null;
        draw(renderer, entry.view, "fine");
      }
    }
  }

  return {
    get available() {
      begin();
      return renderer !== null;
    },
    /** Whether everything stands still now, small figures as well. */
    get resting() {
      return resting && software;
    },
    /**
     * Let everything stand still while an answer is awaited, or go on. A processor that draws figures
     * has no time to answer and to draw the answers; with a graphics processor nothing rests.
     */
    rest(next: boolean): void {
      resting = next;
      if (!next) for (const entry of entries.values()) entry.last = performance.now();
    },
    /** Start drawing a view; returns a function that stops it. */
    add(view: StageView): () => void {
      begin();
      colours ??= stageColours();
      view.recolour(colours);
      entries.set(view.canvas, {
        view,
        visible: false,
        stale: true,
        drawn: false,
        last: performance.now(),
        rough: null,
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

export type Stage = ReturnType<typeof makeStage>;
