/** The catalogue: all captures with moving figures, filters, words, and one capture beside them. */

import { named, onSubmit } from "../../dom/fields.ts";
import { ApiError, get, isAbort, messageOf } from "../../api/client.ts";
import type { Caption, CaptureRow } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { icon } from "../../dom/icons.ts";
import { onDrop } from "../../parts/dropping.ts";
import { banner, emptyState, type Action } from "../../parts/states.ts";
import { plural, seconds } from "../../parts/text.ts";
import { amend, go, partOf, routeTo } from "../../shell/router.ts";
import type { Context, OpenView } from "../view.ts";
import { openAdding } from "./adding.ts";
import { makeDetails, type Details, type Place } from "./details.ts";
import { showDuplicates } from "./duplicates.ts";
import { editInPlace, isEditing, makeWordsActions, withWholeWords } from "./editing.ts";
import { makeFacets } from "./facets.ts";
import { combine, readPicks, togglePick, writePick, type Pick } from "./filter.ts";
import { openLearning, reasonToLearn } from "./learning.ts";
import { makePicking } from "./picking.ts";
import { wholeWords } from "./row.ts";
import { makeRows } from "./rows.ts";
import { makeSelections } from "./selections.ts";
import { makeGrid } from "./grid.ts";
import { makeTable, type Table } from "./table.ts";
import { makeThumbs } from "./thumbs.ts";
import { emptyDatabase } from "../empty_database.ts";

const LISTS = ["duplicates", "selections"] as const;
type List = (typeof LISTS)[number] | "";

interface Wanted {
  typed: string;
  picks: Pick[];
  sort: string;
  capture: string;
  /** What stands in place of the rows. */
  list: List;
  /** Large previews in place of the table. */
  grid: boolean;
  /** The part and the moment of the shown capture. */
  place: Place;
}

const WHOLE: Place = { part: null, time: null };

/** The part and the moment of a capture that an address names. */
function placeOf(parameters: URLSearchParams): Place {
  const number = (name: string): number | null => {
    const text = parameters.get(name);
    return text === null || !Number.isFinite(Number(text)) ? null : Number(text);
  };
  const [start, end] = [number("start"), number("end")];
  return {
    part: start !== null && end !== null && end > start ? [start, end] : null,
    time: number("time"),
  };
}

/** The names of all captures that a filter lets through. */
async function allNames(where: string, sort: string): Promise<string[]> {
  const names: string[] = [];
  for (;;) {
    const page = await get("/api/captures", { where, sort, offset: names.length, limit: 1000 });
    names.push(...page.captures.map((capture) => capture.name));
    if (page.captures.length === 0 || names.length >= page.total) return names;
  }
}

