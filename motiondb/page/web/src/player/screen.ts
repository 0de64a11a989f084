/**
 * A screen on which motions play: figures on the ground, a camera and a playback.
 *
 * The buttons around it are made by `player.ts`; small screens in lists have none.
 */

import * as THREE from "three";
import type { BallTrack, BodyTrack, Track } from "../api/container.ts";
import { eyeOf, FIELD_OF_VIEW, orbitAround, turn, type Orbit } from "./camera.ts";
import { BODY_FINENESS, makeCapsules, MARK_FINENESS, type Capsules } from "./capsules.ts";
import type { StageColours } from "./colours.ts";
import { ballsOf, makeFigures, type Colour, type Figures } from "./figures.ts";
import { paintFlat } from "./flat.ts";
import { makeGround } from "./ground.ts";
import { makeLight } from "./light.ts";
import { fits } from "./mannequin/bones.ts";
import { makePeople, type People } from "./mannequin/people.ts";
import { boundsOf, unite, type Box } from "./motion.ts";
import { advance, startPlayback, type Playback } from "./playback.ts";
import type { Stage } from "./stage.ts";

export interface Shown {
  tracks: readonly Track[];
  /** The part of the take that is played; the whole if absent. */
  from?: number;
  to?: number;
  /** The part of the take during which figures have the highlight colour. */
  lit?: readonly [number, number] | null;
  /** One colour for each body, instead of the figure's colour. */
  colours?: readonly Colour[];
  /** Where each body is moved to on the ground. */
  shifts?: readonly (readonly [number, number])[];
}

export interface Switches {
  follow: boolean;
  grid: boolean;
  trails: boolean;
  contacts: boolean;
  turntable: boolean;
}

export interface Screen {
  readonly canvas: HTMLCanvasElement;
  /** Objects that other views add to the scene: a court, paths. */
  readonly extras: THREE.Group;
  show(shown: Shown): void;
  readonly playback: Playback;
  setPlayback(playback: Playback): void;
  readonly switches: Switches;
  setSwitches(switches: Partial<Switches>): void;
  readonly orbit: Orbit;
  setOrbit(orbit: Orbit): void;
  /** Move the camera to where it shows everything that is played. */
  frameAll(azimuth?: number, elevation?: number): void;
  /** Move the camera near the figures as they stand now, and follow them. */
  frameNow(): void;
  /** Call a function with the time whenever a frame is drawn at a new time, or playback was set anew. */
  onTime(listener: (time: number) => void): void;
  /** Call a function whenever a picture was drawn, with a new time or seen from elsewhere. */
  onDraw(listener: () => void): void;
  redraw(): void;
  close(): void;
}

/** The turntable's speed, radians a second: once around in 12 s. Chosen by eye. */
const TURNTABLE = Math.PI / 6;

const rgb = (colour: THREE.Color): Colour => [colour.r, colour.g, colour.b];

/** The times that all tracks cover. */
export function spanOf(tracks: readonly Track[]): [start: number, end: number] {
  let [start, end] = [Infinity, 0];
  for (const { motion } of tracks) {
    start = Math.min(start, motion.start);
    end = Math.max(end, motion.start + motion.frames / motion.fps);
  }
  return Number.isFinite(start) ? [start, end] : [0, 0];
}

