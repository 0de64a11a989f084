/** Boards as files: the shipped ones and the user's are opened and saved, also as text. */

import { named } from "../../dom/fields.ts";
import { get, put } from "../../api/client.ts";
import { button } from "../../dom/button.ts";
import { fill, h } from "../../dom/element.ts";
import { askLine, openDialog } from "../../parts/asking.ts";
import { saveBlob } from "../../parts/download.ts";
import type { Context } from "../view.ts";
import type { BoardFile, BoardReply } from "../../api/types.ts";

export interface FileActions {
  /** Open a board by its name; "" begins a new one. */
  open(name: string): void;
  /** Begin a new board on the ground of a grammar. */
  begin(grammar: string): void;
  openText(text: string): void;
  present(): { name: string; text: string };
  saved(board: BoardReply): void;
}

const ENDING = ".tactics";
/** Begins the value of a new board of a grammar; names of boards hold no such sign. */
const NEW = "new:";

export function makeFiles(context: Context, actions: FileActions) {
  const select = h("select.field", {
    id: "board-name",
    on: {
      change: () => {
        const [, grammar] = select.value.split(NEW);
        if (grammar) actions.begin(grammar);
        else actions.open(select.value);
      },
    },
  });
  const input = h("input", {
    type: "file",
    accept: ENDING,
    hidden: true,
    on: {
      change: () => {
        const file = input.files?.[0];
        input.value = "";
        void file?.text().then(actions.openText);
      },
    },
  });

  function save(): void {
    const { name, text } = actions.present();
    const line = {
      title: "Save the board",
      label: "Name of the board",
      value: name,
      note: "Saved as a text file that the command line reads too.",
      yes: "Save",
      rules: { pattern: "[A-Za-z0-9][A-Za-z0-9_\\-]{0,59}", title: "Letters, digits, - and _" },
    };
    askLine(line, async (chosen) => {
      const board = await put("/api/board", { name: chosen, text });
      context.notify(`Saved as ${board.name}${ENDING}.`);
      actions.saved(board);
    });
  }

  function editText(): void {
    const area = h("textarea.field.wide.board-text", {
      "aria-label": "Text of the board",
      rows: 18,
    });
    area.value = actions.present().text;
    const dialog = openDialog(
      "The board as text",
      area,
      h(
        "div.row.end",
        button("main", "Use this text", () => {
          dialog.close();
          actions.openText(area.value);
        }),
      ),
    );
  }

  return {
    element: h(
      "div.row",
      named("Board", select),
      input,
      button("plain", "Open a file…", () => input.click()),
      button("plain", "Save…", save),
      button("plain", "Download", () => {
        const { name, text } = actions.present();
        saveBlob(`${name || "play"}${ENDING}`, new Blob([text], { type: "text/plain" }));
      }),
      button("plain", "Text…", editText),
    ),
    editText,
    async list(chosen: string, grammars: readonly string[]): Promise<void> {
      const { boards } = await get("/api/boards");
      const option = (one: BoardFile): HTMLElement =>
        h("option", { value: one.name, selected: one.name === chosen }, one.title);
      const own = boards.filter((one) => !one.shipped);
      fill(
        select,
        h("option", { value: "", selected: chosen === "" }, "My unsaved board"),
        h(
          "optgroup",
          { label: "Begin a new one" },
          grammars.map((one) => h("option", { value: `${NEW}${one}` }, `New ${one} board`)),
        ),
        own.length ? h("optgroup", { label: "Saved" }, own.map(option)) : null,
        h("optgroup", { label: "Shipped" }, boards.filter((one) => one.shipped).map(option)),
      );
    },
  };
}

export type Files = ReturnType<typeof makeFiles>;
