/** What the grammar of the board lets one draw: its verbs, roles and object. */

import type { BoardVerb, Ground, GroundShape } from "../../api/types.ts";

const FIELD: GroundShape = { width: 20, length: 20, left: -10, back: -10, own: false, marks: [] };
const NOTHING: Ground = { grammar: "", verbs: [], teams: ["player"], places: [], object: "", ground: FIELD };
let present: Ground = NOTHING;

/** Take the verbs of a grammar for all that is drawn from now on. */
export function useGround(ground: Ground | null): void {
  present = ground ?? NOTHING;
}

export const groundNow = (): Ground => present;
export const verbOf = (kind: string): BoardVerb | undefined => present.verbs.find((one) => one.name === kind);

/** Whether an action ends at a place of the ground. */
export const endsAtPlace = (kind: string): boolean => verbOf(kind)?.goes ?? false;
/** Whether an action needs another player. */
export const needsOther = (kind: string): boolean => {
  const verb = verbOf(kind);
  return !!verb?.link && verb.role !== "target" && !present.places.includes(verb.role);
};
/** How an action is drawn: way, wave, give, send, link or act. */
export const lookOf = (kind: string, holds = false): string => {
  const verb = verbOf(kind);
  return (holds ? verb?.holding : verb?.look) ?? "act";
};
export const linkOf = (kind: string): string => verbOf(kind)?.link || "on";

/** The style of a role: those of the first two differ, all others are alike. */
export const styleOf = (team: string): "first" | "second" | "other" => {
  const at = team === "player" ? -1 : present.teams.indexOf(team);
  return at === 0 ? "first" : at === 1 ? "second" : "other";
};
