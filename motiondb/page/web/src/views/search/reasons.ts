/** Why an answer was found, word by word: the numbers of `--explain` as bars. */

import type { ExplainedWord, Explanation } from "../../api/types.ts";
import { h } from "../../dom/element.ts";
import { signed } from "../../parts/text.ts";

export interface ReasonRow {
  label: string;
  amount: number;
  detail: string;
}

/** Numbers have three digits, as on the command line, so that the shown numbers add up. */
const nats = (value: number): string => signed(value, 3);

/** The terms of the contribution of a word; terms of zero are left out. */
function partsOf(word: ExplainedWord): string {
  return [
    `usual ${nats(word.prior)}`,
    word.written === 0 ? "" : `written ${nats(word.written)}`,
    word.likeness === 0 ? "" : `likeness ${nats(word.likeness)}`,
    ...word.strongest.map(
      ({ symbol, from, to, share }) =>
        `symbol ${symbol} ${nats(share)} (${from.toFixed(1)}–${to.toFixed(1)} s)`,
    ),
    Math.abs(word.others) < 0.0005 ? "" : `others ${nats(word.others)}`,
  ]
    .filter(Boolean)
    .join(", ");
}

/** Rows that add up to the log-odds of the answer. */
export function reasonRows(explanation: Explanation): ReasonRow[] {
  const rows = explanation.words.map((word) => ({
    label: word.word,
    amount: word.contribution,
    detail: partsOf(word),
  }));
  if (explanation.together !== 0) {
    rows.push({
      label: "together",
      amount: explanation.together,
      detail: "how the parts of the question fit together",
    });
  }
  for (const one of explanation.excluded) {
    const words = one.words.map((word) => `${word.word} ${nats(word.contribution)} = ${partsOf(word)}`);
    rows.push({
      label: `not ${one.words.map(({ word }) => word).join(" ")}`,
      amount: one.amount,
      detail: `as its log-odds are ${nats(one.log_odds)}: ${words.join("; ")}`,
    });
  }
  return rows;
}

export function reasonsElement(explanation: Explanation): HTMLElement {
  const rows = reasonRows(explanation);
  const largest = Math.max(...rows.map((row) => Math.abs(row.amount)), 1);
  return h(
    "table.reasons",
    h(
      "caption",
      `What speaks for it (+) and against it (−). The rows add up to the log-odds ${nats(explanation.log_odds)}. Usual: before its motion is looked at; written: its captions say it; likeness: to the captions nearest to its motion; symbol: one of its movements.`,
    ),
    h(
      "tbody",
      rows.flatMap((row) => {
        const bar = h("span", { class: row.amount < 0 ? "reason-bar against" : "reason-bar" });
        bar.style.width = `${(Math.abs(row.amount) / largest) * 100}%`;
        return [
          h(
            "tr",
            h("th", { scope: "row" }, row.label),
            h("td.number-cell", nats(row.amount)),
            h("td.reason-cell", bar),
          ),
          h("tr", h("td.reason-detail", { colspan: 3 }, row.detail)),
        ];
      }),
      explanation.suggests.length
        ? h(
            "tr",
            h(
              "td.reason-detail",
              { colspan: 3 },
              `Captions nearest to its motion: ${explanation.suggests.join("; ")}.`,
            ),
          )
        : null,
    ),
  );
}
