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
  across("pelvis", 0.062, [0, -0.02, -0.004], 0.095),
  across("pelvis", 0.052, [0, 0.055, 0], 0.088, 0.06),
  across("belly", 0.043, [0, 0.14, 0.002], 0.084, 0.06),
  across("belly", 0.048, [0, 0.22, 0.002], 0.089, 0.06),
  across("chest", 0.055, [0, 0.3, 0], 0.094, 0.06),
  across("chest", 0.082, [0, 0.37, -0.01], 0.086, 0.06),
  cone("chest", [0.066, 0.352, 0.05], [0.1, 0.372, 0.03], [0.046, 0.04], 0.05), // breast
  cone("chest", [0.07, 0.39, -0.05], [0.085, 0.27, -0.035], [0.056, 0.05], 0.06), // shoulder blade
  cone("neck", [0, 0.46, -0.02], [0, 0.6, 0.0], [0.06, 0.054], 0.05),
  cone("chest", [0.02, 0.505, -0.03], [0.105, 0.452, -0.022], [0.042, 0.048], 0.07), // shoulder muscle
  cone("head", [0, 0.712, -0.008], [0, 0.71, -0.002], [0.088, 0.087], 0.03, [0.87, 1.03, 1.19]), // skull
  cone("head", [0, 0.66, 0.038], [0, 0.624, 0.052], [0.062, 0.049], 0.03, [0.95, 1, 1]), // face
  cone("head", [0.05, 0.648, 0.006], [0.022, 0.602, 0.06], [0.021, 0.017], 0.05), // jaw
  cone("head", [0, 0.601, 0.074], [0, 0.605, 0.077], [0.018, 0.018], 0.03), // chin
  cone("head", [0.046, 0.67, 0.056], [0.036, 0.636, 0.062], [0.021, 0.02], 0.05), // cheek
  cone("head", [0.014, 0.714, 0.09], [0.044, 0.712, 0.072], [0.0115, 0.0115], 0.022), // brow
  cone("head", [0, 0.706, 0.095], [0, 0.666, 0.114], [0.0075, 0.0125], 0.02), // nose
  cone("head", [0, 0.633, 0.0965], [0.016, 0.633, 0.089], [0.0055, 0.004], 0.02), // lips
  cone("head", [0, 0.648, 0.088], [0.004, 0.648, 0.088], [0.012, 0.012], 0.03), // upper lip
  cone("head", [0.08, 0.664, -0.008], [0.084, 0.698, -0.018], [0.012, 0.021], 0.012, [0.5, 1, 1]), // ear
];
/** What is taken away: the hollows of the eyes. */
const EYE = cone("head", [0.036, 0.69, 0.118], [0.032, 0.69, 0.118], [0.0145, 0.0145], 0.024);

const LEG: readonly Cone[] = [
  cone("l_hip", [0.086, -0.055, -0.04], [0.088, -0.075, -0.03], [0.082, 0.08], 0.05), // buttock
  cone("l_thigh", [0.089, -0.06, 0.004], [0.09, -0.38, 0.002], [0.081, 0.054]),
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
  cone("l_collar", [0.03, 0.462, -0.018], [0.132, 0.447, -0.01], [0.05, 0.05], 0.06),
  cone("l_shoulder", [0.152, 0.424, 0], [0.172, 0.426, 0], [0.057, 0.056], 0.05),
  cone("l_upper", [0.18, 0.432, 0], [0.42, 0.44, 0], [0.052, 0.038]),
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

/** A cone as numbers that are needed for each place, and the ball around it, beyond which it does not matter. */
interface Solid {
  cone: Cone;
  x: number;
  y: number;
  z: number;
  reach: number;
}

function solid(cone: Cone): Solid {
  const { from, to, radii, stretch } = cone;
  const [x, y, z] = from.map((value, n) => (value + to[n]!) / 2) as [number, number, number];
  const half = Math.sqrt((to[0] - from[0]) ** 2 + (to[1] - from[1]) ** 2 + (to[2] - from[2]) ** 2) / 2;
  return { cone, x, y, z, reach: half + Math.max(...radii) * Math.max(...stretch) + cone.melt };
}

/** About how far a place is outside of a cone, metres; negative inside. */
export function outside({ from, to, radii, stretch }: Cone, x: number, y: number, z: number): number {
  // No lists: this is computed a million times.
  const sx = stretch[0];
  const sy = stretch[1];
  const sz = stretch[2];
  const ax = (to[0] - from[0]) / sx;
  const ay = (to[1] - from[1]) / sy;
  const az = (to[2] - from[2]) / sz;
  const px = (x - from[0]) / sx;
  const py = (y - from[1]) / sy;
  const pz = (z - from[2]) / sz;
  const along = (px * ax + py * ay + pz * az) / (ax * ax + ay * ay + az * az);
  const share = along < 0 ? 0 : along > 1 ? 1 : along;
  const dx = px - share * ax;
  const dy = py - share * ay;
  const dz = pz - share * az;
  const apart = Math.sqrt(dx * dx + dy * dy + dz * dz);
  const inside = apart - radii[0] - share * (radii[1] - radii[0]);
  if (stretch === ROUND || apart < 1e-9) return inside;
  // In the direction of the place, so that what is stretched is not thought to be nearer than it is.
  return (inside * Math.sqrt(dx * sx * dx * sx + dy * sy * dy * sy + dz * sz * dz * sz)) / apart;
}

/** The smaller of two distances, rounded where they are alike. */
function melted(a: number, b: number, melt: number): number {
  const alike = melt - Math.abs(a - b);
  const less = a < b ? a : b;
  return alike > 0 ? less - (alike * alike) / (4 * melt) : less;
}

/** A distance, with one more cone. */
function joined(far: number, one: Solid, x: number, y: number, z: number): number {
  const dx = x - one.x;
  const dy = y - one.y;
  const dz = z - one.z;
  const bound = far + one.reach;
  if (dx * dx + dy * dy + dz * dz > bound * bound) return far;
  return melted(far, outside(one.cone, x, y, z), one.cone.melt);
}

const TRUNK = MIDDLE.map(solid);
const LEGS = LEG.map(solid);
const ARMS = ARM.map(solid);
/** How far legs and arms melt into the trunk, metres. */
const LIMB = 0.05;
/** What is farther than this from the surface is not told apart, metres. */
const FAR = 0.12;

/** About how far a place is outside of the mannequin, metres; negative inside. */
export function distance(x: number, y: number, z: number): number {
  const side = Math.abs(x);
  let far = FAR;
  for (let n = 0; n < TRUNK.length; n += 1) {
    const one = TRUNK[n]!;
    far = joined(far, one, side, y, z);
    if (one.x > 0) far = joined(far, one, -side, y, z);
  }
  if (y > 0.6 && z > 0) far = -melted(-far, outside(EYE, side, y, z), EYE.melt);
  if (y < 0.15 || y > 0.2) {
    const cones = y < 0.15 ? LEGS : ARMS;
    let limb = FAR;
    for (let n = 0; n < cones.length; n += 1) limb = joined(limb, cones[n]!, side, y, z);
    far = melted(far, limb, LIMB);
  }
  return y < -0.8 ? -melted(-far, y - SOLE.height, SOLE.melt) : far;
}
