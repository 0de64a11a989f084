/** What a view shows for a question that cannot be asked: why, and the words that are known. */

import { ApiError, get, messageOf } from "../api/client.ts";
import { button } from "../dom/button.ts";
import { fill, h } from "../dom/element.ts";
import { faultState } from "../parts/states.ts";

/** The near words at the end of the server's sentence. */
const NEAR = / Perhaps ([^.]+)\.$/;

/** Words that are shown; more would be a list to read. Chosen by hand. */
const MOST = 24;

/** The fault; where no word of a question is known, also known words to choose from. */
export function faultWithWords(fault: unknown, choose: (word: string) => void): HTMLElement {
  if (!(fault instanceof ApiError && fault.kind === "UnknownWordsError")) return faultState(messageOf(fault));
  const words = h("div.known-words");
  void get("/api/vocabulary").then(
    (answer) => {
      if (answer.words.length === 0) return;
      fill(
        words,
        h("p.muted", "Words that this database knows, the commonest first:"),
        h(
          "div.row",
          answer.words.slice(0, MOST).map(({ word }) => button("plain", word, () => choose(word))),
        ),
      );
    },
    () => undefined, // the fault stands there
  );
  const message = messageOf(fault);
  const near = NEAR.exec(message)?.[1]?.split(" or ") ?? [];
  const choices = near.map((word, i) => [
    i > 0 ? " or " : " Perhaps ",
    button("link", word, () => choose(word)),
  ]);
  return h(
    "div",
    h(
      "div.verdict.not-here",
      { role: "alert" },
      h("p", message.replace(NEAR, ""), choices, near.length > 0 ? "." : ""),
    ),
    words,
  );
}
