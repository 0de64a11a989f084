/** Dialogs: a box over the page that has to be answered or closed. */

import { onSubmit } from "../dom/fields.ts";
import { button } from "../dom/button.ts";
import { messageOf } from "../api/client.ts";
import { h, type Attributes, type Child } from "../dom/element.ts";
import { icon } from "../dom/icons.ts";

/** Open a dialog; it is removed when it closes. */
export function openDialog(title: string, ...children: Child[]): HTMLDialogElement {
  const dialog: HTMLDialogElement = h(
    "dialog.dialog",
    { "aria-label": title, on: { close: () => dialog.remove() } },
    h(
      "div.dialog-head",
      h("h2", title),
      button("tool", icon("close"), () => dialog.close(), { "aria-label": "Close" }),
    ),
    ...children,
  );
  document.body.append(dialog);
  dialog.showModal();
  return dialog;
}

/**
 * A form in a dialog. `send` does what was asked for; the dialog closes when it has, and stays open
 * where it resolves to false or null. What it throws is shown in the dialog, which covers the rest.
 */
export function openForm(title: string, content: Child, yes: string, send: () => Promise<unknown>): void {
  const fault = h("p.bad.small", { role: "alert" });
  const submit = async (): Promise<void> => {
    fault.textContent = "";
    try {
      const done = await send();
      if (done !== false && done !== null) dialog.close();
    } catch (problem) {
      fault.textContent = messageOf(problem);
    }
  };
  const form = h(
    "form",
    content,
    fault,
    h(
      "div.row.end",
      button("plain", "Cancel", () => dialog.close()),
      h("button.button", { type: "submit" }, yes),
    ),
  );
  onSubmit(form, () => {
    void submit();
  });
  const dialog = openDialog(title, form);
}

/** A dialog with one line to fill in. */
export interface Line {
  title: string;
  label: string;
  /** The word on the button that sends it. */
  yes: string;
  value?: string;
  example?: string;
  /** What stands above the line, and under it. */
  about?: string;
  note?: string;
  /** Further attributes of the input. */
  rules?: Attributes;
}

/** Ask for one line. */
export function askLine(line: Line, send: (text: string) => Promise<unknown>): void {
  const input = h("input.field.wide", {
    id: "asked-line",
    required: true,
    value: line.value ?? "",
    placeholder: line.example,
    ...line.rules,
  });
  const content = [
    line.about ? h("p.muted", line.about) : null,
    h("label", { for: "asked-line" }, line.label),
    input,
    line.note ? h("p.muted", line.note) : null,
  ];
  openForm(line.title, content, line.yes, () => send(input.value.trim()));
  input.select();
}

/** Ask a question that has consequences; true: go on. */
export function askWhether(title: string, text: string, yes: string): Promise<boolean> {
  return new Promise((resolve) => {
    let answer = false;
    const choose = (value: boolean): void => {
      answer = value;
      dialog.close();
    };
    const dialog = openDialog(
      title,
      h("p", text),
      h(
        "div.row.end",
        button("plain", "Cancel", () => choose(false), { autofocus: true }),
        button("danger", yes, () => choose(true)),
      ),
    );
    dialog.addEventListener("close", () => resolve(answer));
  });
}
