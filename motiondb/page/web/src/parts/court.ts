/** The marks of a ground, for the board from above and for the player. */

import type { GroundShape } from "../api/types.ts";

type Spot = [x: number, z: number];

/** The marks as lines of places [x, z]; those above the ground are seen from above. */
export function groundLines({ own, marks }: GroundShape): Spot[][] {
  return own ? [] : marks.map((mark) => mark.map(([x, , z]): Spot => [x!, z!]));
}
