/** One answer: it plays the matched interval over the timeline of its take. */

import { get } from "../../api/client.ts";
import type { CaptureDetails, ShownMatch, MatchPart } from "../../api/types.ts";
import { fill, h, type Child } from "../../dom/element.ts";
import { interval, probability } from "../../parts/text.ts";
import { routeTo } from "../../shell/router.ts";
import { makeClip, type Clip } from "../../take/clip.ts";
import { captionLane, symbolLane, wordLane, type Lane } from "../../timeline/lanes.ts";
import { makeTimeline, type Interval } from "../../timeline/timeline.ts";
import type { Motions } from "../../api/motions.ts";
import type { Stage } from "../../player/stage.ts";
import { reasonsElement } from "./reasons.ts";

export interface AnswerOptions {
  /** false: nothing in the database matches, this is only the nearest. */
  matches: boolean;
  /** false: the scores are for less than what was asked. */
  scored: boolean;
  /** Absent in a file without a server: nothing can be selected, opened or asked. */
  actions?: { select(match: ShownMatch, selected: boolean): void };
}

export interface AnswerCard {
  readonly element: HTMLElement;
  setSelected(selected: boolean): void;
  close(): void;
}

/** The intervals that were found: those of the parts where they are known, or the whole match. */
function litParts(match: ShownMatch): Interval[] {
  const known = match.parts.filter((part) => part.place === "known");
  if (known.length > 0) return known.map((part): Interval => [part.start!, part.end!]);
  return match.place === "unknown" ? [] : [[match.start, match.end]];
}

function meter(name: string, value: number | null | undefined, hint: string): Child {
  if (value === null || value === undefined) {
    return h(
      "div",
      { class: "meter", title: hint },
      h("span", { class: "meter-name" }, name),
      h("span", { class: "muted" }, "not measured"),
    );
  }
  const bar = h("span", { class: "meter-fill" });
  bar.style.width = `${Math.round(value * 100)}%`;
  return h(
    "div",
    { class: "meter", title: hint },
    h("span", { class: "meter-name" }, name),
    h("span", { class: "meter-bar", "aria-hidden": "true" }, bar),
    h("span", { class: "meter-value" }, probability(value)),
  );
}

function lanesOf(match: ShownMatch): Lane[] {
  if (!match.timeline) return [];
  return [symbolLane(match.timeline.segments), captionLane(match.timeline.words, match.duration)];
}

/** How sure the place of a part is. */
function saidHere(part: MatchPart): string {
  return `here ${part.interval_probability === null ? "not measured" : probability(part.interval_probability)}`;
}

function foundList(match: ShownMatch, seek: (time: number) => void): Child {
  const parts = match.parts;
  if (parts.length === 0) return match.reason ? h("p", { class: "small" }, match.reason) : null;
  return h(
    "ul",
    { class: "plain found" },
    parts.map((part) => {
      const certain = [
        `shown ${part.probability === null ? "not measured" : probability(part.probability)}`,
        saidHere(part),
      ]
        .filter(Boolean)
        .join(", ");
      const place =
        part.place === "known"
          ? h(
              "button",
              {
                class: "link time",
                type: "button",
                title: "Go there",
                on: { click: () => seek(part.start!) },
              },
              interval(part.start, part.end),
            )
          : h("span", { class: "muted" }, "somewhere, by its caption");
      return h(
        "li",
        {},
        h("b", {}, part.words),
        " ",
        place,
        certain ? h("span", { class: "muted" }, ` ${certain}`) : null,
      );
    }),
  );
}

/** The address of the found part of a capture. */
function placeOf({ capture, start, end, place }: ShownMatch): Record<string, string> {
  const part: Record<string, string> =
    place === "unknown" ? {} : { start: start.toFixed(3), end: end.toFixed(3) };
  return { capture, ...part };
}

export function makeAnswer(
  context: { stage: Stage; motions: Motions },
  match: ShownMatch,
  options: AnswerOptions,
): AnswerCard {
  const { actions } = options;
  const part: Interval = [match.start, match.end];
  const timeline = makeTimeline({
    duration: match.duration,
    label: `Timeline of ${match.capture}`,
    small: true,
    onSeek: (time) => clip.seek(time),
  });
  const clip: Clip = makeClip(context, {
    ref: match.ref,
    part,
    lit: match.place === "unknown" || !options.matches ? null : part,
    label: `${match.capture}, ${interval(...part)}`,
    onTime: (time) => timeline.setTime(time),
  });
  const lanes = lanesOf(match);
  timeline.setLanes(lanes);
  timeline.setLit(litParts(match));
  timeline.setTime(match.start);

  const checkbox = h("input", {
    type: "checkbox",
    "aria-label": `Select ${match.capture}, ${interval(...part)}`,
    on: { change: () => actions?.select(match, checkbox.checked) },
  });
  const name = actions
    ? h("a", { href: routeTo("catalogue", placeOf(match)), class: "capture-name" }, match.capture)
    : h("span", { class: "capture-name" }, match.capture);
  const explain = match.explain
    ? h(
        "details",
        { class: "why" },
        h("summary", {}, "Why this answer"),
        reasonsElement(match.explain, match.score),
      )
    : null;
  const wordsButton = h(
    "button",
    { class: "link", type: "button", on: { click: () => void addWords() } },
    "Recognised words",
  );

  async function addWords(): Promise<void> {
    wordsButton.remove();
    const facts = await get<CaptureDetails>("/api/capture", { name: match.capture });
    timeline.setLanes([...lanes, wordLane(facts.recognised)]);
  }

  const element = h(
    "article",
    {
      class: options.matches ? "answer" : "answer nearest",
      "aria-label": `Answer ${match.rank}: ${match.capture}`,
    },
    h(
      "header",
      { class: "answer-head" },
      actions ? h("label", { class: "check" }, checkbox) : null,
      h("span", { class: "rank" }, match.rank),
      name,
      h("span", { class: "time muted" }, interval(...part)),
    ),
    clip.element,
    timeline.element,
  );
  const facts = h("div", { class: "answer-facts" });
  fill(
    facts,
    h(
      "div",
      { class: "meters" },
      meter("shown", match.probability, "The probability that this take shows what was asked."),
      match.parts.length > 0
        ? meter("here", match.interval_probability, "The probability that this interval shows it.")
        : null,
      match.probability === null && options.scored
        ? meter(
            "score",
            match.score,
            "A score between 0 and 1 that orders the answers; it is no probability.",
          )
        : null,
    ),
    foundList(match, (time) => clip.seek(time)),
    match.words.length > 0 ? h("p", { class: "small muted" }, `recognised: ${match.words.join(", ")}`) : null,
    explain,
    h(
      "div",
      { class: "row answer-actions" },
      actions
        ? h(
            "a",
            {
              class: "link",
              href: routeTo("search", {
                like: match.ref,
                start: match.start.toFixed(3),
                end: match.end.toFixed(3),
              }),
            },
            "More like this",
          )
        : null,
      actions ? wordsButton : null,
      h("span", { class: "muted small licence", title: "Licence" }, match.licence ?? "licence not known"),
    ),
  );
  element.append(facts);

  return {
    element,
    setSelected(selected) {
      checkbox.checked = selected;
    },
    close: () => clip.close(),
  };
}
