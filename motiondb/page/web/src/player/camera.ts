/** A camera that turns around a target. Angles in radians, distances in metres. */

export interface Orbit {
  readonly target: readonly [number, number, number];
  /** Around the vertical axis; at 0 the camera stands at +z and sees the front of a figure. */
  readonly azimuth: number;
  /** Above the horizon. */
  readonly elevation: number;
  readonly distance: number;
}

export const FIELD_OF_VIEW = 34;
const LOWEST = -0.05;
const HIGHEST = Math.PI / 2 - 0.01;
const NEAREST = 0.6;
const FARTHEST = 80;
const HAND = 0.2;

function between(value: number, low: number, high: number): number {
  return Math.min(Math.max(value, low), high);
}

/** An orbit that shows a box, seen from somewhat above and from the side. */
export function orbitAround(
  min: readonly number[],
  max: readonly number[],
  aspect = 1.5,
  azimuth = 0.6,
  elevation = 0.22,
): Orbit {
  const target = [0, 1, 2].map((axis) => (min[axis]! + max[axis]!) / 2) as [number, number, number];
  target[1] += HAND / 4; // A box is of joints: hands reach above a wrist, but not below the ground
  const wide = Math.hypot(max[0]! - min[0]!, max[2]! - min[2]!) + 0.5;
  const high = max[1]! - min[1]! + 0.3 + HAND / 2;
  const half = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
  const distance = Math.max(high / (2 * half), wide / (2 * half * Math.max(aspect, 0.2)));
  // What stands nearer than the target looks larger; the depth of one figure does not matter.
  const [dx, dz] = [max[0]! - min[0]!, max[2]! - min[2]!];
  const deep = Math.abs(dx * Math.sin(azimuth)) + Math.abs(dz * Math.cos(azimuth));
  const nearer = Math.max(deep - 1, 0) / 2;
  return { target, azimuth, elevation, distance: between(distance + nearer, 1.6, FARTHEST) };
}

/** Where the camera stands. */
export function eyeOf(orbit: Orbit): [number, number, number] {
  const flat = Math.cos(orbit.elevation) * orbit.distance;
  return [
    orbit.target[0] + Math.sin(orbit.azimuth) * flat,
    orbit.target[1] + Math.sin(orbit.elevation) * orbit.distance,
    orbit.target[2] + Math.cos(orbit.azimuth) * flat,
  ];
}

/** The camera turned by angles. */
export function turn(orbit: Orbit, azimuth: number, elevation: number): Orbit {
  return {
    ...orbit,
    azimuth: orbit.azimuth + azimuth,
    elevation: between(orbit.elevation + elevation, LOWEST, HIGHEST),
  };
}

/** The camera nearer (factor below 1) or farther. */
export function zoom(orbit: Orbit, factor: number): Orbit {
  return { ...orbit, distance: between(orbit.distance * factor, NEAREST, FARTHEST) };
}

/** The camera and its target moved in the plane of the picture; shares of the picture's height. */
export function pan(orbit: Orbit, right: number, up: number): Orbit {
  const height = 2 * orbit.distance * Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
  const [x, y, z] = orbit.target;
  return {
    ...orbit,
    target: [
      x + Math.cos(orbit.azimuth) * right * height,
      Math.max(y + up * height, 0),
      z - Math.sin(orbit.azimuth) * right * height,
    ],
  };
}
