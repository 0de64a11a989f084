/** Questions to begin with. */

import { get } from "../../api/client.ts";
import type { Context } from "../view.ts";

/**
 * Questions to begin with, and what is known of them: they find something here, or their words are
 * in the captions, or they were learned from captures of others.
 */
export async function offeredQuestions(
  context: Context,
): Promise<{ lead: string; questions: readonly string[] }> {
  const { examples, words } = await get("/api/examples");
  if (examples.length > 0)
    return { lead: "Found here, for example", questions: examples.map((one) => one.question) };
  const own = context.status().captures_with_words > 0;
  return { lead: own ? "Words of its captions" : "Words that it knows", questions: words };
}
