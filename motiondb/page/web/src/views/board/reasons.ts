/** Why a drawing cannot be played, said to somebody who draws: not by lines of its text. */

import type { BoardFault } from "../../api/types.ts";

type Fields = Record<string, string>;

/** Sentences by the kind of fault; what to do follows them. */
const SAID: Record<string, (about: Fields) => string> = {
  empty_handed: ({ player, thing, since }) =>
    `${player} does not have the ${thing}${since ? ` since '${since}'` : ""}.`,
  hands_full: ({ player, thing }) => `${player} has the ${thing}.`,
  two_holders: ({ thing, count, who }) =>
    `Only one player can have the ${thing} at the beginning, here ${count} need it: ${who}.`,
  too_near: ({ apart, other, least }) => `It is ${apart} from ${other}; at least ${least} is needed.`,
};

/** Sentences that say all, with what to do. */
const WHOLE: Record<string, (about: Fields) => string> = {
  nobody: () => "Nobody is on the board. Choose a player above, then click on the ground.",
  not_allowed: ({ player, grammar, missing }) =>
    missing
      ? `The grammar ${grammar} has no ${missing} for ${player}. Leave it out.`
      : `The grammar ${grammar} does not allow these actions of ${player} in this order. Leave one out, or change the order.`,
};

/** A fault of the server as a sentence for the board. */
export function sayFault({ code, fields, message }: BoardFault): string {
  const { expected, found, advice } = fields;
  const whole = WHOLE[code];
  if (whole) return whole(fields);
  if (expected === undefined) return message;
  return `${SAID[code]?.(fields) ?? `Needed: ${expected}. Here: ${found}.`} ${advice}`;
}
