/** Buttons, by how they look. */

import { h, type Attributes, type Child } from "./element.ts";

const LOOKS = {
  /** The next step; one of them stands out. */
  main: "button",
  plain: "button plain",
  danger: "button danger",
  /** In a sentence. */
  link: "link",
  /** A link to a moment. */
  time: "link time",
  /** A link that takes something away. */
  remove: "link danger",
  /** An icon, which needs an `aria-label`. */
  tool: "tool",
} as const;

/** A button that does something when it is pressed. */
export function button(
  look: keyof typeof LOOKS,
  label: Child,
  press: (event: MouseEvent) => unknown,
  attributes: Attributes = {},
): HTMLButtonElement {
  return h("button", { class: LOOKS[look], type: "button", on: { click: press }, ...attributes }, label);
}
