/** Types of the view of grammars that the server does not have. */

import type { AlternativesReply } from "../../api/types.ts";

/** A place on the ground: [x, z] in metres. */
export type Spot = readonly [x: number, z: number];

/** Another derivation of a region: a whole sequence, or why it cannot be played. */
export type Alternative = AlternativesReply["alternatives"][number];

/** A terminal, the levels by which its region is wider, and which draw of alternatives is shown. */
export interface Selection {
  at: number;
  wider: number;
  draw: number;
}

/** What a sequence is made from. */
export interface Wish {
  seed: number;
  length: number | null;
  like: string | null;
}
