/** The frame around all views: navigation, state of the database, jobs, messages. */

import { makeLatest } from "../api/latest.ts";
import { ApiError, dropEarly, get, isAbort, messageOf, UNREACHABLE } from "../api/client.ts";
import { openLive, type News } from "../api/live.ts";
import { serverMotions } from "../api/motions.ts";
import type { Status } from "../api/types.ts";
import { fill, h } from "../dom/element.ts";
import { emptyState } from "../parts/states.ts";
import type { Stage } from "../player/stage.ts";
import { VIEWS } from "../views/registry.ts";
import type { Context, OpenView } from "../views/view.ts";
import { makeJobs } from "./jobs.ts";
import { makeMessages } from "./messages.ts";
import { makeQuestionBox } from "./question_box.ts";
import { keepPlaces } from "./places.ts";
import { parseRoute, replace, routeTo } from "./router.ts";

const FIRST = VIEWS[0]!.name;
/** Milliseconds without a connection after which it is said: a busy computer answers late. */
const PATIENCE = 4000;

/** Parameters that say what a view is about, the most telling first. */
const TELLING = ["capture", "q", "like", "name", "open", "board", "symbol", "where"];

/** What a view is about, for the title of its tab: the question, the capture, the grammar. */
function titleOf(parameters: URLSearchParams): string {
  const about = TELLING.map((name) => parameters.get(name)).find(Boolean);
  return about?.replace(/^(capture|upload|made|sequence|kept):/, "") ?? "";
}

