import assert from "node:assert/strict";
import test from "node:test";
import { fromBase64, readContainer } from "../src/api/container.ts";

/** A container with one body of two points over two frames, and a ball. */
function container(): ArrayBuffer {
  const header = {
    format: 1,
    points: ["pelvis", "head"],
    parents: [-1, 0],
    radii: [0, 0.1],
    tracks: [
      {
        name: "a",
        ref: "capture:a",
        kind: "body",
        team: null,
        frames: 2,
        fps: 30,
        start: 1.5,
        offset: 0,
        origin: [1, 2, 3],
        scale: [0.5, 0.1, 2],
        contacts: 24,
      },
      {
        name: "ball",
        kind: "ball",
        frames: 1,
        fps: 30,
        start: 0,
        offset: 28,
        origin: [0, 0, 0],
        scale: [1, 1, 1],
        contacts: null,
        radius: 0.12,
      },
    ],
  };
  let text = JSON.stringify(header);
  while ((8 + text.length) % 4 !== 0) text += " ";
  const buffer = new ArrayBuffer(8 + text.length + 36);
  new Uint8Array(buffer).set(new TextEncoder().encode("MDBM"));
  const view = new DataView(buffer);
  view.setUint32(4, text.length, true);
  new Uint8Array(buffer).set(new TextEncoder().encode(text), 8);
  const payload = 8 + text.length;
  [2, 10, -1, 4, 0, 0, 0, 0, 0, 0, 0, -32768].forEach((value, i) =>
    view.setInt16(payload + 2 * i, value, true),
  );
  new Uint8Array(buffer).set([1, 3], payload + 24);
  [7, 8, 9].forEach((value, i) => view.setInt16(payload + 28 + 2 * i, value, true));
  return buffer;
}

test("positions are origin + scale * value, by hand", () => {
  const [body] = readContainer(container());
  assert.equal(body?.kind, "body");
  if (body?.kind !== "body") return;
  assert.deepEqual([...body.motion.positions.slice(0, 6)], [2, 3, 1, 3, 2, 3]);
  assert.equal(body.motion.positions[11], 3 + 2 * -32768);
  assert.deepEqual([...body.motion.contacts!], [1, 3]);
  assert.equal(body.motion.start, 1.5);
  assert.equal(body.ref, "capture:a");
});

test("a ball has one place a frame and a radius", () => {
  const ball = readContainer(container())[1]!;
  assert.equal(ball.kind, "ball");
  assert.deepEqual([...ball.motion.positions], [7, 8, 9]);
});

test("other bytes and other formats are refused with a sentence", () => {
  assert.throws(() => readContainer(new ArrayBuffer(4)), /does not begin with MDBM/);
  assert.throws(
    () => readContainer(new TextEncoder().encode("not a motion").buffer),
    /does not begin with MDBM/,
  );
});

test("base64 gives back the bytes", () => {
  const bytes = Uint8Array.from({ length: 256 }, (_, i) => i);
  assert.deepEqual(new Uint8Array(fromBase64(Buffer.from(bytes).toString("base64"))), bytes);
});
