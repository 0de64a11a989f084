/** The filter of the catalogue: what was typed, and the values chosen among the facets. */

export interface Pick {
  column: string;
  /** A clause of the filter language, as the server gives it. */
  where: string;
}

const SEPARATOR = "|";

/** A value as filters write it; a quote in it is written twice. */
export const quoted = (value: string): string => `"${value.replaceAll('"', '""')}"`;

export function readPicks(parameters: URLSearchParams): Pick[] {
  return parameters.getAll("pick").flatMap((text) => {
    const at = text.indexOf(SEPARATOR);
    return at < 1 ? [] : [{ column: text.slice(0, at), where: text.slice(at + 1) }];
  });
}

export function writePick(pick: Pick): string {
  return `${pick.column}${SEPARATOR}${pick.where}`;
}

/** The picks with one added, or removed if it was there. */
export function togglePick(picks: readonly Pick[], pick: Pick): Pick[] {
  const rest = picks.filter((one) => one.where !== pick.where || one.column !== pick.column);
  return rest.length < picks.length ? rest : [...picks, pick];
}

/** Whether a text is in the language of filters: it compares something. */
const COMPARES = /[=<>~]|\bin\s*\(/;

/**
 * The filter for what was typed: plain words are looked for in captions and names, each of them in
 * one or the other; a text with comparisons stays as it is.
 */
export function filterOf(typed: string): string {
  const text = typed.trim();
  if (!text || COMPARES.test(text)) return text;
  const words = text.match(/"[^"]*"|[^\s",;]+/g) ?? [];
  const alternatives: string[][] = [[]];
  let negated = "";
  for (const word of words) {
    const bare = word.replaceAll('"', "").trim();
    const joint = word.toLowerCase();
    if (joint === "or") alternatives.push([]);
    else if (joint === "not") negated = "not ";
    else if (joint !== "and" && bare) {
      alternatives.at(-1)!.push(`${negated}(caption~"${bare}" or name~"${bare}")`);
      negated = "";
    }
  }
  const said = alternatives.filter((all) => all.length > 0).map((all) => all.join(" and "));
  return said.length > 1 ? said.map((one) => `(${one})`).join(" or ") : (said[0] ?? "");
}

/**
 * One filter of all: values of one column are alternatives, columns are conditions.
 * `without` leaves out the picks of one column, to count the captures of its other values.
 */
export function combine(typed: string, picks: readonly Pick[], without = ""): string {
  const columns = [...new Set(picks.map((pick) => pick.column))].filter((column) => column !== without);
  const clauses = columns.map((column) => {
    const own = picks.filter((pick) => pick.column === column).map((pick) => pick.where);
    return own.length > 1 ? `(${own.join(" or ")})` : own[0]!;
  });
  const text = filterOf(typed);
  if (!text) return clauses.join(" and ");
  return clauses.length > 0 ? [`(${text})`, ...clauses].join(" and ") : text;
}
