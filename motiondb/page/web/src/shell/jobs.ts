/** Long work: a button that shows how much is running, and the list behind it. */

import { onPage } from "../api/advice.ts";
import { cancelJob, failureOf, isActive, stepOf } from "../api/jobs.ts";
import type { JobReply } from "../api/types.ts";
import { button } from "../dom/button.ts";
import { icon } from "../dom/icons.ts";
import { fill, h } from "../dom/element.ts";
import type { Context } from "../views/view.ts";
import { plural, roughly } from "../parts/text.ts";
import { go, routeTo } from "./router.ts";
import { quoted } from "../views/catalogue/filter.ts";
import { openLearning } from "../views/catalogue/learning.ts";
import { progressBar } from "../parts/progress.ts";

/** The share of the whole job that is done; of its present step where only that is known. */
const shareOf = (job: JobReply): number => job.whole ?? job.share;

/** The present step, and the time that is left. */
function saidOf(job: JobReply): string {
  const left = job.left === null || job.left === undefined ? "" : ` · about ${roughly(job.left)} left`;
  return `${stepOf(job)}${left}`;
}

/** One sentence on what a job did. */
export function outcome(job: JobReply): string {
  const { result } = job;
  if (job.state === "failed") return failureOf(job);
  if (job.state === "cancelled")
    return job.kind === "sample"
      ? "Cancelled. Captures that were added stay."
      : "Cancelled. The database stays as it was.";
  if (result?.kind === "add") {
    const problems = result.problems.length;
    const broken = problems ? `, ${problems} ${problems === 1 ? "problem" : "problems"}` : "";
    return `${result.added} added${result.known > 0 ? `, ${result.known} already there` : ""}${broken}.`;
  }
  if (result?.kind === "learn") {
    const from = result.start ? ` Started from ${result.start}.` : "";
    const none =
      result.words === 0
        ? " Questions in words cannot be answered yet: nobody has written about these captures."
        : "";
    return `Learned from ${plural(result.captures, "capture")}: ${plural(result.symbols, "kind")} of movement, ${plural(result.words, "word")}.${from}${none}`;
  }
  if (result?.kind === "grammar") {
    const lost = result.no_longer_editable;
    const gone = lost.length ? ` No longer editable: ${lost.join(", ")}.` : "";
    return `Learned.${gone}`;
  }
  return job.message ?? "Done.";
}

/** Captures that are linked one by one; of more, the newest are shown in the catalogue. */
const MOST_LINKS = 12;

/** The address of what a job added: its captures, or the newest ones where they are many. */
function addedAddress(job: JobReply): string | null {
  const names = job.result?.kind === "add" ? job.result.captures : [];
  if (names.length === 0) return null;
  return names.length <= MOST_LINKS
    ? routeTo("catalogue", { where: `name in (${names.map(quoted).join(", ")})` })
    : routeTo("catalogue", { sort: "-added" });
}

/** What the address shows: exactly these, or the catalogue with the newest first. */
const sayShow = (names: readonly string[]): string =>
  names.length > MOST_LINKS ? "Show the newest" : "Show them";

function addedList(job: JobReply): HTMLElement | null {
  const address = addedAddress(job);
  if (!address || job.result?.kind !== "add") return null;
  const names = job.result.captures;
  return h(
    "p.job-added",
    names
      .slice(0, MOST_LINKS)
      .map((name, i) => [i > 0 ? ", " : "", h("a", { href: routeTo("catalogue", { capture: name }) }, name)]),
    ". ",
    h("a", { href: address }, sayShow(names)),
  );
}

function problemList(job: JobReply): HTMLElement | null {
  const problems = job.result?.kind === "add" ? job.result.problems : [];
  if (problems.length === 0) return null;
  const items = problems.map((problem) => h("li", onPage(problem)));
  return h("details", { open: true }, h("summary", plural(problems.length, "problem")), h("ul.plain", items));
}

/** The part of the header that shows jobs. */
export function makeJobs(context: Context): { element: HTMLElement } {
  const count = h("span");
  const opener = h(
    "button.jobs-button",
    {
      type: "button",
      "aria-expanded": "false",
      "aria-controls": "jobs",
      on: { click: () => toggle() },
    },
    count,
  );
  const panel = h("section.jobs-panel", { id: "jobs", "aria-label": "Jobs", hidden: true });
  const element = h("div.jobs", { hidden: true }, opener, panel);

  function toggle(open = panel.hidden): void {
    panel.hidden = !open;
    opener.setAttribute("aria-expanded", String(open));
  }

  function row(job: JobReply): HTMLElement {
    const active = isActive(job);
    return h(
      "li",
      { class: `job ${job.state}` },
      h(
        "div.job-head",
        h("b", job.title),
        h("span.muted", active ? job.state : `${job.state} · ${job.seconds.toFixed(0)} s`),
      ),
      active ? progressBar(job.state === "waiting" ? null : shareOf(job), saidOf(job)) : h("p", outcome(job)),
      addedList(job),
      problemList(job),
      active ? button("link", "Cancel", () => void cancelJob(job)) : null,
    );
  }

  function show(): void {
    const jobs = context.live.jobs();
    const active = jobs.filter(isActive);
    element.hidden = jobs.length === 0;
    opener.classList.toggle("active", active.length > 0);
    const first = active[0];
    const done = first?.state === "waiting" ? "waits" : `${Math.round(100 * (first ? shareOf(first) : 0))} %`;
    const more = active.length > 1 ? ` +${active.length - 1}` : "";
    const title = first ? first.title : "Jobs";
    const short = first ? done + more : `(${jobs.length})`;
    // In a narrow head the number of ended jobs would stand alone.
    fill(count, first ? null : icon("more"), h("span.wide-only", `${title} `), short);
    opener.title = `${title} ${short}`;
    fill(panel, h("ul.plain", jobs.slice(0, 20).map(row)));
  }

  const running = new Set<string>();
  context.live.listen((news) => {
    if (news.kind === "forgotten") {
      const lost = news.jobs.filter((id) => running.delete(id)).length;
      if (lost > 0) context.notify("The server was started again; the work that was going on has ended.");
      return show();
    }
    if (news.kind !== "job") return;
    show();
    const { job } = news;
    if (isActive(job)) running.add(job.id);
    else if (running.delete(job.id)) {
      if (job.state === "failed") context.fail(new Error(`${job.title}: ${outcome(job)}`));
      // The board shows the scene that follows a dragged player: no word at every drag.
      else if (job.kind !== "scene-update") {
        const wordless = job.result?.kind === "learn" && job.result.words === 0;
        const cure = { label: "Learn words of others…", run: () => openLearning(context) };
        const about = job.kind === "learn" ? "" : `${job.title}: `;
        const address = addedAddress(job);
        const added = job.result?.kind === "add" ? job.result.captures : [];
        const show = address ? { label: sayShow(added), run: () => go(address) } : undefined;
        const problems = job.result?.kind === "add" && job.result.problems.length > 0;
        const named = { label: "Show the problems", run: () => setTimeout(() => toggle(true)) };
        context.notify(`${about}${outcome(job)}`, wordless ? cure : problems ? named : show);
      }
      void context.refresh();
    }
  });
  addEventListener("keydown", (event) => event.key === "Escape" && toggle(false));
  addEventListener("pointerdown", (event) => {
    if (!element.contains(event.target as Node)) toggle(false);
  });
  return { element };
}
