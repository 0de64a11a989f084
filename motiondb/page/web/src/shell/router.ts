/** Views live in the hash of the address: `#/search?q=walk`. */

export interface Route {
  view: string;
  parameters: URLSearchParams;
}

/** The route of a hash; an empty hash is the first view. */
export function parseRoute(hash: string, first: string): Route {
  const [path, query] = hash.replace(/^#\/?/, "").split("?", 2);
  return { view: path || first, parameters: new URLSearchParams(query ?? "") };
}

/** The hash of a view with parameters; empty ones are left out. */
export function routeTo(
  view: string,
  parameters: Record<string, string | number | null | undefined> = {},
): string {
  const query = new URLSearchParams();
  for (const [name, value] of Object.entries(parameters)) {
    if (value !== null && value !== undefined && value !== "") query.set(name, String(value));
  }
  const text = query.toString();
  return text ? `#/${view}?${text}` : `#/${view}`;
}

/** What some parameters of an address are, as text that can be compared. */
export const partOf = (parameters: URLSearchParams, names: readonly string[]): string =>
  new URLSearchParams(
    names.flatMap((name) => parameters.getAll(name).map((value) => [name, value])),
  ).toString();

/** Go to a route. */
export function go(hash: string): void {
  location.hash = hash;
}

/** Go to a route without a step that the back button would undo. */
export function replace(hash: string): void {
  history.replaceState(history.state, "", hash); // the same step of the history
  dispatchEvent(new HashChangeEvent("hashchange"));
}

/** Whether a route is one of the view that the address names. Another may be on its way: it is
 *  loaded while the view before it still answers. */
const stays = (hash: string): boolean => parseRoute(location.hash, "").view === parseRoute(hash, "").view;

/** Go to a route of the same view, unless somebody has left it meanwhile. */
export function goOn(hash: string): void {
  if (stays(hash)) go(hash);
}

/** Replace a route by one of the same view, unless somebody has left it meanwhile. */
export function amend(hash: string): void {
  if (stays(hash)) replace(hash);
}

/** Write what a view already shows into the address, unless somebody has left it meanwhile. */
export function rewrite(hash: string): void {
  if (stays(hash)) history.replaceState(history.state, "", hash);
}
