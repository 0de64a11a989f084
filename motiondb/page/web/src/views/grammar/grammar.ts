/** Grammars: learn them, see their rules, make sequences with them, edit these through their trees. */

import { get, messageOf, post, remove } from "../../api/client.ts";
import { fill, h } from "../../dom/element.ts";
import { askWhether } from "../../parts/asking.ts";
import { faultState } from "../../parts/states.ts";
import { amend, go, goOn, rewrite, routeTo } from "../../shell/router.ts";
import type { Context, OpenView } from "../view.ts";
import { addressOf, routeOf } from "./address.ts";
import { makeEditor } from "./editor.ts";
import { makeFacts, summaryOf } from "./facts.ts";
import { openGrammarLearning } from "./learn.ts";
import { grammarList, jobState } from "./list.ts";
import { makeMaker } from "./maker.ts";
import type { GrammarReply, GrammarsReply, SequenceReply } from "../../api/types.ts";
import type { Wish } from "./selection.ts";

export function open(host: HTMLElement, context: Context): OpenView {
  let route = routeOf(new URLSearchParams());
  let facts: GrammarReply | null = null;
  let loads = 0;
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
    loads += 1;
    const mine = loads;
    try {
      const { grammars } = await get<GrammarsReply>("/api/grammars");
      if (mine === loads) fill(list, grammarList(context, grammars, learn));
    } catch (fault) {
      if (mine === loads) fill(list, faultState(messageOf(fault)));
    }
  }

  async function forget(name: string): Promise<void> {
    const sure = await askWhether(
      `Remove the grammar ${name}?`,
      "Sequences that were kept stay as captures, but they can no longer be edited. This cannot be undone.",
      "Remove",
    );
    if (!sure) return;
    try {
      await remove("/api/grammar", { name });
      context.notify(`The grammar ${name} is removed.`);
      go(routeTo("grammar"));
    } catch (fault) {
      context.fail(fault);
    }
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
    loads += 1;
    const mine = loads;
    try {
      const known = await get<GrammarReply>("/api/grammar", { name });
      if (mine !== loads) return false;
      facts = known;
      showHeading(known);
      panel.show(known);
      return true;
    } catch (fault) {
      if (mine !== loads) return false;
      facts = null;
      one.hidden = true;
      list.hidden = false;
      fill(
        list,
        faultState(messageOf(fault), [{ label: "All grammars", run: () => go(routeTo("grammar")) }]),
      );
      return false;
    }
  }

  async function make(wish: Wish): Promise<void> {
    maker.busy(true);
    making.replaceChildren();
    try {
      const made = await post<SequenceReply>("/api/sequences", { grammar: route.name, ...wish });
      goOn(addressOf({ ...route, wish, sequence: made.id, selection: null }));
    } catch (fault) {
      fill(making, faultState(messageOf(fault)));
    } finally {
      maker.busy(false);
    }
  }

  /** Open a kept sequence; the answer names its grammar. */
  async function openKept(capture: string): Promise<void> {
    try {
      const kept = await post<SequenceReply>("/api/sequences/open", { capture });
      amend(addressOf({ ...route, name: kept.grammar, sequence: kept.id, selection: null }));
    } catch (fault) {
      one.hidden = true;
      list.hidden = false;
      fill(
        list,
        faultState(messageOf(fault), [{ label: "All grammars", run: () => go(routeTo("grammar")) }]),
      );
    }
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
      loads += 1;
      panel.close();
      editor.close();
    },
  };
}
