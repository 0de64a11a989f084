/** The learned grammars, and the job that learns one. */

import { cancelJob, failureOf, isActive, stepOf } from "../../api/jobs.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { progressBar } from "../../parts/progress.ts";
import { emptyState, faultState } from "../../parts/states.ts";
import { seconds } from "../../parts/text.ts";
import { emptyDatabase } from "../empty_database.ts";
import { routeTo } from "../../shell/router.ts";
import type { Context } from "../view.ts";
import type { ListedGrammar } from "../../api/types.ts";

/** Failed jobs whose message was closed. */
const closed = new Set<string>();

const COLUMNS: readonly [string, (row: ListedGrammar) => string][] = [
  ["captures", (row) => String(row.captures)],
  ["length", (row) => seconds(row.seconds)],
  ["segments", (row) => String(row.segments)],
  ["terminals", (row) => String(row.terminals)],
  ["sentences", (row) => String(row.sentences)],
  ["rules", (row) => String(row.rules)],
  ["bits", (row) => row.bits["sum"]!.toFixed(0)],
  ["new sentences", (row) => (row.derives_new ? "yes" : "no: it only repeats")],
];

function tableOf(rows: readonly ListedGrammar[]): HTMLElement {
  return h(
    "div.grammar-table",
    h(
      "table",
      h("caption.visually-hidden", "Grammars of this database"),
      h(
        "thead",
        h(
          "tr",
          h("th", { scope: "col" }, "grammar"),
          COLUMNS.map(([title]) => h("th", { scope: "col" }, title)),
        ),
      ),
      h(
        "tbody",
        rows.map((row) =>
          h(
            "tr",
            h(
              "th",
              { scope: "row" },
              h("a", { href: routeTo("grammar", { name: row.grammar }) }, row.grammar),
            ),
            COLUMNS.map(([, text]) => h("td", text(row))),
          ),
        ),
      ),
    ),
  );
}

/** What the user can do in a database without grammars. */
function nothingYet(context: Context, learn: () => void): HTMLElement {
  const status = context.status();
  if (status.captures === 0) return emptyDatabase(context);
  const text =
    "A grammar is the syntax of long takes: which movements follow which. It makes new sequences that obey the same rules.";
  if (status.read_only) return emptyState("No grammars", `${text} This database was opened read-only.`);
  return emptyState("No grammars yet", text, [{ label: "Learn a grammar…", run: learn }]);
}

/** The list, or why it is empty. */
export function grammarList(
  context: Context,
  rows: readonly ListedGrammar[],
  learn: () => void,
): HTMLElement | null {
  if (rows.length === 0) return nothingYet(context, learn);
  return h(
    "div.grammar-list",
    h(
      "div.row",
      h("p.summary", "Grammars of long takes. Choose one to make sequences with it."),
      context.status().read_only ? null : button("main", "Learn a grammar…", learn),
    ),
    tableOf(rows),
    context.status().learned
      ? null
      : h("p.muted.small", "This database has not learned words, so the terminals have letters only."),
  );
}

/** The newest job that learns a grammar: how far it is, or why it failed. */
export function jobState(host: HTMLElement, context: Context): void {
  const job = context.live.jobs().find((one) => one.kind === "grammar");
  if (!job || closed.has(job.id) || (job.state !== "failed" && !isActive(job))) return fill(host);
  if (job.state === "failed") {
    const close = (): void => {
      closed.add(job.id);
      fill(host);
    };
    const message = `${job.title}: ${failureOf(job)}`;
    return fill(host, faultState(message, [{ label: "Close", run: close, plain: true }]));
  }
  const cancel = (): void => void cancelJob(job);
  fill(
    host,
    h(
      "div.grammar-job",
      h("b", job.title),
      progressBar(job.state === "waiting" ? null : job.share, stepOf(job)),
      button("plain", "Cancel", cancel),
    ),
  );
}
