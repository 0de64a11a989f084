/** Messages in a corner of the page: news goes away by itself; faults and offers stay until closed. */

import { button } from "../dom/button.ts";
import { h } from "../dom/element.ts";
import { icon } from "../dom/icons.ts";

const SHOWN_FOR = 8000;
const MOST = 4;
/** Corners of the page as classes, the usual one first. */
const CORNERS = ["", "left", "top"];
/** What messages should not cover, and how bad that is: players and the bar of a selection above all. */
const KEPT_FREE: readonly [string, number][] = [
  [".player-bar, .clip-play, .selection-bar", 100],
  [".timeline, .report", 10],
  ["main :is(button, input, select, summary)", 1],
];

export function makeMessages() {
  const news = h("div", { role: "status", "aria-label": "Messages" });
  const faults = h("div", { role: "alert", "aria-label": "Faults" });
  const element = h("div.messages", news, faults);

  /** Move to the corner in which the least is covered. */
  function place(): void {
    const free = KEPT_FREE.flatMap(([selector, weight]) =>
      [...document.querySelectorAll(selector)].map((one) => ({ box: one.getBoundingClientRect(), weight })),
    ).filter(({ box }) => box.width > 0);
    const costs = CORNERS.map((corner) => {
      element.className = `messages ${corner}`;
      const own = element.getBoundingClientRect();
      return free
        .filter(({ box }) => box.left < own.right && box.right > own.left)
        .filter(({ box }) => box.top < own.bottom && box.bottom > own.top)
        .reduce((sum, { weight }) => sum + weight, 0);
    });
    element.className = `messages ${CORNERS[costs.indexOf(Math.min(...costs))]}`;
  }

  function add(where: HTMLElement, kind: string, ...children: (Node | string)[]): HTMLElement {
    const close = button("tool", icon("close"), () => message.remove(), { "aria-label": "Close" });
    const message = h("div", { class: `message ${kind}` }, h("p", ...children), close);
    where.append(message);
    while (where.childElementCount > MOST) where.firstElementChild!.remove();
    place();
    return message;
  }

  return {
    element,
    notify(text: string, action?: { label: string; run: () => void }): void {
      const offer = action
        ? button("link", action.label, () => {
            message.remove();
            action.run();
          })
        : null;
      const message: HTMLElement = add(news, "news", text, ...(offer ? [" ", offer] : []));
      if (!offer) setTimeout(() => message.remove(), SHOWN_FOR);
    },
    /** `kind`: of faults that end together, such as those of a server that cannot be reached. */
    fail(text: string, kind = ""): void {
      for (const old of faults.children) if (old.textContent === text) old.remove();
      add(faults, "fault", text).dataset["kind"] = kind;
    },
    /** Remove the faults of a kind. */
    settle(kind: string): void {
      for (const old of [...faults.children] as HTMLElement[]) if (old.dataset["kind"] === kind) old.remove();
    },
  };
}

export type Messages = ReturnType<typeof makeMessages>;
