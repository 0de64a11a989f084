/** Advice of the server for the command line, as advice for somebody who looks at this page. */

/** Clauses that only the command line can follow, or that the page says otherwise. */
const CLAUSES: readonly [RegExp, string][] = [
  [/,? or pass --anyway to make the (?:rest|nearest)/g, ", or add it to a motion by hand"],
  [/,? or [^.,;]*--[^.;]*(?=[.;]|$)/g, ""],
  [/ \(`motiondb words` lists them\)/g, ""],
  [/^capture: expected an existing one, found ('[^']*')\./, "There is no capture $1 in this database."],
  [/^query: expected a word that is in the captions, found ([^.]+)\./, "No caption has the word $1."],
  [
    /^filter ('[^']*'): expected NAME OPERATOR VALUE with one of ([^,]*), found '[^']*'\./,
    "$1 is no condition: one has a name, one of $2, and a value.",
  ],
  [
    /^filter on ('[^']*'): expected one of .*, found no such column or tag\./,
    "No column and no tag is called $1. Columns are capture, length, performer, words, licence, format and fps.",
  ],
  [/ \(motiondb words set[^)]*\)/g, " in the catalogue"],
  [/ \(--[a-z-]+(?: [^)]*)?\)/g, ""],
  [/with --fps\b/g, "in a column fps of the sheet of words"],
  [/\bGive --fps\b/g, "Give it in a column fps of the sheet of words"],
];

/** What a sentence with a command becomes, if another stands before it; the first that fits. */
const SENTENCES: readonly [RegExp, string][] = [
  [/motiondb grammar learn/, "Learn one under Grammars."],
  [/motiondb grammar (?:generate|show|edit)/, "Its page under Grammars shows what there is."],
  [/motiondb scene make/, "Make one on the board."],
  [/motiondb learn/, "Choose Learn… in the catalogue."],
  [/motiondb add/, "Choose Add captures in the catalogue."],
  [/motiondb list/, "The catalogue shows the names."],
  [/motiondb words` lists/, ""],
  [/motiondb words/, "Write words to captures in the catalogue."],
  [/motiondb (?:info|undo)/, ""],
];

/** A message of the server with what can be done on this page. */
export function onPage(message: string): string {
  const clauses = CLAUSES.reduce((text, [pattern, by]) => text.replace(pattern, by), message);
  return clauses
    .split(/(?<=[.!?]) (?=[A-Zm'"`])/)
    .map((sentence, i) => {
      const known = i > 0 && SENTENCES.find(([pattern]) => pattern.test(sentence));
      return known ? known[1] : sentence;
    })
    .filter((sentence, i, all) => sentence !== "" && all.indexOf(sentence) === i)
    .join(" ");
}
