/** Compare: two to four parts on one clock and one ground, and how far their poses are apart. */

import { choice, named } from "../../dom/fields.ts";
import { isAbort } from "../../api/client.ts";
import { makeLatest } from "../../api/latest.ts";
import { REDUCED } from "../../dom/wishes.ts";
import type { BodyTrack } from "../../api/container.ts";
import { button } from "../../dom/button.ts";
import { fill, h, type Child } from "../../dom/element.ts";
import { icon } from "../../dom/icons.ts";
import { emptyState, showFault } from "../../parts/states.ts";
import { interval } from "../../parts/text.ts";
import { rgbOf } from "../../parts/tint.ts";
import { makePlayer } from "../../player/player.ts";
import { spanOf } from "../../player/screen.ts";
import { amend, go, partOf, rewrite, routeTo } from "../../shell/router.ts";
import type { Lane } from "../../timeline/lanes.ts";
import { makeTimeline, type Interval, type Timeline } from "../../timeline/timeline.ts";
import type { Context, OpenView } from "../view.ts";
import {
  addressOf,
  comparisonOf,
  keepParts,
  MOMENTS,
  MOST,
  type Comparison,
  type Moment,
  type Part,
} from "./address.ts";
import { alignTracks, differenceOf } from "./aligned.ts";
import { makeCurves } from "./curves.ts";

/** Seconds around each part that are loaded with it. */
const AROUND = 1;
/** Milliseconds after the time was changed by hand before the address tells it. */
const PAUSE = 300;
/** Hues of the figures, degrees in OKLCH; far apart also for most who see few colours. By eye. */
const HUES = [250, 50, 150, 330];

const SAID: Readonly<Record<Moment, string>> = {
  start: "the start of each part",
  middle: "the middle of each part",
  end: "the end of each part",
  poses: "like poses",
};

const rgb = (i: number): [number, number, number] => rgbOf(0.64, 0.13, HUES[i]!);
const css = (i: number): string =>
  `rgb(${rgb(i)
    .map((one) => Math.round(one * 255))
    .join(" ")})`;

/** The name of what a ref plays. */
const nameOf = (ref: string): string => ref.slice(ref.indexOf(":") + 1);

