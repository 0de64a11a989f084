/** The figures of a stage: every body, ball, trail and mark becomes capsules of one array. */

import type { BallMotion, Motion } from "./motion.ts";
import { frameAt, poseAt } from "./motion.ts";
import { bonesOf, CAPSULE, sharesOf, writeCapsules, type Bone } from "./body.ts";

export type Colour = readonly [red: number, green: number, blue: number];

export interface Figure {
  motion: Motion;
  colour: Colour;
  /** The colour during `lit`. */
  litColour: Colour;
  /** Seconds of the take that are lit; null: none. */
  lit: readonly [start: number, end: number] | null;
  /** Where the figure is moved to, metres on the ground. */
  shift: readonly [x: number, z: number];
}

interface Prepared extends Figure {
  bones: readonly Bone[];
  shares: readonly number[];
  pose: Float32Array;
  person: Person | null;
  trailed: readonly number[];
}

export interface Drawn {
  capsules: Float32Array;
  tints: Float32Array;
  count: number;
}

const TRAIL_SECONDS = 1.4;
const TRAIL_STEPS = 28;
const TRAIL_RADIUS = 0.011;
const TRAILED = ["pelvis", "l_hand_end", "r_hand_end", "l_toe", "r_toe"];
/** The two ends of each foot's print, in the order of the bits of `contacts`. */
const FEET = [
  ["l_ankle", "l_toe_end"],
  ["r_ankle", "r_toe_end"],
] as const;
/** Half the width of a print, metres: a rim around the foot is seen. */
const PRINT_RADIUS = 0.07;

/** A body that is drawn as a mannequin: its points and where they are, (points, 3). */
export interface Person {
  points: readonly string[];
  /** Radius around each point, metres. */
  radii: readonly number[];
  pose: Float32Array;
  colour: Colour;
}

/** What is drawn at one time: bodies and balls with shadows; trails; prints, flat on the ground. */
export interface Picture {
  /** Bodies that are mannequins; the others are capsules. */
  people: readonly Person[];
  bodies: Drawn;
  marks: Drawn;
  prints: Drawn;
}

/** Empty arrays with room for a number of capsules. */
function roomFor(count: number): Drawn {
  return { capsules: new Float32Array(count * CAPSULE), tints: new Float32Array(count * 3), count: 0 };
}

/** Prepare bodies and balls for drawing; `isPerson`: whether a body of some points is a mannequin. */
export function makeFigures(
  figures: readonly Figure[],
  balls: readonly BallMotion[],
  markColour: Colour,
  ballColour: Colour,
  isPerson: (points: readonly string[]) => boolean = () => false,
) {
  const prepared = figures
    .filter((figure) => figure.motion.frames > 0)
    .map((figure) => prepare(figure, isPerson(figure.motion.points)));
  const bodies = prepared.reduce((sum, figure) => sum + figure.bones.length, 0);
  const picture: Picture = {
    people: prepared.flatMap(({ person }) => person ?? []),
    bodies: roomFor(bodies + balls.length),
    marks: roomFor(prepared.length * TRAILED.length * TRAIL_STEPS),
    prints: roomFor(prepared.length * FEET.length),
  };
  const centre: [number, number, number] = [0, 0.9, 0];
  return {
    /** Middle of the bodies at the last drawn time; the camera follows it. */
    centre,
    /** What was drawn last. */
    picture,
    draw(time: number, show: { trails: boolean; contacts: boolean }): Picture {
      picture.bodies.count = 0;
      picture.marks.count = 0;
      picture.prints.count = 0;
      centre.fill(0);
      for (const figure of prepared) {
        drawBody(picture.bodies, figure, time);
        for (let axis = 0; axis < 3; axis += 1) centre[axis]! += figure.pose[axis]! / prepared.length;
        if (show.contacts) drawContacts(picture.prints, figure, time, markColour);
        if (show.trails) drawTrails(picture.marks, figure, time);
      }
      for (const ball of balls) drawBall(picture.bodies, ball, time, ballColour);
      return picture;
    },
  };
}

export type Figures = ReturnType<typeof makeFigures>;

