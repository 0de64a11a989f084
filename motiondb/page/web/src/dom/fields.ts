/** Fields of forms. */

import { h, type Attributes } from "./element.ts";

/** A field behind its name. */
export const named = (name: string, field: HTMLElement): HTMLElement[] => [
  h("label", { for: field.id }, name),
  field,
];

/** A field for a whole number, unless another step is given, from a least one on. */
export const numberField = (id: string, min: number, attributes: Attributes = {}): HTMLInputElement =>
  h("input.number", { id: id || null, type: "number", min, step: 1, ...attributes });

type Value = string | number;

/** A choice of values, each with what is said of it. */
export function choice(
  id: string,
  values: readonly (Value | readonly [value: Value, said: string])[],
  chosen?: (value: string) => unknown,
): HTMLSelectElement {
  const pairs = values.map((one) => (typeof one === "object" ? one : [one, one]));
  const select = h(
    "select.field",
    { id },
    pairs.map(([value, said]) => h("option", { value }, said)),
  );
  if (chosen) select.addEventListener("change", () => chosen(select.value));
  return select;
}

/** Do something where a form is sent, in place of the browser's request. */
export function onSubmit(form: HTMLFormElement, run: () => unknown): void {
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    run();
  });
}
