/** The panel of one capture: its player, its words, where it comes from, its copies. */

import { makeLatest } from "../../api/latest.ts";
import { showFault } from "../../parts/states.ts";
import { onPage } from "../../api/advice.ts";
import { ApiError, get, post } from "../../api/client.ts";
import type { CaptureDetails } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h, type Child } from "../../dom/element.ts";
import { icon } from "../../dom/icons.ts";
import { askLine, askWhether } from "../../parts/asking.ts";
import { download, downloadButtons, downloadMenu, type FileFormat } from "../../parts/download.ts";
import { askSelection } from "../../parts/selecting.ts";
import { interval, seconds } from "../../parts/text.ts";
import { makeTake } from "../../take/take.ts";
import {
  captionLane,
  lacksLane,
  stretchLane,
  symbolLane,
  wordLane,
  type Lane,
} from "../../timeline/lanes.ts";
import type { Interval } from "../../timeline/timeline.ts";
import { go, routeTo } from "../../shell/router.ts";
import type { Context } from "../view.ts";
import { isEditing, makeCaptionList, type WordsActions } from "./editing.ts";
import { addressWith } from "../compare/address.ts";

/** All lanes that are known of a capture. */
export function lanesOf(facts: CaptureDetails): Lane[] {
  return [
    captionLane(facts.words, facts.duration),
    symbolLane(facts.segments),
    wordLane(facts.recognised),
    lacksLane(facts.lacks),
    stretchLane(facts.stretches),
  ];
}

/** A part of a capture, and a moment of it, seconds. */
export interface Place {
  part: Interval | null;
  time: number | null;
}

/** Milliseconds after the time was changed by hand before the address tells it. */
const PAUSE = 300;

