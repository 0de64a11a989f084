import assert from "node:assert/strict";
import test from "node:test";
import { seenAt } from "../src/player/motion.ts";

test("a box is seen from half a second before its time to half a second after", () => {
  const at = (time: number): boolean => seenAt([{ start: 2, end: 4 }], time)[0]!;
  assert.deepEqual([1.4, 1.6, 3, 4.4, 4.6].map(at), [false, true, true, true, false]);
});
