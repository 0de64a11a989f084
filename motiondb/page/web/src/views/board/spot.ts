/** Types of the board that the server does not have. */

import type { PlayerShape } from "../../api/types.ts";

/** A place: [x, z] in metres. */
export type Spot = [x: number, z: number];
export type Team = PlayerShape["team"];
