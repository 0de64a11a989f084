/** The opening: captures move in their best seconds, and the question box stands in the middle. */

import { makeLatest } from "../../api/latest.ts";
import { dropEarly, get, isAbort, prefetch } from "../../api/client.ts";
import type { WallTile } from "../../api/types.ts";
import { isActive, stepOf } from "../../api/jobs.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { rememberPlaces } from "../../dom/flights.ts";
import { icon } from "../../dom/icons.ts";
import { onDrop } from "../../parts/dropping.ts";
import { progressBar } from "../../parts/progress.ts";
import { plural, seconds } from "../../parts/text.ts";
import { routeTo } from "../../shell/router.ts";
import { openAdding } from "../catalogue/adding.ts";
import { openLearning, reasonToLearn } from "../catalogue/learning.ts";
import { makeThumbs } from "../catalogue/thumbs.ts";
import { emptyDatabase } from "../empty_database.ts";
import { wordsQuery } from "../search/query.ts";
import type { Context, OpenView } from "../view.ts";
import { offeredQuestions } from "./offered.ts";

/** About the width and the height of a tile, pixels; and the room that the box needs. Chosen by eye. */
const TILE = { width: 150, height: 196 };
const BOX = { width: 640, height: 330 };
const MOST = 60;
/** A narrower window has smaller tiles, so that there is a wall at all. */
const NARROW = 720;
/** Milliseconds for which the wall waits for the answers that it turns into. */
const PATIENCE = 4000;

/** How many columns and rows fit, and which of them the box takes: half-open ranges. */
export function layOut(
  width: number,
  height: number,
): Record<"columns" | "rows", number> & {
  across: [number, number];
  down: [number, number];
} {
  const scale = width < NARROW ? 0.66 : 1;
  const columns = Math.max(Math.round(width / TILE.width / scale), 3);
  const rows = Math.max(Math.round(height / TILE.height / scale), 3);
  const needed = Math.ceil((BOX.width * columns) / width);
  // as many columns on the left as on the right of it
  const wide = Math.min(needed + ((columns - needed) % 2), columns);
  const tall = Math.min(Math.ceil((BOX.height * rows) / height), rows - 1);
  const [left, top] = [(columns - wide) / 2, Math.floor((rows - tall) / 2)];
  return { columns, rows, across: [left, left + wide], down: [top, top + tall] };
}

