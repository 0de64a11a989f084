import assert from "node:assert/strict";
import { test } from "node:test";
import { isAbort } from "../src/api/client.ts";
import { makeLatest } from "../src/api/latest.ts";
import { makeState } from "../src/dom/state.ts";

test("the last question counts, whichever answer comes first", async () => {
  const latest = makeLatest();
  let answer: (text: string) => void = () => undefined;
  const first = latest(new Promise<string>((resolve) => (answer = resolve)));
  const second = latest(Promise.resolve("second"));
  answer("first");
  await assert.rejects(first, isAbort);
  assert.equal(await second, "second");
  await assert.rejects(latest(Promise.reject(new Error("gone"))), /gone/);
  const third = latest(Promise.resolve("third"));
  void latest(); // the view is closed
  await assert.rejects(third, isAbort);
});

test("a state is drawn once after all its changes, and not where nothing changed", async () => {
  const drawn: string[] = [];
  const state = makeState({ name: "a", count: 1 }, () => drawn.push(`${state.name} ${state.count}`));
  state.name = "b";
  state.count = 2;
  assert.deepEqual(drawn, []);
  await Promise.resolve();
  assert.deepEqual(drawn, ["b 2"]);
  state.count = 2;
  await Promise.resolve();
  assert.equal(drawn.length, 1);
});
