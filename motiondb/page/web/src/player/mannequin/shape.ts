/**
 * The shape of the mannequin: rounded cones that melt into each other, in the rest pose.
 *
 * The rest pose is that of the canonical body: arms held out, facing +z, left is +x, the pelvis at
 * the origin, metres. Only the left side is written down. The shape is where `distance` is below 0.
 * There is nothing but sums, products and roots in it, so that every browser computes the same.
 */

export type Spot = readonly [x: number, y: number, z: number];

/** A cone with round ends, which belongs to a bone. */
export interface Cone {
  bone: string;
  from: Spot;
  to: Spot;
  radii: readonly [from: number, to: number];
  /** How far it melts into the others, metres. */
  melt: number;
  /** Width, height and depth against those of a round one. */
  stretch: Spot;
}

const ROUND: Spot = [1, 1, 1];

function cone(
  bone: string,
  from: Spot,
  to: Spot,
  radii: readonly [number, number],
  melt = 0.03,
  stretch = ROUND,
): Cone {
  return { bone, from, to, radii, melt, stretch };
}

/** A cone that lies across the body, from one side to the other. */
function across(bone: string, half: number, [, y, z]: Spot, radius: number, melt = 0.05, s = ROUND): Cone {
  return cone(bone, [-half, y, z], [half, y, z], [radius, radius], melt, s);
}

/** Trunk, neck and head. What does not lie in the middle is there on both sides. */
const MIDDLE: readonly Cone[] = [
  across("pelvis", 0.066, [0, -0.02, -0.004], 0.096),
  across("pelvis", 0.052, [0, 0.055, 0], 0.088, 0.06),
  across("belly", 0.043, [0, 0.14, 0.002], 0.084, 0.06),
  across("belly", 0.048, [0, 0.22, 0.002], 0.089, 0.06),
  across("chest", 0.055, [0, 0.3, 0], 0.094, 0.06),
  across("chest", 0.082, [0, 0.37, -0.01], 0.086, 0.06),
  cone("chest", [0.066, 0.352, 0.05], [0.1, 0.372, 0.03], [0.046, 0.04], 0.05), // breast
  cone("chest", [0.07, 0.39, -0.05], [0.085, 0.27, -0.035], [0.056, 0.05], 0.06), // shoulder blade
  cone("neck", [0, 0.46, -0.018], [0, 0.61, 0.002], [0.057, 0.05], 0.05),
  cone("head", [0, 0.706, -0.03], [0, 0.706, 0.02], [0.086, 0.082], 0.03, [0.88, 1.06, 1]), // skull
  cone("head", [0, 0.665, 0.034], [0, 0.622, 0.052], [0.061, 0.04], 0.03, [0.95, 1, 1]), // face
  cone("head", [0.05, 0.655, 0.0], [0.02, 0.606, 0.062], [0.022, 0.018], 0.03), // jaw
  cone("head", [0, 0.603, 0.07], [0, 0.605, 0.074], [0.018, 0.018], 0.02), // chin
  cone("head", [0.04, 0.667, 0.066], [0.046, 0.672, 0.05], [0.023, 0.023], 0.02), // cheek
  cone("head", [0.014, 0.712, 0.084], [0.04, 0.714, 0.068], [0.014, 0.013], 0.018), // brow
  cone("head", [0, 0.7, 0.094], [0, 0.661, 0.115], [0.0075, 0.0115], 0.014), // nose
  cone("head", [0.009, 0.659, 0.1], [0.011, 0.66, 0.098], [0.0085, 0.0085], 0.01),
  cone("head", [0, 0.636, 0.094], [0.014, 0.635, 0.088], [0.0085, 0.007], 0.012), // lips
  cone("head", [0.076, 0.668, -0.004], [0.079, 0.698, -0.012], [0.012, 0.021], 0.012, [0.5, 1, 1]), // ear
];
/** What is taken away: the hollows of the eyes. */
const EYE = cone("head", [0.034, 0.691, 0.108], [0.03, 0.691, 0.108], [0.0145, 0.0145], 0.022);

const LEG: readonly Cone[] = [
  cone("l_hip", [0.086, -0.055, -0.04], [0.088, -0.075, -0.03], [0.082, 0.08], 0.05), // buttock
  cone("l_thigh", [0.09, -0.06, 0.004], [0.09, -0.38, 0.002], [0.084, 0.054]),
  cone("l_thigh", [0.097, -0.14, 0.022], [0.092, -0.33, 0.016], [0.062, 0.046]),
  cone("l_knee", [0.09, -0.425, 0.008], [0.09, -0.445, 0.008], [0.049, 0.047]),
  cone("l_shin", [0.09, -0.46, 0], [0.09, -0.81, -0.008], [0.046, 0.033]),
  cone("l_shin", [0.094, -0.51, -0.022], [0.091, -0.65, -0.018], [0.044, 0.035]), // calf
  cone("l_ankle", [0.09, -0.84, -0.008], [0.09, -0.862, -0.004], [0.036, 0.038], 0.02),
  cone("l_foot", [0.09, -0.885, -0.042], [0.09, -0.9, -0.045], [0.036, 0.034], 0.03), // heel
  cone("l_foot", [0.09, -0.87, 0.015], [0.09, -0.905, 0.12], [0.04, 0.029], 0.03, [1.05, 1, 1]),
  cone("l_foot", [0.068, -0.907, 0.125], [0.115, -0.91, 0.105], [0.026, 0.022], 0.02), // ball
  cone("l_toes", [0.073, -0.91, 0.15], [0.077, -0.914, 0.192], [0.022, 0.017], 0.02), // great toe
  cone("l_toes", [0.1, -0.912, 0.14], [0.1, -0.916, 0.172], [0.021, 0.016], 0.02),
];

