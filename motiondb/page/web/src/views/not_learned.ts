/** The message of a view in a database that has not learned. */

import { ApiError, messageOf } from "../api/client.ts";
import { isActive } from "../api/jobs.ts";
import { h } from "../dom/element.ts";
import { emptyState } from "../parts/states.ts";
import { openLearning } from "./catalogue/learning.ts";
import { emptyDatabase, withJobs } from "./empty_database.ts";
import type { Context } from "./view.ts";

/** The state for a fault that says "not learned"; null for another fault. `null`: no fault, show it. */
export function notLearned(fault: unknown, context: Context): HTMLElement | null {
  if (fault !== null && !(fault instanceof ApiError && fault.kind === "NotLearnedError")) return null;
  if (context.status().captures === 0) return emptyDatabase(context);
  if (context.status().read_only) {
    return emptyState("Nothing learned yet", "This database has not learned, and it was opened read-only.");
  }
  const wordless = context.status().captures_with_words === 0;
  const state = emptyState(
    context.status().learned ? "No words learned yet" : "Nothing learned yet",
    [
      wordless
        ? "Nobody has written about these captures. Learning can start from words that were learned from captures of others; then questions in words are answered."
        : "Learning finds the movements in the captures and the meanings of words. It takes from seconds to minutes.",
      fault === null ? null : h("span.server-said", messageOf(fault)),
    ],
    [{ label: "Learn…", run: () => openLearning(context) }],
  );
  const isLearning = (): boolean =>
    context.live.jobs().some((job) => ["learn", "sample"].includes(job.kind) && isActive(job));
  return withJobs(context, () =>
    isLearning() ? emptyState("Learning…", "What was asked is answered here when it is done.") : state,
  );
}
