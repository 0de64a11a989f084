/** Values to filter by, with how many captures have each. */

import { makeLatest } from "../../api/latest.ts";
import { get } from "../../api/client.ts";
import type { FacetRow, FacetsReply } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { combine, type Pick } from "./filter.ts";

const SHOWN = 8;

export function makeFacets(toggle: (pick: Pick) => void) {
  const element = h("div.facets");
  const opened = new Set<string>();
  const latest = makeLatest();

  function group(facet: FacetRow, picks: readonly Pick[]): HTMLElement {
    const picked = (where: string): boolean =>
      picks.some((pick) => pick.column === facet.column && pick.where === where);
    const shown = opened.has(facet.column) ? facet.values : facet.values.slice(0, SHOWN);
    const rest = facet.values.length - shown.length;
    return h(
      "fieldset.facet",
      h("legend", facet.column),
      shown.map(({ value, count, where }) =>
        h(
          "label.facet-value",
          h("input", {
            type: "checkbox",
            checked: picked(where),
            on: { change: () => toggle({ column: facet.column, where }) },
          }),
          h("span.facet-name", { title: value }, value),
          h("span.count", count),
        ),
      ),
      rest > 0
        ? button("link", `${rest} more`, () => {
            opened.add(facet.column);
            void show();
          })
        : null,
      facet.more > 0 ? h("p.muted", `and ${facet.more} rarer`) : null,
    );
  }

  let last: { facets: FacetRow[]; picks: readonly Pick[] } | null = null;
  function show(): void {
    if (!last) return;
    const { facets, picks } = last;
    // A column with one value cannot narrow anything down; a selection can.
    const useful = facets.filter(
      ({ column, values }) =>
        values.length > 1 || column === "selection" || picks.some((pick) => pick.column === column),
    );
    fill(
      element,
      useful.map((facet) => group(facet, picks)),
    );
  }

  return {
    element,
    /** The columns and tags that are offered, with or without values to choose from. */
    columns: () => last?.facets.map(({ column }) => column) ?? [],
    async load(typed: string, picks: readonly Pick[]): Promise<void> {
      const ask = (without = ""): Promise<FacetsReply> =>
        get("/api/facets", { where: combine(typed, picks, without) });
      // A column with picks shows how many captures its other values have: its facets are requested
      // without its picks.
      const columns = [...new Set(picks.map((pick) => pick.column))];
      const [all, ...own] = await latest(Promise.all([ask(), ...columns.map(ask)]));
      const facets = all!.facets.map((facet) => {
        const at = columns.indexOf(facet.column);
        return at < 0 ? facet : (own[at]!.facets.find((one) => one.column === facet.column) ?? facet);
      });
      last = { facets, picks };
      show();
    },
  };
}
