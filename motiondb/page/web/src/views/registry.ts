/** The views of the page, in the order of the navigation. A further view is one line here. */

import { boardView } from "./board/board.ts";
import { catalogue } from "./catalogue/catalogue.ts";
import { compare } from "./compare/compare.ts";
import { generate } from "./generate/generate.ts";
import { grammar } from "./grammar/grammar.ts";
import { search } from "./search/search.ts";
import { symbols } from "./symbols/symbols.ts";
import type { View } from "./view.ts";

export const VIEWS: readonly View[] = [catalogue, search, generate, boardView, symbols, grammar, compare];
