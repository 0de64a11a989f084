/** Why an answer was found, word by word: the numbers of `--explain` as bars. */

import type { ExplainedWord, Explanation } from "../../api/types.ts";
import { h } from "../../dom/element.ts";
import { plural, signed } from "../../parts/text.ts";

export interface ReasonRow {
  label: string;
  amount: number;
  detail: string;
}

/** Symbols that are listed one by one; the others of a word are added up. */
const LISTED = 4;

function partsOf(word: ExplainedWord): string {
  const ordered = [...word.symbols].sort((a, b) => Math.abs(b.share) - Math.abs(a.share));
  const symbols = ordered
    .slice(0, LISTED)
    .map(
      ({ symbol, from, to, share }) =>
        `symbol ${symbol} ${signed(share)} (${from.toFixed(1)}–${to.toFixed(1)} s)`,
    );
  const rest = ordered.slice(LISTED);
  if (rest.length > 0) {
    const sum = rest.reduce((total, { share }) => total + share, 0);
    symbols.push(`${plural(rest.length, "other segment")} ${signed(sum)}`);
  }
  return [`usual ${signed(word.prior)}`, `written ${signed(word.written)}`, ...symbols].join(", ");
}

/** Rows that add up to the log-odds of the answer. */
export function reasonRows(explanation: Explanation): ReasonRow[] {
  const rows = explanation.words.map((word) => ({
    label: word.word,
    amount: word.contribution,
    detail: partsOf(word),
  }));
  if (Math.abs(explanation.together) >= 0.005) {
    rows.push({
      label: "together",
      amount: explanation.together,
      detail: "how the parts of the question fit together",
    });
  }
  for (const one of explanation.excluded) {
    rows.push({
      label: `not ${one.words.map(({ word }) => word).join(" ")}`,
      amount: one.amount,
      detail: one.words.map((word) => `${word.word}: ${partsOf(word)}`).join("; "),
    });
  }
  return rows;
}

export function reasonsElement(explanation: Explanation): HTMLElement {
  const rows = reasonRows(explanation);
  const largest = Math.max(...rows.map((row) => Math.abs(row.amount)), 1);
  return h(
    "table",
    { class: "reasons" },
    h("caption", {}, `Evidence in log-odds (nats); together ${signed(explanation.log_odds)}`),
    h(
      "tbody",
      {},
      rows.map((row) => {
        const bar = h("span", { class: row.amount < 0 ? "reason-bar against" : "reason-bar" });
        bar.style.width = `${(Math.abs(row.amount) / largest) * 100}%`;
        return h(
          "tr",
          {},
          h("th", { scope: "row" }, row.label),
          h("td", { class: "number-cell" }, signed(row.amount)),
          h("td", { class: "reason-cell" }, bar, h("span", { class: "reason-detail" }, row.detail)),
        );
      }),
    ),
  );
}
