/** The captures that a generated motion was made from, with their licences. */

import type { Source } from "../api/types.ts";
import { h } from "../dom/element.ts";

export function sourceList(sources: readonly Source[]): HTMLElement {
  return h(
    "details.why",
    h("summary", `Sources and licences (${sources.length})`),
    h(
      "ul.plain",
      sources.map((one) =>
        h("li", one.capture, h("span.muted", ` ${one.frames} frames, licence ${one.licence}`)),
      ),
    ),
  );
}
