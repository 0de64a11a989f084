/** A button that opens a short list of others; it closes when one is chosen, or by Escape. */

import { h } from "../dom/element.ts";

export function makeMenu(label: string, items: readonly HTMLElement[]): HTMLElement {
  const close = (): void => void (menu.open = false);
  const summary = h("summary.button.plain", label);
  const list = h("div.menu-items", { on: { click: close } }, items);
  const menu = h(
    "details.menu",
    {
      on: {
        keydown: (event) => {
          if (event.key !== "Escape" || !menu.open) return;
          event.stopPropagation();
          close();
          summary.focus();
        },
        focusout: (event) => {
          if (event.relatedTarget && !menu.contains(event.relatedTarget as Node)) close();
        },
      },
    },
    summary,
    list,
  );
  menu.addEventListener("toggle", () => {
    if (!menu.open) return;
    list.scrollIntoView({ block: "nearest" });
    const outside = (event: Event): void => {
      if (menu.contains(event.target as Node)) return;
      close();
      removeEventListener("pointerdown", outside);
    };
    addEventListener("pointerdown", outside);
  });
  return menu;
}