const ARM: readonly Cone[] = [
  cone("l_collar", [0.03, 0.452, -0.016], [0.13, 0.437, -0.008], [0.044, 0.05], 0.05),
  cone("l_shoulder", [0.158, 0.428, 0], [0.172, 0.43, 0], [0.06, 0.058], 0.04),
  cone("l_upper", [0.18, 0.434, 0], [0.42, 0.44, 0], [0.053, 0.038]),
  cone("l_upper", [0.26, 0.44, 0.004], [0.35, 0.44, 0.004], [0.047, 0.041]),
  cone("l_elbow", [0.444, 0.44, -0.002], [0.456, 0.44, -0.002], [0.037, 0.037]),
  cone("l_fore", [0.47, 0.44, 0], [0.67, 0.44, 0], [0.038, 0.026]),
  cone("l_fore", [0.5, 0.44, 0.004], [0.57, 0.44, 0.002], [0.041, 0.034]),
  cone("l_wrist", [0.694, 0.44, 0], [0.706, 0.44, 0], [0.026, 0.026], 0.02, [1, 0.85, 1.05]),
  cone("l_hand", [0.735, 0.438, -0.004], [0.78, 0.434, -0.002], [0.03, 0.031], 0.02, [1, 0.62, 1.25]),
  cone("l_hand", [0.79, 0.432, 0], [0.832, 0.424, 0.002], [0.026, 0.023], 0.015, [1, 0.55, 1.4]), // fingers
  cone("l_hand", [0.832, 0.424, 0.002], [0.86, 0.411, 0.004], [0.022, 0.017], 0.012, [1, 0.55, 1.4]),
  cone("l_hand", [0.728, 0.43, 0.026], [0.764, 0.42, 0.052], [0.0165, 0.0145], 0.014), // thumb
  cone("l_hand", [0.764, 0.42, 0.052], [0.796, 0.41, 0.06], [0.014, 0.0105], 0.01),
];

/** Where the ground is, and how much the edge of the sole is rounded. */
const SOLE = { height: -0.93, melt: 0.012 };

/** Every cone, with the bones of the left side. */
export const CONES: readonly Cone[] = [...MIDDLE, ...LEG, ...ARM];

/** The ball around a cone, beyond which it does not matter. */
interface Solid extends Cone {
  middle: Spot;
  reach: number;
}

function solid(one: Cone): Solid {
  const { from, to, radii, stretch } = one;
  const middle: Spot = [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2, (from[2] + to[2]) / 2];
  const half = Math.sqrt((to[0] - from[0]) ** 2 + (to[1] - from[1]) ** 2 + (to[2] - from[2]) ** 2) / 2;
  return { ...one, middle, reach: half + Math.max(...radii) * Math.max(...stretch) };
}

/** About how far a place is outside of a cone, metres; negative inside. */
export function outside(one: Cone, x: number, y: number, z: number): number {
  const { from, to, radii, stretch } = one;
  const [sx, sy, sz] = [stretch[0], stretch[1], stretch[2]];
  const [ax, ay, az] = [(to[0] - from[0]) / sx, (to[1] - from[1]) / sy, (to[2] - from[2]) / sz];
  const [px, py, pz] = [(x - from[0]) / sx, (y - from[1]) / sy, (z - from[2]) / sz];
  const along = (px * ax + py * ay + pz * az) / (ax * ax + ay * ay + az * az);
  const share = along < 0 ? 0 : along > 1 ? 1 : along;
  const [dx, dy, dz] = [px - share * ax, py - share * ay, pz - share * az];
  const apart = Math.sqrt(dx * dx + dy * dy + dz * dz);
  const inside = apart - radii[0] - share * (radii[1] - radii[0]);
  if (stretch === ROUND || apart < 1e-9) return inside;
  // In the direction of the place, so that what is stretched is not thought to be nearer than it is.
  return (inside * Math.sqrt((dx * sx) ** 2 + (dy * sy) ** 2 + (dz * sz) ** 2)) / apart;
}

/** The smaller of two distances, rounded where they are alike. */
function melted(a: number, b: number, melt: number): number {
  const alike = melt - Math.abs(a - b);
  const less = a < b ? a : b;
  return alike > 0 ? less - (alike * alike) / (4 * melt) : less;
}

/** A distance, with one more cone. */
function joined(far: number, one: Solid, x: number, y: number, z: number): number {
  const { middle, reach, melt } = one;
  const [dx, dy, dz] = [x - middle[0], y - middle[1], z - middle[2]];
  const bound = far + melt + reach;
  if (dx * dx + dy * dy + dz * dz > bound * bound) return far;
  return melted(far, outside(one, x, y, z), melt);
}

const [TRUNK, LEGS, ARMS] = [MIDDLE.map(solid), LEG.map(solid), ARM.map(solid)];
/** How far legs and arms melt into the trunk, metres. */
const LIMB = 0.05;
/** What is farther than this from the surface is not told apart, metres. */
const FAR = 0.3;

/** About how far a place is outside of the mannequin, metres; negative inside. */
export function distance(x: number, y: number, z: number): number {
  const side = Math.abs(x);
  let far = FAR;
  for (const one of TRUNK) {
    far = joined(far, one, side, y, z);
    if (one.middle[0] > 0) far = joined(far, one, -side, y, z);
  }
  if (y > 0.6 && z > 0) far = -melted(-far, outside(EYE, side, y, z), EYE.melt);
  if (y < 0.15 || y > 0.2) {
    let limb = FAR;
    for (const one of y < 0.15 ? LEGS : ARMS) limb = joined(limb, one, side, y, z);
    far = melted(far, limb, LIMB);
  }
  return y < -0.8 ? -melted(-far, y - SOLE.height, SOLE.melt) : far;
}
