/** Several captures at once: which are chosen, and what is done with them. */

import { post } from "../../api/client.ts";
import type { Part } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { h } from "../../dom/element.ts";
import { askLine, askWhether } from "../../parts/asking.ts";
import { download, downloadButtons, type FileFormat } from "../../parts/download.ts";
import { askSelection } from "../../parts/selecting.ts";
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
  options: Pick<TableOptions, "onPick">,
): (index: number, isRange: boolean, on: boolean) => Promise<void> {
  let last = 0;
  return async (index, isRange, on) => {
    const [low, high] = isRange ? [Math.min(last, index), Math.max(last, index)] : [index, index];
    last = index;
    try {
      options.onPick(await rows.names(low, high), on);
    } catch (fault) {
      options.onPick([], on); // the box shows again that it is not selected
      throw fault;
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
    "div.selection-bar",
    { role: "region", "aria-label": "Selected captures", hidden: true },
    count,
    button("link", "Select all", async () => set(await options.all(), true)),
    canWrite
      ? [
          button("plain", "Words…", () =>
            ask("Add words", "What do all of them show?", "a person walks", addWords),
          ),
          button("plain", "Tags…", () =>
            ask(
              "Set a tag",
              "A tag and its value, such as performer = ana. Without a value it is removed.",
              "performer = ana",
              setTag,
            ),
          ),
          button("plain", "Licence…", () =>
            ask("Set the licence", "The licence of all of them", "CC0-1.0", setLicence),
          ),
          button("plain", "Add to a selection…", () =>
            askSelection(context, refs(), plural(chosen.size, "capture")),
          ),
          button("plain", "Rename…", () => rename()),
          button("plain", "Remove…", () => void removeAll()),
        ]
      : null,
    downloadButtons(context.status().writes, (format) => void save(format), true),
    button("link", "Clear", () => clear()),
  );

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

  async function change(
    path: "remove" | "rename" | "tags" | "words",
    body: object,
    done: string,
  ): Promise<void> {
    const { changed } = await post(`/api/captures/${path}`, body);
    context.notify(
      changed.length > 0 ? `${done} of ${plural(changed.length, "capture")}.` : "Nothing had to be changed.",
      changed.length > 0 ? { label: "Undo", run: () => void options.undo() } : undefined,
    );
    await context.refresh();
  }

  function ask(title: string, label: string, example: string, run: (line: string) => Promise<void>): void {
    askLine({ title, label, example, about: plural(chosen.size, "capture"), yes: title }, run);
  }

  const names = (): string[] => [...chosen];
  const refs = (): Part[] => names().map((name) => ({ ref: `capture:${name}` }));
  const addWords = (words: string): Promise<void> => change("words", { captures: names(), words }, "Words");
  const setLicence = (licence: string): Promise<void> =>
    change("tags", { captures: names(), tags: { licence } }, "Licence");
  const setTag = async (line: string): Promise<void> => {
    const [key, ...value] = line.split("=");
    if (!key?.trim() || value.length === 0) {
      throw new Error("Write a tag and its value with = between them, such as performer = ana.");
    }
    await change("tags", { captures: names(), tags: { [key.trim()]: value.join("=").trim() } }, "Tags");
  };

  function rename(): void {
    const chosen = names();
    if (chosen.length > 0) {
      askNames(chosen, async (body) => {
        await change("rename", body, "Name");
        clear();
      });
    }
  }

  async function removeAll(): Promise<void> {
    const sure = await askWhether(
      `Remove ${plural(chosen.size, "capture")}?`,
      "They are removed with their words and what was learned from these. Undo brings them back.",
      "Remove",
    );
    if (!sure) return;
    await change("remove", { captures: names() }, "Removal");
    clear();
  }

  async function save(format: FileFormat): Promise<void> {
    await download(refs(), format);
  }

  return { element, has: (name) => chosen.has(name), set, clear, check };
}
