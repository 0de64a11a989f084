/** Why a drawing cannot be played, said to somebody who draws: not by lines of its text. */

const RULES: readonly [RegExp, string][] = [
  [/^'[^']*': /, ""], // the element stands beside its reason
  [/ \(line \d+\)|, line \d+(?=\))/g, ""],
  [
    /^expected at least one player, found none\..*$/,
    "Nobody is on the board. Choose a player above, then click on the ground.",
  ],
  [
    /^expected of (\S+) what the grammar (\S+) allows, found .* but (\S+) cannot come at all\..*$/,
    "The grammar $2 has no $3 for $1. Leave it out.",
  ],
  [
    /^expected of (\S+) what the grammar (\S+) allows, found .*$/,
    "The grammar $2 does not allow these actions of $1 in this order. Leave one out, or change the order.",
  ],
  [
    /^expected (\S+) to have the ball, found \S+ without the ball( since '[^']*')?\./,
    "$1 does not have the ball$2.",
  ],
  [/^expected (\S+) without the ball, found \S+ with it\./, "$1 has the ball."],
  [
    /^expected one player with the ball at the beginning, found (\d+): /,
    "Only one player can have the ball at the beginning, here $1 need it: ",
  ],
  [
    /^expected a place at least (\S+ m) from (\S+), found (\S+ m)\./,
    "It is $3 from $2; at least $1 is needed.",
  ],
  [/^expected (.+?), found (.+?)\./, "Needed: $1. Here: $2."],
];

/** A reason of the server as a sentence for the board. */
export const sayReason = (message: string): string =>
  RULES.reduce((text, [pattern, by]) => text.replace(pattern, by), message);
