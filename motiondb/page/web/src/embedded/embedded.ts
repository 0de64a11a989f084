/** A page without a server: the answers and motions are inside the file. */

import { embeddedMotions } from "../api/motions.ts";
import { fromBase64 } from "../api/container.ts";
import { fill, h } from "../dom/element.ts";
import { emptyState } from "../parts/states.ts";
import { makeStage } from "../player/stage.ts";
import { renderAnswer, type EmbeddedContext } from "./answers.ts";

export interface Embedded {
  format: number;
  kind: "search" | "like" | "generate" | "capture" | "sequence" | "scene";
  title: string;
  version: string;
  database: string;
  answer: unknown;
  motions: Record<string, string>;
}

/** Show the data of the file. */
export function startEmbedded(root: HTMLElement, text: string): void {
  let data: Embedded;
  try {
    data = JSON.parse(text) as Embedded;
    if (data.format !== 1) throw new Error(`format ${data.format}`);
  } catch {
    fill(
      root,
      h(
        "main.centre",
        emptyState("This file cannot be shown", "Its data is damaged, or it was made by a newer motiondb."),
      ),
    );
    return;
  }
  const containers = new Map(
    Object.entries(data.motions).map(([ref, base64]) => [ref, () => fromBase64(base64)]),
  );
  const context: EmbeddedContext = { stage: makeStage(), motions: embeddedMotions(containers), data };
  document.title = `${data.title} · motiondb`;
  const host = h("main.view.embedded", { id: "view" });
  fill(
    root,
    h(
      "header.top",
      h("span.brand", h("span.brand-mark", { "aria-hidden": "true" }), "motiondb"),
      h("span.database", data.database),
    ),
    host,
    h(
      "footer.foot",
      `Made with motiondb ${data.version}. Captures keep the licences that are shown with them.`,
    ),
  );
  fill(host, h("h1", data.title));
  renderAnswer(host, context);
}