export function open(host: HTMLElement, context: Context): OpenView {
  const canWrite = !context.status().read_only;
  const thumbs = makeThumbs(context.motions, () => false);
  const chips = h("div.chips.examples");
  const facts = h("div.wall-facts.row");
  const work = h("div.wall-work", { role: "status" });
  const box = h(
    "section.wall-box",
    { "aria-label": "About" },
    h("h1", "A library of human motion that you can ask."),
    h("div.question-slot"),
    chips,
    work,
    facts,
  );
  const wall = h("div.wall", box);
  let tiles = new Map<string, HTMLElement>();
  let asked = -1;
  const latest = makeLatest();
  let leaving = 0;
  let size = "";
  let drawn = -1; // The revision of the tiles

  function tile({ capture, words, start, end }: WallTile): HTMLElement {
    const scale = Math.min(devicePixelRatio, 2);
    const canvas = h("canvas", {
      width: TILE.width * scale,
      height: TILE.height * scale,
      "aria-hidden": "true",
    });
    thumbs.show(canvas, capture);
    return h(
      "a.tile",
      {
        href: routeTo("catalogue", { capture, start: start.toFixed(3), end: end.toFixed(3) }),
        title: capture,
        "aria-label": words ? `${capture}: ${words}` : capture,
      },
      canvas,
      words ? h("span.tile-words", words) : null,
    );
  }

  /** Ask for as many captures as there is room for. */
  async function load(): Promise<void> {
    const room = layOut(host.clientWidth, host.clientHeight);
    const { columns, rows, across, down } = room;
    const { revision } = context.status();
    const now = [columns, rows, ...across, ...down, revision].join(" ");
    if (now === size || host.clientWidth === 0) return;
    size = now; // news that comes meanwhile does not ask again
    wall.style.gridTemplateColumns = `repeat(${columns}, minmax(0, 1fr))`;
    wall.style.gridTemplateRows = `repeat(${rows}, minmax(0, 1fr))`;
    box.style.gridColumn = `${across[0] + 1} / ${across[1] + 1}`;
    box.style.gridRow = `${down[0] + 1} / ${down[1] + 1}`;
    const count = columns * rows - (across[1] - across[0]) * (down[1] - down[0]);
    const reply = await latest(get("/api/wall", { count: Math.min(count, MOST) })).catch((fault) => {
      if (!isAbort(fault)) size = "";
      throw fault;
    });
    if (revision !== drawn) context.motions.forget();
    const kept = revision === drawn ? tiles : new Map<string, HTMLElement>();
    const shown = new Map(reply.tiles.map((one) => [one.capture, kept.get(one.capture) ?? tile(one)]));
    for (const [name, element] of tiles) {
      if (shown.get(name) === element) continue;
      thumbs.show(element.querySelector("canvas")!, null);
      element.remove();
    }
    [tiles, drawn] = [shown, revision];
    wall.append(...tiles.values());
  }

  async function offer(): Promise<void> {
    const { learned, revision } = context.status();
    if (!learned || revision === asked) return;
    asked = revision;
    const { lead, questions } = await offeredQuestions(context).catch((fault) => {
      asked = -1;
      throw fault;
    });
    fill(
      chips,
      questions.length > 0 ? h("span.chips-lead", lead) : null,
      questions.map((q) => h("a.chip", { href: routeTo("search", { q }) }, q)),
    );
  }

  /** What is going on, or what is to be done before questions are answered. */
  function showWork(): void {
    const { captures, seconds: length } = context.status();
    const job = context.live
      .jobs()
      .find((one) => ["sample", "learn", "add"].includes(one.kind) && isActive(one));
    const reason = canWrite && !job ? reasonToLearn(context.status()) : null;
    fill(
      work,
      job ? progressBar(job.whole ?? null, stepOf(job)) : null,
      reason ? [h("p", reason), button("main", "Learn…", () => openLearning(context))] : null,
    );
    fill(
      facts,
      h(
        "a.button.plain",
        { href: routeTo("catalogue") },
        icon("list"),
        `${plural(captures, "capture")}, ${seconds(length)} as a list`,
      ),
      canWrite ? button("plain", [icon("plus"), "Add captures"], () => openAdding(context)) : null,
    );
  }

  function show(): void {
    if (context.status().captures === 0) {
      size = "";
      return fill(host, emptyDatabase(context));
    }
    if (!wall.isConnected) fill(host, wall);
    showWork();
    load();
    offer().catch(() => undefined); // the box is there without them
  }

  const sized = new ResizeObserver(() => wall.isConnected && void load());
  sized.observe(host);
  const endDrops = canWrite ? onDrop(host, (files) => openAdding(context, files)) : null;
  show();

  return {
    slot: () => (wall.isConnected ? box.querySelector<HTMLElement>(".question-slot") : null),
    update() {
      leaving += 1; // back, or still here
      if (!host.classList.contains("asking")) return;
      host.classList.remove("asking");
      dropEarly();
      showWork();
    },
    news: show,
    async leave({ view, parameters }) {
      const q = parameters.get("q");
      if (view !== "search" || !q || tiles.size === 0) return;
      leaving += 1;
      const mine = leaving;
      host.classList.add("asking");
      fill(work, h("p", `Looking for “${q}”…`));
      const late = new Promise((resolve) => setTimeout(resolve, PATIENCE));
      await Promise.race([prefetch(...wordsQuery(parameters)), late]);
      if (mine === leaving) rememberPlaces(tiles);
    },
    close() {
      endDrops?.();
      sized.disconnect();
      thumbs.close();
    },
  };
}
