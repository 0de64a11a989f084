/** One answer: it plays the matched interval over the timeline of its take. */

import { get } from "../../api/client.ts";
import type { ShownMatch, MatchPart } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h, type Child } from "../../dom/element.ts";
import { interval, probability, seconds } from "../../parts/text.ts";
import { routeTo } from "../../shell/router.ts";
import { makeClip, type Clip } from "../../take/clip.ts";
import { captionLane, symbolLane, wordLane, type Lane } from "../../timeline/lanes.ts";
import { makeTimeline, type Interval } from "../../timeline/timeline.ts";
import { fromBase64, readContainer } from "../../api/container.ts";
import type { Motions } from "../../api/motions.ts";
import type { Motion } from "../../player/motion.ts";
import type { Stage } from "../../player/stage.ts";
import {
  certaintyOf,
  isPlaced,
  isWhole,
  saysAll,
  sayGrade,
  sayPart,
  type Certainty,
  type Replaced,
} from "./certainty.ts";
import { reasonsElement } from "./reasons.ts";

export interface AnswerOptions {
  /** Words of the question that known words stand for. */
  replaced: Replaced;
  /** false: the scores are for less than what was asked. */
  scored: boolean;
  /** What is measured in the motion, in place of searched: its score says nothing of that. */
  measured: readonly string[];
  /** Absent in a file without a server: nothing can be selected, opened or asked. */
  actions?: { select(match: ShownMatch, selected: boolean): void };
}

/** The intervals that were found, those of the parts where they are known, and which are likely. */
function litParts(match: ShownMatch, likely: boolean): [Interval[], boolean[]] {
  const known = match.parts.filter((part) => part.place === "known");
  if (known.length > 0) {
    const placed = known.map((part) => likely && (isPlaced(part) || isWhole(part, match.duration)));
    return [known.map((part): Interval => [part.start, part.end]), placed];
  }
  return match.place === "unknown" ? [[], []] : [[[match.start, match.end]], [likely]];
}

/** Captions of the whole take are read above the timeline: only those of parts need a place on it. */
function lanesOf(match: ShownMatch): Lane[] {
  if (!match.timeline) return [];
  const timed = match.timeline.words.filter((one) => one.start !== null);
  return [captionLane(timed, match.duration), symbolLane(match.timeline.segments)];
}

function bar(value: number): HTMLElement {
  const fill = h("span.meter-fill");
  fill.style.width = `${Math.round(value * 100)}%`;
  return h("span.meter-bar", { "aria-hidden": "true" }, fill);
}

/** The verdict of a card: how certain the whole answer is, once. */
function verdictOf(match: ShownMatch, certainty: Certainty, options: AnswerOptions): Child {
  const { value, most } = certainty;
  const said = saysAll(match) ? sayPart(match.parts[0], options.replaced) : null;
  const shown = saysAll(match) ? (value ?? match.parts[0].probability) : value;
  const what = said
    ? [h("b", said.words), said.instead ? `, for “${said.instead}”` : ""]
    : match.parts.length > 0
      ? h("b", "all of it")
      : match.reason
        ? match.reason
        : h("b", "the same kind of movement");
  if (shown !== null) {
    return h(
      "p.answer-verdict",
      { title: "The probability that this capture shows it" },
      h("span", what),
      h(
        "span.meter-pair",
        bar(shown),
        h("span.meter-value", probability(shown)),
        h("span.muted", sayGrade(shown)),
      ),
    );
  }
  const score = options.scored && most === null;
  // A score of the word that stands for another says nothing about the other.
  const ranked = said?.instead
    ? `no probability that it is “${said.instead}”`
    : options.measured.length > 0
      ? `measured: ${options.measured.join(", ")}`
      : `score ${probability(match.score)}, no probability`;
  return h(
    "p.answer-verdict",
    h("span", what),
    match.contradicted.length > 0
      ? h("span", `the motion speaks against it; measured: ${match.contradicted.join(", ")}`)
      : h("span", most !== null ? `at most ${probability(most)}` : score ? ranked : "not measured"),
    match.reason.includes("not seen in this order") ? h("span", "not seen in this order") : null,
  );
}

/** The pose of the found moment. */
function posterOf({ poster }: ShownMatch): Motion | null {
  const [track] = poster ? readContainer(fromBase64(poster)) : [];
  return track?.kind === "body" ? track.motion : null;
}

/**
 * Where the parts are. The card says how certain it is once: a place that is less certain than the
 * answer is "about" there, and its number is in its title.
 */
