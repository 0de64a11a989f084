/** The states of a view without content: why it is empty, and what the user can do. */

import { isAbort, messageOf } from "../api/client.ts";
import { button } from "../dom/button.ts";
import { fill, h, type Child } from "../dom/element.ts";

export interface Action {
  label: string;
  run: () => void;
  plain?: boolean;
}

export function actionButton(action: Action): HTMLButtonElement {
  return button(action.plain ? "plain" : "main", action.label, action.run);
}

/** An empty state with a heading, a sentence and actions. */
export function emptyState(title: string, text: Child, actions: readonly Action[] = []): HTMLElement {
  return h(
    "div.empty",
    h("h2", title),
    h("p", text),
    actions.length > 0 ? h("div.row", actions.map(actionButton)) : null,
  );
}

/** An error message, shown in the place of the content that it prevents. */
export function faultState(message: string, actions: readonly Action[] = []): HTMLElement {
  return h(
    "div.empty.fault-state",
    { role: "alert" },
    h("p", message),
    actions.length > 0 ? h("div.row", actions.map(actionButton)) : null,
  );
}

/** Show a fault in the place of an answer; one that came too late is not told. */
export function showFault(host: Element, fault: unknown, actions: readonly Action[] = []): void {
  if (!isAbort(fault)) fill(host, faultState(messageOf(fault), actions));
}

/** A bar above a view: something the user should know, with an action. */
export function banner(text: Child, actions: readonly Action[] = []): HTMLElement {
  return h("div.banner", { role: "status" }, h("p", text), actions.map(actionButton));
}
