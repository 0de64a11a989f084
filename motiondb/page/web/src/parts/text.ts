/** Numbers and names as text. */

import { h, type Child } from "../dom/element.ts";

/** A name that is broken after its separators, before it is broken anywhere. */
export const breakable = (name: string): Child =>
  name.split(/(?<=[/_.-])/).map((part, i) => [i > 0 ? h("wbr") : null, part]);

export function seconds(value: number): string {
  if (value < 60) return `${value.toFixed(value < 10 ? 2 : 1)} s`;
  const minutes = Math.floor(value / 60);
  return `${minutes} min ${Math.round(value - 60 * minutes)} s`;
}

/** A time that is only estimated: 5 s, 40 s, 3 min. */
export function roughly(value: number): string {
  if (value < 10) return `${Math.max(Math.ceil(value), 1)} s`;
  return value < 90 ? `${Math.ceil(value / 10) * 10} s` : `${Math.round(value / 60)} min`;
}

export function interval(start: number, end: number): string {
  return `${start.toFixed(2)}–${end.toFixed(2)} s`;
}

/** A probability with two digits; nothing where it is not known. */
export function probability(value: number | null | undefined): string {
  return value === null || value === undefined ? "" : value.toFixed(2);
}

/** A signed number with two digits or more: +3.89, −1.62. */
export function signed(value: number, digits = 2): string {
  return `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(digits)}`;
}

export function plural(count: number, one: string, many = `${one}s`): string {
  return `${count.toLocaleString("en")} ${count === 1 ? one : many}`;
}

export function bytesText(value: number): string {
  const units = ["B", "kB", "MB", "GB"];
  let unit = 0;
  let left = value;
  while (left >= 1000 && unit < units.length - 1) {
    left /= 1000;
    unit += 1;
  }
  return `${left < 10 && unit > 0 ? left.toFixed(1) : Math.round(left)} ${units[unit]}`;
}

/** Why none of several actions is confirmed, if the reason is the same: it need not be read at each. */
export function sharedReason(shown: readonly { shown: boolean | null; reason: string | null }[]): string {
  const first = shown[0]?.reason ?? "";
  const all = shown.every((one) => one.shown === null && one.reason === first);
  return shown.length > 1 && all ? first : "";
}