/** Start the page: ask for the state of the database, then show the view of the address. */
export async function startPage(root: HTMLElement): Promise<void> {
  let status: Status;
  const named = parseRoute(location.hash, FIRST).view;
  const wanted = VIEWS.find((view) => view.name === named) ?? VIEWS[0]!;
  void wanted.load().catch(() => undefined); // its code comes while the state is asked for
  try {
    status = await get("/api/status");
  } catch (fault) {
    fill(
      root,
      h(
        "main.centre",
        emptyState("motiondb cannot be reached", messageOf(fault), [
          { label: "Try again", run: () => location.reload() },
        ]),
      ),
    );
    return;
  }
  let asking: Promise<Status> | null = null;
  let stage: Stage | null = null;
  const messages = makeMessages();
  const live = openLive();
  const context: Context = {
    get stage() {
      return stage!; // there when a view that needs it is opened
    },
    motions: serverMotions(),
    live,
    status: () => status,
    refresh() {
      asking = askStatus();
      return asking;
    },
    notify: messages.notify,
    fail: (fault) =>
      isAbort(fault)
        ? undefined
        : messages.fail(messageOf(fault), fault instanceof ApiError ? fault.kind : ""),
  };
  // What nobody catches is told here; what is no fault of a server stays an error of the page, too.
  addEventListener("unhandledrejection", (event) => {
    if (event.reason instanceof ApiError || isAbort(event.reason)) event.preventDefault();
    context.fail(event.reason);
  });
  const jobs = makeJobs(context);
  const question = makeQuestionBox(context);
  const links = new Map(
    VIEWS.filter((view) => view.place !== "asking").map((view) => [
      view.name,
      h("a.nav-link", { href: routeTo(view.name) }, view.title),
    ]),
  );
  const linksOf = (place?: string): HTMLElement[] =>
    VIEWS.filter((view) => view.place === place).map((view) => links.get(view.name)!);
  const explore = h(
    "details.nav-more",
    h("summary.nav-link", "Explore"),
    h("div.nav-menu", linksOf("explore")),
  );
  const navigation = h("nav.nav", { "aria-label": "Views" }, linksOf(), explore);
  const database = h("span.database");
  const lost = h("p.lost", { role: "status", hidden: true }, "The server does not answer. Trying again…");
  const host = h("main", { id: "view", tabindex: -1 });
  fill(
    root,
    h("button.skip", { type: "button", on: { click: () => host.focus() } }, "Skip to the content"),
    h(
      "header.top",
      h("a.brand", { href: routeTo(FIRST) }, h("span.brand-mark", { "aria-hidden": "true" }), "motiondb"),
      question.element,
      navigation,
      database,
      jobs.element,
    ),
    lost,
    host,
    messages.element,
  );

  async function askStatus(): Promise<Status> {
    status = await get("/api/status");
    showStatus();
    tellRevision();
    return status;
  }

  function showStatus(): void {
    const mode = status.read_only ? " · read only" : "";
    database.textContent = `${status.database}${mode}`;
    database.title = `${status.captures} captures, ${Math.round(status.seconds)} s of motion`;
  }

  const places = keepPlaces();
  let open: OpenView | null = null;
  let shown = "";
  const latest = makeLatest();

  /** Let the question box stand where the view has a place for it. */
  function placeBox(): void {
    const slot = open?.slot?.() ?? null;
    if (slot ? question.element.parentElement === slot : question.element.nextSibling === navigation) return;
    const active = document.activeElement;
    if (slot) slot.append(question.element);
    else navigation.before(question.element);
    if (active instanceof HTMLElement && question.element.contains(active)) active.focus();
  }

  async function loadStage(): Promise<void> {
    stage ??= (await import("../player/stage.ts")).makeStage();
  }

  async function show(): Promise<void> {
    const route = parseRoute(location.hash, FIRST);
    const view = VIEWS.find((one) => one.name === route.view);
    if (!view) return replace(routeTo(FIRST));
    if (shown === view.name) void latest(); // back before another view was loaded
    if (shown !== view.name) {
      const loaded = Promise.all([view.load(), view.flat ? null : loadStage()]).catch(() => {
        throw new ApiError(
          "Outdated",
          "A part of this page cannot be loaded: the server does not answer, or motiondb is a newer one by now. Reload the page.",
          0,
        );
      });
      const [module] = await latest(Promise.resolve(open?.leave?.(route)).then(() => loaded));
      open?.close();
      host.replaceChildren();
      host.className = `view view-${view.name}`;
      shown = view.name;
      for (const [name, link] of links) {
        if (name === view.name) link.setAttribute("aria-current", "page");
        else link.removeAttribute("aria-current");
      }
      explore.classList.toggle("current", view.place === "explore");
      explore.open = false;
      open = module.open(host, context);
      placeBox();
    }
    const about = titleOf(route.parameters);
    document.title = [about, view.title, "motiondb"].filter(Boolean).join(" · ");
    question.show(view.name === "search" ? (route.parameters.get("q") ?? "") : "");
    open?.update(route.parameters);
    places.arrive([view.name, ...["q", "like"].map((name) => route.parameters.get(name))].join(" "));
  }

  function tellView(news: News): void {
    open?.news?.(news);
    placeBox();
  }

  // The revision that was last passed to the view; any request for the state may bring a new one.
  let told = status.revision;
  function tellRevision(): void {
    const { revision } = status;
    if (revision === told) return;
    told = revision;
    dropEarly();
    tellView({ kind: "revision", revision });
  }

  /** Ask for the state of a revision, unless what was just asked for tells it already. */
  async function catchUp(revision: number): Promise<void> {
    await asking?.catch(() => undefined);
    if (revision !== told) await context.refresh();
  }

  let gone = 0;
  live.listen((news) => {
    if (news.kind === "connection") {
      const wasLost = gone > 0;
      if (!news.open) {
        gone ||= window.setTimeout(() => (lost.hidden = false), PATIENCE);
        return;
      }
      clearTimeout(gone);
      gone = 0;
      lost.hidden = true;
      messages.settle(UNREACHABLE);
      // Changes made before the connection was open were not reported. What a view could not ask
      // for meanwhile, it asks for now, whether or not the database changed.
      if (wasLost) told = -1;
      void context.refresh();
    } else if (news.kind === "forgotten") {
      return;
    } else if (news.kind === "job") tellView(news);
    else void catchUp(news.revision);
  });
  const showView = (): void => void show();
  addEventListener("hashchange", showView);
  addEventListener("keydown", (event) => {
    const typed = event.target as HTMLElement;
    if (event.key === "/" && !typed.matches("input, textarea, select") && !event.ctrlKey) {
      event.preventDefault();
      question.focus();
    }
    if (event.key === "Escape" && explore.open) {
      explore.open = false;
      explore.querySelector("summary")?.focus();
    }
  });
  addEventListener("pointerdown", (event) => {
    if (!explore.contains(event.target as Node)) explore.open = false;
  });
  showStatus();
  showView();
}
