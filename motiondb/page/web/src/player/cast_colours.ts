/** Colours of several characters: one for each role, or one for each character without a role. */

import type { Track } from "../api/container.ts";
import { hueOf, rgbOf } from "../parts/tint.ts";
import type { Colour } from "./figures.ts";

/** Hues of the first two roles, degrees in OKLCH: those of the board, orange and teal. Chosen by eye. */
const HUES: readonly number[] = [50, 185];

/** The roles of some bodies, in their order; people without one have none. */
export function rolesOf(bodies: readonly { team?: string | null }[]): string[] {
  const named = bodies.map((track) => track.team ?? "").filter((team) => team && team !== "player");
  return [...new Set(named)];
}

/** A colour for each body; undefined where there is only one, which has the figure's own colour. */
export function castColours(tracks: readonly Track[]): readonly Colour[] | undefined {
  const bodies = tracks.filter((track) => track.kind === "body");
  if (bodies.length < 2) return undefined;
  const roles = rolesOf(bodies);
  return bodies.map((track, i) => rgbOf(0.68, 0.1, HUES[roles.indexOf(track.team ?? "")] ?? hueOf(i)));
}
