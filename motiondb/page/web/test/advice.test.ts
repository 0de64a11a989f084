/** Advice for the command line becomes advice for the page. */

import assert from "node:assert/strict";
import test from "node:test";

import { onPage } from "../src/api/advice.ts";

const SAID: readonly [string, string][] = [
  [
    "m.duckdb: expected a database that has learned, found none. Run motiondb learn --db m.duckdb first.",
    "m.duckdb: expected a database that has learned, found none. Choose Learn… in the catalogue.",
  ],
  [
    "generate: found 'x', which nothing in the database shows. Say it in other words (`motiondb words` lists them), or pass --anyway to make the rest.",
    "generate: found 'x', which nothing in the database shows. Say it in other words, or add it to a motion by hand.",
  ],
  [
    'generate: expected captures with words, found none. Write some down (motiondb words set CAPTURE "...") and learn again.',
    "generate: expected captures with words, found none. Write some down in the catalogue and learn again.",
  ],
  [
    "a.bvh: line 3: expected 57 numbers, found 3. The file may be cut short: export it again, or pass --skip-bad-frames to leave this frame out.",
    "a.bvh: line 3: expected 57 numbers, found 3. The file may be cut short: export it again.",
  ],
  [
    "a.amc: expected at most 24 hours, found 30. Give the right frame rate with --fps.",
    "a.amc: expected at most 24 hours, found 30. Give the right frame rate in a column fps of the sheet of words.",
  ],
  [
    "capture: expected a name, found 'x'. motiondb list shows the names.",
    "capture: expected a name, found 'x'. The catalogue shows the names.",
  ],
  [
    "query: expected a word that is in the captions, found 'x'. `motiondb words` lists the words that are known.",
    "No caption has the word 'x'.",
  ],
  [
    "filter on 'lenght': expected one of capture_id, name, found no such column or tag. Did you mean length?",
    "No column and no tag is called 'lenght'. Columns are capture, length, performer, words, licence, format and fps. Did you mean length?",
  ],
  [
    "capture: expected an existing one, found 'ana/x'. It may have been removed or renamed.",
    "There is no capture 'ana/x' in this database. It may have been removed or renamed.",
  ],
  [
    "filter 'duration>': expected NAME OPERATOR VALUE with one of = != >, found 'duration>'. Write for example: performer=14.",
    "'duration>' is no condition: one has a name, one of = != >, and a value. Write for example: performer=14.",
  ],
  ["Start motiondb serve without it.", "Start motiondb serve without it."],
];

test("advice for the command line becomes advice for the page", () => {
  for (const [told, said] of SAID) assert.equal(onPage(told), said);
});