function placesOf(match: ShownMatch, options: AnswerOptions, play: (time: number) => void): Child {
  const { parts } = match;
  const moment = (start: number, end: number, sure: boolean, title = "Play from there"): Child =>
    button("time", `${sure ? "" : "about "}${interval(start, end)}`, () => play(start), { title });
  if (parts.length === 0)
    return match.place === "unknown" ? null : h("p.found", moment(match.start, match.end, true));
  const alone = saysAll(match);
  const place = (part: MatchPart): Child => {
    if (part.place !== "known") return h("span", "somewhere in it, as its caption says");
    if (isWhole(part, match.duration)) return h("span", "from beginning to end");
    const chance = part.interval_probability;
    const sure = chance !== null && isPlaced(part);
    const title =
      chance === null ? undefined : `Shown at this place: ${probability(chance)}. Play from there`;
    return moment(part.start, part.end, sure, title);
  };
  return h(
    "ul.plain.found",
    parts.map((part) => {
      if (alone) return h("li", place(part));
      const said = sayPart(part, options.replaced);
      return h(
        "li",
        h("b", said.words),
        said.instead ? `, for “${said.instead}”` : "",
        match.probability !== null || match.parts.every((one) => one.probability === null)
          ? " " // the verdict says it
          : part.probability !== null
            ? ` ${probability(part.probability)} · `
            : " not measured · ",
        place(part),
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
) {
  const { actions } = options;
  const part: Interval = [match.start, match.end];
  const certainty = certaintyOf(match);
  const lit = litParts(match, certainty.grade === "likely");
  const timeline = makeTimeline({
    duration: match.duration,
    label: `Timeline of ${match.capture}`,
    small: true,
    onSeek: (time) => clip.seek(time),
  });
  const clip: Clip = makeClip(context, {
    ref: match.ref,
    part,
    lit: certainty.grade === "likely" ? part : null,
    poster: posterOf(match),
    label: `${match.capture}, ${interval(...part)}`,
    onTime: (time) => timeline.setTime(time),
  });
  const lanes = lanesOf(match);
  timeline.setLanes(lanes);
  timeline.setLit(...lit);
  timeline.setTime(match.start);

  const checkbox = h("input", {
    type: "checkbox",
    "aria-label": `Select ${match.capture}, ${interval(...part)}`,
    on: { change: () => actions?.select(match, checkbox.checked) },
  });
  const name = actions
    ? h("a.capture-name", { href: routeTo("catalogue", placeOf(match)) }, match.capture)
    : h("span.capture-name", match.capture);
  const explain = match.explain
    ? h("details.why", h("summary", "Why this answer"), reasonsElement(match.explain))
    : null;
  const wordsButton = button("link", "Likely words", () => void addWords());

  async function addWords(): Promise<void> {
    wordsButton.remove();
    const facts = await get("/api/capture", { name: match.capture });
    timeline.setLanes([...lanes, wordLane(facts.recognised)]);
  }

  const element = h(
    "article",
    {
      class: `answer ${certainty.grade}`,
      "aria-label": `Answer ${match.rank}: ${match.capture}`,
    },
    h(
      "header.answer-head",
      actions ? h("label.check", checkbox) : null,
      h("span.rank", match.rank),
      name,
      h("span.time.muted", `${seconds(match.duration)} long`),
    ),
    clip.element,
    timeline.element,
  );
  const whole = (match.timeline?.words ?? []).filter((one) => one.start === null).map((one) => one.words);
  const facts = h("div.answer-facts");
  fill(
    facts,
    verdictOf(match, certainty, options),
    placesOf(match, options, (time) => void clip.playFrom(time)),
    whole.length > 0 ? h("p.answer-caption", { title: whole.join("; ") }, `“${whole[0]}”`) : null,
    match.parts.length === 0 && match.words.length > 0
      ? h("p.small", `likely words: ${match.words.join(", ")}`)
      : null,
  );
  const foot = h(
    "div.answer-foot",
    explain,
    h(
      "div.row.answer-actions",
      actions
        ? h(
            "a.link",
            {
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
      h(
        "span.muted.small.licence",
        { title: "Licence" },
        match.licence ? `licence ${match.licence}` : "licence not known",
      ),
    ),
  );
  clip.element.after(facts);
  facts.after(timeline.element);
  element.append(foot);

  return {
    element,
    grade: certainty.grade,
    setSelected(selected: boolean): void {
      checkbox.checked = selected;
    },
    close: () => clip.close(),
  };
}

export type AnswerCard = ReturnType<typeof makeAnswer>;
