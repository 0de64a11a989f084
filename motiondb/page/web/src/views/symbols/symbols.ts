/** Symbol space: the map, and beside it the chosen symbol with its segments. */

import { named, onSubmit } from "../../dom/fields.ts";
import { get, messageOf } from "../../api/client.ts";
import type { ChoiceReply, PlacedSymbol, SegmentsReply, SpaceReply } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { emptyState, faultState } from "../../parts/states.ts";
import { interval, plural, seconds } from "../../parts/text.ts";
import { go, routeTo } from "../../shell/router.ts";
import { makeClip, type Clip } from "../../take/clip.ts";
import { notLearned } from "../not_learned.ts";
import type { Context, OpenView } from "../view.ts";
import { axisEnds, clustersOf, foundSymbols } from "./clusters.ts";
import { makeChoice } from "./choice.ts";
import { makeSymbolMap } from "./map.ts";

const PAGE = 30;

export function open(host: HTMLElement, context: Context): OpenView {
  let space: SpaceReply | null = null;
  let chosen: number | null = null;
  let axes: [number, number] = [0, 1];
  let clip: Clip | null = null;

  let found = "";
  const map = makeSymbolMap(context.motions, (symbol) =>
    go(routeTo("symbols", { symbol, axes: axes.join(",") === "0,1" ? "" : axes.join(",") })),
  );
  const bar = h("div.row.settings");
  const legend = h("ul.plain.cluster-legend", { "aria-label": "Clusters" });
  const find = h("input.field", {
    id: "find-symbol",
    type: "search",
    placeholder: "a word, or the number of a symbol",
    autocomplete: "off",
    on: {
      input: () => {
        found = find.value;
        covered = null;
        showFound();
      },
    },
  });
  const count = h("span.muted.small", { role: "status" });
  const finding = h(
    "form.row",
    { role: "search", "aria-label": "Find a symbol" },
    named("Find", find),
    count,
  );
  onSubmit(finding, () => {
    const [best] = bestFound();
    if (best !== undefined) go(routeTo("symbols", { symbol: best }));
  });
  let covered: ChoiceReply | null = null;
  const choice = makeChoice((next) => {
    covered = next;
    found = find.value = "";
    showFound();
  });
  const panel = h("aside.symbol-panel", { "aria-label": "Chosen symbol" });
  const left = h("div.symbol-left", bar, finding, choice.element, map.element, legend);

  async function load(): Promise<void> {
    try {
      space = await get("/api/symbols");
    } catch (fault) {
      fill(host, notLearned(fault, context) ?? faultState(messageOf(fault)));
      return;
    }
    if (!left.isConnected)
      fill(host, h("h1.hidden-heading", "Symbol space"), h("div.symbol-body", left, panel));
    showMap();
    void showChosen();
  }

  function zoomButton(text: string, label: string, by: number): HTMLElement {
    return button("plain", text, () => map.enlarge(by), {
      title: label,
      ...(text === "All" ? {} : { "aria-label": label }),
    });
  }

  function axisChoice(which: 0 | 1): HTMLElement {
    const select = h(
      "select.field",
      {
        "aria-label": which === 0 ? "Horizontal axis" : "Vertical axis",
        on: {
          change: () => {
            axes[which] = Number(select.value);
            showMap();
          },
        },
      },
      Array.from({ length: space!.dimensions }, (_, i) => {
        const { low, high } = axisEnds(space!.symbols, i);
        const about = low.length && high.length ? `: ${low[0]} to ${high[0]}` : "";
        return h("option", { value: i, selected: axes[which] === i }, `axis ${i + 1}${about}`);
      }),
    );
    return select;
  }

  function showMap(): void {
    if (!space) return;
    fill(
      bar,
      h(
        "p.summary",
        `${plural(space.symbols.length, "symbol")}: kinds of movement that learning found. Those that lie close together move alike.`,
      ),
      h(
        "span.row",
        zoomButton("−", "Shrink the map", 1 / 1.5),
        zoomButton("+", "Enlarge the map", 1.5),
        zoomButton("All", "See the whole map", 0),
      ),
      space.dimensions > 2 ? h("span.row", "Across", axisChoice(0), "up", axisChoice(1)) : null,
    );
    map.show(space, axes);
    map.choose(chosen);
    showLegend();
    showFound();
  }

  /** The found symbols, the one of which the word is most probable first. */
  function bestFound(): number[] {
    const numbers = space ? foundSymbols(space.symbols, found) : null;
    const typed = found.trim().toLowerCase();
    const likely = (symbol: number): number =>
      space!.symbols
        .find((one) => one.symbol === symbol)!
        .words.find(({ word }) => word.toLowerCase().startsWith(typed))?.probability ?? 0;
    return [...(numbers ?? [])].sort((a, b) => likely(b) - likely(a));
  }

  function showFound(): void {
    if (!space) return;
    const numbers = covered && !found ? new Set(covered.symbols) : foundSymbols(space.symbols, found);
    map.find(numbers);
    count.textContent = numbers === null ? "" : plural(numbers.size, "symbol");
  }

  /** What each colour of the map is about. */
  function showLegend(): void {
    fill(
      legend,
      (space!.clusters.length > 1 ? clustersOf(space!.symbols) : []).map(
        ({ tint, symbols: members, words }) =>
          h(
            "li",
            h("span.cluster-colour", { style: { background: tint.strong } }),
            words.length ? words.join(", ") : "no probable word",
            h("span.muted.small", ` ${plural(members, "symbol")}`),
          ),
      ),
    );
  }

  function closeClip(): void {
    clip?.close();
    clip = null;
  }

  function play(box: HTMLElement, segment: SegmentsReply["segments"][number]): void {
    closeClip();
    clip = makeClip(context, {
      ref: segment.ref,
      part: [segment.start, segment.end],
      lit: [segment.start, segment.end],
      label: `${segment.capture}, ${interval(segment.start, segment.end)}`,
    });
    fill(box, clip.element, h("p.small.muted", segment.capture, ` ${interval(segment.start, segment.end)}`));
  }

  async function showChosen(): Promise<void> {
    map.choose(chosen);
    closeClip();
    const facts = space?.symbols.find((one) => one.symbol === chosen);
    if (!facts) {
      fill(panel, emptyState("Choose a dot", "It plays this kind of movement, and lists where it happens."));
      return;
    }
    const box = h("div.symbol-clip");
    const list = h("ul.plain.segment-list");
    fill(panel, heading(facts), box, h("h3", "Where it happens, the most typical first"), list);
    await moreSegments(facts.symbol, box, list, 0);
  }

  async function moreSegments(
    symbol: number,
    box: HTMLElement,
    list: HTMLElement,
    offset: number,
  ): Promise<void> {
    const answer = await get("/api/symbol", { symbol, offset, limit: PAGE });
    if (chosen !== symbol) return;
    list.append(
      ...answer.segments.map((segment) =>
        h(
          "li",
          button("link", segment.capture, () => play(box, segment), { title: "Play this segment" }),
          h("span.muted.time", ` ${interval(segment.start, segment.end)} `),
          h(
            "a.link",
            {
              href: routeTo("search", {
                like: segment.ref,
                start: segment.start.toFixed(3),
                end: segment.end.toFixed(3),
              }),
            },
            "more like this",
          ),
        ),
      ),
    );
    const next = offset + answer.segments.length;
    if (next < answer.total) {
      const more = button("plain", `${answer.total - next} more`, () => {
        more.remove();
        void moreSegments(symbol, box, list, next);
      });
      list.after(more);
    }
    if (offset === 0 && answer.segments[0]) play(box, answer.segments[0]);
  }

  function heading(facts: PlacedSymbol): HTMLElement {
    return h(
      "div",
      h("h2", `Symbol ${facts.symbol}`),
      h(
        "p.muted",
        `${plural(facts.count, "segment")} in ${plural(facts.captures, "capture")}, ${seconds(facts.seconds)} on average`,
      ),
      h(
        "p.chips",
        h("span.chips-lead", "Words most often said of it"),
        facts.words
          .filter((one) => one.probability >= 0.05)
          .slice(0, 6)
          .map(({ word, probability }) => {
            const chip = h(
              "a.chip",
              { href: routeTo("search", { q: word }) },
              word,
              h("span.chip-detail", probability.toFixed(2)),
            );
            return chip;
          }),
      ),
    );
  }

  void load();
  return {
    update(parameters) {
      const symbol = parameters.get("symbol");
      const next = symbol === null ? null : Number(symbol);
      const [first, second] = (parameters.get("axes") ?? "0,1").split(",").map(Number);
      axes = [first ?? 0, second ?? 1];
      if (next === chosen && space) return;
      chosen = next;
      if (space) void showChosen();
    },
    news(news) {
      if (news.kind === "revision") void load();
    },
    close() {
      closeClip();
      map.close();
    },
  };
}
