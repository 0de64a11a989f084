/** What is asked of the server for the address of a search. */

import type { Parameters } from "../../api/client.ts";
import { filterOf } from "../catalogue/filter.ts";

/** The request for a question in words. */
export function wordsQuery(address: URLSearchParams): [path: "/api/search", parameters: Parameters] {
  const value = (name: string): string => address.get(name) ?? "";
  return [
    "/api/search",
    {
      q: value("q"),
      where: filterOf(value("where")),
      limit: value("limit") || "10",
      exact: value("exact") !== "",
      by_symbols: value("symbols") !== "",
    },
  ];
}