export function open(host: HTMLElement, context: Context): OpenView {
  let wanted: Wanted = {
    typed: "",
    picks: [],
    sort: "name",
    capture: "",
    list: "",
    grid: false,
    place: WHOLE,
  };
  let asked: string | null = null;
  let details: Details | null = null;

  const rows = makeRows(() => table().refresh());
  const thumbs = makeThumbs(context.motions, () => context.stage.resting);
  const actions = makeWordsActions(context, (capture, words) => void wordsChanged(capture, words));
  const facets = makeFacets((pick) => route({ picks: togglePick(wanted.picks, pick) }));
  const shared = {
    rows,
    onChoose: (capture: string) => route({ capture }),
    isPicked: (name: string) => picking.has(name),
    onPick: (names: readonly string[], picked: boolean) => picking.set(names, picked),
  };
  const listed = makeTable({
    ...shared,
    thumbs,
    canEdit: () => !context.status().read_only,
    hasLearned: () => context.status().learned,
    onSort: (sort) => route({ sort }),
    onEdit: (capture, cell) => editWords(capture, cell),
  });
  const previews = makeThumbs(context.motions, () => context.stage.resting, true);
  const grid = makeGrid({ ...shared, thumbs: previews });
  const table = (): Table => (wanted.grid ? grid : listed);
  const picking = makePicking(context, {
    all: () => allNames(combine(wanted.typed, wanted.picks), wanted.sort),
    known: () => allNames("", "name"),
    changed: () => table().refresh(),
    undo: () => actions.undo(),
  });

  const filter = h("input.field", {
    id: "filter",
    type: "search",
    placeholder: "words, a name, or length > 10",
    "aria-describedby": "filter-fault",
    spellcheck: false,
  });
  const filterFault = h("p.bad.small", { id: "filter-fault", role: "alert" });
  const form = h("form.filter-form", { role: "search" }, named("Filter", filter));
  const summary = h("p.summary", { role: "status" });
  const canWrite = !context.status().read_only;
  const undo = button("plain", [icon("undo"), "Undo"], () => void actions.undo(), {
    class: "button plain undo-button",
    title: "Undo the last change",
  });
  const selections = makeSelections(context);
  const toggle = (label: string, list: List, title: string): HTMLButtonElement =>
    button("plain", label, () => route({ list: wanted.list === list ? "" : list }), { title });
  const lists = {
    duplicates: toggle("Copies", "duplicates", "List the captures that show the same motion"),
    selections: toggle("Selections", "selections", "List what was selected and kept under a name"),
  };
  const asGrid = button("plain", [icon("grid"), "Previews"], () => route({ grid: !wanted.grid }), {
    title: "Large previews, which play while they are pointed at",
  });
  const tools = h(
    "div.row",
    h("a.button.plain", { href: routeTo("wall"), title: "All captures in motion" }, "Wall"),
    asGrid,
    Object.values(lists),
    canWrite
      ? [
          undo,
          button("plain", "Learn…", () => openLearning(context)),
          button(
            "main",
            [icon("plus"), h("span", "Add", h("span.wide-only", " captures"))],
            () => openAdding(context),
            { "aria-label": "Add captures" },
          ),
        ]
      : null,
  );
  const notice = h("div");
  const facetBox = h(
    "details.facet-box",
    { open: innerWidth > 900 },
    h("summary", "Filter by value"),
    facets.element,
  );
  const content = h("div.catalogue-content");
  const side = h("div.catalogue-side", { hidden: true });
  fill(
    host,
    h("h1.hidden-heading", "Catalogue"),
    h("div.catalogue-bar", form, summary, tools),
    filterFault,
    notice,
    h("div.catalogue-body", facetBox, content, side),
    picking.element,
  );
  const endDrops = canWrite ? onDrop(host, (files) => openAdding(context, files)) : null;

  onSubmit(form, () => {
    route({ typed: filter.value });
  });
  filter.addEventListener("search", () => route({ typed: filter.value }));

  function route(change: Partial<Wanted>): void {
    const place = change.capture === undefined ? wanted.place : WHOLE;
    const next = { ...wanted, place, ...change };
    const query = new URLSearchParams();
    if (next.typed.trim()) query.set("where", next.typed.trim());
    for (const pick of next.picks) query.append("pick", writePick(pick));
    if (next.sort !== "name") query.set("sort", next.sort);
    if (next.list) query.set("show", next.list);
    if (next.grid) query.set("as", "grid");
    if (next.capture) {
      query.set("capture", next.capture);
      const { part, time } = next.place;
      part?.forEach((value, i) => query.set(i === 0 ? "start" : "end", value.toFixed(3)));
      if (time !== null) query.set("time", time.toFixed(2));
    }
    const text = query.toString();
    const hash = text ? `#/catalogue?${text}` : "#/catalogue";
    if (hash !== location.hash) (change.capture === undefined ? amend : go)(hash);
  }

  function editWords(capture: CaptureRow, cell: HTMLElement): void {
    editInPlace(
      cell,
      wholeWords(capture),
      `Words of ${capture.name}`,
      (line) => actions.replace(capture.name, withWholeWords(capture.words, line), capture.words),
      () => {
        table().refresh();
        if (missed) void load();
      },
    );
  }

  async function wordsChanged(capture: string, words: Caption[]): Promise<void> {
    const at = rows.find(capture);
    const row = at >= 0 ? rows.at(at) : null;
    if (row) rows.replace({ ...row, words });
    table().refresh();
    await Promise.all([refreshUndo(), wanted.capture === capture ? details?.reload() : undefined]);
  }

  async function refreshUndo(): Promise<void> {
    try {
      undo.hidden = (await get("/api/undo")).left === 0;
    } catch {
      undo.hidden = true;
    }
  }

  /** Whether the database changed while words were typed; the rows are asked for after that. */
  let missed = false;

  async function load(): Promise<void> {
    missed = isEditing(table().element);
    if (missed) return;
    const where = combine(wanted.typed, wanted.picks);
    filterFault.textContent = "";
    filter.removeAttribute("aria-invalid");
    try {
      await Promise.all([
        rows.ask(where, wanted.sort, wanted.capture),
        facets.load(wanted.typed, wanted.picks).catch(() => undefined), // the rows tell the fault
      ]);
    } catch (fault) {
      if (isAbort(fault)) return;
      if (fault instanceof ApiError && fault.status === 400) {
        filterFault.textContent = messageOf(fault);
        filter.setAttribute("aria-invalid", "true");
        summary.textContent = "";
        showUnread();
      } else context.fail(fault);
      return;
    }
    missed = isEditing(table().element);
    if (missed) return; // typing began while the rows were on their way
    host.classList.toggle("no-facets", facets.element.childElementCount === 0);
    table().leaveOut(new Set([...facets.columns(), ...rows.tags()]));
    showRows();
  }

  /** What to do instead: the box above answers questions, this one only looks for words. */
  const askInstead = (): Action[] =>
    context.status().learned && /\p{L}/u.test(wanted.typed) && !/[=<>~]/.test(wanted.typed)
      ? [{ label: `Ask for “${wanted.typed.trim()}”`, run: () => go(routeTo("search", { q: wanted.typed })) }]
      : [];

  const showAll: Action = { label: "Show all captures", run: () => route({ typed: "", picks: [] }) };

  function showUnread(): void {
    host.classList.add("no-facets");
    fill(content, emptyState("The filter could not be read", "Correct it, or show all captures.", [showAll]));
  }

  function showRows(): void {
    const status = context.status();
    showTools();
    const filtered = wanted.typed.trim() !== "" || wanted.picks.length > 0;
    summary.textContent = filtered
      ? `${rows.total.toLocaleString("en")} of ${plural(status.captures, "capture")}`
      : `${plural(status.captures, "capture")}, ${seconds(status.seconds)} of motion`;
    if (wanted.list) return;
    if (rows.total > 0) {
      if (!table().element.isConnected) fill(content, table().element);
      table().reset(wanted.sort);
      if (rows.found !== null && wanted.capture) table().reveal(rows.found);
    } else if (filtered) {
      fill(
        content,
        emptyState(
          "No capture matches",
          askInstead().length > 0
            ? "The filter looks for words in captions and names. A question looks at the motion, too."
            : "Remove a condition, or show all captures.",
          [...askInstead(), { ...showAll, plain: askInstead().length > 0 }],
        ),
      );
    } else fill(content, emptyDatabase(context));
  }

  function showList(): void {
    if (wanted.list === "duplicates") void showDuplicates(content);
    if (wanted.list === "selections") void selections.show(content);
  }

  /** Nothing to filter, to learn from or to compare yet: one step at a time. */
  const showTools = (): void => void host.classList.toggle("no-captures", context.status().captures === 0);

  function showNotice(): void {
    const reason = canWrite ? reasonToLearn(context.status()) : null;
    fill(notice, reason ? banner(reason, [{ label: "Learn…", run: () => openLearning(context) }]) : null);
  }

  function showSide(): void {
    const left = details?.name ?? "";
    const shown = wanted.capture;
    if (shown === left) return details?.select(wanted.place.part);
    side.hidden = shown === "";
    host.classList.toggle("with-side", shown !== "");
    table().choose(shown || null);
    if (!shown) {
      const inside = side.contains(document.activeElement);
      if (inside || document.activeElement === document.body) table().focus(left);
      details?.close();
      details = null;
      side.replaceChildren();
      return;
    }
    if (!details) {
      details = makeDetails(
        context,
        actions,
        () => route({ capture: "" }),
        (moved) => route({ place: { ...wanted.place, ...moved } }),
      );
      fill(side, details.element);
    }
    void details.show(shown, wanted.place);
  }

  showTools(); // at once: a button must not vanish while it is pressed
  showNotice();
  void refreshUndo();
  return {
    update(parameters) {
      wanted = {
        typed: parameters.get("where") ?? "",
        picks: readPicks(parameters),
        sort: parameters.get("sort") ?? "name",
        capture: parameters.get("capture") ?? "",
        list: LISTS.find((list) => list === parameters.get("show")) ?? "",
        grid: parameters.get("as") === "grid",
        place: placeOf(parameters),
      };
      filter.value = wanted.typed;
      table().choose(wanted.capture || null);
      asGrid.setAttribute("aria-pressed", String(wanted.grid));
      for (const list of LISTS) lists[list].setAttribute("aria-pressed", String(wanted.list === list));
      const key = partOf(parameters, ["where", "pick", "sort", "show", "as"]);
      if (key !== asked) {
        asked = key;
        showList();
        void load();
      }
      showSide();
    },
    news(news) {
      if (news.kind !== "revision") return;
      showNotice();
      context.motions.forget();
      if (wanted.list === "selections") showList();
      void load();
      void picking.check();
      void refreshUndo();
      void details?.reload();
    },
    close() {
      endDrops?.();
      details?.close();
      listed.close();
      grid.close();
      thumbs.close();
      previews.close();
    },
  };
}