export function makeDetails(
  context: Context,
  actions: WordsActions,
  leave: () => void,
  /** Another part, or another moment, is shown. */
  moved: (place: Partial<Place>) => void,
) {
  let facts: CaptureDetails | null = null;
  let name = "";
  const latest = makeLatest();
  const title = h("h2", { tabindex: -1 });
  const under = h("div.details-under");
  // There at once, before anything is known of the capture.
  const tools = h(
    "div.row.actions",
    button("plain", "More like this", () => go(routeTo("search", { like: ref() }))),
    downloadButtons(context.status().writes, (format) => void save(format), true),
  );
  const ref = (): string => `capture:${name}`;

  const writeWords = (part: Interval): void => {
    const capture = name;
    const label = "What happens in this part?";
    const about = `${capture}, ${interval(...part)}`;
    askLine({ title: "Words of a part", label, about, example: "turns left", yes: "Save words" }, (words) =>
      actions.addPart(capture, words, ...part),
    );
  };
  const likeThis = (part: Interval): void =>
    go(routeTo("search", { like: ref(), start: part[0].toFixed(3), end: part[1].toFixed(3) }));
  const compareThis = (part: Interval): void =>
    go(addressWith([{ ref: ref(), start: part[0], end: part[1] }]));
  const selectThis = (part: Interval): void =>
    askSelection(context, [{ ref: ref(), start: part[0], end: part[1] }], `${name}, ${interval(...part)}`);
  let loading = false;
  let timer = 0;
  const take = makeTake(context, {
    label: "Capture",
    onSelect: (part) => loading || moved({ part, time: null }),
    partActions: [
      ...(context.status().read_only ? [] : [{ label: "Write words", run: writeWords }]),
      { label: "Search with this part", run: likeThis },
      { label: "Compare this part", run: compareThis },
      ...(context.status().read_only ? [] : [{ label: "Add to a selection…", run: selectThis }]),
    ],
    partMore: downloadMenu(
      "Download this part",
      context.status().writes,
      (format) => void save(format, ...(take.selection ?? [])),
    ),
  });
  take.player.onTime((time) => {
    clearTimeout(timer);
    if (loading || take.player.screen.playback.playing) return;
    timer = window.setTimeout(() => {
      const { playing, from } = take.player.screen.playback;
      if (!playing) moved({ time: Math.abs(time - from) < 1e-6 ? null : time });
    }, PAUSE);
  });
  const captions = makeCaptionList(actions, (start, end) => take.select([start, end]));

  async function save(format: FileFormat, start?: number, end?: number): Promise<void> {
    await download([{ ref: ref(), start: start ?? null, end: end ?? null }], format);
    // Readers of BVH refuse whatever else stands in a file, so no licence can be written into it.
    const licence = facts?.tags["licence"];
    if (format === "bvh" && licence)
      context.notify(`Saved. A BVH file has no place for its licence, which is ${licence}.`);
  }

  async function removeCapture(): Promise<void> {
    const sure = await askWhether(
      `Remove ${name}?`,
      "The capture, its words and what was learned from its words are removed from the database. Undo brings them back.",
      "Remove",
    );
    if (!sure) return;
    await post("/api/captures/remove", { captures: [name] });
    context.notify(`${name} is removed.`, { label: "Undo", run: () => void actions.undo() });
    leave();
  }

  const element = h(
    "aside.details",
    { "aria-label": "Capture" },
    h(
      "div.details-head",
      title,
      button("tool", icon("close"), leave, { "aria-label": "Close the capture", title: "Close (Escape)" }),
    ),
    take.element,
    tools,
    under,
  );
  element.addEventListener("keydown", (event) => {
    const inside = (event.target as HTMLElement).closest("dialog, input, select"); // these it ends itself
    if (event.key === "Escape" && !inside && !document.fullscreenElement) leave();
  });

  /** Ask for the likely words, which take longest; everything else is there meanwhile. */
  async function describe(): Promise<void> {
    try {
      const { words } = await latest(get("/api/describe", { ref: ref() }));
      if (!facts) return; // another capture is on its way
      facts = { ...facts, recognised: words };
      take.setLanes(lanesOf(facts));
    } catch (fault) {
      if (!(fault instanceof ApiError && fault.kind === "NotLearnedError")) throw fault;
    }
  }

  function showFacts(): void {
    if (!facts) return;
    take.setLanes(lanesOf(facts));
    take.setGhosts(facts.ghosts);
    captions.show(name, facts.words, !context.status().read_only && facts.kind !== "generated");
    fill(
      under,
      facts.grammar && facts.string
        ? h(
            "p.small",
            `A sequence of the grammar ${facts.grammar}. `,
            h("a", { href: routeTo("grammar", { open: facts.name }) }, "Open in the editor"),
          )
        : null,
      h("h3", "Words"),
      captions.element,
      copiesOf(facts),
      h("h3", "Facts"),
      factList(facts),
      context.status().read_only
        ? null
        : button("remove", "Remove this capture…", () => void removeCapture()),
    );
  }

  return {
    element,
    /** The capture that is shown. */
    get name(): string {
      return name;
    },
    /** Show a capture, with a part of it and a moment if an address names them. */
    async show(next: string, { part, time }: Place): Promise<void> {
      name = next;
      clearTimeout(timer);
      title.textContent = name;
      facts = null;
      take.element.hidden = tools.hidden = false;
      fill(under, h("p.muted", { role: "status" }, "Loading its words and facts…"));
      loading = true;
      context.stage.rest(true);
      const ready = take.load({ ref: ref(), selection: part }).then(() => {
        if (name !== next) return;
        loading = false;
        if (time === null) return;
        take.player.screen.setPlayback({ ...take.player.screen.playback, playing: false });
        take.player.seek(time);
      }); // it plays while the facts are computed
      try {
        const answer = await get("/api/capture", { name: next, described: false });
        if (name !== next) return;
        facts = answer;
        void describe();
      } catch (fault) {
        if (name !== next) return;
        context.stage.rest(false);
        take.element.hidden = tools.hidden = true;
        showFault(under, fault, [{ label: "Close", run: leave }]);
        return;
      }
      showFacts();
      // The figures move again once the facts are drawn.
      requestAnimationFrame(() => requestAnimationFrame(() => name === next && context.stage.rest(false)));
      await ready;
    },
    /** Ask again for the facts of the shown capture; the player goes on. */
    async reload(): Promise<void> {
      const asked = name;
      try {
        const answer = await get("/api/capture", { name: asked, described: false });
        if (name !== asked || isEditing(element)) return; // what is typed is compared when it is saved
        facts = answer;
        showFacts();
        void describe();
      } catch (fault) {
        if (name === asked && fault instanceof ApiError && fault.status === 404) leave(); // removed
      }
    },
    /** Choose a part of the shown capture. */
    select: (part: Interval | null) => {
      const before = take.selection;
      if (part?.[0] !== before?.[0] || part?.[1] !== before?.[1]) take.select(part);
    },
    close: () => {
      clearTimeout(timer);
      context.stage.rest(false);
      take.close();
    },
  };
}

export type Details = ReturnType<typeof makeDetails>;

function copiesOf(facts: CaptureDetails): Child {
  if (facts.relations.length === 0) return null;
  return [
    h("h3", "Copies"),
    h(
      "ul.plain",
      facts.relations.map((copy) => {
        const other = copy.capture === facts.name ? copy.other : copy.capture;
        const where = `, ${interval(copy.start, copy.end)}`;
        return h(
          "li",
          h("a", { href: routeTo("catalogue", { capture: other }) }, other),
          ` – ${copy.kind}${where}`,
        );
      }),
    ),
  ];
}

function factList(facts: CaptureDetails): HTMLElement {
  const rows: [string, string | null][] = [
    [
      "Length",
      `${seconds(facts.duration)}, ${facts.n_frames} frames at ${Number(facts.fps.toFixed(2))} per second`,
    ],
    ["Performer", facts.tags["performer"] ?? null],
    ["Licence", facts.tags["licence"] ?? "not known"],
    ["Format", facts.format],
    ["File", facts.path.split(/[/\\]/).at(-1) ?? ""],
    ...Object.entries(facts.tags).filter(([key]) => key !== "performer" && key !== "licence"),
    ...facts.notes.map((note): [string, string] => ["Note", onPage(note)]),
    ...facts.sources.map((one): [string, string] => [
      "Source",
      `${one.capture}, ${one.frames} frames, licence ${one.licence}`,
    ]),
    ["SHA-256", facts.sha256],
  ];
  return h(
    "dl.facts",
    rows.filter(([, value]) => value).map(([name, value]) => h("div", h("dt", name), h("dd", value!))),
  );
}
