/** The state of the view as an address: `#/grammar?name=play&sequence=q1f2&at=3&wider=1`. */

import { routeTo } from "../../shell/router.ts";
import type { Selection, Wish } from "./selection.ts";

export interface Route {
  /** The grammar; empty: the list of grammars. */
  name: string;
  sequence: string;
  open: string;
  selection: Selection | null;
  tree: boolean;
  wish: Wish;
}

const numberOr = <T>(text: string | null, other: T): number | T => {
  const value = Number(text);
  return text && Number.isInteger(value) && value >= 0 ? value : other;
};

/** The state that an address describes. */
export function routeOf(parameters: URLSearchParams): Route {
  const at = numberOr(parameters.get("at"), null);
  return {
    name: parameters.get("name") ?? "",
    sequence: parameters.get("sequence") ?? "",
    open: parameters.get("open") ?? "",
    selection:
      at === null
        ? null
        : { at, wider: numberOr(parameters.get("wider"), 0), draw: numberOr(parameters.get("draw"), 0) },
    tree: parameters.has("tree"),
    wish: {
      seed: numberOr(parameters.get("seed"), 0),
      length: numberOr(parameters.get("length"), null) || null,
      like: parameters.get("like"),
    },
  };
}

/** The address of a route. */
export function addressOf({ name, sequence, selection, tree, wish }: Omit<Route, "open">): string {
  return routeTo("grammar", {
    name,
    seed: wish.seed || null,
    length: wish.length,
    like: wish.like,
    sequence,
    at: selection?.at,
    wider: selection?.wider || null,
    draw: selection?.draw || null,
    tree: tree ? 1 : null,
  });
}
