/** The filter of the catalogue: what was typed, and the values chosen among the facets. */

export interface Pick {
  column: string;
  /** A clause of the filter language, as the server gives it. */
  where: string;
}

const SEPARATOR = "|";

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
  const text = typed.trim();
  if (!text) return clauses.join(" and ");
  return clauses.length > 0 ? [`(${text})`, ...clauses].join(" and ") : text;
}
