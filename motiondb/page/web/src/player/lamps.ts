/** Where light comes from, and how bright it is; the same for every way of drawing. */

type Direction = readonly [x: number, y: number, z: number];

function towards(x: number, y: number, z: number): Direction {
  const length = Math.hypot(x, y, z);
  return [x / length, y / length, z / length];
}

/** Towards the lamp, and towards the light from behind. */
export const TO_LAMP = towards(0.45, 1, 0.4);
export const TO_BACK = towards(-0.6, 0.5, -0.8);
/** Light of a surface that faces the sky, the ground, the lamp, and what is behind. By eye. */
export const BRIGHT = { sky: 0.66, ground: 0.4, lamp: 0.5, back: 0.16 };
