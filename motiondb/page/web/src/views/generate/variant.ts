/** One generated motion: its player, the actions it shows, and the source of every stretch. */

import { post } from "../../api/client.ts";
import type { Motions } from "../../api/motions.ts";
import type { MadeReply } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { download, downloadButton, type FileFormat } from "../../parts/download.ts";
import { askToKeep, suggestedName } from "../../parts/keeping.ts";
import { sourceList } from "../../parts/sources.ts";
import { probability, seconds, sharedReason } from "../../parts/text.ts";
import type { Stage } from "../../player/stage.ts";
import { routeTo } from "../../shell/router.ts";
import { makeClip, type Clip } from "../../take/clip.ts";
import { stretchLane, wordLane, type Lane } from "../../timeline/lanes.ts";
import { makeTimeline } from "../../timeline/timeline.ts";
import type { Blocks } from "./blocks.ts";

export interface Variant {
  readonly element: HTMLElement;
  readonly clip: Clip;
  close(): void;
}

export interface VariantActions {
  fail(fault: unknown): void;
  notify(text: string): void;
  canSave: boolean;
  /** The blocks of the motion, which ask for a changed one. */
  blocks(made: MadeReply, seek: (time: number) => void): Blocks | null;
}

/** The requested actions, over the times at which they were made. */
export function askedLane(made: MadeReply): Lane {
  return {
    name: "asked",
    kind: "parts",
    blocks: made.shown_actions.map(({ words, start, end, shown }) => ({
      start,
      end,
      label: words.join(" "),
      title: `“${words.join(" ")}”, made from ${start.toFixed(2)} to ${end.toFixed(2)} s${shown === false ? "; not shown" : shown === null ? "; not sure" : ""}`,
      missing: shown === false,
      faint: shown === null,
    })),
  };
}

/** The verdicts; those of the first `said` actions stand on their blocks. */
function shownList(made: MadeReply, seek: (time: number) => void, said: number): HTMLElement {
  const verdicts = made.shown_actions.slice(said);
  const shared = sharedReason(verdicts);
  return h(
    "ul.plain.shown-list",
    { "aria-label": "Shown and not shown" },
    verdicts.map(({ words, start, end, probability: p, shown, reason }) =>
      h(
        "li",
        { class: shown ? "shown" : "not-shown" },
        h("span.mark", { "aria-hidden": "true" }, shown ? "✓" : shown === null ? "?" : "✕"),
        h(
          "span",
          h("b", words.join(" ")),
          shown ? " is shown" : shown === null ? " is not sure" : " is not shown",
          p === null ? "" : ` (${probability(p)})`,
          reason && reason !== shared ? `: ${reason}` : "",
          " ",
        ),
        button("time", `${start.toFixed(1)}–${end.toFixed(1)} s`, () => seek(start)),
      ),
    ),
    made.question.not_used.map(({ text, reason }) =>
      h(
        "li.not-shown",
        h("span.mark", { "aria-hidden": "true" }, "✕"),
        h("span", h("b", text), " is not shown: ", reason),
      ),
    ),
    shared ? h("li.muted.shared-reason", `Not sure: ${shared}.`) : null,
  );
}

export function makeVariant(
  context: { stage: Stage; motions: Motions },
  made: MadeReply,
  actions: VariantActions | null,
): Variant {
  const blocks = actions?.blocks(made, (time) => void clip.seek(time)) ?? null;
  const timeline = makeTimeline({
    duration: made.seconds,
    label: `Timeline of seed ${made.seed}`,
    small: true,
    top: blocks?.lane ?? null,
    onSeek: (time) => clip.seek(time),
  });
  const clip: Clip = makeClip(context, {
    ref: made.ref,
    label: `${made.words}, seed ${made.seed}`,
    onTime: (time) => timeline.setTime(time),
  });
  timeline.setLanes([
    ...(blocks ? [] : [askedLane(made)]),
    wordLane(made.recognised_words),
    stretchLane(made.stretches),
  ]);
  const saved = h("span");

  function showSaved(name: string): void {
    fill(saved, "kept as ", h("a", { href: routeTo("catalogue", { capture: name }) }, name));
  }

  async function run(work: Promise<unknown>): Promise<void> {
    try {
      await work;
    } catch (fault) {
      actions?.fail(fault);
    }
  }

  function askName(): void {
    const keep = async (name: string): Promise<void> => {
      const { capture } = await post("/api/made/save", { id: made.id, name });
      showSaved(capture);
      actions?.notify(`Kept as ${capture}.`);
    };
    askToKeep("Keep this motion", suggestedName(made.words, made.seed), keep);
  }

  async function saveAs(format: FileFormat): Promise<void> {
    await download([{ ref: made.ref }], format, format === "bvh" || format === "glb");
    if (format !== "bvh") return;
    const licences = [...new Set(made.sources.map((source) => source.licence || "not known"))].join("; ");
    actions?.notify(`Saved. A BVH file has no place for its licence, which is ${licences}.`);
  }

  const save = (format: FileFormat): void => void run(saveAs(format));
  if (made.saved) showSaved(made.saved);
  const element = h(
    "article.answer.variant",
    { "aria-label": `Seed ${made.seed}` },
    h(
      "header.answer-head",
      h("b", `seed ${made.seed}`),
      h("span.muted", `${made.method}, ${seconds(made.seconds)}`),
    ),
    clip.element,
    timeline.element,
    blocks?.tools,
    h(
      "div.answer-facts",
      shownList(made, (time) => clip.seek(time), blocks ? made.blocks.length : 0),
      sourceList(made.sources),
      actions
        ? h(
            "div.row.answer-actions",
            (["bvh", "glb"] as const).map((format) => downloadButton(format, save)),
            actions.canSave ? button("link", "Keep…", askName) : null,
            h("a.link", { href: routeTo("search", { like: made.ref }) }, "More like this"),
            saved,
          )
        : null,
    ),
  );
  return { element, clip, close: () => clip.close() };
}