/** Make a screen on a canvas. */
export function makeScreen(stage: Stage, canvas: HTMLCanvasElement): Screen {
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.05, 300);
  const ground = makeGround();
  const light = makeLight();
  const extras = new THREE.Group();
  scene.add(ground.object, light.object, extras);
  const listeners: ((time: number) => void)[] = [];
  const drawListeners: (() => void)[] = [];

  let shown: Shown = { tracks: [] };
  let colours: StageColours | null = null;
  let figures: Figures | null = null;
  let people: People | null = null;
  let bodyCapsules: Capsules | null = null;
  let markCapsules: Capsules | null = null;
  let printCapsules: Capsules | null = null;
  let playback = startPlayback(0);
  let orbit = orbitAround([-0.5, 0, -0.5], [0.5, 1.75, 0.5]);
  let switches: Switches = { follow: false, grid: true, trails: false, contacts: false, turntable: false };
  let changed = true;
  let toldTime = NaN;
  let followed: readonly [number, number] | null = null;

  function build(): void {
    if (!colours) return;
    const bodies = shown.tracks.filter((track): track is BodyTrack => track.kind === "body");
    const balls = shown.tracks.filter((track): track is BallTrack => track.kind === "ball");
    const plain = rgb(colours.figure);
    const lit = rgb(colours.figureLit);
    figures = makeFigures(
      bodies.map((track, i) => ({
        motion: track.motion,
        colour: shown.colours?.[i] ?? plain,
        litColour: shown.colours?.[i] ?? lit,
        lit: shown.lit === undefined ? null : shown.lit,
        shift: shown.shifts?.[i] ?? [0, 0],
      })),
      balls.map((track) => track.motion),
      rgb(colours.contact),
      rgb(colours.contact),
      (points) => stage.available && fits(points),
    );
    clear();
    const { people: drawn, bodies: others, marks, prints } = figures.draw(playback.time, switches);
    people = makePeople(drawn);
    bodyCapsules = makeCapsules(others.tints.length / 3, BODY_FINENESS, "shaded");
    markCapsules = makeCapsules(marks.tints.length / 3, MARK_FINENESS, "plain");
    printCapsules = makeCapsules(prints.tints.length / 3, BODY_FINENESS, "print");
    scene.add(people.object, bodyCapsules.object, markCapsules.object, printCapsules.object);
    changed = true;
  }

  function clear(): void {
    for (const drawn of [people, bodyCapsules, markCapsules, printCapsules]) {
      if (!drawn) continue;
      scene.remove(drawn.object);
      drawn.dispose();
    }
  }

  function box(from: number, to: number): Box {
    const boxes = shown.tracks.flatMap((track, i) => {
      if (track.kind !== "body" || track.motion.frames === 0) return [];
      const one = boundsOf(track.motion, from, to);
      const [x, z] = shown.shifts?.[i] ?? [0, 0];
      one.min[0] += x;
      one.max[0] += x;
      one.min[2] += z;
      one.max[2] += z;
      return [one];
    });
    return unite(boxes);
  }

  function follow(): void {
    if (!figures) return;
    const [x, , z] = figures.centre;
    if (switches.follow && followed) {
      const [tx, ty, tz] = orbit.target;
      orbit = { ...orbit, target: [tx + x - followed[0], ty, tz + z - followed[1]] };
    }
    followed = [x, z];
  }

  function place(): void {
    const picture = figures?.draw(playback.time, switches);
    if (picture) {
      bodyCapsules?.show(picture.bodies);
      markCapsules?.show(picture.marks);
      printCapsules?.show(picture.prints);
    }
    follow();
    const [x, y, z] = eyeOf(orbit);
    camera.position.set(x, Math.max(y, 0.05), z);
    camera.lookAt(...orbit.target);
    ground.object.visible = switches.grid;
    ground.centre(orbit.target[0], orbit.target[2], Math.max(9, orbit.distance * 2.2));
  }

  const end = stage.add({
    canvas,
    scene,
    camera,
    prepare(detail) {
      drawListeners.forEach((listener) => listener()); // also where only the size has changed
      if (!figures) return;
      people?.show(figures.picture.people, detail);
      light.setFine(detail === "fine");
      light.around(ballsOf(figures.picture));
    },
    isEmpty: () => shown.tracks.length === 0,
    update(seconds) {
      const before = playback.time;
      if (switches.turntable) screen.setOrbit(turn(orbit, seconds * TURNTABLE, 0));
      playback = advance(playback, seconds);
      const moved = playback.time !== before || changed;
      changed = false;
      if (moved && figures) {
        place();
        if (!stage.available) {
          paintFlat(canvas, figures.draw(playback.time, switches), orbit);
          drawListeners.forEach((listener) => listener());
        }
      }
      if (playback.time !== toldTime) {
        toldTime = playback.time;
        listeners.forEach((listener) => listener(toldTime));
      }
      return moved;
    },
    recolour(fresh) {
      colours = fresh;
      scene.background = fresh.background;
      ground.setColours(fresh);
      light.setColours(fresh);
      build();
    },
  });

  const screen: Screen = {
    canvas,
    extras,
    show(next) {
      shown = next;
      const [start, finish] = spanOf(next.tracks);
      const from = Math.max(next.from ?? start, start);
      const to = Math.min(next.to ?? finish, finish);
      const { speed, playing, loop } = playback;
      playback = { ...startPlayback(finish, from, to), speed, playing, loop };
      followed = null;
      build();
    },
    get playback() {
      return playback;
    },
    setPlayback(next) {
      playback = next;
      changed = true;
      // Within one frame it may start, and end at the time that was told last.
      toldTime = NaN;
    },
    get switches() {
      return switches;
    },
    setSwitches(next) {
      switches = { ...switches, ...next };
      changed = true;
    },
    get orbit() {
      return orbit;
    },
    setOrbit(next) {
      orbit = next;
      changed = true;
    },
    frameAll(azimuth, elevation) {
      const { min, max } = box(playback.from, playback.to);
      const aspect = canvas.clientWidth / Math.max(canvas.clientHeight, 1) || 1.5;
      orbit = orbitAround(min, max, aspect, azimuth, elevation);
      changed = true;
    },
    frameNow() {
      const { min, max } = box(playback.time, playback.time);
      const aspect = canvas.clientWidth / Math.max(canvas.clientHeight, 1) || 1.5;
      // The figure may stand up or crouch: leave room for a standing person, whatever the first
      // pose is.
      orbit = orbitAround([min[0], 0, min[2]], [max[0], Math.max(max[1], 1.8), max[2]], aspect);
      switches = { ...switches, follow: true };
      followed = null;
      changed = true;
    },
    onTime: (listener) => void listeners.push(listener),
    onDraw: (listener) => void drawListeners.push(listener),
    redraw: () => void (changed = true),
    close() {
      end();
      clear();
      ground.dispose();
      light.dispose();
    },
  };
  return screen;
}
