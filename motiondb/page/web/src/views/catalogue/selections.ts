/** The selections that the database keeps: what each holds, to be played, taken out and downloaded. */

import { makeLatest } from "../../api/latest.ts";
import { bytes, get, post, remove } from "../../api/client.ts";
import type { CapturesChanged, PlayablePart, SelectionRow } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { icon } from "../../dom/icons.ts";
import { downloadMenu, saveBlob, type FileFormat } from "../../parts/download.ts";
import { tellChanged } from "../../parts/selecting.ts";
import { emptyState, showFault } from "../../parts/states.ts";
import { interval, plural, seconds } from "../../parts/text.ts";
import { routeTo } from "../../shell/router.ts";
import type { Context } from "../view.ts";
import { quoted } from "./filter.ts";

export function makeSelections(context: Context) {
  const opened = new Set<string>();
  const canWrite = !context.status().read_only;
  const latest = makeLatest();
  /** The selection whose head takes the focus after it was changed. */
  let changed = "";

  async function change(name: string, text: string, request: Promise<CapturesChanged>): Promise<void> {
    changed = name;
    try {
      await tellChanged(context, text, await request);
    } catch (fault) {
      changed = "";
      context.fail(fault);
    }
  }

  async function save(name: string, format: FileFormat): Promise<void> {
    const data = await bytes("/api/selection/pack", { name, format });
    saveBlob(`${name}.zip`, new Blob([data], { type: "application/zip" }));
  }

  function partRow(name: string, part: PlayablePart): HTMLElement {
    const { ref, capture, whole } = part;
    const [start, end] = [part.start, part.end];
    const when = whole ? "whole" : interval(start, end);
    const place = whole ? {} : { start: start.toFixed(3), end: end.toFixed(3) };
    const take = (): void =>
      void change(
        name,
        `${capture} is taken out of “${name}”.`,
        post("/api/selection/take", { name, items: [{ ref, start, end }] }),
      );
    return h(
      "li.selected-part",
      h("a", { href: routeTo("catalogue", { show: "selections", capture, ...place }) }, capture),
      h("span.muted", when),
      h("span.muted.small", `licence ${part.licence}`),
      canWrite
        ? button("tool", icon("close"), take, {
            "aria-label": `Take ${capture}, ${when}, out of ${name}`,
            title: "Take out",
          })
        : null,
    );
  }

  async function fillParts(list: HTMLElement, name: string): Promise<void> {
    try {
      const { parts } = await get("/api/selection", { name });
      fill(
        list,
        parts.map((part) => partRow(name, part)),
      );
    } catch (fault) {
      showFault(list, fault);
    }
  }

  function section(row: SelectionRow): HTMLElement {
    const name = row.selection;
    const list = h("ul.plain");
    const about = `${plural(row.parts, "part")} of ${plural(row.captures, "capture")}, ${seconds(row.seconds)}`;
    const summary = h("summary", h("strong", name), " ", h("span.muted", about));
    const forget = (): void =>
      void change(name, `“${name}” is removed; its captures stay.`, remove("/api/selection", { name }));
    const details = h(
      "details.kept-selection",
      { open: opened.has(name) },
      summary,
      h(
        "div.row",
        h(
          "a.button.plain",
          { href: routeTo("catalogue", { where: `selection=${quoted(name)}` }) },
          "Filter by it",
        ),
        downloadMenu("Download", context.status().writes, (format) => void save(name, format)),
        canWrite ? button("plain", "Remove selection", forget) : null,
      ),
      list,
    );
    const load = (): void => {
      if (details.open) opened.add(name);
      else opened.delete(name);
      if (details.open && list.childElementCount === 0) void fillParts(list, name);
    };
    details.addEventListener("toggle", load);
    if (details.open) load();
    return details;
  }

  return {
    /** Show them in an element, now and when the database has changed. */
    async show(host: HTMLElement): Promise<void> {
      try {
        const { selections } = await latest(get("/api/selections"));
        if (selections.length === 0) {
          const how =
            "Select captures here or answers of a search, then “Add to a selection…” in the bar at the bottom.";
          fill(host, emptyState("No selections", how));
          return;
        }
        if (selections.length === 1) opened.add(selections[0]!.selection);
        fill(host, h("h2.hidden-heading", "Selections"), selections.map(section));
        const at = selections.findIndex((row) => row.selection === changed);
        if (at >= 0) host.querySelectorAll<HTMLElement>(".kept-selection > summary")[at]?.focus();
        changed = "";
      } catch (fault) {
        showFault(host, fault);
      }
    },
  };
}

export type Selections = ReturnType<typeof makeSelections>;
