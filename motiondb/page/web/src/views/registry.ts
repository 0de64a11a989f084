/**
 * The views of the page, in the order of the navigation. A further view is one line here. The code
 * of a view is loaded when it is opened: the first one needs no three.js.
 */

import type { View } from "./view.ts";

export const VIEWS: readonly View[] = [
  { name: "wall", title: "", place: "asking", flat: true, load: () => import("./wall/wall.ts") },
  { name: "catalogue", title: "Catalogue", load: () => import("./catalogue/catalogue.ts") },
  { name: "search", title: "Search", place: "asking", load: () => import("./search/search.ts") },
  { name: "generate", title: "Generate", load: () => import("./generate/generate.ts") },
  { name: "board", title: "Board", load: () => import("./board/board.ts") },
  { name: "symbols", title: "Symbols", place: "explore", load: () => import("./symbols/symbols.ts") },
  { name: "grammar", title: "Grammars", place: "explore", load: () => import("./grammar/grammar.ts") },
  { name: "compare", title: "Compare", place: "asking", load: () => import("./compare/compare.ts") },
];
