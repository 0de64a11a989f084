/** The alternatives of a region, playing in the corners of the stage. */

import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { makeClip, type Clip } from "../../take/clip.ts";
import type { Context } from "../view.ts";
import type { TerminalColours } from "./colours.ts";
import { timesOf } from "./layout.ts";
import { letters } from "./letters.ts";
import { makeRibbon, type Ribbon } from "./ribbon.ts";
import type { SequenceReply } from "../../api/types.ts";
import type { Alternative } from "./selection.ts";

/** Seconds before and after the region that play with it, so that its seams are seen. */
const AROUND = 0.4;

/** A probability from its logarithm; very small ones as powers of ten. */
export function chanceText(logProbability: number | null): string {
  if (logProbability === null) return "not known";
  const chance = Math.exp(logProbability);
  if (chance >= 0.005) return chance.toFixed(2);
  return `10^${Math.round(logProbability / Math.LN10)}`;
}

export function makeCorners(context: Context, choose: (sequence: SequenceReply) => void) {
  const element = h("div.corners");
  let clips: Clip[] = [];
  let ribbons: Ribbon[] = [];

  function clear(): void {
    ribbons.forEach((ribbon) => ribbon.close());
    clips.forEach((clip) => clip.close());
    ribbons = [];
    clips = [];
    element.inert = false;
    fill(element);
  }

  function player(made: SequenceReply, label: string, colours: TerminalColours): HTMLElement {
    const region = made.edited ?? { start: 0, end: made.strip.length };
    const [from, to] = timesOf(made.strip, region.start, region.end);
    const clip = makeClip(context, {
      ref: made.ref,
      label,
      part: [Math.max(from - AROUND, 0), Math.min(to + AROUND, made.seconds)],
      lit: [from, to],
    });
    const ribbon = makeRibbon(clip.screen);
    ribbon.show(made, colours);
    clips.push(clip);
    ribbons.push(ribbon);
    return clip.element;
  }

  function corner(one: Alternative, number: number, colours: TerminalColours): HTMLElement {
    const text = one.region.join(" ") || "nothing";
    const playable = "not_playable" in one ? null : one;
    return h(
      "article",
      { class: playable ? "corner" : "corner not-playable", "aria-label": `Alternative ${number}: ${text}` },
      h("header.corner-head", { title: text }, h("b.corner-number", number), letters(one.region, colours)),
      playable
        ? player(playable, `Alternative ${number}: ${text}`, colours)
        : h("p.corner-reason", "Cannot be played: ", "not_playable" in one ? one.not_playable : ""),
      h(
        "footer.corner-foot",
        h(
          "span.muted.time",
          { title: "How often the grammar makes this string here" },
          `chance ${chanceText(one.log_probability)}`,
        ),
        playable
          ? button("main", "Choose", () => choose(playable), {
              title: `Choose alternative ${number} (${number})`,
              "aria-label": `Choose alternative ${number}: ${text}`,
              "data-alternative": number,
            })
          : null,
      ),
    );
  }

  return {
    element,
    show(alternatives: readonly Alternative[], colours: TerminalColours): void {
      clear();
      fill(
        element,
        alternatives.map((one, i) => corner(one, i + 1, colours)),
      );
    },
    /** A message instead of alternatives; an empty one removes everything. */
    say(text: string): void {
      clear();
      if (text) fill(element, h("p.corners-message", text));
    },
    /** While other alternatives are requested, those on screen cannot be chosen. */
    wait: () => void (element.inert = true),
    close: clear,
  };
}

export type Corners = ReturnType<typeof makeCorners>;
