import assert from "node:assert/strict";
import test from "node:test";
import { advance, changeSpeed, seek, startPlayback, step, toggle } from "../src/player/playback.ts";

const playing = { ...startPlayback(10, 2, 4), playing: true };

test("time runs on by the seconds that passed, times the speed", () => {
  assert.equal(advance({ ...playing, speed: 0.5 }, 1).time, 2.5);
});

test("a paused playback does not move", () => {
  assert.equal(advance({ ...playing, playing: false }, 1).time, 2);
});

test("a loop begins again at the start of the part, by what was left over", () => {
  const after = advance({ ...playing, time: 3.5 }, 1);
  assert.ok(Math.abs(after.time - 2.5) < 1e-9);
  assert.equal(after.playing, true);
});

test("without a loop it stops at the end, and playing begins at the start", () => {
  const ended = advance({ ...playing, loop: false }, 5);
  assert.deepEqual([ended.time, ended.playing], [4, false]);
  assert.equal(toggle(ended).time, 2);
});

test("seeking stays inside the take, but may leave the part", () => {
  assert.equal(seek(playing, 99).time, 10);
  assert.equal(seek(playing, -1).time, 0);
  assert.equal(seek(playing, 7).time, 7);
});

test("a step is one frame, and pauses", () => {
  const next = step({ ...playing, time: 1 }, 1, 30);
  assert.ok(Math.abs(next.time - 31 / 30) < 1e-9);
  assert.equal(next.playing, false);
  assert.equal(step({ ...playing, time: 0 }, -1, 30).time, 0);
  assert.ok(Math.abs(step({ ...playing, time: 10 }, 5, 30).time - 299 / 30) < 1e-9);
});

test("speeds go up and down a list and stop at its ends", () => {
  assert.equal(changeSpeed(playing, 1).speed, 1.5);
  assert.equal(changeSpeed(playing, -1).speed, 0.5);
  assert.equal(changeSpeed({ ...playing, speed: 4 }, 1).speed, 4);
  assert.equal(changeSpeed({ ...playing, speed: 0.1 }, -1).speed, 0.1);
});
