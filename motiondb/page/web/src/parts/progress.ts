/** A progress bar with a word about the present step. */

import { h } from "../dom/element.ts";

/** `share` between 0 and 1; null: not known. */
export function progressBar(share: number | null, what: string): HTMLElement {
  const percent = share === null ? null : Math.round(Math.min(Math.max(share, 0), 1) * 100);
  return h(
    "div.progress",
    h("progress", { max: 100, "aria-label": what, ...(percent === null ? {} : { value: percent }) }),
    h("span.progress-what", percent === null ? what : `${what} · ${percent} %`),
  );
}