export function open(host: HTMLElement, context: Context): OpenView {
  let wanted: Comparison = { parts: [], at: "middle", overlaid: false, time: null };
  let asked: string | null = null;
  const latest = makeLatest();
  let timer = 0;
  let bodies: BodyTrack[] = [];
  let timeline: Timeline | null = null;

  const player = makePlayer(context.stage, { label: "The comparison" });
  const curves = makeCurves();
  const list = h("ol.plain.compare-parts", { "aria-label": "Compared parts" });
  const timelineBox = h("div");
  const fault = h("div", { "aria-live": "polite" });
  const at = choice(
    "compare-at",
    MOMENTS.map((value) => [value, SAID[value]]),
    (value) => change({ at: value as Moment }),
  );
  const ground = choice(
    "compare-ground",
    [
      ["", "side by side"],
      ["one", "overlaid on one spot"],
    ],
    (value) => change({ overlaid: value === "one" }),
  );
  const note = h("p.small.muted", { "aria-live": "polite" });
  const body = h(
    "div.compare-body",
    h(
      "div.compare-left",
      list,
      h("div.form-grid", named("Same moment", at), named("Figures", ground)),
      note,
      h("p.small.muted", "To add another, select an answer of a search and press Compare."),
    ),
    h("div.compare-right", fault, player.element, timelineBox, curves.element),
  );
  const empty = h("div");
  fill(host, h("h1.hidden-heading", "Compare"), empty, body);

  player.onTime((time) => {
    timeline?.setTime(time);
    curves.setTime(time);
    if (player.screen.playback.playing || bodies.length === 0) return;
    clearTimeout(timer);
    timer = window.setTimeout(() => {
      if (player.screen.playback.playing) return;
      wanted = { ...wanted, time };
      rewrite(addressOf(wanted));
    }, PAUSE);
  });

  function change(next: Partial<Comparison>): void {
    clearTimeout(timer);
    amend(addressOf({ ...wanted, ...next, time: null }));
  }

  function row(part: Part, i: number): HTMLElement {
    const name = nameOf(part.ref);
    const [start, end] = [part.start.toFixed(3), part.end.toFixed(3)];
    const catalogued = part.ref.startsWith("capture:");
    const address = routeTo("catalogue", { capture: name, start, end });
    const remove = (): void => change({ parts: wanted.parts.filter((_, k) => k !== i) });
    return h(
      "li",
      h("span.swatch", { style: { background: css(i) } }),
      h("b", i + 1),
      catalogued ? h("a.capture-name", { href: address }, name) : h("span.capture-name", name),
      h("span.time.muted", interval(part.start, part.end)),
      button("tool", icon("close"), remove, { "aria-label": `Remove ${name} from the comparison` }),
    );
  }

  /** How much faster or slower a figure is played than it was, in words. */
  function stretchOf(i: number): string {
    const [first, part] = [wanted.parts[0]!, wanted.parts[i]!];
    if (wanted.at !== "poses" || i === 0) return "";
    const ratio = (part.end - part.start) / (first.end - first.start);
    return `, at ${ratio.toFixed(2)} times its speed on average`;
  }

  /** The found part of each motion, on the common clock. */
  function lanes(spans: readonly Interval[]): Lane[] {
    return wanted.parts.map((part, i) => ({
      name: String(i + 1),
      kind: "parts",
      blocks: [
        {
          start: spans[i]![0],
          end: spans[i]![1],
          label: nameOf(part.ref),
          colour: `color-mix(in srgb, ${css(i)} 40%, white)`, // that of its figure
          title: `${i + 1}: ${nameOf(part.ref)}, ${interval(part.start, part.end)} of its take${stretchOf(i)}`,
        },
      ],
    }));
  }

  function play(): void {
    const { parts, overlaid, time } = wanted;
    const { tracks, spans } = alignTracks(bodies, parts, wanted.at, overlaid);
    const named = tracks.map((track, i) => ({
      ...track,
      name: innerWidth > 720 ? `${i + 1} ${nameOf(parts[i]!.ref)}` : String(i + 1),
    }));
    player.show({ tracks: named, colours: parts.map((_, i) => rgb(i)) });
    const [, duration] = spanOf(tracks);
    timeline = makeTimeline({
      duration,
      label: "Timeline of the comparison",
      onSeek: (moment) => player.seek(moment),
    });
    timeline.setLanes(lanes(spans));
    fill(timelineBox, timeline.element);
    const others = tracks.slice(1).map((track, k) => ({
      figure: k + 2,
      colour: css(k + 1),
      difference: differenceOf(tracks[0]!.motion, track.motion),
    }));
    curves.show(others, tracks[0]?.motion.points ?? [], duration);
    player.seek(time ?? Math.min(...spans.map(([start]) => start)));
    if (time === null && !REDUCED.matches) player.play();
  }

  async function load(): Promise<void> {
    fault.replaceChildren();
    player.element.hidden = false;
    player.say("Loading…");
    const asking = wanted.parts.map(({ ref, start, end }) =>
      context.motions.tracks(ref, Math.max(start - AROUND, 0), end + AROUND),
    );
    try {
      const answers = await latest(Promise.all(asking));
      const found = answers.map((tracks) => tracks.find((one): one is BodyTrack => one.kind === "body"));
      bodies = found.flatMap((one) => (one && one.motion.frames > 0 ? [one] : []));
      if (bodies.length < wanted.parts.length) throw new Error("A part holds no motion of a person.");
      play();
    } catch (problem) {
      if (isAbort(problem)) return;
      bodies = [];
      timelineBox.replaceChildren();
      curves.show([], [], 0);
      player.element.hidden = true;
      showFault(fault, problem);
    }
  }

  function show(): void {
    const { parts } = wanted;
    body.hidden = parts.length === 0;
    const searching = { label: "Search", run: (): void => go(routeTo("search")) };
    const about =
      "Select two to four answers of a search and press Compare, or drag over the timeline of a capture and press Compare this part.";
    fill(
      empty,
      parts.length === 0 ? emptyState("Nothing to compare yet", about as Child, [searching]) : null,
    );
    at.value = wanted.at;
    note.textContent =
      wanted.at === "poses"
        ? "The time of the others is stretched, so that like poses come at the same moments as in 1."
        : "All face the same way at that moment. Time is as it was.";
    ground.value = wanted.overlaid ? "one" : "";
    fill(list, parts.map(row));
  }

  return {
    update(parameters) {
      const next = comparisonOf(parameters);
      const key = partOf(parameters, ["part", "at", "ground"]);
      if (key === asked) return;
      asked = key;
      wanted = { ...next, parts: next.parts.slice(0, MOST) };
      keepParts(wanted.parts);
      show();
      if (wanted.parts.length > 0) void load();
    },
    close() {
      void latest();
      clearTimeout(timer);
      player.close();
    },
  };
}
