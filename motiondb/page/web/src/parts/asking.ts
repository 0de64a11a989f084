/** Dialogs: a box over the page that has to be answered or closed. */

import { h, type Child } from "../dom/element.ts";
import { icon } from "../dom/icons.ts";

/** Open a dialog; it is removed when it closes. */
export function openDialog(title: string, ...children: Child[]): HTMLDialogElement {
  const dialog = h(
    "dialog",
    { class: "dialog", "aria-label": title, on: { close: () => dialog.remove() } },
    h(
      "div",
      { class: "dialog-head" },
      h("h2", {}, title),
      h(
        "button",
        { class: "tool", type: "button", "aria-label": "Close", on: { click: () => dialog.close() } },
        icon("close"),
      ),
    ),
    ...children,
  );
  document.body.append(dialog);
  dialog.showModal();
  return dialog;
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
      h("p", {}, text),
      h(
        "div",
        { class: "row end" },
        h(
          "button",
          { class: "button plain", type: "button", autofocus: true, on: { click: () => choose(false) } },
          "Cancel",
        ),
        h("button", { class: "button danger", type: "button", on: { click: () => choose(true) } }, yes),
      ),
    );
    dialog.addEventListener("close", () => resolve(answer));
  });
}
