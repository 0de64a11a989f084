import assert from "node:assert/strict";
import test from "node:test";
import { rowsInSight } from "../src/parts/virtual.ts";
import { sharedReason } from "../src/parts/text.ts";
import { sortFiles } from "../src/parts/upload.ts";
import { parseRoute, routeTo } from "../src/shell/router.ts";
import { withWholeWords } from "../src/views/catalogue/editing.ts";
import { makeRangePick } from "../src/views/catalogue/picking.ts";
import { makeRows } from "../src/views/catalogue/rows.ts";
import { combine, filterOf, readPicks, togglePick, writePick } from "../src/views/catalogue/filter.ts";

const ana = { column: "performer", where: "performer=ana" };
const boris = { column: "performer", where: "performer=boris" };
const bvh = { column: "format", where: "format=bvh" };

test("values of one column are alternatives, columns are conditions", () => {
  assert.equal(combine("", [ana, bvh, boris]), "(performer=ana or performer=boris) and format=bvh");
  assert.equal(combine("duration>3 or fps=60", [ana]), "(duration>3 or fps=60) and performer=ana");
  assert.equal(combine(" ", []), "");
});

test("plain words are looked for in captions and names", () => {
  const has = (word: string): string => `(caption~"${word}" or name~"${word}")`;
  assert.equal(filterOf("walk  left"), `${has("walk")} and ${has("left")}`);
  assert.equal(filterOf('"turn left" or not run'), `(${has("turn left")}) or (not ${has("run")})`);
  assert.equal(filterOf("duration>3"), "duration>3");
  assert.equal(filterOf("performer in (ana)"), "performer in (ana)");
  assert.equal(filterOf("walk or"), has("walk"));
  assert.equal(combine("walk", [ana]), `(${has("walk")}) and performer=ana`);
});

test("a column without its own picks shows its other values", () => {
  assert.equal(combine("", [ana, bvh], "performer"), "format=bvh");
});

test("picks survive the address, and toggle", () => {
  const query = new URLSearchParams();
  query.append("pick", writePick(ana));
  assert.deepEqual(readPicks(new URLSearchParams(query.toString())), [ana]);
  assert.deepEqual(togglePick([ana, bvh], ana), [bvh]);
  assert.deepEqual(togglePick([bvh], ana), [bvh, ana]);
  assert.deepEqual(readPicks(new URLSearchParams("pick=nonsense")), []);
});

test("only rows in sight are drawn, with a few beyond", () => {
  assert.deepEqual(rowsInSight(0, 680, 68, 10_000), [0, 14]);
  assert.deepEqual(rowsInSight(68_000, 680, 68, 10_000), [996, 1014]);
  assert.deepEqual(rowsInSight(1e9, 680, 68, 100), [100, 100]);
  assert.deepEqual(rowsInSight(0, 680, 68, 0), [0, 0]);
});

test("a line of words replaces the sentences of the whole capture and keeps those of parts", () => {
  const part = { words: "turns", start: 1, end: 2 };
  const whole = { words: "walks", start: null, end: null };
  assert.deepEqual(withWholeWords([whole, part], "a person runs;  running ; "), [
    { words: "a person runs", start: null, end: null },
    { words: "running", start: null, end: null },
    part,
  ]);
  assert.deepEqual(withWholeWords([whole, part], ""), [part]);
});

test("files that the server would refuse are left out with the reason", () => {
  const accepts = {
    captures: [".bvh"],
    skeletons: [".asf"],
    sheets: [".tsv"],
    max_file_bytes: 10,
    max_request_bytes: 100,
    max_files: 2,
  };
  const file = (path: string, size: number) => ({ path, file: { size } as File });
  const sorted = sortFiles(
    [file("a/B.BVH", 3), file("x.exe", 3), file("large.bvh", 11), file("w.tsv", 1), file("c.bvh", 1)],
    accepts,
  );
  assert.deepEqual(
    sorted.send.map((one) => one.path),
    ["a/B.BVH", "w.tsv"],
  );
  assert.deepEqual(
    sorted.refused.map((one) => one.message),
    ["not one of .bvh .asf .tsv", "larger than 10 B", "more than 2 files at once"],
  );
});

test("routes are read as they are written", () => {
  const route = parseRoute(routeTo("search", { q: "walk & turn, left", where: "", limit: 5 }), "catalogue");
  assert.equal(route.view, "search");
  assert.deepEqual(
    [...route.parameters],
    [
      ["q", "walk & turn, left"],
      ["limit", "5"],
    ],
  );
  assert.equal(parseRoute("", "catalogue").view, "catalogue");
});

test("a reason that no action escapes is said once", () => {
  const open = { shown: null, reason: "no judge" };
  assert.equal(sharedReason([open, open]), "no judge");
  assert.equal(sharedReason([open]), "");
  assert.equal(sharedReason([open, { shown: null, reason: "too short" }]), "");
  assert.equal(sharedReason([open, { shown: false, reason: "no judge" }]), "");
  assert.equal(sharedReason([]), "");
});

test("a range of rows is selected whole, also where its rows have not arrived", async (context) => {
  const total = 2500;
  const asked: string[] = [];
  context.mock.method(globalThis, "fetch", (path: string) => {
    const query = new URL(path, "http://page").searchParams;
    const [offset, limit] = [Number(query.get("offset")), Number(query.get("limit"))];
    asked.push(`${offset} ${limit}`);
    const count = Math.max(Math.min(limit, total - offset), 0);
    const captures = Array.from({ length: count }, (_, i) => ({ name: `take ${offset + i}` }));
    return Promise.resolve(new Response(JSON.stringify({ total, captures })));
  });
  const rows = makeRows(() => undefined);
  await rows.ask("", "name");
  const picked: string[] = [];
  const pick = makeRangePick(rows, { onPick: (names) => picked.push(...names) });
  await pick(5, false, true);
  await pick(8, true, true);
  assert.deepEqual(picked.splice(0), ["take 5", "take 5", "take 6", "take 7", "take 8"]);
  assert.equal(asked.length, 1); // all of them were there
  await pick(2400, true, true);
  assert.deepEqual(
    picked,
    Array.from({ length: 2393 }, (_, i) => `take ${8 + i}`),
  );
  assert.deepEqual(asked.slice(1), ["8 1000", "1008 1000", "2008 393"]);
});