function prepare(figure: Figure, isPerson: boolean): Prepared {
  const { points, parents, radii } = figure.motion;
  const bones = isPerson ? [] : bonesOf(points, parents, radii);
  const pose = new Float32Array(points.length * 3);
  const named = TRAILED.map((name) => points.indexOf(name)).filter((point) => point >= 0);
  return {
    ...figure,
    bones,
    shares: sharesOf(points, bones),
    pose,
    person: isPerson ? { points, radii, pose, colour: figure.colour } : null,
    trailed: named.length > 0 ? named : [0],
  };
}

function shifted(figure: Prepared, time: number): Float32Array {
  poseAt(figure.motion, time, figure.pose);
  const [x, z] = figure.shift;
  if (x !== 0 || z !== 0) {
    for (let i = 0; i < figure.pose.length; i += 3) {
      figure.pose[i]! += x;
      figure.pose[i + 2]! += z;
    }
  }
  return figure.pose;
}

function paintTints(drawn: Drawn, first: number, count: number, colour: Colour): void {
  for (let i = first; i < first + count; i += 1) drawn.tints.set(colour, i * 3);
}

function drawBody(drawn: Drawn, figure: Prepared, time: number): void {
  const pose = shifted(figure, time);
  const count = writeCapsules(figure.bones, figure.shares, pose, drawn.capsules, drawn.count);
  const lit = figure.lit !== null && time >= figure.lit[0] && time < figure.lit[1];
  const colour = lit ? figure.litColour : figure.colour;
  if (figure.person) figure.person.colour = colour;
  paintTints(drawn, drawn.count, count, colour);
  drawn.count += count;
}

function put(drawn: Drawn, numbers: readonly number[], colour: Colour): void {
  drawn.capsules.set(numbers, drawn.count * CAPSULE);
  drawn.tints.set(colour, drawn.count * 3);
  drawn.count += 1;
}

/** A print under each foot that stands on the ground, as long as the foot. */
function drawContacts(drawn: Drawn, figure: Prepared, time: number, colour: Colour): void {
  const { contacts, points } = figure.motion;
  if (!contacts) return;
  const frame = frameAt(figure.motion, time);
  FEET.forEach((ends, bit) => {
    const [heel, toe] = ends.map((name) => points.indexOf(name));
    if (heel! < 0 || toe! < 0 || !(contacts[frame]! & (1 << bit))) return;
    const end = (point: number): number[] => [
      figure.pose[3 * point]!,
      0,
      figure.pose[3 * point + 2]!,
      PRINT_RADIUS,
    ];
    put(drawn, [...end(heel!), ...end(toe!)], colour);
  });
}

function drawTrails(drawn: Drawn, figure: Prepared, time: number): void {
  const { motion, trailed, shift } = figure;
  const size = motion.points.length * 3;
  for (const point of trailed) {
    let before: readonly number[] | null = null;
    for (let step = 0; step <= TRAIL_STEPS; step += 1) {
      const at = time - TRAIL_SECONDS * (1 - step / TRAIL_STEPS);
      if (at < motion.start) continue;
      const frame = Math.min(Math.round((at - motion.start) * motion.fps), motion.frames - 1);
      const p = frame * size + point * 3;
      const { positions } = motion;
      const now = [positions[p]! + shift[0], positions[p + 1]!, positions[p + 2]! + shift[1]];
      if (before) {
        const thin = TRAIL_RADIUS * (step / TRAIL_STEPS);
        put(drawn, [...before, thin, ...now, thin], figure.litColour);
      }
      before = now;
    }
  }
}

function drawBall(drawn: Drawn, ball: BallMotion, time: number, colour: Colour): void {
  const place = new Float32Array(3);
  poseAt(ball, time, place);
  const [x, y, z] = [place[0]!, place[1]!, place[2]!];
  put(drawn, [x, y, z, ball.radius, x, y + 0.001, z, ball.radius], colour);
}

/** The balls that bodies consist of: around the points of people, and at the ends of capsules. */
export function ballsOf({ people, bodies }: Picture): [x: number, y: number, z: number, radius: number][] {
  const balls: [number, number, number, number][] = [];
  for (const { pose, radii } of people) {
    radii.forEach((radius, i) => {
      if (radius > 0) balls.push([pose[3 * i]!, pose[3 * i + 1]!, pose[3 * i + 2]!, radius]);
    });
  }
  for (let i = 0; i < bodies.count; i += 1) {
    const [x, y, z, radius] = bodies.capsules.subarray(i * CAPSULE, i * CAPSULE + 4);
    balls.push([x!, y!, z!, radius!]);
  }
  return balls;
}
