/** Grammars: learn them, see their rules, make sequences with them, edit these through their trees. */

import { showFault } from "../../parts/states.ts";
import { makeLatest } from "../../api/latest.ts";
import { get, isAbort, post, remove } from "../../api/client.ts";
import { fill, h } from "../../dom/element.ts";
import { askWhether } from "../../parts/asking.ts";
import { amend, go, goOn, rewrite, routeTo } from "../../shell/router.ts";
import type { Context, OpenView } from "../view.ts";
import { addressOf, routeOf } from "./address.ts";
import { makeEditor } from "./editor.ts";
import { makeFacts, summaryOf } from "./facts.ts";
import { openGrammarLearning } from "./learn.ts";
import { grammarList, jobState } from "./list.ts";
import { makeMaker } from "./maker.ts";
import type { GrammarReply } from "../../api/types.ts";
import type { Wish } from "./selection.ts";

export function open(host: HTMLElement, context: Context): OpenView {
  let route = routeOf(new URLSearchParams());
  let facts: GrammarReply | null = null;
  const latest = makeLatest();
  let learning = "";

  const job = h("div", { "aria-live": "polite" });
  const list = h("div");
  const one = h("div.grammar-one", { hidden: true });
  const heading = h("div.row.grammar-head");
  const making = h("div", { "aria-live": "polite" });
  const panel = makeFacts(context);
  const rules = h("details.grammar-rest", h("summary", "Rules and terminals"), panel.element);
  const maker = makeMaker((wish) => void make(wish));
  const editor = makeEditor(context, {
    sequence: (id) => go(addressOf({ ...route, sequence: id, selection: null })),
    region: (selection, tree) => {
      route = { ...route, selection, tree };
      rewrite(addressOf(route));
    },
  });
  fill(host, h("h1.hidden-heading", "Grammars"), job, list, one);
  fill(one, heading, maker.element, making, editor.element, rules);

  function learn(): void {
    openGrammarLearning(context, (started) => {
      learning = started.id;
      jobState(job, context);
    });
  }

  async function showList(): Promise<void> {
    one.hidden = true;
    list.hidden = false;
    try {
      const { grammars } = await latest(get("/api/grammars"));
      fill(list, grammarList(context, grammars, learn));
    } catch (fault) {
      showFault(list, fault);
    }
  }

  async function forget(name: string): Promise<void> {
    const sure = await askWhether(
      `Remove the grammar ${name}?`,
      "Sequences that were kept stay as captures, but they can no longer be edited. This cannot be undone.",
      "Remove",
    );
    if (!sure) return;
    await remove("/api/grammar", { name });
    context.notify(`The grammar ${name} is removed.`);
    go(routeTo("grammar"));
  }

  function showHeading(known: GrammarReply): void {
    const remove = (): void => void forget(known.grammar);
    fill(
      heading,
      h("a", { href: routeTo("grammar") }, "Grammars"),
      h("span.muted", { "aria-hidden": "true" }, "/"),
      h("h2", known.grammar),
      h("span.muted.small", summaryOf(known)),
      context.status().read_only
        ? null
        : h("button.link.danger.small", { type: "button", on: { click: remove } }, "Remove…"),
    );
  }

  /** Request the facts of a grammar; false if the request failed. */
  async function load(name: string): Promise<boolean> {
    try {
      const known = await latest(get("/api/grammar", { name }));
      facts = known;
      showHeading(known);
      panel.show(known);
      return true;
    } catch (fault) {
      if (isAbort(fault)) return false;
      facts = null;
      showMissing(fault);
      return false;
    }
  }

  async function make(wish: Wish): Promise<void> {
    maker.busy(true);
    making.replaceChildren();
    try {
      const made = await post("/api/sequences", { grammar: route.name, ...wish });
      goOn(addressOf({ ...route, wish, sequence: made.id, selection: null }));
    } catch (fault) {
      showFault(making, fault);
    } finally {
      maker.busy(false);
    }
  }

  /** Open a kept sequence; the answer names its grammar. */
  async function openKept(capture: string): Promise<void> {
    try {
      const kept = await post("/api/sequences/open", { capture });
      amend(addressOf({ ...route, name: kept.grammar, sequence: kept.id, selection: null }));
    } catch (fault) {
      showMissing(fault);
    }
  }

  /** Say why a grammar is not shown, in the place of the list. */
  function showMissing(fault: unknown): void {
    one.hidden = true;
    list.hidden = false;
    showFault(list, fault, [{ label: "All grammars", run: () => go(routeTo("grammar")) }]);
  }

  async function showOne(): Promise<void> {
    const { name, sequence, selection, tree, wish } = route;
    if (facts?.grammar !== name && !(await load(name))) return;
    list.hidden = true;
    one.hidden = false;
    maker.show(wish);
    editor.element.hidden = !sequence;
    rules.open = !sequence;
    making.replaceChildren();
    if (sequence && facts) await editor.open(sequence, selection, tree, facts);
    else editor.rest();
  }

  return {
    update(parameters) {
      route = routeOf(parameters);
      jobState(job, context);
      if (route.open) void openKept(route.open);
      else if (route.name) void showOne();
      else void showList();
    },
    news(news) {
      if (news.kind === "revision" && !route.name && !route.open) void showList();
      if (news.kind === "revision" && facts) void load(facts.grammar);
      if (news.kind !== "job" || news.job.kind !== "grammar") return;
      jobState(job, context);
      const { result } = news.job;
      if (news.job.id !== learning || result?.kind !== "grammar") return;
      learning = "";
      goOn(routeTo("grammar", { name: result.grammar }));
    },
    close() {
      void latest();
      panel.close();
      editor.close();
    },
  };
}
