/** Add captures: drop or choose files or a folder, or name a folder of the server's computer. */

import { choice, named, onSubmit } from "../../dom/fields.ts";
import { onPage } from "../../api/advice.ts";
import { get, messageOf, post } from "../../api/client.ts";
import type { UploadReply } from "../../api/types.ts";
import { button } from "../../dom/button.ts";
import { fill, h, type Child } from "../../dom/element.ts";
import { openDialog } from "../../parts/asking.ts";
import { fromList, onDrop, type NamedFile } from "../../parts/dropping.ts";
import { bytesText, plural } from "../../parts/text.ts";
import { sortFiles, upload } from "../../parts/upload.ts";
import type { Context } from "../view.ts";

/** Open the dialog; files that were dropped on the page are taken at once. */
export function openAdding(context: Context, dropped: readonly NamedFile[] = []): void {
  const { accepts, folders } = context.status();
  const state = h("div.adding-state", { role: "status" });
  const chooseFiles = picker("Choose files…", false);
  const chooseFolder = picker("Choose a folder…", true);
  const zone = h(
    "div.drop-zone",
    h("p.drop-title", "Drop captures here"),
    h(
      "p.muted",
      `${[...accepts.captures, ...accepts.skeletons].join(" ")}, and a sheet of words (${accepts.sheets.join(" ")}). Folders are read with all that is in them.`,
    ),
    h("div.row.centre", chooseFiles, chooseFolder),
  );
  onDrop(zone, (files) => void take(files));

  function picker(label: string, folder: boolean): HTMLElement {
    const input = h("input", {
      type: "file",
      multiple: true,
      hidden: true,
      ...(folder ? { webkitdirectory: true } : {}),
      "aria-label": label,
      on: { change: () => void take(fromList(input.files)) },
    });
    return h(
      "span",
      input,
      button("plain", label, () => input.click()),
    );
  }

  async function take(files: readonly NamedFile[]): Promise<void> {
    const sorted = sortFiles(files, accepts);
    if (sorted.send.length === 0) {
      fill(state, refusedList(sorted.refused), h("p.bad", "None of these files can be added."));
      return;
    }
    const size = sorted.send.reduce((sum, one) => sum + one.file.size, 0);
    fill(
      state,
      h("p", `Sending ${plural(sorted.send.length, "file")} (${bytesText(size)})…`),
      h("progress", { "aria-label": "Sending" }),
    );
    try {
      const sent = await upload(sorted.send);
      fill(state, ready(sent, [...sorted.refused, ...sent.refused]));
    } catch (fault) {
      fill(state, h("p.bad", messageOf(fault)));
    }
  }

  function ready(sent: UploadReply, refused: { name: string; message: string }[]): Child {
    const captures = sent.files.filter((file) => file.kind === "capture").length;
    if (captures === 0) {
      return [refusedList(refused), h("p.bad", "None of these files is a capture that can be added.")];
    }
    const sheets = sent.files.filter((file) => file.kind === "sheet").map((file) => file.name);
    return [
      h(
        "p",
        `${plural(captures, "file")} ready to be added. Those that cannot be read are left out, and named.`,
      ),
      refusedList(refused),
      addForm(sheets, (words) => ({ upload: sent.upload, words })),
    ];
  }

  function addForm(sheets: readonly string[], body: (words: string | null) => object): HTMLElement {
    const sheet = h(
      "select.field",
      { id: "sheet" },
      h("option", { value: "" }, "no sheet"),
      sheets.map((name, i) => h("option", { value: name, selected: i === 0 }, name)),
    );
    const up = choice("up", [["", "as found"], "y", "z", "x", "-y", "-z", "-x"]);
    const unit = choice("unit", [["", "as found"], "m", "cm", "mm", "inch"]);
    const mirrored = h("input", { type: "checkbox", id: "mirror-world" });
    const swapped = h("input", { type: "checkbox", id: "swap-sides" });
    const reading = h(
      "details.reading",
      h("summary", "How the files are to be read"),
      h("div.row", named("Axis up", up), named("Unit", unit)),
      h("label.row", { for: "mirror-world" }, mirrored, "Left-handed axes (Unity, DirectX)"),
      h("label.row", { for: "swap-sides" }, swapped, "Left and right are exchanged in the names"),
    );
    const form = h(
      "form.row.end",
      reading,
      sheets.length > 0 ? [h("label", { for: "sheet" }, "Words from"), sheet] : null,
      h("button.button", { type: "submit" }, "Add to the database"),
    );
    onSubmit(form, () => {
      const how = {
        up: up.value,
        unit: unit.value || null,
        mirror_world: mirrored.checked,
        swap_sides: swapped.checked,
      };
      void begin({ ...body(sheets.length > 0 ? sheet.value || null : null), ...how });
    });
    return form;
  }

  async function begin(body: object): Promise<void> {
    try {
      await post("/api/add", body);
      dialog.close();
      context.notify("Adding has begun. It goes on if you leave or reload this page.");
    } catch (fault) {
      fill(state, h("p.bad", { role: "alert" }, messageOf(fault)));
    }
  }

  async function browse(into: HTMLElement, root: number, path: string): Promise<void> {
    try {
      const listing = await get("/api/folders", { root, path });
      const up = path.includes("/") ? path.slice(0, path.lastIndexOf("/")) : "";
      const name = folders.find((one) => one.root === root)?.name ?? "";
      fill(
        into,
        h(
          "p",
          h("b", [name, path].filter(Boolean).join("/")),
          ` – ${plural(listing.captures, "capture")} here`,
        ),
        h(
          "ul.plain.folder-list",
          path
            ? h(
                "li",
                button("link", "one folder up", () => void browse(into, root, up)),
              )
            : null,
          listing.folders.map((folder) =>
            h(
              "li",
              button(
                "link",
                `${folder}/`,
                () => void browse(into, root, path ? `${path}/${folder}` : folder),
              ),
            ),
          ),
        ),
        addForm(listing.sheets, (words) => ({
          folder: { root, path },
          words: words && path ? `${path}/${words}` : words,
        })),
      );
    } catch (fault) {
      fill(into, h("p.bad", messageOf(fault)));
    }
  }

  const roots = folders.map(({ root, name }) => {
    const inside = h("div");
    return h(
      "details",
      { on: { toggle: () => inside.childElementCount === 0 && void browse(inside, root, "") } },
      h("summary", `Folder ${name} on the server's computer`),
      inside,
    );
  });
  const dialog = openDialog("Add captures", zone, state, roots);
  if (dropped.length > 0) void take(dropped);
}

function refusedList(refused: readonly { name: string; message: string }[]): HTMLElement | null {
  if (refused.length === 0) return null;
  return h(
    "details.refused",
    { open: true },
    h("summary", `${plural(refused.length, "file")} left out`),
    h(
      "ul.plain",
      refused.slice(0, 200).map(({ name, message }) => h("li", h("b", name), ` ${onPage(message)}`)),
    ),
  );
}
