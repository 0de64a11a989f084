/** Colours of several characters: one for each team, or one for each character without a team. */

import type { Track } from "../api/container.ts";
import { hueOf, rgbOf } from "../parts/tint.ts";
import type { Colour } from "./figures.ts";

/** Hues of the teams, degrees in OKLCH: those of the tactics board, orange and teal. Chosen by eye. */
const TEAM_HUES: Record<string, number> = { attack: 50, defence: 185 };

/** A colour for each body; undefined where there is only one, which has the figure's own colour. */
export function castColours(tracks: readonly Track[]): readonly Colour[] | undefined {
  const bodies = tracks.filter((track) => track.kind === "body");
  if (bodies.length < 2) return undefined;
  return bodies.map((track, i) => rgbOf(0.68, 0.1, TEAM_HUES[track.team ?? ""] ?? hueOf(i)));
}
