/** The address of a comparison: its parts, where they are aligned, and the moment that is shown. */

import { routeTo } from "../../shell/router.ts";

/** A part of a motion that is compared, seconds. */
export interface Part {
  ref: string;
  start: number;
  end: number;
}

/** The moment of each part that is shown at the same time; "poses": like poses, in stretched time. */
export const MOMENTS = ["start", "middle", "end", "poses"] as const;
export type Moment = (typeof MOMENTS)[number];

export interface Comparison {
  parts: readonly Part[];
  at: Moment;
  overlaid: boolean;
  /** Seconds of the common clock; null: from the start. */
  time: number | null;
}

/** Most figures that can still be told apart. */
export const MOST = 4;

const KEY = "motiondb-compare";

const written = ({ ref, start, end }: Part): string => `${start.toFixed(3)}-${end.toFixed(3)} ${ref}`;

function read(text: string): Part[] {
  const found = /^([\d.]+)-([\d.]+) (.+)$/.exec(text);
  const [start, end] = [Number(found?.[1]), Number(found?.[2])];
  return found && end > start ? [{ ref: found[3]!, start, end }] : [];
}

/** The comparison that an address names; parts that cannot be read are left out. */
export function comparisonOf(parameters: URLSearchParams): Comparison {
  const at = parameters.get("at");
  const time = parameters.get("time");
  return {
    parts: parameters.getAll("part").flatMap(read),
    at: MOMENTS.find((one) => one === at) ?? "middle",
    overlaid: parameters.get("ground") === "one",
    time: time === null || !Number.isFinite(Number(time)) ? null : Number(time),
  };
}

export function addressOf({ parts, at, overlaid, time }: Comparison): string {
  const query = new URLSearchParams();
  for (const part of parts) query.append("part", written(part));
  if (at !== "middle") query.set("at", at);
  if (overlaid) query.set("ground", "one");
  if (time !== null) query.set("time", time.toFixed(2));
  return `${routeTo("compare")}?${query.toString()}`;
}

/** The address that compares some parts. */
export const compareAddress = (parts: readonly Part[]): string =>
  addressOf({ parts, at: "middle", overlaid: false, time: null });

/** Remember the parts of the last comparison, so that a further one can be added. */
export function keepParts(parts: readonly Part[]): void {
  try {
    sessionStorage.setItem(KEY, JSON.stringify(parts.map(written)));
  } catch {
    // the browser stores nothing; the address still holds the parts
  }
}

/** The parts of the last comparison of this tab. */
export function keptParts(): Part[] {
  try {
    return (JSON.parse(sessionStorage.getItem(KEY) ?? "[]") as string[]).flatMap(read);
  } catch {
    return [];
  }
}

/** The address that compares some parts with those of the last comparison, if there is room. */
export function addressWith(parts: readonly Part[]): string {
  const known = keptParts();
  const fresh = parts.filter((part) => !known.some((one) => written(one) === written(part)));
  const all = known.length + fresh.length <= MOST ? [...known, ...fresh] : fresh;
  return compareAddress(all.slice(0, MOST));
}
