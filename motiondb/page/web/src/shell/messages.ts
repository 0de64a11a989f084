/** Messages in a corner of the page: news goes away by itself, faults stay until closed. */

import { h } from "../dom/element.ts";
import { icon } from "../dom/icons.ts";

export interface Messages {
  readonly element: HTMLElement;
  notify(text: string, action?: { label: string; run: () => void }): void;
  /** `kind`: of faults that end together, such as those of a server that cannot be reached. */
  fail(text: string, kind?: string): void;
  /** Remove the faults of a kind. */
  settle(kind: string): void;
}

const SHOWN_FOR = 8000;
const MOST = 4;

export function makeMessages(): Messages {
  const news = h("div", { role: "status", "aria-label": "Messages" });
  const faults = h("div", { role: "alert", "aria-label": "Faults" });
  const element = h("div", { class: "messages" }, news, faults);

  function add(where: HTMLElement, kind: string, ...children: (Node | string)[]): HTMLElement {
    const close = h(
      "button",
      { class: "tool", type: "button", "aria-label": "Close", on: { click: () => message.remove() } },
      icon("close"),
    );
    const message = h("div", { class: `message ${kind}` }, h("p", {}, ...children), close);
    where.append(message);
    while (where.childElementCount > MOST) where.firstElementChild!.remove();
    return message;
  }

  return {
    element,
    notify(text, action) {
      const button = action
        ? h(
            "button",
            {
              class: "link",
              type: "button",
              on: {
                click: () => {
                  message.remove();
                  action.run();
                },
              },
            },
            action.label,
          )
        : null;
      const message: HTMLElement = button ? add(news, "news", text, " ", button) : add(news, "news", text);
      setTimeout(() => message.remove(), SHOWN_FOR);
    },
    fail(text, kind = "") {
      for (const old of faults.children) if (old.textContent === text) old.remove();
      add(faults, "fault", text).dataset["kind"] = kind;
    },
    settle(kind) {
      for (const old of [...faults.children] as HTMLElement[]) if (old.dataset["kind"] === kind) old.remove();
    },
  };
}
