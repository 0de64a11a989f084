/** Groups of captures that are copies, cuts or mirror images of one another. */

import { get } from "../../api/client.ts";
import { fill, h } from "../../dom/element.ts";
import { emptyState, showFault } from "../../parts/states.ts";
import { interval, plural } from "../../parts/text.ts";
import { routeTo } from "../../shell/router.ts";

const KINDS: Record<string, string> = {
  cut: "is a cut of",
  mirror: "is a mirror image of",
  same: "is the same take as",
};

export async function showDuplicates(host: HTMLElement): Promise<void> {
  fill(host, h("p.muted", "Searching for copies…"));
  try {
    const { groups } = await get("/api/duplicates");
    if (groups.length === 0) {
      fill(
        host,
        emptyState("No copies", "No capture of this database is a copy, a cut or a mirror image of another."),
      );
      return;
    }
    fill(
      host,
      h(
        "p.lead",
        `${plural(groups.length, "group")} of captures that show the same motion. The first of each group is the longest.`,
      ),
      groups.map((group) =>
        h(
          "section.duplicate-group",
          h("h3", link(group.captures[0]!)),
          h(
            "ul.plain",
            group.relations.map((one) =>
              h(
                "li",
                link(one.capture),
                ` ${KINDS[one.kind] ?? one.kind} `,
                link(one.other),
                h("span.muted", ` (${interval(one.start, one.end)})`),
              ),
            ),
          ),
        ),
      ),
    );
  } catch (fault) {
    showFault(host, fault);
  }
}

function link(name: string): HTMLElement {
  return h("a", { href: routeTo("catalogue", { show: "duplicates", capture: name }) }, name);
}
