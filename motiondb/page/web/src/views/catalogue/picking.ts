/** Several captures at once: which are chosen, and what is done with them. */

import { isAbort, post } from "../../api/client.ts";
import type { CapturesChanged } from "../../api/types.ts";
import { h } from "../../dom/element.ts";
import { askWhether, openDialog } from "../../parts/asking.ts";
import { download, downloadButtons, type FileFormat } from "../../parts/download.ts";
import { plural } from "../../parts/text.ts";
import type { Context } from "../view.ts";
import { askNames } from "./renaming.ts";
import type { Rows } from "./rows.ts";
import type { TableOptions } from "./table.ts";

/**
 * Select a row, with Shift all from the row that was selected before; also those that have not
 * arrived.
 */
export function makeRangePick(
  rows: Pick<Rows, "names">,
  options: Pick<TableOptions, "onPick" | "failed">,
): (index: number, isRange: boolean, on: boolean) => Promise<void> {
  let last = 0;
  return async (index, isRange, on) => {
    const [low, high] = isRange ? [Math.min(last, index), Math.max(last, index)] : [index, index];
    last = index;
    try {
      options.onPick(await rows.names(low, high), on);
    } catch (fault) {
      options.onPick([], on); // the box shows again that it is not selected
      if (!isAbort(fault)) options.failed(fault);
    }
  };
}

export interface Picking {
  readonly element: HTMLElement;
  has(name: string): boolean;
  set(names: readonly string[], chosen: boolean): void;
  clear(): void;
  /** The database changed: captures that are not there any more are not selected any more. */
  check(): Promise<void>;
}

export interface PickingOptions {
  /** The names of all captures of the database. */
  known(): Promise<string[]>;
  /** The names of all captures that the filter lets through. */
  all(): Promise<string[]>;
  changed(): void;
  undo(): Promise<void>;
}

export function makePicking(context: Context, options: PickingOptions): Picking {
  const chosen = new Set<string>();
  const count = h("span", { role: "status" });
  const canWrite = !context.status().read_only;
  const element = h(
    "div",
    { class: "selection-bar", role: "region", "aria-label": "Selected captures", hidden: true },
    count,
    link("Select all", async () => set(await options.all(), true)),
    canWrite
      ? [
          action("Words…", () => ask("Add words", "What do all of them show?", "a person walks", addWords)),
          action("Tags…", () =>
            ask(
              "Set a tag",
              "A tag and its value, such as performer = ana. Without a value it is removed.",
              "performer = ana",
              setTag,
            ),
          ),
          action("Licence…", () =>
            ask("Set the licence", "The licence of all of them", "CC0-1.0", setLicence),
          ),
          action("Rename…", () => rename()),
          action("Remove…", () => void removeAll()),
        ]
      : null,
    downloadButtons(context.status().writes, (format) => void save(format), true),
    link("Clear", () => clear()),
  );

  function link(label: string, run: () => unknown): HTMLElement {
    return h("button", { class: "link", type: "button", on: { click: () => void run() } }, label);
  }

  function action(label: string, run: () => void): HTMLElement {
    return h("button", { class: "button plain", type: "button", on: { click: run } }, label);
  }

  function show(): void {
    element.hidden = chosen.size === 0;
    count.textContent = `${plural(chosen.size, "capture")} selected`;
    options.changed();
  }

  function set(names: readonly string[], on: boolean): void {
    for (const name of names)
      if (on) chosen.add(name);
      else chosen.delete(name);
    show();
  }

  function clear(): void {
    chosen.clear();
    show();
  }

  async function check(): Promise<void> {
    if (chosen.size === 0) return;
    const before = [...chosen];
    const known = new Set(await options.known());
    const gone = before.filter((name) => !known.has(name));
    if (gone.length > 0) set(gone, false);
  }

  async function change(path: string, body: object, done: string): Promise<boolean> {
    try {
      const { changed } = await post<CapturesChanged>(`/api/captures/${path}`, body);
      context.notify(
        changed.length > 0
          ? `${done} of ${plural(changed.length, "capture")}.`
          : "Nothing had to be changed.",
        changed.length > 0 ? { label: "Undo", run: () => void options.undo() } : undefined,
      );
      await context.refresh();
      return true;
    } catch (fault) {
      context.fail(fault);
      return false;
    }
  }

  /** Ask for one line; the dialog stays open where it cannot be done. */
  function ask(title: string, label: string, example: string, run: (line: string) => Promise<boolean>): void {
    const input = h("input", {
      class: "field wide",
      id: "bulk",
      required: true,
      autofocus: true,
      placeholder: example,
    });
    const form = h(
      "form",
      {},
      h("p", { class: "muted" }, plural(chosen.size, "capture")),
      h("label", { for: "bulk" }, label),
      input,
      h("div", { class: "row end" }, h("button", { class: "button", type: "submit" }, title)),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void run(input.value.trim()).then((done) => done && dialog.close());
    });
    const dialog = openDialog(title, form);
  }

  const names = (): string[] => [...chosen];
  const addWords = (words: string): Promise<boolean> =>
    change("words", { captures: names(), words }, "Words");
  const setLicence = (licence: string): Promise<boolean> =>
    change("tags", { captures: names(), tags: { licence } }, "Licence");
  const setTag = (line: string): Promise<boolean> => {
    const [key, ...value] = line.split("=");
    if (!key?.trim() || value.length === 0) {
      context.fail(new Error("Write a tag and its value with = between them, such as performer = ana."));
      return Promise.resolve(false);
    }
    return change("tags", { captures: names(), tags: { [key.trim()]: value.join("=").trim() } }, "Tags");
  };

  function rename(): void {
    const chosen = names();
    if (chosen.length > 0) {
      askNames(chosen, async (body) => {
        const done = await change("rename", body, "Name");
        if (done) clear();
        return done;
      });
    }
  }

  async function removeAll(): Promise<void> {
    const sure = await askWhether(
      `Remove ${plural(chosen.size, "capture")}?`,
      "They are removed with their words and what was learned from these. Undo brings them back.",
      "Remove",
    );
    if (sure && (await change("remove", { captures: names() }, "Removal"))) clear();
  }

  async function save(format: FileFormat): Promise<void> {
    try {
      await download(
        names().map((name) => ({ ref: `capture:${name}` })),
        format,
      );
    } catch (fault) {
      context.fail(fault);
    }
  }

  return { element, has: (name) => chosen.has(name), set, clear, check };
}
